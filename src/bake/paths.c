/* SPDX-License-Identifier: Apache-2.0 */
#include "bake/paths.h"
#include "base/claim.h"
#include "base/error.h"

#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static struct error *join(char **path, const char *folder, const char *name)
{
    if (asprintf(path, "%s/%s", folder, name) >= 0)
        return NULL;
    *path = NULL;
    return error_memory();
}

/* OUT.report, without .probe: where the report goes if nobody says. */
static struct error *name_report(const char *output, char **path)
{
    static const char usual[] = ".probe";
    const size_t length = strlen(output), ending = sizeof usual - 1;
    const bool cut = length > ending && !strcmp(output + length - ending, usual) &&
                     output[length - ending - 1] != '/';
    if (asprintf(path, "%.*s.report", (int)(cut ? length - ending : length), output) >= 0)
        return NULL;
    *path = NULL;
    return error_memory();
}

static struct error *name_in_report(struct bake_paths *paths, const char *path)
{
    paths->report = strdup(path);
    if (!paths->report)
        return error_memory();
    struct error *err = join(&paths->text, path, "report.txt");
    if (!err)
        err = join(&paths->pair, path, "light.png");
    if (!err)
        err = join(&paths->probes, path, "probes.png");
    const char *const written[] = {path, paths->text, paths->pair, paths->probes};
    for (size_t i = 0; i < sizeof written / sizeof *written && !err; i++)
        err = claim_output(written[i], "report");
    return err;
}

struct error *bake_paths_report(struct bake_paths *paths, const char *report, const char *output)
{
    char *path = NULL;
    struct error *err = NULL;
    if (report)
        return strcmp(report, "none") ? name_in_report(paths, report) : NULL;
    if (output)
        err = name_report(output, &path);
    if (!err && path)
        err = name_in_report(paths, path);
    free(path);
    return err;
}

struct error *bake_paths_make(struct bake_paths *paths)
{
    const char *parent = getenv("TMPDIR");
    char *d = paths->directory;
    if (paths->report) {
        struct stat status;
        paths->report_made = !mkdir(paths->report, 0777);
        if (!paths->report_made && (errno != EEXIST || access(paths->report, W_OK)))
            return error_system(errno, "%s", paths->report);
        if (stat(paths->report, &status) || !S_ISDIR(status.st_mode))
            return error_system(ENOTDIR, "%s", paths->report);
    }
    snprintf(d, sizeof paths->directory, "%s/probe-bake-XXXXXX",
             parent && *parent ? parent : "/tmp");
    if (!mkdtemp(d)) {
        struct error *err = error_system(errno, "%s", d);
        *d = 0;
        return err;
    }
    snprintf(paths->baked, sizeof paths->baked, "%s/baked.probe", d);
    snprintf(paths->figures, sizeof paths->figures, "%s/figures", d);
    snprintf(paths->packed, sizeof paths->packed, "%s/packed", d);
    /* what the stages put aside goes with it, even if they are killed */
    return setenv("TMPDIR", d, 1) ? error_memory() : NULL;
}

void bake_paths_forget(const struct bake_paths *paths)
{
    const char *const of_report[] = {paths->text, paths->pair, paths->probes};
    for (size_t i = 0; i < sizeof of_report / sizeof *of_report; i++)
        if (of_report[i])
            (void)unlink(of_report[i]);
}

static int remove_one(const char *path, const struct stat *status, int kind, struct FTW *where)
{
    (void)status, (void)kind, (void)where;
    (void)remove(path);
    return 0;
}

void bake_paths_clear(struct bake_paths *paths)
{
    if (*paths->directory)
        nftw(paths->directory, remove_one, 16, FTW_DEPTH | FTW_PHYS);
    if (paths->report_made) /* empty: nothing came of it */
        (void)rmdir(paths->report);
    free(paths->report);
    free(paths->text);
    free(paths->pair);
    free(paths->probes);
}
