/* SPDX-License-Identifier: Apache-2.0 */
/* relight_senders: the light that surfaces scatter to probes, by what falls on the senders that
 * probes have links to (capture/senders.h).
 */
#ifndef RELIGHT_SENDERS_H
#define RELIGHT_SENDERS_H

#include "stream/common_options.h"

#include <stdbool.h>

struct error;
struct warnings;

/* What is asked for. Texts are borrowed. */
struct relight_senders_ask {
    const char *senders; /* the senders with their direct irradiance; NULL: nothing is asked for */
    const char *direct;  /* the probes with their direct light, which is added; NULL: none */
    int bounces;
    bool keep;                   /* links, senders and keys */
    const char *recorded;        /* provenance that is added */
    const struct common *common; /* output, encoding, threads */
};

/* Relights the stream at `input`, block by block. Errors: it has no such links, the senders or the
 * probes are others, their light is not straight from lights or not the same; no output appears
 * then. */
struct error *relight_senders(const struct relight_senders_ask *ask, const char *input,
                              struct warnings *warnings);

#endif
