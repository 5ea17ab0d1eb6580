/* SPDX-License-Identifier: Apache-2.0 */
/* Placement: grids fill their box evenly and keep to their count; what is inside solids is
 * recognised and rooms are not; and every method of the table is told of and keeps to its operands
 * and options. */
#include "base/error.h"
#include "base/options.h"
#include "math/random.h"
#include "math/vec.h"
#include "place/place_grid.h"
#include "place/place_inside.h"
#include "place/place_method.h"
#include "scene/scene.h"
#include "scene/scene_build.h"
#include "scene/scene_settings.h"
#include "support/tap.h"
#include "trace/trace.h"

#include <string.h>
#include <unistd.h>

static void append_grid(struct place *place, const struct place_grid *grid)
{
    must(place_grids(place, grid, 1, NULL, 1e6));
}

/* Even nodes from face to face, but for the clearance, as many as the count allows. */
static void check_grid(struct place_grid *grid, double count)
{
    const double *low = grid->box.low, *high = grid->box.high;
    const double spacing = place_grid_spacing(grid, 1, count);
    double nodes[3], first[3], last[3];
    struct place place = {0};
    place_grid_nodes(grid, nodes);
    append_grid(&place, grid);
    memcpy(first, place.position, sizeof first);
    memcpy(last, place.position + 3 * (place.count - 1), sizeof last);
    bool well = (double)place.count == nodes[0] * nodes[1] * nodes[2] &&
                (double)place.count <= count;
    for (int k = 0; k < 3; k++) {
        const double length = high[k] - low[k], off = first[k] - low[k],
                     step = nodes[k] > 1 ? (last[k] - first[k]) / (nodes[k] - 1) : 0,
                     clear = grid->share ? grid->clearance * step : grid->clearance,
                     rounding = 1e-9 * (1 + fabs(low[k]) + length);
        well = well && fabs(high[k] - last[k] - off) < rounding && step <= spacing * (1 + 1e-9);
        well = well && (nodes[k] > 1 ? fabs(off - clear) < rounding
                                     : length - 2 * off < rounding &&
                                           length <= 1.5 * spacing + 2 * (grid->share ? 0 : clear));
    }
    for (int k = 0; k < 3; k++)
        grid->spacing[k] *= 1 - 1e-6;
    place_grid_nodes(grid, nodes);
    ok(well && nodes[0] * nodes[1] * nodes[2] > count,
       "at most %.0f probes: %zu, %g apart at most, even, at the clearance from the faces", count,
       place.count, spacing);
    place_clear(&place);
}

static void test_grid(void)
{
    const double boxes[][6] = {{0, 0, 0, 10, 4, 7},
                               {-3, 5, 1, -2, 5.5, 9},
                               {0, 0, 0, 1, 0, 1},
                               {1e6, 0, 0, 1e6 + 1, 1, 1}};
    for (int i = 0; i < 4; i++)
        for (double count = 1; count < 1e5; count = count * 9 + 1) {
            struct place_grid grid = {.up = 1, .clearance = i == 1 ? .02 : .1, .share = i != 1};
            memcpy(grid.box.low, boxes[i], sizeof grid.box.low);
            memcpy(grid.box.high, boxes[i] + 3, sizeof grid.box.high);
            check_grid(&grid, count);
        }
    const struct place_grid grid = {.box = {.high = {1, 1, 1}}, .spacing = {1e-4, 1e-4, 1e-4}};
    struct place place = {0};
    struct error *err = place_grids(&place, &grid, 1, NULL, 1e6);
    ok(err && strstr(error_message(err), "1000300030001 probes") && !place.count, "refused: %s",
       err ? error_message(err) : "");
    error_destroy(err);
    place_clear(&place);
}

/* The least distance of two positions, and how many there are. */
static double least_distance(const struct place *place)
{
    double least = INFINITY;
    for (size_t i = 0; i < place->count; i++)
        for (size_t j = 0; j < i; j++)
            least = fmin(least, vec3_length(vec3_sub(vec3_load(place->position + 3 * i),
                                                     vec3_load(place->position + 3 * j))));
    return least;
}

static void test_boxes(void)
{
    struct place_grid grid[3] = {{.box = {{0, 0, 0}, {4, 2, 3}, 30}},
                                 {.box = {{3, .3, 1}, {7, 2.4, 5}, 0}},
                                 {.box = {{0, 0, 0}, {4, 2, 3}, 30}}};
    for (int i = 0; i < 3; i++) {
        grid[i].up = 1;
        grid[i].clearance = .1;
        grid[i].share = true;
    }
    struct place one = {0}, all = {0};
    const double spacing = place_grid_spacing(grid, 3, 500);
    append_grid(&one, grid);
    must(place_grids(&all, grid, 3, NULL, 1e6));
    size_t in_first = 0;
    for (size_t i = one.count; i < all.count; i++) {
        const struct place_space first = {
            .low = {-9, -9, -9}, .high = {9, 9, 9}, .box = &grid->box, .count = 1, .up = 1};
        in_first += place_space_holds(&first, all.position + 3 * i);
    }
    ok(!memcmp(one.position, all.position, 3 * one.count * sizeof *one.position) &&
           all.count > one.count && all.count <= 500 && !in_first,
       "nodes of the first box win: %zu, and %zu of the others, none of them in it", one.count,
       all.count - one.count);
    ok(least_distance(&all) > .45 * spacing, "no two are nearer than half of what lies between: %g",
       least_distance(&all) / spacing);
    place_clear(&one);
    place_clear(&all);
    /* (1, 0, 0) from the centre, by 90 degrees counter-clockwise from above, is (0, 0, -1) */
    const struct place_box box = {{-2, 0, 3}, {2, 1, 5}, 90};
    double p[3] = {1, 0, 4}, low[3], high[3];
    place_box_turn(&box, 1, false, p, p);
    place_box_hull(&box, 1, low, high);
    ok(p[0] == 0 && p[1] == 0 && p[2] == 3 && low[0] == -1 && high[0] == 1 && low[2] == 2 &&
           high[2] == 6 && low[1] == 0 && high[1] == 1,
       "a quarter turn is exact: %g %g %g", p[0], p[1], p[2]);
}

static void test_path(void)
{
    char name[] = "/tmp/probe-path-XXXXXX";
    const int fd = mkstemp(name);
    FILE *f = fd < 0 ? NULL : fdopen(fd, "w");
    if (!f)
        bail("no temporary file");
    fputs("# a corner\n0 0 0\n\n10 0 0\n10 3.5 0\n10 3.5 0\n", f);
    fclose(f);
    struct place place = {0};
    const struct place_way way = {.step = 1}, smooth = {.step = 0.05, .spline = true};
    must(place_path(&place, name, &way, 1e6, NULL));
    double longest = 0, length = 0;
    for (size_t i = 1; i < place.count; i++) {
        const double d = vec3_length(
            vec3_sub(vec3_load(place.position + 3 * i), vec3_load(place.position + 3 * i - 3)));
        longest = fmax(longest, d);
        length += d;
    }
    ok(longest <= 1 + 1e-12 && fabs(length - 13.5) < 1e-9 && place.count == 1 + 10 + 4 + 1,
       "a path of 13.5 in steps of at most 1: %zu probes", place.count);
    const double *time = column_f64(table_column(&place.columns, "time"));
    ok(time[0] == 0 && time[10] == 10 && fabs(time[place.count - 1] - 13.5) < 1e-9,
       "whose time is how far it came");
    place_clear(&place);
    /* a parabola in time, and a point on it is one of the spline */
    f = fopen(name, "w");
    fputs("0 0 7 0\n1 1 7 1\n3 9 7 3\n4 16 7 4\n4.5 20.25 7 4.5\n", f);
    fclose(f);
    must(place_path(&place, name, &smooth, 1e6, NULL));
    double off = 0;
    longest = length = 0;
    time = column_f64(table_column(&place.columns, "time"));
    for (size_t i = 0; i < place.count; i++) {
        const double *p = place.position + 3 * i;
        off = fmax(off, fabs(p[1] - time[i] * time[i]) + fabs(p[0] - time[i]) + fabs(p[2] - 7));
        if (i)
            longest = fmax(longest, vec3_length(vec3_sub(vec3_load(p), vec3_load(p - 3))));
    }
    ok(off < 1e-12 && longest <= 0.05 && time[place.count - 1] == 4.5 && place.count < 440,
       "a spline through points of a parabola is that, in even steps: %g, %g, %zu", off, longest,
       place.count);
    place_clear(&place);
    f = fopen(name, "w");
    fputs("0 0 0\n1 2\n", f);
    fclose(f);
    struct error *err = place_points(&place, name, 1e6, NULL);
    ok(err && strstr(error_message(err), ":2: expected 3 numbers, as in the lines before, got 2"),
       "refused: %s", err ? error_message(err) : "");
    error_destroy(err);
    place_clear(&place);
    unlink(name);
}

/* A box of 12 triangles, outward or inward. */
static void add_box(struct scene *scene, const double low[3], const double high[3], bool outward,
                    int faces)
{
    double p[24];
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            p[3 * i + k] = i >> k & 1 ? high[k] : low[k];
    const uint32_t quad[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                 {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    uint32_t index[36];
    for (int i = 0; i < faces; i++) {
        const uint32_t *q = quad[i];
        const uint32_t a = outward ? 1 : 2, c = outward ? 2 : 1, d = outward ? 3 : 2,
                       e = outward ? 2 : 3;
        const uint32_t two[6] = {q[0], q[a], q[c], q[0], q[e], q[d]};
        memcpy(index + 6 * i, two, sizeof two);
    }
    const struct scene_material m = {.albedo = {0.5f, 0.5f, 0.5f},
                                     .albedo_map = {.texture = SCENE_NONE},
                                     .emission_map = {.texture = SCENE_NONE},
                                     .alpha_map = {.texture = SCENE_NONE},
                                     .opacity = 1};
    must(scene_add_mesh(scene, 8, p, (size_t)(2 * faces), index, &m));
}

/* Which of random positions in -1 .. 11 are inside, by place_inside. */
static size_t inside_count(struct scene *scene, bool (*expected)(const double *p), size_t *wrong)
{
    enum { N = 2000 };
    static double p[3 * N];
    static enum place_side side[N];
    struct scene_settings settings = scene_settings_default();
    struct tracer *tracer = NULL;
    struct random r = random_start(1, 0, 0);
    for (int i = 0; i < 3 * N; i++)
        p[i] = 12 * random_double(&r) - 1;
    const struct place place = {.position = p, .count = N};
    const struct place_inside_settings s = place_inside_default();
    must(scene_finish(scene, &settings, NULL));
    must(trace_create(&tracer, scene));
    must(place_inside(&place, tracer, &s, side, NULL));
    size_t count = 0;
    *wrong = 0;
    for (int i = 0; i < N; i++) {
        count += side[i] != PLACE_AIR;
        *wrong += (side[i] != PLACE_AIR) != expected(p + 3 * i);
    }
    trace_destroy(tracer);
    scene_destroy(scene);
    return count;
}

static bool in_box(const double *p, double low, double high)
{
    return p[0] > low && p[0] < high && p[1] > low && p[1] < high && p[2] > low && p[2] < high;
}

static bool in_cube(const double *p)
{
    return in_box(p, 2, 5);
}

static bool out_of_room(const double *p)
{
    return !in_box(p, 0, 10);
}

static bool out_of_room_or_in_cube(const double *p)
{
    return out_of_room(p) || in_cube(p);
}

static bool nowhere(const double *p)
{
    (void)p;
    return false;
}

static void test_inside(void)
{
    const double low[3] = {2, 2, 2}, high[3] = {5, 5, 5}, room_low[3] = {0, 0, 0},
                 room_high[3] = {10, 10, 10};
    struct scene *scene = NULL;
    size_t wrong;
    must(scene_create(&scene));
    add_box(scene, low, high, true, 6);
    size_t count = inside_count(scene, in_cube, &wrong);
    ok(count > 20 && wrong == 0, "a solid cube: %zu inside, %zu wrong", count, wrong);
    must(scene_create(&scene));
    add_box(scene, room_low, room_high, false, 6);
    count = inside_count(scene, out_of_room, &wrong);
    ok(count > 700 && wrong == 0,
       "a room whose faces look inward holds air, and outside is none: %zu, %zu wrong", count,
       wrong);
    must(scene_create(&scene));
    add_box(scene, room_low, room_high, true, 6);
    add_box(scene, low, high, true, 6);
    count = inside_count(scene, out_of_room_or_in_cube, &wrong);
    ok(count > 720 && wrong == 0,
       "so does one whose faces look outward, for it holds the cube: %zu, %zu wrong", count, wrong);
    const double sign_low[3] = {5, 5, 5}, wall_low[3] = {5, -1.5, 0}, wall_high[3] = {9, 3, 7},
                 sign_high[3] = {5.5, 5.5, 5.5}, ground_low[3] = {-9, -9, -9},
                 ground_high[3] = {20, -1.5, 20};
    must(scene_create(&scene));
    add_box(scene, sign_low, sign_high, true, 1);
    count = inside_count(scene, nowhere, &wrong);
    ok(count < 10, "behind a sign in the open is air, but for right behind it: %zu", count);
    must(scene_create(&scene));
    add_box(scene, wall_low, wall_high, true, 1);
    add_box(scene, ground_low, ground_high, true, 6);
    count = inside_count(scene, nowhere, &wrong);
    ok(wrong == 0, "where there is a ground, nothing is behind a wall: %zu", count);
}

/* All that comes; owned by the caller. */
static char *read_all(FILE *f)
{
    size_t size = 0, used = 0;
    char *text = NULL;
    for (size_t got = 1; f && got; used += got) {
        char *grown = realloc(text, size = used + 65536 + 1);
        if (!grown)
            bail("no memory");
        text = grown;
        got = fread(text + used, 1, 65536, f);
    }
    if (!text)
        bail("nothing to read");
    text[used] = 0;
    return text;
}

static char *help_text(void)
{
    FILE *pipe = popen("probe-place --help", "r");
    char *text = read_all(pipe);
    if (pclose(pipe))
        bail("probe-place --help fails");
    return text;
}

static char *manual_text(void)
{
    char path[4096];
    const char *source = getenv("SRC");
    snprintf(path, sizeof path, "%s/man/probe-place.1", source ? source : ".");
    FILE *f = fopen(path, "r");
    char *text = read_all(f);
    if (f)
        fclose(f);
    return text;
}

static int rows_of(const struct place_method *method, struct place_options *options,
                   struct option_row *rows)
{
    return method->rows ? (int)(method->rows(options, rows) - rows) : 0;
}

/* Whether the usage line has it as a word, with FILE where it takes one. */
static bool in_usage(const char *help, const struct place_method *method)
{
    char word[128];
    const size_t length = strcspn(help, "\n");
    snprintf(word, sizeof word, "%s%s", method->name, method->file_of ? " FILE" : "");
    for (const char *at = strstr(help, word); at && at < help + length; at = strstr(at + 1, word))
        if (strchr(" |", at[-1]) && strchr(" |", at[strlen(word)]))
            return true;
    return false;
}

/* Whether a help begins with the method, alone or the first of several, or goes for those by
 * light, of which it is one. */
static bool names(const char *help, const struct place_method *method)
{
    const size_t named = strlen(method->name);
    if (!strncmp(help, "by light: ", 10))
        return method->sees_light;
    return !strncmp(help, method->name, named) && strchr(":,", help[named]);
}

static void test_told(void)
{
    char *help = help_text(), *manual = manual_text();
    for (int i = 0; place_methods[i]; i++) {
        const struct place_method *method = place_methods[i];
        struct place_options options = place_options_default();
        struct option_row rows[PLACE_OPTION_ROWS];
        const int count = rows_of(method, &options, rows);
        char text[256];
        snprintf(text, sizeof text, "\n.It Cm %s\n", method->name);
        ok(in_usage(help, method) && strstr(manual, text), "%s is in --help and the manual",
           method->name);
        bool told = true;
        for (int k = 0; k < count; k++) {
            snprintf(text, sizeof text, "Fl -%s", rows[k].name);
            char *in_manual = strstr(manual, text);
            snprintf(text, sizeof text, "--%s%s%s", rows[k].name, rows[k].argument ? " " : "",
                     rows[k].argument ? rows[k].argument : "");
            told = told && in_manual && strstr(help, text) && rows[k].given &&
                   names(rows[k].help, method);
        }
        if (!count)
            continue;
        ok(told, "%s: so are its %d options, which name it and tell when they are given",
           method->name, count);
    }
    free(help);
    free(manual);
}

/* Whether it is a usage error that says so; frees it. */
static bool says(struct error *err, const char *what)
{
    const bool said = err && error_status(err) == EXIT_BAD_USAGE &&
                      strstr(error_message(err), what);
    error_destroy(err);
    return said;
}

static void test_operands(void)
{
    const struct place_method *found = NULL;
    const char *file, *scene, *net[] = {"net"};
    struct error *err = place_operands(1, net, &found, &file, &scene);
    for (int i = 0; place_methods[i]; i++) {
        const struct place_method *method = place_methods[i];
        const char *operands[] = {method->name, "one", "two", "three"};
        const int most = method->file_of ? 3 : 2;
        char list[128];
        ok(err && strstr(error_message(err), method->name), "what is no method is told of %s",
           method->name);
        snprintf(list, sizeof list, "unexpected operand '%s'", operands[most]);
        ok(says(place_operands(most + 1, operands, &found, &file, &scene), list),
           "%s refuses an operand too many", method->name);
        must(place_operands(most, operands, &found, &file, &scene));
        ok(found == method && (method->file_of ? file == operands[1] : !file) &&
               scene == operands[most - 1],
           "%s takes a scene%s", method->name, method->file_of ? " behind its file" : "");
        must(place_operands(most - 1, operands, &found, &file, &scene));
        ok(found == method && !scene, "%s: the last operand is the scene", method->name);
        if (method->file_of)
            ok(says(place_operands(1, operands, &found, &file, &scene), method->file_of),
               "%s refuses to go without its file", method->name);
        struct place_options options = place_options_default();
        if (method->needs_scene)
            ok(says(place_options_check(&options, method, false), "expected a SCENE"),
               "%s refuses to go without a scene", method->name);
    }
    error_destroy(err);
}

static bool shares(const struct place_method *method, const char *option)
{
    for (int i = 0; method->shares && method->shares[i]; i++)
        if (!strcmp(method->shares[i], option))
            return true;
    for (int i = 0; method->reaches && place_reach_shares[i]; i++)
        if (!strcmp(place_reach_shares[i], option))
            return true;
    return false;
}

/* Each option of each method is refused by all other methods that do not share it. */
static void test_options(void)
{
    for (int i = 0; place_methods[i]; i++) {
        struct place_options options = place_options_default();
        struct option_row rows[PLACE_OPTION_ROWS];
        const int count = rows_of(place_methods[i], &options, rows);
        bool refused = true;
        char text[128];
        for (int k = 0; k < count; k++) {
            snprintf(text, sizeof text, "--%s goes with the method", rows[k].name);
            *rows[k].given = true;
            for (int j = 0; place_methods[j]; j++)
                refused = refused &&
                          (i == j || shares(place_methods[j], rows[k].name) ||
                           says(place_options_check(&options, place_methods[j], true), text));
            *rows[k].given = false;
        }
        if (!count)
            continue;
        ok(refused, "%d options of %s are refused by the others", count, place_methods[i]->name);
    }
}

int main(void)
{
    test_grid();
    test_boxes();
    test_path();
    test_inside();
    test_told();
    test_operands();
    test_options();
    return tap_done();
}
