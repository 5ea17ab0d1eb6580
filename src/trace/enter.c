/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/enter.h"
#include "trace/trace_local.h"

#include <float.h>
#include <math.h>

/* fmin and fmax that are no calls: millions of triangles are asked for. */
static inline double least(double a, double b)
{
    return a < b ? a : b;
}

static inline double most(double a, double b)
{
    return a > b ? a : b;
}

/* How far floats of rays and surfaces may be off, of the largest coordinate. */
static const double slack = 16 * (double)FLT_EPSILON;

struct cell {
    const struct tracer *tracer;
    int count;
    struct vec3 corner[4], edge[6]; /* local coordinates */
    int edges, facets;
    struct vec3 facet[4]; /* normals, of any length */
    struct vec3 low, high;
    double size; /* the largest coordinate */
    trace_enter_visit *visit;
    void *context;
    bool entered, done;
};

/* -- separating axes -------------------------------------------------------------------------- */

struct range {
    double low, high;
};

static inline struct range range_of(struct vec3 axis, int count, const struct vec3 *corner)
{
    const double first = vec3_dot(axis, corner[0]);
    struct range r = {first, first};
    for (int i = 1; i < count; i++) {
        const double x = vec3_dot(axis, corner[i]);
        r.low = x < r.low ? x : r.low;
        r.high = x > r.high ? x : r.high;
    }
    return r;
}

static inline bool separates(const struct cell *c, const struct vec3 triangle[3], double gap,
                             struct vec3 axis)
{
    const struct range a = range_of(axis, c->count, c->corner), b = range_of(axis, 3, triangle);
    const double apart = most(a.low - b.high, b.low - a.high);
    return apart > gap * (fabs(axis.x) + fabs(axis.y) + fabs(axis.z));
}

static bool boxes_part(const struct cell *c, const struct vec3 t[3], double gap)
{
    return most(t[0].x, most(t[1].x, t[2].x)) < c->low.x - gap ||
           most(t[0].y, most(t[1].y, t[2].y)) < c->low.y - gap ||
           most(t[0].z, most(t[1].z, t[2].z)) < c->low.z - gap ||
           least(t[0].x, least(t[1].x, t[2].x)) > c->high.x + gap ||
           least(t[0].y, least(t[1].y, t[2].y)) > c->high.y + gap ||
           least(t[0].z, least(t[1].z, t[2].z)) > c->high.z + gap;
}

/* Of cells that are flat some axes are not tried: then what is near them may count. */
static bool are_apart(const struct cell *c, const struct vec3 triangle[3], double gap)
{
    if (boxes_part(c, triangle, gap))
        return true;
    const struct vec3 side[3] = {vec3_sub(triangle[1], triangle[0]),
                                 vec3_sub(triangle[2], triangle[1]),
                                 vec3_sub(triangle[0], triangle[2])};
    if (separates(c, triangle, gap, vec3_cross(side[0], side[1])))
        return true;
    for (int i = 0; i < c->facets; i++)
        if (separates(c, triangle, gap, c->facet[i]))
            return true;
    for (int i = 0; i < c->edges; i++)
        for (int k = 0; k < 3; k++)
            if (separates(c, triangle, gap, vec3_cross(c->edge[i], side[k])))
                return true;
    return false;
}

/* -- the query -------------------------------------------------------------------------------- */

static bool try_candidate(struct RTCPointQueryFunctionArguments *args)
{
    struct cell *c = args->userPtr;
    struct trace_entering entering = {.instance = trace_candidate(args), .triangle = args->primID};
    struct vec3f corner[3];
    struct vec3 *t = entering.corner;
    double size = c->size;
    if (c->done)
        return false;
    trace_corners(c->tracer, entering.instance, entering.triangle, corner);
    for (int k = 0; k < 3; k++) {
        t[k] = (struct vec3){(double)corner[k].x, (double)corner[k].y, (double)corner[k].z};
        size = most(size, most(fabs(t[k].x), most(fabs(t[k].y), fabs(t[k].z))));
    }
    if (are_apart(c, t, slack * size))
        return false;
    c->entered = true;
    for (int k = 0; k < 3; k++)
        t[k] = vec3_scale(1 / c->tracer->scale, vec3_sub(t[k], c->corner[0]));
    c->done = !c->visit || !c->visit(c->context, &entering);
    if (c->done)
        args->query->radius = 0;
    return c->done;
}

static void add_corners(struct cell *c, int count, const double *const point[])
{
    const struct tracer *t = c->tracer;
    c->count = count;
    for (int i = 0; i < count; i++) {
        const struct vec3 p = vec3_scale(t->scale, vec3_sub(vec3_load(point[i]), t->centre));
        c->corner[i] = p;
        c->low = i ? (struct vec3){fmin(c->low.x, p.x), fmin(c->low.y, p.y), fmin(c->low.z, p.z)}
                   : p;
        c->high =
            i ? (struct vec3){fmax(c->high.x, p.x), fmax(c->high.y, p.y), fmax(c->high.z, p.z)} : p;
        for (int k = 0; k < i; k++)
            c->edge[c->edges++] = vec3_sub(p, c->corner[k]);
        c->size = fmax(c->size, fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))));
    }
    for (int i = 0; count == 4 && i < 4; i++) {
        const struct vec3 a = c->corner[i], b = c->corner[(i + 1) % 4], d = c->corner[(i + 2) % 4];
        c->facet[c->facets++] = vec3_cross(vec3_sub(b, a), vec3_sub(d, a));
    }
    if (count == 3)
        c->facet[c->facets++] = vec3_cross(c->edge[0], c->edge[1]);
}

bool trace_enter(const struct tracer *tracer, int count, const double *const point[],
                 trace_enter_visit *visit, void *context)
{
    const struct tracer *t = trace_near(tracer, point[0]);
    struct cell c = {.tracer = t, .visit = visit, .context = context};
    double far = 0;
    add_corners(&c, count, point);
    const struct vec3 middle = vec3_scale(0.5, vec3_add(c.low, c.high));
    for (int i = 0; i < count; i++)
        far = fmax(far, vec3_length(vec3_sub(c.corner[i], middle)));
    struct RTCPointQuery query = {
        .x = (float)middle.x,
        .y = (float)middle.y,
        .z = (float)middle.z,
        .radius = (float)(t->reach * (far * (1 + 1e-5) + 4 * slack * fmax(c.size, 1)))};
    struct RTCPointQueryContext about;
    rtcInitPointQueryContext(&about);
    rtcPointQuery(t->embree, &query, &about, try_candidate, &c);
    return c.entered;
}
