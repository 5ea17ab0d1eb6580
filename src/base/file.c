/* SPDX-License-Identifier: Apache-2.0 */
#include "base/file.h"
#include "base/array.h"
#include "base/claim.h"
#include "base/error.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

/* Opens, above the standard descriptors: where one of these is closed, a file must not take its
 * place. */
static int open_above(const char *path, int flags)
{
    const int fd = open(path, flags | O_CLOEXEC, 0666);
    if (fd < 0 || fd > STDERR_FILENO)
        return fd;
    const int above = fcntl(fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1), number = errno;
    close(fd);
    errno = number;
    return above;
}

static ssize_t read_some(int fd, void *bytes, size_t most)
{
    ssize_t got;
    do
        got = read(fd, bytes, most);
    while (got < 0 && errno == EINTR);
    return got;
}

/* Appends all that is left to *data, and a zero byte behind it; frees it on error. */
static struct error *read_rest(int fd, char **data, size_t *size, size_t capacity)
{
    struct stat status;
    const bool known = fstat(fd, &status) == 0 && S_ISREG(status.st_mode) && status.st_size >= 0;
    struct error *err =
        array_reserve(data, &capacity, *size + 2 + (known ? (size_t)status.st_size : 65536), 1);
    for (ssize_t got = 1; !err && got;) {
        if (*size + 1 == capacity)
            err = array_reserve(data, &capacity, 2 * capacity, 1);
        got = err ? 0 : read_some(fd, *data + *size, capacity - 1 - *size);
        if (got < 0)
            err = error_new("%s", strerror(errno));
        else
            *size += (size_t)got;
    }
    if (err) {
        free(*data);
        *data = NULL;
        *size = 0;
    } else {
        (*data)[*size] = 0;
    }
    return err;
}

struct error *file_read(const char *path, char **data, size_t *size)
{
    *data = NULL;
    *size = 0;
    const int fd = open_above(path, O_RDONLY);
    if (fd < 0)
        return error_new("%s", strerror(errno));
    struct error *err = claim_input(fd);
    if (!err)
        err = read_rest(fd, data, size, 0);
    close(fd);
    return err;
}

struct error *file_make_room(size_t files)
{
    enum { OTHERS = 32 }; /* that are open or may be */
    struct rlimit limit;
    const rlim_t wanted = (rlim_t)files + OTHERS;
    if (getrlimit(RLIMIT_NOFILE, &limit) || limit.rlim_cur >= wanted)
        return NULL;
    if (limit.rlim_max < wanted)
        return error_new("%zu files at once are more than may be open: expected at most %zu "
                         "(ulimit -Hn)",
                         files, (size_t)(limit.rlim_max > OTHERS ? limit.rlim_max - OTHERS : 0));
    limit.rlim_cur = wanted;
    return setrlimit(RLIMIT_NOFILE, &limit) ? error_system(errno, "open files") : NULL;
}

/* -- in -------------------------------------------------------------------------------------- */

bool file_is_small(const char *path, size_t bytes)
{
    struct stat status;
    const bool known = strcmp(path, "-") ? !stat(path, &status) : !fstat(STDIN_FILENO, &status);
    return known && ((S_ISREG(status.st_mode) && (uintmax_t)status.st_size < bytes) ||
                     S_ISCHR(status.st_mode));
}

const char *file_input_name(const char *path)
{
    return strcmp(path, "-") ? path : "stdin";
}

static bool is_standard_input(const char *path)
{
    static const char *const names[] = {"-", "/dev/stdin", "/dev/fd/0", "/proc/self/fd/0"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (!strcmp(path, names[i]))
            return true;
    return false;
}

struct error *file_inputs_differ(const char *a, const char *a_is, const char *b, const char *b_is)
{
    if (!is_standard_input(a) || !is_standard_input(b))
        return NULL;
    return error_usage("%s and %s cannot both come from standard input", a_is, b_is);
}

struct error *file_check_again(const char *path, const char *what)
{
    struct stat status;
    if (is_standard_input(path))
        return error_usage("%s cannot be standard input: it is read more than once", what);
    if (stat(path, &status) || S_ISREG(status.st_mode) || S_ISDIR(status.st_mode))
        return NULL;
    return error_usage("%s: %s: expected a file, as it is read more than once, got a pipe or a "
                       "device",
                       what, path);
}

struct error *file_read_input(const char *path, char **data, size_t *size)
{
    if (strcmp(path, "-"))
        return file_read(path, data, size);
    *data = NULL;
    *size = 0;
    if (fcntl(STDIN_FILENO, F_GETFD) < 0)
        return error_new("it is closed: there is nothing to read");
    struct error *err = claim_input(STDIN_FILENO);
    return err ? err : read_rest(STDIN_FILENO, data, size, 0);
}

struct error *file_input_open(struct file_input *in, const char *path)
{
    const bool standard = !strcmp(path, "-");
    *in = (struct file_input){.fd = standard ? STDIN_FILENO : open_above(path, O_RDONLY)};
    struct error *err = NULL;
    if (in->fd < 0)
        err = error_system(errno, "%s", path);
    else if (fcntl(in->fd, F_GETFD) < 0)
        err = error_new("stdin is closed: there is nothing to read");
    else if (!(in->name = strdup(file_input_name(path))))
        err = error_memory();
    if (!err)
        err = error_wrap(claim_input(in->fd), "%s", in->name);
    if (err)
        file_input_close(in);
    return err;
}

void file_input_close(struct file_input *in)
{
    if (in->fd > STDERR_FILENO) /* reading is over: closing has nothing to say */
        close(in->fd);
    free(in->name);
    free(in->data);
    *in = (struct file_input){.fd = -1};
}

struct error *file_input_read(struct file_input *in, void *bytes, size_t most, size_t *got)
{
    const ssize_t count = read_some(in->fd, bytes, most);
    *got = count > 0 ? (size_t)count : 0;
    if (count < 0)
        return error_system(errno, "%s", in->name);
    in->ended = count == 0;
    return NULL;
}

/* Reads once more, into room for at least one byte. */
static struct error *fill(struct file_input *in)
{
    if (in->start > 0) {
        memmove(in->data, in->data + in->start, in->end - in->start);
        in->end -= in->start;
        in->start = 0;
    }
    if (in->end == in->capacity) {
        struct error *err = array_reserve(
            &in->data, &in->capacity, in->capacity ? 2 * in->capacity : FILE_BLOCK_BYTES / 4, 1);
        if (err)
            return err;
    }
    size_t got;
    struct error *err = file_input_read(in, in->data + in->end, in->capacity - in->end, &got);
    in->end += got;
    return err;
}

struct error *file_input_peek(struct file_input *in, size_t count, const unsigned char **bytes,
                              size_t *got)
{
    struct error *err = NULL;
    while (!err && in->end - in->start < count && !in->ended)
        err = fill(in);
    *bytes = in->data + in->start;
    *got = in->end - in->start < count ? in->end - in->start : count;
    return err;
}

void file_input_consume(struct file_input *in, size_t count)
{
    in->start += count;
    in->offset += count;
}

struct error *file_input_line(struct file_input *in, const char **line, size_t *length,
                              size_t *bytes)
{
    size_t searched = 0;
    *line = NULL;
    *length = *bytes = 0;
    for (;;) {
        const size_t available = in->end - in->start;
        const unsigned char *begin = in->data + in->start;
        const unsigned char *newline =
            available > searched ? memchr(begin + searched, '\n', available - searched) : NULL;
        if (newline || (in->ended && available)) {
            *line = (const char *)begin;
            *length = newline ? (size_t)(newline - begin) : available;
            *bytes = newline ? *length + 1 : available;
            return NULL;
        }
        if (in->ended)
            return NULL;
        if (available > FILE_LINE_MOST)
            return error_new("%s:%zu: the line is longer than %d bytes", in->name, in->line + 1,
                             FILE_LINE_MOST);
        searched = available;
        struct error *err = fill(in);
        if (err)
            return err;
    }
}

struct error *file_input_rest(struct file_input *in, char **data, size_t *size)
{
    size_t capacity = 0;
    *data = NULL;
    *size = in->end - in->start;
    struct error *err = array_reserve(data, &capacity, *size, 1);
    if (err)
        return err;
    if (*size)
        memcpy(*data, in->data + in->start, *size);
    file_input_consume(in, *size);
    return error_wrap(read_rest(in->fd, data, size, capacity), "%s", in->name);
}

/* -- out ------------------------------------------------------------------------------------- */

const char *file_output_name(const char *path)
{
    return strcmp(path, "-") ? path : "stdout";
}

/* Tries temporary names beside the target until one is free: `take` makes the file, or fails with
 * EEXIST. */
static struct error *take_temporary(struct file_output *out,
                                    bool (*take)(struct file_output *out, const char *name))
{
    const char *slash = strrchr(out->target, '/');
    const int directory = slash ? (int)(slash + 1 - out->target) : 0;
    for (int attempt = 0; attempt < 1000; attempt++) {
        char *name = NULL;
        if (asprintf(&name, "%.*s.probe-%ld-%d", directory, out->target, (long)getpid(), attempt) <
            0)
            return error_memory();
        if (take(out, name)) {
            out->temporary = name;
            return NULL;
        }
        const int number = errno;
        free(name);
        if (number != EEXIST)
            return error_system(number, "%s", out->name);
    }
    return error_new("%s: no free temporary name beside it", out->name);
}

static bool take_created(struct file_output *out, const char *name)
{
    out->fd = open_above(name, O_WRONLY | O_CREAT | O_EXCL);
    return out->fd >= 0;
}

/* Gives a nameless file its first name. */
static bool take_linked(struct file_output *out, const char *name)
{
    char descriptor[32];
    snprintf(descriptor, sizeof descriptor, "/proc/self/fd/%d", out->fd);
    return linkat(AT_FDCWD, descriptor, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0;
}

/* A file without a name, so that a killed program leaves nothing, where the system has such; else
 * one with a temporary name. */
static struct error *open_beside(struct file_output *out)
{
    char *directory = strdup(out->target);
    if (!directory)
        return error_memory();
    char *slash = strrchr(directory, '/');
    if (slash)
        slash[slash == directory] = 0;
    const bool nameable = !access("/proc/self/fd", X_OK);
    out->fd = nameable ? open_above(slash ? directory : ".", O_TMPFILE | O_WRONLY) : -1;
    const int number = nameable ? errno : EOPNOTSUPP;
    free(directory);
    if (out->fd >= 0)
        return NULL;
    if (number != EOPNOTSUPP && number != EISDIR && number != EINVAL)
        return error_system(number, "%s", out->name);
    return take_temporary(out, take_created);
}

static struct error *open_file(struct file_output *out, const char *path)
{
    struct stat status;
    const bool exists = stat(path, &status) == 0;
    if (!exists && errno != ENOENT)
        return error_system(errno, "%s", path);
    if (exists && !S_ISREG(status.st_mode)) { /* a pipe, a device: nothing to rename */
        out->fd = open_above(path, O_WRONLY);
        return out->fd < 0 ? error_system(errno, "%s", path) : NULL;
    }
    if (exists && access(path, W_OK))
        return error_system(errno, "%s", path);
    /* through links, so that they stay */
    out->target = exists ? realpath(path, NULL) : strdup(path);
    struct error *err = out->target ? open_beside(out) : error_memory();
    if (!err && exists && fchmod(out->fd, status.st_mode & 07777))
        err = error_system(errno, "%s", path);
    return err;
}

struct error *file_output_open(struct file_output *out, const char *path, bool binary)
{
    const bool standard = !strcmp(path, "-");
    *out = (struct file_output){.fd = -1, .name = strdup(file_output_name(path))};
    struct error *err = out->name ? NULL : error_memory();
    if (!err)
        err = claim_output(path, NULL);
    if (!err && !standard)
        err = open_file(out, path);
    if (!err && standard && fcntl(STDOUT_FILENO, F_GETFD) < 0)
        err = error_new("stdout is closed: there is nowhere to write to");
    else if (!err && standard)
        out->fd = STDOUT_FILENO;
    if (!err)
        /* a pipe: fewer turns of who writes and who reads. Others have no such size */
        (void)fcntl(out->fd, F_SETPIPE_SZ, FILE_BLOCK_BYTES);
    if (!err && binary && isatty(out->fd))
        err = error_new(
            "%s is a terminal, and the stream is binary: give --text, or a file with --output",
            out->name);
    if (err)
        file_output_abandon(out);
    return err;
}

struct error *file_output_room(struct file_output *out, size_t count, char **room)
{
    struct error *err = array_reserve(&out->data, &out->capacity, out->count + count, 1);
    *room = err ? NULL : out->data + out->count;
    return err;
}

static struct error *write_all(const struct file_output *out, const char *bytes, size_t count)
{
    for (size_t done = 0; done < count;) {
        const ssize_t put = write(out->fd, bytes + done, count - done);
        if (put < 0 && errno != EINTR)
            return error_system(errno, "%s", out->name);
        if (put > 0)
            done += (size_t)put;
    }
    return NULL;
}

struct error *file_output_flush(struct file_output *out, bool always)
{
    if (!always && out->count < FILE_BLOCK_BYTES)
        return NULL;
    struct error *err = write_all(out, out->data, out->count);
    if (!err)
        out->count = 0;
    return err;
}

struct error *file_output_write(struct file_output *out, const void *bytes, size_t count)
{
    struct error *err = file_output_flush(out, true);
    return err ? err : write_all(out, bytes, count);
}

struct error *file_output_finish(struct file_output *out)
{
    struct error *err = file_output_flush(out, true);
    if (!err && out->target && !out->temporary)
        err = take_temporary(out, take_linked);
    if (!err) {
        const int fd = out->fd;
        out->fd = -1;
        if (close(fd)) /* some file systems tell only now that the disk is full */
            err = error_system(errno, "%s", out->name);
    }
    if (!err && out->target) {
        claim_end(out->target);
        if (rename(out->temporary, out->target)) {
            err = error_system(errno, "%s", out->name);
        } else {
            free(out->temporary);
            out->temporary = NULL;
        }
    }
    file_output_abandon(out);
    return err;
}

void file_output_abandon(struct file_output *out)
{
    if (out->fd > STDERR_FILENO)
        close(out->fd);
    if (out->temporary)
        unlink(out->temporary);
    free(out->name);
    free(out->target);
    free(out->temporary);
    free(out->data);
    *out = (struct file_output){.fd = -1};
}
