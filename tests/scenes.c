/* SPDX-License-Identifier: Apache-2.0 */
/* The bundled scenes are what scenes/README.md says: lit by themselves, closed where it says so,
 * without faces that lie upon each other, and read without a warning. */
#include "base/error.h"
#include "base/warning.h"
#include "import/import_scene.h"
#include "math/affine.h"
#include "scene/scene.h"
#include "support/tap.h"
#include "topology/solids.h"

#include <string.h>

struct corners {
    struct vec3 p[3];
};

static struct corners triangle(const struct scene *s, size_t instance, size_t t)
{
    const struct scene_mesh *const mesh = &s->meshes[s->instances[instance].mesh];
    struct corners out;
    for (size_t k = 0; k < 3; k++)
        out.p[k] = affine_point(s->instances[instance].transform,
                                mesh->position + 3 * (size_t)mesh->index[3 * t + k]);
    return out;
}

static struct vec3 normal(const struct corners *t)
{
    return vec3_normalize(vec3_cross(vec3_sub(t->p[1], t->p[0]), vec3_sub(t->p[2], t->p[0])));
}

/* How far apart two triangles are along an axis; negative where they overlap. */
static double gap(const struct corners *a, const struct corners *b, struct vec3 axis)
{
    double low[2], high[2];
    for (int i = 0; i < 2; i++) {
        const struct corners *const t = i ? b : a;
        const double x[3] = {vec3_dot(t->p[0], axis), vec3_dot(t->p[1], axis),
                             vec3_dot(t->p[2], axis)};
        low[i] = fmin(fmin(x[0], x[1]), x[2]);
        high[i] = fmax(fmax(x[0], x[1]), x[2]);
    }
    return fmax(low[0] - high[1], low[1] - high[0]);
}

/* Whether two triangles of one plane share an area: no edge's normal keeps them apart. */
static bool overlap(const struct corners *a, const struct corners *b, double scale)
{
    const struct vec3 n = normal(a), m = normal(b), between = vec3_sub(b->p[0], a->p[0]);
    if (vec3_length(vec3_cross(n, m)) > 1e-9 || fabs(vec3_dot(n, between)) > 1e-9 * scale)
        return false;
    for (int i = 0; i < 6; i++) {
        const struct corners *const t = i < 3 ? a : b;
        const struct vec3 edge = vec3_sub(t->p[(i + 1) % 3], t->p[i % 3]);
        if (gap(a, b, vec3_normalize(vec3_cross(n, edge))) > -1e-9 * scale)
            return false;
    }
    return true;
}

static size_t count_overlaps(const struct scene *s)
{
    const double scale = vec3_length(vec3_sub(s->box_max, s->box_min));
    size_t count = 0;
    for (size_t i = 0; i < s->instance_count; i++)
        for (size_t t = 0; t < s->meshes[s->instances[i].mesh].triangle_count; t++) {
            const struct corners a = triangle(s, i, t);
            for (size_t j = i; j < s->instance_count; j++)
                for (size_t u = j == i ? t + 1 : 0;
                     u < s->meshes[s->instances[j].mesh].triangle_count; u++) {
                    const struct corners b = triangle(s, j, u);
                    count += overlap(&a, &b, scale);
                }
        }
    return count;
}

static void expect(const char *name, size_t closed, size_t inward, size_t open)
{
    char path[4096];
    const char *const source = getenv("SRC");
    struct scene *s = NULL;
    struct warnings warnings = {0};
    struct scene_solids solids = {0};
    snprintf(path, sizeof path, "%s/scenes/%s", source ? source : ".", name);
    struct error *err = scene_read(&s, path, NULL, false, &warnings);
    if (!err)
        err = scene_solids(s, &solids, &warnings);
    if (err)
        bail("%s", error_message(err));
    size_t turned = 0;
    for (size_t i = 0; i < solids.count; i++)
        turned += solids.closed[i] && solids.volume[i] < 0;
    ok(solids.closed_count == closed && turned == inward &&
           solids.count - solids.closed_count == open,
       "%s: %zu closed pieces, of which %zu look inward, and %zu open ones", name,
       solids.closed_count, turned, solids.count - solids.closed_count);
    bool lit = s->light_count > 0;
    for (size_t i = 0; i < s->material_count; i++)
        lit = lit || scene_emits(&s->materials[i]);
    ok(lit && warnings.count == 0, "%s: lit by itself, and nothing to warn about", name);
    ok(count_overlaps(s) == 0, "%s: no two faces lie upon each other", name);
    scene_solids_clear(&solids);
    scene_destroy(s);
    warnings_clear(&warnings);
}

int main(void)
{
    expect("cornell-box.obj", 0, 0, 4);
    expect("two-rooms.obj", 2, 1, 1);
    expect("coloured-walls.gltf", 5, 0, 1);
    return tap_done();
}
