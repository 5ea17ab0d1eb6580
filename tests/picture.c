/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures: colour spaces and maps have the values that are published; what is written
 * reads back; screens show what IEC 61966-2-1 says; FLIP has its paper's values. */
#include "base/error.h"
#include "image/annotate.h"
#include "image/cielab.h"
#include "image/colour_map.h"
#include "image/compare.h"
#include "image/display.h"
#include "image/flip.h"
#include "image/image.h"
#include "image/picture.h"
#include "math/luminance.h"
#include "support/files.h"
#include "support/tap.h"

/* Whether it failed, saying this. */
static bool fails(struct error *err, const char *text)
{
    const bool said = err && strstr(error_message(err), text);
    if (err && !said)
        printf("# %s\n", error_message(err));
    error_destroy(err);
    return said;
}

static void test_screen(void)
{
    bool same = true, nearest = true;
    for (int code = 0; code < 256; code++) {
        const double encoded = code / 255.0, light = encoded <= 0.04045
                                                         ? encoded / 12.92
                                                         : pow((encoded + 0.055) / 1.055, 2.4);
        same = same && display_code(light) == code;
        if (code < 255) { /* the border between two codes is half way between their lights */
            const double middle = ((double)image_linear[code] + (double)image_linear[code + 1]) / 2;
            nearest = nearest && display_code(middle * (1 - 1e-12)) == code &&
                      display_code(middle * (1 + 1e-12)) == code + 1;
        }
    }
    ok(same, "the light that IEC 61966-2-1 gives each sRGB code is shown as that code");
    ok(nearest && display_code(-1) == 0 && display_code(7) == 255,
       "other light as the nearest; beyond the ends as the ends");
    ok(display_tone(DISPLAY_CLIP, 0.3) == 0.3 && display_tone(DISPLAY_CLIP, 3) == 1 &&
           display_tone(DISPLAY_CLIP, -1) == 0,
       "clip clips");
    ok(fabs(display_tone(DISPLAY_FILMIC, 1 / 0.6) - 2.54 / 3.16) < 1e-12 &&
           display_tone(DISPLAY_FILMIC, 1e30) == 1 && display_tone(DISPLAY_FILMIC, 0) == 0,
       "the filmic curve is the published one");
}

static void test_colours(void)
{
    double lab[3], rgb[3], worst = 0;
    cielab_of((const double[3]){1, 0, 0}, lab);
    ok(fabs(lab[0] - 53.24) < 0.01 && fabs(lab[1] - 80.09) < 0.01 && fabs(lab[2] - 67.20) < 0.01,
       "red is L*a*b* 53.24, 80.09, 67.20");
    cielab_of((const double[3]){1, 1, 1}, lab);
    ok(fabs(lab[0] - 100) < 1e-9 && fabs(lab[1]) < 1e-9 && fabs(lab[2]) < 1e-9,
       "white is 100, 0, 0");
    for (int i = 0; i < 216; i++) {
        const double c[3] = {i % 6 / 5.0, i / 6 % 6 / 5.0, i / 36 / 5.0};
        cielab_of(c, lab);
        cielab_to(lab, rgb);
        for (int k = 0; k < 3; k++)
            worst = fmax(worst, fabs(rgb[k] - c[k]));
    }
    ok(worst < 1e-12, "and back (%.1e)", worst);
}

static int code_distance(struct vec3f c, int r, int g, int b)
{
    const int dr = abs(display_code((double)c.x) - r), dg = abs(display_code((double)c.y) - g),
              db = abs(display_code((double)c.z) - b);
    return dr > dg ? dr > db ? dr : db : dg > db ? dg : db;
}

static void test_maps(void)
{
    static const int cool[11][3] = {{59, 76, 192},   {68, 90, 204},   {77, 104, 215},
                                    {87, 117, 225},  {98, 130, 234},  {108, 142, 241},
                                    {119, 154, 247}, {130, 165, 251}, {141, 176, 254},
                                    {152, 185, 255}, {163, 194, 255}};
    int worst = 0;
    for (int i = 0; i < 11; i++) {
        const int d = code_distance(colour_map_at(COLOUR_COOL_WARM, i / 32.0), cool[i][0],
                                    cool[i][1], cool[i][2]);
        worst = d > worst ? d : worst;
    }
    ok(worst <= 1, "cool to warm has Moreland's published colours (%d codes off)", worst);
    ok(code_distance(colour_map_at(COLOUR_COOL_WARM, 0.5), 221, 221, 221) <= 1 &&
           code_distance(colour_map_at(COLOUR_COOL_WARM, 1), 180, 4, 38) <= 1 &&
           code_distance(colour_map_at(COLOUR_COOL_WARM, -3), 59, 76, 192) <= 1,
       "grey in the middle, red at the end, ends beyond");
    ok(!code_distance(colour_map_at(COLOUR_MAGMA, 0), 0, 0, 4) &&
           !code_distance(colour_map_at(COLOUR_MAGMA, 1), 0xfc, 0xfd, 0xbf) &&
           code_distance(colour_map_at(COLOUR_MAGMA, 100 / 255.0), 0x89, 0x28, 0x81) <= 1 &&
           code_distance(colour_map_at(COLOUR_MAGMA, 196 / 255.0), 0xfc, 0x90, 0x65) <= 1,
       "magma is matplotlib's, between the kept colours too");
    bool rises = true;
    for (int i = 0; i < 255; i++)
        rises = rises && luminance_vec3f(colour_map_at(COLOUR_MAGMA, i / 255.0)) <=
                             luminance_vec3f(colour_map_at(COLOUR_MAGMA, (i + 1) / 255.0));
    ok(rises, "and rises in luminance all the way");
}

static void test_files(void)
{
    struct picture p = {0}, q = {0};
    must(picture_init(&p, 7, 5));
    for (size_t i = 0; i < 105; i++)
        p.rgb[i] = (float)(i * i) / 7 - 3;
    must(picture_write(&p, files_path("a.pfm"), false));
    must(picture_read(&q, files_path("a.pfm")));
    ok(q.width == 7 && q.height == 5 && !memcmp(p.rgb, q.rgb, 105 * sizeof(float)),
       "PFM reads back to the bit, below 0 too");
    picture_clear(&q);
    for (size_t i = 0; i < 105; i++)
        p.rgb[i] = image_linear[i * 2];
    must(picture_write(&p, files_path("a.png"), true));
    must(picture_read(&q, files_path("a.png")));
    ok(q.width == 7 && q.height == 5 && !memcmp(p.rgb, q.rgb, 105 * sizeof(float)),
       "PNG reads back the light of its codes");
    picture_clear(&p);
    picture_clear(&q);
    static const unsigned char big[] =
        "PF 1 2\n1.0\n\x3f\x80\0\0\x40\0\0\0\x40\x40\0\0\0\0\0\0\0\0\0\0\0\0\0\0";
    files_write_bytes("big.pfm", big, sizeof big - 1);
    must(picture_read(&q, files_path("big.pfm")));
    ok(q.rgb[3] == 1 && q.rgb[4] == 2 && q.rgb[5] == 3 && q.rgb[0] == 0,
       "a big-endian PFM, its bottom row first");
    picture_clear(&q);
    files_write("short.pfm", "PF\n2 2\n-1\n1234");
    ok(fails(picture_read(&q, files_path("short.pfm")), "expected 48 bytes of pixels, got 4"),
       "a PFM that is cut off is refused");
    files_write("zero.pfm", "PF\n0 2\n-1\n");
    ok(fails(picture_read(&q, files_path("zero.pfm")), "0 x 2 pixels"), "so is one of no pixels");
    files_write("head.pfm", "PF\n2 x\n-1\n");
    ok(fails(picture_read(&q, files_path("head.pfm")), "expected a colour PFM"),
       "and one with a damaged header");
    files_write_bytes("nan.pfm", "PF\n1 1\n-1\n\0\0\xc0\x7f\0\0\0\0\0\0\0\0", 22);
    ok(fails(picture_read(&q, files_path("nan.pfm")), "expected finite numbers"),
       "and one that holds a NaN");
    files_write("text.png", "hello");
    ok(fails(picture_read(&q, files_path("text.png")), "not a picture"), "and what is no picture");
    ok(fails(picture_read(&q, files_path("none.png")), "none.png"), "and what is not there");
}

/* -- FLIP -------------------------------------------------------------------------------------- */

static void fill(struct picture *p, size_t width, size_t height, float r, float g, float b)
{
    must(picture_init(p, width, height));
    for (size_t i = 0; i < width * height; i++)
        picture_set(p, i % width, i / width, (struct vec3f){r, g, b});
}

static void pattern(struct picture *p, size_t seed)
{
    must(picture_init(p, 32, 24));
    for (size_t y = 0; y < 24; y++)
        for (size_t x = 0; x < 32; x++)
            for (size_t k = 0; k < 3; k++)
                p->rgb[3 * (32 * y + x) + k] = (float)((x / (3 + seed) * 7 + y / (4 + seed) * 13 +
                                                        k * 5 + seed * 11 + x * y % 5) %
                                                       16) /
                                                   15 * 0.9f +
                                               0.05f;
}

static double flip_of(const struct picture *a, const struct picture *b, double ppd, float *map)
{
    double mean;
    must(flip_compare(a, b, ppd, 2, map, &mean));
    return mean;
}

static void test_flip(void)
{
    struct picture black, white, green, blue, grey, a, b;
    float map[32 * 24], other[32 * 24];
    fill(&black, 9, 6, 0, 0, 0);
    fill(&white, 9, 6, 1, 1, 1);
    fill(&green, 9, 6, 0, 1, 0);
    fill(&blue, 9, 6, 0, 0, 1);
    /* L* = 50 */
    fill(&grey, 9, 6, 0.18418651851244416f, 0.18418651851244416f, 0.18418651851244416f);
    pattern(&a, 0);
    pattern(&b, 1);
    const double ppd = flip_pixels_per_degree;
    ok(fabs(ppd - 67.0206) < 1e-4, "the paper's observer has 67 pixels a degree");
    ok(flip_of(&a, &a, ppd, map) == 0, "a picture and itself: 0");
    ok(fabs(flip_of(&green, &blue, ppd, map) - 1) < 1e-9,
       "green and blue, the most different of all: 1");
    /* Plain pictures have no edges: (pt + (100^0.7 - knee) / (most - knee) (1 - pt)), most =
     * 203.3017^0.7, knee = 0.4 most */
    ok(fabs(flip_of(&black, &white, ppd, map) - 0.96737976) < 1e-7,
       "black and white: 0.96738, by hand");
    ok(fabs(flip_of(&black, &grey, ppd, map) - 0.95 / 0.4 * pow(50 / 203.30165461, 0.7)) < 1e-6,
       "black and middle grey: by hand");
    /* An evaluation of the paper's formulas in two dimensions, apart from this code. */
    const double mean = flip_of(&a, &b, ppd, map);
    ok(fabs(mean - 0.5348872843) < 1e-6 && fabs((double)map[7 * 32 + 5] - 0.4472241322) < 1e-6 &&
           fabs((double)map[23 * 32 + 31] - 0.9721454158) < 1e-6,
       "two patterns: the mean and pixels of an evaluation in two dimensions (%.9f)", mean);
    ok(fabs(flip_of(&a, &b, 30, other) - 0.7077648079) < 1e-6, "and seen from nearer");
    double swapped, threads;
    must(flip_compare(&b, &a, ppd, 1, other, &swapped));
    must(flip_compare(&a, &b, ppd, 1, other, &threads));
    ok(fabs(swapped - mean) < 1e-15 && threads == mean && !memcmp(map, other, sizeof map),
       "it is symmetric, and the same for any number of threads");
    ok(fails(flip_compare(&a, &black, ppd, 1, map, &threads), "differ in size"),
       "sizes that differ are refused");
    struct picture *all[] = {&black, &white, &green, &blue, &grey, &a, &b};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        picture_clear(all[i]);
}

static void test_figures(void)
{
    struct picture truth, test, variance;
    struct compare c;
    float map[54];
    const struct compare_pair pair = {
        .truth = &truth, .test = &test, .variance = &variance, .screen = {1, DISPLAY_CLIP}};
    fill(&truth, 9, 6, 0.5f, 0.5f, 0.5f);
    fill(&test, 9, 6, 0.5f, 0.8f, 0.5f);
    fill(&variance, 9, 6, 0.0003f, 0.0002f, 0.0001f);
    must(compare_pictures(&pair, 1, map, &c));
    const double d = 0.3, rms = d / sqrt(3);
    ok(fabs(c.mean - 0.5) < 1e-7 && fabs(c.bias - 0.2) < 1e-6 && fabs(c.rmse - rms) < 1e-6 &&
           fabs(c.relative - 2 * rms) < 1e-6,
       "mean, bias, RMSE and relative RMSE are what they say");
    ok(fabs(c.noise - sqrt(0.0002)) < 1e-8 && c.flip > 0, "and so is the truth's noise");
    double exposure;
    must(compare_exposure(&truth, &exposure));
    ok(fabs(exposure - 1.4) < 1e-6, "exposure brings the 95th percentile to 0.7");
    struct picture small;
    fill(&small, 60, 20, 0.5f, 0.5f, 0.5f);
    annotate_scale(&small, COLOUR_MAGMA, "higher than its picture",
                   (const char *const[]){"0", "1", "2"});
    const struct vec3f there = picture_get(&small, 20, 0),
                       expected = colour_map_at(COLOUR_MAGMA, 8.5 / 36);
    ok(vec3f_length(vec3f_sub(there, expected)) < 1e-6f,
       "of a scale that is higher than its picture, there is what fits");
    picture_clear(&small);
    picture_clear(&truth);
    picture_clear(&test);
    picture_clear(&variance);
}

int main(void)
{
    files_begin();
    test_screen();
    test_colours();
    test_maps();
    test_files();
    test_flip();
    test_figures();
    files_end();
    return tap_done();
}
