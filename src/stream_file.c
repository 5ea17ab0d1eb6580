/* Bytes in and out of files: buffering, checksums, and files that appear only when they are whole. */
#include "array.h"
#include "error.h"
#include "stream_private.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

static struct error *hash_create(void **hash)
{
    XXH3_state_t *state = XXH3_createState();
    if (!state)
        return error_memory();
    XXH3_64bits_reset(state);
    *hash = state;
    return NULL;
}

/* -- in -------------------------------------------------------------------------------------- */

struct error *input_open(struct stream_input *in, const char *path)
{
    const bool standard = !strcmp(path, "-");
    *in = (struct stream_input){.fd = standard ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC)};
    if (in->fd < 0)
        return error_system(errno, "%s", path);
    in->name = strdup(standard ? "stdin" : path);
    if (!in->name) {
        input_close(in);
        return error_memory();
    }
    return NULL;
}

void input_close(struct stream_input *in)
{
    if (in->fd > STDERR_FILENO) /* reading is over: closing has nothing to say */
        close(in->fd);
    XXH3_freeState(in->hash);
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
        struct error *err =
            array_reserve(&in->data, &in->capacity, in->capacity ? 2 * in->capacity : STREAM_BLOCK_BYTES / 4, 1);
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

struct error *input_peek(struct stream_input *in, size_t count, const unsigned char **bytes, size_t *got)
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
        const unsigned char *newline = available > searched ? memchr(begin + searched, '\n', available - searched) : NULL;
        if (newline || (in->ended && available)) {
            *line = (const char *)begin;
            *length = newline ? (size_t)(newline - begin) : available;
            *bytes = newline ? *length + 1 : available;
            return NULL;
        }
        if (in->ended)
            return NULL;
        if (available > STREAM_LINE_MOST)
            return error_new("%s:%zu: the line is longer than %d bytes", in->name, in->line + 1, STREAM_LINE_MOST);
        searched = available;
        struct error *err = fill(in);
        if (err)
            return err;
    }
}

struct error *input_hash_start(struct stream_input *in)
{
    return hash_create(&in->hash);
}

void input_hash_update(struct stream_input *in, const void *bytes, size_t count)
{
    XXH3_64bits_update(in->hash, bytes, count);
}

uint64_t input_hash(const struct stream_input *in)
{
    return XXH3_64bits_digest(in->hash);
}

/* -- out ------------------------------------------------------------------------------------- */

/* "DIRECTORY/.NAME.XXXXXX" beside the target. */
static char *temporary_name(const char *target)
{
    const char *slash = strrchr(target, '/');
    const int directory = slash ? (int)(slash + 1 - target) : 0;
    char *name = NULL;
    if (asprintf(&name, "%.*s.%s.XXXXXX", directory, target, target + directory) < 0)
        return NULL;
    return name;
}

/* A file without a name, where the file system has such; else one with a temporary name. */
static struct error *open_beside(struct stream_output *out, mode_t mode)
{
    char *directory = strdup(out->target);
    if (!directory)
        return error_memory();
    char *slash = strrchr(directory, '/');
    if (slash)
        slash[slash == directory] = 0;
    out->fd = open(slash ? directory : ".", O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    free(directory);
    if (out->fd < 0 && errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL)
        return error_system(errno, "%s", out->name);
    if (out->fd < 0) {
        out->temporary = temporary_name(out->target);
        if (!out->temporary)
            return error_memory();
        out->fd = mkostemp(out->temporary, O_CLOEXEC);
        if (out->fd < 0) {
            const int number = errno;
            free(out->temporary);
            out->temporary = NULL;
            return error_system(number, "%s", out->name);
        }
        if (!mode) {
            const mode_t mask = umask(0);
            umask(mask);
            mode = 0666 & ~mask;
        }
    }
    if (mode && fchmod(out->fd, mode))
        return error_system(errno, "%s", out->name);
    return NULL;
}

static struct error *open_file(struct stream_output *out, const char *path)
{
    struct stat status;
    if (stat(path, &status) == 0) {
        if (!S_ISREG(status.st_mode)) { /* a pipe, a device: nothing to rename */
            out->fd = open(path, O_WRONLY | O_CLOEXEC);
            return out->fd < 0 ? error_system(errno, "%s", path) : NULL;
        }
        if (access(path, W_OK))
            return error_system(errno, "%s", path);
        out->target = realpath(path, NULL); /* through links, so that they stay */
        return out->target ? open_beside(out, status.st_mode & 07777) : error_system(errno, "%s", path);
    }
    if (errno != ENOENT)
        return error_system(errno, "%s", path);
    out->target = strdup(path);
    return out->target ? open_beside(out, 0) : error_memory();
}

struct error *output_open(struct stream_output *out, const char *path, bool binary)
{
    const bool standard = !strcmp(path, "-");
    struct stat status;
    *out = (struct stream_output){.fd = -1, .name = strdup(standard ? "stdout" : path)};
    struct error *err = out->name ? NULL : error_memory();
    if (!err && !standard)
        err = open_file(out, path);
    if (!err && standard) {
        out->fd = STDOUT_FILENO;
        if (fstat(out->fd, &status))
            err = error_system(errno, "stdout");
    }
    if (!err && binary && isatty(out->fd))
        err = error_new("%s is a terminal, and the stream is binary: give --text, or a file with --output", out->name);
    if (!err && binary)
        err = hash_create(&out->hash);
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

void output_hash_update(struct stream_output *out, size_t from)
{
    XXH3_64bits_update(out->hash, out->data + from, out->count - from);
}

uint64_t output_hash(const struct stream_output *out)
{
    return XXH3_64bits_digest(out->hash);
}

struct error *output_flush(struct stream_output *out, bool always)
{
    if (!always && out->count < STREAM_BLOCK_BYTES)
        return NULL;
    for (size_t done = 0; done < out->count;) {
        const ssize_t put = write(out->fd, out->data + done, out->count - done);
        if (put < 0 && errno != EINTR)
            return error_system(errno, "%s", out->name);
        if (put > 0)
            done += (size_t)put;
    }
    out->count = 0;
    return NULL;
}

/* Gives a nameless file a temporary name, of a random kind that is still free. */
static struct error *link_temporary(struct stream_output *out)
{
    char descriptor[32];
    snprintf(descriptor, sizeof descriptor, "/proc/self/fd/%d", out->fd);
    for (int attempt = 0; attempt < 100; attempt++) {
        char *name = temporary_name(out->target);
        if (!name)
            return error_memory();
        const int fd = mkstemp(name); /* finds a free name */
        if (fd >= 0) {
            close(fd);
            unlink(name);
            if (linkat(AT_FDCWD, descriptor, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0) {
                out->temporary = name;
                return NULL;
            }
        }
        const int number = errno;
        free(name);
        if (number != EEXIST)
            return error_system(number, "%s", out->name);
    }
    return error_new("%s: no free temporary name beside it", out->name);
}

struct error *output_finish(struct stream_output *out)
{
    struct error *err = output_flush(out, true);
    if (!err && out->target && !out->temporary)
        err = link_temporary(out);
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
    XXH3_freeState(out->hash);
    free(out->name);
    free(out->target);
    free(out->temporary);
    free(out->data);
    *out = (struct stream_output){.fd = -1};
}
