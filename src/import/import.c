/* SPDX-License-Identifier: Apache-2.0 */
/* Reading a scene: which importer. */
#include "base/file.h"
#include "import/import.h"
#include "import/import_scene.h"
#include "math/hash.h"
#include "scene/scene_hints.h"
#include "scene/scene_settings.h"
#include "scene/scene_told.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* -- formats ---------------------------------------------------------------------------------- */

struct format {
    const char *ending;
    struct error *(*read)(struct scene_import *import);
};

static const struct format formats[] = {
    {".obj", scene_read_obj}, {".gltf", scene_read_gltf}, {".glb", scene_read_gltf},
    {".ply", scene_read_ply}, {".off", scene_read_off},   {".stl", scene_read_stl},
};

/* The first line that says more than a comment, without leading blanks. */
static const char *first_words(const char *text)
{
    for (;;) {
        text += strspn(text, " \t\r\n");
        if (*text != '#')
            return text;
        text += strcspn(text, "\r\n");
    }
}

/* The format of a file whose name says nothing, by how it begins; an ending, or NULL. */
static const char *guess(const char *data, size_t size)
{
    const char *words = first_words(strncmp(data, "\xef\xbb\xbf", 3) ? data : data + 3);
    uint32_t triangles = 0;
    if (size >= 84)
        memcpy(&triangles, data + 80, sizeof triangles);
    if (!strncmp(data, "glTF", 4))
        return ".glb";
    if (!strncmp(data, "ply", 3))
        return ".ply";
    if (!strncmp(data, "solid", 5) || (size >= 84 && size == 84 + 50 * (size_t)triangles))
        return ".stl";
    if (*words == '{')
        return ".gltf";
    if (!strncmp(words + strspn(words, "STCN4n"), "OFF", 3))
        return ".off";
    static const char *const statements[] = {"v ", "v\t",     "vn ",     "vt ", "o ",
                                             "g ", "mtllib ", "usemtl ", "s "};
    for (size_t i = 0; i < sizeof statements / sizeof *statements; i++)
        if (!strncmp(words, statements[i], strlen(statements[i])))
            return ".obj";
    return NULL;
}

static const struct format *find_ending(const char *ending)
{
    for (size_t i = 0; ending && i < sizeof formats / sizeof *formats; i++)
        if (!strcasecmp(ending, formats[i].ending))
            return &formats[i];
    return NULL;
}

/* The folder that what the scene names is found from: its own, or where the program runs when it
 * comes through a pipe. */
static char *directory_of(const char *path)
{
    struct stat status;
    const char *slash = strrchr(path, '/');
    const bool file = slash && (stat(path, &status) || S_ISREG(status.st_mode));
    return strndup(path, file ? (size_t)(slash - path) + 1 : 0);
}

static struct error *find_format(struct scene_import *import, const struct format **format)
{
    *format = find_ending(strrchr(import->path, '.'));
    if (*format)
        return NULL;
    if (strspn(import->content, " \t\r\n") == import->content_size)
        return error_new("the file is empty, expected a scene: a pipe can be read once");
    *format = find_ending(guess(import->content, import->content_size));
    return *format ? NULL : error_new("not a scene: expected OBJ, glTF, GLB, PLY, OFF or STL");
}

static struct error *read_as(const struct format *format, struct scene_import *import)
{
    struct error *err = NULL;
    if (strspn(import->content, " \t\r\n") == import->content_size)
        err = scene_import_broken(import, "file empty", 0, "the file is empty");
    if (!err)
        err = format->read(import);
    if (err && import->broken_line)
        return error_wrap(err, "%s:%zu", import->path, import->broken_line);
    return error_wrap(err, "%s", import->path);
}

static struct error *check_empty(const struct scene *scene)
{
    if (scene_triangle_count(scene) > 0)
        return NULL;
    if (scene->degenerate_count > 0)
        return error_new("%s: no triangle with an area among %zu", scene->path,
                         scene->degenerate_count);
    return error_new("%s: no triangle", scene->path);
}

struct error *scene_read(struct scene **scene, const char *path,
                         const struct scene_settings *settings, bool empty_allowed,
                         struct warnings *warnings)
{
    const struct format *format = NULL;
    struct warnings found = {0};
    char *directory = directory_of(path);
    struct scene_import import = {
        .path = file_input_name(path),
        .directory = directory,
        .warnings = &found,
        .lenient = settings && settings->lenient,
    };
    struct error *err = directory ? file_read_input(path, &import.content, &import.content_size)
                                  : error_memory();
    path = import.path;
    const uint64_t file = err ? 0 : hash_bytes(import.content, import.content_size);
    if (!err)
        err = find_format(&import, &format);
    err = error_wrap(err, "%s", path);
    *scene = NULL;
    if (!err)
        err = scene_create(&import.scene);
    if (!err && !(import.scene->path = strdup(path)))
        err = error_memory();
    if (!err)
        err = read_as(format, &import);
    if (!err && settings)
        err = error_wrap(scene_choose(import.scene, &settings->choice, &found), "%s", path);
    if (!err)
        err = scene_finish(import.scene, settings, &found);
    if (!err)
        err = scene_hint(import.scene, &found);
    if (!err && !empty_allowed)
        err = check_empty(import.scene);
    scene_told_mark(&found, path, file, warnings);
    scene_import_clear(&import);
    free(directory);
    if (err)
        scene_destroy(import.scene);
    else
        *scene = import.scene;
    return err;
}
