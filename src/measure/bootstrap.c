/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/bootstrap.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "math/random.h"
#include "math/sort.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS_LEAST = 8 };

struct sets {
    const struct bootstrap_job *job;
    uint32_t **times; /* by thread */
    double *figure;   /* figures of each set */
};

static struct error *draw_set(void *context, size_t index, int thread)
{
    const struct sets *sets = context;
    const struct bootstrap_job *job = sets->job;
    uint32_t *times = sets->times[thread];
    struct random r = random_start(job->seed, job->name, (uint32_t)index);
    memset(times, 0, job->count * sizeof *times);
    for (size_t i = 0; i < job->count; i++)
        times[(size_t)(random_double(&r) * (double)job->count)]++;
    job->reckon(job->context, times, sets->figure + (size_t)job->figures * index);
    return NULL;
}

/* The middle 95 % of one figure's values. */
static void set_interval(const struct sets *sets, int figure, double *value,
                         struct estimate *estimate)
{
    for (size_t i = 0; i < BOOTSTRAP_SETS; i++)
        value[i] = sets->figure[(size_t)sets->job->figures * i + (size_t)figure];
    estimate->low = sort_find(BOOTSTRAP_SETS, value, BOOTSTRAP_SETS / 40);
    estimate->high = sort_find(BOOTSTRAP_SETS, value, BOOTSTRAP_SETS - 1 - BOOTSTRAP_SETS / 40);
}

static struct error *make_intervals(const struct bootstrap_job *job, struct estimate *estimate)
{
    const int threads = job->threads;
    struct sets sets = {.job = job};
    double *value = NULL;
    struct error *err = array_create(&sets.times, (size_t)threads, sizeof *sets.times);
    if (!err)
        err =
            array_create(&sets.figure, BOOTSTRAP_SETS * (size_t)job->figures, sizeof *sets.figure);
    if (!err)
        err = array_create(&value, BOOTSTRAP_SETS, sizeof *value);
    for (int i = 0; i < threads && !err; i++)
        err = array_create(&sets.times[i], job->count, sizeof **sets.times);
    if (!err)
        err = threads_for(threads, BOOTSTRAP_SETS, draw_set, &sets);
    for (int f = 0; f < job->figures && !err; f++)
        set_interval(&sets, f, value, &estimate[f]);
    for (int i = 0; i < threads && sets.times; i++)
        free(sets.times[i]);
    free(sets.times);
    free(sets.figure);
    free(value);
    return err;
}

struct error *bootstrap(const struct bootstrap_job *job, struct estimate *estimate)
{
    const size_t count = job->count;
    const int figures = job->figures;
    uint32_t *once = NULL;
    double *figure = NULL;
    struct error *err = array_create(&once, count, sizeof *once);
    if (!err)
        err = array_create(&figure, (size_t)figures, sizeof *figure);
    for (size_t i = 0; i < count && !err; i++)
        once[i] = 1;
    if (!err)
        job->reckon(job->context, once, figure);
    for (int f = 0; f < figures && !err; f++)
        estimate[f] =
            (struct estimate){.value = figure[f], .low = (double)NAN, .high = (double)NAN};
    if (!err && count >= POINTS_LEAST)
        err = make_intervals(job, estimate);
    free(once);
    free(figure);
    return err;
}
