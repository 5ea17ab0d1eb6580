/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_sky.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/warning.h"
#include "image/image.h"
#include "math/angle.h"
#include "math/hash.h"
#include "scene/scene_build.h"
#include "scene/scene_settings.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* -- angular maps and cube maps --------------------------------------------------------------- */

enum { PANORAMA_HIGH_MOST = 8192 };

/* Bilinear; x and y in texels from the centre of the left upper one, within the picture. */
static double between_texels(const struct image *from, double x, double y, int c)
{
    const size_t i = (size_t)fmin(x, from->width - 2.0), j = (size_t)fmin(y, from->height - 2.0);
    const double fx = x - (double)i, fy = y - (double)j;
    const float *t = (const float *)from->texels + 3 * (j * from->width + i) + c;
    const size_t row = 3 * (size_t)from->width;
    return (1 - fy) * ((1 - fx) * (double)t[0] + fx * (double)t[3]) +
           fy * ((1 - fx) * (double)t[row] + fx * (double)t[row + 3]);
}

/* Where a picture shows a direction, whose x is to the front, y up, z to the right: in texels, as
 * between_texels takes them. */
typedef void place_of(const struct image *from, struct vec3 d, double *x, double *y);

/* The centre looks to the front, the rim to the back; the angle from the front grows with the
 * distance from the centre. */
static void place_angular(const struct image *from, struct vec3 d, double *x, double *y)
{
    const double side = from->width, away = sqrt(d.y * d.y + d.z * d.z);
    /* what lies beyond the rim is no light */
    const double r = fmin(angle_atan2(away, d.x) / ANGLE_PI, 1 - 3.0 / side);
    *x = ((away > 0 ? r * d.z / away : 0) + 1) / 2 * side - 0.5;
    *y = (1 - (away > 0 ? r * d.y / away : 0)) / 2 * side - 0.5;
}

enum face { RIGHT, LEFT, UP, DOWN, FRONT, BACK, FACES };

/* How six faces lie in a picture of so many faces across and down. */
static const struct layout {
    uint32_t across, down;
    int at[FACES][2]; /* across, down */
    bool back_turned; /* by half a turn */
} layouts[] = {{4, 3, {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {3, 1}}, false},
               {3, 4, {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {1, 3}}, true},
               {6, 1, {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}}, false},
               {1, 6, {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}}, false}};

static const struct layout *layout_of(const struct image *image)
{
    for (size_t i = 0; i < sizeof layouts / sizeof *layouts; i++)
        if ((uint64_t)image->width * layouts[i].down ==
                (uint64_t)image->height * layouts[i].across &&
            image->width % layouts[i].across == 0)
            return &layouts[i];
    return NULL;
}

/* The face that a direction meets, and where: from -1 on its left, or upper, edge to 1. */
static enum face face_of(struct vec3 d, double *across, double *down)
{
    const double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
    if (x >= y && x >= z) {
        *across = d.z / d.x;
        *down = -d.y / x;
        return d.x > 0 ? FRONT : BACK;
    }
    if (z >= y) {
        *across = -d.x / d.z;
        *down = -d.y / z;
        return d.z > 0 ? RIGHT : LEFT;
    }
    *across = d.z / y;
    *down = d.x / d.y;
    return d.y > 0 ? UP : DOWN;
}

static void place_cube(const struct image *from, struct vec3 d, double *x, double *y)
{
    const struct layout *layout = layout_of(from);
    const double side = from->width / layout->across;
    double across, down;
    const enum face face = face_of(d, &across, &down);
    const double turned = face == BACK && layout->back_turned ? -1 : 1;
    /* between the centres of the face's own texels */
    *x = fmin(fmax((turned * across + 1) / 2 * side - 0.5, 0), side - 1) +
         side * layout->at[face][0];
    *y = fmin(fmax((turned * down + 1) / 2 * side - 0.5, 0), side - 1) + side * layout->at[face][1];
}

/* Makes a panorama of a picture, each texel the mean of samples * samples in it. */
static struct error *unroll(struct image *image, place_of *place, uint32_t high, int samples)
{
    const uint32_t height = high < PANORAMA_HIGH_MOST ? high : PANORAMA_HIGH_MOST,
                   width = 2 * height, rows = height * (uint32_t)samples,
                   columns = width * (uint32_t)samples;
    float *to = NULL;
    double *sum = NULL;
    struct vec3 *turns = NULL;
    struct error *err = array_create(&to, 3 * (size_t)width * height, sizeof *to);
    if (!err)
        err = array_create(&sum, 3 * (size_t)width, sizeof *sum);
    if (!err)
        err = array_create(&turns, columns, sizeof *turns);
    for (uint32_t i = 0; i < columns && !err; i++) {
        const double turn = 2 * ANGLE_PI * ((i + 0.5) / columns - 0.5);
        turns[i] = (struct vec3){angle_cos(turn), 0, angle_sin(turn)};
    }
    for (uint32_t j = 0; j < rows && !err; j++) {
        const double angle = ANGLE_PI * (0.5 - (j + 0.5) / rows), flat = angle_cos(angle),
                     up = angle_sin(angle);
        for (uint32_t i = 0; i < columns; i++) {
            double x, y;
            place(image, (struct vec3){flat * turns[i].x, up, flat * turns[i].z}, &x, &y);
            for (uint32_t c = 0; c < 3; c++)
                sum[3 * (i / (uint32_t)samples) + c] += between_texels(image, x, y, (int)c);
        }
        if ((j + 1) % (uint32_t)samples)
            continue;
        float *row = to + 3 * (size_t)width * (j / (uint32_t)samples);
        for (size_t k = 0; k < 3 * (size_t)width; k++)
            row[k] = (float)(sum[k] / (samples * samples));
        memset(sum, 0, 3 * (size_t)width * sizeof *sum);
    }
    free(sum);
    free(turns);
    if (err) {
        free(to);
        return err;
    }
    free(image->texels);
    image->texels = to;
    image->width = width;
    image->height = height;
    return NULL;
}

static struct error *map_picture(struct image *image, int map)
{
    const uint32_t width = image->width, height = image->height;
    const struct layout *layout = layout_of(image);
    if (map == SCENE_SKY_ANGULAR)
        return width == height && width >= 8
                   ? unroll(image, place_angular, height, 1)
                   : error_new("a picture of %u x %u texels: --sky-map angular expects a square of "
                               "at least 8",
                               (unsigned)width, (unsigned)height);
    if (map == SCENE_SKY_CUBE)
        return layout && width / layout->across >= 2
                   ? unroll(image, place_cube, 2 * (width / layout->across), 2)
                   : error_new("a picture of %u x %u texels: --sky-map cube expects six square "
                               "faces, as a cross of 4:3 or 3:4 or a strip of 6:1 or 1:6",
                               (unsigned)width, (unsigned)height);
    if (map == SCENE_SKY_LATLONG || fabs(width - 2.0 * height) <= fmax(1, 0.01 * width))
        return NULL;
    return error_new("a picture of %u x %u texels, expected a panorama twice as wide as high%s%s",
                     (unsigned)width, (unsigned)height,
                     layout            ? ": --sky-map cube reads the six faces of a cube"
                     : width == height ? ": --sky-map angular reads the map of a square light probe"
                                       : "",
                     layout || width == height
                         ? "; --sky-map latlong takes any sides for a panorama"
                         : ": --sky-map latlong takes any sides for one");
}

/* -- the file --------------------------------------------------------------------------------- */

/* A file that is looked at, and what it holds. */
struct found {
    char *name, *data; /* owned */
    size_t size;
    uint64_t key;
    struct error *err; /* why it cannot be read */
};

static void found_clear(struct found *found)
{
    free(found->name);
    free(found->data);
    error_destroy(found->err);
    *found = (struct found){0};
}

/* The scene's folder, absolute and with '/' at its end; "" where the scene is no file. */
static char *scene_folder(const char *scene_path)
{
    struct stat status;
    char *whole = NULL, *folder = NULL;
    if (scene_path && stat(scene_path, &status) == 0 && S_ISREG(status.st_mode))
        whole = realpath(scene_path, NULL);
    folder = whole ? strndup(whole, (size_t)(strrchr(whole, '/') - whole) + 1) : strdup("");
    free(whole);
    return folder;
}

/* The name of a file from a folder, both absolute; NULL where they have no more in common than
 * "/". The caller frees it. */
static struct error *name_from(const char *folder, const char *file, char **name)
{
    size_t common = 0;
    for (size_t i = 0; folder[i] && folder[i] == file[i]; i++)
        if (folder[i] == '/')
            common = i + 1;
    *name = NULL;
    if (common < 2)
        return NULL;
    size_t up = 0;
    for (const char *c = folder + common; *c; c++)
        up += *c == '/';
    const char *rest = file + common;
    const size_t size = 3 * up + strlen(rest) + sizeof "./";
    struct error *err = array_create(name, size, 1);
    if (err)
        return err;
    char *at = *name;
    if (!up) /* a header's value begins with no blank */
        at = stpcpy(at, "./");
    for (; up > 0; up--)
        at = stpcpy(at, "../");
    stpcpy(at, rest);
    return NULL;
}

/* Reading a pipe may wait for ever. */
static bool is_pipe(const char *path)
{
    struct stat status;
    return !stat(path, &status) && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

/* Reads folder/name. */
static struct error *look_at(struct found *found, const char *folder, const char *name)
{
    *found = (struct found){0};
    if (asprintf(&found->name, "%s%s", folder, name) < 0) {
        found->name = NULL;
        return error_memory();
    }
    found->err = is_pipe(found->name) ? error_new("expected a file that later programs find again, "
                                                  "got a pipe or a device")
                                      : file_read(found->name, &found->data, &found->size);
    if (found->err && !error_is_of_data(found->err)) {
        struct error *err = error_wrap(found->err, "%s", found->name);
        found->err = NULL;
        return err;
    }
    found->key = found->err ? 0 : hash_bytes(found->data, found->size);
    return NULL;
}

/* The picture, or none where found->err says why. */
static struct error *find_picture(struct found *best, const char *folder,
                                  const struct scene_settings *settings, struct warnings *warnings)
{
    const bool moved = settings->sky_key && *folder; /* it may have */
    const char *const slash = strrchr(settings->sky_file, '/'),
                      *const own = slash ? slash + 1 : settings->sky_file,
                      *const from_scene = settings->sky_from_scene ? settings->sky_from_scene : own;
    const char *const tries[][2] = {{"", settings->sky_file},
                                    {folder, moved ? from_scene : NULL},
                                    {folder, moved ? own : NULL}};
    struct error *err = NULL;
    for (size_t i = 0; i < sizeof tries / sizeof *tries && !err; i++) {
        struct found found;
        if (!tries[i][1])
            continue;
        err = look_at(&found, tries[i][0], tries[i][1]);
        const bool right = !found.err && found.key == settings->sky_key;
        if (!err && (!best->name || right || (best->err && !found.err))) {
            found_clear(best);
            *best = found;
        } else {
            found_clear(&found);
        }
        if (right)
            break;
    }
    if (err || !settings->sky_key || best->key == settings->sky_key)
        return err;
    if (best->err) {
        struct error *here = best->err;
        best->err = moved ? error_new("%s, and from the scene's folder %s there is neither %s nor "
                                      "%s: the sky of the stream's header (sky-file) is missing",
                                      error_message(here), folder, from_scene, own)
                          : error_new("%s: the sky of the stream's header (sky-file) is missing",
                                      error_message(here));
        error_destroy(here);
        return NULL;
    }
    warnings_add(warnings, "sky changed",
                 "%s: this is not the sky that the probes were captured under (its key is "
                 "%016" PRIx64 ", theirs %016" PRIx64 ")",
                 best->name, best->key, settings->sky_key);
    return NULL;
}

/* Reads the picture, which is only of use as radiance: floats. */
static struct error *read_picture(struct scene_texture **picture, const struct found *found,
                                  int map)
{
    struct image image = {0};
    struct error *err = image_decode(&image, found->data, found->size, IMAGE_COLOUR);
    if (!err && image.bytes)
        err = error_new(
            "expected a Radiance .hdr or OpenEXR picture: 8-bit pictures hold no radiance");
    if (!err)
        err = map_picture(&image, map);
    if (!err)
        err = array_create(picture, 1, sizeof **picture);
    if (err) {
        free(image.texels);
        return err;
    }
    **picture = scene_texture_of(&image);
    (*picture)->wrap_v = SCENE_CLAMP;
    return NULL;
}

static struct error *finish_picture(struct scene_sky *sky, const char *scene_path,
                                    const struct scene_settings *settings,
                                    struct warnings *warnings)
{
    struct found found = {0};
    char *folder = scene_folder(scene_path);
    struct error *err = folder ? find_picture(&found, folder, settings, warnings) : error_memory();
    if (!err && found.err) {
        err = found.err;
        found.err = NULL;
    }
    if (!err)
        err = read_picture(&sky->picture, &found, settings->sky_map);
    if (found.name)
        err = error_wrap(err, "%s", found.name);
    if (!err && !(sky->file = realpath(found.name, NULL)))
        err = error_system(errno, "%s", found.name);
    if (!err && *folder)
        err = name_from(folder, sky->file, &sky->from_scene);
    sky->key = found.key;
    sky->changed = settings->sky_key && settings->sky_key != found.key;
    found_clear(&found);
    free(folder);
    return err;
}

/* -- its axes --------------------------------------------------------------------------------- */

/* Where the centre of a picture is: +Y turned into `up` by the shortest way (+X stays where up is
 * -Y). */
static struct vec3 find_front(struct vec3 up)
{
    const double above = 1 + up.y;
    return above > 1e-12 ? (struct vec3){1 - up.x * up.x / above, -up.x, -up.x * up.z / above}
                         : (struct vec3){1, 0, 0};
}

/* At an azimuth (degrees) about `up`. */
static struct vec3 turn_front(struct vec3 up, double azimuth)
{
    const struct vec3 front = find_front(up);
    const double angle = azimuth * (ANGLE_PI / 180);
    return vec3_normalize(vec3_add(vec3_scale(angle_cos(angle), front),
                                   vec3_scale(angle_sin(angle), vec3_cross(up, front))));
}

/* The picture's axes. */
static void turn(struct scene_sky *sky, const struct scene_settings *settings)
{
    const struct vec3 up = vec3_load(settings->sky_up);
    sky->turned = !(up.y == 1) || !(settings->sky_turn == 0);
    if (!sky->turned)
        return;
    sky->up = up;
    sky->front = turn_front(up, settings->sky_turn);
    sky->right = vec3_cross(sky->front, sky->up);
}

struct vec3 scene_sky_direction(const double up[3], double azimuth, double elevation)
{
    const struct vec3 u = vec3_load(up);
    const double angle = elevation * (ANGLE_PI / 180);
    return vec3_add(vec3_scale(angle_cos(angle), turn_front(u, fmod(azimuth, 360))),
                    vec3_scale(angle_sin(angle), u));
}

struct error *scene_sky_finish(struct scene_sky *sky, const char *scene_path,
                               const struct scene_settings *settings, struct warnings *warnings)
{
    for (int c = 0; c < 3; c++)
        sky->radiance[c] = settings->sky_scale * (settings->sky_file ? 1 : settings->sky[c]);
    if (!settings->sky_file)
        return NULL;
    turn(sky, settings);
    return finish_picture(sky, scene_path, settings, warnings);
}
