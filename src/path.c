/* Based on:
 * Kajiya, "The rendering equation", SIGGRAPH 1986.
 * Veach, "Robust Monte Carlo methods for light transport simulation", 1997, ch. 9 (balance heuristic).
 * Malley's method: cosine-distributed directions from a disc. Duff et al., "Building an orthonormal basis, revisited", JCGT 2017.
 */
#include "path.h"
#include "angle.h"
#include "array.h"
#include "error.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#define PI 3.14159265f

struct path_sun {
    struct vec3f to_light, irradiance;
};

static struct error *add_suns(struct path_tracer *path)
{
    const struct scene *scene = path->tracer->scene;
    struct error *err = array_create(&path->suns, scene->light_count, sizeof *path->suns);
    for (size_t i = 0; i < scene->light_count && !err; i++) {
        const struct scene_light *l = &scene->lights[i];
        if (l->kind != SCENE_SUN || !(l->intensity[0] > 0 || l->intensity[1] > 0 || l->intensity[2] > 0))
            continue;
        path->suns[path->sun_count++] = (struct path_sun){
            {-(float)l->direction.x, -(float)l->direction.y, -(float)l->direction.z},
            {(float)l->intensity[0], (float)l->intensity[1], (float)l->intensity[2]}};
    }
    return err;
}

struct error *path_create(struct path_tracer *path, const struct tracer *tracer, int bounces)
{
    *path = (struct path_tracer){.tracer = tracer, .bounces = bounces};
    struct error *err = lights_create(&path->lights, tracer);
    for (size_t i = 0; i < path->lights.instance_count && !err; i++)
        path->emissive = path->emissive || path->lights.number[i];
    if (!err)
        err = sky_create(&path->sky, tracer->scene);
    if (!err)
        err = add_suns(path);
    if (err)
        path_clear(path);
    return err;
}

void path_clear(struct path_tracer *path)
{
    lights_clear(&path->lights);
    sky_clear(&path->sky);
    free(path->suns);
    path->suns = NULL;
}

static uint32_t draw_salt(const struct path_tracer *path, struct random *random)
{
    return path->tracer->has_alpha ? random_u32(random) : 0;
}

/* Radiance that a surface emits towards where it is seen from. */
static struct vec3f emitted(const struct path_tracer *path, const struct trace_point *point)
{
    if (!scene_emits(point->material) || (path->tracer->scene->emit_front_only && !point->front))
        return (struct vec3f){0};
    return scene_emission(path->tracer->scene, point->material, point->u, point->v);
}

/* -- asking lights and sky ---------------------------------------------------------------------- */

static bool on_surface(const struct lights_receiver *r)
{
    return r->normal.x != 0 || r->normal.y != 0 || r->normal.z != 0;
}

/* Density per solid angle of a receiver's own directions. */
static float own_density(const struct lights_receiver *r, struct vec3f direction)
{
    return on_surface(r) ? float_most(vec3f_dot(direction, r->normal), 0) / PI : 1 / (4 * PI);
}

/* Per solid angle from distance: per area times d^2 / cos. */
static float solid_density(float area_density, float distance, float cosine)
{
    return area_density * distance * distance / cosine;
}

/* A question whether anything stands between a receiver and what was found, and what is found where nothing does. */
struct question {
    struct trace_ray ray;
    struct path_found found;
};

/* Radiance of a drawn point of an emissive surface towards the receiver, over its density per solid angle, balanced with the
 * receiver's own directions. False: it is turned away, and nothing is to be asked. */
static bool ask_surface(const struct path_tracer *path, const struct lights_receiver *from, float share,
                        struct lights_choice *choice, struct random *random, struct question *question)
{
    struct trace_point *point = &choice->point;
    const struct vec3f way = vec3f_sub(point->position, from->position);
    const float distance = vec3f_length(way);
    const uint32_t salt = draw_salt(path, random);
    if (!(distance > 0))
        return false;
    const struct vec3f direction = vec3f_scale(1 / distance, way);
    const float cosine = -vec3f_dot(direction, point->normal);
    point->front = cosine > 0;
    point->distance = distance;
    const float own = own_density(from, direction);
    struct vec3f radiance = emitted(path, point);
    if (path->tracer->has_alpha) /* where the surface is not, it does not shine */
        radiance = vec3f_scale(1 - scene_transparency(path->tracer->scene, point->material, point->u, point->v), radiance);
    if (!(fabsf(cosine) > 0) || !(own > 0) || !(vec3f_most(radiance) > 0))
        return false;
    const float density = solid_density(choice->density, distance, fabsf(cosine));
    /* To just above the light, so that it does not shadow itself. */
    const struct vec3f target = trace_leave(point, vec3f_scale(cosine > 0 ? 1.0f : -1.0f, point->normal));
    const struct vec3f to_target = vec3f_sub(target, from->position);
    const float reach = vec3f_length(to_target);
    question->ray = (struct trace_ray){.origin = from->position, .direction = vec3f_scale(1 / reach, to_target), .most = reach, .salt = salt};
    question->found = (struct path_found){direction, vec3f_scale(1 / (share * density + own), radiance)};
    return true;
}

/* The weight of emission that a ray of density `own` met, against found_surface. */
static float met_weight(const struct path_tracer *path, const struct lights_receiver *from, float share,
                        const struct trace_point *point, struct vec3f direction, float own)
{
    const float area_density = path->emissive ? lights_density(&path->lights, from, point) : 0;
    if (!(area_density > 0))
        return 1;
    const float cosine = fabsf(vec3f_dot(direction, point->normal));
    return own / (own + share * solid_density(area_density, point->distance, float_most(cosine, FLT_MIN)));
}

/* Radiance of the sky from a drawn direction over its density, balanced as above. */
static bool ask_sky(const struct path_tracer *path, const struct lights_receiver *from, float share, double x, double y,
                    struct random *random, struct question *question)
{
    float density;
    const struct vec3f direction = sky_sample(&path->sky, x, y, &density);
    const float own = own_density(from, direction);
    question->ray = (struct trace_ray){.origin = from->position, .direction = direction, .most = INFINITY, .salt = draw_salt(path, random)};
    if (!(own > 0) || !(density > 0))
        return false;
    question->found = (struct path_found){direction, vec3f_scale(1 / (share * density + own), scene_sky_radiance(path->tracer->scene, direction))};
    return true;
}

static float sky_weight(const struct path_tracer *path, float share, struct vec3f direction, float own)
{
    return path->sky.rows ? own / (own + share * sky_density(&path->sky, direction)) : 1;
}

/* -- scattering -------------------------------------------------------------------------------- */

struct vec3f path_scatter(struct vec3f n, float u, float turn)
{
    const float r = sqrtf(u), z = sqrtf(1 - u);
    float x, y;
    angle_turn(turn, &x, &y);
    x *= r;
    y *= r;
    const float sign = n.z < 0 ? -1.0f : 1.0f, a = -1 / (sign + n.z), b = n.x * n.y * a;
    const struct vec3f s = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, t = {b, sign + n.y * n.y * a, -n.y};
    return vec3f_add(vec3f_scale(x, s), vec3f_add(vec3f_scale(y, t), vec3f_scale(z, n)));
}

/* -- a wave of paths --------------------------------------------------------------------------- */

/* A path between two stages. */
struct walker {
    struct trace_point point; /* of the surface where it is */
    struct vec3f incoming;    /* the way it came */
    struct lights_receiver from;
    struct vec3f throughput, sum; /* what light it meets counts, and what it has met so far */
    struct vec3f light;           /* irradiance over pi on the surface from what was asked */
    struct scene_texel texel;
    struct trace_ray ray; /* the way it goes on */
    bool hit;
    struct random *random;
};

/* Paths that go on, and what they ask for in one stage. */
struct wave {
    const struct path_tracer *path;
    struct walker *walker[PATH_WAVE];
    size_t count;
    struct question question[PATH_WAVE]; /* found.light: irradiance over pi */
    struct walker *asks[PATH_WAVE];      /* by question */
    size_t questions;
};

/* Irradiance over pi from a point or spot light that was drawn. */
static bool ask_punctual(const struct path_tracer *path, const struct lights_receiver *from, const struct lights_choice *choice,
                         struct random *random, struct question *question)
{
    const struct scene_light *light = choice->punctual;
    const struct vec3 p = trace_to_world(path->tracer, from->position);
    double direction[3], distance, rgb[3];
    scene_light_at(light, (const double[3]){p.x, p.y, p.z}, direction, &distance, rgb);
    const struct vec3f to_light = {(float)direction[0], (float)direction[1], (float)direction[2]};
    const struct vec3f e = {(float)rgb[0], (float)rgb[1], (float)rgb[2]};
    const float cosine = vec3f_dot(to_light, from->normal);
    const uint32_t salt = draw_salt(path, random);
    if (!(cosine > 0) || !(vec3f_most(e) > 0))
        return false;
    question->ray = (struct trace_ray){.origin = from->position, .direction = to_light, .most = (float)(distance * path->tracer->scale), .salt = salt};
    question->found = (struct path_found){to_light, vec3f_scale(cosine / (PI * choice->probability), e)};
    return true;
}

/* Irradiance over pi from what was found as radiance over density. */
static void found_to_irradiance(const struct lights_receiver *from, struct path_found *found)
{
    found->light = vec3f_scale(float_most(vec3f_dot(found->direction, from->normal), 0) / PI, found->light);
}

static bool ask_light(const struct path_tracer *path, const struct lights_receiver *from, struct random *random, struct question *question)
{
    struct lights_choice choice;
    const double x = random_double(random);
    const float y = random_float(random);
    if (!lights_sample(&path->lights, path->tracer, from, x, y, &choice))
        return false;
    if (choice.punctual)
        return ask_punctual(path, from, &choice, random, question);
    if (!ask_surface(path, from, 1, &choice, random, question))
        return false;
    found_to_irradiance(from, &question->found);
    return true;
}

static bool ask_sun(const struct path_tracer *path, const struct path_sun *sun, const struct lights_receiver *from, struct random *random,
                    struct question *question)
{
    const float cosine = vec3f_dot(sun->to_light, from->normal);
    if (!(cosine > 0))
        return false;
    question->ray = (struct trace_ray){.origin = from->position, .direction = sun->to_light, .most = INFINITY, .salt = draw_salt(path, random)};
    question->found = (struct path_found){sun->to_light, vec3f_scale(cosine / PI, sun->irradiance)};
    return true;
}

/* Traces what was asked. */
static void answer(struct wave *wave)
{
    for (size_t i = 0; i < wave->questions; i++)
        if (!trace_local_occluded(wave->path->tracer, &wave->question[i].ray))
            wave->asks[i]->light = vec3f_add(wave->asks[i]->light, wave->question[i].found.light);
    wave->questions = 0;
}

/* The light on all surfaces of a wave from what is asked for, without what their scattered rays are to meet. */
static void light_wave(struct wave *wave)
{
    const struct path_tracer *path = wave->path;
    for (size_t i = 0; i < wave->count && path->lights.count; i++) {
        struct walker *w = wave->asks[wave->questions] = wave->walker[i];
        wave->questions += ask_light(path, &w->from, w->random, &wave->question[wave->questions]);
    }
    answer(wave);
    for (size_t i = 0; i < wave->count && path->sky.rows; i++) {
        struct walker *w = wave->asks[wave->questions] = wave->walker[i];
        const double x = random_double(w->random), y = random_double(w->random);
        struct question *question = &wave->question[wave->questions];
        if (ask_sky(path, &w->from, 1, x, y, w->random, question)) {
            found_to_irradiance(&w->from, &question->found);
            wave->questions++;
        }
    }
    answer(wave);
    for (size_t s = 0; s < path->sun_count; s++) {
        for (size_t i = 0; i < wave->count; i++) {
            struct walker *w = wave->asks[wave->questions] = wave->walker[i];
            wave->questions += ask_sun(path, &path->suns[s], &w->from, w->random, &wave->question[wave->questions]);
        }
        answer(wave);
    }
}

/* Turns to the side of the surface that the path came from. */
static void face(struct walker *w)
{
    const struct vec3f n = vec3f_dot(w->point.normal, w->incoming) < 0 ? w->point.normal : vec3f_scale(-1, w->point.normal);
    w->from = (struct lights_receiver){.position = trace_leave(&w->point, n), .normal = n};
    w->light = (struct vec3f){0};
}

/* Draws the way on. What a point is made of is asked only here, so that memory answers while rays are traced. */
static void turn(const struct path_tracer *path, struct walker *w)
{
    trace_point_shade(path->tracer, &w->point);
    w->texel = scene_texel_draw(path->tracer->scene, w->point.material, w->point.u, w->point.v, random_u32(w->random));
    const float u = random_float(w->random), turn = random_float(w->random);
    w->incoming = path_scatter(w->from.normal, u, turn);
    w->ray = (struct trace_ray){.origin = w->from.position, .direction = w->incoming, .most = INFINITY, .salt = draw_salt(path, w->random)};
}

/* Takes in what was lit and met, and says whether the path goes on. */
static bool gather(const struct path_tracer *path, struct walker *w, bool may_end)
{
    const struct scene *scene = path->tracer->scene;
    w->throughput = vec3f_mul(w->throughput, scene_texel_albedo(scene, &w->texel));
    w->sum = vec3f_add(w->sum, vec3f_mul(w->throughput, w->light));
    if (!w->hit) {
        const float weight = sky_weight(path, 1, w->incoming, own_density(&w->from, w->incoming));
        w->sum = vec3f_fma(w->sum, weight, vec3f_mul(w->throughput, scene_sky_radiance(scene, w->incoming)));
        return false;
    }
    if (path->emissive) {
        trace_point_shade(path->tracer, &w->point);
        const struct vec3f e = emitted(path, &w->point);
        if (vec3f_most(e) > 0) {
            const float weight = met_weight(path, &w->from, 1, &w->point, w->incoming, own_density(&w->from, w->incoming));
            w->sum = vec3f_fma(w->sum, weight, vec3f_mul(w->throughput, e));
        }
    }
    const float most = vec3f_most(w->throughput);
    if (!(most > 0))
        return false;
    if (may_end && most < 1) { /* Russian roulette */
        if (random_float(w->random) >= most)
            return false;
        w->throughput = vec3f_scale(1 / most, w->throughput);
    }
    return true;
}

/* The radiance that the points of a wave's walkers scatter back along the way they came, in their sums: one path each. */
static void scatter_wave(struct wave *wave)
{
    const struct path_tracer *path = wave->path;
    for (int bounce = 1; bounce <= path->bounces && wave->count; bounce++) {
        for (size_t i = 0; i < wave->count; i++)
            face(wave->walker[i]);
        light_wave(wave);
        for (size_t i = 0; i < wave->count; i++)
            turn(path, wave->walker[i]);
        for (size_t i = 0; i < wave->count; i++)
            wave->walker[i]->hit = trace_local_nearest(path->tracer, &wave->walker[i]->ray, &wave->walker[i]->point);
        size_t left = 0;
        for (size_t i = 0; i < wave->count; i++) {
            struct walker *w = wave->walker[i];
            if (gather(path, w, bounce >= 2))
                wave->walker[left++] = w;
        }
        wave->count = left;
    }
}

/* -- receivers --------------------------------------------------------------------------------- */

/* What a receiver's ray met by itself. */
static struct path_sample seen(const struct path_tracer *path, const struct path_receiver *receiver, const struct walker *w)
{
    struct path_sample sample = {.weight = 1, .distance = INFINITY};
    if (!w->hit) {
        sample.straight = scene_sky_radiance(path->tracer->scene, w->ray.direction);
        sample.weight = sky_weight(path, receiver->sky_share, w->ray.direction, own_density(&receiver->at, w->ray.direction));
        return sample;
    }
    sample.hit = true;
    sample.front = w->point.front;
    sample.distance = w->point.distance;
    sample.normal = w->point.normal;
    if (path->emissive) {
        struct trace_point point = w->point;
        trace_point_shade(path->tracer, &point);
        sample.straight = emitted(path, &point);
        if (vec3f_most(sample.straight) > 0)
            sample.weight = met_weight(path, &receiver->at, receiver->lights_share, &point, w->ray.direction,
                                       own_density(&receiver->at, w->ray.direction));
    }
    return sample;
}

void path_samples(const struct path_tracer *path, const struct path_receiver *receiver, size_t count, const struct vec3f *direction,
                  bool with_scattered, struct random *random, struct path_sample *sample)
{
    struct walker walker[PATH_WAVE];
    struct wave wave = {.path = path};
    for (size_t i = 0; i < count; i++) {
        struct walker *w = &walker[i];
        w->random = &random[i];
        w->ray = (struct trace_ray){.origin = receiver->at.position, .direction = direction[i], .most = INFINITY,
                                    .salt = draw_salt(path, w->random)};
        w->hit = trace_local_nearest(path->tracer, &w->ray, &w->point);
    }
    for (size_t i = 0; i < count; i++) {
        struct walker *w = &walker[i];
        sample[i] = seen(path, receiver, w);
        w->incoming = direction[i];
        w->throughput = (struct vec3f){1, 1, 1};
        w->sum = (struct vec3f){0};
        if (w->hit && with_scattered)
            wave.walker[wave.count++] = w;
    }
    scatter_wave(&wave);
    for (size_t i = 0; i < count; i++)
        sample[i].scattered = walker[i].sum;
}

/* Keeps what was found where nothing is between. */
static void answer_found(const struct path_tracer *path, size_t count, const bool *asked, const struct question *question, struct path_found *found)
{
    for (size_t i = 0; i < count; i++)
        found[i] = asked[i] && !trace_local_occluded(path->tracer, &question[i].ray) ? question[i].found : (struct path_found){0};
}

void path_lights(const struct path_tracer *path, const struct path_receiver *receiver, size_t count, const float *x, const double *y,
                 struct random *random, struct path_found *found)
{
    struct question question[PATH_WAVE];
    bool asked[PATH_WAVE];
    for (size_t i = 0; i < count; i++) {
        struct lights_choice choice;
        asked[i] = lights_sample(&path->lights, path->tracer, &receiver->at, y[i], x[i], &choice) && !choice.punctual &&
                   ask_surface(path, &receiver->at, receiver->lights_share, &choice, &random[i], &question[i]);
    }
    answer_found(path, count, asked, question, found);
}

void path_skies(const struct path_tracer *path, const struct path_receiver *receiver, size_t count, const float *x, const double *y,
                struct random *random, struct path_found *found)
{
    struct question question[PATH_WAVE];
    bool asked[PATH_WAVE];
    for (size_t i = 0; i < count; i++)
        asked[i] = ask_sky(path, &receiver->at, receiver->sky_share, (double)x[i], y[i], &random[i], &question[i]);
    answer_found(path, count, asked, question, found);
}
