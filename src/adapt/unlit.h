/* SPDX-License-Identifier: Apache-2.0 */
/* unlit: single probes for the largest areas without light (P. Sukys, "Light probe cloud generation
 * for games", Chalmers University, 2014, sec. 3.1.3).
 *
 * The text makes several of all black probes by k-means and leaves open how many, how it starts and
 * what an area is. Here areas are what hangs together: black probes that are neighbours and see
 * each other. Each area has a centre at least, where so many are wanted; further ones are drawn
 * with probability by squared distance (k-means++: Arthur and Vassilvitskii, "k-means++: the
 * advantages of careful seeding", SODA 2007). Then Lloyd's rounds, in which a probe belongs to the
 * nearest centre of its own area. A mean of a bent area may be in a wall, so the probe nearest to
 * it stands for the cluster.
 */
#ifndef UNLIT_H
#define UNLIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;
struct tracer;

/* A probe is black whose band 0 of luminance is 0, or below this share of the mean of all. */
#define UNLIT_SHARE 1e-4

struct unlit_job {
    size_t count;
    const double *position;      /* of black probes, 3 each */
    double reach;                /* of neighbours */
    const struct tracer *tracer; /* NULL: neighbours see each other */
    int wanted;                  /* 0: one for each area, UNLIT_MOST at the most */
    uint64_t seed;
};

enum { UNLIT_MOST = 64 };

struct unlit_cluster {
    uint32_t probe; /* that stands for it */
    uint32_t size;  /* how many probes it has */
};

/* Finds the clusters, the largest first: wanted, or fewer where there are fewer probes. *cluster is
 * owned by the caller. Areas beyond those wanted, the smallest, get none. */
struct error *unlit_find(const struct unlit_job *job, struct unlit_cluster **cluster,
                         size_t *clusters, size_t *areas);

/* Says on standard error how many stand for how many. */
void unlit_tell(const char *program, size_t count, size_t areas, size_t clusters);

/* Whether any of 32 rays around p meets a surface. */
bool unlit_sees_surface(const struct tracer *tracer, const double p[3]);

/* Twice the median distance from each of some positions to the nearest of all, which they are of; 0
 * where there are fewer than two. */
struct error *unlit_reach(size_t count, const double *position, size_t some, const double *of,
                          double *reach);

#endif
