/* SPDX-License-Identifier: Apache-2.0 */
#include "math/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

_Static_assert(sizeof(struct hash) == sizeof(XXH3_state_t) &&
                   _Alignof(struct hash) == _Alignof(XXH3_state_t),
               "struct hash has the room of XXH3's state");

uint64_t hash_bytes(const void *bytes, size_t count)
{
    return XXH3_64bits(bytes, count);
}

void hash_start(struct hash *hash, uint64_t seed)
{
    XXH3_64bits_reset_withSeed((XXH3_state_t *)hash, seed);
}

void hash_add(struct hash *hash, const void *bytes, size_t count)
{
    XXH3_64bits_update((XXH3_state_t *)hash, bytes, count);
}

uint64_t hash_value(const struct hash *hash)
{
    return XXH3_64bits_digest((const XXH3_state_t *)hash);
}
