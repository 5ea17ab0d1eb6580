/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/ask_lit.h"
#include "base/array.h"
#include "base/error.h"
#include "trace/lit.h"

#include <stdlib.h>
#include <string.h>

static void ask_wave(const struct ask_lit *ask, int count, size_t now, const int *place,
                     struct path_found *found, size_t *cluster)
{
    struct random random[PATH_WAVE];
    double x[PATH_WAVE];
    for (size_t i = 0; i < now; i++) {
        random[i] = random_start(ask->seed, ask->name, ask->first + (uint32_t)place[i]);
        x[i] = (place[i] + random_double(&random[i])) / count;
    }
    path_lit(ask->path, ask->lit, ask->receiver, ask->sum, now, x, random, found, cluster);
}

/* Learns from `count` questions; those that count go on alike where none is answered. */
static struct error *learn(struct ask_lit *ask, const struct lit *lit, int count)
{
    const size_t clusters = lit_clusters(lit);
    uint32_t *asked = NULL;
    double *const sum = ask->sum, *spread = NULL;
    bool some = false;
    struct error *err = array_create(&asked, 2 * clusters, sizeof *asked);
    if (!err)
        err = array_create(&spread, clusters, sizeof *spread);
    if (!err) {
        lit_spread(lit, sum, spread);
        ask->sum = spread;
    }
    for (int first = 0; first < count && !err; first += PATH_WAVE) {
        const int now = count - first < PATH_WAVE ? count - first : PATH_WAVE;
        struct path_found found[PATH_WAVE];
        size_t cluster[PATH_WAVE];
        int place[PATH_WAVE];
        for (int i = 0; i < now; i++)
            place[i] = first + i;
        ask_wave(ask, count, (size_t)now, place, found, cluster);
        for (int i = 0; i < now; i++) {
            const bool seen = vec3f_most(found[i].light) > 0;
            asked[cluster[i]]++;
            asked[clusters + cluster[i]] += seen;
            some = some || seen;
        }
    }
    ask->sum = sum;
    if (!err && !some)
        memcpy(sum, spread, clusters * sizeof *sum);
    else if (!err)
        lit_learn(lit, asked, asked + clusters, sum);
    free(spread);
    ask->first += (uint32_t)count;
    free(asked);
    return err;
}

struct error *ask_lit_start(struct ask_lit *ask, int questions)
{
    const struct lit *lit = ask->lit;
    ask->receiver->lit = false;
    ask->sum = NULL;
    if (!lit || !lit_is_of(lit, ask->path->tracer))
        return NULL;
    const size_t clusters = lit_clusters(lit);
    struct error *err = array_create(&ask->sum, clusters, sizeof *ask->sum);
    if (err)
        return err;
    lit_weigh(lit, &ask->receiver->at, ask->sum);
    ask->receiver->lit = ask->sum[clusters - 1] > 0;
    return ask->receiver->lit ? learn(ask, lit, questions) : NULL;
}

void ask_lit_end(struct ask_lit *ask)
{
    free(ask->sum);
    ask->sum = NULL;
}

void ask_lit_wave(const struct ask_lit *ask, int count, size_t now, const int *place,
                  struct path_found *found)
{
    size_t cluster[PATH_WAVE];
    ask_wave(ask, count, now, place, found, cluster);
}
