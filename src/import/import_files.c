/* SPDX-License-Identifier: Apache-2.0 */
/* What importers call: the files that a scene's file names, and its textures. */
#include "base/file.h"
#include "base/number.h"
#include "import/import.h"

#include <dirent.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* -- files ------------------------------------------------------------------------------------ */

void scene_import_content(struct scene_import *import, char **data, size_t *size)
{
    *data = import->content;
    *size = import->content_size;
    import->content = NULL;
}

void scene_import_bare(const char **text, size_t *size)
{
    if (*size >= 3 && !memcmp(*text, "\xef\xbb\xbf", 3)) {
        *text += 3;
        *size -= 3;
    }
    while (*size > 0 && (!(*text)[*size - 1] || (*text)[*size - 1] == 0x1a))
        --*size;
}

const char *scene_import_number(const char *from, const char *end, double *value)
{
    static const struct {
        const char *word;
        double value;
    } words[] = {{"nan(ind)", NAN}, {"nan(snan)", NAN}, {"1.#IND", NAN},
                 {"1.#QNAN", NAN},  {"1.#SNAN", NAN},   {"1.#INF", INFINITY}};
    const char *word = from + (from < end && *from == '-');
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        const size_t length = strlen(words[i].word);
        if ((size_t)(end - word) < length || strncasecmp(word, words[i].word, length))
            continue;
        *value = word > from ? -words[i].value : words[i].value;
        for (word += length; word < end && *word == '0';) /* 1.#INF00 */
            word++;
        return word;
    }
    return number_read_f64(from, end, value);
}

struct error *scene_import_broken(struct scene_import *import, const char *kind, size_t line,
                                  const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    const int length = vasprintf(&text, format, args);
    va_end(args);
    if (length < 0)
        return error_memory();
    struct error *err = NULL;
    if (!import->lenient) {
        import->broken_line = line;
        err = error_new("%s (--lenient leaves out what is broken)", text);
    } else if (line) {
        warnings_add(import->warnings, kind, "%s:%zu: %s: left out", import->path, line, text);
    } else {
        warnings_add(import->warnings, kind, "%s: %s: left out", import->path, text);
    }
    free(text);
    return err;
}

void scene_import_warn_end(struct scene_import *import, const char *path, const char *text,
                           size_t size)
{
    if (!size || !memchr("0123456789.", text[size - 1], 11))
        return;
    size_t first = size;
    while (first > 0 && text[first - 1] != '\n' && text[first - 1] != '\r')
        first--;
    const size_t length = size - first;
    if (!memchr(text + first, '#', length))
        warnings_add(import->warnings, "last line without an end",
                     "%s: nothing ends the last line, '%.*s': if the file is cut off there, its "
                     "last number is another",
                     path, (int)(length < 60 ? length : 60), text + first);
}

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
    struct image image;
    struct error *err = image_decode(&image, data, size, use);
    if (err == error_memory())
        return err;
    if (err) {
        struct error *damage = err;
        err = NULL;
        if (image_is_known(data, size))
            err = scene_import_broken(import, "texture damaged", 0, "texture %s: %s", name,
                                      error_message(damage));
        else
            warnings_add(import->warnings, "texture not understood",
                         "%s: texture %s: %s: the material's factor alone is used", import->path,
                         name, error_message(damage));
        error_destroy(damage);
    } else {
        struct scene_texture picture = scene_texture_of(&image);
        picture.wrap_u = sampler.wrap_u;
        picture.wrap_v = sampler.wrap_v;
        picture.nearest = sampler.nearest;
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
    struct error *unread = err || !path ? NULL : file_read(path, &data, &size);
    if (!err && unread && !error_is_of_data(unread)) {
        err = error_wrap(unread, "texture %s", path);
        unread = NULL;
    } else if (!err && path && !unread) {
        err = scene_import_picture(import, name, data, size, use, sampler, texture);
    } else if (!err) {
        if (unread)
            err = scene_import_broken(import, "texture unreadable", 0, "texture %s: %s", name,
                                      error_message(unread));
        else
            warnings_add(import->warnings, "texture missing",
                         "%s: texture %s is missing: the material's factor alone is used",
                         import->path, name);
        if (!err)
            err = add_entry(
                import,
                (struct texture_entry){.use = use, .sampler = sampler, .texture = SCENE_NONE},
                name);
    }
    error_destroy(unread);
    free(data);
    free(path);
    return err;
}

void scene_import_clear(struct scene_import *import)
{
    for (size_t i = 0; i < import->entry_count; i++)
        free(import->entries[i].name);
    free(import->entries);
    free(import->content);
}

/* -- materials -------------------------------------------------------------------------------- */

/* Whether some texel's alpha, times the factor, is at least `least`, and above 0. */
static bool any_alpha(const struct scene_texture *t, float factor, float least)
{
    for (uint32_t y = 0; y < t->height; y++) {
        for (uint32_t x = 0; x < t->width; x++) {
            float rgba[4];
            scene_texture_texel(t, x, y, rgba);
            if (factor * rgba[3] >= least && factor * rgba[3] > 0)
                return true;
        }
    }
    return false;
}

void scene_import_warn_hidden(struct scene_import *import, const struct scene_material *m,
                              const char *name)
{
    const bool cut = m->alpha == SCENE_CUTOUT;
    const int32_t map = m->alpha_map.texture;
    const float least = cut ? m->cutoff : 0;
    char reach[64] = "";
    if (m->alpha == SCENE_OPAQUE ||
        (map == SCENE_NONE ? m->opacity >= least && m->opacity > 0
                           : any_alpha(&import->scene->textures[map], m->opacity, least)))
        return;
    if (cut)
        snprintf(reach, sizeof reach, ", and should reach %.4g", (double)m->cutoff);
    warnings_add(import->warnings, "nothing to be seen",
                 "%s: material '%.60s' hides all that has it, for all light passes: its opacity "
                 "(d, 1 - Tr, alpha) is %.4g%s%s",
                 import->path, name, (double)m->opacity,
                 map == SCENE_NONE ? "" : " times that of a picture", reach);
}
