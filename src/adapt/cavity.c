/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/cavity.h"
#include "adapt/quick_square.h"
#include "leak/stars.h"
#include "libprobe-query/sight.h"
#include "math/vec.h"

#include <math.h>
#include <string.h>

/* Weights below this are none where something is in the way: that saves a ray. */
static const float LEAST = 1e-3F;

/* Standard errors of a gain, as if all of it were by chance, that it has to exceed. */
static const double DOUBT = 0.5;

/* -- cells ------------------------------------------------------------------------------------ */

static struct vec3 corner_of(const struct choice *choice, int32_t cell, int k)
{
    return leak_mesh_probe(&choice->mesh, choice->mesh.vertex[4 * (size_t)cell + (size_t)k]);
}

/* Whether p is in the circumsphere of a cell, which is right-handed. */
static bool in_sphere(const struct choice *choice, int32_t cell, struct vec3 p)
{
    const struct vec3 a = vec3_sub(corner_of(choice, cell, 0), p),
                      b = vec3_sub(corner_of(choice, cell, 1), p),
                      c = vec3_sub(corner_of(choice, cell, 2), p),
                      d = vec3_sub(corner_of(choice, cell, 3), p);
    const double volume = vec3_dot(vec3_sub(b, a), vec3_cross(vec3_sub(c, a), vec3_sub(d, a)));
    const double det = -vec3_dot(a, a) * vec3_dot(b, vec3_cross(c, d)) +
                       vec3_dot(b, b) * vec3_dot(a, vec3_cross(c, d)) -
                       vec3_dot(c, c) * vec3_dot(a, vec3_cross(b, d)) +
                       vec3_dot(d, d) * vec3_dot(a, vec3_cross(b, c));
    return volume > 0 ? det < 0 : det > 0;
}

static bool holds(size_t count, const int32_t *list, int32_t cell)
{
    for (size_t i = 0; i < count; i++)
        if (list[i] == cell)
            return true;
    return false;
}

/* Adds the cells around the cavity, nearest by faces first, to where hull may be in the way. */
static void find_ring(struct cavity *cavity, const struct choice *choice)
{
    memcpy(cavity->ring, cavity->cell, cavity->cells * sizeof *cavity->ring);
    cavity->ringed = cavity->cells;
    for (size_t i = 0; i < cavity->ringed; i++)
        for (size_t k = 0; k < 4 && cavity->ringed < CAVITY_RING; k++) {
            const int32_t next = choice->cells.neighbour[4 * (size_t)cavity->ring[i] + k];
            if (next >= 0 && !holds(cavity->ringed, cavity->ring, next))
                cavity->ring[cavity->ringed++] = next;
        }
}

/* Adds to the cells that there are those around whose spheres hold a candidate. */
static bool dig(struct cavity *cavity, const struct choice *choice, uint32_t candidate)
{
    memcpy(cavity->point, choice->world.candidates->position + 3 * (size_t)candidate,
           sizeof cavity->point);
    const struct vec3 p = vec3_load(cavity->point);
    for (size_t i = 0; i < cavity->cells; i++)
        for (int k = 0; k < 4; k++) {
            const int32_t next = choice->cells.neighbour[4 * (size_t)cavity->cell[i] + (size_t)k];
            if (next < 0 || holds(cavity->cells, cavity->cell, next) || !in_sphere(choice, next, p))
                continue;
            if (cavity->cells == CAVITY_CELLS)
                return false;
            cavity->cell[cavity->cells++] = next;
        }
    cavity->ringed = 0;
    if (!choice->blend[candidate].inside)
        find_ring(cavity, choice);
    return true;
}

bool cavity_dig(struct cavity *cavity, const struct choice *choice, uint32_t candidate)
{
    cavity->without = CAVITY_NONE;
    cavity->cell[0] = choice->blend[candidate].cell;
    cavity->cells = 1;
    return dig(cavity, choice, candidate);
}

bool cavity_dig_without(struct cavity *cavity, const struct choice *choice, uint32_t candidate,
                        const struct stars *stars, uint32_t probe)
{
    const size_t first = stars->first[probe], count = stars->first[probe + 1] - first;
    const int32_t own = choice->blend[candidate].cell;
    cavity->without = choice->probe[probe];
    if (count >= CAVITY_CELLS)
        return false;
    for (size_t i = 0; i < count; i++)
        cavity->cell[i] = (int32_t)(stars->slot[first + i] / 4);
    cavity->cells = count;
    if (!holds(count, cavity->cell, own))
        cavity->cell[cavity->cells++] = own;
    return dig(cavity, choice, candidate);
}

uint64_t cavity_around(const struct cavity *cavity, const uint64_t *cell, bool refined)
{
    uint64_t sum = refined;
    for (size_t i = 0; i < cavity->cells; i++)
        sum += cell[cavity->cell[i]];
    for (size_t i = cavity->cells; i < cavity->ringed; i++)
        sum += 3 * cell[cavity->ring[i]];
    return sum ? sum : 1;
}

/* -- faces ------------------------------------------------------------------------------------ */

/* Whether the probe that goes is a corner of the face opposite a corner of a cell. */
static bool goes(const struct cavity *cavity, const struct choice *choice, int32_t cell, int k)
{
    for (int i = 0; i < 4 && cavity->without != CAVITY_NONE; i++)
        if (i != k &&
            choice->probe[choice->mesh.vertex[4 * (size_t)cell + (size_t)i]] == cavity->without)
            return true;
    return false;
}

/* Joins the point to the face opposite a corner of a cell, on this side of which it is (1: the
 * cell's; -1: the other), unless it is not. */
static void join(struct cavity *cavity, const struct choice *choice, int32_t cell, int k,
                 double way)
{
    static const int of[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
    const struct vec3 p = vec3_load(cavity->point);
    const size_t face = cavity->faces;
    struct vec3 q[3];
    for (int i = 0; i < 3; i++) {
        cavity->corner[face][i] =
            choice->probe[choice->mesh.vertex[4 * (size_t)cell + (size_t)of[k][i]]];
        q[i] = vec3_sub(corner_of(choice, cell, of[k][i]), p);
    }
    const struct vec3 own = vec3_sub(corner_of(choice, cell, k), p),
                      normal = vec3_cross(vec3_sub(q[1], q[0]), vec3_sub(q[2], q[0]));
    const double volume = vec3_dot(q[0], vec3_cross(q[1], q[2])),
                 height = vec3_dot(normal, vec3_sub(own, q[0])), /* of the corner above the face */
        mine = -vec3_dot(normal, q[0]);                          /* of p */
    const double size = vec3_length(normal) * vec3_length(q[0]);
    if (!(mine * height * way > 0) || !(fabs(volume) > 1e-9 * size))
        return;
    for (int i = 0; i < 3; i++) {
        const struct vec3 n = vec3_scale(1 / volume, vec3_cross(q[(i + 1) % 3], q[(i + 2) % 3]));
        cavity->row[3 * i][face] = (float)n.x;
        cavity->row[3 * i + 1][face] = (float)n.y;
        cavity->row[3 * i + 2][face] = (float)n.z;
    }
    cavity->faces++;
}

static void find_faces(struct cavity *cavity, const struct choice *choice)
{
    cavity->faces = 0;
    for (size_t i = 0; i < cavity->cells; i++)
        for (int k = 0; k < 4; k++) {
            const int32_t cell = cavity->cell[i],
                          next = choice->cells.neighbour[4 * (size_t)cell + (size_t)k];
            if ((next < 0 || !holds(cavity->cells, cavity->cell, next)) &&
                !goes(cavity, choice, cell, k))
                join(cavity, choice, cell, k, 1);
        }
    for (size_t i = cavity->cells; i < cavity->ringed; i++)
        for (int k = 0; k < 4; k++)
            if (choice->cells.neighbour[4 * (size_t)cavity->ring[i] + (size_t)k] < 0)
                join(cavity, choice, cavity->ring[i], k, -1);
}

/* -- candidates ------------------------------------------------------------------------------- */

static inline float least(float a, float b)
{
    return a < b ? a : b;
}

/* Of all faces that around which the weights of x are most positive; -1: it is in none, by more
 * than `off`. */
static int find_face(const struct cavity *cavity, const double x[3], float off, float weight[4])
{
    const float(*const row)[CAVITY_FACES] = cavity->row;
    const float a = (float)(x[0] - cavity->point[0]), b = (float)(x[1] - cavity->point[1]),
                c = (float)(x[2] - cavity->point[2]);
    float lowest[CAVITY_FACES], most = -off, rest = 1;
    int face = -1;
    for (size_t i = 0; i < cavity->faces; i++) {
        const float u = row[0][i] * a + row[1][i] * b + row[2][i] * c,
                    v = row[3][i] * a + row[4][i] * b + row[5][i] * c,
                    w = row[6][i] * a + row[7][i] * b + row[8][i] * c;
        lowest[i] = least(least(u, v), least(w, 1 - (u + v + w)));
    }
    for (size_t i = 0; i < cavity->faces; i++)
        if (lowest[i] > most) {
            most = lowest[i];
            face = (int)i;
        }
    for (int k = 0; k < 3 && face >= 0; k++) {
        const float w = row[3 * k][face] * a + row[3 * k + 1][face] * b + row[3 * k + 2][face] * c;
        weight[k] = w > 0 ? w : 0;
        rest -= w;
    }
    weight[3] = rest > 0 ? rest : 0;
    return face;
}

/* Whether something hid a corner from a candidate in the cavity's cells. */
static bool is_walled(const struct cavity *cavity, const struct choice *choice)
{
    for (size_t i = 0; i < cavity->cells; i++)
        for (uint32_t k = choice->first[cavity->cell[i]]; k < choice->first[cavity->cell[i] + 1];
             k++)
            if (choice->blend[choice->at[k]].hidden)
                return true;
    return false;
}

static double square_distance(const struct candidates *c, uint32_t a, uint32_t b)
{
    const struct vec3 d =
        vec3_sub(vec3_load(c->position + 3 * (size_t)a), vec3_load(c->position + 3 * (size_t)b));
    return vec3_dot(d, d);
}

/* The same where x sees no corner to speak of: the nearest probe that it sees stands in (seen.h),
 * which the candidate may be. */
static double square_of_stand_in(const struct choice *choice, uint32_t candidate, uint32_t x)
{
    const struct candidates *c = choice->world.candidates;
    const struct blend *now = &choice->blend[x];
    const struct seen_world seen = choice_seen(choice);
    if ((now->stood_in &&
         square_distance(c, x, now->from[0]) <= square_distance(c, x, candidate)) ||
        !(seen_by(&seen, x, candidate) > 0.5))
        return choice_square((double)choice->error[x]);
    const float *own = c->light[candidate].probe[0], *light[4] = {own, own, own, own};
    const float weight[4] = {1, 0, 0, 0};
    const struct quick_light blend = quick_blend(light, weight);
    return quick_square(&c->light[x], &blend, c->floor);
}

/* What the error at x comes to: its square, as it counts. stays: its cell does. */
static double square_at(const struct cavity *cavity, const struct choice *choice,
                        uint32_t candidate, bool walled, bool stays, uint32_t x)
{
    /* where a probe of the hull goes there may be points beyond, for which a face stands in */
    const float off = stays || cavity->without == CAVITY_NONE ? 1e-5F : 1e3F;
    const struct candidates *c = choice->world.candidates;
    const double before = choice_square((double)choice->error[x]);
    float weight[4], sum = 0;
    const int face = find_face(cavity, c->position + 3 * (size_t)x, off, weight);
    if (face < 0)
        return choice->blend[x].stood_in ? square_of_stand_in(choice, candidate, x) : before;
    const uint32_t *corner = cavity->corner[face];
    const uint32_t from[4] = {corner[0], corner[1], corner[2], candidate};
    const float *light[4];
    const struct seen_world seen = choice_seen(choice);
    for (int k = 0; k < 4; k++) {
        if (walled)
            weight[k] *= weight[k] < LEAST ? 0
                         : k < 3           ? (float)seen_probe(&seen, x, from[k])
                                           : (float)seen_by(&seen, x, candidate);
        sum += weight[k];
        light[k] = c->light[from[k]].probe[0];
    }
    if (sum < SIGHT_ENOUGH)
        return square_of_stand_in(choice, candidate, x);
    for (int k = 0; k < 4; k++)
        weight[k] /= sum;
    const struct quick_light blend = quick_blend(light, weight);
    return quick_square(&c->light[x], &blend, c->floor);
}

/* Squares of errors as they count, and of what they fall by. */
struct sums {
    double before, after, squares;
};

/* Adds those of a cell's candidates. Those of a cell that stays are beyond the hull, and what is
 * beyond it stays as it is where the point is not. */
static void add_cell(const struct cavity *cavity, const struct choice *choice, uint32_t candidate,
                     bool walled, int32_t cell, bool stays, struct sums *sums)
{
    for (uint32_t k = choice->first[cell]; k < choice->first[cell + 1]; k++) {
        const uint32_t x = choice->at[k];
        const bool inside = choice->blend[x].inside;
        if (x == candidate || !choice_counts(choice, x) || (inside ? stays : !cavity->ringed))
            continue;
        const double weight = (double)choice->weight[x],
                     before = weight * choice_square((double)choice->error[x]),
                     after = weight * square_at(cavity, choice, candidate, walled, stays, x);
        sums->before += before;
        sums->after += after;
        sums->squares += (before - after) * (before - after);
    }
}

double cavity_gain(struct cavity *cavity, const struct choice *choice, uint32_t candidate,
                   bool *doubtful)
{
    struct sums sums = {0};
    find_faces(cavity, choice);
    const bool walled = cavity->ringed || is_walled(cavity, choice);
    for (size_t i = 0; i < cavity->cells; i++)
        add_cell(cavity, choice, candidate, walled, cavity->cell[i], false, &sums);
    for (size_t i = cavity->cells; i < cavity->ringed; i++)
        add_cell(cavity, choice, candidate, walled, cavity->ring[i], true, &sums);
    const double gain = fmax(sums.before, 0) - fmax(sums.after, 0); /* less than none is noise */
    *doubtful = !(gain > DOUBT * sqrt(sums.squares));
    return fmax(gain, 0);
}
