/* SPDX-License-Identifier: Apache-2.0 */
/* cielab: CIE 1976 L*a*b* (ISO/CIE 11664-4) of linear Rec. 709 light, under its own white (D65):
 * white is L* = 100, a* = b* = 0. The same bytes on every machine (power.h).
 */
#ifndef CIELAB_H
#define CIELAB_H

/* XYZ over that of white; white is (1, 1, 1). */
void cielab_xyz(const double rgb[3], double xyz[3]);
void cielab_rgb(const double xyz[3], double rgb[3]);

/* L*, a*, b*, and back. */
void cielab_of(const double rgb[3], double lab[3]);
void cielab_to(const double lab[3], double rgb[3]);

#endif
