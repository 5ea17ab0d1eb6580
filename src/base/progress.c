/* SPDX-License-Identifier: Apache-2.0 */
#include "base/progress.h"
#include "base/clock.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

struct progress {
    const char *program, *unit;
    size_t total, done;
    double start, drawn; /* seconds */
    pthread_mutex_t lock;
};

struct progress *progress_start(bool show, const char *program, const char *unit, size_t total)
{
    struct progress *p = show ? calloc(1, sizeof *p) : NULL;
    if (!p)
        return NULL;
    p->program = program;
    p->unit = unit;
    p->total = total;
    p->start = p->drawn = clock_seconds();
    pthread_mutex_init(&p->lock, NULL);
    return p;
}

static void draw(const struct progress *p, double time)
{
    const double seconds = time - p->start;
    const double rate = seconds > 0 ? (double)p->done / seconds : 0;
    fprintf(stderr, "\r%s: %zu", p->program, p->done);
    if (p->total)
        fprintf(stderr, " / %zu %s (%.0f %%)", p->total, p->unit,
                100.0 * (double)p->done / (double)p->total);
    else
        fprintf(stderr, " %s", p->unit);
    fprintf(stderr, ", %.3g /s", rate);
    if (p->total && rate > 0)
        fprintf(stderr, ", %.0f s left", (double)(p->total - p->done) / rate);
    fputs("\033[K", stderr); /* clears what a longer line left behind */
}

void progress_add(struct progress *p, size_t count)
{
    if (!p)
        return;
    pthread_mutex_lock(&p->lock);
    p->done += count;
    const double time = clock_seconds();
    if (time - p->drawn > 0.2) {
        draw(p, time);
        p->drawn = time;
    }
    pthread_mutex_unlock(&p->lock);
}

void progress_end(struct progress *p)
{
    if (!p)
        return;
    draw(p, clock_seconds());
    fputc('\n', stderr);
    pthread_mutex_destroy(&p->lock);
    free(p);
}
