/* SPDX-License-Identifier: Apache-2.0 */
#include "base/threads.h"
#include "base/error.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>

struct loop {
    threads_body *body;
    void *context;
    size_t count;
    atomic_size_t next;
    atomic_bool failed;
    pthread_mutex_t lock; /* guards the two below */
    size_t error_index;
    struct error *err;
};

struct worker {
    struct loop *loop;
    int thread;
};

int threads_available(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        return CPU_COUNT(&set);
    return 1;
}

static void *work(void *argument)
{
    const struct worker *worker = argument;
    struct loop *loop = worker->loop;
    while (!atomic_load_explicit(&loop->failed, memory_order_relaxed)) {
        const size_t i = atomic_fetch_add(&loop->next, 1);
        if (i >= loop->count)
            break;
        struct error *err = loop->body(loop->context, i, worker->thread);
        if (!err)
            continue;
        pthread_mutex_lock(&loop->lock);
        if (!loop->err || i < loop->error_index) {
            error_destroy(loop->err);
            loop->err = err;
            loop->error_index = i;
        } else {
            error_destroy(err);
        }
        pthread_mutex_unlock(&loop->lock);
        atomic_store(&loop->failed, true);
    }
    return NULL;
}

struct error *threads_for(int threads, size_t count, threads_body *body, void *context)
{
    struct loop loop = {.body = body, .context = context, .count = count};
    pthread_mutex_init(&loop.lock, NULL);
    int helpers = threads > 1 ? threads - 1 : 0;
    if ((size_t)helpers >= count)
        helpers = count ? (int)count - 1 : 0;
    struct worker *workers = calloc((size_t)helpers + 1, sizeof *workers);
    pthread_t *ids = calloc((size_t)helpers + 1, sizeof *ids);
    int started = 0;
    if (workers && ids) {
        for (; started < helpers; started++) {
            workers[started] = (struct worker){.loop = &loop, .thread = started + 1};
            if (pthread_create(&ids[started], NULL, work, &workers[started]))
                break;
        }
    }
    work(&(struct worker){.loop = &loop, .thread = 0});
    for (int i = 0; i < started; i++)
        pthread_join(ids[i], NULL);
    free(ids);
    free(workers);
    pthread_mutex_destroy(&loop.lock);
    return loop.err;
}
