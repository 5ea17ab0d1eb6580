#include "measure/bootstrap.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "math/random.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS_LEAST = 8 };

struct job {
    size_t count;
    uint64_t seed, name;
    int figures;
    bootstrap_reckon *reckon;
    const void *context;
    uint32_t **times; /* by thread */
    double *figure;   /* figures of each set */
};

static struct error *draw_set(void *context, size_t index, int thread)
{
    const struct job *job = context;
    uint32_t *times = job->times[thread];
    struct random r = random_start(job->seed, job->name, (uint32_t)index);
    memset(times, 0, job->count * sizeof *times);
    for (size_t i = 0; i < job->count; i++)
        times[(size_t)(random_double(&r) * (double)job->count)]++;
    job->reckon(job->context, times, job->figure + (size_t)job->figures * index);
    return NULL;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* The middle 95 % of one figure's values. */
static void set_interval(const struct job *job, int figure, double *value,
                         struct estimate *estimate)
{
    for (size_t i = 0; i < BOOTSTRAP_SETS; i++)
        value[i] = job->figure[(size_t)job->figures * i + (size_t)figure];
    qsort(value, BOOTSTRAP_SETS, sizeof *value, compare);
    estimate->low = value[BOOTSTRAP_SETS / 40];
    estimate->high = value[BOOTSTRAP_SETS - 1 - BOOTSTRAP_SETS / 40];
}

static struct error *make_intervals(struct job *job, int threads, struct estimate *estimate)
{
    double *value = NULL;
    struct error *err = array_create(&job->times, (size_t)threads, sizeof *job->times);
    if (!err)
        err =
            array_create(&job->figure, BOOTSTRAP_SETS * (size_t)job->figures, sizeof *job->figure);
    if (!err)
        err = array_create(&value, BOOTSTRAP_SETS, sizeof *value);
    for (int i = 0; i < threads && !err; i++)
        err = array_create(&job->times[i], job->count, sizeof **job->times);
    if (!err)
        err = threads_for(threads, BOOTSTRAP_SETS, draw_set, job);
    for (int f = 0; f < job->figures && !err; f++)
        set_interval(job, f, value, &estimate[f]);
    for (int i = 0; i < threads && job->times; i++)
        free(job->times[i]);
    free(job->times);
    free(job->figure);
    free(value);
    return err;
}

struct error *bootstrap(size_t count, uint64_t seed, uint64_t name, int figures,
                        bootstrap_reckon *reckon, const void *context, int threads,
                        struct estimate *estimate)
{
    struct job job = {.count = count,
                      .seed = seed,
                      .name = name,
                      .figures = figures,
                      .reckon = reckon,
                      .context = context};
    uint32_t *once = NULL;
    double *figure = NULL;
    struct error *err = array_create(&once, count, sizeof *once);
    if (!err)
        err = array_create(&figure, (size_t)figures, sizeof *figure);
    for (size_t i = 0; i < count && !err; i++)
        once[i] = 1;
    if (!err)
        reckon(context, once, figure);
    for (int f = 0; f < figures && !err; f++)
        estimate[f] =
            (struct estimate){.value = figure[f], .low = (double)NAN, .high = (double)NAN};
    if (!err && count >= POINTS_LEAST)
        err = make_intervals(&job, threads, estimate);
    free(once);
    free(figure);
    return err;
}
