/* SPDX-License-Identifier: Apache-2.0 */
#include "trace/seen.h"
#include "base/array.h"
#include "base/error.h"
#include "interpolate/interpolate.h"
#include "interpolate/scatter.h"
#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

enum { RADIUS_MOST = 4 }; /* of the search for a seen probe, in scatter_spacing */

struct seen {
    const struct tracer *tracer;
    const double *position;
    const float *light;
    size_t width;
    struct scatter *scatter; /* owned */
    double spacing;
};

static bool is_dark(const void *context, size_t probe)
{
    const struct seen *seen = context;
    return seen->light && isnan(seen->light[probe * seen->width]);
}

struct error *seen_create(struct seen **seen, const struct tracer *tracer, size_t probes,
                          const double *position, const float *light, size_t width)
{
    struct seen *s = NULL;
    *seen = NULL;
    struct error *err = array_create(&s, 1, sizeof *s);
    if (err)
        return err;
    *s = (struct seen){.tracer = tracer, .position = position, .light = light, .width = width};
    err = scatter_create(&s->scatter, probes, position, is_dark, s);
    if (err) {
        seen_destroy(s);
        return err;
    }
    s->spacing = scatter_spacing(s->scatter);
    *seen = s;
    return NULL;
}

void seen_destroy(struct seen *seen)
{
    if (!seen)
        return;
    scatter_destroy(seen->scatter);
    free(seen);
}

void seen_look_again(const struct tracer *tracer, const double *position, const double p[3],
                     const struct probe_place *known, const struct seen_look *seen,
                     const struct probe_place *place, struct seen_look *look)
{
    *look = (struct seen_look){0};
    for (int i = 0; i < 4; i++) {
        int k = 0;
        if (!(place->weight[i] > 0))
            continue;
        while (seen && k < 4 && !(known->weight[k] > 0 && known->probe[k] == place->probe[i]))
            k++;
        look->visible[i] = seen && k < 4 ? seen->visible[k]
                                         : (double)trace_visibility(
                                               tracer, p, position + 3 * (size_t)place->probe[i]);
        look->share += place->weight[i] * look->visible[i];
        look->unseen += place->weight[i] * (1 - look->visible[i]);
    }
    look->blind = !(look->share > 1e-9);
}

void seen_look(const struct tracer *tracer, const double *position, const double p[3],
               const struct probe_place *place, struct seen_look *look)
{
    seen_look_again(tracer, position, p, NULL, NULL, place, look);
}

/* The search for the nearest probe that a point sees. */
struct search {
    const struct seen *seen;
    const double *p;
    double from, nearest; /* nearer ones than `from` were asked before */
    int32_t probe;        /* -1: none yet */
};

static void ask(void *context, int32_t probe, double distance)
{
    struct search *s = context;
    const struct seen *seen = s->seen;
    const bool nearer = distance < s->nearest || (distance == s->nearest && probe < s->probe);
    if (distance < s->from || !nearer ||
        !(trace_visibility(seen->tracer, s->p, seen->position + 3 * (size_t)probe) > 0))
        return;
    s->nearest = distance;
    s->probe = probe;
}

int32_t seen_nearest(const struct seen *seen, const double p[3])
{
    struct search s = {.seen = seen, .p = p, .nearest = (double)INFINITY, .probe = -1};
    for (int turn = 1; turn <= RADIUS_MOST && s.probe < 0; turn *= 2) {
        scatter_within(seen->scatter, p, turn * seen->spacing, ask, &s);
        s.from = turn * seen->spacing;
    }
    return s.probe;
}

double seen_spacing(const struct seen *seen)
{
    return seen->spacing / 2;
}

void seen_blend(const struct seen *seen, const double p[3], const struct seen_look *look,
                struct probe_place *place)
{
    if (!look->blind) {
        for (int i = 0; i < 4 && look->unseen > 0; i++)
            place->weight[i] *= look->visible[i] / look->share;
        return;
    }
    const int32_t probe = seen_nearest(seen, p);
    for (int i = 0; i < 4 && probe >= 0; i++) {
        place->probe[i] = probe;
        place->weight[i] = i == 0;
    }
}

static void see(const void *own, const double p[3], struct probe_place *place)
{
    const struct seen *seen = own;
    struct seen_look look;
    seen_look(seen->tracer, seen->position, p, place, &look);
    seen_blend(seen, p, &look, place);
}

struct error *seen_join(struct seen **seen, const struct tracer *tracer, size_t probes,
                        struct interpolate *in)
{
    struct error *err = seen_create(seen, tracer, probes, in->position, in->value, in->width);
    if (err)
        return err;
    const struct interpolate_sight sight = {.see = see, .own = *seen};
    return interpolate_set_sight(in, &sight);
}
