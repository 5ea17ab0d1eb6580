/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/trace.h"
#include "base/array.h"
#include "base/error.h"
#include "base/once.h"
#include "math/affine.h"
#include "math/box.h"
#include "trace/frames.h"
#include "scene/scene_shade.h"
#include "trace/trace_local.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- making ----------------------------------------------------------------------------------- */

static double largest(struct vec3 a)
{
    return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
}

/* The map from the mesh's coordinates to local ones, in double. */
static void local_transform(const struct tracer *t, const struct scene_instance *instance,
                            double m[12])
{
    const double centre[3] = {t->centre.x, t->centre.y, t->centre.z};
    for (int row = 0; row < 3; row++) {
        for (int k = 0; k < 3; k++)
            m[4 * row + k] = instance->transform[4 * row + k] * t->scale;
        m[4 * row + 3] = (instance->transform[4 * row + 3] - centre[row]) * t->scale;
    }
}

/* Vertices of a mesh under a transform; Embree reads 16 bytes at a time, so one more float is
 * there. */
static struct error *make_vertices(const struct scene_mesh *mesh, const double m[12],
                                   float **vertex)
{
    struct error *err = array_create(vertex, 3 * mesh->vertex_count + 1, sizeof **vertex);
    for (size_t i = 0; i < mesh->vertex_count && !err; i++) {
        const struct vec3 p = affine_point(m, mesh->position + 3 * i);
        (*vertex)[3 * i] = (float)p.x;
        (*vertex)[3 * i + 1] = (float)p.y;
        (*vertex)[3 * i + 2] = (float)p.z;
    }
    return err;
}

static bool mesh_has_alpha(const struct scene *scene, const struct scene_mesh *mesh)
{
    for (size_t i = 0; i < mesh->triangle_count; i++)
        if (scene->materials[mesh->material[i]].alpha != SCENE_OPAQUE)
            return true;
    return false;
}

/* A number in [0, 1) for a ray and a triangle: the same however often and in whatever order Embree
 * asks. */
static float chance(uint32_t salt, uint32_t instance, uint32_t triangle)
{
    /* mixed as in MurmurHash3 */
    uint32_t h = salt ^ (instance * 0x9e3779b9u) ^ (triangle * 0x85ebca6bu);
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    h ^= h >> 16;
    return (float)(h >> 8) * 0x1p-24f;
}

/* Rejects a hit where the surface lets the ray through. */
static void filter(const struct RTCFilterFunctionNArguments *args)
{
    const struct trace_query *query = (const struct trace_query *)args->context;
    /* N is 1: single rays alone are traced */
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    const uint32_t instance = hit->instID[0] != RTC_INVALID_GEOMETRY_ID ? hit->instID[0]
                                                                        : hit->geomID;
    struct trace_point point = {
        .instance = instance, .triangle = hit->primID, .b = hit->u, .c = hit->v};
    trace_point_shade(query->tracer, &point);
    const float through = trace_point_transparency(query->tracer, &point);
    const float limit = isnan(query->opaque) ? 1 - chance(query->salt, instance, hit->primID)
                                             : query->opaque;
    if (through >= limit)
        args->valid[0] = 0;
}

static RTCGeometry triangle_geometry(const struct tracer *t, const struct scene_mesh *mesh,
                                     const float *vertex)
{
    RTCGeometry geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertex, 0,
                               3 * sizeof(float), mesh->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->index, 0,
                               3 * sizeof(uint32_t), mesh->triangle_count);
    if (mesh_has_alpha(t->scene, mesh)) {
        rtcSetGeometryIntersectFilterFunction(geometry, filter);
        rtcSetGeometryOccludedFilterFunction(geometry, filter);
    }
    rtcCommitGeometry(geometry);
    return geometry;
}

static RTCScene new_scene(const struct tracer *t)
{
    RTCScene scene = rtcNewScene(t->device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    return scene;
}

/* Embree 3.13.5 takes the radius of a point query into an instance as it is where it should grow:
 * where the instance is smaller than its mesh. So trace_distance searches as far as the smallest
 * instance needs: 1 / its least singular value times as far, at most |M|^2 / (2 |det M|),
 * Frobenius' norm, since the other two have a product of at most |M|^2 / 2. */
static double instance_reach(const double m[12])
{
    double square = 0;
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++)
            square += m[4 * row + k] * m[4 * row + k];
    const double volume = fabs(affine_determinant(m));
    return volume > 0 ? fmin(square / (2 * volume), 1e6) : 1;
}

/* A mesh that is placed many times: a scene of its own, made once, about the mesh's own centre. */
static struct error *add_placed(struct tracer *t, size_t i)
{
    const size_t mesh_index = t->scene->instances[i].mesh;
    const struct scene_mesh *mesh = &t->scene->meshes[mesh_index];
    struct trace_geometry *g = &t->geometry[i];
    const struct box box = box_of(mesh->vertex_count, mesh->position);
    double centre[3], m[12];
    for (int k = 0; k < 3; k++)
        centre[k] = mesh->vertex_count ? box.low[k] / 2 + box.high[k] / 2 : 0;
    float **vertex = &t->vertices[t->scene->instance_count + mesh_index];
    if (!t->parts[mesh_index]) {
        const double shift[12] = {1, 0, 0, -centre[0], 0, 1, 0, -centre[1], 0, 0, 1, -centre[2]};
        struct error *err = make_vertices(mesh, shift, vertex);
        if (err)
            return err;
        t->parts[mesh_index] = new_scene(t);
        RTCGeometry geometry = triangle_geometry(t, mesh, *vertex);
        rtcAttachGeometryByID(t->parts[mesh_index], geometry, 0);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(t->parts[mesh_index]);
    }
    local_transform(t, &t->scene->instances[i], m);
    t->reach = fmax(t->reach, instance_reach(m));
    g->vertex = *vertex;
    g->placed = true;
    for (int row = 0; row < 3; row++) {
        double moved = m[4 * row + 3];
        for (int k = 0; k < 3; k++) {
            g->transform[4 * row + k] = (float)m[4 * row + k];
            moved += m[4 * row + k] * centre[k];
        }
        g->transform[4 * row + 3] = (float)moved;
    }
    RTCGeometry geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, t->parts[mesh_index]);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, g->transform);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(t->embree, geometry, (unsigned)i);
    rtcReleaseGeometry(geometry);
    return NULL;
}

/* A mesh that is placed once: flat, in local coordinates. */
static struct error *add_flat(struct tracer *t, size_t i)
{
    const struct scene_mesh *mesh = &t->scene->meshes[t->scene->instances[i].mesh];
    double m[12];
    local_transform(t, &t->scene->instances[i], m);
    struct error *err = make_vertices(mesh, m, &t->vertices[i]);
    if (err)
        return err;
    t->geometry[i].vertex = t->vertices[i];
    RTCGeometry geometry = triangle_geometry(t, mesh, t->vertices[i]);
    rtcAttachGeometryByID(t->embree, geometry, (unsigned)i);
    rtcReleaseGeometry(geometry);
    return NULL;
}

/* The local origin and scale: the centre of a box, and the power of two that brings its largest
 * side to 1 .. 2. */
static void set_frame(struct tracer *t, const struct box *box)
{
    const struct scene *s = t->scene;
    t->scale = t->extent = 1;
    if (!(box->low[0] <= box->high[0]))
        return;
    double half = 0;
    double *const centre[3] = {&t->centre.x, &t->centre.y, &t->centre.z};
    for (int k = 0; k < 3; k++) {
        *centre[k] = box->low[k] / 2 + box->high[k] / 2;
        half = fmax(half, box->high[k] / 2 - box->low[k] / 2);
    }
    int exponent = 0;
    if (half > 0)
        frexp(half, &exponent);
    t->scale = ldexp(1, -exponent);
    t->extent = fmax(1, t->scale * fmax(largest(vec3_sub(s->box_min, t->centre)),
                                        largest(vec3_sub(s->box_max, t->centre))));
}

static struct error *build(struct tracer *t)
{
    const struct scene *scene = t->scene;
    size_t *uses = NULL;
    struct error *err = array_create(&uses, scene->mesh_count, sizeof *uses);
    if (!err)
        err = array_create(&t->geometry, scene->instance_count, sizeof *t->geometry);
    if (!err)
        err = array_create(&t->vertices, scene->instance_count + scene->mesh_count,
                           sizeof *t->vertices);
    if (!err)
        err = array_create(&t->parts, scene->mesh_count, sizeof *t->parts);
    for (size_t i = 0; i < scene->instance_count && !err; i++)
        uses[scene->instances[i].mesh]++;
    for (size_t i = 0; i < scene->instance_count && !err; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        t->geometry[i].index = mesh->index;
        t->geometry[i].uv = mesh->uv;
        t->geometry[i].emission_uv = mesh->emission_uv;
        t->geometry[i].colour = mesh->colour;
        t->geometry[i].material = mesh->material;
        t->geometry[i].materials = scene->materials;
        t->geometry[i].mirrored = affine_mirrors(scene->instances[i].transform);
        t->has_alpha = t->has_alpha || mesh_has_alpha(scene, mesh);
        t->has_colour = t->has_colour || mesh->colour;
        if (mesh->triangle_count)
            err = uses[scene->instances[i].mesh] > 1 ? add_placed(t, i) : add_flat(t, i);
    }
    free(uses);
    if (!err)
        rtcCommitScene(t->embree);
    if (!err && rtcGetDeviceError(t->device) != RTC_ERROR_NONE)
        err = error_new("Embree could not build the scene (out of memory?)");
    return err;
}

/* Makes all of a tracer but its frame. */
static struct error *wake(void *context)
{
    struct tracer *t = context;
    t->device = rtcNewDevice("isa=avx");
    if (!t->device)
        return error_new("Embree does not run on this processor: it needs AVX");
    t->embree = new_scene(t);
    return build(t);
}

static struct error *add_frame(struct tracer **tracer, const struct scene *scene,
                               const struct box *box)
{
    struct error *err = array_create(tracer, 1, sizeof **tracer);
    if (err)
        return err;
    (*tracer)->scene = scene;
    (*tracer)->reach = 1;
    set_frame(*tracer, box);
    return NULL;
}

struct error *trace_create(struct tracer **tracer, const struct scene *scene)
{
    struct frames frames = {.count = 0};
    struct tracer *last = NULL;
    *tracer = NULL;
    struct error *err = frames_find(&frames, scene);
    for (int i = 0; i < frames.count && !err; i++) {
        struct tracer **next = i ? &last->next : tracer;
        err = add_frame(next, scene, &frames.box[i]);
        last = *next;
        if (!err)
            err = i ? once_create(&last->awake) : wake(last);
    }
    if (!err)
        err = once_create(&(*tracer)->solid);
    if (err) {
        trace_destroy(*tracer);
        *tracer = NULL;
    }
    return err;
}

static struct error *find_solids(void *context)
{
    struct tracer *t = context;
    return scene_solids(t->scene, &t->solids, NULL);
}

struct error *trace_solids(const struct tracer *tracer, const struct scene_solids **solids)
{
    *solids = &tracer->solids;
    return once_do(tracer->solid, find_solids, (void *)tracer);
}

struct error *trace_find_near(const struct tracer *tracer, const double p[3],
                              const struct tracer **near)
{
    struct tracer *best = NULL; /* the first is built from the start */
    double least = vec3_length(vec3_sub(vec3_load(p), tracer->centre));
    *near = tracer;
    for (struct tracer *t = tracer->next; t; t = t->next) {
        const double distance = vec3_length(vec3_sub(vec3_load(p), t->centre));
        if (distance < least) {
            least = distance;
            best = t;
        }
    }
    if (!best)
        return NULL;
    struct error *err = once_do(best->awake, wake, best);
    if (!err)
        *near = best;
    return err;
}

const struct tracer *trace_near(const struct tracer *tracer, const double p[3])
{
    const struct tracer *near = tracer;
    if (tracer->next)
        error_destroy(trace_find_near(tracer, p, &near));
    return near;
}

void trace_destroy(struct tracer *t)
{
    if (!t)
        return;
    trace_destroy(t->next);
    if (t->embree)
        rtcReleaseScene(t->embree);
    for (size_t i = 0; t->parts && i < t->scene->mesh_count; i++)
        if (t->parts[i])
            rtcReleaseScene(t->parts[i]);
    if (t->device)
        rtcReleaseDevice(t->device);
    for (size_t i = 0; t->vertices && i < t->scene->instance_count + t->scene->mesh_count; i++)
        free(t->vertices[i]);
    free(t->geometry);
    free(t->vertices);
    free(t->parts);
    once_destroy(t->awake);
    once_destroy(t->solid);
    scene_solids_clear(&t->solids);
    free(t);
}

const struct scene *trace_scene(const struct tracer *tracer)
{
    return tracer->scene;
}

/* -- points ----------------------------------------------------------------------------------- */

struct vec3f trace_to_local(const struct tracer *t, const double world[3])
{
    return (struct vec3f){(float)((world[0] - t->centre.x) * t->scale),
                          (float)((world[1] - t->centre.y) * t->scale),
                          (float)((world[2] - t->centre.z) * t->scale)};
}

struct vec3 trace_to_world(const struct tracer *t, struct vec3f local)
{
    return (struct vec3){t->centre.x + (double)local.x / t->scale,
                         t->centre.y + (double)local.y / t->scale,
                         t->centre.z + (double)local.z / t->scale};
}

void trace_corners(const struct tracer *t, uint32_t instance, uint32_t triangle,
                   struct vec3f corner[3])
{
    const struct trace_geometry *g = &t->geometry[instance];
    const uint32_t *index = g->index + 3 * (size_t)triangle;
    for (int k = 0; k < 3; k++) {
        const float *p = g->vertex + 3 * (size_t)index[g->mirrored && k ? 3 - k : k];
        corner[k] = g->placed ? affine_pointf(g->transform, p) : (struct vec3f){p[0], p[1], p[2]};
    }
}

void trace_point_at(const struct tracer *t, uint32_t instance, uint32_t triangle, float b, float c,
                    struct trace_point *point)
{
    const float a = 1 - b - c;
    struct vec3f p[3];
    trace_corners(t, instance, triangle, p);
    /* b and c belong to the mesh's corners 1 and 2 */
    const bool mirrored = t->geometry[instance].mirrored;
    const struct vec3f p1 = p[mirrored ? 2 : 1], p2 = p[mirrored ? 1 : 2];
    point->position =
        vec3f_add(vec3f_scale(a, p[0]), vec3f_add(vec3f_scale(b, p1), vec3f_scale(c, p2)));
    point->normal = vec3f_normalize(vec3f_cross(vec3f_sub(p[1], p[0]), vec3f_sub(p[2], p[0])));
    point->instance = instance;
    point->triangle = triangle;
    point->b = b;
    point->c = c;
    trace_point_shade(t, point);
}

/* -- eyes on surfaces -------------------------------------------------------------------------- */

/* An eye that is moved off the triangles it stands on; local coordinates in double. */
struct eye {
    const struct tracer *tracer;
    struct vec3 place, start, normal;
    double most;     /* how far it may be moved: what is far is coarse, but far */
    double rounding; /* what may be between a place on a surface and the surface, in double */
};

/* How far an eye keeps off a surface, of the largest coordinate. trace_leave's 4 suffices for the
 * rays of the eye itself; beside an edge the points that they meet need room as well: of the light
 * in the corner of a box 0.6 % is lost at 4, 0.2 % at 16, 0.1 % at 32. */
static const double eye_gap = 32 * (double)FLT_EPSILON;

/* Corners of the mesh's triangle, local, in double. */
static void exact_corners(const struct tracer *t, uint32_t instance, uint32_t triangle,
                          struct vec3 corner[3])
{
    const struct scene_mesh *mesh = &t->scene->meshes[t->scene->instances[instance].mesh];
    double m[12];
    local_transform(t, &t->scene->instances[instance], m);
    for (int k = 0; k < 3; k++) {
        const double *p = mesh->position +
                          3 * (size_t)mesh->index[3 * (size_t)triangle + (size_t)k];
        corner[k] = affine_point(m, p);
    }
}

/* Moves the start off this triangle, where it is nearer than the gap. */
static void clear_triangle(struct eye *eye, uint32_t instance, uint32_t triangle)
{
    const struct tracer *t = eye->tracer;
    double size = largest(eye->place);
    struct vec3 corner[3];
    exact_corners(t, instance, triangle, corner);
    for (int k = 0; k < 3; k++)
        size = fmax(size, largest(corner[k]));
    const double gap = fmin(eye_gap * size, eye->most);
    struct vec3 n =
        vec3_normalize(vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0])));
    for (int k = 0; k < 3; k++) { /* not beyond an edge */
        const struct vec3 edge = vec3_normalize(vec3_sub(corner[(k + 1) % 3], corner[k]));
        if (vec3_dot(vec3_cross(n, edge), vec3_sub(eye->place, corner[k])) < -gap)
            return;
    }
    if (t->geometry[instance].mirrored)
        n = vec3_scale(-1, n);
    const double height = vec3_dot(n, vec3_sub(eye->place, corner[0]));
    if (fabs(height) >= gap)
        return;
    /* a smoothed normal is still on the surface's side; walls beside it have theirs */
    const double facing = vec3_dot(n, eye->normal);
    if (fabs(facing) > 0.5 ? facing < 0 : height < -eye->rounding)
        n = vec3_scale(-1, n);
    const double now = vec3_dot(n, vec3_sub(eye->start, corner[0]));
    if (now < gap)
        eye->start = vec3_fma(eye->start, gap - now, n);
}

static bool clear_candidate(struct RTCPointQueryFunctionArguments *args)
{
    clear_triangle(args->userPtr, trace_candidate(args), args->primID);
    return false; /* the radius stays */
}

float trace_start_room(const struct tracer *t, const double p[3])
{
    const struct vec3 place = vec3_scale(t->scale, vec3_sub(vec3_load(p), t->centre));
    return (float)(2 * eye_gap * fmax(1, largest(place)));
}

struct vec3f trace_start(const struct tracer *t, const double p[3], struct vec3f normal)
{
    const struct vec3 place = vec3_scale(t->scale, vec3_sub(vec3_load(p), t->centre));
    const double size =
        fmax(1, largest(place)); /* of what is near, no corner is farther out than 1 */
    struct eye eye = {.tracer = t,
                      .place = place,
                      .start = place,
                      .normal = {(double)normal.x, (double)normal.y, (double)normal.z},
                      .most = 2 * eye_gap * size,
                      .rounding = 8 * DBL_EPSILON * (size + t->scale * largest(vec3_load(p)))};
    struct RTCPointQuery query = {.x = (float)place.x,
                                  .y = (float)place.y,
                                  .z = (float)place.z,
                                  .radius = trace_start_room(t, p)};
    struct RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(t->embree, &query, &context, clear_candidate, &eye);
    return (struct vec3f){(float)eye.start.x, (float)eye.start.y, (float)eye.start.z};
}

/* -- distance --------------------------------------------------------------------------------- */

struct nearness {
    const struct tracer *tracer;
    struct vec3 place;
    double distance; /* local, to the nearest triangle so far */
};

static double distance_to_segment(struct vec3 p, struct vec3 a, struct vec3 b)
{
    const struct vec3 way = vec3_sub(b, a), to = vec3_sub(p, a);
    const double square = vec3_dot(way, way),
                 along = square > 0 ? fmin(fmax(vec3_dot(to, way) / square, 0), 1) : 0;
    return vec3_length(vec3_sub(to, vec3_scale(along, way)));
}

static double distance_to_triangle(struct vec3 p, const struct vec3 corner[3])
{
    const struct vec3 n =
        vec3_normalize(vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0])));
    double to_edges = INFINITY;
    bool above = vec3_dot(n, n) > 0;
    for (int k = 0; k < 3; k++) {
        const struct vec3 edge = vec3_sub(corner[(k + 1) % 3], corner[k]);
        above = above && vec3_dot(vec3_cross(n, edge), vec3_sub(p, corner[k])) >= 0;
        to_edges = fmin(to_edges, distance_to_segment(p, corner[k], corner[(k + 1) % 3]));
    }
    return above ? fabs(vec3_dot(n, vec3_sub(p, corner[0]))) : to_edges;
}

static bool nearer_candidate(struct RTCPointQueryFunctionArguments *args)
{
    struct nearness *n = args->userPtr;
    struct vec3 corner[3];
    exact_corners(n->tracer, trace_candidate(args), args->primID, corner);
    const double distance = distance_to_triangle(n->place, corner);
    if (!(distance < n->distance))
        return false;
    n->distance = distance;
    /* no less than rounding hides */
    args->query->radius =
        (float)(n->tracer->reach * (distance * (1 + 1e-5) + 1e-6 * fmax(1, largest(n->place))));
    return true;
}

/* To the nearest surface, no farther than `most`, both local: else INFINITY. */
static double find_nearest(const struct tracer *t, struct vec3 place, double most)
{
    struct nearness n = {.tracer = t, .place = place, .distance = most};
    struct RTCPointQuery query = {
        .x = (float)place.x,
        .y = (float)place.y,
        .z = (float)place.z,
        /* no corner is farther out than sqrt 3 times the extent */
        .radius = (float)(fmin(vec3_length(place) + 2 * t->extent,
                               most * (1 + 1e-5) + 1e-6 * fmax(1, largest(place))) *
                          t->reach)};
    struct RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(t->embree, &query, &context, nearer_candidate, &n);
    return n.distance < most ? n.distance : (double)INFINITY;
}

double trace_distance(const struct tracer *tracer, const double p[3])
{
    const struct tracer *t = trace_near(tracer, p);
    const struct vec3 place = vec3_scale(t->scale, vec3_sub(vec3_load(p), t->centre));
    return find_nearest(t, place, (double)INFINITY) / t->scale;
}

bool trace_is_near(const struct tracer *tracer, const double p[3], double distance)
{
    const struct tracer *t = trace_near(tracer, p);
    const struct vec3 place = vec3_scale(t->scale, vec3_sub(vec3_load(p), t->centre));
    return find_nearest(t, place, distance * t->scale) < (double)INFINITY;
}

/* -- rays ------------------------------------------------------------------------------------- */

static struct trace_query start_query(const struct tracer *t, uint32_t salt, float opaque)
{
    struct trace_query query = {.tracer = t, .salt = salt, .opaque = opaque};
    rtcInitIntersectContext(&query.context);
    return query;
}

/* Four at a time, as Embree reads them: a read waits for the narrower writes that it spans (5 ns a
 * ray). */
static inline void set_ray(struct RTCRay *r, struct vec3f origin, struct vec3f direction,
                           float most)
{
    typedef float four __attribute__((vector_size(16), may_alias));
    *(four *)&r->org_x = (four){origin.x, origin.y, origin.z, 0};          /* tnear */
    *(four *)&r->dir_x = (four){direction.x, direction.y, direction.z, 0}; /* time */
    r->tfar = most;
    r->mask = UINT32_MAX;
    r->id = r->flags = 0;
}

/* The instance that was hit, and its normal of the front side, of any length. Sends for what
 * trace_point_shade will read. */
static uint32_t met(const struct tracer *t, const struct RTCHit *hit, struct vec3f *normal)
{
    const uint32_t instance = hit->instID[0] != RTC_INVALID_GEOMETRY_ID ? hit->instID[0]
                                                                        : hit->geomID;
    const struct trace_geometry *g = &t->geometry[instance];
    *normal = (struct vec3f){hit->Ng_x, hit->Ng_y, hit->Ng_z};
    if (g->placed) { /* Embree's is in the mesh's own coordinates */
        struct vec3f corner[3];
        trace_corners(t, instance, hit->primID, corner);
        *normal = vec3f_cross(vec3f_sub(corner[1], corner[0]), vec3f_sub(corner[2], corner[0]));
    } else if (g->mirrored) {
        *normal = vec3f_scale(-1, *normal);
    }
    __builtin_prefetch(&g->material[hit->primID]);
    if (g->uv)
        __builtin_prefetch(g->uv + 6 * (size_t)hit->primID);
    return instance;
}

/* The point is reckoned along the ray: its error of a few ulps of max(|p|, t) is what trace_leave
 * steps over. */
static bool nearest(struct trace_query *query, const struct trace_ray *ray,
                    struct trace_point *point)
{
    struct RTCRayHit rh;
    set_ray(&rh.ray, ray->origin, ray->direction, ray->most);
    rh.hit.geomID = rh.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(query->tracer->embree, &query->context, &rh);
    if (rh.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;
    struct vec3f normal;
    point->instance = met(query->tracer, &rh.hit, &normal);
    point->normal = vec3f_normalize(normal);
    point->distance = rh.ray.tfar;
    point->position = vec3f_fma(ray->origin, rh.ray.tfar, ray->direction);
    point->front = vec3f_dot(point->normal, ray->direction) < 0;
    point->triangle = rh.hit.primID;
    point->b = rh.hit.u;
    point->c = rh.hit.v;
    return true;
}

bool trace_local_occluded(const struct tracer *tracer, const struct trace_ray *ray)
{
    struct trace_query query = start_query(tracer, ray->salt, NAN);
    struct RTCRay r;
    set_ray(&r, ray->origin, ray->direction, ray->most);
    rtcOccluded1(tracer->embree, &query.context, &r);
    return r.tfar < 0; /* Embree's mark of an occluded ray */
}

static void shade_points(const struct tracer *t, size_t count, struct trace_points *points)
{
    for (size_t i = 0; i < count; i++) {
        if (!points->hit[i])
            continue;
        struct trace_point p = {.instance = points->instance[i],
                                .triangle = points->triangle[i],
                                .b = points->b[i],
                                .c = points->c[i]};
        trace_point_shade(t, &p);
        points->material[i] = p.material;
        points->u[i] = p.u;
        points->v[i] = p.v;
    }
}

static void tint_points(const struct tracer *t, size_t count, struct trace_points *points)
{
    for (size_t i = 0; i < count; i++) {
        const struct trace_point p = {.instance = points->instance[i],
                                      .triangle = points->triangle[i],
                                      .b = points->b[i],
                                      .c = points->c[i]};
        float rgba[4];
        if (!points->hit[i])
            continue;
        trace_point_tint(t, &p, rgba);
        wave_put(&points->tint, i, (struct vec3f){rgba[0], rgba[1], rgba[2]});
    }
}

TRACE_VECTORS void trace_rays_nearest(const struct tracer *t, size_t count,
                                      const struct trace_rays *rays, struct trace_points *points)
{
    struct trace_query query = start_query(t, 0, NAN);
    for (size_t i = 0; i < count; i++) {
        struct RTCRayHit rh;
        set_ray(&rh.ray, wave_get(&rays->origin, i), wave_get(&rays->direction, i), rays->most[i]);
        rh.hit.geomID = rh.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        query.salt = rays->salt[i];
        rtcIntersect1(t->embree, &query.context, &rh);
        struct vec3f normal = {0};
        points->hit[i] = rh.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        points->distance[i] = points->hit[i] ? rh.ray.tfar : INFINITY;
        points->instance[i] = points->hit[i] ? met(t, &rh.hit, &normal) : 0;
        points->triangle[i] = rh.hit.primID;
        points->b[i] = rh.hit.u;
        points->c[i] = rh.hit.v;
        wave_put(&points->normal, i, normal);
    }
    for (size_t i = 0; i < count; i++) {
        const struct vec3f direction = wave_get(&rays->direction, i),
                           normal = vec3f_normalize(wave_get(&points->normal, i));
        wave_put(&points->normal, i, normal);
        wave_put(&points->position, i,
                 vec3f_fma(wave_get(&rays->origin, i), points->distance[i], direction));
        points->front[i] = vec3f_dot(normal, direction) < 0;
    }
    shade_points(t, count, points);
    if (t->has_colour)
        tint_points(t, count, points);
}

void trace_rays_occluded(const struct tracer *t, size_t count, const struct trace_rays *rays,
                         int32_t *seen)
{
    struct trace_query query = start_query(t, 0, NAN);
    for (size_t i = 0; i < count; i++) {
        struct RTCRay r;
        if (!seen[i])
            continue;
        set_ray(&r, wave_get(&rays->origin, i), wave_get(&rays->direction, i), rays->most[i]);
        query.salt = rays->salt[i];
        rtcOccluded1(t->embree, &query.context, &r);
        seen[i] = !(r.tfar < 0); /* Embree's mark of an occluded ray */
    }
}

struct trace_hit trace_nearest(const struct tracer *tracer, const double origin[3],
                               const double direction[3], double most)
{
    const struct tracer *t = trace_near(tracer, origin);
    struct trace_hit hit = {0};
    const double reach = most * t->scale;
    const struct trace_ray ray = {
        .origin = trace_to_local(t, origin),
        .direction = {(float)direction[0], (float)direction[1], (float)direction[2]},
        .most = reach < (double)FLT_MAX ? (float)reach : INFINITY};
    struct trace_query query = start_query(t, 0, 0.5f);
    struct trace_point point;
    if (!nearest(&query, &ray, &point))
        return hit;
    hit = (struct trace_hit){
        .hit = true,
        .distance = (double)point.distance / t->scale,
        .position = trace_to_world(t, point.position),
        .normal = {(double)point.normal.x, (double)point.normal.y, (double)point.normal.z},
        .front = point.front,
        .instance = point.instance,
        .triangle = point.triangle};
    return hit;
}

/* Multiplies what blended surfaces let through, nearest first, up to an opaque one. */
static float transmission(const struct tracer *t, struct trace_ray ray)
{
    if (!t->has_alpha)
        return trace_local_occluded(t, &ray) ? 0 : 1;
    float through = 1;
    struct trace_point point;
    for (struct trace_query query = start_query(t, 0, 1);
         through > 0 && nearest(&query, &ray, &point);) {
        trace_point_shade(t, &point);
        through *= trace_point_transparency(t, &point);
        const struct vec3f behind = point.front ? vec3f_scale(-1, point.normal) : point.normal;
        ray.origin = trace_leave(point.position, point.distance, behind);
        ray.most -= point.distance;
        if (!(ray.most > 0))
            break;
    }
    return through;
}

float trace_visibility(const struct tracer *tracer, const double a[3], const double b[3])
{
    const struct tracer *t = trace_near(tracer, a);
    const struct vec3f from = trace_to_local(t, a), to = trace_to_local(t, b),
                       way = vec3f_sub(to, from);
    const float length = vec3f_length(way);
    if (!(length > 0))
        return 1;
    return transmission(t, (struct trace_ray){.origin = from,
                                              .direction = vec3f_scale(1 / length, way),
                                              .most = length});
}

float trace_visibility_sky(const struct tracer *tracer, const double a[3],
                           const double direction[3])
{
    const struct tracer *t = trace_near(tracer, a);
    return transmission(t,
                        (struct trace_ray){.origin = trace_to_local(t, a),
                                           .direction = {(float)direction[0], (float)direction[1],
                                                         (float)direction[2]},
                                           .most = INFINITY});
}
