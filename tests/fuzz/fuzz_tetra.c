/* SPDX-License-Identifier: Apache-2.0 */
/* Fuzzing tetra: generated sets of points of every kind become cells that pass tetra_verify and can
 * be looked up in, the same for any order of the points.
 *
 * Many sets run in one child process, TetGen in it, since a process a set would cost more than the
 * set. When the child dies, the set is made once more as programs make it, TetGen in a child of its
 * own: what counts is what comes of that.
 *
 * PROBE_FUZZ_SETS: how many sets (2700 by default), PROBE_FUZZ_SEED: which (1), PROBE_FUZZ_KIND:
 * only those of this number.
 */
#include "base/error.h"
#include "base/warning.h"
#include "interpolate/cells_volume.h"
#include "support/point_sets.h"
#include "support/tap.h"
#include "tetra/tetra.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

enum { POINTS_MOST = 1000, LIGHT = 2, FAILURES_SHOWN = 20 };

/* What the child tells, in memory that it shares. */
struct tally {
    size_t done; /* sets */
    struct {
        size_t sets, failed, died, by_corners[5], merged, shuffled;
        size_t cells, slivers, stretched, peeled;
        double tolerance;
    } kind[POINT_SETS];
    char failure[FAILURES_SHOWN][200];
    size_t failures;
};

static void fail_set(struct tally *tally, int kind, size_t set, const char *what)
{
    tally->kind[kind].failed++;
    if (tally->failures < FAILURES_SHOWN)
        snprintf(tally->failure[tally->failures], sizeof *tally->failure, "%s, set %zu: %s",
                 point_set_names[kind], set, what);
    tally->failures++;
}

struct set {
    int kind;
    size_t count;
    double position[3 * POINTS_MOST], shuffled[3 * POINTS_MOST];
    float light[LIGHT * POINTS_MOST], shuffled_light[LIGHT * POINTS_MOST];
    struct tetra_settings settings;
};

static void make_set(struct set *set, uint64_t seed, size_t number, int only)
{
    struct random r = random_start(seed, number, 0);
    set->kind = only >= 0 ? only : (int)(number % POINT_SETS);
    set->count = (size_t)(4 * pow(POINTS_MOST / 4.0 + 0.001, random_double(&r)));
    /* large ones take most of the time, and find the least */
    if (set->count > 100 && random_u32(&r) % 4)
        set->count /= 8;
    make_points((enum point_set)set->kind, set->count, &r, set->position);
    for (size_t i = 0; i < set->count; i++) {
        const bool lit = random_u32(&r) % 2;
        for (size_t k = 0; k < LIGHT; k++)
            set->light[LIGHT * i + k] = lit ? random_float(&r) : NAN;
    }
    static const double merge[] = {1e-12, 1e-12, 1e-12, 0, 1e-9, 1e-6, 1e-3, 0.1};
    set->settings = tetra_settings_default();
    set->settings.merge = merge[random_u32(&r) % 8];
    set->settings.light = set->light;
    set->settings.light_width = LIGHT;
    set->settings.thin = number % 3 ? 0 : 0.35;
    for (size_t i = 0; i < set->count; i++) { /* backwards: another order, and easy to map */
        memcpy(set->shuffled + 3 * i, set->position + 3 * (set->count - 1 - i), 3 * sizeof(double));
        memcpy(set->shuffled_light + LIGHT * i, set->light + LIGHT * (set->count - 1 - i),
               LIGHT * sizeof(float));
    }
}

static bool same_place(const struct set *set, int32_t a, int32_t b)
{
    return !memcmp(set->position + 3 * (size_t)a, set->shuffled + 3 * (size_t)b,
                   3 * sizeof(double)) &&
           !memcmp(set->light + LIGHT * (size_t)a, set->shuffled_light + LIGHT * (size_t)b,
                   LIGHT * sizeof(float));
}

/* The same cells, cell by cell and corner by corner, of probes at the same places with the same
 * light. */
static bool same_cells(const struct set *set, const struct tetra *a, const struct tetra *b)
{
    if (a->corners != b->corners || a->cell_count != b->cell_count ||
        a->merged_count != b->merged_count)
        return false;
    for (size_t i = 0; i < (size_t)a->corners * a->cell_count; i++)
        if (a->neighbour[i] != b->neighbour[i] || !same_place(set, a->vertex[i], b->vertex[i]))
            return false;
    return true;
}

/* Whether libprobe-query takes the cells, and finds each of their probes where it is: all its
 * weight on itself, but for probes that were put into a plane or onto a line, which they may stand
 * off by what is merged. */
static struct error *look_up(const struct set *set, const struct tetra *t)
{
    const struct probe_mesh mesh = {.probes = set->count,
                                    .position = set->position,
                                    .corners = t->corners,
                                    .cells = t->cell_count,
                                    .vertex = t->vertex,
                                    .neighbour = t->neighbour};
    struct probe_volume *volume = NULL;
    struct error *err = cells_volume_create(&mesh, 0, &volume);
    struct probe_place place = {.cell = PROBE_COLD};
    for (size_t i = 0; i < set->count && !err; i++) {
        double own = 0;
        probe_volume_locate(volume, set->position + 3 * i, &place);
        for (int k = 0; k < 4; k++)
            own += place.probe[k] == (int32_t)i ? place.weight[k] : 0;
        if ((!t->merged || t->merged[i] < 0) && t->corners == 4 && !(own > 1 - 1e-6))
            err = error_new("probe %zu has a weight of %g where it is", i, own);
    }
    probe_volume_destroy(volume);
    return err;
}

static void run_set(struct tally *tally, struct set *set, size_t number, bool in_process)
{
    const int kind = set->kind;
    struct tetra t = {0}, again = {0};
    struct tetra_verdict verdict;
    struct tetra_report report;
    set->settings.in_process = in_process;
    struct error *err = tetra_make(&t, set->count, set->position, &set->settings, NULL);
    if (!err)
        err = tetra_verify(&t, set->count, set->position, &verdict);
    if (!err && verdict.not_delaunay && !t.stretched)
        err = error_new("%zu facets are not Delaunay", verdict.not_delaunay);
    for (size_t i = 0; i < set->count && t.merged && !err; i++)
        if (t.merged[i] >= 0 && isnan(set->light[LIGHT * (size_t)t.merged[i]]) &&
            !isnan(set->light[LIGHT * i]))
            err = error_new("probe %zu, which has light, is merged with one that has none", i);
    if (!err)
        err = look_up(set, &t);
    if (!err && number % 4 == 0) {
        struct tetra_settings settings = set->settings;
        settings.light = set->shuffled_light;
        err = tetra_make(&again, set->count, set->shuffled, &settings, NULL);
        if (!err && !same_cells(set, &t, &again))
            err = error_new("other cells in another order");
        tally->kind[kind].shuffled++;
    }
    if (!err)
        err = tetra_measure(&t, set->count, set->position, &report);
    if (err) {
        fail_set(tally, kind, number, error_message(err));
    } else {
        tally->kind[kind].by_corners[t.corners]++;
        tally->kind[kind].merged += t.merged_count;
        tally->kind[kind].stretched += t.stretched;
        tally->kind[kind].tolerance = fmax(tally->kind[kind].tolerance, verdict.tolerance);
        if (t.corners == 4) {
            tally->kind[kind].cells += report.cells;
            tally->kind[kind].slivers += report.angle_histogram[0];
            tally->kind[kind].peeled += t.peeled;
        }
    }
    tally->kind[kind].sets++;
    error_destroy(err);
    tetra_clear(&t);
    tetra_clear(&again);
}

static void run_all(struct tally *tally, size_t sets, uint64_t seed, int only)
{
    static struct set set;
    while (tally->done < sets) {
        fflush(NULL);
        const pid_t pid = fork();
        if (pid < 0)
            bail("fork failed");
        if (pid == 0) {
            if (!freopen("/dev/null", "w", stdout) || !freopen("/dev/null", "w", stderr))
                _exit(1);
            for (; tally->done < sets; tally->done++) {
                make_set(&set, seed, tally->done, only);
                run_set(tally, &set, tally->done, true);
            }
            _exit(0);
        }
        int status;
        waitpid(pid, &status, 0);
        if (tally->done >= sets)
            break;
        make_set(&set, seed, tally->done, only);
        tally->kind[set.kind].died++;
        run_set(tally, &set, tally->done++, false);
    }
}

int main(void)
{
    const char *count = getenv("PROBE_FUZZ_SETS"), *seed = getenv("PROBE_FUZZ_SEED"),
               *kind = getenv("PROBE_FUZZ_KIND");
    struct tally *tally =
        mmap(NULL, sizeof *tally, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (tally == MAP_FAILED)
        bail("no memory");
    run_all(tally, count ? strtoull(count, NULL, 10) : tap_cases(100) * POINT_SETS,
            seed ? strtoull(seed, NULL, 10) : 1, kind ? atoi(kind) : -1);
    printf("# kind: sets, of them tetrahedra, triangles, segments, points; merged probes; "
           "stretched; sets in two orders; TetGen died at first; "
           "slivers of cells; tolerance\n");
    for (int k = 0; k < POINT_SETS; k++)
        printf("# %-20s %8zu  %8zu %8zu %8zu %8zu  %9zu %8zu %8zu %5zu  %7zu of %9zu (%.3f %%)  "
               "%.2g\n",
               point_set_names[k], tally->kind[k].sets, tally->kind[k].by_corners[4],
               tally->kind[k].by_corners[3], tally->kind[k].by_corners[2],
               tally->kind[k].by_corners[1], tally->kind[k].merged, tally->kind[k].stretched,
               tally->kind[k].shuffled, tally->kind[k].died, tally->kind[k].slivers,
               tally->kind[k].cells,
               100.0 * (double)tally->kind[k].slivers /
                   (double)(tally->kind[k].cells + !tally->kind[k].cells),
               tally->kind[k].tolerance);
    for (size_t i = 0; i < tally->failures && i < FAILURES_SHOWN; i++)
        printf("# %s\n", tally->failure[i]);
    for (int k = 0; k < POINT_SETS; k++)
        if (tally->kind[k].sets)
            ok(!tally->kind[k].failed, "%s: %zu sets, %zu failed", point_set_names[k],
               tally->kind[k].sets, tally->kind[k].failed);
    return tap_done();
}
