/* SPDX-License-Identifier: Apache-2.0 */
/* A hostile picture: whatever its bytes, decoding ends, with light that is finite and not below 0,
 * or with an error.
 *
 *     fuzz_image [MUTATIONS [SEED [FILE]...]]     small pictures, mutated: of its own, which are
 * part of make check with few mutations, or these
 *
 * With clang -fsanitize=fuzzer -DFUZZ_ENGINE: LLVMFuzzerTestOneInput takes a file.
 */
#include "base/error.h"
#include "image/image.h"
#include "support/tap.h"

#include <stdint.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct image t;
    struct error *err = image_decode(&t, data, size, IMAGE_COLOUR);
    bool legal = !err == (t.texels != NULL);
    const float *light = t.bytes ? NULL : t.texels;
    for (size_t i = 0; legal && light && i < (size_t)t.width * t.height * t.channels; i++)
        legal = light[i] >= 0 && isfinite(light[i]);
    if (!legal) {
        fprintf(stderr, "broken: a picture of light, or an error\n");
        abort();
    }
    error_destroy(err);
    free(t.texels);
    return 0;
}

#ifndef FUZZ_ENGINE

static uint64_t state;

static uint32_t draw(uint32_t below)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)((state >> 33) % below);
}

enum { SEED_MOST = 32768, SEEDS_MOST = 8 };

static struct seed {
    uint8_t data[SEED_MOST];
    size_t size;
} seeds[SEEDS_MOST];

static int seed_count;

static void add(const char *header, const uint8_t *texels, size_t size)
{
    struct seed *s = &seeds[seed_count++];
    s->size = strlen(header);
    memcpy(s->data, header, s->size);
    memcpy(s->data + s->size, texels, size);
    s->size += size;
}

static void add_bytes(struct seed *s, const void *bytes, size_t size)
{
    memcpy(s->data + s->size, bytes, size);
    s->size += size;
}

static void add_int(struct seed *s, uint32_t value)
{
    add_bytes(s, &value, sizeof value);
}

/* An attribute of an OpenEXR header. */
static void add_attribute(struct seed *s, const char *name, const char *type, const void *bytes,
                          uint32_t size)
{
    add_bytes(s, name, strlen(name) + 1);
    add_bytes(s, type, strlen(type) + 1);
    add_int(s, size);
    add_bytes(s, bytes, size);
}

/* A small OpenEXR picture of floats, not compressed, of rows or tiles of a row each (The OpenEXR
 * File Layout). */
static void add_exr(const char *const *channel, int channels, bool tiled)
{
    enum { W = 4, H = 3 };
    static const int32_t window[] = {0, 0, W - 1, H - 1};
    static const float one = 1, centre[2];
    struct seed list = {.size = 0}, *s = &seeds[seed_count++];
    for (int c = 0; c < channels; c++) {
        static const int32_t rest[] = {0, 1, 1};
        add_bytes(&list, channel[c], strlen(channel[c]) + 1);
        add_int(&list, 2);
        add_bytes(&list, rest, sizeof rest);
    }
    add_bytes(&list, "", 1);
    s->size = 0;
    add_bytes(s, "v/1\1\2", 5);
    add_bytes(s, tiled ? "\2\0" : "\0\0", 3);
    add_attribute(s, "channels", "chlist", list.data, (uint32_t)list.size);
    add_attribute(s, "compression", "compression", "", 1);
    add_attribute(s, "dataWindow", "box2i", window, sizeof window);
    add_attribute(s, "displayWindow", "box2i", window, sizeof window);
    add_attribute(s, "lineOrder", "lineOrder", "", 1);
    add_attribute(s, "pixelAspectRatio", "float", &one, sizeof one);
    add_attribute(s, "screenWindowCenter", "v2f", centre, sizeof centre);
    add_attribute(s, "screenWindowWidth", "float", &one, sizeof one);
    if (tiled)
        add_attribute(s, "tiles", "tiledesc", "\4\0\0\0\1\0\0\0", 9);
    add_bytes(s, "", 1);
    const uint32_t row = 4u * W * (uint32_t)channels, head = tiled ? 20 : 8;
    for (uint32_t y = 0; y < H; y++) {
        const uint64_t at = s->size + (H - y) * sizeof(uint64_t) + (uint64_t)y * (head + row);
        add_bytes(s, &at, sizeof at);
    }
    for (uint32_t y = 0; y < H; y++) {
        const uint32_t tile[] = {0, y, 0, 0};
        if (tiled)
            add_bytes(s, tile, sizeof tile);
        else
            add_int(s, y);
        add_int(s, row);
        for (uint32_t i = 0; i < row / 4; i++) {
            const float light = 0.25f * (float)i;
            add_bytes(s, &light, sizeof light);
        }
    }
}

static void make_seeds(void)
{
    static const char *const rgb[] = {"B", "G", "R"}, *const deep[] = {"Z", "a.B", "a.G", "a.R"},
                             *const grey[] = {"Y"};
    static const uint8_t coded[] = {2, 2,   0,   8,   136, 128, 136, 128, 136, 128,
                                    4, 129, 130, 131, 9,   132, 7,   2,   2,   0,
                                    8, 136, 128, 136, 128, 136, 128, 136, 129};
    static const uint8_t old[] = {128, 128, 128, 129, 1, 1, 1, 87, 1, 1, 1, 2};
    add("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 2 +X 8\n", coded, sizeof coded);
    add("#?RGBE\nFORMAT=32-bit_rle_xyze\nCOLORCORR=1 2 3\n\n+X 6 -Y 100\n", old, sizeof old);
    add("#?RADIANCE\n\n-Y 2 +X 1\n", coded, 8);
    add_exr(rgb, 3, false);
    add_exr(deep, 4, false);
    add_exr(grey, 1, true);
}

static void add_file(const char *path)
{
    struct seed *s = &seeds[seed_count++];
    FILE *file = fopen(path, "rb");
    if (!file)
        bail("%s", path);
    s->size = fread(s->data, 1, SEED_MOST, file);
    fclose(file);
}

static bool is_picture(const struct seed *s)
{
    struct image t;
    struct error *err = image_decode(&t, s->data, s->size, IMAGE_COLOUR);
    const bool good = !err;
    if (err)
        printf("# %s\n", error_message(err));
    error_destroy(err);
    free(t.texels);
    return good;
}

/* A few bytes changed, and at times a piece cut out or the end cut off. */
static size_t mutate(uint8_t *data, size_t size)
{
    for (uint32_t changes = 1 + draw(6); changes-- && size;)
        switch (draw(4)) {
        case 0: data[draw((uint32_t)size)] ^= (uint8_t)(1u << draw(8)); break;
        case 1: data[draw((uint32_t)size)] = (uint8_t)draw(256); break;
        case 2: data[draw((uint32_t)size)] = (uint8_t) "\1\2\0\377\200-+XY9 \n="[draw(13)]; break;
        default:
            if (draw(8) == 0) {
                size = draw((uint32_t)size);
            } else {
                const size_t from = draw((uint32_t)size), count = draw(4);
                if (from + count < size) {
                    memmove(data + from, data + from + count, size - from - count);
                    size -= count;
                }
            }
        }
    return size;
}

int main(int argc, char **argv)
{
    const long mutations = argc > 1 ? atol(argv[1]) : tap_cases(3000);
    state = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    for (int i = 3; i < argc && seed_count < SEEDS_MOST; i++)
        add_file(argv[i]);
    if (!seed_count)
        make_seeds();
    for (long i = 0; i < mutations; i++) {
        const struct seed *s = &seeds[i % seed_count];
        uint8_t *data = malloc(s->size); /* to the byte: sanitizers see what is beyond */
        if (!data)
            bail("memory");
        memcpy(data, s->data, s->size);
        const size_t size = i < seed_count ? s->size : mutate(data, s->size);
        if (i < seed_count && argc <= 3)
            ok(is_picture(s), "seed %ld is a picture", i);
        uint8_t *exact = size ? realloc(data, size) : data;
        LLVMFuzzerTestOneInput(exact ? exact : data, size);
        free(exact ? exact : data);
    }
    ok(true, "%ld pictures end as light or an error", mutations);
    return tap_done();
}

#endif
