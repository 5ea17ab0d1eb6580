/* SPDX-License-Identifier: Apache-2.0 */
/* paths: what a bake makes on disk beside its output, and takes away again.
 *
 *     struct bake_paths paths = {0};
 *     err = bake_paths_report(&paths, report, output);
 *     if (!err) err = bake_paths_make(&paths);
 *     ... stages write into paths.baked ...
 *     bake_paths_clear(&paths);
 */
#ifndef PATHS_H
#define PATHS_H

#include <limits.h>
#include <stdbool.h>

struct error;

/* Starts as {0}. */
struct bake_paths {
    char directory[PATH_MAX];    /* of temporary files; "": there is none */
    char baked[PATH_MAX + 32];   /* the stream */
    char figures[PATH_MAX + 32]; /* what a program prints */
    char packed[PATH_MAX + 32];
    char *report;               /* a folder; NULL: no pictures are wanted */
    bool report_made;           /* it was not there */
    char *text, *pair, *probes; /* in it */
};

/* Names the report's folder and what is in it: `report`, unless that is "none"; if NULL, the one
 * beside the output, without its .probe; output NULL: that is no file, and there is no report. A
 * usage error where one of its files is read. */
struct error *bake_paths_report(struct bake_paths *paths, const char *report, const char *output);

/* Makes the report's folder, where it is missing, and one of temporary files, in which programs
 * that are run put theirs, too (TMPDIR). Errors name the folder. */
struct error *bake_paths_make(struct bake_paths *paths);

/* Removes what is in the report's folder of a report. */
void bake_paths_forget(const struct bake_paths *paths);

/* Removes the temporary files, and the report's folder if it was made and is empty. */
void bake_paths_clear(struct bake_paths *paths);

#endif
