/* SPDX-License-Identifier: Apache-2.0 */
/* half: IEEE 754 binary16 in two bytes, as packed files hold light and sight. */
#ifndef HALF_H
#define HALF_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* The half nearest to x (|x| < 65536), to even; the largest half for what is beyond it. */
static inline uint16_t half_of(float x)
{
    uint32_t bits;
    const float size = fabsf(x);
    /* a half's exponent: what falls below a float's least normal is rounded as a subnormal half's
     * is */
    float scaled = size * 0x1p-112f;
    memcpy(&bits, &scaled, sizeof bits);
    bits = (bits + 0xfff + (bits >> 13 & 1)) >> 13;
    if (size < 0x1p-14f)
        bits = (uint32_t)nearbyintf(size * 0x1p24f);
    bits = bits > 0x7bff ? 0x7bff : bits;
    return (uint16_t)(bits | (signbit(x) ? 0x8000u : 0));
}

/* A half (finite) as a float: the bits moved into place, and the exponent's bias made right. A
 * subnormal half is the fraction of the least normal one, without that one: no float on the way is
 * subnormal, which takes processors a hundred times as long. */
static inline float half_value(uint16_t half)
{
    const uint32_t least = 113u << 23, bits = (uint32_t)(half & 0x7fff) << 13,
                   moved = bits + (bits < 1u << 23 ? least : 112u << 23);
    float x, less;
    memcpy(&x, &moved, sizeof x);
    memcpy(&less, &least, sizeof less);
    x -= bits < 1u << 23 ? less : 0;
    return half & 0x8000 ? -x : x;
}

/* A power of two that brings all numbers within a half's range, near its top, whose largest is
 * `most`: small ones keep more bits. It is one that packed files may have. */
static inline float half_scale(float most)
{
    int exponent = 0;
    if (!(most > 0))
        return 1;
    frexpf(most, &exponent);
    exponent = exponent < -100 ? -100 : exponent > 127 ? 127 : exponent;
    return ldexpf(1, exponent - 15);
}

static inline int half_finite(uint16_t half)
{
    return (half & 0x7c00) != 0x7c00;
}

#endif
