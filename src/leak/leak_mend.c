/* SPDX-License-Identifier: Apache-2.0 */
#include "leak/leak_mend.h"
#include "base/array.h"
#include "base/error.h"
#include "base/warning.h"
#include "interpolate/baked.h"
#include "leak/cells_make.h"
#include "leak/leak_need.h"
#include "leak/sight.h"
#include "measure/unseen.h"
#include "measure/unseen_outside.h"
#include "place/place_inside.h"
#include "stream/cells.h"
#include "stream/stream.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct error *leak_mesh_of(const struct stream *stream, struct leak_mesh *mesh)
{
    struct cells cells;
    const struct table *probes = stream_table(stream, "probe");
    if (!probes)
        return error_new("there are no cells: run probe-tet");
    struct error *err = cells_find(stream, &cells);
    if (err)
        return err;
    *mesh = (struct leak_mesh){.probe_count = probes->rows,
                               .position = column_f64(table_column(probes, "position")),
                               .corners = cells.corners,
                               .cell_count = cells.table->rows,
                               .vertex = cells.vertex,
                               .neighbour = cells.neighbour};
    return NULL;
}

/* -- the state of mending --------------------------------------------------------------------- */

/* Seeds of points: those that measure in the end, those that rounds are judged by, and those that
 * the first round chooses by; each further round has others. */
enum { FOR_CERTIFICATE, FOR_JUDGING, FOR_CHOOSING };
enum { JUDGES = 8 };  /* times as many points judge a round, which may win little */
enum { OUTSIDE = 4 }; /* one of so many points looks at what is outside of the hull */

struct mend {
    struct stream *stream;
    const struct leak_mend_job *job;
    struct warnings *warnings;
    struct leak_settings settings; /* of the next round */
    struct leaks leaks;
    struct place_judge *judge; /* what is inside of solids; NULL: not needed yet */
    bool measures;             /* there are cells to measure, and points for it */
    uint64_t round;            /* seed of the points that are now */
    struct unseen_cells now;   /* measured from them */
};

static struct table *probes_of(const struct mend *m)
{
    return stream_table(m->stream, "probe");
}

/* How many probes may still be added. */
static size_t room_of(const struct mend *m)
{
    const double room = floor(m->job->probes_most) - (double)probes_of(m)->rows;
    return room > 0 ? (size_t)room : 0;
}

/* Whether p is not inside of solids. */
static struct error *is_free(void *context, const double p[3], bool *free)
{
    struct mend *m = context;
    const struct table *probes = probes_of(m);
    struct error *err = place_judge_of(&m->judge, m->job->tracer, probes->rows,
                                       column_f64(table_column(probes, "position")),
                                       m->settings.threads);
    *free = !err && place_judge_side(m->judge, p) == PLACE_AIR;
    return err;
}

/* Takes out what would stand inside solids; *count: how many are left. */
static struct error *keep_free(struct mend *m, double *probe, size_t *count)
{
    struct error *err = NULL;
    size_t kept = 0;
    for (size_t i = 0; i < *count && !err; i++) {
        bool free;
        err = is_free(m, probe + 3 * i, &free);
        if (!err && free)
            memmove(probe + 3 * kept++, probe + 3 * i, 3 * sizeof *probe);
    }
    *count = kept;
    return err;
}

/* Looks along the edges. */
static struct error *find(struct mend *m)
{
    struct leak_mesh mesh;
    leaks_clear(&m->leaks);
    struct error *err = leak_mesh_of(m->stream, &mesh);
    return err ? err : leak_find(&m->leaks, m->job->tracer, &m->settings, &mesh);
}

static struct error *store_occlusion(struct stream *stream, const struct leaks *leaks)
{
    struct cells cells;
    struct column *occlusion = NULL;
    struct error *err = cells_find(stream, &cells);
    const size_t edges = err ? 0 : (size_t)leak_edges_of(cells.corners);
    if (!edges) /* a single probe has none */
        return err;
    err = table_add_column(cells.table, "occlusion", COLUMN_I32, edges, &occlusion);
    if (!err)
        memcpy(occlusion->data, leaks->cell_edges, edges * cells.table->rows * sizeof(int32_t));
    return err;
}

static struct error *store_sight_outside(struct table *cells, const struct sights *sights)
{
    struct column *sight = NULL, *stand_in = NULL;
    struct error *err = table_add_column(cells, "sight_outside", COLUMN_F32, 12, &sight);
    if (!err)
        memcpy(column_f32(sight), sights->outside, 12 * cells->rows * sizeof *sights->outside);
    if (!err)
        err = table_add_column(cells, "stand_in_outside", COLUMN_I32, 1, &stand_in);
    if (!err)
        memcpy(column_i32(stand_in), sights->stand_in_outside,
               cells->rows * sizeof *sights->stand_in_outside);
    return err;
}

/* says: how many cells have walls in them */
static struct error *store_sight(struct stream *stream, const struct leak_mend_job *job, bool says)
{
    struct cells cells;
    struct leak_mesh mesh;
    struct sights sights = {0};
    struct column *sight = NULL, *stand_in = NULL;
    struct error *err = leak_mesh_of(stream, &mesh);
    if (!err)
        err = cells_find(stream, &cells);
    const size_t width = err ? 0 : (size_t)(cells.corners * (cells.corners - 1));
    if (!width) /* a single probe is seen from everywhere */
        return err;
    table_remove_column(cells.table, "sight_outside");
    table_remove_column(cells.table, "stand_in_outside");
    err = sight_find(&sights, job->tracer, &mesh, job->settings.threads);
    if (!err)
        err = table_add_column(cells.table, "sight", COLUMN_F32, width, &sight);
    if (!err)
        err = table_add_column(cells.table, "stand_in", COLUMN_I32, 1, &stand_in);
    if (!err) {
        sight = table_column(cells.table, "sight"); /* the table has moved its columns since */
        memcpy(column_f32(sight), sights.sight, width * mesh.cell_count * sizeof *sights.sight);
        memcpy(column_i32(stand_in), sights.stand_in, mesh.cell_count * sizeof *sights.stand_in);
    }
    if (!err && job->program && says)
        fprintf(stderr, "%s: sight: %zu of %zu cells have walls in them, %zu a stand-in\n",
                job->program, sights.walled, mesh.cell_count, sights.stood_in);
    if (!err && sights.outside)
        err = store_sight_outside(cells.table, &sights);
    sights_clear(&sights);
    return err;
}

static struct error *drop_sight(struct stream *stream)
{
    static const char *const names[] = {"sight", "stand_in",   "sight_outside", "stand_in_outside",
                                        "leak",  "leak_light", "leak_free"};
    struct cells cells;
    struct error *err = cells_find(stream, &cells);
    for (size_t i = 0; i < sizeof names / sizeof *names && !err; i++)
        table_remove_column(cells.table, names[i]);
    return err;
}

/* -- measuring -------------------------------------------------------------------------------- */

/* Points that choose where probes go. */
struct asked {
    struct need_point *point; /* owned */
    size_t count, capacity;
};

/* Of less unseen weight than this, of which light by sight always leaves a little, nobody asks. */
static const double NOTHING = 1e-4;

static struct error *ask(void *context, const struct unseen_point *p)
{
    struct asked *asked = context;
    if (p->weight < NOTHING)
        return NULL;
    struct error *err =
        array_reserve(&asked->point, &asked->capacity, asked->count + 1, sizeof *asked->point);
    if (err)
        return err;
    struct need_point *point = &asked->point[asked->count++];
    *point = (struct need_point){.cell = p->cell, .leaks = p->volume * p->weight};
    memcpy(point->position, p->position, sizeof point->position);
    return NULL;
}

/* What leaks now. asked: gets the points that do not see all, by a seed of their own; or NULL. */
static struct error *measure(struct mend *m, uint64_t seed, struct unseen_cells *cells,
                             struct asked *asked)
{
    struct baked baked;
    const struct unseen_settings settings = {.least = 2,
                                             .points = (seed == FOR_JUDGING ? JUDGES : 1) *
                                                       m->job->points,
                                             .seed = seed,
                                             .threads = m->settings.threads,
                                             .judge = &m->judge,
                                             .keep = asked ? ask : NULL,
                                             .context = asked};
    struct error *err = baked_open_cells(&baked, m->stream);
    if (err)
        return err;
    err = unseen_cells(cells, m->job->tracer, &baked, &settings);
    baked_close(&baked);
    return err;
}

static struct error *store_leak(struct stream *stream, const struct unseen_cells *measured)
{
    struct cells cells;
    struct column *leak = NULL;
    struct error *err = cells_find(stream, &cells);
    if (!err)
        err = table_add_column(cells.table, "leak", COLUMN_F32, 1, &leak);
    if (!err)
        memcpy(column_f32(leak), measured->cell_weight, cells.table->rows * sizeof(float));
    return err;
}

/* What leaks outside of the hull. */
static struct error *measure_outside(struct mend *m, struct report *report)
{
    struct baked baked;
    struct unseen_outside outside = {0};
    const struct unseen_settings settings = {
        .seed = FOR_CERTIFICATE, .threads = m->settings.threads, .judge = &m->judge};
    struct error *err = baked_open_cells(&baked, m->stream);
    if (err)
        return err;
    err = unseen_outside(&outside, m->job->tracer, &baked, &settings,
                         (size_t)(m->job->points / OUTSIDE));
    baked_close(&baked);
    return err ? err : unseen_outside_report(report, &outside);
}

/* Measures from points that nothing else knows of, says so, and keeps it with the cells. when:
 * what is said before it, "after: " or the like. */
static struct error *certify(struct mend *m, const char *when, struct report *report)
{
    struct unseen_cells cells = {0};
    struct leak_mesh mesh;
    if (!m->measures)
        return NULL;
    struct error *err = measure(m, FOR_CERTIFICATE, &cells, NULL);
    report_clear(report);
    if (!err)
        err = leak_mesh_of(m->stream, &mesh);
    if (!err)
        err = unseen_report(report, &cells, mesh.cell_count);
    if (!err)
        err = measure_outside(m, report);
    if (!err)
        err = store_leak(m->stream, &cells);
    if (!err && m->job->program) {
        char before[64];
        snprintf(before, sizeof before, "%s: ", m->job->program);
        fprintf(stderr, "%s%sfrom %zu points in free space:\n", before, when, cells.points);
        report_print_leaks(report, before, stderr);
    }
    unseen_cells_clear(&cells);
    return err;
}

static void say(const struct mend *m, const char *when)
{
    const struct leaks *leaks = &m->leaks;
    if (!m->job->program)
        return;
    fprintf(stderr,
            "%s: %s%zu of %zu edges leak (%.2f %%), %zu pass through a surface, %zu probes\n",
            m->job->program, when, leaks->leaking, leaks->edges,
            leaks->edges ? 100.0 * (double)leaks->leaking / (double)leaks->edges : 0.0,
            leaks->crossed, probes_of(m)->rows);
    if (m->job->settings.edges != LEAK_WALLS)
        fprintf(stderr, "%s: %s%zu edges go through the border of a shadow\n", m->job->program,
                when, leaks->shadowed);
}

/* -- rounds ----------------------------------------------------------------------------------- */

/* What a round is undone to. */
struct state {
    struct stream *cells; /* owned: the cells, and as many probes with nothing else */
    size_t probes, leaking;
};

static struct error *state_keep(struct state *state, const struct mend *m)
{
    struct table *probes = NULL;
    *state = (struct state){.probes = probes_of(m)->rows, .leaking = m->leaks.leaking};
    struct error *err = stream_create(&state->cells);
    if (!err)
        err = stream_add_table(state->cells, "probe", &probes);
    if (!err)
        err = table_resize(probes, state->probes);
    return err ? err : cells_copy(state->cells, m->stream);
}

static struct error *state_restore(const struct state *state, struct mend *m)
{
    struct error *err = table_resize(probes_of(m), state->probes);
    if (!err)
        err = cells_copy(m->stream, state->cells);
    return err ? err : find(m);
}

/* Adds probes, with light, and makes cells of all. */
static struct error *add_probes(struct mend *m, const double *probe, size_t count)
{
    struct table *probes = probes_of(m);
    const size_t before = probes->rows;
    struct error *err = table_resize(probes, before + count);
    if (err)
        return err;
    memcpy(column_f64(table_column(probes, "position")) + 3 * before, probe,
           3 * count * sizeof *probe);
    err = m->job->capture(m->job->context, m->stream, before);
    if (!err)
        err = cells_make(m->stream, false);
    return err ? err : find(m);
}

static void say_undone(const struct mend *m, size_t count, size_t leaking,
                       const struct unseen_blend *before, const struct unseen_blend *after)
{
    char share[80] = "";
    if (m->measures)
        snprintf(share, sizeof share, ", and unseen weight is %.3g %%, %.3g %% without",
                 100 * after->weight.value, 100 * before->weight.value);
    warnings_add(m->warnings, "undone",
                 "a round of %zu probes was undone, since no less leaks with them: %zu edges do, "
                 "%zu without%s",
                 count, m->leaks.leaking, leaking, share);
}

/* Adds a round's probes, and takes them back where no less weight is unseen with them: of the blend
 * of all probes, and no fewer edges leak, where it was edges that asked for them, or of the blend
 * by what is seen. Of weight, since light that leaks is what few bright places say. */
static struct error *try_round(struct mend *m, const double *probe, size_t count, bool by_edges,
                               bool *counts)
{
    struct state before;
    struct unseen_cells after = {0};
    *counts = false;
    struct error *err = state_keep(&before, m);
    if (!err)
        err = add_probes(m, probe, count);
    if (!err && m->job->sight && !by_edges)
        err = store_sight(m->stream, m->job, false);
    if (!err && m->measures)
        err = measure(m, FOR_JUDGING, &after, NULL);
    const struct unseen_blend *was = by_edges ? &m->now.all : &m->now.now,
                              *is = by_edges ? &after.all : &after.now;
    if (!err && m->measures)
        *counts = is->weight.value < was->weight.value;
    if (!err && (by_edges || !m->measures))
        *counts = *counts || m->leaks.leaking < before.leaking;
    if (!err && by_edges && m->job->settings.edges != LEAK_WALLS)
        *counts = true; /* what borders of shadows win is not in what leaks */
    if (!err && !*counts) {
        say_undone(m, count, before.leaking, was, is);
        err = state_restore(&before, m);
    }
    if (!err && *counts) {
        unseen_cells_clear(&m->now);
        m->now = after;
    } else {
        unseen_cells_clear(&after);
    }
    stream_destroy(before.cells);
    return err;
}

static bool is_enough(const struct mend *m)
{
    const struct unseen_blend *now = &m->now.now;
    return m->measures &&
           (isnan(now->light.value) ? now->weight.high : now->light.high) <= m->job->leak_most;
}

/* Rounds in a row that may be undone before the last; of those beside walls, which know less. */
enum { UNDONE = 3, UNDONE_BESIDE = 5 };

/* What a round beside walls may choose. */
struct turn {
    size_t most; /* probes; SIZE_MAX: as many as there is room for */
    size_t past; /* as leak_choose */
};

/* Chooses probes for both sides of walls. */
static struct error *choose_beside(struct mend *m, struct turn turn, struct leak_choice *choice)
{
    struct leak_mesh mesh;
    const size_t space = room_of(m);
    const struct leak_room room = {.most = turn.most < space ? turn.most : space,
                                   .past = turn.past,
                                   .is_free = is_free,
                                   .context = m};
    struct error *err = leak_mesh_of(m->stream, &mesh);
    return err ? err : leak_choose(choice, &m->leaks, m->job->tracer, &m->settings, &mesh, &room);
}

/* more: are asked for. */
static void say_full_beside(const struct mend *m, size_t before, size_t more)
{
    warnings_add(m->warnings, "max-probes",
                 "--max-probes %.0f: %zu probes went in beside walls, where most leaks, and %zu "
                 "more are asked for; %zu of %zu edges still leak",
                 m->job->probes_most, probes_of(m)->rows - before, more, m->leaks.leaking,
                 m->leaks.edges);
}

/* After so many rounds in a row that there was no room for all of, and that were undone: the next
 * best, fewer of them, two as long as walls have two sides, and at last one, which may help alone.
 */
static struct turn turn_after(const struct leak_choice *last, int undone)
{
    enum { FEW = 32, ALONE = UNDONE_BESIDE - 2 };
    const double fewer = last->count > FEW ? sqrt((double)last->count) : (double)last->count / 2;
    return (struct turn){.most = undone < ALONE ? (size_t)fmax(ceil(fewer), 2) : 1,
                         .past = last->past};
}

/* Probes on both sides of walls. */
static struct error *mend_edges(struct mend *m)
{
    const double separation_least = 2 * m->job->settings.offset;
    const size_t before = probes_of(m)->rows;
    const struct turn all = {.most = SIZE_MAX};
    struct turn turn = all;
    size_t more = 0;
    int64_t rounds = 0;
    struct error *err = m->measures ? measure(m, FOR_JUDGING, &m->now, NULL) : NULL;
    int undone = 0;
    while (!err && rounds < m->job->rounds && m->leaks.asking && undone < UNDONE_BESIDE) {
        struct leak_choice choice = {0};
        bool counts = true;
        err = choose_beside(m, turn, &choice);
        const bool cut = choice.asked > choice.count, any = choice.count;
        if (!err && any)
            err = try_round(m, choice.probe, choice.count, true, &counts);
        more = cut ? choice.asked - (counts ? choice.count : 0) : 0;
        undone = counts ? 0 : undone + 1;
        turn = counts ? all : turn_after(&choice, undone);
        leak_choice_clear(&choice);
        if (!counts && !cut)
            break;
        if (!any && (cut || m->settings.separation <= separation_least))
            break; /* what still leaks has probes as near as they may be */
        rounds += counts;
        if (counts)
            m->settings.separation = fmax(m->settings.separation / 2, separation_least);
    }
    if (!err && more)
        say_full_beside(m, before, more);
    return err;
}

/* Keeps the points that most leaks at, as many as can be held against one another. */
static int compare_leaks(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

static struct error *keep_worst(struct asked *asked)
{
    enum { MOST = 1 << 16 };
    double *leaks = NULL;
    if (asked->count <= MOST)
        return NULL;
    struct error *err = array_create(&leaks, asked->count, sizeof *leaks);
    for (size_t i = 0; i < asked->count && !err; i++)
        leaks[i] = asked->point[i].leaks;
    if (!err)
        qsort(leaks, asked->count, sizeof *leaks, compare_leaks);
    size_t kept = 0;
    for (size_t i = 0; i < asked->count && kept < MOST && !err; i++)
        if (asked->point[i].leaks >= leaks[MOST - 1])
            asked->point[kept++] = asked->point[i];
    asked->count = err ? asked->count : kept;
    free(leaks);
    return err;
}

/* Chooses places for `most` probes, by points of the round that do not see all. */
static struct error *choose(struct mend *m, uint64_t round, size_t most, double *probe,
                            size_t *count)
{
    struct asked asked = {0};
    struct unseen_cells cells = {0};
    struct leak_mesh mesh;
    struct error *err = measure(m, FOR_CHOOSING + round, &cells, &asked);
    unseen_cells_clear(&cells);
    if (!err)
        err = keep_worst(&asked);
    if (!err)
        err = leak_mesh_of(m->stream, &mesh);
    if (!err)
        err = leak_need(m->job->tracer, &mesh, asked.point, asked.count, most, m->settings.threads,
                        probe, count);
    free(asked.point);
    return err ? err : keep_free(m, probe, count);
}

static void say_full(const struct mend *m, size_t before)
{
    warnings_add(m->warnings, "max-probes",
                 "--max-probes %.0f: %zu of --probes %lld went in, where most leaks; %.3g %% of "
                 "weight is still unseen",
                 m->job->probes_most, probes_of(m)->rows - before, (long long)m->job->probes,
                 100 * m->now.now.weight.value);
}

/* Probes where most leaks. A round that was undone is tried again with half as many, the best ones
 * of other points. */
static struct error *mend_need(struct mend *m)
{
    enum { LAST = 8 };
    const size_t before = probes_of(m)->rows;
    double *probe = NULL;
    bool full = false;
    int undone = 0; /* rounds in a row */
    size_t left = (size_t)m->job->probes;
    unseen_cells_clear(&m->now);
    struct error *err = measure(m, FOR_JUDGING, &m->now, NULL);
    if (!err)
        err = array_create(&probe, 3 * (left < room_of(m) ? left : room_of(m)), sizeof *probe);
    for (uint64_t round = 0; !err && left && !is_enough(m); round++) {
        bool counts = false;
        full = full || left > room_of(m);
        left = left < room_of(m) ? left : room_of(m);
        size_t count = 0, most = ((left > LAST ? (left + 1) / 2 : left) >> undone) + (undone > 0);
        if (left)
            err = choose(m, round, most, probe, &count);
        if (!err && count)
            err = try_round(m, probe, count, false, &counts);
        undone = counts ? 0 : undone + 1;
        full = full && (count || !left);
        if (!count || undone == UNDONE)
            break;
        left -= counts ? count : 0;
    }
    if (!err && full && !is_enough(m))
        say_full(m, before);
    free(probe);
    return err;
}

/* -- all together ----------------------------------------------------------------------------- */

static struct error *begin(struct mend *m, struct report *report)
{
    struct leak_mesh mesh;
    struct error *err = drop_sight(m->stream);
    if (!err)
        err = leak_mesh_of(m->stream, &mesh);
    if (!err)
        err = find(m);
    if (err)
        return err;
    m->measures = m->job->points > 0 && mesh.corners > 1;
    if (m->job->leak_most >= 0 && !m->measures)
        return error_new("--max-leak is of what leaks in cells: the cell is a point");
    const bool adds = m->job->rounds || m->job->probes;
    const char *when = adds ? "before: " : ""; /* there is no after */
    say(m, when);
    if (m->job->sight)
        err = store_sight(m->stream, m->job, true);
    return err ? err : certify(m, when, report);
}

struct error *leak_mend(struct stream *stream, const struct leak_mend_job *job,
                        struct report *report, struct warnings *warnings)
{
    struct mend m = {.stream = stream, .job = job, .warnings = warnings, .settings = job->settings};
    const size_t probes = stream_table(stream, "probe") ? probes_of(&m)->rows : 0;
    struct error *err = begin(&m, report);
    if (!err && job->rounds)
        err = mend_edges(&m);
    if (!err && job->sight && probes_of(&m)->rows > probes)
        err = store_sight(stream, job, false);
    if (!err && job->probes && m.measures)
        err = mend_need(&m);
    if (!err && (job->rounds || job->probes))
        say(&m, "after: ");
    if (!err && probes_of(&m)->rows > probes)
        err = certify(&m, "after: ", report);
    if (!err)
        err = store_occlusion(stream, &m.leaks);
    leaks_clear(&m.leaks);
    unseen_cells_clear(&m.now);
    place_judge_destroy(m.judge);
    return err;
}
