/* SPDX-License-Identifier: Apache-2.0 */
/* warning: what a library call has to say without failing, kept until main prints it.
 *
 * A dirty scene can be wrong in the same way ten thousand times, so warnings are counted by
 * kind and the first of each kind is kept whole. A program prints them once:
 *
 *     probe-capture: warning: sponza.mtl:12: texture a.png is missing: its factor
 *     alone is used (and 3 more like it)
 *
 * A warning says what was done about the thing.
 */
#ifndef WARNING_H
#define WARNING_H

#include <stddef.h>
#include <stdint.h>

struct warning {
    const char *kind;
    char *message; /* of the first of its kind; owned */
    size_t count;
    uint64_t key; /* of one that is said once a bake (scene_told.h); 0: none */
};

struct warnings {
    struct warning *list; /* in order of first appearance */
    size_t count, capacity;
};

/* Adds one warning. `kind` is a short constant ("texture missing") that groups them; it must
 * outlive the list. The rest is printf-formatted. NULL warnings ignore it; so does a shortage of
 * memory. */
void warnings_add(struct warnings *warnings, const char *kind, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Moves all of `from` behind those of `to`, which may be NULL: then they are forgotten. Those with
 * a key are not grouped with others. */
void warnings_move(struct warnings *to, struct warnings *from);

/* Takes warning i out of the list. */
void warnings_remove(struct warnings *warnings, size_t i);

/* How many warnings of this kind were added. */
size_t warnings_of_kind(const struct warnings *warnings, const char *kind);

/* Prints one line a kind to standard error and clears the list. */
void warnings_print(struct warnings *warnings, const char *program);

void warnings_clear(struct warnings *warnings);

#endif
