/* SPDX-License-Identifier: Apache-2.0 */
/* image_formats: decoders of our own for pictures of light, linear float RGB; for image.c alone.
 *
 * Radiance .hdr: G. Ward, "Real Pixels", Graphics Gems II, 1991, and the Radiance file formats
 * (radsite.lbl.gov/radiance/refer/filefmts.pdf). Run lengths old and new, flat; rows or columns in
 * any direction; RGBE and XYZE, RGBE where the header does not say; `#?` and any name. A texel is
 * mantissa * 2^(exponent - 136), as most programs write it. EXPOSURE and COLORCORR, which multiply
 * where they come again, are divided out. XYZE becomes RGB of Rec. 709's primaries about Radiance's
 * white, which is that of equal energy: X = Y = Z is R = G = B; colours outside are cut at 0.
 *
 * OpenEXR through the plain C part of its library: rows or tiles, half, float or whole numbers, any
 * compression that the library reads; of the first part that has light, channels R, G, B or Y, of
 * no layer or else of the first that has them. The picture is the display window, black where there
 * are no data. Light below 0 is 0. Refused by name: deep parts alone, DWA, chroma, what is not
 * finite.
 */
#ifndef IMAGE_FORMATS_H
#define IMAGE_FORMATS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

enum { IMAGE_SIDE_MOST = 16384 };

struct image_floats {
    uint32_t width, height;
    float *rgb; /* 3 * width * height, top row first; the caller frees it; NULL on error */
};

/* Errors: a side of 0 or above IMAGE_SIDE_MOST. */
struct error *image_check_sides(int64_t width, int64_t height);

bool image_is_hdr(const void *data, size_t size);
struct error *image_decode_hdr(const void *data, size_t size, struct image_floats *out);

bool image_is_exr(const void *data, size_t size);
struct error *image_decode_exr(const void *data, size_t size, struct image_floats *out);

#endif
