/* Bytes in and out of files: buffering, checksums, and files that appear only when they are
 * whole. */
#include "base/array.h"
#include "base/error.h"
#include "stream/stream_private.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

/* -- checksums ------------------------------------------------------------------------------- */

struct error *checksum_create(void **checksum)
{
    XXH3_state_t *state = XXH3_createState();
    *checksum = state;
    if (!state)
        return error_memory();
    XXH3_64bits_reset(state);
    return NULL;
}

void checksum_destroy(void *checksum)
{
    XXH3_freeState(checksum);
}

void checksum_update(void *checksum, const void *bytes, size_t count)
{
    XXH3_64bits_update(checksum, bytes, count);
}

uint64_t checksum_take(void *checksum)
{
    const uint64_t sum = XXH3_64bits_digest(checksum);
    XXH3_64bits_reset_withSeed(checksum, sum);
    return sum;
}

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

/* -- in -------------------------------------------------------------------------------------- */

struct error *input_open(struct stream_input *in, const char *path)
{
    const bool standard = !strcmp(path, "-");
    *in = (struct stream_input){.fd = standard ? STDIN_FILENO : open_above(path, O_RDONLY)};
    if (in->fd < 0)
        return error_system(errno, "%s", path);
    if (fcntl(in->fd, F_GETFD) < 0)
        return error_new("stdin is closed: there is nothing to read");
    in->name = strdup(standard ? "stdin" : path);
    return in->name ? NULL : error_memory();
}

void input_close(struct stream_input *in)
{
    if (in->fd > STDERR_FILENO) /* reading is over: closing has nothing to say */
        close(in->fd);
    free(in->name);
    free(in->data);
    *in = (struct stream_input){.fd = -1};
}

/* Reads once more, into room for at least one byte. */
static struct error *fill(struct stream_input *in)
{
    if (in->start > 0) {
        memmove(in->data, in->data + in->start, in->end - in->start);
        in->end -= in->start;
        in->start = 0;
    }
    if (in->end == in->capacity) {
        struct error *err = array_reserve(
            &in->data, &in->capacity, in->capacity ? 2 * in->capacity : STREAM_BLOCK_BYTES / 4, 1);
        if (err)
            return err;
    }
    ssize_t got;
    do
        got = read(in->fd, in->data + in->end, in->capacity - in->end);
    while (got < 0 && errno == EINTR);
    if (got < 0)
        return error_system(errno, "%s", in->name);
    in->ended = got == 0;
    in->end += (size_t)got;
    return NULL;
}

struct error *input_peek(struct stream_input *in, size_t count, const unsigned char **bytes,
                         size_t *got)
{
    struct error *err = NULL;
    while (!err && in->end - in->start < count && !in->ended)
        err = fill(in);
    *bytes = in->data + in->start;
    *got = in->end - in->start < count ? in->end - in->start : count;
    return err;
}

void input_consume(struct stream_input *in, size_t count)
{
    in->start += count;
    in->offset += count;
}

struct error *input_line(struct stream_input *in, const char **line, size_t *length, size_t *bytes)
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
        if (available > STREAM_LINE_MOST)
            return error_new("%s:%zu: the line is longer than %d bytes", in->name, in->line + 1,
                             STREAM_LINE_MOST);
        searched = available;
        struct error *err = fill(in);
        if (err)
            return err;
    }
}

/* -- out ------------------------------------------------------------------------------------- */

/* Tries temporary names beside the target until one is free: `take` makes the file, or fails with
 * EEXIST. */
static struct error *take_temporary(struct stream_output *out,
                                    bool (*take)(struct stream_output *out, const char *name))
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

static bool take_created(struct stream_output *out, const char *name)
{
    out->fd = open_above(name, O_WRONLY | O_CREAT | O_EXCL);
    return out->fd >= 0;
}

/* Gives a nameless file its first name. */
static bool take_linked(struct stream_output *out, const char *name)
{
    char descriptor[32];
    snprintf(descriptor, sizeof descriptor, "/proc/self/fd/%d", out->fd);
    return linkat(AT_FDCWD, descriptor, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0;
}

/* A file without a name, so that a killed program leaves nothing, where the system has such; else
 * one with a temporary name. */
static struct error *open_beside(struct stream_output *out)
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

static struct error *open_file(struct stream_output *out, const char *path)
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

struct error *output_open(struct stream_output *out, const char *path, bool binary)
{
    const bool standard = !strcmp(path, "-");
    *out = (struct stream_output){.fd = -1, .name = strdup(standard ? "stdout" : path)};
    struct error *err = out->name ? NULL : error_memory();
    if (!err && !standard)
        err = open_file(out, path);
    if (!err && standard && fcntl(STDOUT_FILENO, F_GETFD) < 0)
        err = error_new("stdout is closed: there is nowhere to write to");
    else if (!err && standard)
        out->fd = STDOUT_FILENO;
    if (!err)
        /* a pipe: fewer turns of who writes and who reads. Others have no such size */
        (void)fcntl(out->fd, F_SETPIPE_SZ, STREAM_BLOCK_BYTES);
    if (!err && binary && isatty(out->fd))
        err = error_new(
            "%s is a terminal, and the stream is binary: give --text, or a file with --output",
            out->name);
    if (err)
        output_abandon(out);
    return err;
}

struct error *output_room(struct stream_output *out, size_t count, char **room)
{
    struct error *err = array_reserve(&out->data, &out->capacity, out->count + count, 1);
    *room = err ? NULL : out->data + out->count;
    return err;
}

static struct error *write_all(const struct stream_output *out, const char *bytes, size_t count)
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

struct error *output_flush(struct stream_output *out, bool always)
{
    if (!always && out->count < STREAM_BLOCK_BYTES)
        return NULL;
    struct error *err = write_all(out, out->data, out->count);
    if (!err)
        out->count = 0;
    return err;
}

struct error *output_write(struct stream_output *out, const void *bytes, size_t count)
{
    struct error *err = output_flush(out, true);
    return err ? err : write_all(out, bytes, count);
}

struct error *output_finish(struct stream_output *out)
{
    struct error *err = output_flush(out, true);
    if (!err && out->target && !out->temporary)
        err = take_temporary(out, take_linked);
    if (!err) {
        const int fd = out->fd;
        out->fd = -1;
        if (close(fd)) /* some file systems tell only now that the disk is full */
            err = error_system(errno, "%s", out->name);
    }
    if (!err && out->target) {
        if (rename(out->temporary, out->target)) {
            err = error_system(errno, "%s", out->name);
        } else {
            free(out->temporary);
            out->temporary = NULL;
        }
    }
    output_abandon(out);
    return err;
}

void output_abandon(struct stream_output *out)
{
    if (out->fd > STDERR_FILENO)
        close(out->fd);
    if (out->temporary)
        unlink(out->temporary);
    free(out->name);
    free(out->target);
    free(out->temporary);
    free(out->data);
    *out = (struct stream_output){.fd = -1};
}
