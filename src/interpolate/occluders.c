/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/occluders.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/number.h"
#include "libprobe-query/sh.h"
#include "math/direction.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

struct occluders {
    double *sphere; /* 4 each: centre, radius; owned */
    size_t count, capacity;
    struct vec3 direction[OCCLUDER_DIRECTIONS];
    double basis[OCCLUDER_DIRECTIONS][SH_COUNT_MAX];
};

/* -- reading ---------------------------------------------------------------------------------- */

static struct error *take_sphere(struct occluders *o, const char *line)
{
    double n[4];
    int count = 0;
    const char *end = line + strlen(line), *at = line + strspn(line, " \t\r,");
    if (at >= end || *at == '#')
        return NULL;
    while (at < end && *at != '#') {
        at = count < 4 ? number_read_f64(at, end, &n[count]) : NULL;
        if (!at || !isfinite(n[count]) || (at < end && !strchr(" \t\r,#", *at)))
            return error_new("expected X Y Z RADIUS of a sphere, got '%s'", line);
        count++;
        at += strspn(at, " \t\r,");
    }
    if (count < 4 || !(n[3] > 0))
        return error_new("expected X Y Z RADIUS of a sphere, its radius above 0, got '%s'", line);
    struct error *err =
        array_reserve(&o->sphere, &o->capacity, 4 * (o->count + 1), sizeof *o->sphere);
    if (!err)
        memcpy(o->sphere + 4 * o->count++, n, sizeof n);
    return err;
}

static struct error *read_lines(struct occluders *o, struct file_input *in)
{
    struct error *err = NULL;
    for (bool more = true; more && !err;) {
        const char *line;
        size_t length, bytes;
        err = file_input_line(in, &line, &length, &bytes);
        more = !err && line;
        if (!more)
            break;
        char *text = strndup(line, length);
        err = text ? take_sphere(o, text) : error_memory();
        free(text);
        in->line++;
        file_input_consume(in, bytes);
        err = error_wrap(err, "%s:%zu", in->name, in->line);
    }
    return !err && !o->count ? error_new("%s: expected spheres, there are none", in->name) : err;
}

struct error *occluders_read(struct occluders **occluders, const char *path)
{
    struct file_input in;
    struct error *err = array_create(occluders, 1, sizeof **occluders);
    if (err)
        return err;
    for (int i = 0; i < OCCLUDER_DIRECTIONS; i++) {
        double d[3];
        (*occluders)->direction[i] = direction_even(i, OCCLUDER_DIRECTIONS);
        vec3_store(d, (*occluders)->direction[i]);
        sh_basis(SH_ORDER_MAX, d, (*occluders)->basis[i]);
    }
    err = file_input_open(&in, path);
    if (err)
        return err;
    err = read_lines(*occluders, &in);
    file_input_close(&in);
    return err;
}

void occluders_destroy(struct occluders *o)
{
    if (o)
        free(o->sphere);
    free(o);
}

/* -- shading ---------------------------------------------------------------------------------- */

/* Multiplies what is open of each direction by what a sphere leaves; false: the point is inside of
 * it. A direction stands for a cell
 * about as wide as the root of its solid angle, over which the edge of the sphere's cone falls. */
static bool hide(const struct occluders *o, const double sphere[4], const double point[3],
                 double *open)
{
    const double width = sqrt(4 * ANGLE_PI / OCCLUDER_DIRECTIONS);
    const struct vec3 way = vec3_sub(vec3_load(sphere), vec3_load(point));
    const double distance = vec3_length(way), sine = sphere[3] / distance;
    if (!(distance > sphere[3]))
        return false;
    const struct vec3 axis = vec3_scale(1 / distance, way);
    const double edge = sqrt(1 - sine * sine), slope = 1 / (width * fmax(sine, width / 2)),
                 part = fmin(sine / (width / 2), 1); /* a small one fills a part of a cell */
    for (int i = 0; i < OCCLUDER_DIRECTIONS; i++) {
        const double covered = 0.5 + slope * (vec3_dot(axis, o->direction[i]) - edge);
        if (covered > 0)
            open[i] *= 1 - part * part * fmin(covered, 1);
    }
    return true;
}

/* Of each direction; false: none is. */
static bool find_open(const struct occluders *o, const double point[3], double *open)
{
    bool any = true;
    for (int i = 0; i < OCCLUDER_DIRECTIONS; i++)
        open[i] = 1;
    for (size_t s = 0; s < o->count && any; s++)
        any = hide(o, o->sphere + 4 * s, point, open);
    return any;
}

void occluders_shade(const struct occluders *o, int order, const double point[3], float *sh)
{
    const int count = order * order;
    double open[OCCLUDER_DIRECTIONS], hidden[3 * SH_COUNT_MAX] = {0};
    if (!find_open(o, point, open)) {
        memset(sh, 0, (size_t)(3 * count) * sizeof *sh);
        return;
    }
    for (int i = 0; i < OCCLUDER_DIRECTIONS; i++) {
        const double *y = o->basis[i];
        double light[3] = {0};
        if (!(open[i] < 1))
            continue;
        for (int k = 0; k < 3 * count; k++)
            light[k % 3] += y[k / 3] * (double)sh[k];
        for (int k = 0; k < 3 * count; k++)
            hidden[k] += (1 - open[i]) * y[k / 3] * light[k % 3];
    }
    for (int k = 0; k < 3 * count; k++)
        sh[k] = (float)((double)sh[k] - 4 * ANGLE_PI / OCCLUDER_DIRECTIONS * hidden[k]);
}

double occluders_open(const struct occluders *o, const double point[3])
{
    double open[OCCLUDER_DIRECTIONS], sum = 0;
    const bool any = find_open(o, point, open);
    for (int i = 0; i < OCCLUDER_DIRECTIONS && any; i++)
        sum += open[i] / OCCLUDER_DIRECTIONS;
    return sum;
}
