/* SPDX-License-Identifier: Apache-2.0 */
/* Whether sh_error says the truth: over more than 1000 probes of three scenes, the light of many
 * rays lies within 1.96 of the standard errors of few in 93 to 97 % of all cases; and likewise for
 * surfaces and for rays that are spent by error.
 *
 * The scenes are those that come with the program, lit from the fronts of their lamps: a lamp that
 * shines from its back as well, into the slit under the ceiling, is light that one ray in thousands
 * meets, and no sample of 1000 knows how much of that there is. */
#include "base/error.h"
#include "base/threads.h"
#include "base/warning.h"
#include "capture/capture.h"
#include "import/import_scene.h"
#include "libprobe-query/sh.h"
#include "math/random.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "support/tap.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { PROBES = 360, RAYS = 1024, TRUTH_RAYS = 4096 };

/* One scene's probes, few rays against many. */
struct trial {
    const struct path_tracer *path;
    struct capture_settings few;
    bool surface;
    struct vec3 low, high;
    unsigned within[PROBES], all[PROBES];
};

static struct error *try_probe(void *context, size_t index, int thread)
{
    (void)thread;
    struct trial *t = context;
    struct random r = random_start(5, 0, (uint32_t)index);
    const double p[3] = {t->low.x + (t->high.x - t->low.x) * random_double(&r),
                         t->low.y + (t->high.y - t->low.y) * random_double(&r),
                         t->low.z + (t->high.z - t->low.z) * random_double(&r)};
    const struct vec3f n =
        direction_by_cosine((struct vec3f){0, 1, 0}, random_float(&r), random_float(&r));
    const float normal[3] = {n.x, n.y, n.z};
    struct capture_settings many = t->few;
    many.rays = TRUTH_RAYS;
    many.error = 0;
    many.seed = 12345;
    struct capture_probe one, truth;
    struct error *err = capture_probe(t->path, &t->few, p, t->surface ? normal : NULL, &one);
    if (!err)
        err = capture_probe(t->path, &many, p, t->surface ? normal : NULL, &truth);
    for (int k = 0; k < (t->surface ? 3 : 27) && !err; k++) {
        if (!(truth.sh_error[k] > 0)) /* no light gets there */
            continue;
        const double off = (double)one.sh[k] - (double)truth.sh[k];
        t->all[index]++;
        t->within[index] += off * off < 1.96 * 1.96 *
                                            ((double)one.sh_error[k] * (double)one.sh_error[k] +
                                             (double)truth.sh_error[k] * (double)truth.sh_error[k]);
    }
    return err;
}

/* Adds one scene's cases. */
static void try_scene(const char *name, double sky, struct trial *t, double *within, double *all,
                      int *probes)
{
    char path[4096];
    const char *source = getenv("SRC");
    struct scene_settings light = scene_settings_default();
    struct scene *scene;
    struct tracer *tracer;
    struct path_tracer tracing;
    struct warnings warnings = {0};
    snprintf(path, sizeof path, "%s/scenes/%s", source ? source : ".", name);
    light.emit_front_only = true;
    light.sky[0] = light.sky[1] = light.sky[2] = sky;
    must(scene_read(&scene, path, &light, false, &warnings));
    must(trace_create(&tracer, scene));
    must(path_init(&tracing, tracer, 64));
    t->path = &tracing;
    t->low = scene->box_min;
    t->high = scene->box_max;
    must(threads_for(threads_available(), PROBES, try_probe, t));
    double scene_within = 0, scene_all = 0;
    for (int i = 0; i < PROBES; i++) {
        scene_within += t->within[i];
        scene_all += t->all[i];
        *probes += t->all[i] > 0;
        t->within[i] = t->all[i] = 0;
    }
    printf("# %s: %.1f %% of %.0f\n", name, 100 * scene_within / scene_all, scene_all);
    *within += scene_within;
    *all += scene_all;
    path_clear(&tracing);
    trace_destroy(tracer);
    scene_destroy(scene);
    scene_settings_clear(&light);
    warnings_clear(&warnings);
}

static void test(const char *what, struct capture_settings few, bool surface, int least_probes)
{
    struct trial t = {.few = few, .surface = surface};
    double within = 0, all = 0;
    int probes = 0;
    try_scene("cornell-box.obj", 0, &t, &within, &all, &probes);
    try_scene("two-rooms.obj", 0, &t, &within, &all, &probes);
    try_scene("coloured-walls.gltf", 1, &t, &within, &all, &probes);
    const double share = within / all;
    ok(share > 0.93 && share < 0.97 && probes >= least_probes,
       "%s: the truth is within 1.96 standard errors in %.1f %% of %.0f cases, %d probes", what,
       100 * share, all, probes);
}

int main(void)
{
    if (SANITIZED) {
        tap_skip("statistics over 9000 captures, whose paths tests/capture_extras.c takes as well");
        return tap_done();
    }
    struct capture_settings s = capture_settings_default();
    s.rays = RAYS;
    test("1024 rays", s, false, 1000);
    test("1024 rays on surfaces", s, true, 900);
    s.rays = 128;
    s.error = 0.03;
    s.rays_most = 4096;
    test("rays by error", s, false, 1000);
    return tap_done();
}
