/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/stand_in.h"
#include "base/error.h"
#include "base/threads.h"
#include "leak/leak.h"
#include "leak/stars.h"
#include "libprobe-query/sight.h"
#include "math/sort.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

/* POINTS of a cell; candidates stand within RINGS cells of it, LISTED at most, and the ASKED
 * nearest are looked for. */
enum { POINTS = 64, RINGS = 3, LISTED = 1024, ASKED = 96 };

struct job {
    const struct tracer *tracer;
    const struct leak_mesh *mesh;
    const struct stars *stars;
    const float *sight;
    int32_t *stand_in;
};

/* -- points ----------------------------------------------------------------------------------- */

/* The k-th point of a cell, barycentric: evenly spread, by the gaps between sorted numbers
 * (Devroye, "Non-uniform random variate generation", 1986, ch. V, theorem 2.1) of the additive
 * sequence of three dimensions' golden ratio (Roberts, "The unreasonable effectiveness of
 * quasirandom sequences", 2018). */
static void point_of_cell(int corners, int k, double u[4])
{
    static const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    double x[5] = {0};
    for (int i = 1; i < corners; i++) {
        const double y = 0.5 + (k + 1) * step[i - 1];
        x[i] = y - floor(y);
    }
    x[corners] = 1;
    sort_doubles((size_t)corners - 1, x + 1);
    for (int i = 0; i < 4; i++)
        u[i] = i < corners ? x[i + 1] - x[i] : 0;
}

static bool sees(const struct job *job, struct vec3 p, int32_t probe)
{
    double from[3];
    vec3_store(from, p);
    return trace_visibility(job->tracer, from, job->mesh->position + 3 * (size_t)probe) > 0.5f;
}

/* Points of the cell where little is left of its corners' weights. Returns how many; *served: of
 * how many of them what is left comes from corners that they see. */
static int find_points(const struct job *job, size_t cell, struct vec3 point[POINTS],
                       double *served)
{
    const int corners = job->mesh->corners;
    const size_t width = (size_t)sight_width(corners);
    const int32_t *vertex = job->mesh->vertex + (size_t)corners * cell;
    uint16_t sight[12];
    bool walled = false;
    int count = 0;
    *served = 0;
    for (size_t i = 0; i < width; i++) {
        sight[i] = half_of(job->sight[width * cell + i]);
        walled = walled || job->sight[width * cell + i] > 1;
    }
    for (int k = 0; k < POINTS && walled; k++) {
        double u[4], weight[4];
        struct vec3 p = {0};
        point_of_cell(corners, k, u);
        const double sum = sight_weights(corners, sight, u, weight);
        if (sum >= SIGHT_ENOUGH)
            continue;
        for (int i = 0; i < corners; i++)
            p = vec3_fma(p, u[i], leak_mesh_probe(job->mesh, vertex[i]));
        for (int i = 0; i < corners; i++)
            *served += weight[i] > 1e-3 * sum && sees(job, p, vertex[i]) ? weight[i] / sum : 0;
        point[count++] = p;
    }
    return count;
}

/* -- candidates ------------------------------------------------------------------------------- */

struct candidate {
    double square; /* of the distance */
    int32_t probe;
};

static int compare_candidates(const void *a, const void *b)
{
    const struct candidate *p = a, *q = b;
    if (p->square != q->square)
        return p->square < q->square ? -1 : 1;
    return p->probe < q->probe ? -1 : p->probe > q->probe;
}

static void list(struct candidate *candidate, size_t *count, int32_t probe)
{
    for (size_t i = 0; i < *count; i++)
        if (candidate[i].probe == probe)
            return;
    if (*count < LISTED)
        candidate[(*count)++] = (struct candidate){.probe = probe};
}

/* The probes of the cell and of those around it, ring by ring, then by their distance from p. */
static size_t find_candidates(const struct job *job, size_t cell, struct vec3 p,
                              struct candidate candidate[LISTED])
{
    const size_t corners = (size_t)job->mesh->corners;
    size_t count = 0, begin = 0;
    for (size_t i = 0; i < corners; i++)
        list(candidate, &count, job->mesh->vertex[corners * cell + i]);
    for (int ring = 0; ring < RINGS; ring++) {
        const size_t end = count;
        for (; begin < end; begin++) {
            const size_t *first = job->stars->first + candidate[begin].probe;
            for (size_t s = first[0]; s < first[1]; s++)
                for (size_t i = 0; i < corners; i++)
                    list(candidate, &count,
                         job->mesh->vertex[job->stars->slot[s] / corners * corners + i]);
        }
    }
    for (size_t i = 0; i < count; i++) {
        const struct vec3 way = vec3_sub(leak_mesh_probe(job->mesh, candidate[i].probe), p);
        candidate[i].square = vec3_dot(way, way);
    }
    qsort(candidate, count, sizeof *candidate, compare_candidates);
    return count;
}

static struct error *look_for(void *context, size_t cell, int thread)
{
    (void)thread;
    const struct job *job = context;
    struct vec3 point[POINTS], middle = {0};
    struct candidate candidate[LISTED];
    double served;
    job->stand_in[cell] = -1;
    const int points = find_points(job, cell, point, &served);
    if (!points || served >= points)
        return NULL;
    for (int k = 0; k < points; k++)
        middle = vec3_fma(middle, 1.0 / points, point[k]);
    const size_t count = find_candidates(job, cell, middle, candidate);
    int most = (int)ceil(served);
    for (size_t i = 0; i < count && i < ASKED && most < points; i++) {
        int seen = 0;
        for (int k = 0; k < points && seen + points - k > most; k++)
            seen += sees(job, point[k], candidate[i].probe);
        if (seen > most) {
            most = seen;
            job->stand_in[cell] = candidate[i].probe;
        }
    }
    return NULL;
}

struct error *stand_in_find(int32_t *stand_in, const float *sight, const struct tracer *tracer,
                            const struct leak_mesh *mesh, const struct stars *stars, int threads)
{
    struct job job = {
        .tracer = tracer, .mesh = mesh, .stars = stars, .sight = sight, .stand_in = stand_in};
    return threads_for(threads, mesh->cell_count, look_for, &job);
}
