/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/measure.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/baked.h"
#include "math/sort.h"
#include "math/vec.h"
#include "measure/ruler.h"
#include "measure/sphere.h"
#include "measure/truth.h"
#include "stream/stream.h"
#include "trace/seen.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { FOR_PARTS = 16 }; /* what random numbers are for: part of their name */

/* -- points ----------------------------------------------------------------------------------- */

/* What one point says of the stream. */
struct point {
    bool inside;    /* of the hull */
    double surface; /* distance; NaN: there is none */
    double truth;   /* mean irradiance */
    /* mean over directions of e^2 without noise: of luminance; of the three colours */
    double square, colour;
    double relative;               /* measure.h's error */
    double relative_seen;          /* of the probes that it sees; NaN: not known */
    double blind;                  /* 1: sees none of its probes; NaN: there are no cells */
    double noise;                  /* of y^2 */
    double doubt;                  /* variance of square, by noise */
    double mean, absolute;         /* of e, of |e| */
    double bright, dark;           /* shares of the directions */
    double unseen;                 /* NaN: there are no cells */
    double cut_off, capture_noise; /* squares */
    double error[SPHERE_COUNT];    /* e */
};

struct job {
    const struct truth *truth;
    const struct baked *baked;
    const struct tracer *tracer;
    const struct measure_settings *settings;
    struct seen *seen; /* NULL: no blend by what is seen */
    struct sphere_basis basis;
    double scene_mean, floor;
    struct point *point;
};

/* The stream's irradiance at a place along the set, RGB. */
static struct error *place_light(const struct baked *baked, const struct sphere_basis *basis,
                                 const double p[3], const struct probe_place *place, double *rgb)
{
    double sh[3 * SH_COUNT_MAX];
    struct error *err = baked_light(baked, p, place, sh);
    if (!err)
        sphere_irradiance(basis, sh, 3, rgb);
    return err;
}

/* At p, whose place is found. */
static struct error *stream_light(const struct baked *baked, const struct sphere_basis *basis,
                                  const double p[3], struct probe_place *place, double *rgb)
{
    *place = (struct probe_place){.cell = PROBE_COLD};
    baked_locate(baked, p, place);
    return place_light(baked, basis, p, place, rgb);
}

/* Which of its probes the point sees, and what those alone would say. */
static struct error *measure_seen(const struct job *job, const double p[3],
                                  const struct probe_place *blend, const double *truth,
                                  const double *noise, struct point *point)
{
    const struct baked *baked = job->baked;
    double rgb[TRUTH_WIDTH], light[SPHERE_COUNT];
    struct probe_place place = *blend;
    struct seen_look look;
    point->unseen = point->relative_seen = point->blind = (double)NAN;
    if (!baked->cells)
        return NULL;
    seen_look(job->tracer, baked->position, p, &place, &look);
    point->unseen = look.unseen;
    if (baked_sees(baked)) { /* the blend is not all of the cell's */
        baked_locate_cell(baked, p, &place);
        seen_look(job->tracer, baked->position, p, &place, &look);
    }
    point->blind = look.blind;
    if (!job->seen)
        return NULL;
    seen_blend(job->seen, p, &look, &place);
    struct error *err = place_light(baked, &job->basis, p, &place, rgb);
    if (err)
        return err;
    sphere_luminance(rgb, light);
    point->relative_seen = ruler_error(light, truth, noise, job->floor);
    return NULL;
}

/* Mean over directions and colours of (s - T1)(s - T2). */
static double colour_square(const struct truth *t, size_t i, const double *rgb)
{
    double product[SPHERE_COUNT];
    for (size_t d = 0; d < SPHERE_COUNT; d++) {
        product[d] = 0;
        for (size_t k = 3 * d; k < 3 * d + 3; k++)
            product[d] += (rgb[k] - (double)t->half[0][TRUTH_WIDTH * i + k]) *
                          (rgb[k] - (double)t->half[1][TRUTH_WIDTH * i + k]) / 3;
    }
    return sphere_mean(product);
}

/* Luminance along the set, of one half of the truth. */
static void half_luminance(const struct truth *t, int half, size_t i, double *luminance)
{
    double rgb[TRUTH_WIDTH];
    for (size_t k = 0; k < TRUTH_WIDTH; k++)
        rgb[k] = (double)t->half[half][TRUTH_WIDTH * i + k];
    sphere_luminance(rgb, luminance);
}

/* Mean square, without noise, of what the order cuts off the truth. */
static double cut_off_square(const struct truth *t, size_t i, int order)
{
    double half[2][SPHERE_COUNT];
    for (int k = 0; k < 2; k++) {
        half_luminance(t, k, i, half[k]);
        sphere_cut_off(order, half[k]);
    }
    for (int d = 0; d < SPHERE_COUNT; d++)
        half[0][d] *= half[1][d];
    return sphere_mean(half[0]);
}

static struct error *measure_point(void *context, size_t i, int thread)
{
    (void)thread;
    const struct job *job = context;
    struct point *point = &job->point[i];
    const double *p = job->truth->position + 3 * i,
                 tolerance = job->settings->tolerance * job->scene_mean;
    double rgb[TRUTH_WIDTH], light[SPHERE_COUNT], truth[SPHERE_COUNT], y[SPHERE_COUNT];
    struct probe_place place;
    struct error *err = stream_light(job->baked, &job->basis, p, &place, rgb);
    if (err)
        return error_wrap(err, "point %g,%g,%g", p[0], p[1], p[2]);
    sphere_luminance(rgb, light);
    truth_luminance(job->truth, i, truth, y);
    double square[SPHERE_COUNT], noise[SPHERE_COUNT], mixed[SPHERE_COUNT], absolute[SPHERE_COUNT],
        bright[SPHERE_COUNT], dark[SPHERE_COUNT];
    for (int d = 0; d < SPHERE_COUNT; d++) {
        const double x = light[d] - truth[d];
        point->error[d] = x;
        square[d] = x * x - y[d] * y[d];
        noise[d] = y[d] * y[d];
        mixed[d] = 2 * x * y[d];
        absolute[d] = fabs(x);
        bright[d] = x > tolerance;
        dark[d] = x < -tolerance;
    }
    point->relative = ruler_error(light, truth, noise, job->floor);
    err = measure_seen(job, p, &place, truth, noise, point);
    if (err)
        return error_wrap(err, "point %g,%g,%g", p[0], p[1], p[2]);
    point->inside = place.inside;
    point->surface = (double)job->truth->surface[i];
    point->truth = sphere_mean(truth);
    point->square = sphere_mean(square);
    point->colour = colour_square(job->truth, i, rgb);
    point->noise = sphere_mean(noise);
    point->doubt = sphere_mean(mixed) * sphere_mean(mixed) + 4.0 / 3 * point->noise * point->noise;
    point->mean = sphere_mean(point->error);
    point->absolute = sphere_mean(absolute);
    point->bright = sphere_mean(bright);
    point->dark = sphere_mean(dark);
    point->cut_off = cut_off_square(job->truth, i, job->baked->order);
    point->capture_noise = baked_noise(job->baked, &place);
    return NULL;
}

static double point_mean(const struct truth *t, size_t i)
{
    double mean[SPHERE_COUNT];
    truth_luminance(t, i, mean, NULL);
    return sphere_mean(mean);
}

static double scene_mean(const struct truth *t)
{
    double sum = 0;
    for (size_t i = 0; i < t->points; i++)
        sum += point_mean(t, i);
    return sum / (double)t->points;
}

/* The truth's white (ruler.h). */
static struct error *scene_white(const struct truth *t, double *white)
{
    float *mean = NULL;
    struct error *err = array_create(&mean, t->points, sizeof *mean);
    for (size_t i = 0; i < t->points && !err; i++)
        mean[i] = (float)point_mean(t, i);
    if (!err)
        err = ruler_white(t->points, mean, white);
    free(mean);
    return err;
}

/* -- parts ------------------------------------------------------------------------------------ */

/* One |e| of a part. */
struct value {
    double error;
    uint32_t point; /* of the part */
    uint32_t direction;
};

static int compare_values(const void *a, const void *b)
{
    const struct value *x = a, *y = b; /* largest first */
    if (x->error != y->error)
        return x->error > y->error ? -1 : 1;
    if (x->point != y->point)
        return x->point < y->point ? -1 : 1;
    return x->direction < y->direction ? -1 : x->direction > y->direction;
}

/* The figures that have intervals. */
enum {
    ERROR,
    BAD,
    ERROR_SEEN,
    BAD_SEEN,
    BLIND,
    RMS,
    RMS_COLOUR,
    BIAS,
    MEAN,
    P95,
    P99,
    BRIGHT,
    DARK,
    UNSEEN,
    FIGURES
};

static const struct {
    const char *name;
    bool light; /* and so has a form relative to the scene's mean */
} figures[FIGURES] = {[ERROR] = {"error", false},
                      [BAD] = {"bad", false},
                      [ERROR_SEEN] = {"error_seen", false},
                      [BAD_SEEN] = {"bad_seen", false},
                      [BLIND] = {"blind_points", false},
                      [RMS] = {"rms", true},
                      [RMS_COLOUR] = {"rms_colour", true},
                      [BIAS] = {"bias", true},
                      [MEAN] = {"mean", true},
                      [P95] = {"p95", true},
                      [P99] = {"p99", true},
                      [BRIGHT] = {"too_bright", false},
                      [DARK] = {"too_dark", false},
                      [UNSEEN] = {"unseen", false}};

/* A part of the points. */
struct part {
    const struct point *point;
    double bad;    /* an error above this is */
    size_t *index; /* of its points; owned */
    size_t count;
    struct value *value;     /* SPHERE_COUNT * count, owned */
    double (*term)[FIGURES]; /* what each point adds to a figure, or to its square; owned */
};

/* What a point adds; percentiles have no terms. */
static void set_terms(const struct part *part, const struct point *p, double *term)
{
    const double terms[FIGURES] = {[ERROR] = p->relative,
                                   [BAD] = p->relative > part->bad,
                                   [ERROR_SEEN] = p->relative_seen,
                                   [BAD_SEEN] = p->relative_seen > part->bad,
                                   [BLIND] = p->blind,
                                   [RMS] = p->square,
                                   [RMS_COLOUR] = p->colour,
                                   [BIAS] = p->mean,
                                   [MEAN] = p->absolute,
                                   [BRIGHT] = p->bright,
                                   [DARK] = p->dark,
                                   [UNSEEN] = p->unseen};
    memcpy(term, terms, sizeof terms);
}

static void reckon(const void *context, const uint32_t *times, double *figure)
{
    const struct part *part = context;
    double sum[FIGURES] = {0};
    const double n = (double)part->count;
    for (size_t i = 0; i < part->count; i++)
        for (int f = 0; f < FIGURES; f++)
            sum[f] += times[i] * part->term[i][f];
    for (int f = 0; f < FIGURES; f++) {
        const bool root = f == RMS || f == RMS_COLOUR; /* noise may leave less than nothing */
        figure[f] = root ? sqrt(fmax(sum[f] / n, 0)) : sum[f] / n;
    }
    double above = 0; /* share of the values that are larger */
    size_t k = 0;
    for (int f = P99; f >= P95; f--) {
        const double most = f == P99 ? 0.01 : 0.05;
        for (; k < SPHERE_COUNT * part->count; k++) {
            const double share = times[part->value[k].point] *
                                 sphere_weight[part->value[k].direction] / n;
            if (above + share > most + 1e-12)
                break;
            above += share;
        }
        figure[f] = k < SPHERE_COUNT * part->count ? part->value[k].error : 0;
    }
}

static struct error *report_light(struct report *report, const char *name, const char *of,
                                  struct estimate e, double scene_mean_irradiance)
{
    char relative[32];
    struct error *err = report_add(report, name, of, e);
    if (err || !(scene_mean_irradiance > 0))
        return err;
    snprintf(relative, sizeof relative, "%s_relative", name);
    const double s = 1 / scene_mean_irradiance;
    return report_add(report, relative, of, (struct estimate){s * e.value, s * e.low, s * e.high});
}

static struct estimate alone(double value)
{
    return (struct estimate){value, (double)NAN, (double)NAN};
}

/* What a part's points say in the mean. */
struct means {
    double truth, noise, noise_mean, cut_off, capture_noise;
    double doubt; /* over the number of points once more: that of the mean */
};

static struct means means_of(const struct part *part)
{
    struct means means = {0};
    const double n = (double)part->count;
    for (size_t i = 0; i < part->count; i++) {
        const struct point *p = &part->point[part->index[i]];
        means.truth += p->truth / n;
        means.noise += p->noise / n;
        means.noise_mean += sqrt(p->noise) / n;
        means.doubt += p->doubt / n / n;
        means.cut_off += p->cut_off / n;
        means.capture_noise += p->capture_noise / n;
    }
    return means;
}

/* The worst error, and where it is. */
static struct error *report_worst(struct report *report, const struct job *job,
                                  const struct part *part, const char *of)
{
    static const char *const axes[3] = {"worst_x", "worst_y", "worst_z"};
    const double *worst = job->truth->position + 3 * part->index[part->value[0].point];
    struct error *err =
        report_light(report, "worst", of, alone(part->value[0].error), job->scene_mean);
    for (int k = 0; k < 3 && !err; k++)
        err = report_add_number(report, axes[k], of, worst[k]);
    return err;
}

/* Adds the part's figures to the report. */
static struct error *report_part(struct report *report, const struct job *job, struct part *part,
                                 const char *of, uint64_t name)
{
    struct estimate estimate[FIGURES];
    struct error *err = report_add_number(report, "points", of, (double)part->count);
    if (err || !part->count)
        return err;
    err = array_create(&part->value, SPHERE_COUNT * part->count, sizeof *part->value);
    if (!err)
        err = array_create(&part->term, part->count, sizeof *part->term);
    for (size_t i = 0; i < part->count && !err; i++) {
        const struct point *p = &part->point[part->index[i]];
        set_terms(part, p, part->term[i]);
        for (size_t d = 0; d < SPHERE_COUNT; d++)
            part->value[SPHERE_COUNT * i + d] =
                (struct value){fabs(p->error[d]), (uint32_t)i, (uint32_t)d};
    }
    if (!err) {
        qsort(part->value, SPHERE_COUNT * part->count, sizeof *part->value, compare_values);
        const struct bootstrap_job sets = {.count = part->count,
                                           .seed = job->settings->seed,
                                           .name = name,
                                           .figures = FIGURES,
                                           .reckon = reckon,
                                           .context = part,
                                           .threads = job->settings->threads};
        err = bootstrap(&sets, estimate);
    }
    const struct means mean = means_of(part);
    if (!err)
        err = report_light(report, "irradiance", of, alone(mean.truth), job->scene_mean);
    if (!err)
        err = report_light(report, "noise", of, alone(sqrt(mean.noise)), job->scene_mean);
    if (!err)
        err = report_light(report, "noise_mean", of, alone(mean.noise_mean), job->scene_mean);
    if (!err && job->baked->order <= SPHERE_ORDER)
        err = report_light(report, "cut_off", of, alone(sqrt(fmax(mean.cut_off, 0))),
                           job->scene_mean);
    if (!err && !isnan(mean.capture_noise))
        err = report_light(report, "capture_noise", of, alone(sqrt(mean.capture_noise)),
                           job->scene_mean);
    for (int f = 0; f < FIGURES && !err; f++) {
        if ((f == UNSEEN || f == BLIND) && !job->baked->cells)
            continue;
        if ((f == ERROR_SEEN || f == BAD_SEEN) && !job->seen)
            continue;
        err = figures[f].light
                  ? report_light(report, figures[f].name, of, estimate[f], job->scene_mean)
                  : report_add(report, figures[f].name, of, estimate[f]);
    }
    if (err)
        return err;
    /* Of a root: by its slope, but where that is steep, near 0, by the root of the doubt. */
    const double doubt = sqrt(mean.doubt), root = sqrt(doubt),
                 slope = estimate[RMS].value > 0 ? doubt / (2 * estimate[RMS].value) : root;
    err = report_light(report, "rms_noise", of, alone(fmin(slope, root)), job->scene_mean);
    return err ? err : report_worst(report, job, part, of);
}

enum which { ALL, INSIDE, OUTSIDE, QUARTER, LIT = QUARTER + 4, DIM, SEEN, LEAKY, PARTS };

static bool belongs(const struct job *job, const struct point *p, enum which which,
                    const double quarter[5])
{
    const bool dim = p->truth<job->settings->dark * job->scene_mean, leaky = p->unseen> 0;
    const int k = (int)which - QUARTER;
    switch (which) {
    case ALL: return true;
    case INSIDE: return p->inside;
    case OUTSIDE: return !p->inside;
    case LIT: return !dim;
    case DIM: return dim;
    case SEEN: return !leaky;
    case LEAKY: return leaky;
    default:
        return p->surface >= quarter[k] &&
               (p->surface < quarter[k + 1] || (k == 3 && p->surface <= quarter[4]));
    }
}

/* Distances from the nearest surface that cut the points into quarters; false: there is no
 * surface. */
static struct error *find_quarters(const struct job *job, double quarter[5], bool *there)
{
    double *distance = NULL;
    const size_t n = job->truth->points;
    size_t known = 0;
    *there = false;
    struct error *err = array_create(&distance, n, sizeof *distance);
    for (size_t i = 0; i < n && !err; i++) {
        distance[i] = job->point[i].surface;
        known += isnan(distance[i]) ? 0 : 1;
    }
    if (!err && known == n) {
        sort_doubles(n, distance);
        for (size_t k = 0; k < 5; k++)
            quarter[k] = distance[k < 4 ? k * n / 4 : n - 1];
        *there = true;
    }
    free(distance);
    return err;
}

static struct error *report_parts(struct report *report, const struct job *job)
{
    static const char *const names[PARTS] = {
        "all",       "inside-hull", "outside-hull", "surface-1", "surface-2",  "surface-3",
        "surface-4", "lit",         "dark",         "all-seen",  "some-unseen"};
    double quarter[5];
    bool surfaces;
    struct error *err = find_quarters(job, quarter, &surfaces);
    for (int which = 0; which < PARTS && !err; which++) {
        const int k = which - QUARTER;
        const bool by_surface = k >= 0 && k < 4;
        struct part part = {.point = job->point, .bad = job->settings->bad};
        if ((by_surface && !surfaces) || (which >= SEEN && !job->baked->cells))
            continue;
        err = array_create(&part.index, job->truth->points, sizeof *part.index);
        for (size_t i = 0; i < job->truth->points && !err; i++)
            if (belongs(job, &job->point[i], (enum which)which, quarter))
                part.index[part.count++] = i;
        if (!err)
            err = report_part(report, job, &part, names[which], (uint64_t)(FOR_PARTS + which));
        if (!err && by_surface)
            err = report_add_number(report, "surface_from", names[which], quarter[k]);
        if (!err && by_surface)
            err = report_add_number(report, "surface_to", names[which], quarter[k + 1]);
        free(part.index);
        free(part.value);
        free(part.term);
    }
    return err;
}

static struct error *fill_map(struct table *map, const struct job *job)
{
    static const char *const names[] = {"error", "error_seen", "rms",    "bias",
                                        "truth", "unseen",     "surface"};
    enum { NAMES = sizeof names / sizeof *names };
    struct error *err = table_resize(map, job->truth->points);
    if (!err)
        err = table_add_column(map, "position", COLUMN_F64, 3, NULL);
    for (int k = 0; k < NAMES && !err; k++)
        err = table_add_column(map, names[k], COLUMN_F32, 1, NULL);
    if (!err)
        err = table_add_column(map, "outside", COLUMN_I32, 1, NULL);
    if (err)
        return err;
    memcpy(table_column(map, "position")->data, job->truth->position,
           3 * map->rows * sizeof(double));
    for (size_t i = 0; i < map->rows; i++) {
        const struct point *p = &job->point[i];
        const double value[NAMES] = {p->relative, p->relative_seen, sqrt(fmax(p->square, 0)),
                                     p->mean,     p->truth,         p->unseen,
                                     p->surface};
        for (int k = 0; k < NAMES; k++)
            column_f32(table_column(map, names[k]))[i] = (float)value[k];
        column_i32(table_column(map, "outside"))[i] = !p->inside;
    }
    return NULL;
}

struct error *measure_error(struct report *report, const struct truth *truth,
                            const struct baked *baked, const struct tracer *tracer,
                            const struct measure_settings *settings, struct table *map)
{
    struct job job = {.truth = truth,
                      .baked = baked,
                      .tracer = tracer,
                      .settings = settings,
                      .scene_mean = scene_mean(truth),
                      .basis = sphere_basis_make(baked->order, baked->convolved)};
    double white = 0;
    struct error *err = array_create(&job.point, truth->points, sizeof *job.point);
    if (!err)
        err = scene_white(truth, &white);
    job.floor = RULER_FLOOR * white;
    if (!err && baked_blends(baked))
        err = seen_create(&job.seen, tracer, baked->probe_count, baked->position, baked->sh,
                          baked->width);
    if (!err)
        err = threads_for(settings->threads, truth->points, measure_point, &job);
    if (!err)
        err = report_add_number(report, "white", "all", white);
    if (!err)
        err = report_parts(report, &job);
    if (!err && map)
        err = fill_map(map, &job);
    seen_destroy(job.seen);
    free(job.point);
    return err;
}

/* -- change ----------------------------------------------------------------------------------- */

enum { WINDOW = 8 }; /* steps on either side whose truth one of the stream's is held against */

/* One step along a path: mean squares over directions, per length squared. */
struct step {
    double stream, truth, noise;
    int32_t path;
};

static struct step make_step(double now[3][SPHERE_COUNT], double before[3][SPHERE_COUNT],
                             double length, int32_t path)
{
    double product[3][SPHERE_COUNT];
    for (int d = 0; d < SPHERE_COUNT; d++) {
        const double s = (now[0][d] - before[0][d]) / length,
                     a = (now[1][d] - before[1][d]) / length,
                     b = (now[2][d] - before[2][d]) / length;
        product[0][d] = s * s;
        product[1][d] = a * b;
        product[2][d] = (a - b) * (a - b) / 4;
    }
    return (struct step){sphere_mean(product[0]), sphere_mean(product[1]), sphere_mean(product[2]),
                         path};
}

/* The steps along all paths. */
static struct error *take_steps(const struct truth *t, const struct baked *baked, struct step *step,
                                size_t *count, size_t *paths)
{
    const struct sphere_basis basis = sphere_basis_make(baked->order, baked->convolved);
    double before[3][SPHERE_COUNT] = {{0}}, now[3][SPHERE_COUNT];
    for (size_t i = t->points; i < t->count; i++) {
        const double *p = t->position + 3 * i;
        double rgb[TRUTH_WIDTH];
        struct probe_place place;
        struct error *err = stream_light(baked, &basis, p, &place, rgb);
        if (err)
            return error_wrap(err, "point %g,%g,%g", p[0], p[1], p[2]);
        sphere_luminance(rgb, now[0]);
        half_luminance(t, 0, i, now[1]);
        half_luminance(t, 1, i, now[2]);
        const bool goes_on = i > t->points && t->path[i] == t->path[i - 1];
        const double length = goes_on ? vec3_length(vec3_sub(vec3_load(p), vec3_load(p - 3))) : 0;
        *paths += !goes_on;
        if (length > 0)
            step[(*count)++] = make_step(now, before, length, t->path[i]);
        memcpy(before, now, sizeof before);
    }
    return NULL;
}

/* Mean square of the truth's change in the window about a step, on its path. */
static double around(const struct step *step, size_t count, size_t i)
{
    double sum = 0, n = 0;
    for (size_t k = i > WINDOW ? i - WINDOW : 0; k < count && k <= i + WINDOW; k++) {
        if (step[k].path != step[i].path)
            continue;
        sum += step[k].truth;
        n++;
    }
    return fmax(sum / n, 0);
}

static struct error *report_steps(struct report *report, const struct step *step, size_t count,
                                  double mean)
{
    double stream = 0, truth = 0, noise = 0, stream_most = 0, truth_most = 0, excess = 0;
    const double n = (double)count;
    for (size_t i = 0; i < count; i++) {
        stream += step[i].stream / n;
        truth += step[i].truth / n;
        noise += step[i].noise / n;
        stream_most = fmax(stream_most, step[i].stream);
        truth_most = fmax(truth_most, step[i].truth);
        excess = fmax(excess, sqrt(step[i].stream) - sqrt(around(step, count, i)));
    }
    struct error *err = report_light(report, "change_rms", "probes", alone(sqrt(stream)), mean);
    if (!err)
        err = report_light(report, "change_most", "probes", alone(sqrt(stream_most)), mean);
    if (!err)
        err = report_light(report, "change_excess", "probes", alone(excess), mean);
    if (!err)
        err = report_light(report, "change_rms", "truth", alone(sqrt(fmax(truth, 0))), mean);
    if (!err)
        err = report_light(report, "change_most", "truth", alone(sqrt(truth_most)), mean);
    if (!err)
        err = report_light(report, "change_noise", "truth", alone(sqrt(noise)), mean);
    return err;
}

struct error *measure_change(struct report *report, const struct truth *t,
                             const struct baked *baked)
{
    struct step *step = NULL;
    size_t count = 0, paths = 0;
    struct error *err = array_create(&step, t->count - t->points, sizeof *step);
    if (!err)
        err = take_steps(t, baked, step, &count, &paths);
    if (!err && count)
        err = report_add_number(report, "paths", "all", (double)paths);
    if (!err && count)
        err = report_add_number(report, "change_steps", "all", (double)count);
    if (!err && count)
        err = report_add_number(report, "step", "all", t->step);
    if (!err && count)
        err = report_steps(report, step, count, scene_mean(t));
    free(step);
    return err;
}
