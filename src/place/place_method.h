/* SPDX-License-Identifier: Apache-2.0 */
/* place_method: the ways of placing probes, behind one interface.
 *
 * Each method is a row of place_methods[] and lives in a file of its own, which has its options,
 * what they need of one another, and the placing. probe-place goes over the table and knows no
 * method by name:
 *
 *     struct place_options options = place_options_default();
 *     struct option_row rows[PLACE_OPTION_ROWS];
 *     ... groups[] = {place_option_rows(&options, rows), NULL} ... options_parse ...
 *     err = place_operands(count, operands, &method, &world.file, &scene_path);
 *     if (!err) err = place_options_check(&options, method, scene_path != NULL);
 *     if (!err) err = method->place(&place, &options, &world);
 */
#ifndef PLACE_METHOD_H
#define PLACE_METHOD_H

#include "place/place.h"
#include "place/place_inside.h"
#include "place/reach.h"
#include "place/space.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct option_row;
struct tracer;
struct warnings;

/* What cuts cells of an octree. */
enum place_cut {
    PLACE_CUT_GEOMETRY,
    PLACE_CUT_DISTANCE,
    PLACE_CUT_GRADIENT,
    PLACE_CUT_CONTRAST,
    PLACE_CUT_ALL
};
enum { PLACE_CUTS = PLACE_CUT_ALL + 1, PLACE_LEVELS_MOST = 10 };

/* The options of all methods. Lengths in units of the scene. */
struct place_options {
    /* grid */
    double spacing[3], count, clearance; /* clearance_share: as of struct place_grid */
    int ground;
    bool spacing_given, count_given, clearance_given, clearance_share, ground_given;
    /* grid, adaptive: boxes in their order, and the turn of those that have none of their own */
    struct place_box box[PLACE_BOXES];
    int boxes;
    double turn;
    bool bounds_given, turn_given;
    /* reach, and where others go */
    const char *reach_file;
    bool reach_given;
    struct reach_settings reach;
    /* path */
    struct place_way way;
    bool step_given, interval_given, spline_given;
    /* vertices; crease: degrees */
    double offset, crease;
    int sides; /* enum place_sides */
    bool volume, faces, offset_given, crease_given, volume_given, faces_given, sides_given;
    /* methods by light; rays 0, light -1: as is usual for the method */
    struct {
        int rays, bounces, order;
        int light; /* enum capture_light */
        const char *keep;
        bool rays_given, bounces_given, order_given, light_given, keep_given;
    } light;
    /* spawn-merge and ascent: merging and adding by contrast; lengths in spacings; rounds 0: as is
     * usual */
    struct {
        int contrast, form; /* enum contrast_kind, contrast_form */
        double merge_distance, merge_contrast, spawn_distance, spawn_contrast;
        int rounds;
        bool contrast_given, form_given, merge_distance_given, merge_contrast_given,
            spawn_distance_given, spawn_contrast_given, rounds_given;
    } merge;
    /* ascent */
    int step_back; /* enum step_back */
    bool step_back_given;
    /* unlit, and ascent; 0: as many as there are areas */
    int unlit;
    bool unlit_given;
    /* poisson; lengths in units of the scene */
    struct {
        double radii[2], distance, lift;
        int steer; /* enum poisson_steer */
        int particles, misses, areas;
        bool radii_given, distance_given, lift_given, steer_given, particles_given, misses_given,
            areas_given;
    } poisson;
    /* octree and spawn-merge: from where to where cells are cut; the latter has no least */
    int levels[2];
    bool levels_given, least_level_given;
    /* octree; cut: a threshold for each test, NaN: it is not asked */
    struct {
        int32_t cells[3];
        double cut[PLACE_CUTS], cull, inset;
        bool cells_given, cut_given, cull_given, inset_given;
    } octree;
    /* adaptive; shares and numbers, 0: none */
    struct {
        double error, gain, noise;
        int probes;
        int64_t bytes;
        const char *curve;
        bool error_given, gain_given, probes_given, bytes_given, curve_given, noise_given;
    } adaptive;
};

struct place_options place_options_default(void);

/* What a method gets beside its options. */
struct place_world {
    const struct scene *scene; /* NULL: none was given; with its light, for who looks at it */
    const char *file;          /* of a method that has one; "-": standard input */
    double most;               /* probes */
    struct warnings *warnings;
    /* For a method that looks at light: */
    struct place_inside_settings inside; /* and the threads */
    uint64_t seed;
    const char *program; /* says on standard error how it goes; NULL: nobody does */
    bool progress;       /* and how far it is */
    bool interrupted;    /* out: a signal came, and less was done than was asked for */
    double spacing[3];   /* out, of grid: between nodes, at the most; */
    struct reach *reach; /* and the region, which the caller destroys; NULL: there is none */
};

struct place_method {
    const char *name;    /* the first operand */
    const char *file_of; /* the second is a FILE of these; NULL: it has none */
    bool needs_scene;    /* the last; else it may be left out */
    bool sees_light;     /* and where there is air: all of its positions are in it, */
    bool asks_air;       /* or not: they are looked at as those of others are */
    bool random;         /* --seed goes with it, though it does not look at light */
    int origin;          /* its number in column origin (man probe.5) */
    /* Names of other methods' options that it takes as well, NULL after the last; NULL: none. */
    const char *const *shares;
    bool reaches; /* and place_reach_shares */
    /* Writes the options that go with this method alone, each with `given`, and returns what
     * follows them. NULL: there are none. */
    struct option_row *(*rows)(struct place_options *options, struct option_row *row);
    /* Error: options that lack one another, or the scene. NULL: all are well. */
    struct error *(*check)(const struct place_options *options, bool scene);
    /* Appends at least one position, world->most at most, or says why it cannot. */
    struct error *(*place)(struct place *place, const struct place_options *options,
                           struct place_world *world);
};

extern const struct place_method place_method_grid, place_method_points, place_method_path,
    place_method_vertices, place_method_lights, place_method_adaptive, place_method_spawn_merge,
    place_method_ascent, place_method_unlit, place_method_octree, place_method_poisson,
    place_method_reach, place_method_samples;
/* All of them; NULL after the last. It is where all methods are known, those of higher layers too:
 * adapt/place_methods.c. */
extern const struct place_method *const place_methods[];

enum { PLACE_OPTION_ROWS = 108 }; /* room for those of all methods and the end */

/* Fills rows with the options of all methods, and returns them. */
const struct option_row *place_option_rows(struct place_options *options, struct option_row *rows);

/* Takes the operands apart: METHOD [FILE] [SCENE]; *file and *scene are NULL where there is none.
 * Errors name the method and what it expects. */
struct error *place_operands(int count, const char *const *operands,
                             const struct place_method **method, const char **file,
                             const char **scene);

/* Error: options of another method, no scene where one is needed, and what the method checks. */
struct error *place_options_check(struct place_options *options, const struct place_method *method,
                                  bool scene);

/* A usage error where two of the operands and options that name inputs are standard input. */
struct error *place_inputs_differ(const struct place_options *options, const char *file,
                                  const char *scene);

/* For methods that take --reach as well: the names of its options, NULL after the last; options
 * that lack it, or the scene; the region, NULL where it was not asked for; and leaving out of what
 * was placed what is not in it. */
extern const char *const place_reach_shares[];
struct error *place_reach_check(const struct place_options *options, bool scene);
struct error *place_reach_open(struct reach **reach, const struct place_options *options,
                               const struct tracer *tracer, const struct place_world *world);
struct error *place_reach_keep(struct place *place, const struct place_options *options,
                               const struct place_world *world);

/* The boxes that --bounds says, or the scene's, with air before it where it is flat, as a warning
 * says; and the region in them, which may be NULL: no larger than what holds it. options and reach
 * must outlive the space. */
void place_options_space(const struct place_options *options, const struct place_world *world,
                         const struct reach *reach, struct place_space *space);

/* "grid|points FILE|... [OPTION]... [SCENE]" */
void place_usage(char *text, size_t size);

#endif
