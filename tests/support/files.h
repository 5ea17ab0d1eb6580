/* SPDX-License-Identifier: Apache-2.0 */
/* files: a directory of a test's own, in which it writes the files that it reads.
 *
 *     files_begin();
 *     files_write("a.obj", "v 0 0 0\n");
 *     ... files_path("a.obj") ...
 *     files_end();
 */
#ifndef FILES_H
#define FILES_H

#include <ftw.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char files_directory[PATH_MAX];

/* The path of a file in the directory; good until the eighth call after this one. */
__attribute__((unused)) static const char *files_path(const char *name)
{
    static char paths[8][PATH_MAX + 256];
    static int turn;
    turn = (turn + 1) % 8;
    snprintf(paths[turn], sizeof paths[turn], "%s/%s", files_directory, name);
    return paths[turn];
}

__attribute__((unused)) static void files_begin(void)
{
    const char *parent = getenv("TMPDIR");
    snprintf(files_directory, sizeof files_directory, "%s/probe-test.XXXXXX",
             parent && *parent ? parent : "/tmp");
    if (!mkdtemp(files_directory)) {
        perror(files_directory);
        exit(1);
    }
}

__attribute__((unused)) static void files_write_bytes(const char *name, const void *data,
                                                      size_t size)
{
    FILE *file = fopen(files_path(name), "wb");
    if (!file || (size && fwrite(data, 1, size, file) != size) || fclose(file)) {
        perror(name);
        exit(1);
    }
}

__attribute__((unused)) static void files_write(const char *name, const char *text)
{
    files_write_bytes(name, text, strlen(text));
}

__attribute__((unused)) static void files_make_directory(const char *name)
{
    if (mkdir(files_path(name), 0777)) {
        perror(name);
        exit(1);
    }
}

static int files_remove_one(const char *path, const struct stat *status, int flag, struct FTW *walk)
{
    (void)status;
    (void)flag;
    (void)walk;
    return remove(path);
}

__attribute__((unused)) static void files_end(void)
{
    nftw(files_directory, files_remove_one, 16, FTW_DEPTH | FTW_PHYS);
}

#endif
