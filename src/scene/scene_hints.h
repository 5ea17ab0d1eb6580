/* SPDX-License-Identifier: Apache-2.0 */
/* scene_hints: what of a scene was hardly meant to stop light, and the option that leaves it out.
 *
 * A sky dome surrounds all else, and is unlit, emits while there is a sky or a sun, is a ball or
 * half of one, or has the word sky in its name. Collision hulls, occluders and coarser forms for
 * the distance are told by names that engines give a meaning (UCX_ of Unreal, -col and -occ of
 * Godot, _LOD1 beside _LOD0).
 */
#ifndef SCENE_HINTS_H
#define SCENE_HINTS_H

struct error;
struct scene;
struct warnings;

/* Warns of such things in a finished scene, a warning a kind. */
struct error *scene_hint(const struct scene *scene, struct warnings *warnings);

#endif
