/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/probe_split.h"
#include "base/array.h"

#include <math.h>
#include <stdlib.h>

size_t probe_split_bytes(const struct split *split)
{
    return split_light_bytes(split) +
           split_count(split) * (sizeof(struct strata) + 3 * SH_COUNT_MAX * sizeof(double));
}

struct error *probe_split_init(struct probe_split *p, const struct split *split, int order)
{
    const size_t count = split_count(split);
    *p = (struct probe_split){
        .split = split, .order = order, .functions = order ? order * order : 1};
    struct error *err = split_light_init(&p->light, split);
    if (!err)
        err = array_create(&p->strata, count, sizeof *p->strata);
    if (!err)
        err = array_create(&p->certain, count * 3 * (size_t)p->functions, sizeof *p->certain);
    for (size_t i = 0; i < count && !err; i++)
        strata_start(&p->strata[i], order, false);
    return err;
}

void probe_split_clear(struct probe_split *p)
{
    split_light_clear(&p->light);
    free(p->strata);
    free(p->certain);
    *p = (struct probe_split){0};
}

/* Adds the light of a wave to the parts that have some. solid_angle NULL: 1. */
static void add_wave(struct probe_split *p, struct strata_wave *wave, size_t fours,
                     const float *solid_angle)
{
    struct vec3f light[PATH_WAVE];
    for (size_t part = 0; part < p->light.count; part++) {
        if (!p->light.some[part])
            continue;
        for (size_t i = 0; i < 4 * fours; i++)
            light[i] = vec3f_scale(solid_angle ? solid_angle[i] : 1,
                                   wave_get(&p->light.scattered[part], i));
        strata_add_again(&p->strata[part], wave, fours, light);
    }
}

void probe_split_own(struct probe_split *p, struct strata_wave *wave, size_t fours,
                     const struct vec3f *direction, const struct path_sample *met,
                     const float *solid_angle, bool straight)
{
    for (size_t i = 0; i < 4 * fours && straight; i++) {
        if (!met[i].hit)
            split_add_sky(&p->light, i, direction[i], (struct vec3f){1, 1, 1});
        if (p->split->groups && p->light.straight[i] != GROUP_NONE)
            split_add(&p->light, p->light.straight[i], i,
                      vec3f_scale(met[i].weight, met[i].straight));
    }
    add_wave(p, wave, fours, solid_angle);
}

void probe_split_asked(struct probe_split *p, struct strata_wave *wave, size_t fours,
                       const struct path_found *found)
{
    if (!p->split->groups)
        return;
    split_light_start(&p->light);
    for (size_t i = 0; i < 4 * fours; i++)
        if (vec3f_most(found[i].light) > 0)
            split_add(&p->light, found[i].group, i, found[i].light);
    add_wave(p, wave, fours, NULL);
}

void probe_split_certain(struct probe_split *p, size_t part, const double *function,
                         const double rgb[3], double visible)
{
    double *to = p->certain + part * 3 * (size_t)p->functions;
    for (int k = 0; k < 3 * p->functions; k++)
        to[k] += visible * function[k / 3] * rgb[k % 3];
}

bool probe_split_found(const struct probe_split *p, size_t part)
{
    for (int k = 0; k < 3 * p->functions; k++)
        if (strata_variance(&p->strata[part], k % 3, k / 3) > 0 ||
            strata_sum(&p->strata[part], k % 3, k / 3) > 0)
            return true;
    return false;
}

void probe_split_finish(const struct probe_split *p, int rays, float *light, float *error)
{
    const size_t width = 3 * (size_t)p->functions;
    for (size_t part = 0; part < p->light.count; part++)
        for (size_t k = 0; k < width; k++) {
            const struct strata *s = &p->strata[part];
            const int c = (int)(k % 3), i = (int)(k / 3);
            light[part * width + k] =
                (float)(strata_sum(s, c, i) / rays + p->certain[part * width + k]);
            error[part * width + k] = (float)(sqrt(strata_variance(s, c, i)) / rays);
        }
}
