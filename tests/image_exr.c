/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR: what the library writes in any compression, as rows and tiles, of any kind of number,
 * comes back as the light that was put in. */
#include "base/error.h"
#include "base/file.h"
#include "image/image.h"
#include "support/files.h"
#include "support/tap.h"

#include <openexr.h>
#include <stdint.h>
#include <string.h>

enum { W = 40, H = 20 };

struct form {
    const char *name;
    exr_compression_t compression;
    exr_pixel_type_t type;
    const char *channels[4]; /* the light's first; what comes behind them is no light */
    int light;               /* channels of light */
    int tile;                /* 0: rows */
    int left, top;           /* of the data window in the display window, which is larger by both */
    double error;            /* relative */
    bool second;             /* behind a part that has no light */
};

static double value_at(const struct form *form, int c, int x, int y)
{
    const double v = 1 + c % 3 + (x % 8) * 0.25 + (y % 4) * 2;
    return form->type == EXR_PIXEL_UINT ? floor(v) : v;
}

static void must_exr(exr_result_t code)
{
    if (code != EXR_ERR_SUCCESS)
        bail("%s", exr_get_default_error_message(code));
}

static void write_chunk(exr_context_t file, int part, const struct form *form,
                        const exr_chunk_info_t *chunk, int x0, int y0,
                        exr_encode_pipeline_t *encode, bool first)
{
    static union {
        float f;
        uint32_t u;
    } texels[4][W * H];
    must_exr(first ? exr_encoding_initialize(file, part, chunk, encode)
                   : exr_encoding_update(file, part, chunk, encode));
    for (int k = 0; k < encode->channel_count; k++) {
        exr_coding_channel_info_t *channel = &encode->channels[k];
        int c = 0;
        while (strcmp(form->channels[c], channel->channel_name))
            c++;
        for (int i = 0; i < chunk->width * chunk->height; i++) {
            const double v = value_at(form, c, x0 + i % chunk->width, y0 + i / chunk->width);
            if (form->type == EXR_PIXEL_UINT)
                texels[c][i].u = (uint32_t)v;
            else
                texels[c][i].f = (float)v;
        }
        channel->user_bytes_per_element = 4;
        channel->user_data_type = form->type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 4;
        channel->user_line_stride = 4 * chunk->width;
        channel->encode_from_ptr = (const uint8_t *)texels[c];
    }
    if (first)
        must_exr(exr_encoding_choose_default_routines(file, part, encode));
    must_exr(exr_encoding_run(file, part, encode));
}

static void add_part(exr_context_t file, const char *name, exr_storage_t storage,
                     const struct form *form)
{
    int part;
    must_exr(exr_add_part(file, name, storage, &part));
    must_exr(exr_initialize_required_attr_simple(file, part, W, H, form->compression));
    exr_attr_box2i_t stored, shown = {0};
    stored.min.x = form->left;
    stored.min.y = form->top;
    stored.max.x = form->left + W - 1;
    stored.max.y = form->top + H - 1;
    shown.max.x = W + form->left - 1;
    shown.max.y = H + form->top - 1;
    must_exr(exr_set_data_window(file, part, &stored));
    must_exr(exr_set_display_window(file, part, &shown));
    for (int c = 0; c < 4 && form->channels[c]; c++)
        must_exr(exr_add_channel(file, part, form->channels[c], form->type,
                                 EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    if (form->tile)
        must_exr(exr_set_tile_descriptor(file, part, (uint32_t)form->tile, (uint32_t)form->tile,
                                         EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN));
}

static void write_part(exr_context_t file, int part, const struct form *form)
{
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    bool first = true;
    int32_t lines = form->tile;
    if (!form->tile)
        must_exr(exr_get_scanlines_per_chunk(file, part, &lines));
    for (int y = 0; y < H; y += lines)
        for (int x = 0; x < W; x += form->tile ? form->tile : W) {
            must_exr(form->tile
                         ? exr_write_tile_chunk_info(file, part, x / lines, y / lines, 0, 0, &chunk)
                         : exr_write_scanline_chunk_info(file, part, form->top + y, &chunk));
            write_chunk(file, part, form, &chunk, x, y, &encode, first);
            first = false;
        }
    must_exr(exr_encoding_destroy(file, &encode));
}

static void write_exr(const char *path, const struct form *form)
{
    const struct form depth = {.compression = EXR_COMPRESSION_ZIP,
                               .type = EXR_PIXEL_FLOAT,
                               .channels = {"Z"},
                               .left = form->left,
                               .top = form->top};
    exr_context_t file;
    must_exr(exr_start_write(&file, path, EXR_WRITE_FILE_DIRECTLY, NULL));
    if (form->second)
        add_part(file, "depth", EXR_STORAGE_SCANLINE, &depth);
    add_part(file, "light", form->tile ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, form);
    must_exr(exr_write_header(file));
    if (form->second)
        write_part(file, 0, &depth);
    write_part(file, form->second, form);
    must_exr(exr_finish(&file));
}

/* The header alone: what is deep is told before anything is read. */
static void write_deep(const char *path)
{
    const struct form deep = {
        .compression = EXR_COMPRESSION_ZIPS, .type = EXR_PIXEL_HALF, .channels = {"R", "G", "B"}};
    exr_context_t file;
    must_exr(exr_start_write(&file, path, EXR_WRITE_FILE_DIRECTLY, NULL));
    add_part(file, "deep", EXR_STORAGE_DEEP_SCANLINE, &deep);
    must_exr(exr_write_header(file));
    char *data = NULL;
    size_t size = 0;
    struct error *err = file_read(path, &data, &size); /* the library removes what is not whole */
    must_exr(exr_finish(&file));
    if (err)
        bail("%s", error_message(err));
    files_write_bytes("deep.exr", data, size);
    free(data);
}

static struct error *read_exr(const char *path, size_t most, struct image *t)
{
    char *data = NULL;
    size_t size = 0;
    struct error *err = file_read(path, &data, &size);
    if (!err)
        err = image_decode(t, data, size < most ? size : most, IMAGE_COLOUR);
    free(data);
    return err;
}

static void test_form(const struct form *form)
{
    struct image t = {0};
    write_exr(files_path("a.exr"), form);
    struct error *err = read_exr(files_path("a.exr"), SIZE_MAX, &t);
    double worst = 0;
    const uint32_t width = (uint32_t)(W + form->left), height = (uint32_t)(H + form->top);
    const bool right = !err && !t.bytes && t.channels == 3 && t.width == width &&
                       t.height == height;
    for (int i = 0; right && i < (int)(3 * width * height); i++) {
        const int x = i / 3 % (int)width - form->left, y = i / 3 / (int)width - form->top;
        const double want = x < 0 || y < 0 ? 0 : value_at(form, form->light == 3 ? i % 3 : 0, x, y);
        worst = fmax(worst, fabs((double)((const float *)t.texels)[i] - want) / fmax(want, 1e-9));
    }
    ok(right && worst <= form->error, "%s: error %.2g%s%s", form->name, worst, err ? ": " : "",
       err ? error_message(err) : "");
    error_destroy(err);
    free(t.texels);
}

#define RGB                                                                                        \
    {                                                                                              \
        "R", "G", "B"                                                                              \
    }

static void test_forms(void)
{
    static const struct form forms[] = {
        {"half, ZIP", EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, RGB, 3, 0, 0, 0, 0, false},
        {"half, ZIPS", EXR_COMPRESSION_ZIPS, EXR_PIXEL_HALF, RGB, 3, 0, 0, 0, 0, false},
        {"half, RLE", EXR_COMPRESSION_RLE, EXR_PIXEL_HALF, RGB, 3, 0, 0, 0, 0, false},
        {"half, PIZ", EXR_COMPRESSION_PIZ, EXR_PIXEL_HALF, RGB, 3, 0, 0, 0, 0, false},
        {"float, none", EXR_COMPRESSION_NONE, EXR_PIXEL_FLOAT, RGB, 3, 0, 0, 0, 0, false},
        {"float, PIZ", EXR_COMPRESSION_PIZ, EXR_PIXEL_FLOAT, RGB, 3, 0, 0, 0, 0, false},
        {"float, PXR24", EXR_COMPRESSION_PXR24, EXR_PIXEL_FLOAT, RGB, 3, 0, 0, 0, 1e-4, false},
        {"half, B44", EXR_COMPRESSION_B44, EXR_PIXEL_HALF, RGB, 3, 0, 0, 0, 0.1, false},
        {"half, B44A", EXR_COMPRESSION_B44A, EXR_PIXEL_HALF, RGB, 3, 0, 0, 0, 0.1, false},
        {"whole numbers, ZIP", EXR_COMPRESSION_ZIP, EXR_PIXEL_UINT, RGB, 3, 0, 0, 0, 0, false},
        {"tiles, half, ZIP", EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, RGB, 3, 16, 0, 0, 0, false},
        {"tiles, float, none", EXR_COMPRESSION_NONE, EXR_PIXEL_FLOAT, RGB, 3, 7, 0, 0, 0, false},
        {"luminance alone", EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, {"Y"}, 1, 0, 0, 0, 0, false},
        {"luminance and two others",
         EXR_COMPRESSION_ZIP,
         EXR_PIXEL_HALF,
         {"Y", "A", "Z"},
         1,
         0,
         0,
         0,
         0,
         false},
        {"and three",
         EXR_COMPRESSION_PIZ,
         EXR_PIXEL_HALF,
         {"Y", "A", "U", "V"},
         1,
         0,
         0,
         0,
         0,
         false},
        {"light and another, floats",
         EXR_COMPRESSION_ZIP,
         EXR_PIXEL_FLOAT,
         {"R", "G", "B", "Z"},
         3,
         0,
         0,
         0,
         0,
         false},
        {"with alpha",
         EXR_COMPRESSION_ZIP,
         EXR_PIXEL_HALF,
         {"R", "G", "B", "A"},
         3,
         0,
         0,
         0,
         0,
         false},
        {"a layer",
         EXR_COMPRESSION_ZIP,
         EXR_PIXEL_HALF,
         {"View.Combined.R", "View.Combined.G", "View.Combined.B", "Depth.Z"},
         3,
         0,
         0,
         0,
         0,
         false},
        {"rows in a larger picture", EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, RGB, 3, 0, 5, 3, 0,
         false},
        {"tiles in a larger picture", EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, RGB, 3, 16, 5, 3, 0,
         false},
        {"what lies outside is cut", EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, RGB, 3, 0, -5, -3, 0,
         false},
        {"rows of the second part", EXR_COMPRESSION_PIZ, EXR_PIXEL_HALF, RGB, 3, 0, 5, 3, 0, true},
        {"tiles of it", EXR_COMPRESSION_ZIP, EXR_PIXEL_FLOAT, RGB, 3, 16, 0, 0, 0, true},
    };
    for (size_t i = 0; i < sizeof forms / sizeof *forms; i++)
        test_form(&forms[i]);
}

static void test_refused(void)
{
    struct image t = {0};
    const struct form odd = {"",   EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, {"A", "Z"}, 1, 0, 0, 0, 0,
                             false},
                      whole = {"", EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, RGB, 3, 0, 0, 0, 0, false},
                      two = {"", EXR_COMPRESSION_ZIP, EXR_PIXEL_HALF, {"A"}, 1, 0, 0, 0, 0, true};
    write_exr(files_path("a.exr"), &odd);
    struct error *err = read_exr(files_path("a.exr"), SIZE_MAX, &t);
    ok(err && strstr(error_message(err), "without channels R, G and B, or Y; it has 2"),
       "no light: %s", err ? error_message(err) : "");
    error_destroy(err);
    write_exr(files_path("a.exr"), &two);
    err = read_exr(files_path("a.exr"), SIZE_MAX, &t);
    ok(err && strstr(error_message(err), "2 parts (0 of them deep), of which none has channels"),
       "nor any in two parts: %s", err ? error_message(err) : "");
    error_destroy(err);
    write_deep(files_path("a.exr"));
    err = read_exr(files_path("deep.exr"), SIZE_MAX, &t);
    ok(err && strstr(error_message(err), "a deep OpenEXR picture"), "deep: %s",
       err ? error_message(err) : "");
    error_destroy(err);
    write_exr(files_path("a.exr"), &whole);
    char *data = NULL;
    size_t size = 0, accepted = 0;
    err = file_read(files_path("a.exr"), &data, &size);
    for (size_t most = 4; most < size && !err; most++) {
        struct error *cut = image_decode(&t, data, most, IMAGE_COLOUR);
        accepted += !cut;
        error_destroy(cut);
        free(t.texels);
    }
    ok(!err && size > 100 && !accepted, "cut off anywhere it is refused: %zu of %zu accepted",
       accepted, size);
    error_destroy(err);
    free(data);
}

int main(void)
{
    files_begin();
    test_forms();
    test_refused();
    files_end();
    return tap_done();
}
