/* SPDX-License-Identifier: Apache-2.0 */
#include "base/error.h"

#include <errno.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct error {
    int status;
    bool quiet; /* a closed pipe */
    char *message;
};

static char out_of_memory_message[] = "out of memory";
static struct error out_of_memory = {.status = EXIT_BAD_DATA, .message = out_of_memory_message};

struct error *error_memory(void)
{
    return &out_of_memory;
}

/* Formats into a fresh string; NULL when memory is short. */
static char *format_new(const char *format, va_list args)
{
    va_list again;
    va_copy(again, args);
    const int length = vsnprintf(NULL, 0, format, args);
    char *text = length < 0 ? NULL : malloc((size_t)length + 1);
    if (text)
        vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    return text;
}

/* Takes `message`. */
static struct error *error_from(int status, bool quiet, char *message)
{
    struct error *err = message ? malloc(sizeof *err) : NULL;
    if (!err) {
        free(message);
        return error_memory();
    }
    *err = (struct error){.status = status, .quiet = quiet, .message = message};
    return err;
}

/* "head: tail"; takes neither. */
static char *join(const char *head, const char *tail)
{
    const size_t size = strlen(head) + strlen(tail) + 3;
    char *text = malloc(size);
    if (text)
        snprintf(text, size, "%s: %s", head, tail);
    return text;
}

struct error *error_new(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    char *message = format_new(format, args);
    va_end(args);
    return error_from(EXIT_BAD_DATA, false, message);
}

struct error *error_usage(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    char *message = format_new(format, args);
    va_end(args);
    return error_from(EXIT_BAD_USAGE, false, message);
}

struct error *error_above(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    char *message = format_new(format, args);
    va_end(args);
    return error_from(EXIT_ABOVE, false, message);
}

struct error *error_system(int number, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    char *what = format_new(format, args);
    va_end(args);
    char *message = what ? join(what, strerror(number)) : NULL;
    free(what);
    return error_from(EXIT_BAD_DATA, number == EPIPE, message);
}

struct error *error_memory_for(struct error *err, const char *format, ...)
{
    if (err != &out_of_memory)
        return err;
    va_list args;
    va_start(args, format);
    char *what = format_new(format, args);
    va_end(args);
    char *message = what ? join(err->message, what) : NULL;
    free(what);
    return message ? error_from(EXIT_BAD_DATA, false, message) : err;
}

struct error *error_wrap(struct error *err, const char *format, ...)
{
    if (!err || err == &out_of_memory)
        return err;
    va_list args;
    va_start(args, format);
    char *context = format_new(format, args);
    va_end(args);
    char *message = context ? join(context, err->message) : NULL;
    free(context);
    if (message) { /* without memory the context is lost, not the error */
        free(err->message);
        err->message = message;
    }
    return err;
}

const char *error_message(const struct error *err)
{
    return err->message;
}

bool error_is_of_data(const struct error *err)
{
    return err && err != error_memory() && error_status(err) == EXIT_BAD_DATA;
}

int error_status(const struct error *err)
{
    return err ? err->status : EXIT_DONE;
}

void error_destroy(struct error *err)
{
    if (!err || err == &out_of_memory)
        return;
    free(err->message);
    free(err);
}

int error_exit(const char *program, struct error *err)
{
    const int status = error_status(err);
    if (err && !err->quiet) {
        fprintf(stderr, "%s: %s\n", program, err->message);
        if (status == EXIT_BAD_USAGE)
            fprintf(stderr, "Try '%s --help'.\n", program);
    }
    error_destroy(err);
    return status;
}
