/* SPDX-License-Identifier: Apache-2.0 */
#include "bake/facts.h"
#include "base/error.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "import/import_scene.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "stream/cells.h"
#include "stream/stream.h"

#include <errno.h>
#include <sys/stat.h>

static size_t count_emissive(const struct scene *scene)
{
    size_t count = 0;
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (size_t t = 0; t < mesh->triangle_count; t++)
            count += scene_emits(&scene->materials[mesh->material[t]]);
    }
    return count;
}

struct error *scene_facts_of(const char *path, const struct scene_settings *settings,
                             struct scene_facts *facts)
{
    struct scene *scene = NULL;
    struct warnings unsaid = {0};
    *facts = (struct scene_facts){0};
    struct error *err = scene_read(&scene, path, settings, false, &unsaid);
    warnings_clear(&unsaid);
    if (err)
        return err;
    facts->triangles = scene_triangle_count(scene);
    facts->emissive = count_emissive(scene);
    for (size_t i = 0; i < scene->light_count; i++) {
        const enum scene_light_kind kind = scene->lights[i].kind;
        facts->points += kind == SCENE_POINT;
        facts->spots += kind == SCENE_SPOT;
        facts->suns += kind == SCENE_SUN;
    }
    const double *sky = scene->sky.radiance;
    facts->sky = sky[0] > 0 || sky[1] > 0 || sky[2] > 0;
    facts->dark = capture_is_dark(scene);
    vec3_store(facts->low, scene->box_min);
    vec3_store(facts->high, scene->box_max);
    scene_destroy(scene);
    return NULL;
}

static void look_at(const struct table *probes, struct bake_facts *facts)
{
    const struct column *sh = table_column(probes, "sh");
    const struct column *validity = table_column(probes, "validity");
    for (size_t i = 0; i < probes->rows; i++) {
        bool black = sh != NULL;
        for (size_t k = 0; sh && k < sh->width && black; k++)
            black = !(column_f32(sh)[i * sh->width + k] != 0);
        facts->black += black;
        facts->in_matter += validity && column_f32(validity)[i] < 0.5f;
    }
    facts->probes = probes->rows;
}

struct error *file_bytes(const char *path, uint64_t *bytes)
{
    struct stat status;
    if (stat(path, &status))
        return error_system(errno, "%s", path);
    *bytes = (uint64_t)status.st_size;
    return NULL;
}

struct error *bake_facts_of(const char *path, struct bake_facts *facts)
{
    struct stream *stream = NULL;
    struct cells cells;
    *facts = (struct bake_facts){0};
    struct error *err = stream_read(&stream, path);
    if (!err)
        err = error_wrap(cells_find(stream, &cells), "%s", path);
    if (!err) {
        look_at(stream_table(stream, "probe"), facts);
        facts->cells = cells.table->rows;
        err = file_bytes(path, &facts->bytes);
    }
    stream_destroy(stream);
    return err;
}
