/* SPDX-License-Identifier: Apache-2.0 */
/* vec: vectors of three, in double (positions) and in float (rays, colours).
 *
 * Passed and returned by value. Only + - * / and sqrt are used, which IEEE 754 rounds in one
 * way everywhere: the same bytes come out on every machine.
 */
#ifndef VEC_H
#define VEC_H

#include <math.h>

struct vec3 {
    double x, y, z;
};

struct vec3f {
    float x, y, z;
};

static inline struct vec3 vec3_load(const double p[3])
{
    return (struct vec3){p[0], p[1], p[2]};
}
static inline void vec3_store(double p[3], struct vec3 a)
{
    p[0] = a.x;
    p[1] = a.y;
    p[2] = a.z;
}
static inline struct vec3 vec3_add(struct vec3 a, struct vec3 b)
{
    return (struct vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline struct vec3 vec3_sub(struct vec3 a, struct vec3 b)
{
    return (struct vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline struct vec3 vec3_scale(double s, struct vec3 a)
{
    return (struct vec3){s * a.x, s * a.y, s * a.z};
}
/* a + s b */
static inline struct vec3 vec3_fma(struct vec3 a, double s, struct vec3 b)
{
    return (struct vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
static inline double vec3_dot(struct vec3 a, struct vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline struct vec3 vec3_cross(struct vec3 a, struct vec3 b)
{
    return (struct vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double vec3_length(struct vec3 a)
{
    return sqrt(vec3_dot(a, a));
}
/* a / |a|; the zero vector stays zero. */
static inline struct vec3 vec3_normalize(struct vec3 a)
{
    const double l = vec3_length(a);
    return l > 0 ? vec3_scale(1 / l, a) : a;
}

static inline struct vec3f vec3f_add(struct vec3f a, struct vec3f b)
{
    return (struct vec3f){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline struct vec3f vec3f_sub(struct vec3f a, struct vec3f b)
{
    return (struct vec3f){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline struct vec3f vec3f_scale(float s, struct vec3f a)
{
    return (struct vec3f){s * a.x, s * a.y, s * a.z};
}
/* a + s b */
static inline struct vec3f vec3f_fma(struct vec3f a, float s, struct vec3f b)
{
    return (struct vec3f){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
/* Component by component: a colour through a filter. */
static inline struct vec3f vec3f_mul(struct vec3f a, struct vec3f b)
{
    return (struct vec3f){a.x * b.x, a.y * b.y, a.z * b.z};
}
static inline float vec3f_dot(struct vec3f a, struct vec3f b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline struct vec3f vec3f_cross(struct vec3f a, struct vec3f b)
{
    return (struct vec3f){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline float vec3f_length(struct vec3f a)
{
    return sqrtf(vec3f_dot(a, a));
}
/* a / |a|; the zero vector stays zero. */
static inline struct vec3f vec3f_normalize(struct vec3f a)
{
    const float l = vec3f_length(a);
    return l > 0 ? vec3f_scale(1 / l, a) : a;
}
/* As fmaxf and fminf, which are calls into libm, for numbers that are not NaN. */
static inline float float_most(float a, float b)
{
    return a > b ? a : b;
}
static inline float float_least(float a, float b)
{
    return a < b ? a : b;
}
/* The largest component. */
static inline float vec3f_most(struct vec3f c)
{
    return float_most(c.x, float_most(c.y, c.z));
}

#endif
