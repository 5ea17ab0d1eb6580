/* SPDX-License-Identifier: Apache-2.0 */
/* image: pictures in memory, decoded and made ready to be sampled as textures.
 *
 * PNG and JPEG through stb_image, WebP through libwebp, Radiance .hdr and OpenEXR
 * (image_formats.h); the content decides, not the name. 8-bit pictures keep their codes (a quarter
 * of the memory of floats); image_linear turns a code of a colour channel into linear light. Alpha
 * and masks are linear: code / 255. Pictures of 16 bits a channel are reduced to 8. .hdr and .exr
 * pictures are linear floats.
 */
#ifndef IMAGE_H
#define IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

struct image {
    uint32_t width, height;
    unsigned channels; /* 1 (alpha alone), 3 or 4 (RGB, alpha) */
    /* texels are 8-bit codes to be looked up in image_linear (RGB sRGB, alpha linear), else
     * float */
    bool bytes;
    void *texels; /* width * height * channels of uint8_t or float, top row first */
};

enum image_use {
    IMAGE_COLOUR, /* 3 channels, or 4 where some texel is not opaque */
    /* 1 channel: the alpha of a picture in which some texel is not opaque, else its luminance's
     * code */
    IMAGE_MASK,
};

/* Linear light of an 8-bit sRGB code (IEC 61966-2-1), correctly rounded. Literal numbers, so that
 * they are the same on every machine. */
extern const float image_linear[256];

/* Whether it begins as a PNG, JPEG, WebP, .hdr or .exr picture does. */
bool image_is_known(const void *data, size_t size);

/* Decodes the picture in data[0..size). The caller frees image->texels; there are none on error.
 * Errors: not a picture, damaged, larger than 16384 texels a side. */
struct error *image_decode(struct image *image, const void *data, size_t size, enum image_use use);

#endif
