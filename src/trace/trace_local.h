/* SPDX-License-Identifier: Apache-2.0 */
/* trace_local: rays in local float coordinates, for trace.c and path.c. */
#ifndef TRACE_LOCAL_H
#define TRACE_LOCAL_H

#include "scene/scene_shade.h"
#include "topology/solids.h"
#include "trace/trace.h"

#include <embree3/rtcore.h>
#include <float.h>

/* An instance of the scene as Embree has it. */
struct trace_geometry {
    const float *vertex; /* 3 a vertex: local coordinates, or the mesh's own where `placed` */
    const uint32_t *index;
    const float *uv; /* the mesh's, or NULL; and so are: */
    const float *emission_uv;
    const uint16_t *colour;
    const int32_t *material; /* by triangle, into: */
    const struct scene_material *materials;
    bool placed;         /* by an Embree instance, with: */
    float transform[12]; /* the mesh's own coordinates to local, rows of a 3x4 matrix */
    bool mirrored;       /* the front side is clockwise in local coordinates */
};

struct tracer {
    const struct scene *scene;
    struct vec3 centre;  /* world coordinates of the local origin */
    double scale;        /* local length of a world unit: a power of two */
    double extent;       /* of the scene: its largest local coordinate, at least 1 */
    struct tracer *next; /* the same about another centre (frames.h); owned; NULL: no more */
    struct once *awake;  /* what follows was made; owned; NULL: it always is */
    struct once *solid;  /* solids were made; owned, by the first */
    struct scene_solids solids;
    double reach; /* what the radius of trace_distance's query is to be multiplied with */
    RTCDevice device;
    RTCScene embree;
    struct trace_geometry *geometry; /* by instance of the scene */
    float **vertices;                /* owned buffers: by instance, then by mesh */
    /* by mesh: scenes of meshes that are placed many times, or NULL */
    RTCScene *parts;
    bool has_alpha;  /* some surface lets rays through */
    bool has_colour; /* some mesh's vertices have colours */
};

/* What an Embree query carries for the filters of trace.c. */
struct trace_query {
    struct RTCIntersectContext context; /* first: Embree hands its address on */
    const struct tracer *tracer;
    uint32_t salt;
    /* blended surfaces count where their transparency is below this; NaN: by chance, with the
     * salt */
    float opaque;
};

/* A ray in local coordinates. salt: which rays a blended surface lets through: another number,
 * another choice. */
struct trace_ray {
    struct vec3f origin, direction;
    float most;
    uint32_t salt;
};

/* A point of a surface in local coordinates. */
struct trace_point {
    struct vec3f position;
    struct vec3f normal; /* of the front side, unit */
    float distance;      /* along the ray */
    bool front;
    uint32_t instance, triangle;
    float b, c; /* barycentric weights of the mesh's corners 1 and 2 */
    /* Set by trace_point_shade: */
    float u, v; /* texture coordinates */
    const struct scene_material *material;
};

/* Texture coordinates between those of a triangle's corners. */
static inline void trace_uv(const float *uv, const struct trace_point *point, float *u, float *v)
{
    const float a = 1 - point->b - point->c, *corner = uv + 6 * (size_t)point->triangle;
    *u = a * corner[0] + point->b * corner[2] + point->c * corner[4];
    *v = a * corner[1] + point->b * corner[3] + point->c * corner[5];
}

/* Sets the material and the texture coordinates of a point. trace_rays_nearest has sent for them:
 * what is done between the two hides the way to memory. */
static inline void trace_point_shade(const struct tracer *tracer, struct trace_point *point)
{
    const struct trace_geometry *g = &tracer->geometry[point->instance];
    point->material = g->materials + g->material[point->triangle];
    point->u = point->v = 0;
    if (point->material->textured && g->uv)
        trace_uv(g->uv, point, &point->u, &point->v);
}

/* The colour of the vertices at a point: linear RGB and alpha; 1 where they have none. */
static inline void trace_point_tint(const struct tracer *tracer, const struct trace_point *point,
                                    float rgba[4])
{
    const struct trace_geometry *g = &tracer->geometry[point->instance];
    if (g->colour)
        scene_tint(g->colour, g->index + 3 * (size_t)point->triangle, point->b, point->c, rgba);
    else
        rgba[0] = rgba[1] = rgba[2] = rgba[3] = 1;
}

/* Of a shaded point: the share of light that passes, and the radiance that its material emits. */
static inline float trace_point_transparency(const struct tracer *tracer,
                                             const struct trace_point *point)
{
    if (!tracer->has_colour)
        return scene_transparency(tracer->scene, point->material, point->u, point->v);
    float rgba[4];
    trace_point_tint(tracer, point, rgba);
    return scene_transparency_tinted(tracer->scene, point->material, rgba[3], point->u, point->v);
}

/* The share of light that it scatters, too. */
static inline struct vec3f trace_point_albedo(const struct tracer *tracer,
                                              const struct trace_point *point)
{
    if (!tracer->has_colour)
        return scene_albedo(tracer->scene, point->material, point->u, point->v);
    float rgba[4];
    trace_point_tint(tracer, point, rgba);
    return scene_albedo_tinted(tracer->scene, point->material,
                               (struct vec3f){rgba[0], rgba[1], rgba[2]}, point->u, point->v);
}

static inline struct vec3f trace_point_emission(const struct tracer *tracer,
                                                const struct trace_point *point)
{
    const float *uv = tracer->geometry[point->instance].emission_uv;
    float u = point->u, v = point->v;
    if (uv && point->material->emission_map.texture != SCENE_NONE)
        trace_uv(uv, point, &u, &v);
    return scene_emission(tracer->scene, point->material, u, v);
}

/* -- waves ------------------------------------------------------------------------------------ */

/* Rays that go together: component by component, so that one instruction works on several of
 * them. */
enum { TRACE_WAVE = 64 };

/* Of functions that loop over a wave. Embree runs nowhere without AVX; without fused operations,
 * which these are not, its results are the same bits as any other instruction's. */
#define TRACE_VECTORS __attribute__((target("avx")))

struct wave_vec {
    float x[TRACE_WAVE], y[TRACE_WAVE], z[TRACE_WAVE];
};

static inline struct vec3f wave_get(const struct wave_vec *v, size_t i)
{
    return (struct vec3f){v->x[i], v->y[i], v->z[i]};
}

static inline void wave_put(struct wave_vec *v, size_t i, struct vec3f a)
{
    v->x[i] = a.x, v->y[i] = a.y, v->z[i] = a.z;
}

/* As trace_ray and trace_point, but that a point may be none: hit is 1 or 0, and then distance is
 * INFINITY and the rest has no meaning. */
struct trace_rays {
    struct wave_vec origin, direction;
    float most[TRACE_WAVE];
    uint32_t salt[TRACE_WAVE];
};

struct trace_points {
    struct wave_vec position, normal;
    float distance[TRACE_WAVE];
    int32_t hit[TRACE_WAVE], front[TRACE_WAVE];
    uint32_t instance[TRACE_WAVE], triangle[TRACE_WAVE];
    float b[TRACE_WAVE], c[TRACE_WAVE];
    const struct scene_material *material[TRACE_WAVE];
    float u[TRACE_WAVE], v[TRACE_WAVE];
    struct wave_vec tint; /* of their vertices; set where the tracer has_colour alone */
};

/* Nearest surfaces of the first `count` rays, shaded. */
void trace_rays_nearest(const struct tracer *tracer, size_t count, const struct trace_rays *rays,
                        struct trace_points *points);

/* Makes seen 0 where anything is on the way of a ray; rays whose seen is 0 are not traced. */
void trace_rays_occluded(const struct tracer *tracer, size_t count, const struct trace_rays *rays,
                         int32_t *seen);

/* The albedo of a point that was hit. */
static inline struct vec3f trace_albedo(const struct tracer *tracer,
                                        const struct trace_points *points, size_t i)
{
    const struct scene_material *m = points->material[i];
    return tracer->has_colour ? scene_albedo_tinted(tracer->scene, m, wave_get(&points->tint, i),
                                                    points->u[i], points->v[i])
                              : scene_albedo(tracer->scene, m, points->u[i], points->v[i]);
}

/* -- points ----------------------------------------------------------------------------------- */

/* Of a tracer and those that follow it, the one whose centre is nearest to p: local coordinates of
 * what is seen from there are to be its. It is built now, if nobody was there before. */
struct error *trace_find_near(const struct tracer *tracer, const double p[3],
                              const struct tracer **near);

/* The same, or, where that one cannot be built, the first. */
const struct tracer *trace_near(const struct tracer *tracer, const double p[3]);

struct vec3f trace_to_local(const struct tracer *tracer, const double world[3]);
struct vec3 trace_to_world(const struct tracer *tracer, struct vec3f local);

/* The instance of the scene that a candidate of a point query belongs to. */
static inline uint32_t trace_candidate(const struct RTCPointQueryFunctionArguments *args)
{
    const uint32_t placed = args->context->instStackSize ? args->context->instID[0]
                                                         : RTC_INVALID_GEOMETRY_ID;
    return placed != RTC_INVALID_GEOMETRY_ID ? placed : args->geomID;
}

/* Corners of a triangle, counter-clockwise seen from the front. */
void trace_corners(const struct tracer *tracer, uint32_t instance, uint32_t triangle,
                   struct vec3f corner[3]);

/* A point of a triangle: (1-b-c) corner 0 + b corner 1 + c corner 2, of the mesh. Sets all but
 * distance and front, shaded. */
void trace_point_at(const struct tracer *tracer, uint32_t instance, uint32_t triangle, float b,
                    float c, struct trace_point *point);

/* Whether anything is on the way of the ray. Blended surfaces let it through with probability 1 -
 * alpha. */
bool trace_local_occluded(const struct tracer *tracer, const struct trace_ray *ray);

/* Where the rays of an eye at p (world) start: at p, or, where floats cannot tell p from a surface,
 * just off it: on p's side; before its front, where p is on it; on the side of `normal`, where that
 * is given (unit; zero: none) and the surface's own. */
struct vec3f trace_start(const struct tracer *tracer, const double p[3], struct vec3f normal);

/* A surface nearer to p than this, in local units, is one that p lies in: nobody knows how far
 * trace_start left it behind, nor on which side p was meant to be. */
float trace_start_room(const struct tracer *tracer, const double p[3]);

/* Where a ray starts that leaves a surface's point, met at `distance`, to the side of `normal`
 * (unit; either sign of the surface's). */
static inline struct vec3f trace_leave(struct vec3f position, float distance, struct vec3f normal)
{
    const float size = float_most(float_most(fabsf(position.x), fabsf(position.y)),
                                  float_most(fabsf(position.z), distance));
    return vec3f_fma(position, 4 * FLT_EPSILON * size, normal);
}

#endif
