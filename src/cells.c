#include "cells.h"
#include "error.h"
#include "stream.h"

#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

/* Where probe-tet is: beside this program, or to be found on the PATH. */
static void find_program(char path[PATH_MAX])
{
    char self[PATH_MAX];
    const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    if (length > 0) {
        self[length] = 0;
        if (snprintf(path, PATH_MAX, "%s/probe-tet", dirname(self)) < PATH_MAX && !access(path, X_OK))
            return;
    }
    strcpy(path, "probe-tet");
}

static struct error *run(const char *input, const char *output)
{
    char program[PATH_MAX], name[] = "probe-tet", quiet[] = "--quiet", to[] = "--output";
    find_program(program);
    char *in = strdup(input), *out = strdup(output);
    if (!in || !out) {
        free(in);
        free(out);
        return error_memory();
    }
    char *arguments[] = {name, quiet, to, out, in, NULL};
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

/* A stream of the positions alone: probe-tet needs no more. */
static struct error *write_positions(const struct table *probes, const char *path)
{
    struct stream *stream = NULL;
    struct table *table = NULL;
    struct error *err = stream_create(&stream);
    if (!err)
        err = stream_add_table(stream, "probe", &table);
    if (!err)
        err = table_resize(table, probes->rows);
    if (!err)
        err = table_add_column(table, "position", COLUMN_F64, 3, NULL);
    if (!err) {
        table_copy_rows(table, 0, probes, 0, probes->rows);
        err = stream_write(stream, path, STREAM_BINARY);
    }
    stream_destroy(stream);
    return err;
}

static struct error *take_cells(struct stream *stream, const struct stream *made)
{
    struct table *from = stream_table(made, "tet"), *probes = stream_table(made, "probe"), *to = NULL;
    struct column *normal = NULL;
    if (!from || !probes)
        return error_new("probe-tet wrote no cells");
    struct error *err = table_require(probes, "hull_normal", COLUMN_F32, 3, &normal);
    if (!err)
        err = stream_add_table(stream, "tet", &to);
    if (!err) {
        table_clear(to);
        err = table_copy_schema(to, from);
    }
    if (!err)
        err = table_resize(to, from->rows);
    if (!err) {
        table_copy_rows(to, 0, from, 0, from->rows);
        err = table_add_column(stream_table(stream, "probe"), "hull_normal", COLUMN_F32, 3, NULL);
    }
    if (!err) {
        table_remove_column(probes, "position");
        table_copy_rows(stream_table(stream, "probe"), 0, probes, 0, probes->rows);
    }
    return err;
}

struct error *cells_make(struct stream *stream)
{
    const char *parent = getenv("TMPDIR");
    char directory[PATH_MAX], input[PATH_MAX + 16], output[PATH_MAX + 16];
    snprintf(directory, sizeof directory, "%s/probe-cells-XXXXXX", parent && *parent ? parent : "/tmp");
    if (!mkdtemp(directory))
        return error_system(errno, "%s", directory);
    snprintf(input, sizeof input, "%s/probes", directory);
    snprintf(output, sizeof output, "%s/cells", directory);
    struct stream *made = NULL;
    struct error *err = write_positions(stream_table(stream, "probe"), input);
    if (!err)
        err = run(input, output);
    if (!err)
        err = stream_read(&made, output);
    unlink(input);
    unlink(output);
    rmdir(directory);
    if (!err)
        err = take_cells(stream, made);
    stream_destroy(made);
    return err;
}
