/* SPDX-License-Identifier: Apache-2.0 */
/* emission: how much the picture of an emissive material shines over a triangle of it.
 *
 * Of each picture, means and the most over blocks of its texels stand ready, in a pyramid that is
 * never larger than a million blocks at its base: smaller blocks are read from the texels
 * themselves. Over a triangle of texture coordinates, the box about it is asked, as wrapped and as
 * interpolated: the mean there is an estimate, the most is a bound. Where a surface is cut out or
 * blended by a picture, that picture counts as well.
 */
#ifndef EMISSION_H
#define EMISSION_H

#include "scene/scene.h"

struct emission_maps {
    const struct scene *scene;
    struct emission_map *map; /* owned, and so is: */
    size_t count;
    struct emission_use *use; /* by material */
};

/* Luminance over a triangle. */
struct emission_range {
    float mean, most;
    bool smooth; /* less than a texel: an interpolation has no details here */
};

/* Whether the material's emission depends on where on it one is. */
bool emission_varies(const struct scene_material *material);

/* Of the scene's materials that emit and vary. The scene outlives the maps. */
struct error *emission_init(struct emission_maps *maps, const struct scene *scene);
void emission_clear(struct emission_maps *maps);

/* uv, alpha_uv: u and v of three corners, for the material's emission map and its alpha map. The
 * material, by number, emits and varies. The mean is above 0 where the most is. */
struct emission_range emission_over(const struct emission_maps *maps, int32_t material,
                                    const float uv[3][2], const float alpha_uv[3][2]);

#endif
