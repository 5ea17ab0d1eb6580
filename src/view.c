#include "view.h"
#include "angle.h"
#include "array.h"
#include "camera.h"
#include "error.h"
#include "scene.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum {
    PLACES = 300,  /* about, in the scene's box */
    ACROSS_MOST = 12,
    RAYS = 32,     /* that tell whether a place is free */
    COMPASS = 16,  /* directions that are tried from each eye */
    FINALISTS = 64,
    FAN = 12,      /* rays across and down a finalist's picture */
};

struct place {
    struct vec3 position;
    bool outside; /* of the box: an eye, but no place to be seen */
};

struct candidate {
    size_t eye;
    struct vec3 forward;
    double score;
};

struct choice {
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

/* The i-th of `count` directions spread evenly over the sphere (spherical Fibonacci). */
static struct vec3 spread(int i, int count)
{
    const double z = 1 - (2 * i + 1.0) / count, r = sqrt(1 - z * z), turn = i * 2.39996322972865332;
    return (struct vec3){r * angle_cos(turn), z, r * angle_sin(turn)};
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
        const struct vec3 p = {scene->box_min.x + ((double)(i % n[0]) + 0.5) / (double)n[0] * size.x,
                               scene->box_min.y + ((double)(i / n[0] % n[1]) + 0.5) / (double)n[1] * size.y,
                               scene->box_min.z + ((double)(i / n[0] / n[1]) + 0.5) / (double)n[2] * size.z};
        if (is_free(c, p))
            c->place[c->count++].position = p;
    }
    c->seen = c->count;
    const double half = fmax(c->fov, 1) * (ANGLE_PI / 360), away = c->radius / angle_sin(half) * fmax(1, 1 / c->aspect);
    for (int i = 0; i < 27 && !err; i++) {
        const struct vec3 d = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        if (vec3_length(d) > 0)
            c->place[c->count++] = (struct place){vec3_fma(c->centre, away, vec3_normalize(d)), true};
    }
    return err;
}

/* How many of the places that an eye sees are in the picture; not those that are close by. */
static double count_seen(const struct choice *c, size_t eye, const struct camera *camera)
{
    double count = 0, x, y, depth;
    for (size_t i = 0; i < c->seen; i++)
        count += c->sees[eye * c->seen + i] && camera_project(camera, c->place[i].position, &x, &y, &depth) && depth > c->spacing && x > 0 &&
                 x < (double)camera->width && y > 0 && y < (double)camera->height;
    return count;
}

static struct error *aim(const struct choice *c, const struct candidate *candidate, struct camera *camera)
{
    const struct vec3 eye = c->place[candidate->eye].position;
    const struct vec3 up = fabs(candidate->forward.y) > 0.99 ? (struct vec3){0, 0, -1} : (struct vec3){0, 1, 0};
    return camera_create(camera, eye, vec3_fma(eye, c->radius, candidate->forward), up, c->fov, (size_t)(1000 * c->aspect) + 1, 1000);
}

static void enter(struct choice *c, const struct candidate *candidate)
{
    if (c->finalists == FINALISTS && !(candidate->score > c->best[FINALISTS - 1].score))
        return;
    size_t at = c->finalists < FINALISTS ? c->finalists++ : FINALISTS - 1;
    for (; at > 0 && c->best[at - 1].score < candidate->score; at--)
        c->best[at] = c->best[at - 1];
    c->best[at] = *candidate;
}

static struct error *try_views(struct choice *c)
{
    struct error *err = NULL;
    for (size_t eye = 0; eye < c->count && !err; eye++) {
        const bool outside = c->place[eye].outside;
        for (int i = 0; i < (outside ? 1 : COMPASS) && !err; i++) {
            const double turn = 2 * ANGLE_PI * i / COMPASS;
            const struct vec3 level = {angle_cos(turn), -0.15, angle_sin(turn)};
            struct candidate candidate = {.eye = eye, .forward = vec3_normalize(outside ? vec3_sub(c->centre, c->place[eye].position) : level)};
            struct camera camera;
            err = aim(c, &candidate, &camera);
            candidate.score = err ? 0 : count_seen(c, eye, &camera) * (1 - 0.5 * candidate.forward.y * candidate.forward.y);
            enter(c, &candidate);
        }
    }
    return err;
}

/* 1 where the picture is full of fronts; sky counts a little, backs count against it, and so does what is close to the eye. */
static double worth(const struct choice *c, const struct camera *camera)
{
    double sum = 0;
    for (int i = 0; i < FAN * FAN; i++) {
        const double x = (i % FAN + 0.5) / FAN * (double)camera->width, y = (i / FAN + 0.5) / FAN * (double)camera->height;
        const struct trace_hit hit = look(c, camera->eye, camera_direction(camera, x, y));
        if (!hit.hit)
            sum += 0.4;
        else if (!hit.front)
            sum -= 1;
        else
            sum += fmin(hit.distance / c->spacing, 1);
    }
    return fmax(sum / (FAN * FAN), 0.01);
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
    if (!err)
        err = try_views(c);
    double most = -1;
    for (size_t i = 0; i < c->finalists && !err; i++) {
        struct camera camera;
        err = aim(c, &c->best[i], &camera);
        const double score = err ? 0 : (c->best[i].score + 1) * worth(c, &camera);
        if (!(score > most))
            continue;
        most = score;
        *eye = camera.eye;
        *look_at = vec3_fma(camera.eye, c->radius, camera.forward);
    }
    return err;
}

struct error *view_choose(const struct tracer *tracer, double fov, double aspect, struct vec3 *eye, struct vec3 *look_at)
{
    const struct scene *scene = trace_scene(tracer);
    struct choice c = {.tracer = tracer, .centre = vec3_scale(0.5, vec3_add(scene->box_min, scene->box_max)),
                       .radius = vec3_length(vec3_sub(scene->box_max, scene->box_min)) / 2, .fov = fov, .aspect = aspect};
    struct error *err = choose(&c, eye, look_at);
    free(c.place);
    free(c.sees);
    return err;
}
