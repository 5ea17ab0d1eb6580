/* SPDX-License-Identifier: Apache-2.0 */
/* progress: how far the work is, on standard error, for a person who waits.
 *
 *     probe-capture: 1200 / 4000 probes (30 %), 310 /s, 9 s left
 */
#ifndef PROGRESS_H
#define PROGRESS_H

#include <stdbool.h>
#include <stddef.h>

struct progress; /* NULL is a progress that shows nothing */

/* Starts showing the progress of `program` through `total` things called `unit` ("probes"; 0 when
 * the total is not known). Returns NULL, which every call here accepts, when `show` is false or
 * memory is short. */
struct progress *progress_start(bool show, const char *program, const char *unit, size_t total);

/* `count` more things are done. Any thread may call; the line is redrawn a few times a second. */
void progress_add(struct progress *progress, size_t count);

/* Ends the line and frees. */
void progress_end(struct progress *progress);

#endif
