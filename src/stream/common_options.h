/* SPDX-License-Identifier: Apache-2.0 */
/* common_options: the options that many programs share, with one meaning everywhere.
 *
 *     struct common common = common_default();
 *     struct option_row shared[COMMON_ROWS];
 *     ... groups[] = {rows, common_rows(&common, COMMON_STREAM | COMMON_THREADS, shared), NULL} ...
 */
#ifndef COMMON_OPTIONS_H
#define COMMON_OPTIONS_H

#include "stream/stream.h"

#include <stdbool.h>
#include <stdint.h>

struct option_row;

struct common {
    const char *output;            /* -o: a file's path, or "-": standard output */
    enum stream_encoding encoding; /* STREAM_AS_READ unless --text or --binary */
    int threads;                   /* 1 or more; default threads_available() */
    int64_t seed;                  /* 0 .. 2^53 */
    bool quiet;                    /* no warnings, no progress */
    bool progress;                 /* default: standard error is a terminal */
};

enum {
    COMMON_OUTPUT = 1,   /* --output */
    COMMON_ENCODING = 2, /* --text, --binary */
    COMMON_THREADS = 4,
    COMMON_SEED = 8,
    COMMON_PROGRESS = 16, /* --progress */
    COMMON_STREAM = COMMON_OUTPUT | COMMON_ENCODING,
    COMMON_ROWS = 10, /* room for all of them, --quiet (always there) and the end */
};

struct common common_default(void);

/* Fills rows (COMMON_ROWS of them) with the options named by `which` (and --quiet) and returns
 * rows. */
const struct option_row *common_rows(struct common *common, unsigned which,
                                     struct option_row *rows);

#endif
