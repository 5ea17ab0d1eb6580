/* SPDX-License-Identifier: Apache-2.0 */
/* radiosity: the light that senders (capture/senders.h) scatter, by what falls on them.
 *
 * With direct irradiance D, albedo rho and form factors F of receivers to clusters, the radiance
 * that sender i scatters after n bounces is
 *
 *     B_1 = rho / pi D,      B_n = rho / pi (D + pi sum over links k of F_ik B_n-1,k),
 *
 * where the B of a cluster is the mean of its senders by their areas: radiosity by gathering
 * (Goral et al., "Modeling the interaction of light between diffuse surfaces", SIGGRAPH 1984), a
 * bounce a step, with links to clusters (Hanrahan et al., "A rapid hierarchical radiosity
 * algorithm", SIGGRAPH 1991).
 */
#ifndef RADIOSITY_H
#define RADIOSITY_H

struct error;
struct senders;

/* direct: irradiance, 3 a sender. node: 3 for each node of the tree; the radiance that its senders
 * scatter after `bounces`, 0 or more; no more are made when nothing changes. The same for any
 * number of threads. */
struct error *radiosity_solve(const struct senders *senders, const float *direct, int bounces,
                              int threads, double *node);

#endif
