/* SPDX-License-Identifier: Apache-2.0 */
/* threads: a loop on all cores.
 *
 * Items are handed out one at a time, in order, to whichever thread is free, so uneven items
 * balance. An item's result may depend only on its index, never on the thread or the order:
 * that is what keeps the bytes equal for any number of threads.
 */
#ifndef THREADS_H
#define THREADS_H

#include <stddef.h>

struct error;

/* Does item `index` of the loop on thread `thread` (0 .. threads-1, for scratch space of its
 * own). */
typedef struct error *threads_body(void *context, size_t index, int thread);

/* The cores that this process may use; at least 1. */
int threads_available(void);

/* Runs body(context, i, thread) for i in 0 .. count-1 on `threads` threads (the caller's is one;
 * fewer when they cannot be had). When items fail, no new ones start and the error of the lowest
 * index that failed is returned, the others are freed. */
struct error *threads_for(int threads, size_t count, threads_body *body, void *context);

#endif
