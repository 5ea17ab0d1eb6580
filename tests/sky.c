/* SPDX-License-Identifier: Apache-2.0 */
/* Drawing directions from a sky picture: the density is that of the draws, adds up to one over the
 * sphere, and goes with the light that arrives. */
#include "math/angle.h"
#include "math/random.h"
#include "scene/scene.h"
#include "scene/scene_shade.h"
#include "support/tap.h"
#include "trace/sky.h"

enum { COLUMNS = 24, ROWS = 12, TEXELS = ROWS * COLUMNS };

/* A picture with two suns, one at the edge where the picture meets itself, and black texels. */
struct picture {
    float texels[3 * TEXELS];
    struct scene_texture texture;
    struct scene scene;
};

static void picture_fill(struct picture *p, float sun)
{
    struct random r = random_start(3, 0, 0);
    *p = (struct picture){.scene.sky.radiance = {2, 1, 0.5}};
    for (size_t i = 0; i < TEXELS; i++)
        for (size_t k = 0; k < 3; k++)
            p->texels[3 * i + k] = i / COLUMNS == 8 ? 0 : 0.5f + random_float(&r);
    for (size_t k = 0; k < 3; k++) {
        p->texels[3 * (2 * COLUMNS + 5) + k] += sun;
        p->texels[3 * (5 * COLUMNS + COLUMNS - 1) + k] += sun / 4;
    }
    p->texture = (struct scene_texture){.width = COLUMNS,
                                        .height = ROWS,
                                        .channels = 3,
                                        .texels = p->texels,
                                        .wrap_v = SCENE_CLAMP};
    p->scene.sky.picture = &p->texture;
}

static double solid_angle(size_t row)
{
    return 2 * ANGLE_PI / COLUMNS *
           (cos(ANGLE_PI * (double)row / ROWS) - cos(ANGLE_PI * (double)(row + 1) / ROWS));
}

/* The direction of a place in the picture: x of COLUMNS from the left, y of ROWS from the top. */
static struct vec3f direction_at(double x, double y)
{
    const double azimuth = 2 * ANGLE_PI * (x / COLUMNS - 0.5), zenith = ANGLE_PI * y / ROWS;
    return (struct vec3f){(float)(sin(zenith) * cos(azimuth)), (float)cos(zenith),
                          (float)(sin(zenith) * sin(azimuth))};
}

static size_t texel_of(struct vec3f d)
{
    const double x = (0.5 + atan2((double)d.z, (double)d.x) / (2 * ANGLE_PI)) * COLUMNS,
                 y = acos(fmin(fmax((double)d.y, -1), 1)) / ANGLE_PI * ROWS;
    const size_t column = (size_t)x, row = (size_t)y;
    return (row < ROWS ? row : ROWS - 1) * COLUMNS + (column < COLUMNS ? column : COLUMNS - 1);
}

/* Luminance of the picture as it is seen, the mean over a texel's place. */
static double luminance_seen(const struct picture *p, size_t texel)
{
    enum { PARTS = 8 };
    double sum = 0;
    for (int i = 0; i < PARTS * PARTS; i++) {
        const double x = (double)(texel % COLUMNS) + (i % PARTS + 0.5) / PARTS,
                     y = (double)(texel / COLUMNS) + (i / PARTS + 0.5) / PARTS;
        const struct vec3f rgb = scene_sky_radiance(&p->scene, direction_at(x, y));
        sum += 0.2126 * (double)rgb.x + 0.7152 * (double)rgb.y + 0.0722 * (double)rgb.z;
    }
    return sum / (PARTS * PARTS);
}

static void test_density(const struct picture *p, const struct sky *sky)
{
    double sum = 0, total = 0, off = 0;
    for (size_t i = 0; i < TEXELS; i++)
        total += luminance_seen(p, i) * solid_angle(i / COLUMNS);
    for (size_t i = 0; i < TEXELS; i++) {
        const struct vec3f middle =
            direction_at((double)(i % COLUMNS) + 0.5, (double)(i / COLUMNS) + 0.5);
        const double density = (double)sky_density(sky, middle);
        sum += density * solid_angle(i / COLUMNS);
        off = fmax(off, fabs(density * total / luminance_seen(p, i) - 1));
    }
    ok(fabs(sum - 1) < 1e-6, "the density adds up to one over the sphere (off by %.1e)", sum - 1);
    ok(off < 1e-5, "it goes with the luminance that arrives (%.1e)", off);
}

static void test_draws(const struct sky *sky)
{
    enum { DRAWS = 400000 };
    struct random r = random_start(4, 0, 0);
    static size_t count[TEXELS];
    size_t unlike = 0;
    double length_off = 0, chi = 0;
    for (int i = 0; i < DRAWS; i++) {
        float density;
        const double x = random_double(&r);
        const struct vec3f d = sky_sample(sky, x, random_double(&r), &density);
        length_off = fmax(length_off, fabs((double)vec3f_length(d) - 1));
        unlike += sky_density(sky, d) != density;
        count[texel_of(d)]++;
    }
    for (size_t i = 0; i < TEXELS; i++) {
        const struct vec3f middle =
            direction_at((double)(i % COLUMNS) + 0.5, (double)(i / COLUMNS) + 0.5);
        const double expected = DRAWS * (double)sky_density(sky, middle) * solid_angle(i / COLUMNS);
        chi += ((double)count[i] - expected) * ((double)count[i] - expected) / expected;
    }
    ok(length_off < 1e-6, "directions are unit (%.1e)", length_off);
    /* a float may round a direction over the edge of its texel, one in some hundred thousand */
    ok(unlike < DRAWS / 20000, "a draw has the density that is told of it (%zu of %d have not)",
       unlike, DRAWS);
    /* chi squared has mean n and variance 2 n: within 5 standard deviations */
    ok(chi < TEXELS - 1 + 5 * sqrt(2 * (TEXELS - 1)),
       "texels are drawn as often as the density says (chi squared %.1f of %d)", chi, TEXELS - 1);
}

/* The ends of [0, 1) draw directions that have a density: never a texel without light. */
static void test_ends(const struct sky *sky)
{
    const double end[2] = {0, 1 - 0x1p-53};
    bool lit = true;
    for (int i = 0; i < 4; i++) {
        float density;
        const struct vec3f d = sky_sample(sky, end[i % 2], end[i / 2], &density);
        lit &= density > 0 && isfinite(d.x) && isfinite(d.y) && isfinite(d.z);
    }
    ok(lit, "so do the ends of the interval that they are drawn by");
}

int main(void)
{
    static struct picture p;
    struct sky sky;
    picture_fill(&p, 2000);
    must(sky_init(&sky, &p.scene));
    ok(sky.rows == ROWS && sky.columns == COLUMNS, "a picture with suns is drawn from");
    test_density(&p, &sky);
    test_draws(&sky);
    test_ends(&sky);
    sky_clear(&sky);
    picture_fill(&p, 0);
    must(sky_init(&sky, &p.scene));
    ok(!sky.rows, "one that is nearly even is not");
    sky_clear(&sky);
    p.scene.sky.picture = NULL;
    must(sky_init(&sky, &p.scene));
    ok(!sky.rows, "nor is a sky without one");
    sky_clear(&sky);
    return tap_done();
}
