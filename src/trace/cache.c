/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/cache.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/discs.h"
#include "trace/lit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK = 64 }; /* discs that a thread takes at once */

/* Light is passed on until this share of the brightest changes no more. */
static const float settled = 1e-5f;

struct solve {
    size_t discs;
    int rays;
    const float *direct, *from;
    const struct cache_link *link;
    float *to;
    float *change, *most; /* of each chunk */
};

static void gather(const struct solve *s, size_t i, float sum[3])
{
    const struct cache_link *link = s->link + i * (size_t)s->rays;
    sum[0] = sum[1] = sum[2] = 0;
    for (int r = 0; r < s->rays; r++) {
        if (link[r].disc == CACHE_NONE)
            continue;
        const float *e = s->from + 3 * (size_t)link[r].disc;
        for (int k = 0; k < 3; k++)
            sum[k] += link[r].share[k] * e[k];
    }
}

static struct error *pass_on(void *context, size_t chunk, int thread)
{
    (void)thread;
    const struct solve *s = context;
    float change = 0, most = 0;
    for (size_t i = chunk * CHUNK; i < s->discs && i < (chunk + 1) * CHUNK; i++) {
        float sum[3];
        gather(s, i, sum);
        for (size_t k = 3 * i; k < 3 * i + 3; k++) {
            s->to[k] = s->direct[k] + sum[k - 3 * i] / (float)s->rays;
            change = fmaxf(change, fabsf(s->to[k] - s->from[k]));
            most = fmaxf(most, s->to[k]);
        }
    }
    s->change[chunk] = change;
    s->most[chunk] = most;
    return NULL;
}

struct error *cache_solve(size_t discs, int rays, const float *straight, const float *direct,
                          const struct cache_link *link, int scatters, int threads, float *value)
{
    const size_t chunks = (discs + CHUNK - 1) / CHUNK;
    struct solve s = {.discs = discs, .rays = rays, .direct = direct, .link = link};
    float *other = NULL, *from = value;
    struct error *err = array_create(&other, 3 * discs, sizeof *other);
    if (!err)
        err = array_create(&s.change, 2 * chunks, sizeof *s.change);
    memcpy(value, straight ? straight : direct, 3 * discs * sizeof *value);
    float *to = other;
    for (int i = straight ? 0 : 1; i < scatters && !err; i++) {
        float change = 0, most = 0;
        s.from = from;
        s.to = to;
        s.most = s.change + chunks;
        err = threads_for(threads, chunks, pass_on, &s);
        for (size_t c = 0; c < chunks && !err; c++) {
            change = fmaxf(change, s.change[c]);
            most = fmaxf(most, s.most[c]);
        }
        to = from;
        from = s.to;
        if (!(change > settled * most))
            break;
    }
    if (!err && from != value)
        memcpy(value, from, 3 * discs * sizeof *value);
    free(s.change);
    free(other);
    return err;
}

void cache_clear(struct path_cache *cache)
{
    discs_destroy(cache->discs);
    free(cache->value);
    lit_destroy(cache->lit);
    *cache = (struct path_cache){0};
}
