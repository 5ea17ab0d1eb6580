/* random: counter-based random numbers (Philox 4x32-10, Salmon et al. 2011, through Random123).
 *
 * A thing is random by what it is, never by when it is done: a generator is made from a seed
 * and up to 128 bits that name the thing (a probe's position, a sample's index), and gives the
 * same numbers on any thread, in any order, on any machine.
 *
 *     struct random r = random_start(seed, random_hash_position(p), sample);
 *     const float u = random_float(&r);
 */
#ifndef RANDOM_H
#define RANDOM_H

#include <stdint.h>

struct random {
    uint32_t key[2];
    uint32_t counter[4];
    uint32_t block[4]; /* the numbers of the current counter */
    unsigned used;     /* how many of them are spent */
};

/* The stream of numbers named by (seed, name, index). Streams with different names are independent. */
struct random random_start(uint64_t seed, uint64_t name, uint32_t index);

/* 32 uniform bits. */
uint32_t random_u32(struct random *r);

/* Uniform in [0, 1), a multiple of 2^-24 (every one exactly representable, never 1). */
float random_float(struct random *r);

/* Uniform in [0, 1), a multiple of 2^-53. */
double random_double(struct random *r);

/* A name for a position: a hash of its bits, with -0 as 0, so that equal positions have equal names. */
uint64_t random_hash_position(const double position[3]);

#endif
