/* SPDX-License-Identifier: Apache-2.0 */
#include "image/image.h"
#include "base/array.h"
#include "base/error.h"
#include "image/image_formats.h"
#include "math/luminance.h"

#include <inttypes.h>
#include <limits.h>
#include <stb_image.h>
#include <stdlib.h>
#include <string.h>
#include <webp/decode.h>

const float image_linear[256] = {
    0.f,           0.000303527f,  0.000607054f, 0.000910581f,  0.001214108f,  0.001517635f,
    0.001821162f,  0.0021246888f, 0.002428216f, 0.0027317428f, 0.00303527f,   0.0033465358f,
    0.0036765074f, 0.004024717f,  0.004391442f, 0.0047769533f, 0.0051815165f, 0.0056053917f,
    0.006048833f,  0.0065120906f, 0.00699541f,  0.007499032f,  0.008023193f,  0.008568126f,
    0.009134059f,  0.009721218f,  0.010329823f, 0.010960094f,  0.011612245f,  0.012286488f,
    0.0129830325f, 0.013702083f,  0.014443844f, 0.015208514f,  0.015996294f,  0.016807375f,
    0.017641954f,  0.01850022f,   0.019382361f, 0.020288562f,  0.02121901f,   0.022173885f,
    0.023153367f,  0.024157632f,  0.02518686f,  0.026241222f,  0.027320892f,  0.02842604f,
    0.029556835f,  0.030713445f,  0.031896032f, 0.033104766f,  0.034339808f,  0.035601314f,
    0.03688945f,   0.038204372f,  0.039546236f, 0.0409152f,    0.04231141f,   0.04373503f,
    0.045186203f,  0.046665087f,  0.048171826f, 0.049706567f,  0.051269457f,  0.052860647f,
    0.054480277f,  0.05612849f,   0.05780543f,  0.059511237f,  0.061246052f,  0.063010015f,
    0.064803265f,  0.06662594f,   0.06847817f,  0.070360094f,  0.07227185f,   0.07421357f,
    0.07618538f,   0.07818742f,   0.08021982f,  0.08228271f,   0.08437621f,   0.08650046f,
    0.08865558f,   0.09084171f,   0.093058966f, 0.09530747f,   0.09758735f,   0.099898726f,
    0.10224173f,   0.104616486f,  0.107023105f, 0.10946171f,   0.11193243f,   0.114435375f,
    0.116970666f,  0.11953843f,   0.122138776f, 0.12477182f,   0.12743768f,   0.13013647f,
    0.13286832f,   0.13563333f,   0.13843161f,  0.14126329f,   0.14412847f,   0.14702727f,
    0.14995979f,   0.15292615f,   0.15592647f,  0.15896083f,   0.16202937f,   0.1651322f,
    0.1682694f,    0.17144111f,   0.1746474f,   0.17788842f,   0.18116425f,   0.18447499f,
    0.18782078f,   0.19120169f,   0.19461784f,  0.19806932f,   0.20155625f,   0.20507874f,
    0.20863687f,   0.21223076f,   0.2158605f,   0.2195262f,    0.22322796f,   0.22696587f,
    0.23074006f,   0.23455058f,   0.23839757f,  0.24228112f,   0.24620132f,   0.25015828f,
    0.2541521f,    0.25818285f,   0.26225066f,  0.2663556f,    0.2704978f,    0.2746773f,
    0.27889428f,   0.28314874f,   0.28744084f,  0.29177064f,   0.29613826f,   0.30054379f,
    0.3049873f,    0.30946892f,   0.31398872f,  0.31854677f,   0.3231432f,    0.3277781f,
    0.33245152f,   0.33716363f,   0.34191442f,  0.34670407f,   0.3515326f,    0.35640013f,
    0.3613068f,    0.3662526f,    0.3712377f,   0.37626213f,   0.38132602f,   0.38642943f,
    0.39157248f,   0.39675522f,   0.40197778f,  0.4072402f,    0.4125426f,    0.41788507f,
    0.42326766f,   0.4286905f,    0.43415365f,  0.43965718f,   0.4452012f,    0.4507858f,
    0.45641103f,   0.462077f,     0.4677838f,   0.47353148f,   0.47932017f,   0.48514995f,
    0.49102086f,   0.49693298f,   0.5028865f,   0.50888133f,   0.5149177f,    0.52099556f,
    0.5271151f,    0.5332764f,    0.5394795f,   0.54572445f,   0.55201143f,   0.5583404f,
    0.5647115f,    0.57112485f,   0.57758045f,  0.58407843f,   0.59061885f,   0.59720176f,
    0.60382736f,   0.61049557f,   0.6172066f,   0.6239604f,    0.63075715f,   0.63759685f,
    0.6444797f,    0.65140563f,   0.65837485f,  0.6653873f,    0.67244315f,   0.6795425f,
    0.6866853f,    0.69387174f,   0.7011019f,   0.70837575f,   0.7156935f,    0.7230551f,
    0.73046076f,   0.7379104f,    0.7454042f,   0.7529422f,    0.7605245f,    0.76815116f,
    0.7758222f,    0.7835378f,    0.7912979f,   0.7991027f,    0.80695224f,   0.8148466f,
    0.82278574f,   0.8307699f,    0.838799f,    0.8468732f,    0.8549926f,    0.8631572f,
    0.8713671f,    0.8796224f,    0.8879231f,   0.8962694f,    0.9046612f,    0.91309863f,
    0.92158186f,   0.9301109f,    0.9386857f,   0.9473065f,    0.9559733f,    0.9646863f,
    0.9734453f,    0.9822506f,    0.9911021f,   1.f,
};

struct error *image_check_sides(int64_t width, int64_t height)
{
    if (width < 1 || height < 1 || width > IMAGE_SIDE_MOST || height > IMAGE_SIDE_MOST)
        return error_new("a picture of %" PRId64 " x %" PRId64 " texels, expected 1 to %d a side",
                         width, height, IMAGE_SIDE_MOST);
    return NULL;
}

static bool is_webp(const unsigned char *data, size_t size)
{
    return size >= 12 && !memcmp(data, "RIFF", 4) && !memcmp(data + 8, "WEBP", 4);
}

static bool is_jpeg(const unsigned char *data, size_t size)
{
    return size >= 3 && !memcmp(data, "\xff\xd8\xff", 3);
}

bool image_is_known(const void *data, size_t size)
{
    return (size >= 4 && !memcmp(data, "\x89PNG", 4)) || is_jpeg(data, size) ||
           is_webp(data, size) || image_is_hdr(data, size) || image_is_exr(data, size);
}

/* Whether a JPEG's end mark follows its last scan; stb_image makes up what is missing. */
static bool jpeg_ends(const unsigned char *data, size_t size)
{
    size_t end = size;
    for (size_t i = size; i-- > 1;) {
        if (data[i - 1] == 0xff && data[i] == 0xd9)
            end = i;
        if (data[i - 1] == 0xff && data[i] == 0xda)
            break;
    }
    return end < size;
}

/* RGBA codes of an 8-bit picture; the caller frees them. */
static struct error *decode_bytes(const unsigned char *data, size_t size, uint8_t **rgba,
                                  int *width, int *height)
{
    struct error *err;
    if (is_webp(data, size)) {
        if (!WebPGetInfo(data, size, width, height))
            return error_new("a damaged WebP picture");
        err = image_check_sides(*width, *height);
        if (!err)
            err = array_create(rgba, 4 * (size_t)*width * (size_t)*height, 1);
        if (!err && !WebPDecodeRGBAInto(data, size, *rgba, 4 * (size_t)*width * (size_t)*height,
                                        4 * *width)) {
            free(*rgba);
            err = error_new("a damaged or animated WebP picture");
        }
        return err;
    }
    int channels;
    if (!stbi_info_from_memory(data, (int)size, width, height, &channels))
        return image_is_known(data, size)
                   ? error_new("a damaged picture (%s)", stbi_failure_reason())
                   : error_new("not a picture that can be read (%s)", stbi_failure_reason());
    if (is_jpeg(data, size) && !jpeg_ends(data, size))
        return error_new("a JPEG picture that is cut off: expected its end mark, got the end of "
                         "its %zu bytes",
                         size);
    err = image_check_sides(*width, *height);
    if (err)
        return err;
    *rgba = stbi_load_from_memory(data, (int)size, width, height, &channels, 4);
    return *rgba ? NULL : error_new("a damaged picture (%s)", stbi_failure_reason());
}

/* Packs RGBA codes in place into what the use asks for; returns the number of channels. */
static unsigned pack_bytes(uint8_t *rgba, size_t count, enum image_use use)
{
    bool opaque = true;
    for (size_t i = 0; i < count; i++)
        opaque = opaque && rgba[4 * i + 3] == 255;
    if (use == IMAGE_COLOUR && !opaque)
        return 4;
    if (use == IMAGE_COLOUR) {
        for (size_t i = 0; i < count; i++)
            memmove(rgba + 3 * i, rgba + 4 * i, 3);
        return 3;
    }
    for (size_t i = 0; i < count; i++) {
        const uint8_t *p = rgba + 4 * i;
        rgba[i] = opaque ? (uint8_t)((2126 * p[0] + 7152 * p[1] + 722 * p[2] + 5000) / 10000)
                         : p[3];
    }
    return 1;
}

static struct error *decode_floats(const void *data, size_t size, enum image_use use,
                                   struct image *image)
{
    struct image_floats light;
    struct error *err = image_is_hdr(data, size) ? image_decode_hdr(data, size, &light)
                                                 : image_decode_exr(data, size, &light);
    if (err)
        return err;
    float *rgb = light.rgb;
    const size_t count = (size_t)light.width * light.height;
    for (size_t i = 0; use == IMAGE_MASK && i < count; i++)
        rgb[i] = luminance_vec3f((struct vec3f){rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]});
    *image = (struct image){.width = light.width,
                            .height = light.height,
                            .channels = use == IMAGE_MASK ? 1 : 3,
                            .texels = rgb};
    return NULL;
}

/* Gives back what packing freed; a picture that cannot shrink stays as it is. */
static void shrink(struct image *image)
{
    const size_t texel = image->channels * (image->bytes ? sizeof(uint8_t) : sizeof(float));
    void *smaller = realloc(image->texels, image->width * (size_t)image->height * texel);
    if (smaller)
        image->texels = smaller;
}

struct error *image_decode(struct image *image, const void *data, size_t size, enum image_use use)
{
    *image = (struct image){0};
    if (size == 0)
        return error_new("an empty picture");
    if (size > INT_MAX)
        return error_new("a picture of %zu bytes, expected less than 2 GiB", size);
    struct error *err = NULL;
    if (image_is_hdr(data, size) || image_is_exr(data, size)) {
        err = decode_floats(data, size, use, image);
    } else {
        uint8_t *rgba = NULL;
        int width = 0, height = 0;
        err = decode_bytes(data, size, &rgba, &width, &height);
        if (!err) {
            image->width = (uint32_t)width;
            image->height = (uint32_t)height;
            image->channels = pack_bytes(rgba, (size_t)width * (size_t)height, use);
            image->bytes = true;
            image->texels = rgba;
        }
    }
    if (!err)
        shrink(image);
    return err;
}
