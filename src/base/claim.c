/* SPDX-License-Identifier: Apache-2.0 */
#include "base/claim.h"
#include "base/array.h"
#include "base/error.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum use { INPUT = 1, IN_PLACE = 2, OUTPUT = 4 };

struct claim {
    bool there; /* the file, and so device and inode */
    dev_t device;
    ino_t inode;
    unsigned use;
    /* OUTPUT: */
    const char *option; /* NULL: of none */
    bool written_into;  /* by standard output: nothing appears in its place */
    dev_t folder_device;
    ino_t folder_inode;
    char *name; /* in that folder; owned; NULL: standard output */
};

static struct {
    pthread_mutex_t lock;
    bool begun;
    struct claim *claims;
    size_t count, capacity;
} all = {.lock = PTHREAD_MUTEX_INITIALIZER};

void claim_begin(void)
{
    pthread_mutex_lock(&all.lock);
    all.begun = true;
    pthread_mutex_unlock(&all.lock);
}

static struct error *add(struct claim claim)
{
    struct error *err = array_reserve(&all.claims, &all.capacity, all.count + 1, sizeof claim);
    if (err)
        free(claim.name);
    else
        all.claims[all.count++] = claim;
    return err;
}

static bool is_same(const struct claim *a, const struct claim *b)
{
    return a->there && b->there && a->device == b->device && a->inode == b->inode;
}

/* Two outputs that would take the same name. */
static bool is_same_name(const struct claim *a, const struct claim *b)
{
    return a->name && b->name && a->folder_device == b->folder_device &&
           a->folder_inode == b->folder_inode && !strcmp(a->name, b->name);
}

/* What is known of the file of this claim's input; NULL: nothing. */
static struct claim *find_input(const struct claim *of)
{
    for (size_t i = 0; i < all.count; i++)
        if (all.claims[i].use != OUTPUT && is_same(&all.claims[i], of))
            return &all.claims[i];
    return NULL;
}

static bool may_replace(const struct claim *input, const struct claim *output)
{
    return input && input->use & IN_PLACE && !output->written_into &&
           (!output->option || !strcmp(output->option, "output"));
}

static const char *dashes(const struct claim *output)
{
    return output->option ? "--" : "";
}

static const char *of_option(const struct claim *output)
{
    return output->option ? output->option : output->written_into ? "standard output" : "an output";
}

/* -- what is read ----------------------------------------------------------------------------- */

static bool is_file(struct claim *claim, const struct stat *status)
{
    claim->there = S_ISREG(status->st_mode);
    claim->device = status->st_dev;
    claim->inode = status->st_ino;
    return claim->there;
}

/* With the lock. */
static struct error *check_input(const struct claim *input)
{
    const struct claim *known = find_input(input);
    for (size_t i = 0; i < all.count; i++) {
        const struct claim *output = &all.claims[i];
        if (output->use == OUTPUT && is_same(output, input) && !may_replace(known, output))
            return error_usage("it is read, and %s%s would overwrite it", dashes(output),
                               of_option(output));
    }
    return known && known->use & INPUT ? NULL : add(*input);
}

static struct error *claim_file(const struct stat *status)
{
    struct claim input = {.use = INPUT};
    if (!is_file(&input, status))
        return NULL;
    pthread_mutex_lock(&all.lock);
    struct error *err = all.begun ? check_input(&input) : NULL;
    pthread_mutex_unlock(&all.lock);
    return err;
}

struct error *claim_input(int fd)
{
    struct stat status;
    return fstat(fd, &status) ? NULL : claim_file(&status);
}

struct error *claim_input_of(const char *path)
{
    struct stat status;
    return stat(path, &status) ? NULL : error_wrap(claim_file(&status), "%s", path);
}

void claim_in_place(const char *path)
{
    struct stat status;
    struct claim input = {.use = IN_PLACE};
    if (!(strcmp(path, "-") ? stat(path, &status) : fstat(STDIN_FILENO, &status)) &&
        is_file(&input, &status)) {
        pthread_mutex_lock(&all.lock);
        error_destroy(add(input)); /* without it, in place is refused */
        pthread_mutex_unlock(&all.lock);
    }
}

void claim_end(const char *path)
{
    struct stat status;
    struct claim file = {0};
    if (stat(path, &status) || !is_file(&file, &status))
        return;
    pthread_mutex_lock(&all.lock);
    for (size_t i = 0; i < all.count; i++)
        if (is_same(&all.claims[i], &file))
            all.claims[i].there = false;
    pthread_mutex_unlock(&all.lock);
}

/* -- what is written -------------------------------------------------------------------------- */

/* Where it is and will be; *nobodys: a pipe, a device, or a folder that is not there, of which
 * whoever opens it complains. */
static struct error *find_output(struct claim *output, const char *path, bool *nobodys)
{
    struct stat status;
    *nobodys = true;
    if (!strcmp(path, "-")) {
        output->written_into = true;
        *nobodys = fstat(STDOUT_FILENO, &status) || !is_file(output, &status);
        return NULL;
    }
    const bool exists = !stat(path, &status);
    if (exists && !is_file(output, &status))
        return NULL;
    char *target = exists ? realpath(path, NULL) : strdup(path);
    if (!target)
        return error_memory();
    char *slash = strrchr(target, '/');
    output->name = strdup(slash ? slash + 1 : target);
    if (slash)
        slash[slash == target] = 0;
    if (output->name && !stat(slash ? target : ".", &status)) {
        output->folder_device = status.st_dev;
        output->folder_inode = status.st_ino;
        *nobodys = false;
    }
    free(target);
    return output->name ? NULL : error_memory();
}

/* With the lock; takes the claim. */
static struct error *check_output(struct claim output, const char *path)
{
    const struct claim *input = NULL;
    struct error *err = NULL;
    bool known = false;
    for (size_t i = 0; i < all.count && !err; i++) {
        const struct claim *other = &all.claims[i];
        const bool same = is_same(other, &output);
        if (same && other->use != OUTPUT && !may_replace(find_input(&output), &output))
            input = other;
        if (other->use != OUTPUT || !(same || is_same_name(other, &output)))
            continue;
        known = true;
        if (output.written_into != other->written_into ||
            (output.option && other->option && strcmp(output.option, other->option)))
            err = error_usage("%s: %s%s and %s%s are the same file",
                              output.written_into ? "stdout" : path, dashes(other),
                              of_option(other), dashes(&output), of_option(&output));
    }
    if (!err && input)
        err = error_usage("%s: it is read, and %s%s would overwrite it",
                          output.written_into ? "stdout" : path, dashes(&output),
                          of_option(&output));
    if (!err && !known)
        return add(output);
    free(output.name);
    return err;
}

struct error *claim_output(const char *path, const char *option)
{
    const bool standard = !strcmp(path, "-");
    struct claim output = {.use = OUTPUT, .option = standard ? NULL : option};
    bool nobodys;
    if (option && !*path)
        return error_usage("--%s: expected a file's name, got ''", option);
    pthread_mutex_lock(&all.lock);
    struct error *err = all.begun ? find_output(&output, path, &nobodys) : NULL;
    if (err || !all.begun || nobodys)
        free(output.name);
    else
        err = check_output(output, path);
    pthread_mutex_unlock(&all.lock);
    return err;
}
