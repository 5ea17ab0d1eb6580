/* SPDX-License-Identifier: Apache-2.0 */
/* luminance: of linear RGB by Rec. 709; its weights stand here alone.
 *
 * Summed in double unless all is float: the terms red, green, blue from the left, so that the same
 * colours give the same bytes wherever they are weighed. (libprobe-query/sh.c, which games copy,
 * has the weights again.)
 */
#ifndef LUMINANCE_H
#define LUMINANCE_H

#include "math/vec.h"

#define LUMINANCE_RED 0.2126
#define LUMINANCE_GREEN 0.7152
#define LUMINANCE_BLUE 0.0722

static inline double luminance_f64(const double rgb[3])
{
    return LUMINANCE_RED * rgb[0] + LUMINANCE_GREEN * rgb[1] + LUMINANCE_BLUE * rgb[2];
}

/* In double. */
static inline double luminance_f32(const float rgb[3])
{
    return luminance_f64((const double[3]){(double)rgb[0], (double)rgb[1], (double)rgb[2]});
}

/* In float. */
static inline float luminance_vec3f(struct vec3f c)
{
    return (float)LUMINANCE_RED * c.x + (float)LUMINANCE_GREEN * c.y + (float)LUMINANCE_BLUE * c.z;
}

#endif
