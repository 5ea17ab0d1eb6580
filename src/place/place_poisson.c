/* SPDX-License-Identifier: Apache-2.0 */
/* The method `poisson` of probe-place: points on the surfaces that light gets to (poisson.h). */
#include "base/array.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/options.h"
#include "math/vec.h"
#include "place/patches.h"
#include "place/place.h"
#include "place/place_method.h"
#include "place/poisson.h"
#include "scene/scene.h"
#include "stream/stream.h"
#include "trace/path.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Unless told otherwise: the greatest radius in units of the least, rays of occlusion, and the
 * distance within which it counts, as a share of the diagonal of the scene's box. */
#define RATIO 8
#define RAYS 64
#define DISTANCE_SHARE 0.05

/* Radii below this share of the diagonal are lost in the rounding of rays. */
#define LEAST_SHARE 1e-6

static const char *const steers[] = {[POISSON_AO] = "ao",
                                     [POISSON_GRADIENT] = "ao-gradient",
                                     [POISSON_DEPTH] = "depth",
                                     [POISSON_NONE] = "none",
                                     NULL};

static struct error *parse_radii(void *value, const char *text)
{
    double *radius = value;
    const bool both = strchr(text, ',');
    struct error *err = options_reals("--radii", text, both ? 2 : 1, radius);
    if (!err && !both) {
        radius[1] = radius[0];
        radius[0] /= RATIO;
    }
    if (!err && radius[0] > 0 && radius[0] <= radius[1])
        return NULL;
    error_destroy(err);
    return error_usage("--radii: expected MAX, or MIN,MAX with MIN at most MAX, both above 0, "
                       "got '%s'",
                       text);
}

static struct option_row *rows(struct place_options *o, struct option_row *row)
{
    const struct option_row all[] = {
        {.name = "radii",
         .argument = "MIN,MAX",
         .kind = OPTION_CALL,
         .value = o->poisson.radii,
         .parse = parse_radii,
         .given = &o->poisson.radii_given,
         .help = "poisson: how near points may come to each other, where it is to be\n"
                 "finest and where coarsest; MAX alone: MIN is an eighth"},
        {.name = "steer",
         .argument = "BY",
         .kind = OPTION_CHOICE,
         .choices = steers,
         .value = OPTION_ENUM(o->poisson.steer),
         .given = &o->poisson.steer_given,
         .help = "poisson: radii are small where much is occluded (ao), where that\n"
                 "changes (ao-gradient), where surfaces are near (depth), or are all MAX"},
        {.name = "ao-distance",
         .argument = "D",
         .kind = OPTION_REAL,
         .value = &o->poisson.distance,
         .least_open = true,
         .most = INFINITY,
         .given = &o->poisson.distance_given,
         .shown = "0.05 of the scene's diagonal",
         .help = "poisson: what is nearer occludes"},
        {.name = "lift",
         .argument = "D",
         .kind = OPTION_REAL,
         .value = &o->poisson.lift,
         .least_open = true,
         .most = INFINITY,
         .given = &o->poisson.lift_given,
         .shown = "none",
         .help = "poisson: probes in space, without normals, so far off the surface;\n"
                 "half as far as the next one where there is less room"},
        {.name = "particles",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->poisson.particles,
         .least = 64,
         .most = 1 << 24,
         .given = &o->poisson.particles_given,
         .help = "poisson: of light at a time; they leave darts where they arrive"},
        {.name = "misses",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->poisson.misses,
         .least = 1,
         .most = 1 << 20,
         .given = &o->poisson.misses_given,
         .help = "poisson: end where fewer than one of N darts of particles finds room"},
        {.name = "areas",
         .argument = "N",
         .kind = OPTION_INT,
         .value = &o->poisson.areas,
         .least = 1,
         .most = 1 << 16,
         .given = &o->poisson.areas_given,
         .shown = "none",
         .help = "poisson: columns area and albedo of what each point stands for, from N\n"
                 "places of the surface a point"}};
    memcpy(row, all, sizeof all);
    return row + sizeof all / sizeof *all;
}

static struct error *check(const struct place_options *o, bool scene)
{
    (void)scene;
    if (o->poisson.radii_given == o->count_given)
        return error_usage("poisson: expected either --radii or --count");
    if (o->count_given && o->count > INT32_MAX)
        return error_usage("--count: expected at most %d, got %g", INT32_MAX, o->count);
    if (o->light.keep && o->poisson.lift_given)
        return error_usage("poisson: expected either --keep or --lift: what stays is on surfaces");
    return NULL;
}

static struct error *check_radii(const double radius[2], double diagonal)
{
    if (radius[1] > diagonal)
        return error_new("--radii: expected at most the scene's diagonal, %g, got %g", diagonal,
                         radius[1]);
    if (radius[0] < LEAST_SHARE * diagonal)
        return error_new("--radii: expected at least %g of the scene's diagonal, %g, got %g",
                         LEAST_SHARE, LEAST_SHARE * diagonal, radius[0]);
    return NULL;
}

/* -- points that stay ------------------------------------------------------------------------- */

/* Starts as {0}. */
struct kept {
    struct stream *stream; /* owned, and so are: */
    struct poisson_point *point;
    size_t count;
    const float *normal;   /* as they came, the stream's */
    const int32_t *origin; /* NULL: not known */
};

static void kept_clear(struct kept *kept)
{
    free(kept->point);
    stream_destroy(kept->stream);
}

/* Scenes that a kept point may be off: the grid of points has numbers for that, and more. */
static const double far_off = 1e6;

static struct error *take_kept(struct kept *kept, const struct table *probes,
                               const struct scene *scene)
{
    const struct vec3 middle = vec3_scale(0.5, vec3_add(scene->box_min, scene->box_max));
    const double diagonal = vec3_length(vec3_sub(scene->box_max, scene->box_min));
    struct column *position = NULL, *normal = NULL;
    struct error *err = table_require(probes, "position", COLUMN_F64, 3, &position);
    if (!err && !table_column(probes, "normal"))
        return error_new("expected surface probes, which have a column normal, got probes in "
                         "space");
    if (!err)
        err = table_require(probes, "normal", COLUMN_F32, 3, &normal);
    if (!err)
        err = array_create(&kept->point, probes->rows, sizeof *kept->point);
    if (err)
        return err;
    const struct column *radius = table_column(probes, "radius"), *ao = table_column(probes, "ao"),
                        *origin = table_column(probes, "origin");
    kept->count = probes->rows;
    kept->normal = column_f32(normal);
    kept->origin = origin ? column_i32(origin) : NULL;
    for (size_t i = 0; i < kept->count; i++) {
        const float *n = kept->normal + 3 * i;
        const struct vec3 unit =
            vec3_normalize((struct vec3){(double)n[0], (double)n[1], (double)n[2]});
        if (!(fabs(vec3_length(unit) - 1) < 1e-6))
            return error_new("probe %zu: expected a normal with a length, got %g %g %g", i,
                             (double)n[0], (double)n[1], (double)n[2]);
        const struct vec3 p = vec3_load(column_f64(position) + 3 * i);
        if (!(vec3_length(vec3_sub(p, middle)) <= far_off * diagonal))
            return error_new("probe %zu: expected a place within %g diagonals of the scene, got "
                             "%g %g %g",
                             i, far_off, p.x, p.y, p.z);
        kept->point[i] = (struct poisson_point){
            p,
            {(float)unit.x, (float)unit.y, (float)unit.z},
            radius && column_f32(radius)[i] > 0 ? column_f32(radius)[i] : NAN,
            ao ? column_f32(ao)[i] : NAN};
    }
    return NULL;
}

static struct error *kept_read(struct kept *kept, const struct place_options *o,
                               const struct scene *scene, double most)
{
    const char *file = o->light.keep;
    struct error *err = file ? stream_read(&kept->stream, file) : NULL;
    if (err || !file)
        return err;
    const struct table *probes = stream_table(kept->stream, "probe");
    err = probes ? take_kept(kept, probes, scene) : error_new("there is no table probe");
    if (err)
        return error_wrap(err, "%s", file);
    if (o->count_given && (double)kept->count >= o->count)
        return error_new("--count: expected more than the %zu probes of %s, got %g", kept->count,
                         file, o->count);
    return place_check_count((double)kept->count + 1, most);
}

/* -- placing ---------------------------------------------------------------------------------- */

/* Where a probe is that is lifted off a point: in the middle, where the next surface is nearer than
 * twice that. */
static struct vec3 lifted(const struct tracer *tracer, const struct poisson_point *point,
                          double lift)
{
    const struct vec3 n = {(double)point->normal.x, (double)point->normal.y,
                           (double)point->normal.z};
    double p[3], direction[3];
    vec3_store(p, point->position);
    vec3_store(direction, n);
    const struct trace_hit hit = trace_nearest(tracer, p, direction, 2 * lift);
    return vec3_fma(point->position, hit.hit ? hit.distance / 2 : lift, n);
}

/* Adds columns area and albedo. *lit: the sum of the areas. */
static struct error *give_areas(struct place *place, const struct poisson *set,
                                const struct tracer *tracer, const struct place_options *o,
                                const struct place_world *world, double *lit)
{
    const struct patches_settings settings = {o->poisson.areas, world->seed, world->inside.threads};
    struct column *area = NULL, *albedo = NULL;
    struct patch *patch = NULL;
    struct error *err = array_create(&patch, set->count, sizeof *patch);
    if (!err)
        err = patches_measure(tracer, set->point, set->count, &settings, patch);
    if (!err)
        err = place_add_column(place, "area", COLUMN_F32, 1, &area);
    if (!err)
        err = place_add_column(place, "albedo", COLUMN_F32, 3, &albedo);
    area = err ? NULL : table_column(&place->columns, "area");
    for (size_t i = 0; i < set->count && !err; i++) {
        *lit += (double)patch[i].area;
        column_f32(area)[i] = patch[i].area;
        memcpy(column_f32(albedo) + 3 * i, &patch[i].albedo, sizeof patch[i].albedo);
    }
    free(patch);
    return err;
}

static struct error *give(struct place *place, const struct poisson *set, const struct kept *kept,
                          const struct tracer *tracer, const struct place_options *o)
{
    struct column *radius = NULL, *ao = NULL;
    struct error *err = NULL;
    if (!o->poisson.lift_given)
        err = array_create(&place->normal, 3 * set->count, sizeof *place->normal);
    if (!err)
        err = array_create(&place->origin, set->count, sizeof *place->origin);
    for (size_t i = 0; i < set->count && !err; i++) {
        const struct poisson_point *point = &set->point[i];
        double p[3];
        vec3_store(p, o->poisson.lift_given ? lifted(tracer, point, o->poisson.lift)
                                            : point->position);
        if (place->normal)
            memcpy(place->normal + 3 * i,
                   i < kept->count ? kept->normal + 3 * i : (const float *)&point->normal,
                   3 * sizeof *place->normal);
        place->origin[i] = i >= kept->count ? place_method_poisson.origin
                           : kept->origin   ? kept->origin[i]
                                            : -1;
        err = place_append(place, p);
    }
    if (!err)
        err = place_add_column(place, "radius", COLUMN_F32, 1, &radius);
    if (!err)
        err = place_add_column(place, "ao", COLUMN_F32, 1, &ao);
    radius = err ? NULL : table_column(&place->columns, "radius");
    for (size_t i = 0; i < set->count && !err; i++) {
        column_f32(radius)[i] = set->point[i].radius;
        column_f32(ao)[i] = set->point[i].ao;
    }
    return err;
}

static struct error *make(struct poisson *set, const struct path_tracer *path,
                          const struct kept *kept, const struct place_options *o,
                          const struct place_world *world, double diagonal)
{
    const double *radius = o->poisson.radii;
    const size_t most = (size_t)world->most;
    struct poisson_settings s = {.least = radius[0],
                                 .most = radius[1],
                                 .steer = (enum poisson_steer)o->poisson.steer,
                                 .distance = o->poisson.distance_given ? o->poisson.distance
                                                                       : DISTANCE_SHARE * diagonal,
                                 .rays = o->light.rays_given ? o->light.rays : RAYS,
                                 .particles = o->poisson.particles,
                                 .bounces = o->light.bounces > 0 ? o->light.bounces : 1,
                                 .misses = o->poisson.misses,
                                 .points_most = most,
                                 .kept = kept->point,
                                 .kept_count = kept->count,
                                 .seed = world->seed,
                                 .threads = world->inside.threads};
    if (s.rays > POISSON_RAYS_MOST)
        return error_usage("poisson: expected at most --rays %d, got %d", POISSON_RAYS_MOST,
                           s.rays);
    if (o->count_given) {
        struct error *err = place_check_count(o->count, world->most);
        s.least = 1;
        s.most = RATIO;
        return err ? err : poisson_make_count(set, path, &s, (size_t)o->count);
    }
    struct error *err = check_radii(radius, diagonal);
    if (!err)
        err = poisson_make(set, path, &s);
    if (!err && set->full)
        err =
            error_new("--radii %g,%g make more than --max-probes %zu", radius[0], radius[1], most);
    return err;
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    const struct scene *scene = world->scene;
    const double diagonal = vec3_length(vec3_sub(scene->box_max, scene->box_min));
    struct tracer *tracer = NULL;
    struct path_tracer path = {0};
    struct poisson set = {0};
    struct kept kept = {0};
    double lit = 0;
    struct error *err = kept_read(&kept, o, scene, world->most);
    if (!err)
        err = trace_create(&tracer, scene);
    if (!err)
        err = path_init(&path, tracer, o->light.bounces);
    if (!err) {
        interrupt_catch();
        err = make(&set, &path, &kept, o, world, diagonal);
    }
    if (!err)
        err = give(place, &set, &kept, tracer, o);
    if (!err && o->poisson.areas_given)
        err = give_areas(place, &set, tracer, o, world, &lit);
    if (!err && world->program)
        fprintf(stderr,
                "%s: %zu points, radii %g to %g: of %zu darts %zu were asked for occlusion\n",
                world->program, set.count, set.least, set.most, set.darts, set.tested);
    if (!err && world->program && o->poisson.areas_given)
        fprintf(stderr,
                "%s: they stand for %g of surface that is lit, in units of the scene, "
                "squared\n",
                world->program, lit);
    poisson_clear(&set);
    kept_clear(&kept);
    path_clear(&path);
    trace_destroy(tracer);
    return err ? err : place_reach_keep(place, o, world);
}

static const char *const shares[] = {"count", "rays", "bounces", "keep", NULL};

const struct place_method place_method_poisson = {.name = "poisson",
                                                  .origin = 12,
                                                  .needs_scene = true,
                                                  .sees_light = true,
                                                  .shares = shares,
                                                  .reaches = true,
                                                  .rows = rows,
                                                  .check = check,
                                                  .place = place_by_options};
