/* SPDX-License-Identifier: Apache-2.0 */
#include "bake/plan.h"
#include "base/error.h"
#include "base/options.h"

#include <stdio.h>
#include <string.h>

const char *const plan_quality_names[] = {
    [PLAN_DRAFT] = "draft", [PLAN_GOOD] = "good", [PLAN_BEST] = "best", NULL};

/* -- what a quality means --------------------------------------------------------------------- */

struct quality {
    const char *probes, *gain; /* adaptive: at most; fewer where twice as many gain less */
    const char *grid;          /* probes of a grid, for a scene without volume */
    const char *aim;           /* rays that placing looks with */
    const char *noise;         /* of its probes, as a share of the error */
    const char *rays, *order;  /* rays: of the grid */
    const char *points, *truth_rays, *size;
    const char *samples, *few; /* of a path-traced picture, and of one by the probes alone */
};

static const struct quality qualities[] = {
    [PLAN_DRAFT] = {.probes = "120",
                    .grid = "400",
                    .aim = "64",
                    .noise = "100%",
                    .rays = "1024",
                    .order = "3",
                    .points = "200",
                    .truth_rays = "512",
                    .size = "320x180",
                    .samples = "32",
                    .few = "4"},
    [PLAN_GOOD] = {.probes = "500",
                   .gain = "3%",
                   .grid = "2000",
                   .aim = "128",
                   .noise = "50%",
                   .rays = "2048",
                   .order = "3",
                   .points = "500",
                   .truth_rays = "2048",
                   .size = "480x270",
                   .samples = "64",
                   .few = "16"},
    [PLAN_BEST] = {.probes = "2500",
                   .gain = "2%",
                   .grid = "8000",
                   .aim = "256",
                   .noise = "50%",
                   .rays = "4096",
                   .order = "5",
                   .points = "1000",
                   .truth_rays = "4096",
                   .size = "800x450",
                   .samples = "128",
                   .few = "16"},
};

/* -- routes ----------------------------------------------------------------------------------- */

enum {
    TO_GRID = 1 << 8, /* of probe-place, by its method */
    TO_ADAPTIVE = 1 << 9,
    TO_PLACE = TO_GRID | TO_ADAPTIVE,
    TO_CAPTURE = 1 << PLAN_CAPTURE,
    TO_TET = 1 << PLAN_TET,
    TO_LEAKFIX = 1 << PLAN_LEAKFIX,
    TO_ERROR = 1 << PLAN_ERROR,
    TO_PACK = 1 << PLAN_PACK,
    TO_PICTURES = 1 << PLAN_PAIR | 1 << PLAN_PROBES,
    TO_LIGHT = TO_ADAPTIVE | TO_CAPTURE, /* who looks at light; the header tells the others */
    TO_ALL = TO_PLACE | TO_CAPTURE | TO_TET | TO_LEAKFIX | TO_ERROR | TO_PACK | TO_PICTURES,
    UNSHOWN = 1 << 10 /* it changes no result */
};

/* Where an option goes. */
struct route {
    const char *name;
    unsigned to;
    const char *in_error; /* its name there; NULL: the same */
};

static const struct route routes[] = {
    /* where probes may be */
    {"bounds", TO_PLACE | TO_ERROR, NULL},
    {"reach", TO_PLACE | TO_ERROR, NULL},
    {"radius", TO_PLACE | TO_ERROR, "body-radius"},
    {"height", TO_PLACE | TO_ERROR, NULL},
    {"climb", TO_PLACE | TO_ERROR, NULL},
    {"drop", TO_PLACE | TO_ERROR, NULL},
    {"headroom", TO_PLACE | TO_ERROR, NULL},
    {"cell", TO_PLACE | TO_ERROR, NULL},
    {"fly", TO_PLACE | TO_ERROR, NULL},
    {"max-cells", TO_PLACE | TO_ERROR, NULL},
    /* how many */
    {"max-error", TO_ADAPTIVE, NULL},
    {"probes", TO_ADAPTIVE, NULL},
    {"count", TO_GRID, NULL},
    {"bytes", TO_ADAPTIVE, NULL},
    {"gain", TO_ADAPTIVE, NULL},
    /* their light */
    {"rays", TO_CAPTURE, NULL},
    {"order", TO_LIGHT, NULL},
    {"bounces", TO_LIGHT, NULL},
    {"light", TO_LIGHT, NULL},
    {"dering", TO_CAPTURE, NULL},
    {"groups", TO_CAPTURE, NULL},
    {"transfer", TO_CAPTURE, NULL},
    {"cache", TO_CAPTURE, NULL}, /* leakfix has it from the header */
    {"cache-error", TO_CAPTURE, NULL},
    {"cache-after", TO_CAPTURE, NULL},
    {"cache-renew", TO_CAPTURE | TO_LEAKFIX, NULL},
    {"seed", TO_LIGHT, NULL},
    /* how the scene's file is read: the header tells who comes behind */
    {"lenient", TO_PLACE, NULL},
    {"exclude", TO_PLACE, NULL},
    {"only", TO_PLACE, NULL},
    /* of the work */
    {"text", TO_LEAKFIX, NULL},
    {"binary", TO_LEAKFIX, NULL},
    {"threads", TO_ALL | UNSHOWN, NULL},
    {"progress", TO_PLACE | TO_CAPTURE | TO_LEAKFIX | TO_ERROR | TO_PICTURES | UNSHOWN, NULL},
    {"quiet", TO_PLACE | TO_CAPTURE | TO_TET | TO_LEAKFIX | UNSHOWN, NULL},
    /* ours alone */
    {"quality", 0, NULL},
    {"output", 0, NULL},
    {"report", 0, NULL},
    {"pack", 0, NULL},
    {"dry-run", 0, NULL},
};

/* What has no route is the scene's light. */
static const struct route *route_of(const char *name)
{
    static const struct route light = {NULL, TO_LIGHT, NULL};
    for (size_t i = 0; i < sizeof routes / sizeof *routes; i++)
        if (!strcmp(routes[i].name, name))
            return &routes[i];
    return &light;
}

/* -- words ------------------------------------------------------------------------------------ */

const struct option_given *plan_given(const struct plan_job *job, const char *name)
{
    for (size_t i = job->given_count; i-- > 0;)
        if (!strcmp(job->given[i].row->name, name))
            return &job->given[i];
    return NULL;
}

/* The quality's word, where the command line has none. */
static void add_usual(const struct plan_job *job, struct words *words, const char *name,
                      const char *text)
{
    if (text && !plan_given(job, name))
        words_add_option(words, name, text);
}

static void add_given(const struct plan_job *job, struct words *words, unsigned to)
{
    for (size_t i = 0; i < job->given_count; i++) {
        const char *name = job->given[i].row->name;
        const struct route *route = route_of(name);
        const bool renamed = to & TO_ERROR && route->in_error;
        if (route->to & to && !(job->shown && route->to & UNSHOWN))
            words_add_option(words, renamed ? route->in_error : name, job->given[i].text);
    }
}

static void add_light(const struct plan_job *job, struct words *words)
{
    if (!job->day)
        return;
    words_add_option(words, "sky", PLAN_DAY_SKY);
    words_add_option(words, "sun", PLAN_DAY_SUN);
}

static void place(const struct plan_job *job, const struct quality *q, struct words *words)
{
    const struct option_given *probes = plan_given(job, "probes");
    if (job->flat) {
        words_add(words, "grid");
        words_add_option(words, "count", probes ? probes->text : q->grid);
        add_given(job, words, TO_GRID);
        words_add_file(words, job->scene);
        return;
    }
    words_add(words, "adaptive");
    if (!probes && !plan_given(job, "max-error") && !plan_given(job, "bytes")) {
        words_add_option(words, "probes", q->probes);
        if (q->gain)
            words_add_option(words, "gain", q->gain);
    }
    /* where to put probes few rays tell; how many these need is found out, unless it is told */
    words_add_option(words, "rays", q->aim);
    words_add_option(words, "noise", plan_given(job, "rays") ? "0" : q->noise);
    add_usual(job, words, "order", q->order);
    add_light(job, words);
    add_given(job, words, TO_ADAPTIVE);
    words_add_file(words, job->scene);
}

static void capture(const struct plan_job *job, const struct quality *q, struct words *words)
{
    if (job->flat)
        add_usual(job, words, "rays", q->rays);
    add_usual(job, words, "order", q->order);
    add_light(job, words);
    add_given(job, words, TO_CAPTURE); /* --rays, too; without them adaptive's light stays */
    words_add_file(words, job->scene);
}

static void leakfix(const struct plan_job *job, struct words *words)
{
    add_given(job, words, TO_LEAKFIX);
    if (strcmp(job->output, "-") != 0)
        words_add_option(words, "output", job->output);
    words_add_file(words, job->scene);
}

static void error(const struct plan_job *job, const struct quality *q, struct words *words)
{
    words_add(words, "--tsv");
    words_add_option(words, "paths", "0");
    words_add_option(words, "points", q->points);
    words_add_option(words, "truth-rays", q->truth_rays);
    if (!job->shown)
        words_add(words, "--quiet");
    add_given(job, words, TO_ERROR);
    words_add_file(words, job->scene);
    words_add_file(words, job->baked);
}

static void pack(const struct plan_job *job, struct words *words)
{
    words_add_option(words, "pack", "float");
    if (!job->shown)
        words_add(words, "--quiet");
    add_given(job, words, TO_PACK);
    words_add_option(words, "output", job->packed);
    words_add_file(words, job->baked);
}

static void picture(const struct plan_job *job, const struct quality *q, bool pair,
                    struct words *words)
{
    const struct option_given *light = plan_given(job, "light");
    const bool mixed = light && !strcmp(light->text, "indirect");
    words_add_option(words, "mode", pair ? "pair" : mixed ? "mixed" : "probes");
    if (!pair) {
        words_add_option(words, "draw-probes", "auto");
        if (job->exposure)
            words_add_option(words, "exposure", job->exposure);
    }
    words_add_option(words, "samples", pair || mixed ? q->samples : q->few);
    words_add_option(words, "size", q->size);
    if (!job->shown)
        words_add(words, "--quiet");
    add_given(job, words, TO_PICTURES);
    words_add_option(words, "output", pair ? job->pair : job->probes);
    words_add_file(words, job->scene);
    words_add_file(words, job->baked);
}

struct error *plan_stage(const struct plan_job *job, enum plan_stage which,
                         struct pipe_stage *stage)
{
    const struct quality *q = &qualities[job->quality];
    struct words *words = &stage->words;
    switch (which) {
    case PLAN_PLACE:
        stage->name = "place";
        place(job, q, words);
        /* whose light is traced behind it */
        stage->keeps = !job->flat && !plan_given(job, "rays") && !plan_given(job, "cache");
        break;
    case PLAN_CAPTURE:
        stage->name = "capture";
        capture(job, q, words);
        break;
    case PLAN_TET:
        stage->name = "tet";
        add_given(job, words, TO_TET);
        break;
    case PLAN_LEAKFIX:
        stage->name = "leakfix";
        leakfix(job, words);
        break;
    case PLAN_ERROR:
        stage->name = "error";
        error(job, q, words);
        break;
    case PLAN_PACK:
        stage->name = "query";
        pack(job, words);
        break;
    case PLAN_PAIR:
    case PLAN_PROBES:
        stage->name = "render";
        picture(job, q, which == PLAN_PAIR, words);
        break;
    case PLAN_ALL: break;
    }
    struct error *err = words->err;
    words->err = NULL;
    return err;
}
