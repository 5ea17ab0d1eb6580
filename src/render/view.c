/* SPDX-License-Identifier: Apache-2.0 */
#include "render/view.h"
#include "base/array.h"
#include "base/error.h"
#include "math/angle.h"
#include "math/direction.h"
#include "math/luminance.h"
#include "render/camera.h"
#include "scene/scene.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum {
    PLACES = 300, /* about, in the scene's box */
    ACROSS_MOST = 12,
    RAYS = 32,    /* that tell whether a place is free */
    COMPASS = 16, /* directions that are tried from each eye */
    FINALISTS = 96,
    EYE_FINALISTS = 2, /* of one eye, so that they differ */
    FAN = 12,          /* rays across and down a finalist's picture */
};

struct place {
    struct vec3 position;
    bool outside; /* of the box: an eye, but no place to be seen */
};

struct candidate {
    size_t eye;
    struct vec3 forward;
    double score;
    double worth, light[FAN * FAN]; /* of the finalists */
};

struct choice {
    const struct path_tracer *path;
    const struct tracer *tracer;
    struct vec3 centre;
    double radius, spacing, fov, aspect;
    struct place *place;
    size_t count, seen; /* the first `seen` are those to be seen */
    bool *sees;         /* count * seen */
    struct candidate best[FINALISTS];
    size_t finalists;
};

static struct trace_hit look(const struct choice *c, struct vec3 from, struct vec3 direction)
{
    double origin[3], d[3];
    vec3_store(origin, from);
    vec3_store(d, direction);
    return trace_nearest(c->tracer, origin, d, (double)INFINITY);
}

/* The i-th of `count` directions, from above down. */
static struct vec3 spread(int i, int count)
{
    const struct vec3 d = direction_even(i, count);
    return (struct vec3){d.x, d.z, d.y};
}

/* Whether what surrounds a place shows it its front. */
static bool is_free(const struct choice *c, struct vec3 p)
{
    int fronts = 0, backs = 0;
    for (int i = 0; i < RAYS; i++) {
        const struct trace_hit hit = look(c, p, spread(i, RAYS));
        fronts += hit.hit && hit.front;
        backs += hit.hit && !hit.front;
    }
    return fronts > 0 && 10 * backs <= fronts;
}

static struct error *find_places(struct choice *c)
{
    const struct scene *scene = trace_scene(c->tracer);
    const struct vec3 size = vec3_sub(scene->box_max, scene->box_min);
    const double side[3] = {size.x, size.y, size.z}, longest = fmax(size.x, fmax(size.y, size.z));
    size_t n[3];
    double step = longest / ACROSS_MOST; /* as fine as there are places for */
    for (;; step *= 1.1) {
        for (int k = 0; k < 3; k++)
            n[k] = side[k] > step ? (size_t)(side[k] / step) : 1;
        if (n[0] * n[1] * n[2] <= PLACES)
            break;
    }
    c->spacing = step;
    struct error *err = array_create(&c->place, n[0] * n[1] * n[2] + 26, sizeof *c->place);
    for (size_t i = 0; i < n[0] * n[1] * n[2] && !err; i++) {
        const struct vec3 p = {
            scene->box_min.x + ((double)(i % n[0]) + 0.5) / (double)n[0] * size.x,
            scene->box_min.y + ((double)(i / n[0] % n[1]) + 0.5) / (double)n[1] * size.y,
            scene->box_min.z + ((double)(i / n[0] / n[1]) + 0.5) / (double)n[2] * size.z};
        if (is_free(c, p))
            c->place[c->count++].position = p;
    }
    c->seen = c->count;
    const double half = fmax(c->fov, 1) * (ANGLE_PI / 360),
                 away = c->radius / angle_sin(half) * fmax(1, 1 / c->aspect);
    for (int i = 0; i < 27 && !err; i++) {
        const struct vec3 d = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        if (vec3_length(d) > 0)
            c->place[c->count++] =
                (struct place){vec3_fma(c->centre, away, vec3_normalize(d)), true};
    }
    return err;
}

/* How many of the places that an eye sees are in the picture; not those that are close by. */
static double count_seen(const struct choice *c, size_t eye, const struct camera *camera)
{
    double count = 0, x, y, depth;
    for (size_t i = 0; i < c->seen; i++)
        count += c->sees[eye * c->seen + i] &&
                 camera_project(camera, c->place[i].position, &x, &y, &depth) &&
                 depth > c->spacing && x > 0 && x < (double)camera->width && y > 0 &&
                 y < (double)camera->height;
    return count;
}

static struct error *aim(const struct choice *c, const struct candidate *candidate,
                         struct camera *camera)
{
    const struct vec3 eye = c->place[candidate->eye].position;
    const struct vec3 up = fabs(candidate->forward.y) > 0.99 ? (struct vec3){0, 0, -1}
                                                             : (struct vec3){0, 1, 0};
    return camera_init(
        camera, &(struct camera_view){.eye = eye,
                                      .look_at = vec3_fma(eye, c->radius, candidate->forward),
                                      .up = up,
                                      .fov = c->fov,
                                      .width = (size_t)(1000 * c->aspect) + 1,
                                      .height = 1000});
}

/* Puts a candidate among the finalists, which are in order, if it is good enough. */
static void enter(struct choice *c, const struct candidate *candidate)
{
    if (c->finalists == FINALISTS && !(candidate->score > c->best[FINALISTS - 1].score))
        return;
    size_t at = c->finalists < FINALISTS ? c->finalists++ : FINALISTS - 1;
    for (; at > 0 && c->best[at - 1].score < candidate->score; at--)
        c->best[at] = c->best[at - 1];
    c->best[at] = *candidate;
}

/* The best views from one eye, best first. */
static struct error *try_eye(struct choice *c, size_t eye)
{
    struct candidate best[EYE_FINALISTS] = {{.score = -1}, {.score = -1}};
    const bool outside = c->place[eye].outside;
    struct error *err = NULL;
    for (int i = 0; i < (outside ? 1 : COMPASS) && !err; i++) {
        const double turn = 2 * ANGLE_PI * i / COMPASS;
        const struct vec3 level = {angle_cos(turn), -0.15, angle_sin(turn)};
        struct candidate candidate = {
            .eye = eye,
            .forward =
                vec3_normalize(outside ? vec3_sub(c->centre, c->place[eye].position) : level)};
        struct camera camera;
        err = aim(c, &candidate, &camera);
        const double seen = err ? 0
                                : count_seen(c, eye, &camera) *
                                      (1 - 0.5 * candidate.forward.y * candidate.forward.y);
        /* from outside, all is to be seen or it is no view */
        candidate.score = outside && c->seen ? seen * seen / (double)c->seen : seen;
        if (candidate.score > best[0].score) {
            best[1] = best[0];
            best[0] = candidate;
        } else if (candidate.score > best[1].score) {
            best[1] = candidate;
        }
    }
    for (int i = 0; i < EYE_FINALISTS && !err; i++)
        if (best[i].score >= 0)
            enter(c, &best[i]);
    return err;
}

/* What a finalist's picture shows. Its worth is 1 where it is full of fronts; sky counts a little,
 * backs count against it, and so does what is close to the eye. */
static struct error *look_around(const struct choice *c, struct candidate *finalist, size_t number)
{
    struct camera camera;
    double sum = 0, eye[3];
    struct error *err = aim(c, finalist, &camera);
    if (err)
        return err;
    vec3_store(eye, camera.eye);
    const struct path_receiver receiver = {.at = {.position = trace_to_local(c->tracer, eye)}};
    for (size_t row = 0; row < FAN; row++) {
        struct vec3f direction[FAN];
        struct random random[FAN];
        struct path_sample sample[FAN];
        for (size_t i = 0; i < FAN; i++) {
            const struct vec3 d =
                camera_direction(&camera, ((double)i + 0.5) / FAN * (double)camera.width,
                                 ((double)row + 0.5) / FAN * (double)camera.height);
            direction[i] = (struct vec3f){(float)d.x, (float)d.y, (float)d.z};
            random[i] = random_start(0, number, (uint32_t)(FAN * row + i));
        }
        path_samples(c->path, &receiver,
                     &(struct path_rays){.count = FAN, .direction = direction, .random = random},
                     sample);
        for (size_t i = 0; i < FAN; i++) {
            const struct path_sample *s = &sample[i];
            finalist->light[FAN * row + i] =
                (double)luminance_vec3f(vec3f_add(s->straight, s->scattered));
            sum += !s->hit    ? 0.4
                   : s->front ? fmin((double)s->distance / c->tracer->scale / c->spacing, 1)
                              : -1;
        }
    }
    finalist->worth = fmax(sum / (FAN * FAN), 0.01);
    return NULL;
}

/* How well a finalist is lit, beside what all of them see in the mean: from 0.1 to 1. */
static double brightness(const struct candidate *finalist, double mean)
{
    double sum = 0;
    for (int i = 0; i < FAN * FAN; i++)
        sum += mean > 0 ? fmin(finalist->light[i] / mean, 1) : 1;
    return 0.1 + 0.9 * sum / (FAN * FAN);
}

static struct error *choose(struct choice *c, struct vec3 *eye, struct vec3 *look_at)
{
    struct error *err = find_places(c);
    if (!err)
        err = array_create(&c->sees, c->count * c->seen, sizeof *c->sees);
    for (size_t i = 0; i < c->count * c->seen && !err; i++) {
        double a[3], b[3];
        vec3_store(a, c->place[i / c->seen].position);
        vec3_store(b, c->place[i % c->seen].position);
        c->sees[i] = trace_visibility(c->tracer, a, b) > 0.5f;
    }
    for (size_t i = 0; i < c->count && !err; i++)
        err = try_eye(c, i);
    double mean = 0, most = -1;
    for (size_t i = 0; i < c->finalists && !err; i++) {
        err = look_around(c, &c->best[i], i);
        for (int k = 0; k < FAN * FAN; k++)
            mean += c->best[i].light[k] / (double)(FAN * FAN * c->finalists);
    }
    for (size_t i = 0; i < c->finalists && !err; i++) {
        const struct candidate *f = &c->best[i];
        const double score = (f->score + 1) * f->worth * brightness(f, mean);
        if (!(score > most))
            continue;
        most = score;
        *eye = c->place[f->eye].position;
        *look_at = vec3_fma(*eye, c->radius, f->forward);
    }
    /* straight up or down, the way up is not to be told from the view: a little less than that */
    const struct vec3 along = vec3_sub(*look_at, *eye);
    if (!err && !(hypot(along.x, along.z) > 1e-3 * c->radius))
        look_at->z += along.y > 0 ? 0.01 * c->radius : -0.01 * c->radius;
    return err;
}

struct error *view_choose(const struct path_tracer *path, double fov, double aspect,
                          struct vec3 *eye, struct vec3 *look_at)
{
    const struct scene *scene = path->tracer->scene;
    struct choice c = {.path = path,
                       .tracer = path->tracer,
                       .centre = vec3_scale(0.5, vec3_add(scene->box_min, scene->box_max)),
                       .radius = vec3_length(vec3_sub(scene->box_max, scene->box_min)) / 2,
                       .fov = fov,
                       .aspect = aspect};
    struct error *err = choose(&c, eye, look_at);
    free(c.place);
    free(c.sees);
    return err;
}
