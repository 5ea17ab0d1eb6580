/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Sloan, "Deringing spherical harmonics", SIGGRAPH Asia 2017 technical briefs: a window
 * of its own for each probe. Sloan, "Stupid spherical harmonics (SH) tricks", GDC 2008, "Ringing
 * and windowing". Axler, Bourdon, Ramey, "Harmonic function theory", 2nd ed., 2001, ch. 5: the
 * Poisson kernel, r^l in band l. */
#include "light/dering.h"
#include "base/array.h"
#include "base/error.h"
#include "base/number.h"
#include "base/threads.h"
#include "libprobe-query/sh.h"
#include "light/content.h"
#include "math/vec.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const target_names[] = {
    [DERING_NONE] = "none", [DERING_IRRADIANCE] = "irradiance", [DERING_RADIANCE] = "radiance"};

/* -- header ----------------------------------------------------------------------------------- */

struct error *dering_to_header(const struct dering_settings *settings, struct stream_header *header)
{
    char number[NUMBER_ROOM], text[NUMBER_ROOM + 16];
    if (settings->target == DERING_NONE) {
        header_remove_key(header, "sh-dering");
        return NULL;
    }
    *number_write_f64(number, settings->floor) = '\0';
    snprintf(text, sizeof text, "%s %s", target_names[settings->target], number);
    return header_set_key(header, "sh-dering", text);
}

struct error *dering_from_header(struct dering_settings *settings,
                                 const struct stream_header *header)
{
    const char *text = header_key(header, "sh-dering");
    *settings = (struct dering_settings){0};
    for (int i = DERING_IRRADIANCE; text && i <= DERING_RADIANCE; i++) {
        const size_t length = strlen(target_names[i]);
        const char *end = text + strlen(text);
        double floor;
        if (strncmp(text, target_names[i], length) || text[length] != ' ' ||
            number_read_f64(text + length + 1, end, &floor) != end ||
            !(floor >= 0 && floor <= DERING_FLOOR_MOST))
            continue;
        *settings = (struct dering_settings){.target = (enum dering_target)i, .floor = floor};
        return NULL;
    }
    return text ? error_new("header key sh-dering: expected irradiance or radiance and a floor "
                            "from 0 to %g, got '%s'",
                            DERING_FLOOR_MOST, text)
                : NULL;
}

/* -- the minimum over the sphere -------------------------------------------------------------- */

/* One channel under a window, cut into spherical triangles. At its minimum x a smooth f is level,
 * so f(m) <= f(x) + bend/2 d^2 for any m at the angle d from x, where no second derivative along a
 * great circle exceeds `bend`. So a triangle whose middle is at least bend/2 d^2 above the level, d
 * its radius, does not hold a minimum below it; others are cut in four. */
struct search {
    int order;
    double f[SH_COUNT_MAX];
    double bend, level, slack;
    int left; /* triangles that may still be looked at */
};

enum { WORK_MOST = 1 << 18 };

/* Second derivative along any great circle of a sum of band l whose coefficients have length 1:
 * sqrt of the fourth derivative of the band's reproducing kernel (2l+1)/(4 pi) P_l(cos t) at 0,
 * P_l'''' = k (3k - 2) / 8, k = l (l + 1) (Cauchy and Schwarz). */
static double band_bend(int l)
{
    static const double root[SH_ORDER_MAX] = {
        0, 1, 3.4641016151377544, 7.14142842854285, 12.041594578792296, 18.16590212458495};
    static const double norm[SH_ORDER_MAX] = {SH_Y00,
                                              0.48860251190292,
                                              0.6307831305050401,
                                              0.7463526651802308,
                                              0.8462843753216345,
                                              0.9356025796273889};
    return root[l] * norm[l];
}

static double value_at(const struct search *s, struct vec3 d)
{
    double y[SH_COUNT_MAX], sum = 0;
    sh_basis(s->order, (const double[3]){d.x, d.y, d.z}, y);
    for (int i = 0; i < s->order * s->order; i++)
        sum += s->f[i] * y[i];
    return sum;
}

static bool triangle_is_above(struct search *s, struct vec3 a, struct vec3 b, struct vec3 c)
{
    const struct vec3 m = vec3_normalize(vec3_add(a, vec3_add(b, c)));
    const struct vec3 corner[3] = {a, b, c};
    const double value = value_at(s, m);
    if (value < s->level || s->left-- <= 0)
        return false;
    double chord = 0; /* squared */
    for (int i = 0; i < 3; i++) {
        const struct vec3 way = vec3_sub(corner[i], m);
        chord = fmax(chord, vec3_dot(way, way));
    }
    /* an angle is at most twice the tangent of its half */
    const double drop = 0.5 * s->bend * chord / (1 - chord / 4);
    if (value - drop >= s->level)
        return true;
    if (drop < s->slack)
        return false;
    const struct vec3 ab = vec3_normalize(vec3_add(a, b)), bc = vec3_normalize(vec3_add(b, c)),
                      ca = vec3_normalize(vec3_add(c, a));
    return triangle_is_above(s, ab, bc, ca) && triangle_is_above(s, a, ab, ca) &&
           triangle_is_above(s, b, bc, ab) && triangle_is_above(s, c, ca, bc);
}

bool dering_is_above(int order, const double *f, double level, double slack)
{
    struct search s = {.order = order, .level = level, .slack = slack, .left = WORK_MOST};
    for (int l = 0, i = 0; l < order; l++) {
        double square = 0;
        for (; i < (l + 1) * (l + 1); i++) {
            s.f[i] = f[i];
            square += f[i] * f[i];
        }
        s.bend += band_bend(l) * sqrt(square);
    }
    bool above = true;
    for (int i = 0; i < 8 && above; i++) { /* octants */
        const struct vec3 x = {i & 1 ? -1 : 1, 0, 0}, y = {0, i & 2 ? -1 : 1, 0},
                          z = {0, 0, i & 4 ? -1 : 1};
        above = triangle_is_above(&s, x, y, z);
    }
    return above;
}

/* -- one probe -------------------------------------------------------------------------------- */

/* A probe's channels, each as the function that must stay above the floor, over its mean. Those
 * without light are left out. */
struct channels {
    int order, count;
    double f[3][SH_COUNT_MAX];
    bool hopeless; /* a mean below 0, or of 0 where there is light */
};

static void make_channels(struct channels *c, enum dering_target target, int order, bool convolved,
                          const float *sh)
{
    *c = (struct channels){.order = order};
    for (int k = 0; k < 3; k++) {
        double *f = c->f[c->count], most = 0;
        for (int l = 0, i = 0; l < order; l++) {
            const double factor = target == DERING_IRRADIANCE ? (convolved ? 1 : sh_cosine(l))
                                                              : (convolved ? 1 / sh_cosine(l) : 1);
            for (; i < (l + 1) * (l + 1); i++) {
                f[i] = factor * (double)sh[3 * i + k];
                most = fmax(most, fabs(f[i]));
            }
        }
        const double mean = f[0] * SH_Y00;
        if (!(most > 0))
            continue;
        if (!(mean > 0)) {
            c->hopeless = true;
            return;
        }
        for (int i = 0; i < order * order; i++)
            f[i] /= mean;
        c->count++;
    }
}

static bool window_is_enough(const struct channels *c, double r, double level)
{
    for (int k = 0; k < c->count; k++) {
        double f[SH_COUNT_MAX], factor = 1;
        for (int l = 0, i = 0; l < c->order; l++, factor *= r)
            for (; i < (l + 1) * (l + 1); i++)
                f[i] = factor * c->f[k][i];
        if (!dering_is_above(c->order, f, level, DERING_TOLERANCE / 4))
            return false;
    }
    return true;
}

double dering_window(const struct dering_settings *settings, int order, bool convolved,
                     const float *sh)
{
    struct channels c;
    make_channels(&c, settings->target, order, convolved, sh);
    if (c.hopeless)
        return -1;
    if (window_is_enough(&c, 1, settings->floor))
        return 1;
    double enough = 0, step = 0.5;
    for (int bit = 0; bit < 24; bit++, step /= 2)
        if (window_is_enough(&c, enough + step, settings->floor + DERING_TOLERANCE / 2))
            enough += step;
    return enough;
}

void dering_apply(int order, double r, float *sh, float *error, float *gradient)
{
    double factor[SH_ORDER_MAX] = {1};
    for (int l = 1; l < order; l++)
        factor[l] = r * factor[l - 1];
    sh_scale_bands(order, factor, sh);
    if (error)
        sh_scale_bands(order, factor, error);
    for (int axis = 0; gradient && axis < 3; axis++)
        sh_scale_bands(order, factor, gradient + axis * 3 * order * order);
}

/* -- tables ----------------------------------------------------------------------------------- */

struct job {
    const struct dering_settings *settings;
    bool convolved;
    int order;
    const struct table *probes; /* whose columns of the scene's light are windowed with sh: */
    float *sh, *window;
    double *r; /* what each probe needed; NaN: it has no light */
};

/* Puts a probe's window on all of its light of the scene; the response to other light has none. */
static void window_row(const struct job *job, size_t row, double r)
{
    const size_t width = (size_t)(3 * job->order * job->order);
    for (size_t i = 0; i < job->probes->column_count; i++) {
        const struct column *c = &job->probes->columns[i];
        struct light_column what;
        if (!light_column_of(c, width, &what) || what.surface || what.transfer)
            continue;
        for (size_t k = 0; k < what.blocks; k++)
            dering_apply(job->order, r, column_f32(c) + (row * what.blocks + k) * width, NULL,
                         NULL);
    }
}

static struct error *dering_one(void *context, size_t row, int thread)
{
    (void)thread;
    const struct job *job = context;
    const size_t width = (size_t)(3 * job->order * job->order);
    const float *sh = job->sh + row * width;
    job->r[row] = (double)NAN;
    if (isnan(sh[0]))
        return NULL;
    const double r = job->r[row] = dering_window(job->settings, job->order, job->convolved, sh);
    const double before = isnan(job->window[row]) ? 1 : (double)job->window[row];
    job->window[row] = (float)before;
    if (r < 0 || r == 1)
        return NULL;
    job->window[row] = (float)(before * r);
    window_row(job, row, r);
    return NULL;
}

static float *values(const struct table *table, const char *name)
{
    const struct column *column = table_column(table, name);
    return column ? column_f32(column) : NULL;
}

struct error *dering_table(struct table *probes, const struct dering_settings *settings,
                           bool convolved, int threads, struct dering_count *count)
{
    struct column *sh;
    struct job job = {.settings = settings, .convolved = convolved};
    *count = (struct dering_count){.least = 1};
    struct error *err = table_require(probes, "sh", COLUMN_F32, 0, &sh);
    if (!err && convolved && settings->target == DERING_RADIANCE &&
        sh_order_of(sh->width) > CONTENT_RADIANCE_ORDER_MAX)
        err = error_new("radiance cannot be known from irradiance of an order above %d",
                        CONTENT_RADIANCE_ORDER_MAX);
    if (!err && !table_column(probes, "sh_window"))
        err = table_add_column(probes, "sh_window", COLUMN_F32, 1, NULL);
    if (!err)
        err = array_create(&job.r, probes->rows, sizeof *job.r);
    if (!err) {
        job.order = sh_order_of(table_column(probes, "sh")->width);
        job.sh = values(probes, "sh");
        job.probes = probes;
        job.window = values(probes, "sh_window");
        err = threads_for(threads, probes->rows, dering_one, &job);
    }
    for (size_t i = 0; i < probes->rows && !err; i++) {
        const double r = job.r[i];
        count->probes += isnan(r) ? 0 : 1;
        count->hopeless += r < 0;
        count->changed += r >= 0 && r < 1;
        count->least = r >= 0 && r < count->least ? r : count->least;
    }
    free(job.r);
    return err;
}

void dering_count_add(struct dering_count *count, const struct table *probes)
{
    const struct column *window = table_column(probes, "sh_window");
    for (size_t i = 0; window && i < probes->rows; i++) {
        const double r = (double)column_f32(window)[i];
        count->probes += isnan(r) ? 0 : 1;
        count->changed += r < 1;
        count->least = r < count->least ? r : count->least;
    }
}
