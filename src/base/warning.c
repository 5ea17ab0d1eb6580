/* SPDX-License-Identifier: Apache-2.0 */
#include "base/warning.h"
#include "base/array.h"
#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct warning *find(const struct warnings *warnings, const char *kind)
{
    for (size_t i = 0; i < warnings->count; i++)
        if (!warnings->list[i].key && !strcmp(warnings->list[i].kind, kind))
            return &warnings->list[i];
    return NULL;
}

void warnings_add(struct warnings *warnings, const char *kind, const char *format, ...)
{
    if (!warnings)
        return;
    struct warning *known = find(warnings, kind);
    if (known) {
        known->count++;
        return;
    }
    struct error *err = array_reserve(&warnings->list, &warnings->capacity, warnings->count + 1,
                                      sizeof *warnings->list);
    if (err) {
        error_destroy(err);
        return;
    }
    va_list args;
    va_start(args, format);
    const int length = vsnprintf(NULL, 0, format, args);
    va_end(args);
    char *message = length < 0 ? NULL : malloc((size_t)length + 1);
    if (!message)
        return;
    va_start(args, format);
    vsnprintf(message, (size_t)length + 1, format, args);
    va_end(args);
    warnings->list[warnings->count++] =
        (struct warning){.kind = kind, .message = message, .count = 1};
}

size_t warnings_of_kind(const struct warnings *warnings, const char *kind)
{
    size_t count = 0;
    for (size_t i = 0; i < warnings->count; i++)
        count += strcmp(warnings->list[i].kind, kind) ? 0 : warnings->list[i].count;
    return count;
}

void warnings_move(struct warnings *to, struct warnings *from)
{
    struct error *err =
        to ? array_reserve(&to->list, &to->capacity, to->count + from->count, sizeof *to->list)
           : NULL;
    if (to && !err && from->count) {
        memcpy(to->list + to->count, from->list, from->count * sizeof *from->list);
        to->count += from->count;
        from->count = 0;
    }
    error_destroy(err);
    warnings_clear(from);
}

void warnings_remove(struct warnings *warnings, size_t i)
{
    free(warnings->list[i].message);
    warnings->count--;
    memmove(warnings->list + i, warnings->list + i + 1,
            (warnings->count - i) * sizeof *warnings->list);
}

void warnings_print(struct warnings *warnings, const char *program)
{
    for (size_t i = 0; i < warnings->count; i++) {
        const struct warning *w = &warnings->list[i];
        fprintf(stderr, "%s: warning: %s", program, w->message);
        if (w->count > 1)
            fprintf(stderr, " (and %zu more like it)", w->count - 1);
        fputc('\n', stderr);
    }
    warnings_clear(warnings);
}

void warnings_clear(struct warnings *warnings)
{
    for (size_t i = 0; i < warnings->count; i++)
        free(warnings->list[i].message);
    free(warnings->list);
    *warnings = (struct warnings){0};
}
