/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/guide.h"
#include "base/array.h"
#include "base/error.h"
#include "capture/ask_lit.h"
#include "math/direction.h"
#include "math/luminance.h"
#include "trace/lit.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Puts a zero before every bit. */
static uint32_t spread_bits(uint32_t x)
{
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

/* Every second bit. */
static uint32_t gather_bits(uint32_t x)
{
    x &= 0x55555555u;
    x = (x | x >> 1) & 0x33333333u;
    x = (x | x >> 2) & 0x0f0f0f0fu;
    x = (x | x >> 4) & 0x00ff00ffu;
    return (x | x >> 8) & 0x0000ffffu;
}

static size_t cell_at(const struct guide *g, int row, int column)
{
    return spread_bits((uint32_t)row) << 1 | spread_bits((uint32_t)column & ((1u << g->bits) - 1)) |
           (size_t)(column >> g->bits) << 2 * g->bits;
}

static size_t cell_of(const struct guide *g, double x, double y)
{
    const int rows = 1 << g->bits, columns = 2 * rows, column = (int)(x * columns),
              row = (int)(y * rows);
    return cell_at(g, row < rows ? row : rows - 1, column < columns ? column : columns - 1);
}

struct error *guide_init(struct guide *guide, size_t least)
{
    enum { BITS_MOST = 8 };
    *guide = (struct guide){.bits = 2};
    while (guide->bits < BITS_MOST && (size_t)2 << 2 * guide->bits < least)
        guide->bits++;
    guide->cells = (size_t)2 << 2 * guide->bits;
    struct error *err = array_create(&guide->density, guide->cells, sizeof *guide->density);
    return err ? err : array_create(&guide->sum, guide->cells, sizeof *guide->sum);
}

void guide_clear(struct guide *guide)
{
    free(guide->density);
    free(guide->sum);
    *guide = (struct guide){0};
}

void guide_add(struct guide *guide, double x, double y, float light)
{
    guide->density[cell_of(guide, x, y)] += light;
}

/* Spreads light to the cells about each, 1 2 1 both ways; the last column is beside the first. */
static void smooth(const struct guide *g, const float *from, float *to)
{
    const int rows = 1 << g->bits, columns = 2 * rows;
    for (int row = 0; row < rows; row++)
        for (int column = 0; column < columns; column++) {
            const float light = from[cell_at(g, row, column)];
            for (int i = -1; i <= 1 && light > 0; i++)
                for (int k = -1; k <= 1; k++) {
                    const int r = row + i < 0 ? 0 : row + i < rows ? row + i : rows - 1;
                    to[cell_at(g, r, (column + k + columns) % columns)] +=
                        light * (float)((2 - abs(i)) * (2 - abs(k))) / 16;
                }
        }
}

struct error *guide_make(struct guide *guide, double *gain)
{
    float *smoothed = NULL;
    double all = 0, square = 0;
    *gain = 0;
    struct error *err = array_create(&smoothed, guide->cells, sizeof *smoothed);
    if (err)
        return err;
    smooth(guide, guide->density, smoothed);
    for (size_t i = 0; i < guide->cells; i++)
        all += (double)smoothed[i];
    for (size_t i = 0; i < guide->cells && all > 0; i++) {
        const double share = (double)smoothed[i] / all;
        guide->density[i] = (float)(share * (double)guide->cells);
        square += share * share;
        guide->sum[i] = (i ? guide->sum[i - 1] : 0) + share;
    }
    *gain = square * (double)guide->cells;
    free(smoothed);
    return NULL;
}

void guide_draw(const struct guide *guide, double t, double *x, double *y)
{
    const double at = t * guide->sum[guide->cells - 1];
    size_t low = 0, high = guide->cells - 1;
    while (low < high) { /* the first whose sum is beyond */
        const size_t middle = (low + high) / 2;
        if (guide->sum[middle] > at)
            high = middle;
        else
            low = middle + 1;
    }
    const double before = low ? guide->sum[low - 1] : 0, own = guide->sum[low] - before;
    const double within = own > 0 ? fmin((at - before) / own, 1) : 0;
    const uint32_t code = (uint32_t)fmin(within * 0x1p32, 0xffffffff);
    const uint32_t mask = (1u << 2 * guide->bits) - 1, cell = (uint32_t)low;
    const double rows = 1 << guide->bits,
                 column = gather_bits(cell & mask) +
                          (double)(cell >> 2 * guide->bits) * (double)(1 << guide->bits);
    *x = (column + (gather_bits(code) + 0.5) * 0x1p-16) / (2 * rows);
    *y = (gather_bits((cell & mask) >> 1) + (gather_bits(code >> 1) + 0.5) * 0x1p-16) / rows;
}

float guide_density(const struct guide *guide, double x, double y)
{
    return guide->cells ? guide->density[cell_of(guide, x, y)] : 0;
}

/* -- a receiver -------------------------------------------------------------------------------- */

/* Less gain than that is not worth a guide. */
#define LEAST_GAIN 8.0

/* So many questions, asked of all points alike, tell where sunlight is wide, as it is out of doors:
 * where their gain, in wider cells, is less, no more are asked. */
#define GLANCE_GAIN 3.7
enum { GLANCE = 32 };

/* Cells for each question: so few that hardly one of a bright place is missed. */
#define CELLS_SHARE 0.5

static bool on_surface(struct vec3f n)
{
    return n.x != 0 || n.y != 0 || n.z != 0;
}

struct vec3f guide_direction(const struct path_receiver *receiver, float x, double y)
{
    const struct vec3f n = receiver->at.normal;
    if (on_surface(n))
        return direction_by_cosine(n, (float)y, x);
    const float z = (float)(2 * y - 1), r = sqrtf(float_most(1 - z * z, 0));
    float c, s;
    angle_turn(x, &c, &s);
    return (struct vec3f){r * c, r * s, z};
}

/* Adds light from a direction where guide_direction is that, about. */
static void add_light(struct guide *guide, struct vec3f n, const struct path_found *found)
{
    struct vec3f d = found->direction;
    double y = ((double)d.z + 1) / 2;
    float light = luminance_vec3f(found->light);
    if (on_surface(n)) {
        const float cosine = float_most(vec3f_dot(d, n), 0);
        const struct vec3f x_axis = direction_by_cosine(n, 1, 0),
                           y_axis = direction_by_cosine(n, 1, 0.25f);
        d.x = vec3f_dot(found->direction, x_axis);
        d.y = vec3f_dot(found->direction, y_axis);
        y = 1 - (double)(cosine * cosine);
        light *= cosine;
    }
    const double turn = angle_atan2((double)d.y, (double)d.x) / (2 * ANGLE_PI);
    guide_add(guide, turn < 0 ? turn + 1 : turn, fmax(y, 0), light);
}

/* Learns by so many questions, and asks so many. *gain: 0 where no sunlit point is asked for. */
static struct error *look(struct guide *guide, struct ask_lit *ask, int learnt, int questions,
                          double *gain)
{
    *gain = 0;
    guide_clear(guide);
    struct error *err = ask_lit_start(ask, learnt);
    if (!err && ask->receiver->lit)
        err = guide_init(guide, (size_t)(CELLS_SHARE * questions));
    for (int first = 0; first < questions && ask->receiver->lit && !err; first += PATH_WAVE) {
        const int now = questions - first < PATH_WAVE ? questions - first : PATH_WAVE;
        struct path_found found[PATH_WAVE];
        int place[PATH_WAVE];
        for (int i = 0; i < now; i++)
            place[i] = first + i;
        ask_lit_wave(ask, questions, (size_t)now, place, found);
        for (int i = 0; i < now; i++)
            if (vec3f_most(found[i].light) > 0)
                add_light(guide, ask->receiver->at.normal, &found[i]);
    }
    if (!err && ask->receiver->lit)
        err = guide_make(guide, gain);
    ask->receiver->lit = false;
    ask_lit_end(ask);
    return err;
}

struct error *guide_look(struct guide *guide, const struct path_tracer *path,
                         struct path_receiver *receiver, uint64_t seed, uint64_t name,
                         uint32_t first, int questions)
{
    struct ask_lit ask = {.path = path,
                          .lit = path->lit,
                          .receiver = receiver,
                          .seed = seed,
                          .name = name,
                          .first = first};
    double gain;
    *guide = (struct guide){0};
    struct error *err = look(guide, &ask, 0, GLANCE, &gain);
    const bool narrow = gain > GLANCE_GAIN;
    if (!err && narrow)
        err = look(guide, &ask, questions / 2, questions, &gain);
    if (!err && !(narrow && gain > LEAST_GAIN))
        guide_clear(guide);
    return err;
}
