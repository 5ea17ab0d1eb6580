/* SPDX-License-Identifier: Apache-2.0 */
/* hash: 64 bits that stand for bytes, the same on every machine.
 *
 *     struct hash hash;
 *     hash_start(&hash, 0);
 *     hash_add(&hash, bytes, count);
 *     hash_value(&hash)
 *
 * Based on: Collet, XXH3, https://xxhash.com. libprobe-query, which stands alone, has it of its
 * own.
 */
#ifndef HASH_H
#define HASH_H

#include <stddef.h>
#include <stdint.h>

/* XXH3's state, of no use from outside. Allocate with its alignment. */
struct hash {
    _Alignas(64) unsigned char state[576];
};

/* hash_start, hash_add and hash_value in one, of seed 0. */
uint64_t hash_bytes(const void *bytes, size_t count);

void hash_start(struct hash *hash, uint64_t seed);
void hash_add(struct hash *hash, const void *bytes, size_t count);

/* Of what was added so far; more may follow. */
uint64_t hash_value(const struct hash *hash);

#endif
