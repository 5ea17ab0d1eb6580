/* SPDX-License-Identifier: Apache-2.0 */
/* tap: a test program's results, one line each, in the Test Anything Protocol.
 *
 *     int main(void) { test_a(); test_b(); return tap_done(); }
 *
 * Each check names the property it holds. A failed check prints where and, where given, what was
 * seen.
 */
#ifndef TAP_H
#define TAP_H

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/error.h"

/* Whether this is a build with sanitizers. They look for what is wrong on a path through the code,
 * and the same path again shows them nothing: there, random cases are fewer, and statistics are
 * left to the plain build. */
#ifndef __has_feature
#define __has_feature(feature) 0
#endif
#if defined __SANITIZE_ADDRESS__ || __has_feature(address_sanitizer)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

/* Of so many random cases, those that are made. */
__attribute__((unused)) static unsigned tap_cases(unsigned count)
{
    return SANITIZED ? (count + 3) / 4 : count;
}

static int tap_count, tap_failed;

__attribute__((format(printf, 4, 5), unused)) static bool tap_check(const char *file, int line,
                                                                    bool holds, const char *format,
                                                                    ...)
{
    va_list args;
    va_start(args, format);
    printf("%s %d - ", holds ? "ok" : "not ok", ++tap_count);
    vprintf(format, args);
    putchar('\n');
    va_end(args);
    if (!holds) {
        tap_failed++;
        printf("# %s:%d\n", file, line);
    }
    fflush(stdout);
    return holds;
}

/* ok(condition, "name %d", i) */
#define ok(condition, ...) tap_check(__FILE__, __LINE__, (condition), __VA_ARGS__)

/* A check that cannot be made here, with the reason. */
__attribute__((format(printf, 1, 2), unused)) static void tap_skip(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    printf("ok %d # SKIP ", ++tap_count);
    vprintf(format, args);
    putchar('\n');
    va_end(args);
}

/* Ends a test when its set-up fails: err is not to be NULL here. */
#define bail(...) (printf("Bail out! "), printf(__VA_ARGS__), putchar('\n'), exit(1))

/* A step of the set-up, which succeeds. */
__attribute__((unused)) static void must(struct error *err)
{
    if (err)
        bail("%s", error_message(err));
}

__attribute__((unused)) static int tap_done(void)
{
    printf("1..%d\n", tap_count);
    return tap_failed != 0;
}

#endif
