/* SPDX-License-Identifier: Apache-2.0 */
/* discs: those of libprobe-query (libprobe-query/discs.h), made with an error for what is wrong.
 *
 *     err = discs_create(&discs, &points);
 *     ... discs_blend(discs, ...) ...
 *     discs_destroy(discs);
 */
#ifndef INTERPOLATE_DISCS_H
#define INTERPOLATE_DISCS_H

#include "libprobe-query/discs.h"

struct error;

/* As discs_make. Error: no point has a disc, discs that are too far from one another or too large,
 * memory. */
struct error *discs_create(struct discs **discs, const struct disc_points *points);

#endif
