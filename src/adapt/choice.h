/* SPDX-License-Identifier: Apache-2.0 */
/* choice: some of the candidates as probes, and what queries would make of them at the others.
 *
 * Cells are made as the stream's will be (cells_make: probe-tet), what their points see is found
 * as probe-leakfix finds it (sight.h), and every candidate is located and blended as probe-query
 * does (probe-query.h). So what is counted is what will be seen.
 */
#ifndef CHOICE_H
#define CHOICE_H

#include "adapt/candidates.h"
#include "leak/leak.h"
#include "leak/sight.h"
#include "leak/stars.h"
#include "libprobe-query/probe-query.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct stream;
struct tracer;

/* What a choice is made with; borrowed. */
struct choice_world {
    struct candidates *candidates; /* those that become probes are refined */
    const struct candidates_job *job;
};

struct choice {
    struct choice_world world;
    uint32_t *probe; /* candidates; owned */
    size_t count;
    /* Owned; the mesh's arrays are the stream's: */
    struct stream *stream;
    struct probe_mesh cells;
    struct leak_mesh mesh;
    struct sights sights;
    struct stars stars;
    struct probe_volume *volume;
    /* Of each candidate; owned: */
    bool *chosen;
    struct probe_place *place;
    float *error; /* of the ruler */
    /* what the square of its error counts: those of all, so weighted, change as errors do */
    float *weight;
    /* Candidates by the cell of their place: at[first[cell]] .. at[first[cell + 1] - 1]; owned */
    uint32_t *first, *at;
    /* Means: of those of space that are not chosen, by squares that are smoothed; of the judges;
     * and the standard error of that */
    double error_of_space, error_of_judges, judges_doubt;
};

/* Chooses `count` of the candidates (copied). Error: their cells are no tetrahedra. */
struct error *choice_init(struct choice *choice, const struct choice_world *world, size_t count,
                          const uint32_t *probe);
void choice_clear(struct choice *choice);

/* The light of `count` candidates with weights that sum to 1: its halves, along the directions. */
void choice_blend(const struct candidates *c, int count, const uint32_t *from, const double *weight,
                  double light[2][SPHERE_COUNT]);

/* The ruler's error at a candidate of this light; and a square of one, with its sign. */
double choice_error_of(const struct candidates *c, size_t candidate, double light[2][SPHERE_COUNT]);

static inline double choice_square(double error)
{
    return error * fabs(error);
}

/* Whether a candidate is one of space that is not chosen. */
static inline bool choice_counts(const struct choice *choice, uint32_t x)
{
    return choice->world.candidates->kind[x] == CANDIDATE_SPACE && !choice->chosen[x];
}

/* Bytes of the packed file (probe-query --pack float) of probes with SH of this order; 0: memory is
 * short. */
size_t choice_bytes(const struct choice *choice, int order);

#endif
