/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_told.h"
#include "base/error.h"
#include "base/warning.h"
#include "math/hash.h"
#include "stream/stream.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void scene_told_mark(struct warnings *of_scene, const char *path, uint64_t file,
                     struct warnings *to)
{
    const size_t length = strlen(path);
    for (size_t i = 0; i < of_scene->count; i++) {
        struct warning *w = &of_scene->list[i];
        const uint64_t numbers[] = {file, w->count};
        /* the next program may name the file in another way */
        const char *text = w->message + (strncmp(w->message, path, length) ? 0 : length);
        struct hash hash;
        hash_start(&hash, 0);
        hash_add(&hash, numbers, sizeof numbers);
        hash_add(&hash, w->kind, strlen(w->kind) + 1);
        hash_add(&hash, text, strlen(text));
        w->key = hash_value(&hash) | !hash_value(&hash);
    }
    warnings_move(to, of_scene);
}

struct error *scene_told(struct warnings *warnings, const struct stream_header *header, bool quiet,
                         char **told)
{
    const char *before = header ? header_key(header, SCENE_TOLD_KEY) : NULL;
    size_t size = 0;
    FILE *out = open_memstream(told, &size);
    if (!out)
        return error_memory();
    fputs(before ? before : "", out);
    bool some = before;
    for (size_t i = 0; i < warnings->count; i++) {
        char key[24];
        if (!warnings->list[i].key)
            continue;
        snprintf(key, sizeof key, "%016" PRIx64, warnings->list[i].key);
        if (before && strstr(before, key)) {
            warnings_remove(warnings, i--);
        } else if (!quiet) {
            fprintf(out, "%s%s", some ? "," : "", key);
            some = true;
        }
    }
    if (fclose(out))
        return error_memory();
    if (!some) {
        free(*told);
        *told = NULL;
    }
    return NULL;
}

struct error *scene_told_in(struct warnings *warnings, struct stream_header *header, bool quiet)
{
    char *told = NULL;
    struct error *err = scene_told(warnings, header, quiet, &told);
    if (!err && told)
        err = header_set_key(header, SCENE_TOLD_KEY, told);
    free(told);
    return err;
}
