/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/cells_make.h"
#include "base/error.h"
#include "base/sibling.h"
#include "stream/cells.h"
#include "stream/stream.h"

#include <errno.h>
#include <limits.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

static struct error *run(const char *input, const char *output, bool full)
{
    char program[PATH_MAX], name[] = "probe-tet", quiet[] = "--quiet", to[] = "--output",
                            never_thin[] = "--thin=0";
    sibling_find("tet", program);
    char *in = strdup(input), *out = strdup(output);
    if (!in || !out) {
        free(in);
        free(out);
        return error_memory();
    }
    char *arguments[] = {name, quiet, to, out, in, full ? never_thin : NULL, NULL};
    pid_t pid;
    int status = 0;
    const int number = posix_spawnp(&pid, program, NULL, NULL, arguments, environ);
    struct error *err = number ? error_system(number, "%s", program) : NULL;
    while (!err && waitpid(pid, &status, 0) < 0)
        if (errno != EINTR)
            err = error_system(errno, "waiting for probe-tet");
    if (!err && WIFSIGNALED(status))
        err = error_new("probe-tet died: %s", strsignal(WTERMSIG(status)));
    else if (!err && WEXITSTATUS(status))
        err = error_new("probe-tet failed with status %d", WEXITSTATUS(status));
    free(in);
    free(out);
    return err;
}

/* A stream of the positions, and of the light that tells which of merged probes represents the
 * others: probe-tet needs no more. */
static struct error *write_positions(const struct table *probes, const char *path)
{
    struct stream *stream = NULL;
    struct table *table = NULL;
    const struct column *sh = table_column(probes, "sh");
    struct error *err = stream_create(&stream);
    if (!err)
        err = stream_add_table(stream, "probe", &table);
    if (!err)
        err = table_resize(table, probes->rows);
    if (!err)
        err = table_add_column(table, "position", COLUMN_F64, 3, NULL);
    if (!err && sh)
        err = table_add_column(table, "sh", sh->type, sh->width, NULL);
    if (!err) {
        table_copy_rows(table, 0, probes, 0, probes->rows);
        err = stream_write(stream, path, STREAM_BINARY);
    }
    stream_destroy(stream);
    return err;
}

struct error *cells_copy(struct stream *to, const struct stream *from)
{
    static const char *const of_probes[] = {"hull_normal", "merged"};
    const struct table *probes = stream_table(from, "probe");
    struct cells cells;
    struct table *table = NULL;
    struct error *err = cells_find(from, &cells);
    cells_remove(to);
    if (!err)
        err = stream_add_table(to, cells.table->name, &table);
    for (size_t i = 0; !err && i < cells.table->column_count; i++) {
        const struct column *c = &cells.table->columns[i];
        err = table_add_column(table, c->name, c->type, c->width, NULL);
    }
    if (!err)
        err = table_resize(table, cells.table->rows);
    if (!err)
        table_copy_rows(table, 0, cells.table, 0, cells.table->rows);
    for (size_t i = 0; !err && i < sizeof of_probes / sizeof *of_probes; i++) {
        const struct column *theirs = table_column(probes, of_probes[i]);
        struct column *ours = NULL;
        if (!theirs)
            continue;
        err = table_add_column(stream_table(to, "probe"), theirs->name, theirs->type, theirs->width,
                               &ours);
        if (!err)
            memcpy(ours->data, theirs->data,
                   probes->rows * theirs->width * column_type_size(theirs->type));
    }
    return err;
}

struct error *cells_make(struct stream *stream, bool full)
{
    const char *parent = getenv("TMPDIR");
    char directory[PATH_MAX], input[PATH_MAX + 16], output[PATH_MAX + 16];
    snprintf(directory, sizeof directory, "%s/probe-cells-XXXXXX",
             parent && *parent ? parent : "/tmp");
    if (!mkdtemp(directory))
        return error_system(errno, "%s", directory);
    snprintf(input, sizeof input, "%s/probes", directory);
    snprintf(output, sizeof output, "%s/cells", directory);
    struct stream *made = NULL;
    struct error *err = write_positions(stream_table(stream, "probe"), input);
    if (!err)
        err = run(input, output, full);
    if (!err)
        err = stream_read(&made, output);
    unlink(input);
    unlink(output);
    rmdir(directory);
    if (!err)
        err = cells_copy(stream, made);
    stream_destroy(made);
    return err;
}
