/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/sun_blend.h"
#include "base/error.h"
#include "base/file.h"
#include "base/number.h"
#include "math/angle.h"
#include "math/convex.h"
#include "math/vec.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

static double angle_between(struct vec3 a, struct vec3 b)
{
    return angle_atan2(vec3_length(vec3_cross(a, b)), vec3_dot(a, b));
}

/* -- a way ------------------------------------------------------------------------------------ */

/* The point of the great arc from a to b that is nearest to d: its share of the arc; how far off d
 * is. Opposite ends have no arc between them. */
static double along_arc(struct vec3 a, struct vec3 b, struct vec3 d, double *share)
{
    const struct vec3 pole = vec3_normalize(vec3_cross(a, b));
    const double whole = angle_between(a, b), to_a = angle_between(a, d),
                 to_b = angle_between(b, d);
    *share = to_a <= to_b ? 0 : 1;
    const double nearest = fmin(to_a, to_b);
    if (vec3_dot(pole, pole) < 0.5 || whole < 1e-9)
        return nearest;
    const struct vec3 foot = vec3_normalize(vec3_fma(d, -vec3_dot(d, pole), pole));
    const double at = angle_atan2(vec3_dot(vec3_cross(a, foot), pole), vec3_dot(a, foot));
    if (!(at >= 0 && at <= whole))
        return nearest;
    *share = at / whole;
    return angle_between(d, foot);
}

static double blend_path(size_t count, const double *sun, struct vec3 d, double *weight)
{
    size_t first = 0;
    double best = angle_between(vec3_load(sun), d), best_share = 0;
    for (size_t i = 0; i + 1 < count; i++) {
        double share;
        const double off = along_arc(vec3_load(sun + 3 * i), vec3_load(sun + 3 * i + 3), d, &share);
        if (off < best) {
            best = off;
            best_share = share;
            first = i;
        }
    }
    weight[first] += 1 - best_share;
    if (best_share > 0)
        weight[first + 1] += best_share;
    return best;
}

/* -- the sphere ------------------------------------------------------------------------------- */

static double blend_sphere(size_t count, const double *sun, struct vec3 d, double *weight)
{
    /* the facet of the suns' hull that d pierces: no other triangle along d lies farther out */
    const double target[3] = {d.x, d.y, d.z};
    struct convex c;
    double sum = 0;
    if (convex_least(3, count, sun, NULL, target, &c)) {
        for (int k = 0; k < c.count; k++)
            sum += c.share[k];
        for (int k = 0; k < c.count; k++)
            weight[c.point[k]] += c.share[k] / sum;
        return 0;
    }
    size_t first = 0, second = 0;
    double off = angle_between(vec3_load(sun), d), best_share = 0;
    for (size_t i = 0; i < count; i++)
        for (size_t j = i + 1; j < count; j++) {
            double share;
            const double is = along_arc(vec3_load(sun + 3 * i), vec3_load(sun + 3 * j), d, &share);
            if (is < off - 1e-12) {
                off = is;
                best_share = share;
                first = i, second = j;
            }
        }
    weight[first] += 1 - best_share;
    weight[second] += best_share;
    return off;
}

double sun_blend(enum sun_between between, size_t count, const double *sun, const double d[3],
                 double *weight)
{
    memset(weight, 0, count * sizeof *weight);
    const double off = between == SUN_PATH ? blend_path(count, sun, vec3_load(d), weight)
                                           : blend_sphere(count, sun, vec3_load(d), weight);
    return off * (180 / ANGLE_PI);
}

/* -- a day ------------------------------------------------------------------------------------ */

enum { NUMBERS = 6 };

/* The numbers of a line; *count 0: it holds none. */
static struct error *read_numbers(const char *line, size_t length, double value[NUMBERS],
                                  size_t *count)
{
    static const char expected[] = "expected TIME AZIMUTH ELEVATION R G B";
    const char *comment = memchr(line, '#', length), *end = comment ? comment : line + length;
    *count = 0;
    for (const char *at = line;;) {
        while (at < end && (*at == ' ' || *at == '\t' || *at == ',' || *at == '\r'))
            at++;
        if (at == end)
            break;
        double number;
        const char *next = number_read_f64(at, end, &number);
        if (!next || !isfinite(number))
            return error_new("%s, got '%.*s'", expected, (int)(end - at), at);
        if (*count < NUMBERS)
            value[*count] = number;
        ++*count;
        at = next;
    }
    if (*count && *count != NUMBERS)
        return error_new("%s, got %zu numbers", expected, *count);
    return NULL;
}

static struct error *check_numbers(const double value[NUMBERS], bool first, double before)
{
    if (!first && !(value[0] > before))
        return error_new("expected a time after %.15g, got %.15g", before, value[0]);
    if (!(fabs(value[2]) <= 90))
        return error_new("expected an elevation of -90 to 90 degrees, got %.15g", value[2]);
    for (int c = 3; c < NUMBERS; c++)
        if (value[c] < 0)
            return error_new("expected light of at least 0, got %.15g", value[c]);
    return NULL;
}

static void place_between(const double a[NUMBERS], const double b[NUMBERS], double time,
                          struct sun_place *place)
{
    double now[NUMBERS];
    const double share = b[0] > a[0] ? (time - a[0]) / (b[0] - a[0]) : 0;
    for (int k = 0; k < NUMBERS; k++)
        now[k] = a[k] + share * (b[k] - a[k]);
    *place = (struct sun_place){now[1], now[2], {now[3], now[4], now[5]}};
}

static struct error *search(struct file_input *in, double time, struct sun_place *place)
{
    double before[NUMBERS] = {0}, now[NUMBERS] = {0}, earliest = 0;
    bool first = true, found = false;
    struct error *err = NULL;
    for (bool more = true; more && !err;) {
        const char *line;
        size_t length, bytes, count = 0;
        err = file_input_line(in, &line, &length, &bytes);
        more = !err && line;
        if (!more)
            break;
        in->line++;
        err = read_numbers(line, length, now, &count);
        if (!err && count)
            err = check_numbers(now, first, before[0]);
        err = error_wrap(err, "%s:%zu", in->name, in->line);
        file_input_consume(in, bytes);
        if (err || !count)
            continue;
        earliest = first ? now[0] : earliest;
        if (!found && time >= (first ? now[0] : before[0]) && time <= now[0]) {
            place_between(first ? now : before, now, time, place);
            found = true;
        }
        first = false;
        memcpy(before, now, sizeof before);
    }
    if (!err && first)
        err = error_new("%s: expected lines TIME AZIMUTH ELEVATION R G B, got none", in->name);
    if (!err && !found)
        err = error_usage("--time: expected a time from %.15g to %.15g, which %s has, got %.15g",
                          earliest, before[0], in->name, time);
    return err;
}

struct error *sun_path_at(const char *path, double time, struct sun_place *place)
{
    struct file_input in;
    struct error *err = file_input_open(&in, path);
    if (err)
        return err;
    err = search(&in, time, place);
    file_input_close(&in);
    return err;
}
