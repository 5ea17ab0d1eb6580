/* SPDX-License-Identifier: Apache-2.0 */
/* choice: some of the candidates as probes, and what queries would make of them at the others.
 *
 * Cells are made as the stream's will be (cells_make: probe-tet), every candidate is located as
 * probe-query does (probe-query.h), and blended of the corners that it sees (seen.h). What stayed
 * as it was in the choice before is taken from there. A look (choice_look) blends them by the sight
 * that probe-leakfix will find (sight.h), so what it says is what will be seen; it costs some ten
 * times as much.
 */
#ifndef CHOICE_H
#define CHOICE_H

#include "adapt/candidates.h"
#include "adapt/seen.h"
#include "leak/leak.h"
#include "libprobe-query/probe-query.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct gains;
struct stream;
struct tracer;

/* What a choice is made with; borrowed. */
struct choice_world {
    struct candidates *candidates; /* those that become probes are refined */
    const struct candidates_job *job;
    struct gains *gains; /* what is known of them (gains.h) */
    struct seen_known *seen;
};

/* Mean errors: of the candidates of space that are not chosen, by squares that are smoothed; of the
 * judges (mean_error.h), and the standard error of that. */
struct choice_errors {
    double space, judges, doubt;
};

struct choice {
    struct choice_world world;
    const struct tracer *tracer; /* borrowed */
    uint32_t *probe;             /* candidates; owned */
    size_t count;
    /* Owned; the mesh's arrays are the stream's: */
    struct stream *stream;
    struct probe_mesh cells;
    struct leak_mesh mesh;
    struct probe_volume *volume;
    /* Of each candidate; owned: */
    size_t candidates; /* how many there were */
    bool *chosen;
    struct blend *blend;
    float *error; /* of the ruler */
    float *noise; /* as noisy as its square, about 0 */
    /* what the square of its error counts: those of all, so weighted, change as errors do */
    float *weight;
    /* Candidates by their cell: at[first[cell]] .. at[first[cell + 1] - 1]; owned */
    uint32_t *first, *at;
    struct choice_errors errors;
};

/* Chooses `count` of the candidates (copied). before: a choice of the same candidates, or NULL.
 * Errors: their cells are no tetrahedra; a signal came (interrupt.h). */
struct error *choice_init(struct choice *choice, const struct choice_world *world, size_t count,
                          const uint32_t *probe, const struct choice *before);
void choice_clear(struct choice *choice);

/* What the mean error of the judges would be if each of them were a probe: what SH of this order
 * lose, which no more probes bring back. */
struct error *choice_least_error(const struct choice *choice, double *error);

/* What the errors are by the sight that the cells will keep: of those cells that judges are in,
 * which are few of many; in the others by what each point sees. square: of the error of each
 * candidate by that, with its sign; the caller's. Error: a signal came. */
struct error *choice_look(const struct choice *choice, struct choice_errors *errors, float *square);

/* The light of `count` candidates with weights that sum to 1: its halves, along the directions. */
void choice_blend(const struct candidates *c, int count, const uint32_t *from, const double *weight,
                  double light[2][SPHERE_COUNT]);

/* The ruler's error at a candidate of this light; *noise, unless NULL: what is as noisy as its
 * square, about 0. And a square of an error, with its sign. */
double choice_error_of(const struct candidates *c, size_t candidate, double light[2][SPHERE_COUNT],
                       float *noise);

static inline double choice_square(double error)
{
    return error * fabs(error);
}

/* The points and cells for seen.h. */
static inline struct seen_world choice_seen(const struct choice *choice)
{
    return (struct seen_world){choice->tracer,          choice->world.candidates->position,
                               choice->probe,           choice->mesh.vertex,
                               choice->cells.neighbour, choice->world.seen};
}

/* Whether a candidate is one of space that is not chosen. */
static inline bool choice_counts(const struct choice *choice, uint32_t x)
{
    return choice->world.candidates->kind[x] == CANDIDATE_SPACE && !choice->chosen[x];
}

/* Whether a candidate could be a probe, and is none. */
static inline bool choice_can_add(const struct choice *choice, uint32_t x)
{
    const unsigned char kind = choice->world.candidates->kind[x];
    return (kind == CANDIDATE_SPACE || kind == CANDIDATE_SURFACE) && !choice->chosen[x];
}

/* Bytes of the packed file (probe-query --pack float) of probes with SH of this order; 0: memory is
 * short. */
size_t choice_bytes(const struct choice *choice, int order);

#endif
