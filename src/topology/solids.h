/* SPDX-License-Identifier: Apache-2.0 */
/* solids: what of a scene is closed, so that it has an inside. */
#ifndef SOLIDS_H
#define SOLIDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct scene;
struct warnings;

/* Connected pieces of the scene's surface: faces that share vertices in their file, or stand at
 * equal positions, across an edge of exactly two faces of consistent orientation. Closed: every
 * edge has a face on each side, so that "inside" has a meaning. Meshes that are placed once are
 * joined with each other; a mesh that is placed often is looked at by itself. */
struct scene_solids {
    size_t count, closed_count;
    /* for triangle t of instance i: piece_of[offset[i] + t]; closed[piece]; volume[piece] signed:
     * negative when turned inside out, 0 when not closed; turned[offset[i] + t]: the file has the
     * triangle of a closed piece the other way round than its neighbours; unoriented[piece]: open,
     * and its faces look to both sides */
    size_t *offset;
    uint32_t *piece_of;
    bool *turned;
    bool *closed, *unoriented;
    double *volume;
};
struct error *scene_solids(const struct scene *scene, struct scene_solids *solids,
                           struct warnings *warnings);
/* Says what became of faces that look to another side than their neighbours, as that has said. */
void scene_solids_tell(const struct scene *scene, const struct scene_solids *solids,
                       struct warnings *warnings);
void scene_solids_clear(struct scene_solids *solids);

#endif
