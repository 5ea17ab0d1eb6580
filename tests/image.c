/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures: every format gives the texels that were put in, and damage is an error. */
#include "base/error.h"
#include "image/image.h"
#include "support/tap.h"

#include <stb_image_write.h>
#include <stdint.h>
#include <string.h>
#include <webp/encode.h>

struct bytes {
    uint8_t *data;
    size_t size;
};

static void append(void *context, void *data, int size)
{
    struct bytes *to = context;
    to->data = realloc(to->data, to->size + (size_t)size);
    if (!to->data)
        bail("memory");
    memcpy(to->data + to->size, data, (size_t)size);
    to->size += (size_t)size;
}

static struct bytes png(int width, int height, int channels, const uint8_t *texels)
{
    struct bytes out = {0};
    stbi_write_png_to_func(append, &out, width, height, channels, texels, width * channels);
    return out;
}

/* Decodes and expects these channels and codes. */
static void expect(const char *name, struct bytes file, enum image_use use, uint32_t width,
                   uint32_t height, unsigned channels, const uint8_t *codes)
{
    struct image t = {0};
    struct error *err = image_decode(&t, file.data, file.size, use);
    const bool right = !err && t.bytes && t.width == width && t.height == height &&
                       t.channels == channels &&
                       !memcmp(t.texels, codes, (size_t)width * height * channels);
    ok(right, "%s%s%s", name, err ? ": " : "", err ? error_message(err) : "");
    error_destroy(err);
    free(t.texels);
}

static void test_codes(void)
{
    static const uint8_t grey[6] = {0, 1, 127, 128, 254, 255};
    static const uint8_t grey_rgb[18] = {0,   0,   0,   1,   1,   1,   127, 127, 127,
                                         128, 128, 128, 254, 254, 254, 255, 255, 255};
    static const uint8_t rgb[18] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 8, 7, 6, 5, 4, 3, 2, 1};
    static const uint8_t rgb_grey[6] = {54, 182, 18, 8, 5, 2}; /* 0.2126 R + 0.7152 G + 0.0722 B */
    static const uint8_t rgba[24] = {255, 0, 0, 255, 0, 255, 0, 254, 0, 0, 255, 3,
                                     9,   8, 7, 0,   6, 5,   4, 128, 3, 2, 1,   1};
    static const uint8_t alpha[6] = {255, 254, 3, 0, 128, 1};
    uint8_t opaque[24], noise[3000];
    memcpy(opaque, rgba, sizeof opaque);
    for (int i = 0; i < 6; i++)
        opaque[4 * i + 3] = 255;
    struct bytes f = png(3, 2, 1, grey);
    expect("grey PNG as colour", f, IMAGE_COLOUR, 3, 2, 3, grey_rgb);
    expect("grey PNG as mask: its codes, unchanged", f, IMAGE_MASK, 3, 2, 1, grey);
    free(f.data);
    f = png(3, 2, 3, rgb);
    expect("RGB PNG", f, IMAGE_COLOUR, 3, 2, 3, rgb);
    expect("RGB PNG as mask: its luminance", f, IMAGE_MASK, 3, 2, 1, rgb_grey);
    free(f.data);
    f = png(3, 2, 4, rgba);
    expect("RGBA PNG", f, IMAGE_COLOUR, 3, 2, 4, rgba);
    expect("RGBA PNG as mask: its alpha", f, IMAGE_MASK, 3, 2, 1, alpha);
    free(f.data);
    f = png(3, 2, 4, opaque);
    expect("RGBA PNG that is opaque: no alpha kept", f, IMAGE_COLOUR, 3, 2, 3,
           (const uint8_t[]){255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 8, 7, 6, 5, 4, 3, 2, 1});
    free(f.data);
    f = (struct bytes){0};
    f.size = WebPEncodeLosslessRGB(rgb, 3, 2, 9, &f.data);
    expect("WebP", f, IMAGE_COLOUR, 3, 2, 3, rgb);
    WebPFree(f.data);
    f.size = WebPEncodeLosslessRGBA(rgba, 3, 2, 12, &f.data);
    expect("WebP's alpha as mask", f, IMAGE_MASK, 3, 2, 1, alpha);
    WebPFree(f.data);
    for (size_t i = 0; i < sizeof noise; i++)
        noise[i] = (uint8_t)(i * 2654435761u >> 13);
    f = png(1000, 1, 3, noise);
    expect("one row", f, IMAGE_COLOUR, 1000, 1, 3, noise);
    free(f.data);
}

static void test_lossy(void)
{
    uint8_t smooth[64 * 64 * 3];
    for (int i = 0; i < 64 * 64; i++) {
        smooth[3 * i] = (uint8_t)(i % 64 * 4);
        smooth[3 * i + 1] = (uint8_t)(i / 64 * 4);
        smooth[3 * i + 2] = 128;
    }
    struct bytes jpeg = {0}, webp = {0};
    stbi_write_jpg_to_func(append, &jpeg, 64, 64, 3, smooth, 95);
    webp.size = WebPEncodeRGB(smooth, 64, 64, 192, 95, &webp.data);
    const struct bytes files[] = {jpeg, webp};
    for (int f = 0; f < 2; f++) {
        struct image t = {0};
        struct error *err = image_decode(&t, files[f].data, files[f].size, IMAGE_COLOUR);
        double sum = 0;
        for (int i = 0; !err && i < 64 * 64 * 3; i++)
            sum += fabs((double)((const uint8_t *)t.texels)[i] - smooth[i]);
        ok(!err && t.width == 64 && t.channels == 3 && sum / (64 * 64 * 3) < 3,
           "%s: mean error of a code %.2f", f ? "lossy WebP" : "JPEG", sum / (64 * 64 * 3));
        error_destroy(err);
        free(t.texels);
    }
    free(jpeg.data);
    WebPFree(webp.data);
}

static void test_radiance(void)
{
    const float rgb[12] = {0, 0, 0, 1, 2, 3, 1e-6f, 1e-6f, 1e-6f, 65536, 1024, 512};
    struct bytes f = {0};
    stbi_write_hdr_to_func(append, &f, 2, 2, 3, rgb);
    struct image t = {0};
    struct error *err = image_decode(&t, f.data, f.size, IMAGE_COLOUR);
    double worst = 0;
    for (int i = 0; !err && i < 12; i++)
        worst =
            fmax(worst, fabs((double)((const float *)t.texels)[i] - (double)rgb[i]) /
                            fmax(fmax((double)rgb[i / 3 * 3], (double)rgb[i / 3 * 3 + 1]), 1e-9));
    ok(!err && !t.bytes && t.channels == 3 && worst < 0.01,
       "Radiance .hdr keeps its range: error %.4f of the largest channel", worst);
    error_destroy(err);
    free(t.texels);
    err = image_decode(&t, f.data, f.size, IMAGE_MASK);
    ok(!err && t.channels == 1 && fabs((double)((const float *)t.texels)[1] - 1.8596) < 0.02,
       "as a mask it gives its luminance");
    error_destroy(err);
    free(t.texels);
    free(f.data);
}

static void refuse(const char *name, const void *data, size_t size)
{
    struct image t = {0};
    struct error *err = image_decode(&t, data, size, IMAGE_COLOUR);
    ok(err && !t.texels, "refused, %s: %s", name, err ? error_message(err) : "");
    error_destroy(err);
}

/* Every shorter piece of a coded .hdr picture is refused, the whole is not. */
static void test_cut_radiance(void)
{
    float rgb[16 * 4 * 3];
    for (int i = 0; i < 16 * 4 * 3; i++)
        rgb[i] = (float)(i / 12 % 5);
    struct bytes f = {0};
    stbi_write_hdr_to_func(append, &f, 16, 4, 3, rgb);
    size_t accepted = 0;
    for (size_t size = 1; size <= f.size; size++) {
        struct image t = {0};
        struct error *err = image_decode(&t, f.data, size, IMAGE_COLOUR);
        accepted += !err;
        error_destroy(err);
        free(t.texels);
    }
    ok(accepted == 1, "an .hdr that is cut off is refused, wherever: %zu of %zu accepted", accepted,
       f.size);
    free(f.data);
}

static void test_damage(void)
{
    uint8_t noise[48];
    for (size_t i = 0; i < sizeof noise; i++)
        noise[i] = (uint8_t)(i * 37);
    struct bytes f = png(4, 4, 3, noise), w = {0};
    w.size = WebPEncodeLosslessRGB(noise, 4, 4, 12, &w.data);
    refuse("nothing", "", 0);
    refuse("text", "no picture at all, but text", 27);
    refuse("half a PNG", f.data, f.size / 2);
    refuse("half a WebP", w.data, w.size / 2);
    refuse("half the header of a WebP", w.data, 20);
    f.data[16] = 1; /* the width's highest byte: 2^24 texels */
    refuse("a PNG that claims to be huge", f.data, f.size);
    refuse("an .hdr without texels", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 4\n", 45);
    refuse("an .hdr that claims to be huge",
           "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99999 +X 99999\n", 53);
    free(f.data);
    WebPFree(w.data);
}

/* -- dialects of the Radiance format ---------------------------------------------------------- */

/* A header and texels as one file; expects these values of one channel, or this message. */
static void expect_light(const char *name, const char *header, const uint8_t *texels, size_t count,
                         uint32_t width, uint32_t height, const float *light)
{
    struct bytes f = {0};
    struct image t = {0};
    append(&f, (void *)(uintptr_t)header, (int)strlen(header));
    append(&f, (void *)(uintptr_t)texels, (int)count);
    struct error *err = image_decode(&t, f.data, f.size, IMAGE_COLOUR);
    bool right = !err && !t.bytes && t.width == width && t.height == height && t.channels == 3;
    for (uint32_t i = 0; right && i < 3 * width * height; i++)
        right = fabsf(((const float *)t.texels)[i] - light[i]) <= 1e-6f * light[i];
    ok(right, "%s%s%s", name, err ? ": " : "", err ? error_message(err) : "");
    error_destroy(err);
    free(t.texels);
    free(f.data);
}

/* Texel i is (i, 2 i, 3 i) / 128, wherever the file has it. */
static void test_orientations(void)
{
    static const char *const sides[] = {"-Y 2 +X 3", "-Y 2 -X 3", "+Y 2 +X 3", "+Y 2 -X 3",
                                        "+X 3 -Y 2", "+X 3 +Y 2", "-X 3 -Y 2", "-X 3 +Y 2"};
    /* the file's texels, by their place in the picture */
    static const int order[][6] = {{0, 1, 2, 3, 4, 5}, {2, 1, 0, 5, 4, 3}, {3, 4, 5, 0, 1, 2},
                                   {5, 4, 3, 2, 1, 0}, {0, 3, 1, 4, 2, 5}, {3, 0, 4, 1, 5, 2},
                                   {2, 5, 1, 4, 0, 3}, {5, 2, 4, 1, 3, 0}};
    float light[18];
    for (int i = 0; i < 18; i++)
        light[i] = (float)((i / 3 + 9) * (i % 3 + 1)) / 128;
    for (int k = 0; k < 8; k++) {
        char header[80];
        uint8_t texels[24];
        snprintf(header, sizeof header, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n%s\n", sides[k]);
        for (int i = 0; i < 24; i++)
            texels[i] = (uint8_t)(i % 4 < 3 ? (order[k][i / 4] + 9) * (i % 4 + 1) : 129);
        expect_light(sides[k], header, texels, sizeof texels, 3, 2, light);
    }
}

static void test_dialects(void)
{
    static const float ones[3 * 600] = {1, 1, 1};
    float even[3 * 600], xyz[] = {2.6896552f, 0, 0.06122446f}, last[] = {0.5f, 0.25f, 0.125f};
    uint8_t wide[8 + 4 * 16];
    for (int i = 0; i < 3 * 600; i++)
        even[i] = 1;
    /* 1 + 87 + 2 * 256 texels, over the ends of rows */
    static const uint8_t runs[] = {128, 128, 128, 129, 1, 1, 1, 87, 1, 1, 1, 2};
    static const uint8_t one[] = {128, 128, 128, 129}, cold[] = {128, 64, 32, 128},
                         x[] = {128, 0, 0, 129};
    expect_light("old run lengths, the second of 256 each", "#?RADIANCE\n\n-Y 6 +X 100\n", runs,
                 sizeof runs, 100, 6, even);
    expect_light("another name, no FORMAT, ends of lines of two bytes",
                 "#?RGBE\r\nSOFTWARE=x\r\n\r\n-Y 1 +X 1\r\n", one, 4, 1, 1, ones);
    expect_light("XYZE: equal energy is white", "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n",
                 one, 4, 1, 1, ones);
    expect_light("XYZE: X alone is red, and what is no colour is cut",
                 "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n", x, 4, 1, 1, xyz);
    expect_light("EXPOSURE and COLORCORR are divided out, all of them, but for those of others",
                 "#?RADIANCE\nEXPOSURE=4\nEXPOSURE = .25\n\tEXPOSURE=9\nEXPOSURE=1e0\n"
                 "COLORCORR= 1 .5 .25\nCOLORCORR=.5 .5 .5\n\n-Y 1 +X 1\n",
                 cold, 4, 1, 1, (const float[]){1, 1, 1});
    expect_light("EXPOSURE=.5 makes light of twice as much",
                 "#?RADIANCE\nEXPOSURE=.5\n\n-Y 1 +X 1\n", cold, 4, 1, 1,
                 (const float[]){1, 0.5f, 0.25f});
    expect_light("flat", "#?RADIANCE\n\n-Y 1 +X 1\n", cold, 4, 1, 1, last);
    /* rows of channels and of texels in one file, in columns */
    static const uint8_t coded[] = {2, 2, 0, 8, 136, 128, 136, 128, 136, 128, 136, 129};
    memcpy(wide, coded, sizeof coded);
    for (size_t i = 12; i < 12 + 4 * 8; i++)
        wide[i] = i % 4 == 3 ? 129 : 128;
    expect_light("scan lines coded and flat, in columns", "#?RADIANCE\n\n-X 2 +Y 8\n", wide, 44, 2,
                 8, even);
}

static void refuse_radiance(const char *header, const char *said)
{
    struct image t = {0};
    struct error *err = image_decode(&t, header, strlen(header), IMAGE_COLOUR);
    ok(err && strstr(error_message(err), said), "refused, '%s': %s", said,
       err ? error_message(err) : "");
    error_destroy(err);
    free(t.texels);
}

static void test_radiance_damage(void)
{
    refuse_radiance("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", "does not end");
    refuse_radiance("#?RADIANCE\nFORMAT=48-bit\n\n-Y 1 +X 1\nxxxx", "got '48-bit'");
    refuse_radiance("#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\nxxxx", "EXPOSURE: expected a number");
    refuse_radiance("#?RADIANCE\nCOLORCORR=1 2\n\n-Y 1 +X 1\nxxxx", "COLORCORR: expected 3");
    refuse_radiance("#?RADIANCE\n\n-Y 1 +Y 1\nxxxx", "got '-Y 1 +Y 1'");
    refuse_radiance("#?RADIANCE\n\n-Y 0 +X 1\nxxxx", "expected 1 to 16384 a side");
    refuse_radiance("#?RADIANCE\n\n-Y 1 +X 1\nxxx", "cut off");
    refuse_radiance("#?RADIANCE\n\n-Y 1 +X 1\n\1\1\1\1", "beyond its texels");
    refuse_radiance("#?RADIANCE\n\n-Y 1 +X 2\nxxxx\1\1\1\2", "beyond its texels");
    refuse_radiance("#?RADIANCE\n\n-Y 1 +X 9\n\2\2\1\1xxxx", "a scan line of 257 texels");
    refuse_radiance("#?RADIANCE\nEXPOSURE=1e-30\n\n-Y 1 +X 1\n\2\2\2\377", "too bright");
}

/* A picture that is cut off anywhere is refused, and known for what it was. */
static void test_cut(void)
{
    static uint8_t texels[32 * 32 * 3];
    for (size_t i = 0; i < sizeof texels; i++)
        texels[i] = (uint8_t)(i * i % 251);
    struct bytes files[3] = {png(32, 32, 3, texels)};
    stbi_write_jpg_to_func(append, &files[1], 32, 32, 3, texels, 90);
    files[2].size = WebPEncodeLosslessRGB(texels, 32, 32, 96, &files[2].data);
    for (int f = 0; f < 3; f++) {
        size_t accepted = 0, unknown = 0;
        for (size_t size = 0; size < files[f].size; size++) {
            struct image t = {0};
            struct error *err = image_decode(&t, files[f].data, size, IMAGE_COLOUR);
            accepted += !err;
            unknown += !image_is_known(files[f].data, size);
            error_destroy(err);
            free(t.texels);
        }
        ok(accepted <= (f == 0 ? 16 : 0) && unknown <= 12 && files[f].size > 300,
           "%s cut off is refused: %zu of %zu accepted, %zu not known",
           (const char *const[]){"a PNG", "a JPEG", "a WebP"}[f], accepted, files[f].size, unknown);
        if (f < 2)
            free(files[f].data);
        else
            WebPFree(files[f].data);
    }
}

int main(void)
{
    test_codes();
    test_cut();
    test_lossy();
    test_radiance();
    test_cut_radiance();
    test_orientations();
    test_dialects();
    test_radiance_damage();
    test_damage();
    return tap_done();
}
