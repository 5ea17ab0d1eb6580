/* SPDX-License-Identifier: Apache-2.0 */
#include "base/once.h"
#include "base/array.h"
#include "base/error.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>

struct once {
    atomic_bool done;
    pthread_mutex_t lock; /* guards the making, and: */
    struct error *err;    /* not changed any more when done is set */
};

struct error *once_create(struct once **once)
{
    struct error *err = array_create(once, 1, sizeof **once);
    if (!err)
        pthread_mutex_init(&(*once)->lock, NULL);
    return err;
}

void once_destroy(struct once *once)
{
    if (!once)
        return;
    pthread_mutex_destroy(&once->lock);
    error_destroy(once->err);
    free(once);
}

struct error *once_do(struct once *once, struct error *(*make)(void *context), void *context)
{
    if (!atomic_load_explicit(&once->done, memory_order_acquire)) {
        pthread_mutex_lock(&once->lock);
        if (!atomic_load_explicit(&once->done, memory_order_relaxed)) {
            once->err = make(context);
            atomic_store_explicit(&once->done, true, memory_order_release);
        }
        pthread_mutex_unlock(&once->lock);
    }
    return once->err ? error_new("%s", error_message(once->err)) : NULL;
}
