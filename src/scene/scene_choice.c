/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_choice.h"
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "scene/scene_build.h"
#include "stream/stream.h"

#include <ctype.h>
#include <errno.h>
#include <fnmatch.h>
#include <locale.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { PATH_MOST = 1024 }; /* of a path's text */

void scene_choice_clear(struct scene_choice *choice)
{
    for (size_t i = 0; i < choice->count; i++)
        free(choice->list[i].text);
    free(choice->list);
    free(choice->before);
    *choice = (struct scene_choice){0};
}

/* -- options ---------------------------------------------------------------------------------- */

static const char *const option_names[] = {"exclude", "only"}; /* by `only`; keys too */

static struct error *add_pattern(struct scene_choice *choice, const char *text, bool only)
{
    char *copy = NULL;
    struct error *err =
        array_reserve(&choice->list, &choice->capacity, choice->count + 1, sizeof *choice->list);
    if (!err && !(copy = strdup(text)))
        err = error_memory();
    if (!err)
        choice->list[choice->count++] = (struct scene_pattern){.text = copy, .only = only};
    return err;
}

static struct error *parse_pattern(struct scene_choice *choice, const char *text, bool only)
{
    if (!*text)
        return error_usage("expected a name or a pattern, got ''");
    for (const char *c = text; *c; c++)
        if (iscntrl((unsigned char)*c))
            return error_usage("expected a pattern without control characters (? matches them)");
    if (choice->inherited) {
        for (size_t i = 0; i < choice->count; i++)
            free(choice->list[i].text);
        choice->count = 0;
        choice->inherited = false;
    }
    return add_pattern(choice, text, only);
}

static struct error *parse_exclude(void *value, const char *text)
{
    return parse_pattern(value, text, false);
}

static struct error *parse_only(void *value, const char *text)
{
    return parse_pattern(value, text, true);
}

void scene_choice_rows(struct scene_choice *choice, struct option_row *rows)
{
    rows[0] =
        (struct option_row){.name = "exclude",
                            .argument = "PATTERN",
                            .kind = OPTION_CALL,
                            .value = choice,
                            .parse = parse_exclude,
                            .shown = "",
                            .help = "leave out the nodes, meshes, objects, groups, materials and\n"
                                    "lights of the scene's file whose name matches; may repeat"};
    rows[1] = (struct option_row){.name = "only",
                                  .argument = "PATTERN",
                                  .kind = OPTION_CALL,
                                  .value = choice,
                                  .parse = parse_only,
                                  .shown = "",
                                  .help = "leave out all but these; may repeat"};
}

/* -- header ----------------------------------------------------------------------------------- */

/* The kind of pattern that a key like "only-2" holds: 0 or 1; -1: none. */
static int kind_of_key(const char *key)
{
    for (int only = 0; only < 2; only++) {
        const size_t length = strlen(option_names[only]);
        const char *number = key + length + 1;
        if (!strncmp(key, option_names[only], length) && key[length] == '-' && *number >= '1' &&
            *number <= '9' && number[strspn(number, "0123456789")] == 0)
            return only;
    }
    return -1;
}

struct error *scene_choice_to_header(const struct scene_choice *choice,
                                     struct stream_header *header)
{
    struct error *err = NULL;
    for (size_t k = header->key_count; k-- > 0;)
        if (kind_of_key(header->keys[k].name) >= 0)
            header_remove_key(header, header->keys[k].name);
    for (size_t i = 0; i < choice->count && !err; i++) {
        const char *text = choice->list[i].text;
        char key[32], *value = NULL;
        snprintf(key, sizeof key, "%s-%zu", option_names[choice->list[i].only], i + 1);
        /* a header's value has no blank before it */
        if (asprintf(&value, "%s%s", *text == ' ' ? "\\" : "", text) < 0)
            return error_memory();
        err = header_set_key(header, key, value);
        free(value);
    }
    return err;
}

/* As a shell would take them. */
static struct error *as_options(const struct scene_choice *choice, char **text)
{
    size_t size = 0;
    FILE *out = open_memstream(text, &size);
    if (!out)
        return error_memory();
    for (size_t i = 0; i < choice->count; i++)
        fprintf(out, "%s--%s '%s'", i ? " " : "", option_names[choice->list[i].only],
                choice->list[i].text);
    return fclose(out) ? error_memory() : NULL;
}

struct error *scene_choice_from_header(struct scene_choice *choice,
                                       const struct stream_header *header)
{
    struct scene_choice read = {.inherited = true};
    struct error *err = NULL;
    for (size_t k = 0; k < header->key_count && !err; k++) {
        const int only = kind_of_key(header->keys[k].name);
        const char *text = header->keys[k].value;
        if (only >= 0) /* the backslash is there for the blank */
            err = add_pattern(&read, text + (!strncmp(text, "\\ ", 2) ? 1 : 0), only);
    }
    if (!err && read.count)
        err = as_options(&read, &read.before);
    if (!err && read.count && choice->count && !choice->inherited) {
        free(choice->before); /* the command line's stay */
        choice->before = read.before;
        read.before = NULL;
    } else if (!err && read.count) {
        scene_choice_clear(choice);
        *choice = read;
        return NULL;
    }
    scene_choice_clear(&read);
    return err;
}

/* -- names ------------------------------------------------------------------------------------ */

const char *const scene_part_kinds[] = {[SCENE_NODE] = "node",
                                        [SCENE_MESH] = "mesh",
                                        [SCENE_OBJECT] = "object",
                                        [SCENE_GROUP] = "group",
                                        [SCENE_LIGHT] = "light"};

static const struct scene_part *part_at(const struct scene *scene, uint32_t part)
{
    return &scene->parts[part - 1];
}

/* Puts a name, and a slash where something follows, before text[*first]; cut where it is full. */
static void put_before(char *text, size_t *first, const char *name, bool slash)
{
    if (slash && *first)
        text[--*first] = '/';
    for (size_t i = strlen(name); i-- > 0 && *first;)
        text[--*first] = name[i];
}

/* A name is one line. */
static void show_controls(char *text)
{
    for (; *text; text++)
        if (iscntrl((unsigned char)*text))
            *text = '?';
}

void scene_part_path(const struct scene *scene, uint32_t part, char *text, size_t size)
{
    char path[PATH_MOST];
    size_t first = sizeof path - 1;
    path[first] = 0;
    for (uint32_t p = part; p && first; p = part_at(scene, p)->above)
        put_before(path, &first, part_at(scene, p)->name, p != part);
    const size_t length = sizeof path - 1 - first, shown = length < size ? length : size - 1;
    snprintf(text, size, "%s", path + first + (length - shown));
    show_controls(text);
    if (shown > 3 && (shown < length || !first))
        memcpy(text, "...", 3);
}

void scene_material_name(const struct scene *scene, int32_t material, char *text, size_t size)
{
    const char *name = scene->materials[material].name;
    if (*name)
        snprintf(text, size, "%s", name);
    else
        snprintf(text, size, "material %d", (int)material);
    show_controls(text);
}

uint32_t scene_part_of(const struct scene_mesh *mesh, size_t triangle)
{
    size_t low = 0, high = mesh->run_count; /* the last run that begins at it or before */
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (mesh->runs[middle].first <= triangle)
            low = middle + 1;
        else
            high = middle;
    }
    return low ? mesh->runs[low - 1].part : 0;
}

struct error *scene_count_names(const struct scene *scene, size_t **of_part, size_t **of_material)
{
    size_t *placed = NULL; /* how often each mesh is */
    *of_material = NULL;
    struct error *err = array_create(of_part, scene->part_count + 1, sizeof **of_part);
    if (!err)
        err = array_create(of_material, scene->material_count, sizeof **of_material);
    if (!err)
        err = array_create(&placed, scene->mesh_count, sizeof *placed);
    for (size_t i = 0; i < scene->instance_count && !err; i++) {
        placed[scene->instances[i].mesh]++;
        (*of_part)[scene->instances[i].part] +=
            scene->meshes[scene->instances[i].mesh].triangle_count;
    }
    for (size_t m = 0; m < scene->mesh_count && !err; m++) {
        const struct scene_mesh *mesh = &scene->meshes[m];
        (*of_part)[mesh->part] += placed[m] * mesh->triangle_count;
        for (size_t r = 0; r < mesh->run_count; r++) {
            const size_t end = r + 1 < mesh->run_count ? mesh->runs[r + 1].first
                                                       : mesh->triangle_count;
            (*of_part)[mesh->runs[r].part] += placed[m] * (end - mesh->runs[r].first);
        }
        for (size_t t = 0; t < mesh->triangle_count; t++)
            (*of_material)[mesh->material[t]] += placed[m];
    }
    for (size_t p = scene->part_count; p > 0 && !err; p--)
        (*of_part)[scene->parts[p - 1].above] += (*of_part)[p];
    free(placed);
    return err;
}

struct error *scene_list_names(const struct scene *scene, FILE *out)
{
    size_t *of_part = NULL, *of_material = NULL;
    struct error *err = scene_count_names(scene, &of_part, &of_material);
    char name[PATH_MOST];
    for (size_t p = 1; p <= scene->part_count && !err; p++) {
        scene_part_path(scene, (uint32_t)p, name, sizeof name);
        fprintf(out, "%s\t%zu\t%s\n", scene_part_kinds[part_at(scene, (uint32_t)p)->kind],
                of_part[p], name);
    }
    for (size_t m = 0; m < scene->material_count && !err; m++) {
        scene_material_name(scene, (int32_t)m, name, sizeof name);
        fprintf(out, "material\t%zu\t%s\n", of_material[m], name);
    }
    free(of_part);
    free(of_material);
    if (!err && (fflush(out) || ferror(out)))
        err = error_system(errno, "standard output");
    return err;
}

/* -- matching --------------------------------------------------------------------------------- */

/* How a pattern is held against names. What --list prints of a part or a material names just that;
 * so the first of these is taken under which something matches. */
enum manner { AS_LISTED, AS_NAME, AS_PATTERN };

/* A name as it is shown: control characters are '?'. */
static bool is_name(const char *text, const char *name)
{
    for (; *text && *name; text++, name++)
        if (*text != (iscntrl((unsigned char)*name) ? '?' : *name))
            return false;
    return !*text && !*name;
}

static bool matches(const char *pattern, const char *name, enum manner manner)
{
    return manner == AS_PATTERN ? !fnmatch(pattern, name, 0) : is_name(pattern, name);
}

/* Any of the words of "wall north", which are groups each. */
static bool matches_word(const char *pattern, const char *names, enum manner manner)
{
    char word[PATH_MOST];
    for (const char *at = names + strspn(names, " \t"); *at; at += strspn(at, " \t")) {
        const size_t length = strcspn(at, " \t");
        snprintf(word, sizeof word, "%.*s", (int)length, at);
        if (matches(pattern, word, manner))
            return true;
        at += length;
    }
    return false;
}

static bool matches_part(const struct scene *scene, const char *pattern, uint32_t part,
                         enum manner manner)
{
    const struct scene_part *p = part_at(scene, part);
    char path[PATH_MOST];
    if (manner == AS_LISTED) { /* a name alone may be that of many */
        scene_part_path(scene, part, path, sizeof path);
        return strchr(pattern, '/') && !strcmp(pattern, path);
    }
    if (matches(pattern, p->name, manner) ||
        (p->kind == SCENE_GROUP && matches_word(pattern, p->name, manner)))
        return true;
    if (!strchr(pattern, '/'))
        return false;
    size_t first = sizeof path - 1;
    path[first] = 0;
    put_before(path, &first, p->name, false);
    for (uint32_t up = p->above; up && first; up = part_at(scene, up)->above) {
        put_before(path, &first, part_at(scene, up)->name, true);
        if (first && matches(pattern, path + first, manner))
            return true;
    }
    return false;
}

/* -- the nearest names ------------------------------------------------------------------------ */

enum { NEAREST = 3, NAME_MOST = 64 };

struct nearest {
    size_t distance[NEAREST];
    char text[NEAREST][2 * NAME_MOST];
    size_t count;
};

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* How many letters differ (Levenshtein 1966), whatever their case; of the first ones. */
static size_t edits(const char *a, const char *b)
{
    size_t row[NAME_MOST + 1];
    const size_t m = strnlen(a, NAME_MOST), n = strnlen(b, NAME_MOST);
    for (size_t j = 0; j <= n; j++)
        row[j] = j;
    for (size_t i = 0; i < m; i++) {
        size_t corner = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < n; j++) {
            const bool differ = tolower((unsigned char)a[i]) != tolower((unsigned char)b[j]);
            const size_t here = least(corner + differ, least(row[j], row[j + 1]) + 1);
            corner = row[j + 1];
            row[j + 1] = here;
        }
    }
    return row[n];
}

static void add_near(struct nearest *near, const char *pattern, const char *kind, const char *name)
{
    char bare[NAME_MOST], text[2 * NAME_MOST]; /* the pattern's last name, without its * */
    const char *slash = strrchr(pattern, '/');
    size_t length = 0;
    for (const char *c = slash && slash[1] ? slash + 1 : pattern; *c && length + 1 < NAME_MOST; c++)
        if (!strchr("*?[]\\", *c))
            bare[length++] = *c;
    bare[length] = 0;
    const bool within = length > 1 && (strcasestr(name, bare) || strcasestr(bare, name));
    const size_t distance = within ? strcasecmp(name, bare) != 0 : 2 + edits(bare, name);
    snprintf(text, sizeof text, "%s '%.*s'", kind, NAME_MOST - 1, name);
    size_t at = near->count;
    for (size_t i = 0; i < near->count; i++)
        if (!strcmp(near->text[i], text))
            return;
    while (at > 0 && near->distance[at - 1] > distance)
        at--;
    if (at == NEAREST)
        return;
    near->count = least(near->count + 1, NEAREST);
    for (size_t i = near->count - 1; i > at; i--) {
        near->distance[i] = near->distance[i - 1];
        memcpy(near->text[i], near->text[i - 1], sizeof text);
    }
    near->distance[at] = distance;
    memcpy(near->text[at], text, sizeof text);
}

static struct error *unmatched(const struct scene *scene, const struct scene_pattern *p)
{
    struct nearest near = {0};
    char name[PATH_MOST];
    const char *option = option_names[p->only];
    bool named = scene->part_count > 0;
    for (size_t m = 0; m < scene->material_count; m++)
        named = named || *scene->materials[m].name;
    if (!named)
        return error_new("--%s '%s': this file names nothing: PLY, OFF and STL have no names, OBJ "
                         "by o, g and usemtl, glTF in its nodes, meshes and materials",
                         option, p->text);
    for (uint32_t i = 1; i <= scene->part_count; i++)
        add_near(&near, p->text, scene_part_kinds[part_at(scene, i)->kind],
                 part_at(scene, i)->name);
    for (size_t m = 0; m < scene->material_count; m++) {
        scene_material_name(scene, (int32_t)m, name, sizeof name);
        add_near(&near, p->text, "material", name);
    }
    return error_new("--%s '%s': nothing has such a name; the nearest: %s%s%s%s%s (probe-place "
                     "--list names all)",
                     option, p->text, near.text[0], near.count > 1 ? ", " : "", near.text[1],
                     near.count > 2 ? ", " : "", near.text[2]);
}

/* -- choosing --------------------------------------------------------------------------------- */

enum { OUT = 1, ONLY = 2 };

struct choice_flags {
    unsigned char *part, *material; /* OUT, ONLY by number */
    bool only;                      /* there are --only */
};

/* How much a pattern matches, but not in this manner. */
static size_t count_others(const struct scene *scene, const char *pattern, enum manner manner)
{
    char name[PATH_MOST];
    size_t found = 0;
    for (uint32_t k = 1; k <= scene->part_count; k++)
        found += matches_part(scene, pattern, k, AS_PATTERN) &&
                 !matches_part(scene, pattern, k, manner);
    for (size_t m = 0; m < scene->material_count; m++) {
        scene_material_name(scene, (int32_t)m, name, sizeof name);
        found += matches(pattern, name, AS_PATTERN) && !matches(pattern, name, manner);
    }
    return found;
}

/* Sets the flag of what a pattern matches in this manner (NULL: not looked at); how much does. */
static size_t mark_matches(const struct scene *scene, const char *pattern, enum manner manner,
                           unsigned char flag, unsigned char *part, unsigned char *material)
{
    char name[PATH_MOST];
    size_t found = 0;
    for (uint32_t k = 1; part && k <= scene->part_count; k++)
        if (matches_part(scene, pattern, k, manner)) {
            part[k] |= flag;
            found++;
        }
    for (size_t m = 0; material && m < scene->material_count; m++) {
        scene_material_name(scene, (int32_t)m, name, sizeof name);
        if (!matches(pattern, name, manner))
            continue;
        material[m] |= flag;
        found++;
    }
    return found;
}

/* Letters are UTF-8's, so that ? is one, not a byte; what was there before comes back. */
struct letters {
    locale_t utf8, before;
};

static struct letters letters_begin(void)
{
    struct letters letters = {.utf8 = newlocale(LC_CTYPE_MASK, "C.UTF-8", (locale_t)0)};
    letters.before = letters.utf8 ? uselocale(letters.utf8) : (locale_t)0;
    return letters;
}

static void letters_end(const struct letters *letters)
{
    if (!letters->utf8)
        return;
    uselocale(letters->before);
    freelocale(letters->utf8);
}

size_t scene_match_names(const struct scene *scene, const char *pattern, unsigned char *part,
                         unsigned char *material)
{
    const struct letters letters = letters_begin();
    size_t found = 0;
    for (int manner = AS_LISTED; manner <= AS_PATTERN && !found; manner++)
        found = mark_matches(scene, pattern, (enum manner)manner, 1, part, material);
    letters_end(&letters);
    return found;
}

static struct error *find_matches(const struct scene *scene, const struct scene_choice *choice,
                                  struct choice_flags *flags, struct warnings *warnings)
{
    for (size_t i = 0; i < choice->count; i++) {
        const struct scene_pattern *p = &choice->list[i];
        const unsigned char flag = p->only ? ONLY : OUT;
        size_t found = 0;
        flags->only = flags->only || p->only;
        for (int manner = AS_LISTED; manner <= AS_PATTERN && !found; manner++) {
            found = mark_matches(scene, p->text, (enum manner)manner, flag, flags->part,
                                 flags->material);
            if (!found || manner == AS_PATTERN || !strpbrk(p->text, "*?["))
                continue;
            const size_t others = count_others(scene, p->text, (enum manner)manner);
            if (others > 0)
                warnings_add(warnings, "name and pattern",
                             "--%s '%s' is a name as it stands, and names that alone: the %zu "
                             "names that it matches as a pattern are let be",
                             option_names[p->only], p->text, others);
        }
        if (!found)
            return unmatched(scene, p);
    }
    for (size_t k = 1; k <= scene->part_count; k++)
        flags->part[k] |= flags->part[scene->parts[k - 1].above];
    return NULL;
}

static unsigned flags_of_instance(const struct scene *scene, const struct choice_flags *flags,
                                  const struct scene_instance *instance)
{
    return flags->part[instance->part] | flags->part[scene->meshes[instance->mesh].part];
}

/* Takes out of a mesh the triangles that are to go; `whole`: it was chosen as such. */
static struct error *choose_triangles(struct scene_mesh *mesh, const struct choice_flags *flags,
                                      bool whole)
{
    bool *drop = NULL, some = false;
    struct error *err = array_create(&drop, mesh->triangle_count, sizeof *drop);
    for (size_t t = 0, run = 0; t < mesh->triangle_count && !err; t++) {
        while (run < mesh->run_count && mesh->runs[run].first <= t)
            run++;
        const unsigned f = flags->material[mesh->material[t]] |
                           (run ? flags->part[mesh->runs[run - 1].part] : 0u);
        drop[t] = (f & OUT) || !(whole || (f & ONLY));
        some = some || drop[t];
    }
    if (some)
        scene_mesh_drop(mesh, drop);
    free(drop);
    return err;
}

static struct error *copy_of(const void *from, size_t count, size_t size, void *to)
{
    struct error *err = array_create(to, count, size);
    if (!err && count)
        memcpy(*(void **)to, from, count * size);
    return err;
}

struct error *scene_copy_mesh(struct scene *scene, size_t number, size_t *copy)
{
    const struct scene_mesh *from = &scene->meshes[number];
    struct scene_mesh to = *from;
    to.position = NULL;
    to.index = NULL;
    to.uv = to.emission_uv = NULL;
    to.colour = NULL;
    to.material = NULL;
    to.runs = NULL;
    struct error *err =
        copy_of(from->position, 3 * from->vertex_count, sizeof *to.position, &to.position);
    if (!err)
        err = copy_of(from->index, 3 * from->triangle_count, sizeof *to.index, &to.index);
    if (!err)
        err = copy_of(from->material, from->triangle_count, sizeof *to.material, &to.material);
    if (!err && from->uv)
        err = copy_of(from->uv, 6 * from->triangle_count, sizeof *to.uv, &to.uv);
    if (!err && from->emission_uv)
        err = copy_of(from->emission_uv, 6 * from->triangle_count, sizeof *to.uv, &to.emission_uv);
    if (!err && from->colour)
        err = copy_of(from->colour, 4 * from->vertex_count, sizeof *to.colour, &to.colour);
    if (!err && from->runs)
        err = copy_of(from->runs, from->run_count, sizeof *to.runs, &to.runs);
    if (!err)
        return scene_push_mesh(scene, to, copy);
    scene_mesh_clear(&to);
    return err;
}

/* A mesh that is kept whole by one node and in part by another becomes two. */
static struct error *choose_meshes(struct scene *scene, const struct choice_flags *flags)
{
    enum { WHOLE = 1, PART = 2 };
    const size_t meshes = scene->mesh_count;
    unsigned char *use = NULL;
    struct error *err = array_create(&use, meshes, sizeof *use);
    for (size_t i = 0; i < scene->instance_count && !err; i++) {
        const struct scene_instance *instance = &scene->instances[i];
        use[instance->mesh] |=
            !flags->only || (flags_of_instance(scene, flags, instance) & ONLY) ? WHOLE : PART;
    }
    for (size_t m = 0; m < meshes && !err; m++) {
        size_t part = m;
        if (use[m] == (WHOLE | PART))
            err = scene_copy_mesh(scene, m, &part);
        for (size_t i = 0; i < scene->instance_count && part != m && !err; i++)
            if (scene->instances[i].mesh == m &&
                !(flags_of_instance(scene, flags, &scene->instances[i]) & ONLY))
                scene->instances[i].mesh = part;
        if (!err && part != m)
            err = choose_triangles(&scene->meshes[part], flags, false);
        if (!err)
            err = choose_triangles(&scene->meshes[m], flags, use[m] & WHOLE);
    }
    free(use);
    return err;
}

static void drop_instances(struct scene *scene, const struct choice_flags *flags)
{
    size_t kept = 0;
    for (size_t i = 0; i < scene->instance_count; i++)
        if (!(flags_of_instance(scene, flags, &scene->instances[i]) & OUT))
            scene->instances[kept++] = scene->instances[i];
    scene->instance_count = kept;
}

static void drop_lights(struct scene *scene, const struct choice_flags *flags)
{
    size_t kept = 0;
    for (size_t i = 0; i < scene->light_count; i++) {
        const unsigned f = flags->part[scene->lights[i].part];
        if (!(f & OUT) && (!flags->only || (f & ONLY)))
            scene->lights[kept++] = scene->lights[i];
    }
    scene->light_count = kept;
}

/* Checks what importers leave to scene_finish and the choice rests on. */
static struct error *check_indices(const struct scene *scene)
{
    for (size_t i = 0; i < scene->instance_count; i++)
        if (scene->instances[i].mesh >= scene->mesh_count)
            return error_new("instance %zu places mesh %zu of %zu", i, scene->instances[i].mesh,
                             scene->mesh_count);
    for (size_t m = 0; m < scene->mesh_count; m++)
        for (size_t t = 0; t < scene->meshes[m].triangle_count; t++) {
            const int32_t material = scene->meshes[m].material[t];
            if (material < 0 || (size_t)material >= scene->material_count)
                return error_new("triangle %zu of mesh %zu has material %d of %zu", t, m,
                                 (int)material, scene->material_count);
        }
    return NULL;
}

/* Says where the choice takes the place of another. */
static struct error *warn_other(const struct scene_choice *choice, struct warnings *warnings)
{
    char *now = NULL;
    struct error *err = choice->before ? as_options(choice, &now) : NULL;
    if (!err && now && strcmp(now, choice->before))
        warnings_add(warnings, "another choice",
                     "the stream's probes are of the scene with %s; %s takes its place here",
                     choice->before, now);
    free(now);
    return err;
}

struct error *scene_choose(struct scene *scene, const struct scene_choice *choice,
                           struct warnings *warnings)
{
    if (!choice->count)
        return NULL;
    const size_t triangles = scene_triangle_count(scene), lights = scene->light_count;
    const struct letters letters = letters_begin();
    struct choice_flags flags = {0};
    struct error *err = array_create(&flags.part, scene->part_count + 1, 1);
    if (!err)
        err = array_create(&flags.material, scene->material_count, 1);
    if (!err)
        err = check_indices(scene);
    if (!err)
        err = find_matches(scene, choice, &flags, warnings);
    letters_end(&letters);
    if (!err) {
        drop_instances(scene, &flags);
        drop_lights(scene, &flags);
        err = choose_meshes(scene, &flags);
    }
    const size_t left = err ? 0 : scene_triangle_count(scene);
    if (!err && !left && triangles)
        err = error_new("--exclude and --only leave none of its %zu triangles", triangles);
    char dark[64] = "";
    if (scene->light_count < lights)
        snprintf(dark, sizeof dark, " and %zu of %zu lights", lights - scene->light_count, lights);
    if (!err)
        warnings_add(warnings, "left out",
                     "%s: --exclude and --only leave out %zu of %zu triangles%s",
                     scene->path ? scene->path : "the scene", triangles - left, triangles, dark);
    if (!err)
        err = warn_other(choice, warnings);
    free(flags.part);
    free(flags.material);
    return err;
}
