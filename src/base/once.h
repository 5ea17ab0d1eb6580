/* SPDX-License-Identifier: Apache-2.0 */
/* once: what is made when it is first asked for, by whichever thread asks first. */
#ifndef ONCE_H
#define ONCE_H

struct error;
struct once;

/* Begins with nothing made. The caller destroys it. */
struct error *once_create(struct once **once);
void once_destroy(struct once *once);

/* Runs make(context), if nobody has; others wait for its end. Where it failed it is not tried
 * again, and each caller gets the error, as its own. */
struct error *once_do(struct once *once, struct error *(*make)(void *context), void *context);

#endif
