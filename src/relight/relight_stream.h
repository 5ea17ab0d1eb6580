/* SPDX-License-Identifier: Apache-2.0 */
/* relight_stream: a stream with other light, block by block, for each row of weights an output.
 */
#ifndef RELIGHT_STREAM_H
#define RELIGHT_STREAM_H

#include "relight/other_light.h"
#include "stream/common_options.h"

struct error;
struct warnings;

/* What is asked for. Texts are borrowed. */
struct relight_ask {
    const char *table;    /* file of weights; NULL: none */
    const char **setting; /* NAME=W each, of all rows; the caller's */
    size_t settings;
    const char *row; /* of the table this one alone; NULL: all */
    struct other_light light;
    bool keep;            /* the parts' columns and keys */
    const char *recorded; /* provenance that is added */
    struct common common; /* output, encoding, threads */
};

/* Whether an output has the place of a row's name, %s. */
bool relight_is_pattern(const char *output);

/* Relights the stream at `input`. Errors: what the stream has no part for; weights, names and
 * files that are none; no output appears then. */
struct error *relight_stream(const struct relight_ask *ask, const char *input,
                             struct warnings *warnings);

#endif
