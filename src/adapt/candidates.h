/* SPDX-License-Identifier: Apache-2.0 */
/* candidates: points of the free space whose light is known, of which probes are chosen and by
 * which they are judged.
 *
 * Three kinds are made. Those of space are spread evenly over the free space of a box, one like
 * another, so that a mean over them is one over the space (R3 of M. Roberts, "The unreasonable
 * effectiveness of quasirandom sequences", 2018). Judges, 500 at the least and 2000 at the most,
 * are random, and no probe is ever put there. Those near surfaces stand a little off walls, edges
 * and corners that rays from points of space meet, of which the space's own ends are some: they can
 * be chosen, and count in no mean. Given positions are the fourth kind: probes already.
 *
 * Of each is kept, in luminance along the directions of sphere.h, the irradiance that a probe there
 * gives by SH of the order that is asked for, and the true one, by SH of order 5 or more, which
 * lose little of it (A_3 = 0 and A_5 = 0: sh.h); that of judges is the irradiance itself, for
 * beside a small lamp what SH lose is some percent of it. Both are of the same rays, and are kept
 * in two halves, of half the rays each, that share no random number: with s1, s2 the halves of what
 * probes give at a candidate and T1, T2 those of its truth, (s1 - T1)(s2 - T2) has the expectation
 * of the squared error, whatever the noise. So noise is neither taken for an error nor chased, and
 * nobody has to know how large it is.
 */
#ifndef CANDIDATES_H
#define CANDIDATES_H

#include "measure/sphere.h"
#include "place/space.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct capture_settings;
struct error;
struct path_tracer;
struct progress;
struct warnings;

enum candidate_kind { CANDIDATE_SPACE, CANDIDATE_JUDGE, CANDIDATE_SURFACE, CANDIDATE_GIVEN };

/* Halves, along the directions. */
struct candidate_light {
    float probe[2][SPHERE_COUNT], truth[2][SPHERE_COUNT];
};

/* Starts as {0}. */
struct candidates {
    size_t count;
    double *position; /* 3 each; this and what follows is owned */
    unsigned char *kind;
    bool *refined;
    struct candidate_light *light;
    /* Of those that are refined, or given: what a capture with candidates_settings finds, to the
     * bit, as candidates_capture_width floats; else NULL. Owned, and so is each */
    float **capture;
    /* standard error that the refined were captured to, as of capture_settings, and the irradiance
     * below which that is no share; 0: by rays alone */
    double noise, noise_floor;
    size_t captured;                        /* of them have their light, the first ones */
    size_t room[5];                         /* of the arrays */
    size_t space_tried, judges_tried, lost; /* numbers of the sequences that are used up */
    size_t space, judges;                   /* how many there are */
    double floor;                           /* of the ruler; set by candidates_capture */
};

/* How candidates are made. */
struct candidates_job {
    const struct path_tracer *path;
    /* as probes will be captured: order, rays; the first ones, where noise counts */
    const struct capture_settings *settings;
    bool by_noise;            /* it does: candidates_set_noise will be called */
    struct place_space space; /* that they are in */
    int threads;
    int inside_rays; /* as of place_inside_settings */
    double backface_share;
    struct progress *progress; /* may be NULL */
    struct warnings *warnings;
};

/* Adds a given position. */
struct error *candidates_give(struct candidates *c, const double position[3]);

/* Bytes, about, that choosing among so many of space takes, with judges and those near surfaces. */
double candidates_memory(size_t space);

/* Makes them so many of space, with judges and those near surfaces in proportion. Error: hardly
 * anything of the box is free. */
struct error *candidates_spread(struct candidates *c, const struct candidates_job *job,
                                size_t space);

/* Traces the light of those that have none, judges with more rays than probes have and what could
 * be chosen with fewer, until a signal comes (interrupt.h): then those that
 * still have none are none any more. */
struct error *candidates_capture(struct candidates *c, const struct candidates_job *job);

/* Makes it the standard error that probes are captured to, as a share of their irradiance, of less
 * than the ruler's floor of that. Those that were refined are to be anew. */
void candidates_set_noise(struct candidates *c, double noise);

/* Traces the light of those that became probes anew, with more rays, where that was not done
 * yet: what they say is in the errors of all around. Where noise counts both halves are the capture
 * itself, whose noise is then in those errors as well, and judges are traced anew to a standard
 * error in each half that is 2.5 times as large. */
struct error *candidates_refine(struct candidates *c, const struct candidates_job *job,
                                size_t count, const uint32_t *probe);

/* With what the probes are captured. */
struct capture_settings candidates_settings(const struct candidates *c,
                                            const struct candidates_job *job);

/* Floats of a capture: sh and sh_error, 3 * order^2 each, validity, depth, sky, and rays. */
size_t candidates_capture_width(const struct candidates_job *job);

void candidates_clear(struct candidates *c);

#endif
