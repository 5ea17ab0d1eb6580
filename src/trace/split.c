/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/split.h"
#include "base/array.h"
#include "libprobe-query/sh.h"

#include <stdlib.h>
#include <string.h>

size_t split_light_bytes(const struct split *split)
{
    return split_count(split) * 2 * (sizeof(struct wave_vec) + sizeof(bool));
}

struct error *split_light_init(struct split_light *light, const struct split *split)
{
    *light = (struct split_light){.split = split, .count = split_count(split)};
    struct error *err = array_create(&light->scattered, light->count, sizeof *light->scattered);
    if (!err)
        err = array_create(&light->asked, light->count, sizeof *light->asked);
    if (!err)
        err = array_create(&light->some, light->count, sizeof *light->some);
    if (!err)
        err = array_create(&light->some_asked, light->count, sizeof *light->some_asked);
    return err;
}

void split_light_clear(struct split_light *light)
{
    free(light->scattered);
    free(light->asked);
    free(light->some);
    free(light->some_asked);
    *light = (struct split_light){0};
}

void split_light_start(struct split_light *light)
{
    memset(light->some, 0, light->count * sizeof *light->some);
}

static void add(struct wave_vec *to, bool *some, size_t i, struct vec3f rgb)
{
    if (!*some)
        memset(to, 0, sizeof *to);
    *some = true;
    wave_put(to, i, vec3f_add(wave_get(to, i), rgb));
}

void split_add(struct split_light *light, size_t part, size_t sample, struct vec3f rgb)
{
    add(&light->scattered[part], &light->some[part], sample, rgb);
}

void split_add_sky(struct split_light *light, size_t sample, struct vec3f direction,
                   struct vec3f throughput)
{
    const int order = light->split->sky_order;
    const size_t first = split_sky(light->split);
    double y[SH_COUNT_MAX];
    if (!order)
        return;
    sh_basis(order,
             (const double[3]){(double)direction.x, (double)direction.y, (double)direction.z}, y);
    for (size_t j = 0; j < (size_t)(order * order); j++)
        split_add(light, first + j, sample, vec3f_scale((float)y[j], throughput));
}

void split_ask(struct split_light *light, size_t part, size_t path, struct vec3f rgb)
{
    add(&light->asked[part], &light->some_asked[part], path, rgb);
}

void split_scatter(struct split_light *light, size_t paths, const struct wave_vec *throughput,
                   const uint32_t *sample)
{
    for (size_t p = 0; p < light->count; p++) {
        if (!light->some_asked[p])
            continue;
        light->some_asked[p] = false;
        for (size_t i = 0; i < paths; i++)
            split_add(light, p, sample[i],
                      vec3f_mul(wave_get(throughput, i), wave_get(&light->asked[p], i)));
    }
}
