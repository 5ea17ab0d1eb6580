/* SPDX-License-Identifier: Apache-2.0 */
#include "light/convert.h"
#include "base/error.h"
#include "base/warning.h"
#include "libprobe-query/sh.h"
#include "light/content.h"
#include "light/order.h"
#include "stream/header_number.h"
#include "stream/stream.h"

bool convert_is_asked(const struct convert_settings *settings)
{
    bool asked = settings->order || settings->dering.target != DERING_NONE ||
                 settings->content != CONVERT_AS_IS;
    for (int i = 0; i < BASIS_COUNT; i++)
        asked = asked || settings->basis[i];
    return asked;
}

static struct error *change_order(struct stream *stream, int order)
{
    struct table *probes = stream_table(stream, "probe");
    const int was = sh_order_of(table_column(probes, "sh")->width);
    if (order > was)
        return error_new("the probes have order %d: it cannot be raised to %d", was, order);
    struct error *err = order_reduce(probes, order);
    return err ? err : header_set_whole(&stream->header, "sh-order", order);
}

/* Other light: what was made of the old one goes. */
static void forget_bases(struct table *probes, struct warnings *warnings)
{
    for (int i = 0; i < BASIS_COUNT; i++)
        if (table_column(probes, basis_column((enum basis)i)))
            warnings_add(warnings, "basis dropped",
                         "column %s is of the light as it was: dropped (--basis %s makes it anew)",
                         basis_column((enum basis)i), basis_name((enum basis)i));
    basis_drop(probes);
}

static struct error *change_light(struct stream *stream, const struct convert_settings *settings,
                                  bool convolved, int threads, struct dering_count *count)
{
    struct table *probes = stream_table(stream, "probe");
    struct error *err = settings->order ? change_order(stream, settings->order) : NULL;
    if (!err && settings->dering.target != DERING_NONE) {
        err = dering_table(probes, &settings->dering, convolved, threads, count);
        if (!err)
            err = dering_to_header(&settings->dering, &stream->header);
    }
    if (!err && settings->content != CONVERT_AS_IS) {
        const bool to = settings->content == CONVERT_IRRADIANCE;
        err = content_convert(probes, convolved, to);
        if (!err)
            err = content_to_header(&stream->header, to);
    }
    return err;
}

struct error *convert_stream(struct stream *stream, const struct convert_settings *settings,
                             int threads, struct convert_outcome *outcome,
                             struct warnings *warnings)
{
    struct table *probes = stream_table(stream, "probe");
    bool convolved = false;
    const struct column *sh = probes ? table_column(probes, "sh") : NULL;
    const size_t width = sh ? sh->width : 0;
    *outcome = (struct convert_outcome){.dering = {.least = 1}};
    if (!convert_is_asked(settings))
        return NULL;
    if (!sh && probes && table_column(probes, "irradiance"))
        return error_new(
            "the probes are of surfaces: they have irradiance (one colour), no SH to convert");
    if (!sh)
        return error_new("the probes have no light (no column sh): run probe-capture");
    struct error *err = content_from_header(&stream->header, &convolved);
    if (!err)
        err = change_light(stream, settings, convolved, threads, &outcome->dering);
    if (settings->content != CONVERT_AS_IS)
        convolved = settings->content == CONVERT_IRRADIANCE;
    for (int i = 0; i < BASIS_COUNT; i++)
        if (settings->basis[i])
            table_remove_column(probes, basis_column((enum basis)i));
    if (!err && (outcome->dering.changed || table_column(probes, "sh")->width < width))
        forget_bases(probes, warnings);
    for (int i = 0; i < BASIS_COUNT && !err; i++)
        if (settings->basis[i])
            err = basis_convert(probes, (enum basis)i, convolved, threads,
                                settings->report ? &outcome->basis[i] : NULL);
    if (!err && outcome->dering.hopeless)
        warnings_add(
            warnings, "hopeless",
            "%zu probes have a mean below 0, which no window raises: they are left as they are",
            outcome->dering.hopeless);
    return err;
}

void convert_report_dering(const struct dering_count *count, const char *program, FILE *out)
{
    fprintf(out, "%s: %zu of %zu probes de-rung", program, count->changed, count->probes);
    if (count->changed)
        fprintf(out, ", the least r is %.3f", count->least);
    fprintf(out, "\n");
}

void convert_report(const struct convert_settings *settings, const struct convert_outcome *outcome,
                    const char *program, FILE *out)
{
    if (settings->dering.target != DERING_NONE)
        convert_report_dering(&outcome->dering, program, out);
    for (int i = 0; i < BASIS_COUNT; i++) {
        const struct basis_error *e = &outcome->basis[i];
        if (!settings->basis[i] || !settings->report)
            continue;
        fprintf(out, "%s: %s: RMS %.2f %%, worst %.2f %%", program, basis_name((enum basis)i),
                100 * e->rms, 100 * e->worst);
        if (e->probes)
            fprintf(out, " (probe %zu)", e->worst_probe);
        fprintf(out, " of mean irradiance, against the SH of %zu probes\n", e->probes);
    }
}
