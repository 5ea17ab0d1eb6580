/* SPDX-License-Identifier: Apache-2.0 */
#include "math/places.h"
#include "base/array.h"
#include "base/error.h"

#include <stdlib.h>

static size_t find_slot(const struct places *m, uint64_t key)
{
    uint64_t h = (key ^ key >> 30) * 0xbf58476d1ce4e5b9u; /* Steele, Lea and Flood 2014 */
    h = (h ^ h >> 27) * 0x94d049bb133111ebu;
    size_t i = (size_t)(h ^ h >> 31) & (m->size - 1);
    while (m->key[i] && m->key[i] != key)
        i = (i + 1) & (m->size - 1);
    return i;
}

static uint64_t key_of(const int32_t x[3])
{
    return ((uint64_t)x[2] << 42 | (uint64_t)x[1] << 21 | (uint64_t)x[0]) + 1;
}

int32_t places_find(const struct places *m, const int32_t x[3])
{
    if (!m->size)
        return -1;
    const size_t i = find_slot(m, key_of(x));
    return m->key[i] ? m->number[i] : -1;
}

static struct error *resize(struct places *m, size_t size)
{
    struct places larger = {.size = size, .count = m->count};
    struct error *err = array_create(&larger.key, size, sizeof *larger.key);
    if (!err)
        err = array_create(&larger.number, size, sizeof *larger.number);
    if (err) {
        free(larger.key);
        return err;
    }
    for (size_t i = 0; i < m->size; i++)
        if (m->key[i]) {
            const size_t slot = find_slot(&larger, m->key[i]);
            larger.key[slot] = m->key[i];
            larger.number[slot] = m->number[i];
        }
    free(m->key);
    free(m->number);
    *m = larger;
    return NULL;
}

struct error *places_add(struct places *m, const int32_t x[3], int32_t number)
{
    struct error *err = 2 * (m->count + 1) > m->size ? resize(m, m->size ? 2 * m->size : 64) : NULL;
    if (err)
        return err;
    const size_t i = find_slot(m, key_of(x));
    m->key[i] = key_of(x);
    m->number[i] = number;
    m->count++;
    return NULL;
}

void places_clear(struct places *m)
{
    free(m->key);
    free(m->number);
    *m = (struct places){0};
}
