/* SPDX-License-Identifier: Apache-2.0 */
/* random: random numbers that are named, not drawn.
 *
 * A thing is random by what it is, never by when it is done: a generator is made from a seed
 * and up to 96 bits that name the thing (a probe's position, a sample's index), and gives the
 * same numbers on any thread, in any order, on any machine. The name is hashed by Philox 4x32-10
 * (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011, through Random123) into
 * the state of xoshiro128++ (Blackman and Vigna, "Scrambled linear pseudorandom number generators",
 * ACM TOMS 2021), which is cheaper a number.
 *
 *     struct random r = random_start(seed, random_hash_position(p), sample);
 *     const float u = random_float(&r);
 */
#ifndef RANDOM_H
#define RANDOM_H

#include <stdint.h>

struct random {
    uint32_t state[4];
};

/* The stream of numbers named by (seed, name, index). Streams with different names are
 * independent. */
struct random random_start(uint64_t seed, uint64_t name, uint32_t index);

/* 32 uniform bits. */
static inline uint32_t random_u32(struct random *r)
{
    uint32_t *s = r->state;
    const uint32_t sum = s[0] + s[3], result = (sum << 7 | sum >> 25) + s[0], t = s[1] << 9;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = s[3] << 11 | s[3] >> 21;
    return result;
}

/* Uniform in [0, 1), a multiple of 2^-24 (every one exactly representable, never 1). */
static inline float random_float(struct random *r)
{
    return (float)(random_u32(r) >> 8) * 0x1p-24f;
}

/* Uniform in [0, 1), a multiple of 2^-53. */
static inline double random_double(struct random *r)
{
    const uint64_t high = random_u32(r), low = random_u32(r);
    return (double)((high << 32 | low) >> 11) * 0x1p-53;
}

/* A name for a position: a hash of its bits, with -0 as 0, so that equal positions have equal
 * names. */
uint64_t random_hash_position(const double position[3]);

#endif
