/* SPDX-License-Identifier: Apache-2.0 */
#include "render/scene_film.h"
#include "base/error.h"
#include "base/file.h"
#include "base/warning.h"
#include "render/render_options.h"
#include "render/view.h"
#include "import/import_scene.h"
#include "scene/relit.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "scene/scene_told.h"
#include "stream/sight_key.h"
#include "stream/stream.h"
#include "trace/seen.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check_scene(const struct scene *scene, const struct stream *stream,
                        struct warnings *warnings)
{
    const struct stream_header *header = &stream->header;
    char key[SCENE_KEY_ROOM];
    const char *captured = header_key(header, "scene-key");
    scene_key_text(scene, captured, key);
    if (!scene_differs(scene, header) && !scene->sky.changed && scene_sky_differs(scene, header))
        warnings_add(warnings, "scene", "%s: the probes were captured under another sky than %s",
                     scene->path, scene->sky.file);
    if (scene_differs(scene, header))
        warnings_add(warnings, "scene",
                     "%s: the probes were captured in another scene, or with other light in it "
                     "(its key is %s, theirs %s)",
                     scene->path, key, captured);
    sight_warn_other_scene(stream, scene_surface_key(scene), scene->path, warnings);
}

/* From here on probes give light to what sees them alone. */
static struct error *see_by_rays(struct scene_film *film)
{
    struct error *err = trace_create(&film->tracer, film->scene);
    return err ? err
               : seen_join(&film->seen, film->tracer, film->baked.probe_count, film->baked.in);
}

static struct error *choose_view(struct scene_film *film, const struct render_options *o)
{
    struct tracer *tracer = NULL;
    struct path_tracer path = {0};
    struct error *err = trace_create(&tracer, film->scene);
    if (!err)
        err = path_init(&path, tracer, 2);
    if (!err)
        err = view_choose(&path, o->fov, (double)o->width / (double)o->height, &film->eye,
                          &film->look_at);
    film->view_chosen = !err;
    path_clear(&path);
    trace_destroy(tracer);
    return err;
}

static struct error *aim(struct scene_film *film, const struct render_options *o)
{
    const struct scene *scene = film->scene;
    film->eye = vec3_load(o->eye);
    film->look_at = o->look_at_given ? vec3_load(o->look_at)
                                     : vec3_scale(0.5, vec3_add(scene->box_min, scene->box_max));
    struct error *err = o->eye_given ? NULL : choose_view(film, o);
    const struct camera_view view = {.eye = film->eye,
                                     .look_at = film->look_at,
                                     .up = vec3_load(o->up),
                                     .fov = o->fov,
                                     .width = o->width,
                                     .height = o->height};
    return err ? err : camera_init(&film->camera, &view);
}

/* The light of the probes everywhere where it fills the picture, else that which they have
 * themselves, if any. */
static struct error *open_light(struct scene_film *film, const struct render_options *o,
                                const struct stream *stream)
{
    const struct table *probes = stream_table(stream, "probe");
    if (!probes)
        return error_new("there is no table probe");
    const bool everywhere = render_options_by_probes(o);
    film->light = everywhere || (!isnan(o->draw_probes) && table_column(probes, "sh"));
    if (!film->light)
        return NULL;
    struct interpolate_settings settings = interpolate_options_settings(&o->how, "sh");
    settings.outside |= interpolate_visible_flags(o->visible);
    struct error *err = everywhere ? baked_open(&film->baked, stream, &settings)
                                   : baked_open_probes(&film->baked, stream);
    return err ? err : baked_complete(&film->baked);
}

struct error *scene_film_init(struct scene_film *film, const struct render_options *options,
                              const char *scene_path, const struct stream *stream,
                              const char *input, struct warnings *warnings)
{
    struct error *err = stream ? open_light(film, options, stream) : NULL;
    if (!err && stream)
        err = overlay_spacing(stream, &film->spacing);
    err = error_wrap(err, "%s", file_input_name(input));
    if (!err)
        err = scene_read(&film->scene, scene_path, &options->scene, false, warnings);
    char *told = NULL; /* a picture passes nothing on */
    if (!err && stream)
        err = scene_told(warnings, &stream->header, true, &told);
    free(told);
    if (!err && stream)
        check_scene(film->scene, stream, warnings);
    if (!err && stream && !scene_differs(film->scene, &stream->header))
        err = relit_scene(film->scene, &options->scene, &stream->header, warnings);
    if (!err && film->baked.in && options->visible == INTERPOLATE_VISIBLE_RAYS)
        err = see_by_rays(film);
    if (!err)
        err = aim(film, options);
    return err || !options->truth ? err : picture_read(&film->truth, options->truth);
}

/* A probe before the eye must not hide the others: of its distance, its radius is at most this. */
#define NEAR_SHARE (1. / 15)

/* The radius of the probes that are drawn; 0: none. */
static double probe_radius(const struct scene_film *film, const struct render_options *o)
{
    if (isnan(o->draw_probes))
        return 0;
    return o->draw_probes > 0 ? o->draw_probes : 0.1 * film->spacing;
}

struct error *scene_film_take(const struct scene_film *film, const struct render_options *options,
                              const struct stream *stream, const char *program,
                              struct warnings *warnings)
{
    const struct render_options *o = options;
    const struct render render = {.camera = &film->camera,
                                  .baked = &film->baked,
                                  .object = {.first = SIZE_MAX},
                                  .samples = o->samples,
                                  .offset = o->offset_given ? o->offset : 0.15 * film->spacing,
                                  .error = o->error,
                                  .samples_most = o->max_samples,
                                  .seed = (uint64_t)o->common.seed,
                                  .threads = o->common.threads};
    struct shot_settings shot = o->shot;
    shot.given_truth = o->truth ? &film->truth : NULL;
    const struct film shots = {.render = &render,
                               .shot = &shot,
                               .scene = film->scene,
                               .stream = stream,
                               .baked = film->light ? &film->baked : NULL,
                               .overlay = {.probe_radius = probe_radius(film, o),
                                           .probe_share = o->draw_probes > 0 ? 0 : NEAR_SHARE,
                                           .cells = o->draw_cells},
                               .bounces = o->bounces,
                               .object = o->object ? o->object : "sphere",
                               .path = o->path,
                               .lenient = o->scene.lenient,
                               .object_radius = o->object_radius,
                               .per_pixel = o->per_pixel,
                               .output = o->output,
                               .pfm = o->pfm,
                               .program = program,
                               .progress = o->common.progress && !o->common.quiet};
    return film_take(&shots, warnings);
}

void scene_film_clear(struct scene_film *film)
{
    picture_clear(&film->truth);
    baked_close(&film->baked);
    seen_destroy(film->seen);
    trace_destroy(film->tracer);
    scene_destroy(film->scene);
}
