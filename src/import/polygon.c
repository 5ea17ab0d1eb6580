/* SPDX-License-Identifier: Apache-2.0 */
#include "import/polygon.h"
#include "base/array.h"
#include "base/error.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* How choosy the search for an ear is; it is lowered when a round of the polygon finds none. */
enum pickiness {
    EAR_CLEAN,   /* turns left, with no corner inside or on its border */
    EAR_ALLOWED, /* does not turn right, with no corner inside */
    EAR_ANY,     /* of a polygon that crosses itself, or costs too much to look at */
};

/* Corners looked at before a polygon (of many thousand corners, most of them hollow) is cut as it
 * comes. */
static const size_t looks_most = 1000000000;

struct error *polygon_room_for(struct polygon_room *room, size_t n)
{
    if (n <= room->capacity)
        return NULL;
    if (n > UINT32_MAX)
        return error_new("a polygon of %zu corners", n);
    polygon_room_clear(room);
    struct error *err = array_create(&room->corner, 3 * n, sizeof *room->corner);
    if (!err)
        err = array_create(&room->triangle, 3 * n, sizeof *room->triangle);
    if (!err)
        err = array_create(&room->plane, 2 * n, sizeof *room->plane);
    if (!err)
        err = array_create(&room->next, n, sizeof *room->next);
    if (!err)
        err = array_create(&room->previous, n, sizeof *room->previous);
    if (!err)
        err = array_create(&room->bent, n, sizeof *room->bent);
    if (err)
        polygon_room_clear(room);
    else
        room->capacity = n;
    return err;
}

void polygon_room_clear(struct polygon_room *room)
{
    free(room->corner);
    free(room->triangle);
    free(room->plane);
    free(room->next);
    free(room->previous);
    free(room->bent);
    *room = (struct polygon_room){0};
}

/* Projects the corners so that the polygon turns left; false when it has no area. *least is what
 * counts as none. */
static bool project(struct polygon_room *room, size_t n, double *least)
{
    const double *p = room->corner;
    double area[3] = {0}, size = 0;
    for (size_t i = 1; i + 1 < n; i++) {
        const double *a = p + 3 * i, *b = a + 3;
        const double e[3] = {a[0] - p[0], a[1] - p[1], a[2] - p[2]},
                     f[3] = {b[0] - p[0], b[1] - p[1], b[2] - p[2]};
        for (int k = 0; k < 3; k++)
            area[k] += e[(k + 1) % 3] * f[(k + 2) % 3] - e[(k + 2) % 3] * f[(k + 1) % 3];
    }
    int axis = fabs(area[0]) > fabs(area[1]) ? 0 : 1;
    axis = fabs(area[2]) > fabs(area[axis]) ? 2 : axis;
    if (!(fabs(area[axis]) > 0 && isfinite(area[axis])))
        return false;
    const int x = area[axis] > 0 ? (axis + 1) % 3 : (axis + 2) % 3, y = 3 - axis - x;
    for (size_t i = 0; i < n; i++) {
        room->plane[2 * i] = p[3 * i + (size_t)x] - p[x];
        room->plane[2 * i + 1] = p[3 * i + (size_t)y] - p[y];
        size = fmax(size, fmax(fabs(room->plane[2 * i]), fabs(room->plane[2 * i + 1])));
    }
    *least = 1e-12 * size * size;
    return true;
}

/* Twice the signed area of a triangle of corners. */
static double turn(const struct polygon_room *room, uint32_t a, uint32_t b, uint32_t c)
{
    const double *p = room->plane + 2 * (size_t)a, *q = room->plane + 2 * (size_t)b,
                 *r = room->plane + 2 * (size_t)c;
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
}

static bool same_place(const struct polygon_room *room, uint32_t a, uint32_t b)
{
    const double *p = room->plane + 2 * (size_t)a, *q = room->plane + 2 * (size_t)b;
    return p[0] == q[0] && p[1] == q[1];
}

/* Whether the corner i can be cut off. Only corners that are straight or hollow (not bent) can
 * stand in the way. */
static bool is_ear(const struct polygon_room *room, uint32_t i, enum pickiness pickiness,
                   double least, size_t *looks)
{
    const uint32_t a = room->previous[i], c = room->next[i];
    const double margin = pickiness == EAR_CLEAN ? -least : least;
    if (pickiness == EAR_ANY)
        return true;
    if (pickiness == EAR_CLEAN ? !room->bent[i] : !(turn(room, a, i, c) >= -least))
        return false;
    for (uint32_t j = room->next[c]; j != a; j = room->next[j]) {
        ++*looks;
        if (!room->bent[j] && turn(room, a, i, j) >= margin && turn(room, i, c, j) >= margin &&
            turn(room, c, a, j) >= margin && !same_place(room, j, a) && !same_place(room, j, i) &&
            !same_place(room, j, c))
            return false;
    }
    return true;
}

static void mark_bent(struct polygon_room *room, uint32_t i, double least)
{
    room->bent[i] = turn(room, room->previous[i], i, room->next[i]) > least;
}

static void emit(uint32_t *triangle, uint32_t a, uint32_t b, uint32_t c)
{
    triangle[0] = a;
    triangle[1] = b;
    triangle[2] = c;
}

void polygon_split(struct polygon_room *room, size_t n)
{
    uint32_t *triangle = room->triangle;
    double least = 0;
    if (n == 3 || !project(room, n, &least)) {
        for (uint32_t i = 1; i + 1 < n; i++, triangle += 3)
            emit(triangle, 0, i, i + 1);
        return;
    }
    const uint32_t last = (uint32_t)(n - 1);
    for (uint32_t i = 0; i <= last; i++) {
        room->next[i] = i == last ? 0 : i + 1;
        room->previous[i] = i == 0 ? last : i - 1;
    }
    for (uint32_t i = 0; i <= last; i++)
        mark_bent(room, i, least);

    uint32_t i = 1; /* so that a convex polygon becomes a fan around its first corner */
    size_t looks = 0;
    enum pickiness pickiness = EAR_CLEAN;
    for (size_t left = n, missed = 0; left > 3;) {
        if (looks > looks_most)
            pickiness = EAR_ANY;
        if (!is_ear(room, i, pickiness, least, &looks)) {
            i = room->next[i];
            if (++missed == left) {
                missed = 0;
                pickiness++;
            }
            continue;
        }
        const uint32_t a = room->previous[i], c = room->next[i];
        emit(triangle, a, i, c);
        triangle += 3;
        room->next[a] = c;
        room->previous[c] = a;
        mark_bent(room, a, least);
        mark_bent(room, c, least);
        i = c;
        left--;
        missed = 0;
        pickiness = EAR_CLEAN;
    }
    emit(triangle, room->previous[i], i, room->next[i]);
}
