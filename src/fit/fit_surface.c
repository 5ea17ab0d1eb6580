/* SPDX-License-Identifier: Apache-2.0 */
#include "fit/fit_surface.h"
#include "base/array.h"
#include "base/error.h"
#include "math/vec.h"
#include "stream/faces.h"

#include <math.h>
#include <stdlib.h>

/* An edge of a face: its ends in the order of their numbers, and the corner beside it. */
struct edge {
    int32_t end[2], apex;
    uint32_t face;
};

static int compare_edges(const void *left, const void *right)
{
    const struct edge *a = left, *b = right;
    for (int k = 0; k < 2; k++)
        if (a->end[k] != b->end[k])
            return a->end[k] < b->end[k] ? -1 : 1;
    return (a->face > b->face) - (a->face < b->face);
}

static struct error *list_edges(const struct faces *faces, struct edge **list)
{
    struct error *err = array_create(list, 3 * faces->count, sizeof **list);
    for (size_t i = 0; i < 3 * faces->count && !err; i++) {
        const int32_t *v = faces->vertex + i / 3 * 3;
        const int32_t a = v[i % 3], b = v[(i + 1) % 3];
        (*list)[i] =
            (struct edge){{a < b ? a : b, a < b ? b : a}, v[(i + 2) % 3], (uint32_t)(i / 3)};
    }
    if (!err && faces->count)
        qsort(*list, 3 * faces->count, sizeof **list, compare_edges);
    return err;
}

static struct vec3 at(const struct faces *faces, int32_t vertex)
{
    return vec3_load(faces->surface + 3 * (size_t)vertex);
}

/* Where the apex of a face stands over the edge: its foot, 0 to 1 from end 0 to 1, and its height,
 * in units of the scene. */
static double stand(const struct faces *faces, const struct edge *edge, double *foot)
{
    const struct vec3 a = at(faces, edge->end[0]), along = vec3_sub(at(faces, edge->end[1]), a),
                      to = vec3_sub(at(faces, edge->apex), a);
    const double square = vec3_dot(along, along);
    *foot = vec3_dot(to, along) / square;
    return vec3_length(vec3_cross(along, to)) / sqrt(square);
}

/* The bend between two faces over an edge that both have. */
static bool bend(const struct faces *faces, const struct edge *one, const struct edge *other,
                 double scale, struct fit_element *element)
{
    double foot, other_foot;
    if (one->end[0] != other->end[0] || one->end[1] != other->end[1] || one->apex == other->apex)
        return false;
    const double height = stand(faces, one, &foot), other_height = stand(faces, other, &other_foot);
    if (!(height > 0 && other_height > 0 && isfinite(foot) && isfinite(other_foot)))
        return false;
    const double h = sqrt(height * other_height), s = h / height, t = h / other_height,
                 area = (faces_area(faces, one->face) + faces_area(faces, other->face)) / 3;
    const double w[FIT_CORNERS] = {-s * (1 - foot) - t * (1 - other_foot),
                                   -s * foot - t * other_foot, s, t};
    *element = (struct fit_element){{one->end[0], one->end[1], one->apex, other->apex}, {0}};
    fit_element_add(element, scale * area, w);
    return true;
}

static struct error *add_bends(struct fit_surface *surface, const struct faces *faces,
                               double smooth)
{
    struct edge *edge = NULL;
    struct error *err = list_edges(faces, &edge);
    for (size_t i = 0; i + 1 < 3 * faces->count && !err; i++)
        surface->count += bend(faces, &edge[i], &edge[i + 1], smooth / surface->area,
                               &surface->element[surface->count]);
    free(edge);
    return err;
}

/* The weights of a sample's corners, and which they are. */
static const int32_t *corners(const struct faces *faces, const struct fit_samples *samples,
                              size_t i, double w[FIT_CORNERS])
{
    for (size_t c = 0; c < 3; c++)
        w[c] = (double)samples->weight[3 * i + c];
    w[3] = 0;
    return faces->vertex + 3 * (size_t)samples->face[i];
}

/* An element a face, empty. */
static void start_faces(struct fit_surface *surface, const struct faces *faces)
{
    for (size_t i = 0; i < faces->count; i++) {
        const int32_t *v = faces->vertex + 3 * i;
        surface->element[i] = (struct fit_element){{v[0], v[1], v[2], v[0]}, {0}};
    }
    surface->count = faces->count;
}

struct error *fit_surface_make(struct fit_surface *surface, const struct faces *faces,
                               const struct fit_samples *samples, double smooth)
{
    *surface = (struct fit_surface){0};
    struct error *err = array_create(&surface->element, (smooth > 0 ? 4 : 1) * faces->count,
                                     sizeof *surface->element);
    if (err)
        return err;
    for (size_t i = 0; i < samples->count; i++)
        surface->area += samples->used[i] ? (double)samples->area[i] : 0;
    if (!(surface->area > 0) || !isfinite(surface->area))
        return error_new("no sample has both a value and an area");
    start_faces(surface, faces);
    for (size_t i = 0; i < samples->count; i++) {
        double w[FIT_CORNERS];
        corners(faces, samples, i, w);
        if (samples->used[i])
            fit_element_add(&surface->element[samples->face[i]],
                            (double)samples->area[i] / surface->area, w);
    }
    return smooth > 0 ? add_bends(surface, faces, smooth) : NULL;
}

void fit_surface_clear(struct fit_surface *surface)
{
    free(surface->element);
    *surface = (struct fit_surface){0};
}

void fit_surface_right(const struct fit_surface *surface, const struct faces *faces,
                       const struct fit_samples *samples, const float *value, size_t stride,
                       double *right)
{
    for (size_t i = 0; i < faces->vertices; i++)
        right[i] = 0;
    for (size_t i = 0; i < samples->count; i++) {
        double w[FIT_CORNERS];
        const int32_t *v = corners(faces, samples, i, w);
        const double scale = samples->used[i] ? (double)samples->area[i] / surface->area : 0;
        for (size_t c = 0; c < 3 && scale > 0; c++)
            right[v[c]] += scale * (w[c] * (double)value[stride * i]);
    }
}

void fit_surface_error(const struct fit_surface *surface, const struct faces *faces,
                       const struct fit_samples *samples, const float *value, size_t stride,
                       const double *x, double *error, double *all)
{
    *error = *all = 0;
    for (size_t i = 0; i < samples->count; i++) {
        double w[FIT_CORNERS];
        const int32_t *v = corners(faces, samples, i, w);
        const double scale = samples->used[i] ? (double)samples->area[i] / surface->area : 0;
        if (!(scale > 0))
            continue;
        const double f = (double)value[stride * i],
                     off = w[0] * x[v[0]] + w[1] * x[v[1]] + w[2] * x[v[2]] - f;
        *error += scale * (off * off);
        *all += scale * (f * f);
    }
}
