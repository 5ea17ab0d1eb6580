/* SPDX-License-Identifier: Apache-2.0 */
/* words: a command line that is being made.
 *
 *     struct words words = {0};
 *     words_add(&words, "--rays");
 *     words_add_format(&words, "%d", rays);
 *     err = words_line(&words, &line);     where an addition failed, this says so
 *     words_clear(&words);
 */
#ifndef WORDS_H
#define WORDS_H

#include <stddef.h>

struct error;

/* Starts as {0}. */
struct words {
    char **list; /* owned, NULL behind the last; NULL where there are none */
    size_t count, capacity;
    struct error *err; /* the first that an addition had; owned */
};

void words_add(struct words *words, const char *word);
void words_add_format(struct words *words, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* --name, and its argument where that is not NULL. */
void words_add_option(struct words *words, const char *name, const char *argument);

/* A file that is an operand: what could be an option gets ./ before it. */
void words_add_file(struct words *words, const char *path);

/* The words with blanks between, each quoted for a shell where it needs it; the caller frees *line.
 * Error: what an addition failed with; it is not given twice. */
struct error *words_line(struct words *words, char **line);

void words_clear(struct words *words);

#endif
