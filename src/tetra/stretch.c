/* SPDX-License-Identifier: Apache-2.0 */
#include "tetra/stretch.h"
#include "math/vec.h"

#include <math.h>
#include <stddef.h>

enum {
    SAMPLES = 64, /* points whose neighbours are looked at */
    BLOCK = 512,  /* in order around each: those near in space are mostly near in the order */
    NEIGHBOURS = 12,
    RECTANGLES = 1024, /* at most */
    LEAST_FOUND = 2    /* samples with a rectangle that make a grid */
};

/* By how much the fourth corner may be off, against the shorter side: noise that the stretch can
 * outdo, several times over. */
static const double corner_slack = 0.02;

/* Strength, and how it differs between directions, so that no combination of them cancels. At 0.005
 * the weakest of a cube's squares still decides against displacements of 1e-3 of its side; squared
 * distances change by 0.0146. */
static const double strength = 0.005, shares[3] = {1, 0.69, 0.83}, along[3] = {0.37, 0, -0.29};

struct rectangle {
    struct vec3 u, v; /* unit sides */
};

/* The nearest neighbours of a point among a block, nearest first. */
static int neighbours_of(const double *block, size_t count, size_t self, struct vec3 *neighbour)
{
    double square[NEIGHBOURS];
    int found = 0;
    for (size_t i = 0; i < count; i++) {
        if (i == self)
            continue;
        const struct vec3 v = vec3_sub(vec3_load(block + 3 * i), vec3_load(block + 3 * self));
        const double d = vec3_dot(v, v);
        int at = found < NEIGHBOURS ? found : NEIGHBOURS;
        while (at > 0 && d < square[at - 1])
            at--;
        if (at == NEIGHBOURS)
            continue;
        found += found < NEIGHBOURS;
        for (int k = found - 1; k > at; k--) {
            square[k] = square[k - 1];
            neighbour[k] = neighbour[k - 1];
        }
        square[at] = d;
        neighbour[at] = v;
    }
    return found;
}

static bool is_near(struct vec3 a, struct vec3 b, double slack)
{
    return vec3_length(vec3_sub(a, b)) <= slack;
}

static bool is_upright(struct vec3 u, struct vec3 v)
{
    return fabs(vec3_dot(u, v)) <= corner_slack * vec3_length(u) * vec3_length(v);
}

/* Drops the diagonals of rectangles between others: what is left are sides. */
static int drop_diagonals(struct vec3 *neighbour, int count)
{
    int kept = 0;
    for (int d = 0; d < count; d++) { /* nearest first: the sides of a diagonal stand before it */
        bool diagonal = false;
        for (int i = 0; i < kept; i++)
            for (int j = i + 1; j < kept; j++)
                diagonal = diagonal || (is_upright(neighbour[i], neighbour[j]) &&
                                        is_near(vec3_add(neighbour[i], neighbour[j]), neighbour[d],
                                                corner_slack * vec3_length(neighbour[i])));
        if (!diagonal)
            neighbour[kept++] = neighbour[d];
    }
    return kept;
}

static bool has_corner(const double *block, size_t count, struct vec3 corner, double slack)
{
    for (size_t i = 0; i < count; i++)
        if (is_near(vec3_load(block + 3 * i), corner, slack))
            return true;
    return false;
}

/* Rectangles with a corner at a point of the block. */
static int rectangles_at(const double *block, size_t count, size_t self, struct rectangle *list,
                         int room)
{
    struct vec3 neighbour[NEIGHBOURS];
    const int found = drop_diagonals(neighbour, neighbours_of(block, count, self, neighbour));
    int made = 0;
    for (int i = 0; i < found; i++)
        for (int j = i + 1; j < found && made < room; j++) {
            const struct vec3 u = neighbour[i], v = neighbour[j];
            const double shorter = vec3_length(u);
            if (!is_upright(u, v))
                continue;
            const struct vec3 corner = vec3_add(vec3_load(block + 3 * self), vec3_add(u, v));
            if (shorter > 0 && has_corner(block, count, corner, corner_slack * shorter))
                list[made++] = (struct rectangle){vec3_normalize(u), vec3_normalize(v)};
        }
    return made;
}

/* The stretch askew to a rectangle's frame. */
static void askew(const struct rectangle *r, double s[3][3])
{
    const struct vec3 u = r->u, v = vec3_normalize(vec3_fma(r->v, -vec3_dot(r->u, r->v), r->u)),
                      w = vec3_cross(u, v);
    const double frame[3][3] = {{u.x, u.y, u.z}, {v.x, v.y, v.z}, {w.x, w.y, w.z}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double sum = 0;
            for (int a = 0; a < 3; a++) {
                const int b = (a + 1) % 3;
                sum += along[a] * frame[a][i] * frame[a][j] -
                       shares[a] * (frame[a][i] * frame[b][j] + frame[b][i] * frame[a][j]);
            }
            s[i][j] = strength * sum;
        }
}

/* How well a stretch settles the rectangles: for each how askew its sides become, and enough is
 * enough. */
static double score(const double s[3][3], const struct rectangle *list, int count)
{
    double sum = 0;
    for (int i = 0; i < count; i++) {
        const struct vec3 u = list[i].u, v = list[i].v;
        const double skew = u.x * (s[0][0] * v.x + s[0][1] * v.y + s[0][2] * v.z) +
                            u.y * (s[1][0] * v.x + s[1][1] * v.y + s[1][2] * v.z) +
                            u.z * (s[2][0] * v.x + s[2][1] * v.y + s[2][2] * v.z);
        sum += fmin(fabs(skew) / (0.6 * strength), 1);
    }
    return sum;
}

void stretch_find(struct stretch *stretch, size_t count, const double *point)
{
    *stretch = (struct stretch){.matrix = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    struct rectangle list[RECTANGLES];
    int rectangles = 0, first[SAMPLES], found = 0;
    const size_t samples = count < SAMPLES ? count : SAMPLES, block = count < BLOCK ? count : BLOCK;
    for (size_t i = 0; i < samples; i++) {
        const size_t at = (2 * i + 1) * count / (2 * samples),
                     low = at < block / 2 ? 0 : at - block / 2;
        const size_t start = low + block > count ? count - block : low;
        const int room = (int)(RECTANGLES * (i + 1) / samples) - rectangles;
        const int made =
            rectangles_at(point + 3 * start, block, at - start, list + rectangles, room);
        if (made)
            first[found++] = rectangles;
        rectangles += made;
    }
    if (found < LEAST_FOUND)
        return;
    double best[3][3] = {{0}}, most = -1;
    for (int i = 0; i < found; i++) {
        double s[3][3];
        askew(&list[first[i]], s);
        const double reached = score((const double(*)[3])s, list, rectangles);
        if (reached <= most * (1 + 1e-9))
            continue;
        most = reached;
        for (int k = 0; k < 9; k++)
            best[k / 3][k % 3] = s[k / 3][k % 3];
    }
    stretch->found = true;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            stretch->matrix[i][j] += rint(best[i][j] * 0x1p12) * 0x1p-12;
}
