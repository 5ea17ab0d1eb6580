/* SPDX-License-Identifier: Apache-2.0 */
/* Arithmetic that everything stands on: the same on every machine, and what the textbooks say. */
#include "math/affine.h"
#include "math/angle.h"
#include "math/box.h"
#include "math/cell.h"
#include "math/direction.h"
#include "math/hash.h"
#include "math/luminance.h"
#include "math/power.h"
#include "math/random.h"
#include "math/sort.h"
#include "support/tap.h"

static bool vec3_is(struct vec3 a, double x, double y, double z)
{
    return a.x == x && a.y == y && a.z == z;
}

static void test_affine(void)
{
    /* x' = 2 y + 10, y' = -3 x + z, z' = z / 2 - 1: det = 2 * 3 / 2 */
    const double m[12] = {0, 2, 0, 10, -3, 0, 1, 0, 0, 0, 0.5, -1};
    const float f[12] = {0, 2, 0, 10, -3, 0, 1, 0, 0, 0, 0.5f, -1};
    const double p[3] = {1, 2, 4}, origin[3] = {0};
    ok(vec3_is(affine_point(m, p), 14, 1, 1), "a point is turned, scaled, sheared and moved");
    ok(vec3_is(affine_point(m, origin), 10, 0, -1), "the origin goes where the last column says");
    const struct vec3f q = affine_pointf(f, (const float[3]){1, 2, 4});
    ok(q.x == 14 && q.y == 1 && q.z == 1, "in float as well");
    ok(affine_determinant(m) == 3 && !affine_mirrors(m), "volumes grow by the determinant");
    const double mirror[12] = {1, 0, 0, 5, 0, 2, 0, 6, 0, 0, -4, 7};
    ok(affine_determinant(mirror) == -8 && affine_mirrors(mirror), "a mirror's is negative");

    /* The determinant is the volume that the images of the unit cube's edges span. */
    struct random r = random_start(4, 0, 0);
    double worst = 0;
    for (int i = 0; i < 1000; i++) {
        double any[12];
        for (int k = 0; k < 12; k++)
            any[k] = 2 * random_double(&r) - 1;
        const struct vec3 at = affine_point(any, origin);
        struct vec3 edge[3];
        for (int k = 0; k < 3; k++)
            edge[k] = vec3_sub(affine_point(any, (const double[3]){k == 0, k == 1, k == 2}), at);
        const double volume = vec3_dot(edge[0], vec3_cross(edge[1], edge[2]));
        worst = fmax(worst, fabs(volume - affine_determinant(any)));
    }
    ok(worst < 1e-14, "1000 random maps: the volume of the unit cube's image (%.1e)", worst);
}

static void test_box(void)
{
    struct box box = box_empty();
    ok(box.low[0] > box.high[0] && box_side(&box) == 0, "nothing has an empty box without a side");
    const double p[12] = {1, 5, -2, 0, 7, -2, 3, 6, -2, 1, 6, -2.5};
    box = box_of(4, p);
    ok(box.low[0] == 0 && box.low[1] == 5 && box.low[2] == -2.5 && box.high[0] == 3 &&
           box.high[1] == 7 && box.high[2] == -2,
       "a box reaches to the outermost points");
    ok(box_side(&box) == 3, "its side is the longest");
    box_add(&box, (const double[3]){1, 6, 100});
    ok(box.high[2] == 100 && box.low[2] == -2.5 && box.high[0] == 3 && box_side(&box) == 102.5,
       "a point outside makes it grow, on its own axis alone");
    box = box_of(1, p);
    ok(box.low[1] == 5 && box.high[1] == 5 && box_side(&box) == 0, "a point's box is the point");
}

static void test_direction(void)
{
    enum { N = 1000 };
    static struct vec3 d[N];
    struct vec3 sum = {0};
    double length = 0, step = 0, nearest = 4, second[3] = {0}, mixed = 0;
    int octant[8] = {0};
    for (int i = 0; i < N; i++) {
        d[i] = direction_even(i, N);
        length = fmax(length, fabs(vec3_length(d[i]) - 1));
        step = fmax(step, fabs((i ? d[i - 1].z : 1 + 1.0 / N) - d[i].z - 2.0 / N));
        sum = vec3_add(sum, d[i]);
        second[0] += d[i].x * d[i].x / N;
        second[1] += d[i].y * d[i].y / N;
        second[2] += d[i].z * d[i].z / N;
        mixed += (d[i].x * d[i].y + d[i].y * d[i].z + d[i].z * d[i].x) / N;
        octant[(d[i].x > 0) | (d[i].y > 0) << 1 | (d[i].z > 0) << 2]++;
        for (int j = 0; j < i; j++)
            nearest = fmin(nearest, vec3_length(vec3_sub(d[i], d[j])));
    }
    ok(length < 2e-15, "even directions have length 1 (%.1e)", length);
    ok(step < 1e-15, "they go from the top down by even steps: each has a belt of one area (%.1e)",
       step);
    ok(vec3_length(sum) / N < 1e-3, "their mean is 0 (%.1e)", vec3_length(sum) / N);
    ok(fabs(second[0] * 3 - 1) < 1e-3 && fabs(second[1] * 3 - 1) < 1e-3 &&
           fabs(second[2] * 3 - 1) < 1e-3 && fabs(mixed) < 1e-3,
       "no axis has more of them than another");
    int least = N, most = 0;
    for (int k = 0; k < 8; k++) {
        least = octant[k] < least ? octant[k] : least;
        most = octant[k] > most ? octant[k] : most;
    }
    ok(least >= N / 8 - 4 && most <= N / 8 + 4, "an eighth of them in each octant: %d to %d", least,
       most);
    /* the best of all packings has 3.809 / sqrt(N) */
    ok(nearest * sqrt(N) > 3, "none are near each other: %.2f / sqrt(N)", nearest * sqrt(N));
}

static void test_luminance(void)
{
    const double white[3] = {1, 1, 1}, rgb[3] = {0.25, 2, 16};
    const float rgbf[3] = {0.25f, 2, 16};
    ok(fabs(luminance_f64(white) - 1) < 1e-15, "white has the luminance of its channels");
    ok(luminance_f64((const double[3]){1, 0, 0}) == 0.2126 &&
           luminance_f64((const double[3]){0, 1, 0}) == 0.7152 &&
           luminance_f64((const double[3]){0, 0, 1}) == 0.0722,
       "red, green and blue weigh what Rec. 709 says");
    ok(luminance_f32(rgbf) == luminance_f64(rgb), "floats are summed in double");
    ok(fabs((double)luminance_vec3f((struct vec3f){0.25f, 2, 16}) - luminance_f64(rgb)) < 1e-6 &&
           luminance_vec3f((struct vec3f){0, 1, 0}) == 0.7152f,
       "or in float");
}

static void test_sort(void)
{
    enum { N = 1000 };
    static double x[N];
    static float y[N];
    struct random r = random_start(2, 0, 0);
    double before = 0, after = 0; /* sums of cubes: whole numbers */
    for (int i = 0; i < N; i++) {
        x[i] = (double)(random_u32(&r) % 500) - 250; /* some twice */
        y[i] = (float)x[i];
        before += x[i] * x[i] * x[i];
    }
    sort_doubles(N, x);
    sort_floats(N, y);
    bool ascending = true, same = true;
    for (int i = 0; i < N; i++) {
        ascending = ascending && (!i || x[i - 1] <= x[i]);
        same = same && (float)x[i] == y[i];
        after += x[i] * x[i] * x[i];
    }
    ok(ascending && after == before, "numbers are put in ascending order, and none is lost");
    ok(same, "floats as doubles");

    /* the one at each rank, from values that were found in before, in all sizes */
    bool found = true;
    for (size_t size = 1; size <= N; size = size * 3 / 2 + 1) {
        static double drawn[N], sorted[N];
        for (size_t i = 0; i < size; i++)
            drawn[i] = sorted[i] = (double)(random_u32(&r) % (uint32_t)(2 * size));
        sort_doubles(size, sorted);
        for (size_t k = 0; k < size; k += 1 + size / 40) {
            const double at = sort_find(size, drawn, (k * 7) % size);
            found = found && at == sorted[(k * 7) % size];
        }
    }
    ok(found, "what would be at a place is found without sorting");
}

static void test_cell(void)
{
    const double s = 1 / sqrt(2), regular[4][3] = {{1, 0, -s}, {-1, 0, -s}, {0, 1, s}, {0, -1, s}};
    double angle[6], worst = 0;
    cell_dihedral(regular, angle);
    for (int k = 0; k < 6; k++)
        worst = fmax(worst, fabs(angle[k] - acos(1.0 / 3) * 180 / ANGLE_PI));
    ok(worst < 1e-9, "dihedral angles of a regular tetrahedron are 70.53 degrees");
    const double half[3][3] = {{0, 0, 1}, {sqrt(3), 0, 1}, {0, 1, 1}};
    cell_corner_angles(half, angle);
    ok(fabs(angle[0] - 90) < 1e-12 && fabs(angle[1] - 30) < 1e-12 && fabs(angle[2] - 60) < 1e-12,
       "angles of half a regular triangle are 90, 30 and 60 degrees");
    const double flat[3][3] = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}};
    cell_corner_angles(flat, angle);
    ok(angle[0] == 0 && angle[1] == 180 && angle[2] == 0, "a flat one has 0, 180 and 0");
}

static void test_random(void)
{
    const double p[3] = {1, -0.0, 3}, q[3] = {1, 0, 3};
    ok(random_hash_position(p) == random_hash_position(q), "-0 and 0 are one position");
    struct random a = random_start(1, 2, 3), b = random_start(1, 2, 3), c = random_start(1, 2, 4),
                  d = random_start(2, 2, 3), e = random_start(1, 3, 3);
    int same = 0, clash = 0;
    for (int i = 0; i < 1000; i++) {
        const uint32_t x = random_u32(&a);
        same += x == random_u32(&b);
        clash += (x == random_u32(&c)) + (x == random_u32(&d)) + (x == random_u32(&e));
    }
    ok(same == 1000, "one name, one stream");
    ok(clash <= 1, "another seed, name or index is another stream: %d of 3000 numbers agree",
       clash);

    /* Mean and variance of a uniform variable: z-scores within 4.5 (7e-6 two-sided). */
    enum { N = 200000 };
    double sum = 0, square = 0;
    bool inside = true;
    for (uint32_t i = 0; i < N; i++) {
        struct random r = random_start(9, 8, i);
        const double x = i % 2 ? random_double(&r) : (double)random_float(&r);
        inside = inside && x >= 0 && x < 1;
        sum += x - 0.5;
        square += (x - 0.5) * (x - 0.5);
    }
    const double z_mean = sum / sqrt(N / 12.0), z_variance = (square - N / 12.0) / sqrt(N / 180.0);
    ok(inside, "uniform numbers lie in [0, 1)");
    ok(fabs(z_mean) < 4.5, "their mean is 1/2 (z = %.2f)", z_mean);
    ok(fabs(z_variance) < 4.5, "their variance is 1/12 (z = %.2f)", z_variance);
}

static void test_angle(void)
{
    double sine = 0, cosine = 0, tangent = 0;
    struct random r = random_start(1, 0, 0);
    for (int i = 0; i < 300000; i++) {
        const double x = (random_double(&r) - 0.5) * (i % 2 ? 2e4 : 8);
        sine = fmax(sine, fabs(angle_sin(x) - sin(x)));
        cosine = fmax(cosine, fabs(angle_cos(x) - cos(x)));
        const double a = (random_double(&r) - 0.5) * (i % 3 ? 1 : 1e-8),
                     b = (random_double(&r) - 0.5) * (i % 5 ? 1 : 1e-8);
        tangent = fmax(tangent, fabs(angle_atan2(a, b) - atan2(a, b)));
    }
    ok(sine < 5e-16 && cosine < 5e-16, "sine and cosine agree with libm: %.1e, %.1e", sine, cosine);
    ok(tangent < 9e-16, "so does the arc tangent: %.1e", tangent);
    ok(angle_atan2(0, -1) == ANGLE_PI && angle_atan2(0, 1) == 0 && angle_atan2(0, 0) == 0 &&
           angle_atan2(1, 0) == ANGLE_PI / 2,
       "the arc tangent is exact on the axes");
}

static void test_powers(void)
{
    double log_worst = 0, exp_worst = 0, power_worst = 0;
    for (int i = -3000; i <= 3000; i++) {
        const double x = exp(i / 10.0 + 0.0137), y = i / 5.0 + 0.0137;
        log_worst = fmax(log_worst, fabs(power_log(x) - log(x)) / (1 + fabs(log(x))));
        exp_worst = fmax(exp_worst, fabs(power_exp(y) / exp(y) - 1) / (1 + fabs(y)));
        power_worst = fmax(
            power_worst,
            fabs(power_of(fabs(i / 100.0) + 1e-9, 0.7) / pow(fabs(i / 100.0) + 1e-9, 0.7) - 1));
    }
    ok(log_worst < 4e-16 && exp_worst < 4e-16, "log and exp are libm's (%.1e, %.1e)", log_worst,
       exp_worst);
    ok(power_worst < 4e-15 && power_of(0, 0.5) == 0 && power_of(1, 0.3) == 1,
       "so are powers (%.1e); of 0 and 1 they are exact", power_worst);
}

static void test_hash(void)
{
    ok(hash_bytes("", 0) == 0x2d06800538d394c2, "the hash of nothing is XXH3's");
    unsigned char bytes[5000];
    for (size_t i = 0; i < sizeof bytes; i++)
        bytes[i] = (unsigned char)(i * i >> 3);
    struct hash whole, parts, seeded;
    hash_start(&whole, 0);
    hash_add(&whole, bytes, sizeof bytes);
    hash_start(&parts, 0);
    for (size_t i = 0, some = 1; i < sizeof bytes; i += some, some = some * 2 % 997) {
        some = some < sizeof bytes - i ? some : sizeof bytes - i;
        hash_add(&parts, bytes + i, some);
    }
    ok(hash_value(&whole) == hash_value(&parts) &&
           hash_value(&whole) == hash_bytes(bytes, sizeof bytes),
       "in one piece or in many, bytes have one hash");
    hash_start(&seeded, 1);
    hash_add(&seeded, bytes, sizeof bytes);
    ok(hash_value(&seeded) != hash_value(&whole), "another seed, another hash");
}

int main(void)
{
    test_random();
    test_angle();
    test_powers();
    test_luminance();
    test_affine();
    test_box();
    test_direction();
    test_sort();
    test_cell();
    test_hash();
    return tap_done();
}
