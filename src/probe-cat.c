/* probe-cat: converts, merges, selects and describes probe streams. */
#include "error.h"
#include "options.h"
#include "stream.h"
#include "stream_edit.h"
#include "warning.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* "FIRST:END" or "FIRST:END:STEP", each may be left out; or one row's number. */
static struct error *parse_rows(void *value, const char *text)
{
    struct stream_selection *s = value;
    int64_t number[3] = {0, -1, 1};
    int parts = 1;
    const char *at = text;
    for (; parts <= 3; parts++) {
        char *end = NULL;
        errno = 0;
        const long long x = strtoll(at, &end, 10);
        if (end != at && (*at < '0' || *at > '9' || errno || x > INT32_MAX))
            break;
        if (end != at)
            number[parts - 1] = x;
        if (!*end)
            break;
        if (*end != ':' || parts == 3)
            return error_usage("expected FIRST:END or FIRST:END:STEP, got '%s'", text);
        at = end + 1;
    }
    if (!*text || strspn(text, "0123456789:") != strlen(text) || number[2] < 1)
        return error_usage("expected FIRST:END or FIRST:END:STEP, got '%s'", text);
    *s = (struct stream_selection){.tables = s->tables, .columns = s->columns, .drop = s->drop, .captured = s->captured,
                                   .rows_given = true, .first = number[0],
                                   .end = parts == 1 ? number[0] + 1 : number[1], .step = number[2]};
    return NULL;
}

static struct error *describe(const char *path)
{
    struct stream_reader *reader = NULL;
    struct error *err = stream_reader_open(&reader, path);
    if (!err)
        err = stream_describe(reader, stdout);
    stream_reader_close(reader);
    if (!err && (fflush(stdout) || ferror(stdout)))
        err = error_system(errno, "stdout");
    return err;
}

static enum stream_encoding encoding_for(const struct common *common, enum stream_encoding read)
{
    return common->encoding == STREAM_AS_READ ? read : (enum stream_encoding)common->encoding;
}

static struct error *change_provenance(struct stream_header *header, bool drop, const char *recorded)
{
    if (!drop)
        return header_add_provenance(header, recorded);
    for (size_t i = 0; i < header->provenance_count; i++)
        free(header->provenance[i]);
    header->provenance_count = 0;
    return NULL;
}

/* One stream whose rows all pass: block by block. */
static struct error *pass(const char *path, const struct stream_selection *s, const struct common *common, bool no_provenance,
                          const char *recorded)
{
    struct stream_reader *reader = NULL;
    struct stream_writer *writer = NULL;
    struct stream_header header = {0};
    struct error *err = stream_reader_open(&reader, path);
    if (!err)
        err = header_copy(&header, stream_reader_header(reader));
    if (!err)
        err = change_provenance(&header, no_provenance, recorded);
    if (!err)
        err = stream_writer_open(&writer, common->output, encoding_for(common, stream_reader_encoding(reader)), &header);
    if (!err)
        err = stream_filter(reader, writer, s);
    if (!err)
        err = stream_writer_finish(writer);
    else
        stream_writer_abandon(writer);
    header_clear(&header);
    stream_reader_close(reader);
    return err;
}

/* Streams that are merged, or whose rows are chosen: in memory. */
static struct error *gather(const char **paths, int count, const struct stream_selection *s, const struct common *common,
                            bool no_provenance, const char *recorded, struct warnings *warnings)
{
    struct stream *all = NULL;
    struct error *err = NULL;
    for (int i = 0; i < count && !err; i++) {
        struct stream *one = NULL;
        err = stream_read(&one, paths[i]);
        if (!err && all)
            err = error_wrap(stream_merge(all, one, warnings), "%s", paths[i]);
        if (!all)
            all = one;
        else
            stream_destroy(one);
    }
    if (!err)
        err = stream_select(all, s, warnings);
    if (!err)
        err = change_provenance(&all->header, no_provenance, recorded);
    if (!err)
        err = stream_write(all, common->output, encoding_for(common, all->encoding));
    stream_destroy(all);
    return err;
}

int main(int argc, char **argv)
{
    struct stream_selection s = {.step = 1, .end = -1};
    bool info = false, no_provenance = false;
    int captured = ROWS_ANY;
    const struct option_row rows[] = {
        {.name = "info", .letter = 'i', .kind = OPTION_FLAG, .value = &info,
         .help = "print what the streams hold instead: tables, columns, ranges, history"},
        {.name = "tables", .argument = "LIST", .kind = OPTION_TEXT, .value = &s.tables, .help = "keep these tables alone (probe, tet)"},
        {.name = "columns", .argument = "LIST", .kind = OPTION_TEXT, .value = &s.columns, .help = "keep these columns alone"},
        {.name = "drop", .argument = "LIST", .kind = OPTION_TEXT, .value = &s.drop, .help = "drop these columns"},
        {.name = "rows", .argument = "FIRST:END[:STEP]", .kind = OPTION_CALL, .value = &s, .parse = parse_rows, .shown = "all",
         .help = "keep these probes, counted from 0, END not included"},
        {.name = "captured", .kind = OPTION_SET, .count = ROWS_CAPTURED, .value = &captured, .help = "keep the probes that have light"},
        {.name = "uncaptured", .kind = OPTION_SET, .count = ROWS_UNCAPTURED, .value = &captured,
         .help = "keep the probes that have no light yet"},
        {.name = "no-provenance", .kind = OPTION_FLAG, .value = &no_provenance, .help = "leave out the command lines that made the stream"},
        {0}};
    struct common common = common_default();
    struct option_row shared[COMMON_ROWS];
    struct program program = {
        .name = "probe-cat",
        .usage = "[OPTION]... [STREAM]...",
        .summary = "Converts probe streams between text and binary, merges several into one, selects tables,\n"
                   "columns and probes, or describes them. Without STREAM reads standard input.",
        .groups = {rows, common_rows(&common, COMMON_STREAM, shared)},
        .operands_most = -1};
    struct warnings warnings = {0};
    struct error *err = options_parse(&program, argc, argv);
    s.captured = captured == ROWS_CAPTURED ? ROWS_CAPTURED : captured == ROWS_UNCAPTURED ? ROWS_UNCAPTURED : ROWS_ANY;
    static const char *standard[] = {"-"};
    const char **paths = program.operand_count ? program.operands : standard;
    const int count = program.operand_count ? program.operand_count : 1;
    if (!err && info) {
        for (int i = 0; i < count && !err; i++) {
            if (count > 1)
                printf("%s%s:\n", i ? "\n" : "", paths[i]);
            err = describe(paths[i]);
        }
    } else if (!err && count == 1 && !s.rows_given && s.captured == ROWS_ANY) {
        err = pass(paths[0], &s, &common, no_provenance, program.recorded);
    } else if (!err) {
        err = gather(paths, count, &s, &common, no_provenance, program.recorded, &warnings);
    }
    if (!common.quiet)
        warnings_print(&warnings, program.name);
    warnings_clear(&warnings);
    program_clear(&program);
    return error_exit(program.name, err);
}
