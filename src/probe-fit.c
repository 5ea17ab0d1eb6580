/* SPDX-License-Identifier: Apache-2.0 */
/* probe-fit: gives probes the values that are nearest to those of samples between them. */
#include "base/claim.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "base/warning.h"
#include "fit/fit_stream.h"
#include "stream/common_options.h"
#include "stream/stream.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>

struct arguments {
    struct fit_settings settings;
    struct common common;
};

/* A line a column: how far from the samples, in root mean square. */
static void print_report(const struct fit_report *report, bool measure, FILE *out)
{
    for (size_t i = 0; i < report->count; i++) {
        const struct fit_told *t = &report->told[i];
        if (measure)
            fprintf(out, "%s\t%g\t%g\n", t->name, t->held, t->all);
        else if (isnan(t->held))
            fprintf(out, "probe-fit: %s: rms %g of %g at the samples, %d steps\n", t->name,
                    t->fitted, t->all, t->steps);
        else
            fprintf(out, "probe-fit: %s: rms %g of %g at the samples, was %g, %d steps\n", t->name,
                    t->fitted, t->all, t->held, t->steps);
    }
}

static struct error *fit(struct arguments *a, struct program *program, const char *input,
                         struct warnings *warnings)
{
    struct stream *probes = NULL, *samples = NULL;
    struct fit_report report = {0};
    struct error *err = stream_read(&probes, program->operands[0]);
    if (!err)
        err = stream_read(&samples, input);
    if (!err) {
        a->settings.threads = a->common.threads;
        err = error_wrap(fit_stream(probes, samples, &a->settings, &report, warnings), "%s, %s",
                         file_input_name(program->operands[0]), file_input_name(input));
    }
    if (!err && (a->settings.measure || !a->common.quiet))
        print_report(&report, a->settings.measure, a->settings.measure ? stdout : stderr);
    if (!err && a->settings.measure) {
        if (fflush(stdout) || ferror(stdout))
            err = error_system(errno, "stdout");
    } else if (!err) {
        err = options_record(program, program->operands[0]);
        if (!err)
            err = header_add_provenance(&probes->header, program->recorded);
        if (!err)
            err = stream_write(probes, a->common.output, a->common.encoding);
    }
    fit_report_clear(&report);
    stream_destroy(probes);
    stream_destroy(samples);
    return err;
}

int main(int argc, char **argv)
{
    struct arguments a = {.settings = {.smooth = 0.03}, .common = common_default()};
    const struct option_row rows[] = {
        {.name = "smooth",
         .argument = "X",
         .kind = OPTION_REAL,
         .value = &a.settings.smooth,
         .most = 1e6,
         .help = "how much bends count against the error; 0: not at all"},
        {.name = "columns",
         .argument = "LIST",
         .kind = OPTION_TEXT,
         .value = &a.settings.columns,
         .shown = "light, ao, sky, visibility, bent_normal",
         .help = "fit these columns of the samples"},
        {.name = "measure",
         .kind = OPTION_FLAG,
         .value = &a.settings.measure,
         .unrecorded = true,
         .help = "fit nothing: print how far PROBES are from SAMPLES, a column a\n"
                 "line: its name, the error and the values, root mean squares"},
        {0}};
    struct option_row shared[COMMON_ROWS];
    const struct option_row *const groups[] = {
        rows, common_rows(&a.common, COMMON_STREAM | COMMON_THREADS, shared), NULL};
    struct program program = {
        .name = "probe-fit",
        .usage = "[OPTION]... PROBES [SAMPLES]",
        .summary = "Gives PROBES, vertices with faces between them, the values that, interpolated "
                   "over the faces,\n"
                   "are nearest to those of SAMPLES (standard input) in the mean square.",
        .operands_least = 1,
        .operands_most = 2};
    struct warnings warnings = {0};
    struct error *err = options_parse(&program, groups, argc, argv);
    const char *input = !err && program.operand_count > 1 ? program.operands[1] : "-";
    if (!err)
        err = file_inputs_differ(program.operands[0], "PROBES", input, "SAMPLES");
    if (!err)
        claim_in_place(program.operands[0]);
    if (!err)
        err = fit(&a, &program, input, &warnings);
    if (!a.common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    program_clear(&program);
    return error_exit(program.name, err);
}
