/* angle: sine, cosine and arc tangent that come out the same on every machine.
 *
 * libm picks its instructions by the processor, so its last bit differs between machines; these use + - * /
 * alone. Based on: S. L. Moshier, Cephes Mathematical Library, sin.c and atan.c. Within 5e-16 of the true value
 * for |x| up to 1e4. Arguments must be finite.
 */
#ifndef ANGLE_H
#define ANGLE_H

/* Radians. */
double angle_sin(double x);
double angle_cos(double x);

/* The angle of (x, y) from the x axis, in [-pi, pi]; 0 for (0, 0). */
double angle_atan2(double y, double x);

/* x and y, the cosine and sine of 2 pi `turn`, for turn in [0, 1], in single precision (within 2e-7): for directions drawn at random. */
void angle_turn(float turn, float *x, float *y);

#define ANGLE_PI 3.14159265358979323846

#endif
