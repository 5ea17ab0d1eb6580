/* SPDX-License-Identifier: Apache-2.0 */
/* All methods of placing (place_method.h). */
#include "place/place_method.h"

const struct place_method *const place_methods[] = {
    &place_method_grid,        &place_method_points,
    &place_method_path,        &place_method_vertices,
    &place_method_lights,      &place_method_poisson,
    &place_method_octree,      &place_method_adaptive,
    &place_method_spawn_merge, &place_method_ascent,
    &place_method_unlit,       &place_method_reach,
    &place_method_samples,     NULL,
};
