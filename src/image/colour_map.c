/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: K. Moreland, "Diverging color maps for scientific visualization (expanded)", 2009: Msh,
 * polar CIELAB, and its interpolation. */
#include "image/colour_map.h"
#include "image/cielab.h"
#include "image/image.h"
#include "math/angle.h"

/* Every eighth of magma's 256 colours, and the last; straight lines of codes between are off by no
 * more than one. */
static const unsigned char magma[33][3] = {
    {0x00, 0x00, 0x04}, {0x03, 0x03, 0x12}, {0x0a, 0x08, 0x22}, {0x13, 0x0d, 0x34},
    {0x1d, 0x11, 0x47}, {0x29, 0x11, 0x5a}, {0x36, 0x10, 0x6b}, {0x44, 0x0f, 0x76},
    {0x51, 0x12, 0x7c}, {0x5d, 0x17, 0x7f}, {0x6a, 0x1c, 0x81}, {0x76, 0x21, 0x81},
    {0x83, 0x26, 0x81}, {0x90, 0x2a, 0x81}, {0x9c, 0x2e, 0x7f}, {0xaa, 0x33, 0x7d},
    {0xb7, 0x37, 0x79}, {0xc4, 0x3c, 0x75}, {0xd0, 0x41, 0x6f}, {0xdc, 0x48, 0x69},
    {0xe7, 0x52, 0x63}, {0xef, 0x5d, 0x5e}, {0xf5, 0x6b, 0x5c}, {0xf9, 0x79, 0x5d},
    {0xfc, 0x89, 0x61}, {0xfd, 0x98, 0x69}, {0xfe, 0xa7, 0x72}, {0xfe, 0xb6, 0x7c},
    {0xfe, 0xc4, 0x88}, {0xfe, 0xd3, 0x95}, {0xfd, 0xe2, 0xa3}, {0xfc, 0xf0, 0xb2},
    {0xfc, 0xfd, 0xbf}};

/* Linear light of a code that need not be whole. */
static float light_of(double code)
{
    const int low = code < 254 ? (int)code : 254;
    const double share = code - low;
    return (float)((1 - share) * (double)image_linear[low] + share * (double)image_linear[low + 1]);
}

static struct vec3f magma_at(double t)
{
    const double x = t * 255 / 8;
    const int i = x < 31 ? (int)x : 31;
    const double share = i < 31 ? x - i : (x - 31) * 8 / 7; /* the last step is of 7 */
    float rgb[3];
    for (int k = 0; k < 3; k++)
        rgb[k] = light_of((1 - share) * magma[i][k] + share * magma[i + 1][k]);
    return (struct vec3f){rgb[0], rgb[1], rgb[2]};
}

/* -- Msh --------------------------------------------------------------------------------------- */

struct msh {
    double m, s, h;
};

static struct msh msh_of(const unsigned char code[3])
{
    const double rgb[3] = {(double)image_linear[code[0]], (double)image_linear[code[1]],
                           (double)image_linear[code[2]]};
    double lab[3];
    cielab_of(rgb, lab);
    const double chroma = sqrt(lab[1] * lab[1] + lab[2] * lab[2]),
                 m = sqrt(lab[0] * lab[0] + chroma * chroma);
    return (struct msh){m, angle_atan2(chroma, lab[0]), angle_atan2(lab[2], lab[1])};
}

/* The hue that a colour is to have on its way to a white of larger M (the paper's AdjustHue). */
static double adjusted_hue(struct msh c, double white)
{
    if (c.m >= white)
        return c.h;
    const double spin = c.s * sqrt(white * white - c.m * c.m) / (c.m * angle_sin(c.s));
    return c.h > -ANGLE_PI / 3 ? c.h + spin : c.h - spin;
}

static struct vec3f cool_warm_at(double t)
{
    static const unsigned char cool[3] = {59, 76, 192}, warm[3] = {180, 4, 38};
    const struct msh end = msh_of(t < 0.5 ? cool : warm);
    const double white = fmax(fmax(msh_of(cool).m, msh_of(warm).m), 88);
    /* of white */
    const double hue = adjusted_hue(end, white), share = t < 0.5 ? 2 * t : 2 * (1 - t);
    const struct msh c = {(1 - share) * end.m + share * white, (1 - share) * end.s,
                          (1 - share) * end.h + share * hue};
    const double lab[3] = {c.m * angle_cos(c.s), c.m * angle_sin(c.s) * angle_cos(c.h),
                           c.m * angle_sin(c.s) * angle_sin(c.h)};
    double rgb[3];
    cielab_to(lab, rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] = fmin(fmax(rgb[k], 0), 1);
    return (struct vec3f){(float)rgb[0], (float)rgb[1], (float)rgb[2]};
}

struct vec3f colour_map_at(enum colour_map map, double t)
{
    t = t > 0 ? t < 1 ? t : 1 : 0;
    return map == COLOUR_MAGMA ? magma_at(t) : cool_warm_at(t);
}
