/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/report.h"
#include "base/array.h"
#include "base/error.h"
#include "base/number.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

struct error *report_add(struct report *report, const char *measure, const char *of,
                         struct estimate estimate)
{
    struct error *err =
        array_reserve(&report->rows, &report->capacity, report->count + 1, sizeof *report->rows);
    if (err)
        return err;
    struct report_row *row = &report->rows[report->count++];
    snprintf(row->measure, sizeof row->measure, "%s", measure);
    snprintf(row->of, sizeof row->of, "%s", of);
    row->estimate = estimate;
    return NULL;
}

struct error *report_add_number(struct report *report, const char *measure, const char *of,
                                double value)
{
    return report_add(report, measure, of,
                      (struct estimate){.value = value, .low = (double)NAN, .high = (double)NAN});
}

struct estimate report_get(const struct report *report, const char *measure, const char *of)
{
    for (size_t i = 0; i < report->count; i++)
        if (!strcmp(report->rows[i].measure, measure) && !strcmp(report->rows[i].of, of))
            return report->rows[i].estimate;
    return (struct estimate){(double)NAN, (double)NAN, (double)NAN};
}

void report_clear(struct report *report)
{
    free(report->rows);
    *report = (struct report){0};
}

/* -- for scripts ------------------------------------------------------------------------------ */

/* The shortest text that reads back to the same; `none` for NaN. */
static const char *number(double value, const char *none, char text[NUMBER_ROOM + 1])
{
    if (!isfinite(value))
        return none;
    *number_write_f64(text, value) = '\0';
    return text;
}

static void print_tsv(const struct report *report, FILE *out)
{
    fprintf(out, "measure\tof\tvalue\tlow\thigh\n");
    for (size_t i = 0; i < report->count; i++) {
        const struct report_row *row = &report->rows[i];
        char text[3][NUMBER_ROOM + 1];
        fprintf(out, "%s\t%s\t%s\t%s\t%s\n", row->measure, row->of,
                number(row->estimate.value, "nan", text[0]),
                number(row->estimate.low, "nan", text[1]),
                number(row->estimate.high, "nan", text[2]));
    }
}

static void print_json(const struct report *report, FILE *out)
{
    fprintf(out, "[\n");
    for (size_t i = 0; i < report->count; i++) {
        const struct report_row *row = &report->rows[i];
        char text[3][NUMBER_ROOM + 1];
        fprintf(
            out,
            "  {\"measure\": \"%s\", \"of\": \"%s\", \"value\": %s, \"low\": %s, \"high\": %s}%s\n",
            row->measure, row->of, number(row->estimate.value, "null", text[0]),
            number(row->estimate.low, "null", text[1]), number(row->estimate.high, "null", text[2]),
            i + 1 < report->count ? "," : "");
    }
    fprintf(out, "]\n");
}

/* -- for people ------------------------------------------------------------------------------- */

static double value_of(const struct report *report, const char *measure, const char *of)
{
    return report_get(report, measure, of).value;
}

/* Three digits, but no exponent where a whole number says it. Nine columns, right-aligned; NaN:
 * none. */
static void print_cell(FILE *out, double value)
{
    if (isnan(value))
        fprintf(out, "%9s", "");
    else if (fabs(value) >= 1000 && fabs(value) < 1e8)
        fprintf(out, "%9.0f", value);
    else
        fprintf(out, "%9.3g", value);
}

static double percent(const struct report *report, const char *measure, const char *of)
{
    return 100 * value_of(report, measure, of);
}

/* Of what is a light: percent of the mean irradiance; as it is, where there is no light. */
static struct estimate light(const struct report *report, const char *measure, const char *of)
{
    char relative[40];
    snprintf(relative, sizeof relative, "%s_relative", measure);
    const struct estimate e = report_get(report, relative, of);
    return isnan(e.value) ? report_get(report, measure, of)
                          : (struct estimate){100 * e.value, 100 * e.low, 100 * e.high};
}

/* What a part of the points is called. */
static void name_part(const struct report *report, const char *of, char *name, size_t room)
{
    const double from = value_of(report, "surface_from", of),
                 to = value_of(report, "surface_to", of);
    if (isnan(from))
        snprintf(name, room, "%s", of);
    else
        snprintf(name, room, "surface %.3g .. %.3g", from, to);
}

/* "8.1 .. 9.3"; nothing where there is none. */
static const char *interval_text(struct estimate e, double scale, char text[64])
{
    *text = '\0';
    if (!isnan(e.low))
        snprintf(text, 64, "%.3g .. %.3g", scale * e.low, scale * e.high);
    return text;
}

static void print_part(const struct report *report, const char *of, FILE *out)
{
    char name[64], interval[64];
    const struct estimate error = report_get(report, "error", of);
    name_part(report, of, name, sizeof name);
    fprintf(out, "%-25s%7.0f", name, value_of(report, "points", of));
    if (!(value_of(report, "points", of) > 0)) {
        fprintf(out, "\n");
        return;
    }
    print_cell(out, 100 * error.value);
    fprintf(out, "%16s", interval_text(error, 100, interval));
    print_cell(out, percent(report, "bad", of));
    print_cell(out, percent(report, "error_seen", of));
    print_cell(out, light(report, "rms", of).value);
    static const char *const lights[] = {"bias", "mean", "p95", "p99", "worst"}, *const shares[] = {
                                                                                     "too_bright",
                                                                                     "too_dark",
                                                                                     "unseen"};
    for (size_t i = 0; i < sizeof lights / sizeof *lights; i++)
        print_cell(out, light(report, lights[i], of).value);
    for (size_t i = 0; i < sizeof shares / sizeof *shares; i++)
        print_cell(out, percent(report, shares[i], of));
    fprintf(out, "\n");
}

/* What the rounding of weights leaves is nothing. */
static double whole(double share)
{
    return fabs(share) < 1e-12 ? 0 : share;
}

/* A share in percent, and its interval where it has one, in 28 columns or more. */
static void print_column(const struct report *report, const char *measure, const char *of,
                         FILE *out)
{
    char interval[64], text[80];
    struct estimate e = report_get(report, measure, of);
    e.value = whole(e.value);
    e.low = whole(e.low);
    snprintf(text, sizeof text, "%8.3g %%", 100 * e.value);
    if (*interval_text(e, 100, interval))
        snprintf(text + strlen(text), sizeof text - strlen(text), " (%s)", interval);
    fprintf(out, "%-27s ", isnan(e.value) ? "       -" : text);
}

static void print_worst(const struct report *report, const char *of, const char *before, FILE *out)
{
    fprintf(out, "%s  %-18s  ", before, "worst cell");
    if (value_of(report, "leak_worst", of) > 0)
        fprintf(out, "%.0f at %.6g %.6g %.6g: %.3g %% of its weight, %.3g %% of what leaks\n",
                value_of(report, "leak_worst_cell", of), value_of(report, "leak_worst_x", of),
                value_of(report, "leak_worst_y", of), value_of(report, "leak_worst_z", of),
                percent(report, "leak_worst", of), percent(report, "leak_worst_part", of));
    else
        fprintf(out, "none: nothing leaks\n");
}

/* What leaks outside of the hull, where there is a point. */
static void print_outside(const struct report *report, const char *before, FILE *out)
{
    static const char *const of[] = {"outside-all-probes", "outside"},
                             *const measure[] = {"leak_volume", "leak_light"},
                             *const name[] = {"outside: unseen", "outside: leaks"};
    const int first = isnan(value_of(report, "leak_volume", of[0]));
    for (int i = 0; i < 2; i++) {
        if (isnan(value_of(report, measure[i], "outside")))
            continue;
        fprintf(out, "%s  %-18s", before, name[i]);
        for (int k = first; k < 2; k++)
            print_column(report, measure[i], of[k], out);
        fprintf(out, "\n");
    }
    if (value_of(report, "lost", "outside") > 0)
        fprintf(out, "%s  %-18s%8.3g %%\n", before, "outside: see none",
                percent(report, "lost", "outside"));
}

void report_print_leaks(const struct report *report, const char *before, FILE *out)
{
    static const struct {
        const char *name, *measure;
    } rows[] = {{"unseen weight", "leak_volume"},
                {"light that leaks", "leak_light"},
                {"blind points", "blind"}};
    static const char *const of[] = {"all-probes", "all"};
    const int first = isnan(value_of(report, "leak_volume", of[0]));
    if (!first)
        fprintf(out, "%s%-20s%-28s%s\n", before, "", "  of all probes", "  by what is seen");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (isnan(value_of(report, rows[i].measure, "all"))) {
            fprintf(out, "%s  %-18s  not known: there are probes without light\n", before,
                    rows[i].name);
            continue;
        }
        fprintf(out, "%s  %-18s", before, rows[i].name);
        for (int k = first; k < 2; k++)
            print_column(report, rows[i].measure, of[k], out);
        fprintf(out, "\n");
    }
    fprintf(out, "%s  %-18s", before, "see no probe");
    print_column(report, "lost", "all", out);
    fprintf(out, "\n");
    print_worst(report, "all", before, out);
    print_outside(report, before, out);
}

static void print_leak(const struct report *report, FILE *out)
{
    if (isnan(value_of(report, "cells", "all")))
        return;
    fprintf(out,
            "\nlight from probes that a point cannot see, from %.0f points in the free space of "
            "%.0f cells:\n",
            value_of(report, "leak_points", "all"), value_of(report, "cells", "all"));
    report_print_leaks(report, "", out);
    fprintf(out, "  leaked light, rms %8.3g, in the mean %+.3g\n",
            light(report, "leaked_rms", "all").value, light(report, "leaked_bias", "all").value);
}

static void print_change(const struct report *report, FILE *out)
{
    if (isnan(value_of(report, "change_steps", "all")))
        return;
    fprintf(out, "\nchange of light along %.0f paths, %.0f steps of %.3g, a unit of length:\n",
            value_of(report, "paths", "all"), value_of(report, "change_steps", "all"),
            value_of(report, "step", "all"));
    fprintf(out, "%-15s%9s%9s\n", "", "rms", "most");
    for (int k = 0; k < 2; k++) {
        const char *of = k ? "truth" : "probes";
        fprintf(out, "  %-13s", of);
        print_cell(out, light(report, "change_rms", of).value);
        print_cell(out, light(report, "change_most", of).value);
        fprintf(out, "\n");
    }
    fprintf(out, "  %-13s", "noise");
    print_cell(out, light(report, "change_noise", "truth").value);
    fprintf(out, "\n  %-13s%9s", "beyond truth", "");
    print_cell(out, light(report, "change_excess", "probes").value);
    fprintf(out, "\n");
}

/* A share in percent with its interval. */
static void print_share(const struct report *report, const char *measure, const char *before,
                        FILE *out)
{
    char interval[64];
    const struct estimate e = report_get(report, measure, "all");
    fprintf(out, "%s%.3g %%", before, 100 * e.value);
    if (*interval_text(e, 100, interval))
        fprintf(out, " (%s)", interval);
}

/* The figures that say how good a bake is. */
static void print_headline(const struct report *report, FILE *out)
{
    print_share(report, "error", "error: ", out);
    print_share(report, "bad", "; bad points: ", out);
    fprintf(out, "\n");
    if (!isnan(value_of(report, "error_seen", "all"))) {
        print_share(report, "error_seen", "  of the probes that each point sees: ", out);
        print_share(report, "bad_seen", "; ", out);
        fprintf(out, "\n");
    }
    if (!isnan(value_of(report, "unseen", "all"))) {
        print_share(report, "unseen", "  weight from probes that it does not see: ", out);
        print_share(report, "blind_points", "; blind points: ", out);
        fprintf(out, "\n");
    }
}

static void print_table(const struct report *report, FILE *out)
{
    char interval[64];
    const double mean = value_of(report, "irradiance", "all");
    if (value_of(report, "preview", "all") > 0)
        fprintf(out, "PREVIEW, of light through a cache (--truth-cache): no figure of light below "
                     "is against the truth\n");
    print_headline(report, out);
    fprintf(out, "irradiance in the mean: %.6g%s\n", mean,
            mean > 0 ? "; light below is in % of it"
                     : ": there is no light; light below is as it is");
    fprintf(out, "noise of the truth: %.2g in the mean, %.2g rms\n",
            light(report, "noise_mean", "all").value, light(report, "noise", "all").value);
    const struct estimate rms = light(report, "rms", "all");
    fprintf(out, "rms error: %.4g", rms.value);
    if (*interval_text(rms, 1, interval))
        fprintf(out, " (%s)", interval);
    fprintf(out, ", known to +- %.2g (95 %%, these points); of colours %.4g\n",
            1.96 * light(report, "rms_noise", "all").value,
            light(report, "rms_colour", "all").value);
    const double cut_off = light(report, "cut_off", "all").value,
                 capture = light(report, "capture_noise", "all").value;
    if (!isnan(cut_off))
        fprintf(out, "  cut off by the order of SH: %.3g\n", cut_off);
    if (!isnan(capture))
        fprintf(out, "  noise of the capture: %.3g\n", capture);
    fprintf(out, "\n"
                 "error, that of the probes that are seen, of irradiance, and shares in %% (in "
                 "parentheses: 95 %% for other points)\n");
    fprintf(out, "%-25s%7s%9s%16s%9s%9s%9s%9s%9s%9s%9s%9s%9s%9s%9s\n", "", "points", "error",
            "(error)", "bad", "seen", "rms", "bias", "mean", "95 %", "99 %", "worst", "bright",
            "dark", "unseen");
    for (size_t i = 0; i < report->count; i++)
        if (!strcmp(report->rows[i].measure, "points"))
            print_part(report, report->rows[i].of, out);
    fprintf(out, "worst at %.6g %.6g %.6g\n", value_of(report, "worst_x", "all"),
            value_of(report, "worst_y", "all"), value_of(report, "worst_z", "all"));
    print_leak(report, out);
    print_change(report, out);
}

struct error *report_print(const struct report *report, enum report_format format, FILE *out)
{
    errno = 0;
    if (format == REPORT_TABLE)
        print_table(report, out);
    else if (format == REPORT_TSV)
        print_tsv(report, out);
    else
        print_json(report, out);
    return fflush(out) || ferror(out)
               ? error_system(errno ? errno : EIO, "%s", out == stderr ? "stderr" : "stdout")
               : NULL;
}
