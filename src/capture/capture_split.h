/* SPDX-License-Identifier: Apache-2.0 */
/* capture_split: light that is captured by parts beside the whole, from the same rays: groups of
 * lights, and the response to a distant sky's SH functions, to suns from given directions and to
 * point lights at given places (trace/split.h).
 *
 * Of each group columns sh_NAME and sh_error_NAME (irradiance_NAME and irradiance_error_NAME of
 * surfaces), which add up to sh as far as rounding lets them; transfer_sky, of N^2 blocks, and
 * transfer_suns, of a block a sun, transfer_points, of a block a point, each as wide as sh, and
 * their _error. Header keys group-1 ... (scene/groups.h), transfer-sky N, transfer-sun-1 X,Y,Z ...,
 * transfer-point-1 X,Y,Z ...
 *
 *     capture_split_read(&split, "lamps.txt", "sky:3", settings)
 *     capture_split_open(&split, scene, &(struct groups_way){.added = ...}, &path);
 *     capture settings .split = &split ...
 *     capture_split_clear(&split);          after the path tracer was last used
 */
#ifndef CAPTURE_SPLIT_H
#define CAPTURE_SPLIT_H

#include "scene/groups.h"
#include "trace/split.h"

struct error;
struct path_tracer;
struct scene_settings;
struct stream_header;
struct table;

enum { CAPTURE_SUNS_MOST = 1 << 16, CAPTURE_POINTS_MOST = 1 << 16 };

/* Starts as {0}. */
struct capture_split {
    struct light_groups groups;
    int sky_order; /* 0: no transfer of a sky */
    double *sun;   /* 3 each: unit, towards it; owned */
    size_t sun_count, sun_capacity;
    double *point; /* 3 each: where it is; owned */
    size_t point_count, point_capacity;
    struct group_map map; /* set by capture_split_open, and so is: */
    struct split split;
};

void capture_split_clear(struct capture_split *split);

/* What the command line asks for, in the place of what stands there. groups: a file, "each" or
 * "off"; sky: an order, -1: not given; suns: a file; NULL: not given. A file of suns has a line
 * each: X Y Z, a direction towards the sun, or AZIMUTH ELEVATION in degrees, the azimuth from
 * where a sky's picture has its centre, counter-clockwise from above, about the settings'
 * sky_up. */
struct error *capture_split_read_groups(struct capture_split *split, const char *groups);
struct error *capture_split_read_suns(struct capture_split *split, const char *suns,
                                      const struct scene_settings *settings);

/* Takes the positions of the probes of a stream. Errors: none are there; two are alike. */
struct error *capture_split_read_points(struct capture_split *split, const char *points);

struct error *capture_split_to_header(const struct capture_split *split,
                                      struct stream_header *header);
struct error *capture_split_from_header(struct capture_split *split,
                                        const struct stream_header *header);

/* Whether a header's probes were captured by the same parts. What differs is an error. */
struct error *capture_split_check_same(const struct stream_header *before,
                                       const struct stream_header *now);

/* Finds the groups in a scene as it is traced, and lets the path tracer split light. Nothing where
 * nothing is asked for. */
struct error *capture_split_open(struct capture_split *split, const struct scene *scene,
                                 const struct groups_way *way, struct path_tracer *path);

/* How many parts there are, each as wide as sh. */
size_t capture_split_count(const struct capture_split *split);

/* A column of parts: its name, and its parts `first` .. `first` + `count` - 1. */
struct split_column {
    char name[64];
    size_t first, count;
};

/* The i-th column of values (error: of their errors); false: there are no more. */
bool capture_split_column(const struct capture_split *split, size_t i, bool surface, bool error,
                          struct split_column *column);

#endif
