/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/stage.h"
#include "base/error.h"
#include "import/import_scene.h"
#include "scene/relit.h"
#include "scene/scene_settings.h"
#include "stream/stream.h"
#include "topology/decimate.h"
#include "trace/trace.h"

#include <stdio.h>
#include <string.h>

/* Lets what is captured be split as the probes' light was: of another scene, or one that is lit
 * otherwise, as far as it has such lights. */
static struct error *open_split(struct stage *stage)
{
    const struct groups_way way = {.added = stage->scene_settings.light_count, .lenient = true};
    struct error *err = capture_split_open(&stage->split, stage->scene, &way, &stage->path);
    if (!err && capture_split_count(&stage->split))
        stage->capture_settings.split = &stage->split;
    return err;
}

struct error *stage_init(struct stage *stage, const char *path, const struct stream_header *header,
                         struct scene_settings *given, struct warnings *warnings)
{
    *stage = (struct stage){.scene_settings = *given,
                            .capture_settings = capture_settings_default(),
                            .captured = capture_header_has_settings(header)};
    *given = scene_settings_default();
    struct error *err = scene_settings_from_header(&stage->scene_settings, header);
    if (!err)
        err = capture_settings_from_header(&stage->capture_settings, header);
    if (!err)
        err = scene_read(&stage->scene, path, &stage->scene_settings, stage->scene_settings.lenient,
                         warnings);
    if (!err)
        err = scene_settings_found_sky(&stage->scene_settings, stage->scene);
    if (err)
        return err;
    const char *captured = header_key(header, "scene-key");
    scene_key_text(stage->scene, captured, stage->key);
    snprintf(stage->captured_key, sizeof stage->captured_key, "%s", captured ? captured : "");
    stage->other = scene_differs(stage->scene, header);
    stage->other_sky = scene_sky_differs(stage->scene, header);
    relit_key(header, stage->relit);
    err = stage->other ? NULL : relit_scene(stage->scene, &stage->scene_settings, header, warnings);
    if (!err)
        err = trace_create(&stage->tracer, stage->scene);
    if (!err)
        err = path_init(&stage->path, stage->tracer, stage->capture_settings.bounces);
    /* parts are of the light as it was captured, not of what became of it */
    if (!err && !*stage->relit)
        err = capture_split_from_header(&stage->split, header);
    return err ? err : open_split(stage);
}

struct error *stage_decimate(struct stage *stage, struct warnings *warnings)
{
    if (!(stage->capture_settings.decimate < 1))
        return NULL;
    path_clear(&stage->path);
    trace_destroy(stage->tracer);
    stage->path = (struct path_tracer){0};
    stage->tracer = NULL;
    struct error *err = scene_decimate(stage->scene, stage->capture_settings.decimate, warnings);
    if (!err)
        err = trace_create(&stage->tracer, stage->scene);
    if (!err)
        err = path_init(&stage->path, stage->tracer, stage->capture_settings.bounces);
    return err ? err : open_split(stage);
}

void stage_clear(struct stage *stage)
{
    path_clear(&stage->path);
    trace_destroy(stage->tracer);
    scene_destroy(stage->scene);
    scene_settings_clear(&stage->scene_settings);
    capture_split_clear(&stage->split);
}
