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

static void make_seeds(void)
{
    static const uint8_t coded[] = {2, 2,   0,   8,   136, 128, 136, 128, 136, 128,
                                    4, 129, 130, 131, 9,   132, 7,   2,   2,   0,
                                    8, 136, 128, 136, 128, 136, 128, 136, 129};
    static const uint8_t old[] = {128, 128, 128, 129, 1, 1, 1, 87, 1, 1, 1, 2};
    add("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 2 +X 8\n", coded, sizeof coded);
    add("#?RGBE\nFORMAT=32-bit_rle_xyze\nCOLORCORR=1 2 3\n\n+X 6 -Y 100\n", old, sizeof old);
    add("#?RADIANCE\n\n-Y 2 +X 1\n", coded, 8);
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
        uint8_t *exact = size ? realloc(data, size) : data;
        LLVMFuzzerTestOneInput(exact ? exact : data, size);
        free(exact ? exact : data);
    }
    ok(true, "%ld pictures end as light or an error", mutations);
    return tap_done();
}

#endif
