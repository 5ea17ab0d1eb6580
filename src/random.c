/* Based on: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3" (SC 2011). */
#include "random.h"

#include <Random123/philox.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

struct random random_start(uint64_t seed, uint64_t name, uint32_t index)
{
    return (struct random){
        .key = {(uint32_t)seed, (uint32_t)(seed >> 32)},
        .counter = {0, index, (uint32_t)name, (uint32_t)(name >> 32)},
        .used = 4,
    };
}

uint32_t random_u32(struct random *r)
{
    if (r->used == 4) {
        philox4x32_ctr_t counter;
        philox4x32_key_t key;
        memcpy(counter.v, r->counter, sizeof counter.v);
        memcpy(key.v, r->key, sizeof key.v);
        const philox4x32_ctr_t block = philox4x32(counter, key);
        memcpy(r->block, block.v, sizeof r->block);
        r->counter[0]++;
        r->used = 0;
    }
    return r->block[r->used++];
}

float random_float(struct random *r)
{
    return (float)(random_u32(r) >> 8) * 0x1p-24f;
}

double random_double(struct random *r)
{
    const uint64_t high = random_u32(r), low = random_u32(r);
    return (double)((high << 32 | low) >> 11) * 0x1p-53;
}

uint64_t random_hash_position(const double position[3])
{
    const double canonical[3] = {position[0] + 0.0, position[1] + 0.0, position[2] + 0.0}; /* -0 + 0 = 0 */
    return XXH3_64bits(canonical, sizeof canonical);
}
