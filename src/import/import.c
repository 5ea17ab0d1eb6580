/* Reading a scene: which importer, and the files that the scene's file names. */
#include "import/import.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* -- files ------------------------------------------------------------------------------------ */

/* No pipe and no device, which might never end. */
static bool is_file(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

/* Writes to found[0..length) the entry of a directory that is `name` but for the case of its
 * letters, if any is. */
static void match_entry(const char *directory, const char *name, size_t length, char *found)
{
    DIR *entries = opendir(*directory ? directory : ".");
    if (!entries)
        return;
    for (const struct dirent *entry; (entry = readdir(entries));) {
        if (strlen(entry->d_name) == length && !strncasecmp(entry->d_name, name, length)) {
            memcpy(found, entry->d_name, length);
            break;
        }
    }
    closedir(entries);
}

/* Brings every part of path[start..] that does not exist into the case that it has on disk. */
static struct error *match_case(char *path, size_t start)
{
    char *const wanted = strdup(path);
    if (!wanted)
        return error_memory();
    for (size_t a = start, b; wanted[a]; a = b + (wanted[b] != 0)) {
        struct stat status;
        b = a + strcspn(wanted + a, "/");
        path[b] = 0;
        if (stat(path, &status) != 0) {
            path[a] = 0;
            match_entry(path, wanted + a, b - a, path + a);
            path[a] = path[a] ? path[a] : wanted[a];
        }
        path[b] = wanted[b];
    }
    free(wanted);
    return NULL;
}

/* Tries `name` in `directory`, in any case of its letters when `loose`; sets *path when it is
 * there. */
static struct error *try_name(const char *directory, const char *name, bool loose, char **path)
{
    char *whole;
    if (*path)
        return NULL;
    if (asprintf(&whole, "%s%s", *name == '/' ? "" : directory, name) < 0)
        return error_memory();
    struct error *err = loose ? match_case(whole, *name == '/' ? 1 : strlen(directory)) : NULL;
    if (!err && is_file(whole))
        *path = whole;
    else
        free(whole);
    return err;
}

struct error *scene_import_find(const struct scene_import *import, const char *name, char **path)
{
    *path = NULL;
    char *slashed = strdup(name);
    if (!slashed)
        return error_memory();
    for (char *c = slashed; (c = strchr(c, '\\'));)
        *c = '/';
    const char *last = strrchr(slashed, '/');
    struct error *err = try_name(import->directory, name, false, path);
    if (!err)
        err = try_name(import->directory, slashed, true, path);
    if (!err && last) /* a path of the machine that wrote the file */
        err = try_name(import->directory, last + 1, true, path);
    free(slashed);
    return err;
}

/* -- textures --------------------------------------------------------------------------------- */

struct texture_entry {
    char *name;
    enum image_use use;
    struct scene_sampler sampler;
    int32_t texture;
};

static const struct texture_entry *find_entry(const struct scene_import *import, const char *name,
                                              enum image_use use, struct scene_sampler sampler)
{
    for (size_t i = 0; i < import->entry_count; i++) {
        const struct texture_entry *e = &import->entries[i];
        if (e->use == use && e->sampler.wrap_u == sampler.wrap_u &&
            e->sampler.wrap_v == sampler.wrap_v && e->sampler.nearest == sampler.nearest &&
            !strcmp(e->name, name))
            return e;
    }
    return NULL;
}

static struct error *add_entry(struct scene_import *import, struct texture_entry entry,
                               const char *name)
{
    struct error *err = array_reserve(&import->entries, &import->entry_capacity,
                                      import->entry_count + 1, sizeof *import->entries);
    if (err)
        return err;
    entry.name = strdup(name);
    if (!entry.name)
        return error_memory();
    import->entries[import->entry_count++] = entry;
    return NULL;
}

struct error *scene_import_picture(struct scene_import *import, const char *name, const void *data,
                                   size_t size, enum image_use use, struct scene_sampler sampler,
                                   int32_t *texture)
{
    const struct texture_entry *known = find_entry(import, name, use, sampler);
    *texture = known ? known->texture : SCENE_NONE;
    if (known)
        return NULL;
    struct scene_texture picture = {
        .wrap_u = sampler.wrap_u, .wrap_v = sampler.wrap_v, .nearest = sampler.nearest};
    struct error *err = image_decode(&picture, data, size, use);
    if (err == error_memory())
        return err;
    if (err) {
        warnings_add(import->warnings, "texture damaged",
                     "%s: texture %s: %s: the material's factor alone is used", import->path, name,
                     error_message(err));
        error_destroy(err);
        err = NULL;
    } else {
        err = scene_push_texture(import->scene, picture, texture);
    }
    if (!err)
        err = add_entry(import,
                        (struct texture_entry){.use = use, .sampler = sampler, .texture = *texture},
                        name);
    return err;
}

struct error *scene_import_texture(struct scene_import *import, const char *name,
                                   enum image_use use, struct scene_sampler sampler,
                                   int32_t *texture)
{
    const struct texture_entry *known = find_entry(import, name, use, sampler);
    *texture = known ? known->texture : SCENE_NONE;
    if (known)
        return NULL;
    char *path = NULL, *data = NULL;
    size_t size = 0;
    struct error *err = scene_import_find(import, name, &path);
    struct error *unread = err ? NULL : path ? file_read(path, &data, &size) : error_new("missing");
    if (unread == error_memory()) {
        err = unread;
    } else if (!err && !unread) {
        err = scene_import_picture(import, name, data, size, use, sampler, texture);
    } else if (!err) {
        warnings_add(import->warnings, "texture missing",
                     "%s: texture %s: %s: the material's factor alone is used", import->path, name,
                     error_message(unread));
        err = add_entry(
            import, (struct texture_entry){.use = use, .sampler = sampler, .texture = SCENE_NONE},
            name);
    }
    error_destroy(unread);
    free(data);
    free(path);
    return err;
}

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

static struct error *find_format(const char *path, const struct format **format)
{
    const char *ending = strrchr(path, '.');
    struct error *err = NULL;
    char *data = NULL;
    size_t size = 0;
    for (int by_content = 0; by_content < 2 && !err; by_content++) {
        if (by_content) {
            err = file_read(path, &data, &size);
            ending = err ? NULL : guess(data, size);
        }
        for (size_t i = 0; ending && i < sizeof formats / sizeof *formats; i++) {
            if (!strcasecmp(ending, formats[i].ending)) {
                *format = &formats[i];
                free(data);
                return NULL;
            }
        }
    }
    free(data);
    return err ? err : error_new("not a scene: expected OBJ, glTF, GLB, PLY, OFF or STL");
}

static void import_clear(struct scene_import *import)
{
    for (size_t i = 0; i < import->entry_count; i++)
        free(import->entries[i].name);
    free(import->entries);
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
    struct error *err = directory ? error_wrap(find_format(path, &format), "%s", path)
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
    import_clear(&import);
    free(directory);
    if (err)
        scene_destroy(import.scene);
    else
        *scene = import.scene;
    return err;
}
