/* SPDX-License-Identifier: Apache-2.0 */
/* sobol: points of the unit square that spread evenly, in a random order, pair by pair.
 *
 * The first two dimensions of Sobol's sequence: of 2^k points in a row each 2^-k of the square, cut
 * in any way along powers of 2, holds one. They are scrambled as Owen does (nested, by a hash:
 * Laine and Karras, "Stratified sampling for stochastic transparency", EGSR 2011; Burley,
 * "Practical hash-based Owen scrambling", JCGT 2020), which keeps that and makes each point
 * uniform. A pair is named by its seed; pairs of different seeds are shuffled against each other,
 * so points of 4, 6, ... dimensions are made of pairs.
 */
#ifndef SOBOL_H
#define SOBOL_H

#include <stdint.h>

static inline uint32_t sobol_reverse(uint32_t x)
{
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
    return x >> 16 | x << 16;
}

/* 32 bits of two words; equal words give equal bits. */
static inline uint32_t sobol_mix(uint32_t a, uint32_t b)
{
    uint32_t x = a * 0x9e3779b1u + b;
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

/* Owen's scrambling of a number whose bits are reversed. */
static inline uint32_t sobol_scramble(uint32_t x, uint32_t seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return sobol_reverse(x);
}

/* Point `index` of the pair `seed`, as 32 bits below the binary point. */
static inline void sobol_pair(uint32_t index, uint32_t seed, uint32_t *x, uint32_t *y)
{
    const uint32_t i = sobol_scramble(sobol_reverse(index), sobol_mix(seed, 0));
    /* the second dimension, reversed: Pascal's matrix mod 2 */
    uint32_t v = i;
    v ^= v >> 16;
    v ^= v >> 8 & 0x00ff00ffu;
    v ^= v >> 4 & 0x0f0f0f0fu;
    v ^= v >> 2 & 0x33333333u;
    v ^= v >> 1 & 0x55555555u;
    *x = sobol_scramble(i, sobol_mix(seed, 1));
    *y = sobol_scramble(v, sobol_mix(seed, 2));
}

#endif
