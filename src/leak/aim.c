/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Sutherland and Hodgman, "Reentrant polygon clipping", CACM 17, 1974. */
#include "leak/aim.h"
#include "trace/enter.h"

#include <math.h>

enum { SIDES_MOST = 7 }; /* of a triangle that four planes cut */

struct search {
    struct vec3 reciprocal[3]; /* barycentric coordinates of a way from the eye, by its product */
    struct aim *aim;
    int count;
};

/* Barycentric coordinates: [3] is the eye's. */
struct corner {
    double b[4];
};

/* What of the polygon is on the inner side of the facet opposite corner k. */
static int clip(int sides, const struct corner *in, int k, struct corner *out)
{
    int count = 0;
    for (int i = 0; i < sides; i++) {
        const struct corner *a = &in[i], *b = &in[(i + 1) % sides];
        if (a->b[k] >= 0)
            out[count++] = *a;
        if ((a->b[k] >= 0) == (b->b[k] >= 0))
            continue;
        const double t = a->b[k] / (a->b[k] - b->b[k]);
        for (int j = 0; j < 4; j++)
            out[count].b[j] = j == k ? 0 : a->b[j] + t * (b->b[j] - a->b[j]);
        count++;
    }
    return count;
}

/* The polygon as the eye sees it on the facet: its middle and its share. false: it is none. */
static bool project(int sides, const struct corner *corner, struct aim *aim)
{
    double u[SIDES_MOST][3], area = 0;
    for (int i = 0; i < sides; i++) {
        const double sum = corner[i].b[0] + corner[i].b[1] + corner[i].b[2];
        if (!(sum > 1e-9))
            return false;
        for (int k = 0; k < 3; k++) {
            u[i][k] = fmax(corner[i].b[k], 0) / sum;
            aim->u[k] += u[i][k] / sides;
        }
    }
    for (int i = 0; i < sides; i++) {
        const double *p = u[i], *q = u[(i + 1) % sides];
        area += p[0] * q[1] - p[1] * q[0];
    }
    aim->share = fabs(area);
    return aim->share > 1e-6;
}

/* Larger ones first; which come first does not depend on the order in which they are found. */
static bool precedes(const struct aim *a, const struct aim *b)
{
    if (a->share != b->share)
        return a->share > b->share;
    return a->instance != b->instance ? a->instance < b->instance : a->triangle < b->triangle;
}

static bool add(void *context, const struct trace_entering *entering)
{
    struct search *s = context;
    struct corner polygon[2][SIDES_MOST];
    struct aim aim = {.instance = entering->instance, .triangle = entering->triangle};
    int sides = 3;
    for (int i = 0; i < 3; i++) {
        struct corner *c = &polygon[0][i];
        c->b[3] = 1;
        for (int k = 0; k < 3; k++) {
            c->b[k] = vec3_dot(s->reciprocal[k], entering->corner[i]);
            c->b[3] -= c->b[k];
        }
    }
    for (int k = 0; k < 4; k++)
        sides = clip(sides, polygon[k % 2], k, polygon[(k + 1) % 2]);
    if (sides < 3 || !project(sides, polygon[0], &aim))
        return true;
    int at = s->count;
    while (at > 0 && precedes(&aim, &s->aim[at - 1]))
        at--;
    if (at == AIM_MOST)
        return true;
    s->count += s->count < AIM_MOST;
    for (int i = s->count - 1; i > at; i--)
        s->aim[i] = s->aim[i - 1];
    s->aim[at] = aim;
    return true;
}

int aim_find(struct aim aim[AIM_MOST], const struct tracer *tracer, const double *const corner[4])
{
    struct search s = {.aim = aim};
    const struct vec3 eye = vec3_load(corner[0]), a = vec3_sub(vec3_load(corner[1]), eye),
                      b = vec3_sub(vec3_load(corner[2]), eye),
                      c = vec3_sub(vec3_load(corner[3]), eye);
    const double volume = vec3_dot(a, vec3_cross(b, c));
    if (volume == 0)
        return 0;
    s.reciprocal[0] = vec3_scale(1 / volume, vec3_cross(b, c));
    s.reciprocal[1] = vec3_scale(1 / volume, vec3_cross(c, a));
    s.reciprocal[2] = vec3_scale(1 / volume, vec3_cross(a, b));
    trace_enter(tracer, 4, corner, add, &s);
    return s.count;
}
