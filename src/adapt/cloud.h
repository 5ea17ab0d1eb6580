/* SPDX-License-Identifier: Apache-2.0 */
/* cloud: probes with their light, as methods of placing move, merge and add them (after P. Sukys,
 * "Light probe cloud generation for games", Chalmers University, 2014, sec. 3.1).
 *
 * It starts as a grid's nodes that are in the air, and probes that stay. Lengths are in spacings of
 * that grid, along each axis its own. Probes stand in order of their positions before each step, so
 * that no result depends on the order in which they came; ties are told by it as well. Pairs are
 * found by cubes of the distance asked for: a step costs what there is within that, not the square
 * of the cloud.
 */
#ifndef CLOUD_H
#define CLOUD_H

#include "adapt/contrast.h"
#include "adapt/place_light.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct cloud_probe {
    double position[3];
    int32_t kept;      /* its number in --keep; -1: it is not of these */
    uint32_t light;    /* its row of sh; CLOUD_NONE: not captured */
    float gradient[3]; /* and steps, of ascent: */
    double step;
    int32_t steps, back;
    int32_t cluster; /* of unlit probes: of how many it stands for; 0: it is lit */
};

#define CLOUD_NONE UINT32_MAX

/* Starts as {0}. */
struct cloud {
    struct place_light *light; /* borrowed */
    struct cloud_probe *probe; /* owned */
    size_t count, room;
    float *sh;     /* place_light_width() each; owned */
    double *noise; /* of each row, as of place_light_capture_noise; owned */
    size_t rows, sh_room, noise_room;
    double spacing[3];
};

/* Makes the grid that the options say, takes out what is in no air, adds the probes that stay, and
 * captures all. Errors: nothing is in the air; no light; a signal came before all was captured. */
struct error *cloud_start(struct cloud *cloud, struct place_light *light,
                          const struct place_options *options);
void cloud_clear(struct cloud *cloud);

/* The light of a probe that is captured. */
const float *cloud_light(const struct cloud *cloud, size_t probe);

/* The mean irradiance of all probes that are captured. */
double cloud_mean(const struct cloud *cloud);

struct error *cloud_add(struct cloud *cloud, const struct cloud_probe *probe);

/* Puts the probes into order of their positions, by x, then y, then z. */
void cloud_sort(struct cloud *cloud);

/* Captures those that are not captured yet; after a signal some still are not. */
struct error *cloud_capture(struct cloud *cloud);

/* Merges, nearest pairs first and each probe once at the most, those within `distance` whose
 * contrast, noise and all, is below `most`, which see each other and have no third probe between
 * them, into one at their midpoint, where that is in the air; captures these. One that stays takes
 * in the other where it is. *merged: pairs. */
struct error *cloud_merge(struct cloud *cloud, const struct contrast *contrast, double distance,
                          double most, size_t *merged);

/* How probes are spawned; lengths in spacings. */
struct cloud_spawn {
    double distance; /* of a pair at the most */
    double contrast; /* of a pair at the least */
    double least;    /* from any other probe */
    double most;     /* probes */
    bool full;       /* out: there is no room for one that was wanted */
};

/* Adds probes at midpoints of pairs, those of the highest contrast, less noise, first, in the air
 * and not too near to another; captures them. *added: how many. */
struct error *cloud_spawn(struct cloud *cloud, const struct contrast *contrast,
                          struct cloud_spawn *spawn, size_t *added);

/* Writes the probes: those that stay first, in their order, the others in order of position. */
struct error *cloud_give(struct cloud *cloud, struct place *place, int origin);

#endif
