/* SPDX-License-Identifier: Apache-2.0 */
#include "render/film.h"
#include "base/array.h"
#include "base/error.h"
#include "base/progress.h"
#include "image/annotate.h"
#include "render/object.h"
#include "scene/scene.h"
#include "stream/points.h"
#include "stream/stream.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* -- files ------------------------------------------------------------------------------------- */

static bool is_pfm(const char *path)
{
    const size_t length = strlen(path);
    return length >= 4 && !strcmp(path + length - 4, ".pfm");
}

struct error *film_write(const struct shot *shot, const char *output, const char *pfm)
{
    struct error *err = NULL;
    if (output)
        err = is_pfm(output) ? picture_write(&shot->linear, output, false)
                             : picture_write(&shot->shown, output, true);
    if (!err && pfm)
        err = picture_write(&shot->linear, pfm, false);
    return err;
}

static struct error *print(FILE *out, const char *frame, const char *name, double value)
{
    return isnan(value) || fprintf(out, "%s%s %.6g\n", frame ? frame : "", name, value) >= 0
               ? NULL
               : error_system(errno, "stdout");
}

struct error *film_print(const struct shot *shot, const char *output, const char *frame)
{
    FILE *out = output && !strcmp(output, "-") ? stderr : stdout;
    const struct compare *f = &shot->figures;
    if (!shot->compared)
        return NULL;
    struct error *err = print(out, frame, "mean", f->mean);
    if (!err)
        err = print(out, frame, "bias", f->bias);
    if (!err)
        err = print(out, frame, "rmse", f->rmse);
    if (!err)
        err = print(out, frame, "relative-rmse", f->relative);
    if (!err)
        err = print(out, frame, "truth-noise", f->noise);
    if (!err)
        err = print(out, frame, "flip", f->flip);
    if (!err)
        err = print(out, frame, "exposure", shot->exposure);
    return err || !fflush(out) ? err : error_system(errno, "stdout");
}

/* "frame-%04d.png": where the %d is, and how many digits; false: there is none. Another % than one
 * such is an error. */
static struct error *find_number(const char *path, const char **start, const char **end,
                                 int *digits)
{
    const char *percent = path ? strchr(path, '%') : NULL;
    *start = NULL;
    if (!percent)
        return NULL;
    const size_t count = strspn(percent + 1, "0123456789");
    const bool padded = !count || (percent[1] == '0' && count == 2);
    if (percent[1 + count] != 'd' || !padded || strchr(percent + 1, '%'))
        return error_usage("%s: expected one %%d, or %%0Nd, for the frame's number", path);
    *digits = count ? percent[2] - '0' : 1;
    *start = percent;
    *end = percent + 2 + count;
    return NULL;
}

/* The name of a frame's file; the caller frees it. NULL for NULL. */
static struct error *frame_name(const char *path, size_t frame, char **name)
{
    const char *start, *end;
    int digits = 0;
    *name = NULL;
    if (!path)
        return NULL;
    struct error *err = find_number(path, &start, &end, &digits);
    if (err || !start)
        return err;
    if (asprintf(name, "%.*s%0*zu%s", (int)(start - path), path, digits, frame, end) < 0) {
        *name = NULL;
        return error_memory();
    }
    return NULL;
}

static struct error *write_frame(const struct film *film, const struct shot *shot, size_t frame)
{
    char *output = NULL, *pfm = NULL;
    struct error *err = frame_name(film->output, frame, &output);
    if (!err)
        err = frame_name(film->pfm, frame, &pfm);
    if (!err)
        err = film_write(shot, output, pfm);
    free(output);
    free(pfm);
    return err;
}

/* -- shots ------------------------------------------------------------------------------------- */

static struct error *take_overlay(const struct film *film, const struct render *render,
                                  struct overlay *overlay)
{
    if (!(film->overlay.probe_radius > 0) && !film->overlay.cells)
        return NULL;
    return overlay_init(overlay, render, film->stream, film->baked, &film->overlay);
}

/* One shot of the scene as it stands; object: what moves in it, or NULL. */
static struct error *take_shot(const struct film *film, const struct render_object *object,
                               double exposure, struct progress *progress, struct shot *shot)
{
    struct tracer *tracer = NULL;
    struct path_tracer path = {0};
    struct overlay overlay = {0};
    struct render render = *film->render;
    struct shot_settings settings = *film->shot;
    struct error *err = trace_create(&tracer, film->scene);
    if (!err)
        err = path_init(&path, tracer, film->bounces);
    render.path = &path;
    if (object)
        render.object = *object;
    if (!err)
        err = take_overlay(film, &render, &overlay);
    settings.overlay = overlay.share.rgb ? &overlay : NULL;
    settings.exposure = exposure;
    if (!err)
        err = shot_take(shot, &render, &settings, progress);
    overlay_clear(&overlay);
    path_clear(&path);
    trace_destroy(tracer);
    return err;
}

/* -- a path ------------------------------------------------------------------------------------ */

/* The points of a path, and how far out they may be. */
struct way {
    double *point; /* 3 * count; owned */
    size_t count, capacity;
    struct vec3 centre;
    double reach;
};

static struct error *take_points(void *context, const struct points *points, const double *value,
                                 size_t width, size_t count)
{
    struct way *way = context;
    struct error *err =
        array_reserve(&way->point, &way->capacity, 3 * (way->count + count), sizeof *way->point);
    for (size_t i = 0; i < count && !err; i++, way->count++) {
        const struct vec3 p = vec3_load(value + i * width);
        vec3_store(way->point + 3 * way->count, p);
        if (!(vec3_length(vec3_sub(p, way->centre)) <= way->reach))
            err = points_place(
                points, i, error_new("the point is farther out than 1e6 times the scene's size"));
    }
    return err;
}

static struct error *read_path(const char *path, const struct scene *scene, struct way *way)
{
    way->centre = vec3_scale(0.5, vec3_add(scene->box_min, scene->box_max));
    way->reach = 1e6 * vec3_length(vec3_sub(scene->box_max, scene->box_min));
    return points_read_all(path, POINTS_PLACES, take_points, way, NULL);
}

/* Frames side by side. */
struct sheet {
    size_t across, down;
    struct shot whole;
};

static struct error *sheet_add(struct sheet *sheet, size_t frame, size_t count,
                               const struct shot *shot)
{
    struct error *err = NULL;
    if (!frame) {
        while (sheet->across * sheet->across < count)
            sheet->across++;
        sheet->down = (count + sheet->across - 1) / sheet->across;
        err = picture_init(&sheet->whole.shown, sheet->across * shot->shown.width,
                           sheet->down * shot->shown.height);
        if (!err)
            err = picture_init(&sheet->whole.linear, sheet->across * shot->shown.width,
                               sheet->down * shot->shown.height);
        if (err)
            return error_wrap(
                err, "the sheet of %zu frames (%%d in the output's name makes a file of each)",
                count);
    }
    const size_t x = frame % sheet->across * shot->shown.width,
                 y = frame / sheet->across * shot->shown.height;
    picture_paste(&sheet->whole.shown, x, y, &shot->shown);
    picture_paste(&sheet->whole.linear, x, y, &shot->linear);
    return NULL;
}

static struct error *take_frames(const struct film *film, const struct way *way,
                                 const struct object *object, bool numbered,
                                 struct progress *progress)
{
    struct sheet sheet = {.across = 1};
    double exposure = film->shot->exposure; /* the first frame's holds for all */
    struct error *err = NULL;
    for (size_t frame = 0; frame < way->count && !err; frame++) {
        const struct vec3 p = vec3_load(way->point + 3 * frame);
        const struct render_object at = object_at(object, p, film->per_pixel);
        char name[32];
        struct shot shot = {0};
        object_place(object, p);
        snprintf(name, sizeof name, "%zu ", frame);
        err = take_shot(film, &at, exposure, progress, &shot);
        if (!err && !numbered && way->count > 1)
            annotate_text(&shot.shown, annotate_height(&shot.shown) / 2,
                          (double)shot.shown.height - 2 * annotate_height(&shot.shown), name);
        if (!err)
            err = numbered ? write_frame(film, &shot, frame)
                           : sheet_add(&sheet, frame, way->count, &shot);
        if (!err)
            err = film_print(&shot, film->output, way->count > 1 ? name : NULL);
        exposure = shot.exposure;
        shot_clear(&shot);
    }
    if (!err && !numbered)
        err = film_write(&sheet.whole, film->output, film->pfm);
    shot_clear(&sheet.whole);
    return err;
}

/* Whether frames go to files of their own: all outputs have a number, or none. */
static struct error *is_numbered(const struct film *film, bool *numbered)
{
    const char *output = NULL, *pfm = NULL, *end;
    int digits;
    struct error *err = find_number(film->output, &output, &end, &digits);
    if (!err)
        err = find_number(film->pfm, &pfm, &end, &digits);
    *numbered = output || pfm;
    if (!err && film->output && film->pfm && !output != !pfm)
        err = error_usage("expected a frame's number (%%d) in both --output and --pfm, or in none");
    return err;
}

/* That files can be written is known before there is much to lose. */
static struct error *try_outputs(const char *output, const char *pfm)
{
    struct error *err = output ? picture_try(output) : NULL;
    return err || !pfm ? err : picture_try(pfm);
}

static struct error *try_frame(const struct film *film)
{
    char *output = NULL, *pfm = NULL;
    struct error *err = frame_name(film->output, 0, &output);
    if (!err)
        err = frame_name(film->pfm, 0, &pfm);
    if (!err)
        err = try_outputs(output ? output : film->output, pfm ? pfm : film->pfm);
    free(output);
    free(pfm);
    return err;
}

static struct error *take_path(const struct film *film, struct warnings *warnings)
{
    struct way way = {0};
    bool numbered = false;
    struct object object = {0};
    struct error *err = is_numbered(film, &numbered);
    if (!err)
        err = try_frame(film);
    if (!err)
        err = read_path(film->path, film->scene, &way);
    if (!err)
        err = object_init(&object, film->scene, film->object, film->lenient, film->object_radius,
                          warnings);
    if (!err) {
        struct progress *progress = progress_start(film->progress, film->program, "tiles",
                                                   way.count * render_tiles(film->render->camera) *
                                                       (size_t)shot_pictures(film->shot));
        err = take_frames(film, &way, &object, numbered, progress);
        progress_end(progress);
    }
    object_clear(&object);
    free(way.point);
    return err;
}

struct error *film_take(const struct film *film, struct warnings *warnings)
{
    if (film->path)
        return take_path(film, warnings);
    struct shot shot = {0};
    struct error *err = try_outputs(film->output, film->pfm);
    struct progress *progress =
        progress_start(film->progress, film->program, "tiles",
                       render_tiles(film->render->camera) * (size_t)shot_pictures(film->shot));
    if (!err)
        err = take_shot(film, NULL, film->shot->exposure, progress, &shot);
    progress_end(progress);
    if (!err)
        err = film_write(&shot, film->output, film->pfm);
    if (!err)
        err = film_print(&shot, film->output, NULL);
    shot_clear(&shot);
    return err;
}
