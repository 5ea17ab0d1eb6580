/* SPDX-License-Identifier: Apache-2.0 */
/* visibility: what the sky that a point sees, as SH, tells of its occlusion, without rays.
 *
 * Band 0 is the share of directions that are open, band 1 their mean (Ren et al., "Real-time soft
 * shadows in dynamic scenes using spherical harmonic exponentiation", SIGGRAPH 2006;
 * Akenine-Moeller et al., "Real-time rendering", 4th ed., sec. 11.3.5).
 */
#ifndef VISIBILITY_H
#define VISIBILITY_H

struct error;
struct stream;

/* Adds columns ao, bent_normal, bent_length and cone (man probe.5), or makes them anew, from the
 * column visibility of a stream's probes, and takes the keys of how others were made away. An error
 * where there is none, or none of order 2 or more. */
struct error *visibility_derive(struct stream *stream);

#endif
