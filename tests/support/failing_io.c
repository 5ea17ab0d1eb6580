/* SPDX-License-Identifier: Apache-2.0 */
/* Makes system calls fail on demand, in a program that is run with this library preloaded.
 *
 *     FAIL_CALL=write FAIL_AFTER=3 FAIL_ERRNO=28 LD_PRELOAD=.../failing_io.so probe-cat ...
 *
 * FAIL_CALL: read, write, close, linkat, rename, or tmpfile (open with O_TMPFILE). FAIL_AFTER: how
 * many of these calls work first (0). FAIL_HOW: "errno", they fail with FAIL_ERRNO (5, EIO);
 * "short", reads and writes move 7 bytes at most; "interrupt", every second one fails with EINTR;
 * "unsupported", they fail with EOPNOTSUPP.
 */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *setting(const char *name, const char *otherwise)
{
    const char *value = getenv(name);
    return value ? value : otherwise;
}

/* The function of this name that the library hides. */
static void hidden(const char *name, void *function)
{
    void *symbol = dlsym(RTLD_NEXT, name);
    memcpy(function, &symbol, sizeof symbol);
}

/* Whether this call is to fail; may make *count smaller. */
static bool fails(const char *call, size_t *count)
{
    static int calls;
    const char *how = setting("FAIL_HOW", "errno");
    if (strcmp(setting("FAIL_CALL", ""), call) || calls++ < atoi(setting("FAIL_AFTER", "0")))
        return false;
    if (!strcmp(how, "short")) {
        *count = *count < 7 ? *count : 7;
        return false;
    }
    errno = !strcmp(how, "interrupt")     ? EINTR
            : !strcmp(how, "unsupported") ? EOPNOTSUPP
                                          : atoi(setting("FAIL_ERRNO", "5"));
    return strcmp(how, "interrupt") || calls % 2;
}

int open(const char *path, int flags, ...)
{
    int (*real)(const char *, int, ...);
    size_t count = 0;
    va_list args;
    va_start(args, flags);
    const mode_t mode = flags & (O_CREAT | __O_TMPFILE) ? va_arg(args, mode_t) : 0;
    va_end(args);
    hidden("open", &real);
    return (flags & O_TMPFILE) == O_TMPFILE && fails("tmpfile", &count) ? -1
                                                                        : real(path, flags, mode);
}

ssize_t read(int fd, void *to, size_t count)
{
    ssize_t (*real)(int, void *, size_t);
    hidden("read", &real);
    return fails("read", &count) ? -1 : real(fd, to, count);
}

ssize_t write(int fd, const void *from, size_t count)
{
    ssize_t (*real)(int, const void *, size_t);
    hidden("write", &real);
    return fails("write", &count) ? -1 : real(fd, from, count);
}

int close(int fd)
{
    int (*real)(int);
    size_t count = 0;
    hidden("close", &real);
    const bool failing = fails("close", &count);
    const int number = errno, status = real(fd);
    errno = failing ? number : errno;
    return failing ? -1 : status;
}

int linkat(int from_directory, const char *from, int to_directory, const char *to, int flags)
{
    int (*real)(int, const char *, int, const char *, int);
    size_t count = 0;
    hidden("linkat", &real);
    return fails("linkat", &count) ? -1 : real(from_directory, from, to_directory, to, flags);
}

int rename(const char *from, const char *to)
{
    int (*real)(const char *, const char *);
    size_t count = 0;
    hidden("rename", &real);
    return fails("rename", &count) ? -1 : real(from, to);
}
