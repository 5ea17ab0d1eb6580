/* Reading a scene: which importer. */
#include "base/file.h"
#include "import/import.h"
#include "import/import_scene.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

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

static struct error *find_format(struct scene_import *import, const struct format **format)
{
    *format = find_ending(strrchr(import->path, '.'));
    if (*format)
        return NULL;
    struct error *err = file_read(import->path, &import->content, &import->content_size);
    if (err)
        return err;
    *format = find_ending(guess(import->content, import->content_size));
    return *format ? NULL : error_new("not a scene: expected OBJ, glTF, GLB, PLY, OFF or STL");
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
    const char *slash = strrchr(path, '/');
    char *directory = strndup(path, slash ? (size_t)(slash - path) + 1 : 0);
    struct scene_import import = {.path = path, .directory = directory, .warnings = warnings};
    struct error *err = directory ? error_wrap(find_format(&import, &format), "%s", path)
                                  : error_memory();
    *scene = NULL;
    if (!err)
        err = scene_create(&import.scene);
    if (!err && !(import.scene->path = strdup(path)))
        err = error_memory();
    if (!err)
        err = error_wrap(format->read(&import), "%s", path);
    if (!err)
        err = scene_finish(import.scene, settings, warnings);
    if (!err && !empty_allowed)
        err = check_empty(import.scene);
    scene_import_clear(&import);
    free(directory);
    if (err)
        scene_destroy(import.scene);
    else
        *scene = import.scene;
    return err;
}
