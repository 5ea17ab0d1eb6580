/* SPDX-License-Identifier: Apache-2.0 */
#include "bake/words.h"
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Takes `word`; NULL: memory was short. */
static void take(struct words *words, char *word)
{
    if (!words->err && !word)
        words->err = error_memory();
    if (!words->err)
        words->err =
            array_reserve(&words->list, &words->capacity, words->count + 2, sizeof *words->list);
    if (words->err) {
        free(word);
        return;
    }
    words->list[words->count++] = word;
    words->list[words->count] = NULL;
}

void words_add(struct words *words, const char *word)
{
    take(words, strdup(word));
}

void words_add_format(struct words *words, const char *format, ...)
{
    char *word = NULL;
    va_list args;
    va_start(args, format);
    if (vasprintf(&word, format, args) < 0)
        word = NULL;
    va_end(args);
    take(words, word);
}

void words_add_option(struct words *words, const char *name, const char *argument)
{
    words_add_format(words, "--%s", name);
    if (argument)
        words_add(words, argument);
}

void words_add_file(struct words *words, const char *path)
{
    words_add_format(words, "%s%s", *path == '-' && path[1] ? "./" : "", path);
}

struct error *words_line(struct words *words, char **line)
{
    struct program quoted = {0};
    struct error *err = words->err;
    words->err = NULL;
    for (size_t i = 0; i < words->count && !err; i++)
        err = options_record(&quoted, words->list[i]);
    *line = quoted.recorded;
    if (!err && !*line)
        err = error_memory();
    if (err) {
        free(*line);
        *line = NULL;
    }
    return err;
}

void words_clear(struct words *words)
{
    for (size_t i = 0; i < words->count; i++)
        free(words->list[i]);
    free(words->list);
    error_destroy(words->err);
    *words = (struct words){0};
}
