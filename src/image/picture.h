/* SPDX-License-Identifier: Apache-2.0 */
/* picture: pictures of linear RGB in memory, and as files.
 *
 * PFM holds the numbers as they are: "PF", width and height, -1 (little-endian), then rows of float
 * RGB, the bottom one first (P. Debevec's HDRShop). PNG holds sRGB codes of 8 bits (display.h).
 * Files appear only when they are whole.
 */
#ifndef PICTURE_H
#define PICTURE_H

#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>

struct error;

struct picture {
    size_t width, height;
    float *rgb; /* 3 * width * height, the top row first; owned */
};

enum { PICTURE_SIDE_MOST = 16384 };

/* A black picture. Errors: a side of 0, or of more than PICTURE_SIDE_MOST. */
struct error *picture_init(struct picture *picture, size_t width, size_t height);
void picture_clear(struct picture *picture);

static inline struct vec3f picture_get(const struct picture *p, size_t x, size_t y)
{
    const float *rgb = p->rgb + 3 * (y * p->width + x);
    return (struct vec3f){rgb[0], rgb[1], rgb[2]};
}

static inline void picture_set(const struct picture *p, size_t x, size_t y, struct vec3f c)
{
    float *rgb = p->rgb + 3 * (y * p->width + x);
    rgb[0] = c.x;
    rgb[1] = c.y;
    rgb[2] = c.z;
}

/* Copies `from` into `to` with its left upper pixel at (x, y); what does not fit is left out. */
void picture_paste(const struct picture *to, size_t x, size_t y, const struct picture *from);

/* path "-": standard output. png: light of 0 .. 1, sRGB; else PFM. */
struct error *picture_write(const struct picture *picture, const char *path, bool png);

/* Whether a file of this name can be written, before there is a picture; says nothing of pipes and
 * devices. */
struct error *picture_try(const char *path);

/* Reads a PFM, or a PNG, JPEG, WebP or Radiance .hdr picture, whose light is made linear. Errors
 * name the file. */
struct error *picture_read(struct picture *picture, const char *path);

#endif
