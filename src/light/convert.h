/* SPDX-License-Identifier: Apache-2.0 */
/* convert: what probe-cat turns a stream's light into: fewer bands, less ringing, irradiance or
 * radiance, other bases; in this order.
 */
#ifndef CONVERT_H
#define CONVERT_H

#include "light/basis.h"
#include "light/dering.h"

#include <stdio.h>

struct error;
struct stream;
struct warnings;

enum convert_content { CONVERT_AS_IS, CONVERT_RADIANCE, CONVERT_IRRADIANCE };

struct convert_settings {
    int order; /* 0: as it is */
    struct dering_settings dering;
    enum convert_content content;
    bool basis[BASIS_COUNT];
    bool report; /* how far the bases are from the SH */
};

/* What came of it. */
struct convert_outcome {
    struct dering_count dering;
    struct basis_error basis[BASIS_COUNT];
};

/* Whether there is anything to do, for which the whole stream is needed in memory. */
bool convert_is_asked(const struct convert_settings *settings);

/* Converts the table probe, and the header with it. Columns of bases that were there go, with a
 * warning, where the light that they were made of changes and they are not asked for. */
struct error *convert_stream(struct stream *stream, const struct convert_settings *settings,
                             int threads, struct convert_outcome *outcome,
                             struct warnings *warnings);

/* Prints what came of it, a line each: of dering, and of each basis where settings.report. */
void convert_report(const struct convert_settings *settings, const struct convert_outcome *outcome,
                    const char *program, FILE *out);

/* A line on what de-ringing changed. */
void convert_report_dering(const struct dering_count *count, const char *program, FILE *out);

#endif
