/* SPDX-License-Identifier: Apache-2.0 */
#include "place/up.h"
#include "math/affine.h"
#include "math/vec.h"
#include "scene/scene.h"

int up_axis(const struct scene *scene)
{
    if (!scene)
        return 1;
    double low[3], high[3];
    int least = 1;
    vec3_store(low, scene->box_min);
    vec3_store(high, scene->box_max);
    for (int k = 0; k < 3; k += 2)
        if (high[k] - low[k] < high[least] - low[least])
            least = k;
    return high[least] - low[least] < (high[1] - low[1]) / 4 ? least : 1;
}

double up_way(const struct scene *scene, int axis)
{
    double sum = 0;
    if (axis == 1)
        return 1;
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        const double *m = scene->instances[i].transform, side = affine_mirrors(m) ? -1 : 1;
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            struct vec3 p[3];
            double twice[3];
            for (size_t c = 0; c < 3; c++)
                p[c] = affine_point(m, mesh->position + 3 * (size_t)mesh->index[3 * t + c]);
            vec3_store(twice, vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])));
            sum += side * twice[axis];
        }
    }
    const struct vec3 size = vec3_sub(scene->box_max, scene->box_min);
    return sum < -1e-3 * vec3_dot(size, size) ? -1 : 1;
}
