/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/stars.h"
#include "base/array.h"
#include "base/error.h"
#include "leak/leak.h"

#include <stdlib.h>

struct error *stars_init(struct stars *stars, const struct leak_mesh *mesh)
{
    const size_t slots = (size_t)mesh->corners * mesh->cell_count;
    *stars = (struct stars){0};
    if (slots > UINT32_MAX)
        return error_new("more than %u corners of cells", UINT32_MAX);
    struct error *err = array_create(&stars->first, mesh->probe_count + 2, sizeof *stars->first);
    if (!err)
        err = array_create(&stars->slot, slots, sizeof *stars->slot);
    if (err) {
        stars_clear(stars);
        return err;
    }
    size_t *first = stars->first;
    for (size_t i = 0; i < slots; i++)
        first[mesh->vertex[i] + 2]++;
    for (size_t i = 0; i < mesh->probe_count; i++)
        first[i + 2] += first[i + 1];
    for (size_t i = 0; i < slots;
         i++) /* first[p + 1] runs through p's, and ends where p + 1 begins */
        stars->slot[first[mesh->vertex[i] + 1]++] = (uint32_t)i;
    return NULL;
}

void stars_clear(struct stars *stars)
{
    free(stars->first);
    free(stars->slot);
    *stars = (struct stars){0};
}
