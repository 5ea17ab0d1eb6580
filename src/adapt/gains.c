/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/gains.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "math/hash.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = 256 }; /* cells */

struct error *gains_reserve(struct gains *gains, size_t count)
{
    struct error *err = array_reserve(&gains->of, &gains->room, count, sizeof *gains->of);
    if (!err && count > gains->count) {
        memset(gains->of + gains->count, 0, (count - gains->count) * sizeof *gains->of);
        gains->count = count;
    }
    return err;
}

void gains_clear(struct gains *gains)
{
    free(gains->of);
    *gains = (struct gains){0};
}

/* -- cells ------------------------------------------------------------------------------------ */

struct numbering {
    const struct choice *choice;
    uint64_t *corners, *cell; /* what stands for a cell's corners, in any order; for all of it */
};

static uint64_t number_corners(const struct choice *choice, size_t cell)
{
    uint64_t sum = 0;
    for (size_t k = 0; k < 4; k++) {
        const uint32_t corner = choice->probe[choice->mesh.vertex[4 * cell + k]];
        sum += hash_bytes(&corner, sizeof corner);
    }
    return hash_bytes(&sum, sizeof sum);
}

static uint64_t number_candidate(const struct choice *choice, uint32_t x)
{
    struct {
        uint32_t number, hidden;
        float error, weight;
    } all = {x, choice->blend[x].hidden, choice->error[x], choice->weight[x]};
    return hash_bytes(&all, sizeof all);
}

static struct error *number_block(void *context, size_t block, int thread)
{
    (void)thread;
    const struct numbering *n = context;
    const size_t cells = n->choice->mesh.cell_count,
                 end = (block + 1) * BLOCK < cells ? (block + 1) * BLOCK : cells;
    for (size_t i = block * BLOCK; i < end; i++) {
        n->cell[i] = hash_bytes(&n->corners[i], sizeof n->corners[i]);
        for (size_t k = 0; k < 4; k++) {
            const int32_t next = n->choice->cells.neighbour[4 * i + k];
            n->cell[i] += next >= 0 ? n->corners[next] : 1;
        }
        for (uint32_t k = n->choice->first[i]; k < n->choice->first[i + 1]; k++)
            if (!n->choice->chosen[n->choice->at[k]]) /* those are in any of the cells around */
                n->cell[i] += number_candidate(n->choice, n->choice->at[k]);
    }
    return NULL;
}

struct error *gains_cells(const struct choice *choice, uint64_t **cell)
{
    const size_t cells = choice->mesh.cell_count;
    struct numbering n = {.choice = choice};
    struct error *err = array_create(&n.corners, cells, sizeof *n.corners);
    if (!err)
        err = array_create(&n.cell, cells, sizeof *n.cell);
    for (size_t i = 0; i < cells && !err; i++)
        n.corners[i] = number_corners(choice, i);
    if (!err)
        err =
            threads_for(choice->world.job->threads, (cells + BLOCK - 1) / BLOCK, number_block, &n);
    free(n.corners);
    if (err)
        free(n.cell);
    else
        *cell = n.cell;
    return err;
}
