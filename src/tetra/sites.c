/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707, 2004. */
#include "tetra/sites.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "math/cubes.h"
#include "math/vec.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* -- canonical order -------------------------------------------------------------------------- */

enum { KEY_BITS = 16, DIGIT_BITS = 12, DIGITS = 1 << DIGIT_BITS, PASSES = 4 };

struct place {
    uint64_t key;
    int32_t row;
};

/* 16 bits to every third bit of 48. */
static uint64_t spread(uint64_t x)
{
    x = (x | x << 16) & 0x0000ff0000ff;
    x = (x | x << 8) & 0x00f00f00f00f;
    x = (x | x << 4) & 0x0c30c30c30c3;
    return (x | x << 2) & 0x249249249249;
}

static uint32_t to_cube(double coordinate)
{
    const double cube = coordinate * (1.0 / (INT64_C(1) << (LATTICE_BITS - KEY_BITS))); /* exact */
    return cube > 0 ? (uint32_t)cube : 0;
}

/* A step of the transform: where an axis has the bit above `low`, x's bits below are inverted, else
 * exchanged with the axis's. */
static inline void turn(uint32_t *x, uint32_t *axis, int bit)
{
    const uint32_t low = (1u << bit) - 1, set = -(*axis >> bit & 1),
                   exchange = (*x ^ *axis) & low & ~set;
    *axis ^= exchange;
    *x ^= exchange | (low & set);
}

/* The cell of a curve over 2^KEY_BITS cubed that a site is in: Skilling's AxestoTranspose, its bits
 * interleaved; without branches, which no processor could foretell. */
static uint64_t hilbert_key(const double site[3])
{
    uint32_t x = to_cube(site[0]), y = to_cube(site[1]), z = to_cube(site[2]);
    for (int bit = KEY_BITS - 1; bit > 0; bit--) {
        x ^= ((1u << bit) - 1) & -(x >> bit & 1);
        turn(&x, &y, bit);
        turn(&x, &z, bit);
    }
    y ^= x;
    z ^= y;
    uint32_t t = z >> 1; /* of each bit, the parity of those above it */
    for (int shift = 1; shift < KEY_BITS; shift *= 2)
        t ^= t >> shift;
    return spread(x ^ t) << 2 | spread(y ^ t) << 1 | spread(z ^ t);
}

/* Sorts by key, least digit first; `spare` has room for all. */
static void sort_places(struct place *place, struct place *spare, size_t count)
{
    for (int pass = 0; pass < PASSES; pass++) {
        size_t start[DIGITS] = {0}, sum = 0;
        for (size_t i = 0; i < count; i++)
            start[place[i].key >> (pass * DIGIT_BITS) & (DIGITS - 1)]++;
        for (int d = 0; d < DIGITS; d++) {
            const size_t here = start[d];
            start[d] = sum;
            sum += here;
        }
        for (size_t i = 0; i < count; i++)
            spare[start[place[i].key >> (pass * DIGIT_BITS) & (DIGITS - 1)]++] = place[i];
        /* an even number of passes: the last ends where the first began */
        struct place *const swap = place;
        place = spare;
        spare = swap;
    }
}

static int compare_numbers(const double *a, const double *b)
{
    for (int k = 0; k < 3; k++)
        if (a[k] != b[k])
            return a[k] < b[k] ? -1 : 1;
    return 0;
}

struct order {
    const double *snapped, *position;
    const struct sites_settings *settings;
};

static bool is_lit(const struct sites_settings *settings, int32_t row)
{
    return settings->light && !isnan(settings->light[(size_t)row * settings->light_width]);
}

/* By site; on one site lit probes first, then by position and by light: which one represents the
 * others does not depend on rows. */
static int compare_places(const void *a, const void *b, void *context)
{
    const struct order *o = context;
    const int32_t i = ((const struct place *)a)->row, j = ((const struct place *)b)->row;
    int order = compare_numbers(o->snapped + 3 * (size_t)i, o->snapped + 3 * (size_t)j);
    if (!order)
        order = (int)is_lit(o->settings, j) - (int)is_lit(o->settings, i);
    if (!order)
        order = compare_numbers(o->position + 3 * (size_t)i, o->position + 3 * (size_t)j);
    const size_t width = o->settings->light_width;
    if (!order && o->settings->light)
        order = memcmp(o->settings->light + width * (size_t)i,
                       o->settings->light + width * (size_t)j, width * sizeof(float));
    return order ? order : i < j ? -1 : i > j;
}

/* -- merging ---------------------------------------------------------------------------------- */

static struct error *merge_row(struct sites *sites, size_t probes, int32_t row, int32_t into)
{
    if (!sites->merged) {
        struct error *err = array_create(&sites->merged, probes, sizeof *sites->merged);
        if (err)
            return err;
        for (size_t i = 0; i < probes; i++)
            sites->merged[i] = -1;
    }
    sites->merged[row] = into;
    sites->merged_count++;
    return NULL;
}

/* Drops the sites whose row is merged, and lets what was merged with them follow. */
static void drop_merged(struct sites *sites, size_t probes)
{
    if (!sites->merged)
        return;
    size_t kept = 0;
    for (size_t i = 0; i < sites->count; i++) {
        if (sites->merged[sites->row[i]] >= 0)
            continue;
        memmove(sites->site + 3 * kept, sites->site + 3 * i, 3 * sizeof *sites->site);
        sites->row[kept++] = sites->row[i];
    }
    sites->count = kept;
    for (size_t i = 0; i < probes; i++)
        while (sites->merged[i] >= 0 && sites->merged[sites->merged[i]] >= 0)
            sites->merged[i] = sites->merged[sites->merged[i]];
}

/* One place after the other, lit ones first, is merged with one before it that is nearer than
 * `reach` (steps), or represents itself. */
static struct error *merge_near(struct sites *sites, size_t probes, double reach,
                                const struct sites_settings *settings)
{
    struct cubes cubes = {0};
    int32_t *represents = NULL, near;
    struct error *err = cubes_init(&cubes, reach, sites->count);
    if (!err)
        err = array_create(&represents, sites->count, sizeof *represents);
    for (int turn = 0; turn < 2; turn++)
        for (size_t i = 0; i < sites->count && !err; i++) {
            if (is_lit(settings, sites->row[i]) != (turn == 0))
                continue;
            if (cubes_find(&cubes, sites->site + 3 * i, reach, NULL, NULL, &near)) {
                err = merge_row(sites, probes, sites->row[i], represents[near]);
            } else {
                represents[cubes.count] = sites->row[i];
                cubes_add(&cubes, sites->site + 3 * i);
            }
        }
    if (!err)
        drop_merged(sites, probes);
    cubes_clear(&cubes);
    free(represents);
    return err;
}

/* A site's projection, for finding sites that fall together in it. */
struct shadow {
    double at[2];
    bool lit;
    int32_t site;
};

static int compare_shadows(const void *a, const void *b)
{
    const struct shadow *s = a, *t = b;
    for (int k = 0; k < 2; k++)
        if (s->at[k] != t->at[k])
            return s->at[k] < t->at[k] ? -1 : 1;
    return s->lit != t->lit ? (int)t->lit - (int)s->lit : s->site < t->site ? -1 : 1;
}

static struct error *merge_projected(struct sites *sites, size_t probes,
                                     const struct sites_settings *settings)
{
    struct shadow *shadow = NULL;
    struct error *err = array_create(&shadow, sites->count, sizeof *shadow);
    for (size_t i = 0; i < sites->count && !err; i++) {
        const double *p = sites->site + 3 * i;
        shadow[i] =
            (struct shadow){{p[sites->axis[0]], sites->corners == 3 ? p[sites->axis[1]] : 0},
                            is_lit(settings, sites->row[i]),
                            (int32_t)i};
    }
    if (!err)
        qsort(shadow, sites->count, sizeof *shadow, compare_shadows);
    size_t first = 0;
    for (size_t i = 1; i < sites->count && !err; i++) {
        if (shadow[i].at[0] == shadow[first].at[0] && shadow[i].at[1] == shadow[first].at[1])
            err = merge_row(sites, probes, sites->row[shadow[i].site],
                            sites->row[shadow[first].site]);
        else
            first = i;
    }
    if (!err)
        drop_merged(sites, probes);
    free(shadow);
    return err;
}

/* -- what they span --------------------------------------------------------------------------- */

/* The widest triangle that is found by going for the farthest, thrice. */
struct span {
    /* a site, the unit direction to the farthest, the unit normal */
    struct vec3 from, along, normal;
    /* from the point; of the farthest from the line; of the farthest from the plane */
    double length, width, height;
    size_t extreme[4]; /* the sites */
};

/* The site where `away` is the largest; among equals the lexicographically first. */
static size_t farthest(size_t count, const double *site, const struct span *span,
                       double (*away)(const struct span *, struct vec3), double *most)
{
    size_t best = 0;
    *most = -1;
    for (size_t i = 0; i < count; i++) {
        const double d = away(span, vec3_sub(vec3_load(site + 3 * i), span->from));
        if (d > *most || (d == *most && compare_numbers(site + 3 * i, site + 3 * best) < 0)) {
            *most = d;
            best = i;
        }
    }
    return best;
}

static double from_point(const struct span *span, struct vec3 v)
{
    (void)span;
    return vec3_length(v);
}

static double from_line(const struct span *span, struct vec3 v)
{
    return vec3_length(vec3_cross(v, span->along));
}

static double from_plane(const struct span *span, struct vec3 v)
{
    return fabs(vec3_dot(v, span->normal));
}

static struct span span_of(size_t count, const double *site)
{
    struct span span = {0};
    /* from the box's corner */
    span.extreme[0] = farthest(count, site, &span, from_point, &span.length);
    span.from = vec3_load(site + 3 * span.extreme[0]);
    span.extreme[1] = farthest(count, site, &span, from_point, &span.length);
    span.along = vec3_normalize(vec3_sub(vec3_load(site + 3 * span.extreme[1]), span.from));
    span.extreme[2] = farthest(count, site, &span, from_line, &span.width);
    span.normal = vec3_normalize(
        vec3_cross(span.along, vec3_sub(vec3_load(site + 3 * span.extreme[2]), span.from)));
    for (int i = 0; i < 2; i++) /* of a narrow strip the cross product is mostly rounding */
        span.normal =
            vec3_normalize(vec3_fma(span.normal, -vec3_dot(span.normal, span.along), span.along));
    span.extreme[3] = farthest(count, site, &span, from_plane, &span.height);
    return span;
}

/* Of three shares the largest; a later axis goes before an earlier one that is hardly larger. */
static int main_axis(struct vec3 v)
{
    const double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z), clearly = 1.01;
    const int best = y > clearly * z ? 1 : 2;
    return x > clearly * (best == 1 ? y : z) ? 0 : best;
}

static void axes_of(const struct span *span, int corners, int axis[2])
{
    const int main = main_axis(corners == 3 ? span->normal : span->along);
    axis[0] = corners == 3 ? (main + 1) % 3 : main;
    axis[1] = (main + 2) % 3;
}

void sites_axes(size_t count, const double *site, int corners, int axis[2])
{
    const struct span span = span_of(count, site);
    axes_of(&span, corners, axis);
}

void sites_extremes(size_t count, const double *site, size_t extreme[4])
{
    const struct span span = span_of(count, site);
    memcpy(extreme, span.extreme, sizeof span.extreme);
}

void sites_metric(size_t count, const double *site, const int axis[2], double m[2][2])
{
    const int a = axis[0], b = axis[1], c = 3 - a - b;
    double gram[2][2] = {{0}}, across[2] = {0}, mean[3] = {0};
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            mean[k] += site[3 * i + (size_t)k] / (double)count;
    for (size_t i = 0; i < count; i++) { /* the slopes of c over a and b, by least squares */
        const double *p = site + 3 * i, d[2] = {p[a] - mean[a], p[b] - mean[b]}, e = p[c] - mean[c];
        for (int k = 0; k < 2; k++) {
            across[k] += d[k] * e;
            for (int j = 0; j < 2; j++)
                gram[k][j] += d[k] * d[j];
        }
    }
    const double det = gram[0][0] * gram[1][1] - gram[0][1] * gram[0][1];
    const double u = det > 0 ? (across[0] * gram[1][1] - across[1] * gram[0][1]) / det : 0;
    const double v = det > 0 ? (across[1] * gram[0][0] - across[0] * gram[0][1]) / det : 0;
    m[0][0] = sqrt(1 + u * u);
    m[0][1] = u * v / m[0][0];
    m[1][0] = 0;
    m[1][1] = sqrt(1 + v * v - m[0][1] * m[0][1]);
}

static double number_noise(size_t count, const double *position)
{
    double most = 0;
    for (size_t i = 0; i < 3 * count; i++)
        most = fmax(most, fabs(position[i]));
    return most * 0x1p-52;
}

/* -- all together ----------------------------------------------------------------------------- */

static struct error *check_positions(size_t count, const double *position)
{
    if (!count)
        return error_new("there are no probes");
    if (count > INT32_MAX)
        return error_new("more than %d probes", INT32_MAX);
    for (size_t i = 0; i < 3 * count; i++)
        if (!isfinite(position[i]))
            return error_new("probe %zu: expected a finite position, got %g", i / 3, position[i]);
    return NULL;
}

enum { CHUNK = 16384 };

struct snapping {
    const struct lattice *lattice;
    size_t count;
    const double *position;
    double *snapped;
    struct place *place;
};

static struct error *snap_chunk(void *context, size_t index, int thread)
{
    (void)thread;
    const struct snapping *s = context;
    for (size_t i = index * CHUNK; i < (index + 1) * CHUNK && i < s->count; i++) {
        lattice_snap(s->lattice, s->position + 3 * i, s->snapped + 3 * i);
        s->place[i] = (struct place){hilbert_key(s->snapped + 3 * i), (int32_t)i};
    }
    return NULL;
}

/* The probes by site, and of those on one site the first. */
static struct error *gather(struct sites *sites, size_t count, const double *position,
                            const struct sites_settings *settings)
{
    double *snapped = NULL;
    struct place *place = NULL, *spare = NULL;
    struct error *err = array_create(&snapped, 3 * count, sizeof *snapped);
    if (!err)
        err = array_create(&place, count, sizeof *place);
    if (!err)
        err = array_create(&spare, count, sizeof *spare);
    struct snapping snapping = {&sites->lattice, count, position, snapped, place};
    if (!err)
        err = threads_for(settings->threads, (count + CHUNK - 1) / CHUNK, snap_chunk, &snapping);
    if (!err)
        sort_places(place, spare, count);
    free(spare);
    if (!err)
        err = array_create(&sites->site, 3 * count, sizeof *sites->site);
    if (!err)
        err = array_create(&sites->row, count, sizeof *sites->row);
    struct order order = {snapped, position, settings};
    for (size_t i = 0, end; i < count && !err; i = end) {
        for (end = i + 1; end < count && place[end].key == place[i].key;)
            end++;
        if (end > i + 1)
            qsort_r(place + i, end - i, sizeof *place, compare_places, &order);
        for (size_t k = i; k < end && !err; k++) {
            const double *site = snapped + 3 * (size_t)place[k].row;
            if (k > i && !compare_numbers(site, sites->site + 3 * (sites->count - 1))) {
                err = merge_row(sites, count, place[k].row, sites->row[sites->count - 1]);
                continue;
            }
            memcpy(sites->site + 3 * sites->count, site, 3 * sizeof *site);
            sites->row[sites->count++] = place[k].row;
        }
    }
    free(snapped);
    free(place);
    return err;
}

/* What the sites span, within a tolerance (steps). */
static void find_span(struct sites *sites, double tolerance)
{
    const struct span span = span_of(sites->count, sites->site);
    sites->corners = sites->count == 1          ? 1
                     : span.width <= tolerance  ? 2
                     : span.height <= tolerance ? 3
                                                : 4;
    axes_of(&span, sites->corners, sites->axis);
    memcpy(sites->extreme, span.extreme, sizeof span.extreme);
}

struct error *sites_make(struct sites *sites, size_t count, const double *position,
                         const struct sites_settings *settings)
{
    *sites = (struct sites){0};
    struct error *err = check_positions(count, position);
    if (err)
        return err;
    sites->lattice = lattice_fit(count, position);
    const double step = sites->lattice.step;
    err = gather(sites, count, position, settings);
    double side = 0;
    for (size_t i = 0; i < 3 * sites->count && !err; i++)
        side = fmax(side, sites->site[i]); /* the least is 0, up to rounding */
    const double reach = settings->merge * side;
    if (!err && reach > 1)
        err = merge_near(sites, count, reach, settings);
    const double tolerance =
        step > 0 ? fmax(fmax(4, reach), 4 * number_noise(count, position) / step) : 0;
    /* who is merged may have been an extreme one: what is left may span otherwise */
    for (size_t before = 0; !err && sites->count != before;) {
        before = sites->count;
        find_span(sites, tolerance);
        if (sites->corners == 3 || sites->corners == 2)
            err = merge_projected(sites, count, settings);
    }
    if (err)
        sites_clear(sites);
    return err;
}

void sites_clear(struct sites *sites)
{
    free(sites->site);
    free(sites->row);
    free(sites->merged);
    *sites = (struct sites){0};
}

lattice_volume sites_volume(int corners, const int axis[2], const double *const p[4])
{
    if (corners == 4)
        return lattice_orient(p[0], p[1], p[2], p[3]);
    int64_t d[2][2] = {{0}};
    for (int i = 1; i < corners; i++)
        for (int k = 0; k < corners - 1; k++)
            d[i - 1][k] = (int64_t)(p[i][axis[k]] - p[0][axis[k]]);
    if (corners == 3)
        return (lattice_volume)d[0][0] * d[1][1] - (lattice_volume)d[0][1] * d[1][0];
    return corners == 2 ? d[0][0] : 1;
}
