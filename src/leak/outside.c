/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/outside.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/cells_volume.h"
#include "leak/leak.h"
#include "math/angle.h"
#include "math/box.h"
#include "math/random.h"
#include "scene/scene.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* RAYS go all around from a probe; MORE, where one of those points is not seen by all. About a cell
 * with such a point POINTS more are looked at, where one of WITNESSES that saw others sees them;
 * then about the cells that these were found at, in TURNS. Random numbers have a name. */
enum {
    RAYS = 32,
    MORE = 256,
    POINTS = 128,
    WITNESSES = 8,
    TURNS = 3,
    HALVINGS = 8,
    RINGS = 2,
    FOR_OUTSIDE = 0x4f555453
};
static const double BESIDE = 0.5, REACH = 2;

/* Rays that go more than this into the hull (cosine to its normal) find no point outside. */
static const double INWARD = -0.3;

struct looks {
    struct outside_look *look; /* owned */
    size_t count, capacity;
};

struct job {
    struct outside *outside;
    const struct tracer *tracer;
    int32_t *hull; /* probes of the hull, and some behind it, ascending */
    size_t hulls;
    double *normal;      /* 3 a probe, any length; 0: not of the hull */
    struct looks *looks; /* of each of them */
    struct looks *more;  /* of each cell */
    bool *asked;         /* of each cell: it was looked about */
};

static double inverse_of(const struct tracer *tracer, const double p[3], const double q[3],
                         struct trace_hit *hit)
{
    double direction[3];
    const struct vec3 way = vec3_sub(vec3_load(q), vec3_load(p));
    const double length = vec3_length(way), least = length / 0x1p14;
    vec3_store(direction, vec3_scale(1 / length, way));
    *hit = trace_nearest(tracer, p, direction, length);
    return hit->hit ? length / fmax(hit->distance, least) : 0;
}

double outside_inverse(const struct tracer *tracer, const double p[3], const double q[3])
{
    struct trace_hit hit;
    return inverse_of(tracer, p, q, &hit);
}

void outside_way(const struct outside *o, const struct outside_look *look, double off[3])
{
    struct vec3 away = vec3_load(look->point);
    for (size_t i = 0; i < 4; i++)
        away = vec3_fma(away, -look->weight[i],
                        leak_mesh_probe(o->mesh, o->mesh->vertex[4 * (size_t)look->cell + i]));
    vec3_store(off, away);
}

static bool is_blocked(const struct outside_look *look)
{
    return look->inverse[0] > 0 || look->inverse[1] > 0 || look->inverse[2] > 0 ||
           look->inverse[3] > 0;
}

bool outside_is_blocked(const struct outside *o, size_t cell)
{
    const struct outside_list *list = &o->by_cell;
    if (!list->first)
        return false;
    for (size_t k = list->first[cell]; k < list->first[cell + 1]; k++)
        if (is_blocked(&o->look[list->of[k]]))
            return true;
    return false;
}

bool outside_plane(const struct outside_look *look, const double p[3], struct vec3 *plane)
{
    const struct vec3 normal = {(double)look->normal[0], (double)look->normal[1],
                                (double)look->normal[2]};
    const double height = (double)look->height +
                          vec3_dot(normal, vec3_sub(vec3_load(look->point), vec3_load(p)));
    if (!is_blocked(look) || height == 0)
        return false;
    *plane = vec3_scale(1 / height, normal);
    return true;
}

/* -- the hull --------------------------------------------------------------------------------- */

/* The corners of the face opposite each corner, counter-clockwise from outside. */
static const int face[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

static bool sees(const struct job *job, int32_t a, int32_t b)
{
    const double *position = job->outside->mesh->position;
    return !(outside_inverse(job->tracer, position + 3 * (size_t)a, position + 3 * (size_t)b) > 0);
}

/* Whether something stands on an edge of the face opposite a corner. */
static bool is_cut(const struct job *job, const int32_t *vertex, const int f[3])
{
    for (int k = 0; k < 3; k++)
        if (!sees(job, vertex[f[k]], vertex[f[(k + 1) % 3]]))
            return true;
    return false;
}

/* Leaves out the marked probes that see one of the hull, or another that does, along edges: they
 * are in a room with it, whose points outside it looks for. */
static struct error *leave_seen(const struct job *job, bool *beside)
{
    const struct leak_mesh *mesh = job->outside->mesh;
    bool *seen = NULL;
    struct error *err = array_create(&seen, mesh->probe_count, sizeof *seen);
    for (size_t i = 0; i < mesh->probe_count && !err; i++)
        seen[i] = vec3_length(vec3_load(job->normal + 3 * i)) > 0;
    for (int ring = 0; ring <= RINGS && !err; ring++)
        for (size_t slot = 0; slot < 16 * mesh->cell_count; slot++) {
            const int32_t *vertex = mesh->vertex + slot / 16 * 4, a = vertex[slot % 16 / 4],
                          b = vertex[slot % 4];
            if (beside[a] && beside[b] && seen[a] && !seen[b])
                seen[b] = sees(job, a, b);
        }
    for (size_t i = 0; i < mesh->probe_count && !err; i++)
        beside[i] = beside[i] && !seen[i];
    free(seen);
    return err;
}

/* Marks the probes within RINGS of a face of the hull that a wall cuts and that are in a room with
 * none of the hull, as where a room has probes in its middle alone: what is before the face is seen
 * from them. */
static struct error *find_beside(const struct job *job, bool *beside)
{
    const struct leak_mesh *mesh = job->outside->mesh;
    bool *before = NULL;
    struct error *err = array_create(&before, mesh->probe_count, sizeof *before);
    for (size_t slot = 0; slot < 4 * mesh->cell_count && !err; slot++) {
        const int32_t *vertex = mesh->vertex + slot / 4 * 4;
        if (mesh->neighbour[slot] >= 0 || !is_cut(job, vertex, face[slot % 4]))
            continue;
        for (int i = 0; i < 4; i++)
            beside[vertex[i]] = true;
    }
    for (int ring = 0; ring < RINGS && !err; ring++) {
        memcpy(before, beside, mesh->probe_count * sizeof *before);
        for (size_t cell = 0; cell < mesh->cell_count; cell++) {
            const int32_t *v = mesh->vertex + 4 * cell;
            const bool any = before[v[0]] || before[v[1]] || before[v[2]] || before[v[3]];
            for (int i = 0; i < 4 && any; i++)
                beside[v[i]] = true;
        }
    }
    free(before);
    return err ? err : leave_seen(job, beside);
}

static struct error *find_hull(struct job *job)
{
    const struct leak_mesh *mesh = job->outside->mesh;
    bool *from = NULL;
    struct error *err = array_create(&job->normal, 3 * mesh->probe_count, sizeof *job->normal);
    if (!err)
        err = array_create(&job->hull, mesh->probe_count, sizeof *job->hull);
    for (size_t slot = 0; slot < 4 * mesh->cell_count && !err; slot++) {
        const int32_t *vertex = mesh->vertex + slot / 4 * 4;
        const int *f = face[slot % 4];
        if (mesh->neighbour[slot] >= 0)
            continue;
        const struct vec3 p = leak_mesh_probe(mesh, vertex[f[0]]),
                          n = vec3_cross(vec3_sub(leak_mesh_probe(mesh, vertex[f[1]]), p),
                                         vec3_sub(leak_mesh_probe(mesh, vertex[f[2]]), p));
        for (int k = 0; k < 3; k++) {
            double *sum = job->normal + 3 * (size_t)vertex[f[k]];
            vec3_store(sum, vec3_add(vec3_load(sum), n));
        }
    }
    if (!err)
        err = array_create(&from, mesh->probe_count, sizeof *from);
    if (!err)
        err = find_beside(job, from);
    for (size_t i = 0; i < mesh->probe_count && !err; i++)
        if (from[i] || vec3_length(vec3_load(job->normal + 3 * i)) > 0)
            job->hull[job->hulls++] = (int32_t)i;
    free(from);
    return err ? err : array_create(&job->looks, job->hulls, sizeof *job->looks);
}

/* -- looks ------------------------------------------------------------------------------------ */

/* How far it is from p along d to the end of the scene's box. */
static double way_out(const struct scene *scene, const double p[3], const double d[3])
{
    const double low[3] = {scene->box_min.x, scene->box_min.y, scene->box_min.z},
                 high[3] = {scene->box_max.x, scene->box_max.y, scene->box_max.z};
    double way = (double)INFINITY;
    for (int k = 0; k < 3; k++)
        if (d[k] != 0)
            way = fmin(way, fmax(((d[k] > 0 ? high[k] : low[k]) - p[k]) / d[k], 0));
    return way;
}

/* Looks at a point from the probes of its place, by nearest points or by rays; `from` sees it.
 * false: it is within the hull. */
static bool look_at(const struct job *job, bool extends, int32_t from, struct outside_look *look)
{
    struct probe_place place = {.cell = PROBE_COLD};
    const double *position = job->outside->mesh->position;
    if (probe_volume_locate(job->outside->volume[extends], look->point, &place) || place.inside)
        return false;
    look->cell = place.cell;
    look->from = from;
    memcpy(look->weight, place.weight, sizeof look->weight);
    memset(look->inverse, 0, sizeof look->inverse);
    for (int i = 0; i < 4; i++) {
        struct trace_hit hit;
        if (!(place.weight[i] > 0) || place.probe[i] == from)
            continue;
        const double inverse =
            inverse_of(job->tracer, position + 3 * (size_t)place.probe[i], look->point, &hit);
        if (inverse > 0 && !is_blocked(look)) {
            look->normal[0] = (float)hit.normal.x;
            look->normal[1] = (float)hit.normal.y;
            look->normal[2] = (float)hit.normal.z;
            look->height =
                (float)vec3_dot(hit.normal, vec3_sub(hit.position, vec3_load(look->point)));
        }
        look->inverse[i] = (float)inverse;
    }
    return true;
}

/* How much of a way from p, which is within the hull, is within it; 1: all. */
static double way_inside(const struct job *job, struct vec3 p, struct vec3 way)
{
    double low = 0, high = 1;
    struct probe_place place = {.cell = PROBE_COLD};
    for (int k = 0; k <= HALVINGS; k++) {
        const double at = k ? (low + high) / 2 : 1;
        double point[3];
        vec3_store(point, vec3_fma(p, at, way));
        const bool inside = probe_volume_locate(job->outside->volume[0], point, &place) ||
                            place.inside;
        if (!k && inside)
            return 1;
        *(inside ? &low : &high) = at;
    }
    return high;
}

/* Sends `rays` all around from a probe, and looks at a point of each; from behind the hull, at one
 * before it. Returns how many were outside. */
static size_t look_around(const struct job *job, int32_t probe, int rays, struct outside_look *look)
{
    const double *p = job->outside->mesh->position + 3 * (size_t)probe, golden = (sqrt(5) - 1) / 2;
    const struct vec3 normal = vec3_normalize(vec3_load(job->normal + 3 * (size_t)probe));
    struct random r = random_start((uint64_t)rays, random_hash_position(p), FOR_OUTSIDE);
    const double turn = random_double(&r), up = random_double(&r), start = random_double(&r);
    const bool behind = !(vec3_length(normal) > 0);
    size_t found = 0;
    for (int k = 0; k < rays; k++) {
        const double z = 1 - 2 * (k + up) / rays, flat = sqrt(1 - z * z),
                     angle = 2 * ANGLE_PI * (turn + k * golden - floor(turn + k * golden)),
                     d[3] = {flat * angle_cos(angle), flat * angle_sin(angle), z};
        const double part = start + k * 0.5497004779019703, at = part - floor(part);
        if (vec3_dot(normal, vec3_load(d)) < INWARD)
            continue;
        const double most = way_out(trace_scene(job->tracer), p, d);
        if (!(most > 0 && most < (double)INFINITY))
            continue;
        const struct trace_hit hit = trace_nearest(job->tracer, p, d, most);
        const double end = 0.999 * (hit.hit ? hit.distance : most);
        const struct vec3 ray = vec3_scale(end, vec3_load(d));
        const double first = behind ? way_inside(job, vec3_load(p), ray) : 0;
        if (first >= 1)
            continue;
        const double way = behind ? end * (first + at * (1 - first)) : end * at;
        vec3_store(look[found].point, vec3_fma(vec3_load(p), way, vec3_load(d)));
        found += look_at(job, k % 2 && job->outside->volume[1], probe, &look[found]);
    }
    return found;
}

static struct error *look_from(void *context, size_t index, int thread)
{
    (void)thread;
    const struct job *job = context;
    struct looks *looks = &job->looks[index];
    struct outside_look look[RAYS + MORE];
    size_t found = look_around(job, job->hull[index], RAYS, look);
    bool blocked = false;
    for (size_t i = 0; i < found; i++)
        blocked = blocked || is_blocked(&look[i]);
    if (blocked)
        found += look_around(job, job->hull[index], MORE, look + found);
    struct error *err = array_create(&looks->look, found, sizeof *looks->look);
    if (!err) {
        memcpy(looks->look, look, found * sizeof *look);
        looks->count = found;
    }
    return err;
}

/* Puts them all behind those that there are. */
static struct error *gather(struct outside *o, const struct looks *looks, size_t lists)
{
    size_t count = o->count;
    for (size_t i = 0; i < lists; i++)
        count += looks[i].count;
    struct error *err = array_reserve(&o->look, &o->capacity, count, sizeof *o->look);
    for (size_t i = 0; i < lists && !err; i++) {
        if (looks[i].count)
            memcpy(o->look + o->count, looks[i].look, looks[i].count * sizeof *o->look);
        o->count += looks[i].count;
    }
    return err;
}

static void looks_free(struct looks *looks, size_t lists)
{
    for (size_t i = 0; i < lists && looks; i++)
        free(looks[i].look);
    free(looks);
}

/* -- before the faces of a cell --------------------------------------------------------------- */

/* Who saw the points of a cell's looks, each once. Returns how many. */
static int find_witnesses(const struct outside *o, size_t cell, int32_t witness[WITNESSES])
{
    int count = 0;
    for (size_t i = o->by_cell.first[cell]; i < o->by_cell.first[cell + 1]; i++) {
        const int32_t from = o->look[o->by_cell.of[i]].from;
        int k = 0;
        while (k < count && witness[k] != from)
            k++;
        if (k == count && count < WITNESSES)
            witness[count++] = from;
    }
    return count;
}

/* The first of them that sees p; -1: none. */
static int32_t who_sees(const struct job *job, int count, const int32_t *witness, const double p[3])
{
    for (int k = 0; k < count; k++)
        if (!(outside_inverse(job->tracer, job->outside->mesh->position + 3 * (size_t)witness[k],
                              p) > 0))
            return witness[k];
    return -1;
}

/* A box about a cell, BESIDE times as far as that is long to all sides, and outward REACH times,
 * but not out of the scene's. */
static struct box box_about(const struct job *job, size_t cell)
{
    const struct leak_mesh *mesh = job->outside->mesh;
    const struct scene *scene = trace_scene(job->tracer);
    const double low[3] = {scene->box_min.x, scene->box_min.y, scene->box_min.z},
                 high[3] = {scene->box_max.x, scene->box_max.y, scene->box_max.z};
    struct box box = box_empty();
    double normal[3] = {0};
    for (size_t i = 0; i < 4; i++) {
        const size_t probe = (size_t)mesh->vertex[4 * cell + i];
        box_add(&box, mesh->position + 3 * probe);
        for (int k = 0; k < 3; k++)
            normal[k] += job->normal[3 * probe + (size_t)k];
    }
    const double side = box_side(&box);
    for (int k = 0; k < 3; k++) {
        const bool down = normal[k] < 0;
        box.low[k] = fmin(box.low[k], fmax(low[k], box.low[k] - (down ? REACH : BESIDE) * side));
        box.high[k] =
            fmax(box.high[k], fmin(high[k], box.high[k] + (down ? BESIDE : REACH) * side));
    }
    return box;
}

static struct error *look_about(void *context, size_t cell, int thread)
{
    (void)thread;
    static const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    const struct job *job = context;
    struct looks *looks = &job->more[cell];
    struct error *err = NULL;
    int32_t witness[WITNESSES];
    if (job->asked[cell] || !outside_is_blocked(job->outside, cell))
        return NULL;
    job->asked[cell] = true;
    const int count = find_witnesses(job->outside, cell, witness);
    const struct box box = box_about(job, cell);
    for (int n = 0; n < POINTS && !err; n++) {
        struct outside_look look;
        for (int k = 0; k < 3; k++) {
            const double x = 0.5 + (n + 1) * step[k], u = x - floor(x);
            look.point[k] = box.low[k] + u * (box.high[k] - box.low[k]);
        }
        const int32_t from = who_sees(job, count, witness, look.point);
        if (from < 0 || !look_at(job, n % 2 && job->outside->volume[1], from, &look))
            continue;
        err = array_reserve(&looks->look, &looks->capacity, looks->count + 1, sizeof *looks->look);
        if (!err)
            looks->look[looks->count++] = look;
    }
    return err;
}

/* -- lists ------------------------------------------------------------------------------------ */

/* Of what the c-th corner of a look's cell is, by probe, or its cell. */
static size_t of_what(const struct outside *o, const struct outside_look *look, bool probe, int c)
{
    return probe ? (size_t)o->mesh->vertex[4 * (size_t)look->cell + (size_t)c] : (size_t)look->cell;
}

static struct error *list_init(struct outside_list *list, const struct outside *o, bool probe)
{
    const size_t count = probe ? o->mesh->probe_count : o->mesh->cell_count;
    const int corners = probe ? 4 : 1;
    struct error *err = array_create(&list->first, count + 2, sizeof *list->first);
    if (!err)
        err = array_create(&list->of, (size_t)corners * o->count, sizeof *list->of);
    for (size_t i = 0; i < o->count && !err; i++)
        for (int c = 0; c < corners; c++)
            list->first[of_what(o, &o->look[i], probe, c) + 2]++;
    for (size_t i = 0; i < count && !err; i++)
        list->first[i + 2] += list->first[i + 1];
    for (size_t i = 0; i < o->count && !err; i++)
        for (int c = 0; c < corners; c++)
            list->of[list->first[of_what(o, &o->look[i], probe, c) + 1]++] = (uint32_t)i;
    return err;
}

static void list_clear(struct outside_list *list)
{
    free(list->first);
    free(list->of);
    *list = (struct outside_list){0};
}

/* -- all together ----------------------------------------------------------------------------- */

/* Without matrices: what is asked of them is where points outside are. */
static struct error *make_volumes(struct outside *o, const struct probe_mesh *cells)
{
    struct error *err = cells_volume_create(cells, PROBE_NEAREST | PROBE_LEAN, &o->volume[0]);
    if (!err)
        err = cells_volume_create(cells, PROBE_EXTEND | PROBE_LEAN, &o->volume[1]);
    if (!err && !probe_volume_extends(o->volume[1])) {
        probe_volume_destroy(o->volume[1]);
        o->volume[1] = NULL;
    }
    return err;
}

/* Looks about the cells that were found since. */
static struct error *look_more(struct job *job, int threads)
{
    struct outside *o = job->outside;
    const size_t cells = o->mesh->cell_count;
    struct error *err = array_create(&job->more, cells, sizeof *job->more);
    if (!err)
        err = threads_for(threads, cells, look_about, job);
    if (!err)
        err = gather(o, job->more, cells);
    looks_free(job->more, cells);
    list_clear(&o->by_cell);
    return err ? err : list_init(&o->by_cell, o, false);
}

struct error *outside_init(struct outside *o, const struct tracer *tracer,
                           const struct leak_mesh *mesh, int threads)
{
    struct job job = {.outside = o, .tracer = tracer};
    *o = (struct outside){.mesh = mesh};
    if (mesh->corners != 4 || !mesh->neighbour)
        return NULL;
    const struct probe_mesh cells = {.probes = mesh->probe_count,
                                     .position = mesh->position,
                                     .corners = mesh->corners,
                                     .cells = mesh->cell_count,
                                     .vertex = mesh->vertex,
                                     .neighbour = mesh->neighbour};
    struct error *err = make_volumes(o, &cells);
    if (!err)
        err = find_hull(&job);
    if (!err)
        err = threads_for(threads, job.hulls, look_from, &job);
    if (!err)
        err = gather(o, job.looks, job.hulls);
    looks_free(job.looks, job.hulls);
    if (!err)
        err = list_init(&o->by_cell, o, false);
    if (!err)
        err = array_create(&job.asked, mesh->cell_count, sizeof *job.asked);
    for (int turn = 0; turn < TURNS && !err; turn++)
        err = look_more(&job, threads);
    if (!err)
        err = list_init(&o->by_probe, o, true);
    free(job.asked);
    free(job.hull);
    free(job.normal);
    if (err)
        outside_clear(o);
    return err;
}

void outside_clear(struct outside *o)
{
    probe_volume_destroy(o->volume[0]);
    probe_volume_destroy(o->volume[1]);
    free(o->look);
    list_clear(&o->by_probe);
    list_clear(&o->by_cell);
    *o = (struct outside){0};
}
