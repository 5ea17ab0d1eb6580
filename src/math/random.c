/* SPDX-License-Identifier: Apache-2.0 */
#include "math/random.h"
#include "math/hash.h"

#include <Random123/philox.h>
#include <string.h>

struct random random_start(uint64_t seed, uint64_t name, uint32_t index)
{
    const philox4x32_ctr_t counter = {{0, index, (uint32_t)name, (uint32_t)(name >> 32)}};
    const philox4x32_key_t key = {{(uint32_t)seed, (uint32_t)(seed >> 32)}};
    const philox4x32_ctr_t block = philox4x32(counter, key);
    struct random random;
    memcpy(random.state, block.v, sizeof random.state);
    if (!(random.state[0] | random.state[1] | random.state[2] | random.state[3]))
        random.state[0] = 1; /* the one state that xoshiro never leaves */
    return random;
}

uint64_t random_hash_position(const double position[3])
{
    /* -0 + 0 = 0 */
    const double canonical[3] = {position[0] + 0.0, position[1] + 0.0, position[2] + 0.0};
    return hash_bytes(canonical, sizeof canonical);
}
