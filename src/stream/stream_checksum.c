/* SPDX-License-Identifier: Apache-2.0 */
/* The checksums that prove a binary stream (man probe.5, "Blocks"). */
#include "base/error.h"
#include "math/hash.h"
#include "stream/stream_private.h"

#include <stdlib.h>

struct error *checksum_create(struct hash **checksum)
{
    *checksum = aligned_alloc(_Alignof(struct hash), sizeof **checksum);
    if (!*checksum)
        return error_memory();
    hash_start(*checksum, 0);
    return NULL;
}

void checksum_destroy(struct hash *checksum)
{
    free(checksum);
}

void checksum_update(struct hash *checksum, const void *bytes, size_t count)
{
    hash_add(checksum, bytes, count);
}

uint64_t checksum_take(struct hash *checksum)
{
    const uint64_t sum = hash_value(checksum);
    hash_start(checksum, sum);
    return sum;
}
