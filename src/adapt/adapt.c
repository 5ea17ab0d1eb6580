/* SPDX-License-Identifier: Apache-2.0 */
#include "adapt/adapt.h"
#include "adapt/choice.h"
#include "adapt/gains.h"
#include "adapt/insert.h"
#include "adapt/move.h"
#include "adapt/thin_out.h"
#include "base/array.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/interrupt.h"
#include "base/memory.h"
#include "base/progress.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "math/vec.h"
#include "trace/path.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST = 4, START = 20 }; /* probes that are far apart: of the first choice, of the second */
enum { SPACE_OF_PROBE = 10 };   /* candidates of space for each probe that is wanted, */
enum { SPACE_OF_FEW = 20 };     /* and for each of the first, */
enum { FEW = 2000 };            /* of which there are so many */
enum { WANTED_LEAST = 75 };     /* probes that there are candidates for, at the least */
enum { WANTED_FIRST = 1000 };   /* and at first, at the most: so that there is soon what to keep */
enum { TURNS = 3 };
enum { MOVES = 40, IDLE = 3 }; /* times that probes are moved; that this pays little */
enum { TRIES = 3 };            /* at having fewer probes for the same error */

static const double ROUND_SHARE = 0.2; /* probes that come in a round, of those there are */
static const double LOOK_EVERY = 1.5;  /* as many probes as at the last look */
static const double TURN_SHARE = 0.15; /* and that go in a turn */
static const double GAIN_SHARE = 0.1;  /* of the largest gain of a round, that a probe must have */
static const double FLAT_SHARE = 0.05; /* of the error, that twice the probes must take off it */
static const double UNSEEN = 0.02;     /* errors that nobody sees */
static const double FLAT = 0.003;      /* turns end where the error falls by less than this share */
static const double LITTLE = 0.001;    /* and moves are of little use */
static const double NOISY = 0.3;       /* error that noise is a share of at first */
static const double QUIET = 0.7; /* of the noise that may be: what is asked for, for a while */

/* What was chosen when it was looked at. */
struct looked {
    size_t probes;
    uint32_t *probe; /* owned */
    float *judge;    /* squares of the errors of the judges, in order; owned */
    size_t judges;
    struct choice_errors told, quick; /* by sight; by what each point sees */
};

/* A run: what was chosen so far. */
struct run {
    const struct adapt_job *job;
    struct adapt_result *result;
    struct candidates_job own; /* the job's, with the progress from look to look */
    struct candidates candidates;
    struct gains gains;
    struct seen_known seen;
    struct moves moves;
    struct choice_world world;
    struct choice now;
    struct looked *looked; /* as `rows` of the result */
    size_t room;
    uint32_t *start; /* the first probes, after the given ones; owned */
    size_t starts;
    double began;
    bool full; /* the last round would have made too many bytes */
};

/* -- the start -------------------------------------------------------------------------------- */

static double square_distance(const struct candidates *c, uint32_t a, uint32_t b)
{
    const struct vec3 d =
        vec3_sub(vec3_load(c->position + 3 * (size_t)a), vec3_load(c->position + 3 * (size_t)b));
    return vec3_dot(d, d);
}

/* How far a candidate is off what the first `count` (1 to 3) of the start span, squared. */
static double square_off(const struct candidates *c, const uint32_t *start, size_t count,
                         uint32_t x)
{
    const struct vec3 o = vec3_load(c->position + 3 * (size_t)start[0]);
    struct vec3 d = vec3_sub(vec3_load(c->position + 3 * (size_t)x), o), axis[2];
    for (size_t k = 1; k < count; k++) {
        struct vec3 *a = &axis[k - 1];
        *a = vec3_sub(vec3_load(c->position + 3 * (size_t)start[k]), o);
        if (k == 2)
            *a = vec3_fma(*a, -vec3_dot(*a, axis[0]), axis[0]);
        *a = vec3_normalize(*a);
        d = vec3_fma(d, -vec3_dot(d, *a), *a);
    }
    return vec3_dot(d, d);
}

static bool can_start(const struct candidates *c, uint32_t x)
{
    return c->kind[x] == CANDIDATE_SPACE || c->kind[x] == CANDIDATE_SURFACE;
}

/* Four that span the free space, then always the farthest from all: of given ones too. */
static struct error *find_start(struct run *run)
{
    const struct candidates *c = &run->candidates;
    const size_t given = run->job->given;
    double *nearest = NULL;
    struct error *err = array_create(&nearest, c->count, sizeof *nearest);
    if (!err)
        err = array_create(&run->start, START, sizeof *run->start);
    for (uint32_t x = 0; x < c->count && !err; x++) {
        nearest[x] = (double)INFINITY;
        for (uint32_t g = 0; g < given; g++)
            nearest[x] = fmin(nearest[x], square_distance(c, x, g));
    }
    while (!err && run->starts < START) {
        double most = 0;
        uint32_t best = 0;
        for (uint32_t x = 0; x < c->count; x++) {
            double value = nearest[x];
            const double *p = c->position + 3 * (size_t)x, *low = run->job->candidates.space.low;
            if (!can_start(c, x) || !(value > 0))
                continue;
            if (!run->starts)
                value = 1 / (1e-30 + (p[0] - low[0]) + (p[1] - low[1]) + (p[2] - low[2]));
            else if (run->starts < FIRST)
                value = square_off(c, run->start, run->starts, x);
            if (value > most) {
                most = value;
                best = x;
            }
        }
        if (!(most > 0))
            break;
        run->start[run->starts++] = best;
        for (uint32_t x = 0; x < c->count; x++)
            nearest[x] = fmin(nearest[x], square_distance(c, x, best));
    }
    free(nearest);
    if (!err && run->starts < FIRST)
        err = error_new("the free space has no room for 4 probes that are apart");
    return err;
}

/* -- rounds ----------------------------------------------------------------------------------- */

/* Shows how much was looked at since the last line. */
static void show(struct run *run)
{
    if (!run->own.progress)
        run->own.progress =
            progress_start(run->job->progress, run->job->program, "points looked at", 0);
}

static void hide(struct run *run)
{
    progress_end(run->own.progress);
    run->own.progress = NULL;
}

/* Prints the last row. */
static void tell(struct run *run)
{
    hide(run);
    const struct adapt_row *row = &run->result->row[run->result->rows - 1];
    if (run->job->program)
        fprintf(stderr, "%s: %zu probes: error %.2f %% (held out %.2f, %.2f to %.2f), %.1f s\n",
                run->job->program, row->probes, 100 * row->space, 100 * row->judges,
                100 * (row->judges - 1.96 * row->doubt), 100 * (row->judges + 1.96 * row->doubt),
                row->seconds);
}

static const struct looked *last_looked(const struct run *run)
{
    return run->result->rows ? &run->looked[run->result->rows - 1] : NULL;
}

/* Remembers a choice and the squares of the errors of all candidates. */
static struct error *remember(struct looked *looked, const struct choice *choice,
                              const float *square)
{
    const struct candidates *c = choice->world.candidates;
    looked->probes = choice->count;
    looked->quick = choice->errors;
    struct error *err = array_create(&looked->probe, choice->count, sizeof *looked->probe);
    if (!err)
        err = array_create(&looked->judge, c->judges, sizeof *looked->judge);
    if (err)
        return err;
    memcpy(looked->probe, choice->probe, choice->count * sizeof *looked->probe);
    for (size_t x = 0; x < choice->candidates; x++)
        if (c->kind[x] == CANDIDATE_JUDGE)
            looked->judge[looked->judges++] = square[x];
    return NULL;
}

/* Makes a choice, whatever it was made for, the one that there is. */
static void put(struct run *run, struct choice *choice)
{
    choice_clear(&run->now);
    run->now = *choice;
    *choice = (struct choice){0};
}

/* What noise may be where the error is this. */
static double noise_of(const struct run *run, double error)
{
    return run->job->noise * fmax(error, fmax(run->job->limits.error, UNSEEN));
}

/* Captures what is chosen anew where its noise is no small share of the error; *quiet: it is. */
static struct error *quieten(struct run *run, double error, bool *quiet)
{
    struct choice same = {0};
    const double most = noise_of(run, error);
    *quiet = !(run->job->noise > 0) || run->candidates.noise <= most;
    if (*quiet)
        return NULL;
    candidates_set_noise(&run->candidates, fmax(QUIET * most, noise_of(run, 0)));
    struct error *err = choice_init(&same, &run->world, run->now.count, run->now.probe, NULL);
    if (!err)
        put(run, &same);
    return err;
}

/* Looks at what there is (choice_look) until it is quiet enough. */
static struct error *look_quietly(struct run *run, struct choice_errors *told, float *square)
{
    bool quiet = false;
    struct error *err = NULL;
    while (!err && !quiet) {
        err = choice_look(&run->now, told, square);
        if (!err)
            err = quieten(run, told->judges, &quiet);
    }
    return err;
}

/* Says at once that SH of this order leave more than the error that is asked for. */
static struct error *tell_least(const struct run *run)
{
    const double asked = run->job->limits.error;
    double least = 0;
    struct error *err = asked > 0 ? choice_least_error(&run->now, &least) : NULL;
    if (!err && least > asked && run->job->program)
        fprintf(stderr,
                "%s: SH of order %d leave %.2f %% of error wherever probes are, more than the "
                "%.2f %% asked for: a higher --order leaves less\n",
                run->job->program, run->job->candidates.settings->order, 100 * least, 100 * asked);
    return err;
}

/* Looks, and tells it. */
static struct error *look(struct run *run)
{
    struct adapt_result *r = run->result;
    const struct choice *now = &run->now;
    float *square = NULL;
    struct error *err = array_reserve(&r->row, &r->room, r->rows + 1, sizeof *r->row);
    if (!err)
        err = array_reserve(&run->looked, &run->room, r->rows + 1, sizeof *run->looked);
    if (!err)
        err = array_create(&square, now->candidates, sizeof *square);
    struct looked looked = {0};
    if (!err)
        err = look_quietly(run, &looked.told, square);
    if (!err)
        err = remember(&looked, now, square);
    free(square);
    if (err) {
        free(looked.probe);
        free(looked.judge);
        return err;
    }
    run->looked[r->rows] = looked;
    r->row[r->rows++] =
        (struct adapt_row){.probes = now->count,
                           .bytes = choice_bytes(now, run->job->candidates.settings->order),
                           .space = looked.told.space,
                           .judges = looked.told.judges,
                           .doubt = looked.told.doubt,
                           .seconds = clock_seconds() - run->began};
    tell(run);
    return r->rows == 1 ? tell_least(run) : NULL;
}

/* Goes back to what was looked at. */
static struct error *go_back(struct run *run, const struct looked *looked)
{
    struct choice next = {0};
    struct error *err = choice_init(&next, &run->world, looked->probes, looked->probe, &run->now);
    if (!err)
        put(run, &next);
    return err;
}

/* The probes of a choice and others. */
static struct error *join(const struct choice *choice, const uint32_t *more, size_t count,
                          uint32_t **all)
{
    struct error *err = array_create(all, choice->count + count, sizeof **all);
    if (err)
        return err;
    memcpy(*all, choice->probe, choice->count * sizeof **all);
    for (size_t i = 0; i < count; i++)
        (*all)[choice->count + i] = more[i];
    return NULL;
}

/* Makes of a choice one with at most `most` probes more; *found: how many came. */
static struct error *insert(struct run *run, const struct choice *from, size_t most,
                            struct choice *to, size_t *found)
{
    uint32_t *more = NULL, *all = NULL;
    double gain = 0;
    *found = 0;
    show(run);
    struct error *err = array_create(&more, most, sizeof *more);
    if (!err)
        err = insert_find(from, most, GAIN_SHARE, more, found, &gain);
    if (!err && *found)
        err = join(from, more, *found, &all);
    if (!err && *found)
        err = choice_init(to, &run->world, from->count + *found, all, from);
    free(more);
    free(all);
    return err;
}

/* How many may come, by the limits. */
static size_t room_for(const struct run *run)
{
    const struct adapt_limits *limits = &run->job->limits;
    const size_t n = run->now.count, probes = run->job->probes_most;
    size_t most = limits->probes && limits->probes < probes ? limits->probes : probes;
    most = most > n ? most - n : 0;
    if (limits->bytes) {
        const double bytes = (double)choice_bytes(&run->now, run->job->candidates.settings->order),
                     left = (double)limits->bytes - bytes, one = 1.02 * bytes / (double)n;
        const size_t fit = left > one ? (size_t)(left / one) : 0;
        most = most < fit ? most : fit;
    }
    return most;
}

/* Whether the last doubling of the number of probes took too little off the error. */
static bool gains_little(const struct run *run)
{
    const struct adapt_result *r = run->result;
    const struct adapt_row *last = &r->row[r->rows - 1];
    for (size_t i = r->rows; i-- > 0;)
        if (2 * r->row[i].probes <= last->probes && r->row[i].probes >= START)
            return 1 - last->space / r->row[i].space < run->job->limits.gain;
    return false;
}

/* How many candidates of space there are for so many probes: few are chosen too well for the errors
 * of as few points as they are to be those of others. */
static size_t space_for(size_t probes)
{
    const size_t few = probes < FEW ? probes : FEW;
    return SPACE_OF_FEW * few + SPACE_OF_PROBE * (probes - few);
}

/* Whether the candidates for so many probes are more than the machine's memory holds. */
static bool is_too_many(size_t wanted)
{
    return candidates_memory(space_for(wanted)) > memory_bytes();
}

/* Refuses to choose more than there is memory for, and tells of how much it takes if it is much. */
static struct error *check_memory(const struct run *run, size_t probes)
{
    enum { MUCH = 1000000000, GB = 1000000000 };
    const double bytes = candidates_memory(space_for(probes));
    if (is_too_many(probes))
        return error_new("%zu probes are chosen of points that take %.1f GB of memory, and there "
                         "are %.1f: expected fewer --probes",
                         probes, bytes / GB, memory_bytes() / GB);
    if (bytes >= MUCH && run->job->program)
        fprintf(stderr,
                "%s: the points that %zu probes are chosen of take up to %.1f GB of "
                "memory\n",
                run->job->program, probes, bytes / GB);
    return NULL;
}

/* Makes more candidates where there are few for the number of probes, and memory for them. */
static struct error *grow(struct run *run, size_t wanted)
{
    struct candidates *c = &run->candidates;
    const struct candidates_job *job = &run->job->candidates;
    struct candidates_job traced = *job;
    if (space_for(wanted) <= c->space)
        return NULL;
    if (c->count && is_too_many(wanted)) {
        warnings_add(job->warnings, "memory",
                     "more points than %zu to choose probes from are more than memory holds: "
                     "probes are chosen of these",
                     c->count);
        return NULL;
    }
    struct error *err = candidates_spread(c, job, space_for(wanted));
    hide(run);
    traced.progress =
        progress_start(run->job->progress, run->job->program, "candidates", c->count - c->captured);
    if (!err)
        err = candidates_capture(c, &traced);
    progress_end(traced.progress);
    return err;
}

static struct error *start(struct run *run)
{
    const struct adapt_job *job = run->job;
    const size_t probes = job->limits.probes,
                 most = probes && probes < job->probes_most ? probes : job->probes_most;
    struct error *err = NULL;
    run->began = clock_seconds();
    if (job->given + FIRST > most)
        return error_new("%zu probes at most, with %zu given ones: expected room for 4 more", most,
                         job->given);
    if (probes)
        err = check_memory(run, most);
    for (size_t i = 0; i < job->given && !err; i++)
        err = candidates_give(&run->candidates, job->position + 3 * i);
    if (!err)
        err = grow(run, probes < WANTED_LEAST   ? WANTED_LEAST
                        : probes > WANTED_FIRST ? WANTED_FIRST
                                                : probes);
    if (!err && interrupt_came() && run->candidates.count < job->given + FIRST)
        return error_new("interrupted before there was anything to keep");
    if (!err && !(run->candidates.floor > 0) && !interrupt_came())
        return error_new("no light reaches the free space: --sky, --sun, --point and --spot add "
                         "light; to a closed scene, a --point within");
    run->world = (struct choice_world){&run->candidates, &job->candidates, &run->gains, &run->seen};
    if (!err && job->noise > 0)
        candidates_set_noise(&run->candidates, noise_of(run, NOISY));
    if (!err)
        err = find_start(run);
    return err;
}

/* The given probes and so many of the start; the caller's to free. */
static struct error *list_start(const struct run *run, size_t starts, uint32_t **all)
{
    const size_t given = run->job->given;
    struct error *err = array_create(all, given + starts, sizeof **all);
    for (size_t i = 0; i < given && !err; i++)
        (*all)[i] = (uint32_t)i;
    for (size_t i = 0; i < starts && !err; i++)
        (*all)[given + i] = run->start[i];
    return err;
}

static struct error *choose_start(struct run *run, size_t starts)
{
    uint32_t *all = NULL;
    struct choice next = {0};
    struct error *err = list_start(run, starts, &all);
    if (!err)
        err = choice_init(&next, &run->world, run->job->given + starts, all, NULL);
    free(all);
    if (!err)
        put(run, &next);
    return err;
}

/* Makes more candidates where there are few for the number of probes, and judges by them. */
static struct error *grow_with(struct run *run)
{
    const size_t before = run->candidates.count, n = run->now.count, most = run->job->limits.probes;
    struct choice next = {0};
    struct error *err = NULL;
    if (space_for(n) > run->candidates.space)
        err = grow(run, most && most < 2 * n ? most : 2 * n);
    if (err || run->candidates.count == before)
        return err;
    if (!err)
        err = choice_init(&next, &run->world, n, run->now.probe, &run->now);
    if (!err)
        put(run, &next);
    return err;
}

static bool is_too_large(const struct run *run, const struct choice *choice)
{
    const size_t most = run->job->limits.bytes;
    return most && choice_bytes(choice, run->job->candidates.settings->order) > most;
}

/* The second choice, of `count` probes that are far apart, or of as many as fit. */
static struct error *begin(struct run *run, size_t count)
{
    struct error *err = choose_start(run, count);
    while (!err && count > FIRST && is_too_large(run, &run->now)) {
        run->full = true;
        err = choose_start(run, --count);
    }
    return err;
}

/* One round; *found: the probes that it brought. */
static struct error *go_round(struct run *run, size_t *found)
{
    const size_t n = run->now.count, room = room_for(run), starts = run->starts - FIRST;
    struct choice next = {0};
    if (n == run->job->given + FIRST && starts)
        return begin(run, FIRST + (room < starts ? room : starts));
    struct error *err = grow_with(run);
    const size_t most = (size_t)(ROUND_SHARE * (double)n) + FIRST;
    if (!err && !interrupt_came())
        err = insert(run, &run->now, most < room ? most : room, &next, found);
    run->full = !err && next.count && is_too_large(run, &next);
    if (!err && next.count && !run->full)
        put(run, &next);
    choice_clear(&next);
    return err;
}

/* Whether the error that was told is at most what was asked for, by the upper end of its interval;
 * and whether that of a choice may be, if it is to what is quickly found as it was. */
static bool is_reached(const struct run *run)
{
    const struct choice_errors *told = &last_looked(run)->told;
    return told->judges + 1.96 * told->doubt <= run->job->limits.error;
}

static bool may_be_reached(const struct run *run, const struct choice *choice)
{
    const struct looked *last = last_looked(run);
    const double ratio = last->quick.judges > 0 ? last->told.judges / last->quick.judges : 1;
    return ratio * (choice->errors.judges + 1.96 * choice->errors.doubt) <= run->job->limits.error;
}

/* The last look at half as many probes or fewer; NULL: there is none. */
static const struct looked *half_ago(const struct run *run)
{
    const size_t least = run->job->given + FIRST, probes = last_looked(run)->probes;
    for (size_t i = run->result->rows; i-- > 0;)
        if (run->looked[i].probes >= least && 2 * run->looked[i].probes <= probes)
            return &run->looked[i];
    return NULL;
}

static bool is_noise(const struct choice_errors *errors)
{
    return errors->judges <= 1.96 * errors->doubt;
}

/* Whether twice the probes took as good as nothing off the errors of the judges, in all likelihood;
 * or what is left of these is no more than its noise, before and now. */
static bool is_flat(const struct run *run)
{
    const struct looked *last = last_looked(run), *before = half_ago(run);
    const struct choice *now = &run->now;
    double n = 0, sum = 0, squares = 0;
    if (!before)
        return false;
    for (size_t x = 0; x < now->candidates && n < (double)before->judges; x++) {
        if (run->candidates.kind[x] != CANDIDATE_JUDGE)
            continue;
        const size_t i = (size_t)n++;
        const double fall = (double)now->weight[x] *
                            ((double)before->judge[i] - (double)last->judge[i]);
        sum += fall;
        squares += fall * fall;
    }
    return (is_noise(&before->told) && is_noise(&last->told)) ||
           ((before->probes >= run->job->given + START || before->told.judges <= UNSEEN) &&
            sum + sqrt(squares) <= FLAT_SHARE * n * fmax(last->told.judges, UNSEEN));
}

static enum adapt_end find_end(const struct run *run, size_t found)
{
    const struct adapt_limits *limits = &run->job->limits;
    const size_t n = run->now.count;
    const bool looked = last_looked(run)->probes == n;
    if (looked && limits->error > 0 && is_reached(run))
        return ADAPT_ERROR;
    if (looked && limits->gain > 0 && gains_little(run))
        return ADAPT_GAIN;
    if (looked && is_flat(run))
        return ADAPT_FLAT;
    if (run->full || !room_for(run))
        return limits->probes && n >= limits->probes ? ADAPT_PROBES
               : n >= run->job->probes_most          ? ADAPT_MOST
                                                     : ADAPT_BYTES;
    if (interrupt_came())
        return ADAPT_INTERRUPT;
    return found ? ADAPT_NONE : ADAPT_FLAT;
}

/* Whether it is time to look again: there are many more probes, or an end may have come. */
static bool is_due(const struct run *run, size_t found)
{
    const struct looked *last = last_looked(run);
    const size_t n = run->now.count;
    return n != last->probes &&
           ((double)n >= LOOK_EVERY * (double)last->probes || !found ||
            (run->job->limits.error > 0 && (may_be_reached(run, &run->now) || !room_for(run))));
}

static struct error *go_rounds(struct run *run)
{
    size_t found = 1;
    struct error *err = choose_start(run, FIRST);
    if (!err && is_too_large(run, &run->now))
        err = error_new("expected room for %d more probes, which take %zu bytes (--bytes)", FIRST,
                        choice_bytes(&run->now, run->job->candidates.settings->order));
    if (!err)
        err = look(run);
    while (!err && !(run->result->end = find_end(run, found))) {
        err = go_round(run, &found);
        if (!err && is_due(run, found))
            err = look(run);
    }
    const struct looked *before =
        !err && run->result->end == ADAPT_FLAT && is_flat(run) ? half_ago(run) : NULL;
    return before ? go_back(run, before) : err;
}

/* -- turns ------------------------------------------------------------------------------------ */

/* What there is without those that are missed least, about so many. */
static struct error *without(const struct run *run, size_t most, struct choice *less)
{
    const struct choice *now = &run->now;
    uint32_t *gone = NULL, *left = NULL;
    bool *goes = NULL;
    size_t count = 0, kept = 0;
    struct error *err = array_create(&gone, most, sizeof *gone);
    if (!err)
        err = array_create(&goes, now->count, sizeof *goes);
    if (!err)
        err = array_create(&left, now->count, sizeof *left);
    if (!err)
        err = thin_out_find(now, most, gone, &count);
    for (size_t i = 0; i < count && !err; i++)
        goes[gone[i]] = true;
    for (size_t i = 0; i < now->count && !err; i++)
        if (!goes[i])
            left[kept++] = now->probe[i];
    if (!err && count && kept >= FIRST)
        err = choice_init(less, &run->world, kept, left, now);
    free(gone);
    free(goes);
    free(left);
    return err;
}

/* Some go, as many others come; *better: the error of space fell by how much of it. */
static struct error *turn(struct run *run, size_t most, double *better)
{
    struct choice turned = {0}, next = {0};
    const double before = run->now.errors.space;
    size_t found = 1;
    *better = 0;
    struct error *err = without(run, most, &turned);
    while (!err && turned.count && turned.count < run->now.count && found && !interrupt_came()) {
        err = insert(run, &turned, run->now.count - turned.count, &next, &found);
        if (!err && found) {
            choice_clear(&turned);
            turned = next;
            next = (struct choice){0};
        }
    }
    if (!err && turned.count == run->now.count && turned.errors.space < before &&
        !is_too_large(run, &turned)) {
        *better = 1 - turned.errors.space / before;
        put(run, &turned);
    }
    choice_clear(&turned);
    return err;
}

/* Makes moves together, takes those back around which the errors did not fall, and the others where
 * these did not in all; *better: by how much they fell, of the error. */
static struct error *make_moves(struct run *run, size_t count, const struct move *move,
                                double *better)
{
    const double before = run->now.errors.space;
    const size_t n = run->now.count;
    struct choice moved = {0}, next = {0};
    uint32_t *all = NULL;
    bool *good = NULL;
    size_t left = 0;
    struct error *err = join(&run->now, NULL, 0, &all);
    if (!err)
        err = array_create(&good, count, sizeof *good);
    for (size_t i = 0; i < count && !err; i++)
        all[move[i].probe] = move[i].candidate;
    if (!err)
        err = choice_init(&moved, &run->world, n, all, &run->now);
    if (!err)
        err = move_judge(&run->now, &moved, &run->moves, count, move, good);
    for (size_t i = 0; i < count && !err; i++) {
        all[move[i].probe] = good[i] ? move[i].candidate : run->now.probe[move[i].probe];
        left += good[i];
    }
    if (!err && left && left < count)
        err = choice_init(&next, &run->world, n, all, &moved);
    if (!err && next.count) {
        choice_clear(&moved);
        moved = next;
    }
    *better = !err && left ? 1 - moved.errors.space / before : 0;
    if (!err && *better > 0 && !is_too_large(run, &moved))
        put(run, &moved);
    choice_clear(&moved);
    free(all);
    free(good);
    return err;
}

/* Moves probes as long as that pays. */
static struct error *go_moves(struct run *run)
{
    struct move *move = NULL;
    struct error *err = array_create(&move, run->now.count, sizeof *move);
    size_t found = 1;
    int idle = 0;
    for (int i = 0; i < MOVES && idle < IDLE && found && !interrupt_came() && !err; i++) {
        double better = 0;
        show(run);
        err = move_find(&run->now, &run->moves, run->now.count, move, &found);
        if (!err && found)
            err = make_moves(run, found, move, &better);
        idle = better > LITTLE ? 0 : idle + 1;
    }
    free(move);
    return err;
}

static struct error *go_turns(struct run *run)
{
    const size_t most = (size_t)(TURN_SHARE * (double)run->now.count) + 1;
    double better = 1;
    struct error *err = NULL;
    for (int i = 0; i < TURNS && better > FLAT && !interrupt_came() && !err; i++)
        err = turn(run, most, &better);
    return err;
}

/* Takes away as many probes as the error allows, by what is quickly found. */
static struct error *thin(struct run *run)
{
    size_t most = (size_t)(TURN_SHARE * (double)run->now.count);
    struct error *err = NULL;
    while (!err && most && !interrupt_came()) {
        struct choice less = {0};
        err = without(run, most, &less);
        if (!err && less.count && may_be_reached(run, &less))
            put(run, &less);
        else
            most /= 2;
        choice_clear(&less);
    }
    return err;
}

/* Fewer probes for the same error: what a look does not find so good is tried again with what it
 * found. */
static struct error *shed(struct run *run)
{
    struct error *err = NULL;
    size_t good = run->result->rows - 1; /* the look that was the last to be reached */
    for (int i = 0; i < TRIES && !err && !interrupt_came(); i++) {
        const size_t before = run->now.count;
        if (!i)
            err = go_turns(run);
        if (!err)
            err = thin(run);
        if (!err && !i && run->now.count == before)
            break;
        if (!err)
            err = look(run);
        if (!err && is_reached(run))
            good = run->result->rows - 1;
        else if (!err)
            err = go_back(run, &run->looked[good]);
        if (!err && run->now.count == before)
            break;
    }
    if (!err && run->now.count != last_looked(run)->probes)
        err = look(run);
    return err;
}

/* -- all -------------------------------------------------------------------------------------- */

static int compare(const void *a, const void *b)
{
    const uint32_t *x = a, *y = b;
    return *x < *y ? -1 : *x > *y;
}

static struct error *take_over(struct run *run, size_t count, uint32_t *probe)
{
    struct adapt_result *result = run->result;
    struct error *err = array_create(&result->position, 3 * count, sizeof *result->position);
    const size_t width = candidates_capture_width(&run->job->candidates);
    size_t known = 0;
    if (!err)
        err = array_create(&result->light, width * count, sizeof *result->light);
    if (err)
        return err;
    qsort(probe, count, sizeof *probe, compare);
    result->count = count;
    result->candidates = run->candidates.count;
    result->settings = candidates_settings(&run->candidates, &run->job->candidates);
    for (size_t i = 0; i < count; i++) {
        const struct candidates *c = &run->candidates;
        const float *light = c->refined[probe[i]] ? c->capture[probe[i]] : NULL;
        known += light != NULL;
        result->rays += light ? (double)light[width - 1] : 0;
        for (size_t k = 0; k < width; k++)
            result->light[width * i + k] = light ? light[k] : NAN;
        memcpy(result->position + 3 * i, run->candidates.position + 3 * (size_t)probe[i],
               3 * sizeof *result->position);
    }
    result->rays /= fmax((double)known, 1);
    return NULL;
}

/* The probes of the first choice, which a signal did not let come about. */
static struct error *take_over_start(struct run *run)
{
    uint32_t *all = NULL;
    struct error *err = list_start(run, FIRST, &all);
    if (!err)
        err = take_over(run, run->job->given + FIRST, all);
    free(all);
    return err;
}

struct error *adapt(struct adapt_result *result, const struct adapt_job *job)
{
    struct run run = {.job = job, .result = result};
    run.own = job->candidates;
    struct error *err = start(&run);
    run.world.job = &run.own;
    if (!err)
        err = go_rounds(&run);
    if (!err && result->end == ADAPT_ERROR)
        err = shed(&run);
    else if (!err && result->end != ADAPT_INTERRUPT) {
        err = go_turns(&run);
        if (!err)
            err = go_moves(&run);
        if (!err)
            err = look(&run);
    }
    if (interrupt_came() && run.starts >= FIRST) { /* which may have ended probe-tet as well */
        error_destroy(err);
        err = NULL;
        result->end = ADAPT_INTERRUPT;
    }
    if (!err)
        err = run.now.count ? take_over(&run, run.now.count, run.now.probe) : take_over_start(&run);
    if (!err && run.now.count)
        err = choice_least_error(&run.now, &result->least);
    for (size_t i = 0; i < result->rows; i++) {
        free(run.looked[i].probe);
        free(run.looked[i].judge);
    }
    free(run.looked);
    hide(&run);
    choice_clear(&run.now);
    gains_clear(&run.gains);
    seen_clear(&run.seen);
    moves_clear(&run.moves);
    candidates_clear(&run.candidates);
    free(run.start);
    return err;
}

void adapt_clear(struct adapt_result *result)
{
    free(result->position);
    free(result->light);
    free(result->row);
    *result = (struct adapt_result){0};
}
