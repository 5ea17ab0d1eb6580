/* SPDX-License-Identifier: Apache-2.0 */
#include "base/array.h"
#include "base/error.h"
#include "image/image_formats.h"

#include <math.h>
#include <openexr.h>
#include <stdlib.h>
#include <string.h>

enum { PLANES = 4 };

struct source {
    const unsigned char *data;
    size_t size;
};

struct file {
    exr_context_t context;
    int part;
    exr_attr_box2i_t shown, stored; /* the display window; the data window: both with their ends */
    const char *channel[3];         /* of red, green and blue; all the same: luminance */
    exr_decode_pipeline_t decode;
    bool decoding;
    float *chunk; /* planes of what is decoded at once: the light's, and one for the rest; owned */
    size_t capacity;
    struct image_floats *out;
};

bool image_is_exr(const void *data, size_t size)
{
    return size >= 4 && !memcmp(data, "v/1\1", 4);
}

/* -- what the library asks for ---------------------------------------------------------------- */

static int64_t read_bytes(exr_const_context_t context, void *user, void *buffer, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    (void)context;
    (void)fail;
    const struct source *source = user;
    if (offset >= source->size)
        return 0;
    const uint64_t left = source->size - offset, count = size < left ? size : left;
    memcpy(buffer, source->data + offset, count);
    return (int64_t)count;
}

static int64_t size_of(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((const struct source *)user)->size;
}

/* Its codes say enough; nothing below main prints. */
static void be_silent(exr_const_context_t context, exr_result_t code, const char *message)
{
    (void)context;
    (void)code;
    (void)message;
}

static struct error *damaged(exr_result_t code)
{
    return error_new("a damaged OpenEXR picture (%s)", exr_get_default_error_message(code));
}

/* -- header ----------------------------------------------------------------------------------- */

static struct error *read_windows(struct file *file)
{
    exr_result_t code = exr_get_display_window(file->context, file->part, &file->shown);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_data_window(file->context, file->part, &file->stored);
    if (code != EXR_ERR_SUCCESS)
        return damaged(code);
    const exr_attr_box2i_t a = file->shown, b = file->stored;
    const int64_t width = (int64_t)a.max.x - a.min.x + 1, height = (int64_t)a.max.y - a.min.y + 1;
    struct error *err = image_check_sides(width, height);
    if (!err)
        err = image_check_sides((int64_t)b.max.x - b.min.x + 1, (int64_t)b.max.y - b.min.y + 1);
    if (!err && (b.min.x > a.max.x || b.max.x < a.min.x || b.min.y > a.max.y || b.max.y < a.min.y))
        err = error_new("an OpenEXR picture whose data lie outside of what it shows");
    file->out->width = (uint32_t)width;
    file->out->height = (uint32_t)height;
    return err;
}

/* The first channel of this name, or of this name in a layer, in the layer that is given. */
static const exr_attr_chlist_entry_t *find_channel(const exr_attr_chlist_t *list, const char *layer,
                                                   size_t layer_length, const char *name)
{
    for (int i = 0; i < list->num_channels; i++) {
        const char *own = list->entries[i].name.str;
        if (!strncmp(own, layer, layer_length) && !strcmp(own + layer_length, name))
            return &list->entries[i];
    }
    return NULL;
}

/* Red, green and blue, or luminance alone, of the layer that the name of entry `from` begins with;
 * false: it has none. */
static bool take_layer(struct file *file, const exr_attr_chlist_t *list, const char *layer,
                       size_t length)
{
    static const char *const names[][3] = {{"R", "G", "B"}, {"r", "g", "b"}, {"Y", "Y", "Y"}};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        int found = 0;
        for (int c = 0; c < 3; c++) {
            const exr_attr_chlist_entry_t *entry = find_channel(list, layer, length, names[k][c]);
            if (!entry || entry->x_sampling != 1 || entry->y_sampling != 1)
                break;
            file->channel[c] = entry->name.str;
            found++;
        }
        if (found == 3)
            return true;
    }
    return false;
}

/* The channels of a part: those of no layer, or else of the first that has them. */
static struct error *choose_channels(struct file *file, bool *found)
{
    const exr_attr_chlist_t *list = NULL;
    const exr_result_t code = exr_get_channels(file->context, file->part, &list);
    *found = false;
    if (code != EXR_ERR_SUCCESS)
        return damaged(code);
    if (find_channel(list, "", 0, "RY") || find_channel(list, "", 0, "BY"))
        return error_new("an OpenEXR picture of luminance and chroma (Y, RY, BY), expected RGB");
    *found = take_layer(file, list, "", 0);
    for (int i = 0; i < list->num_channels && !*found; i++) {
        const char *name = list->entries[i].name.str, *dot = strrchr(name, '.');
        *found = dot && take_layer(file, list, name, (size_t)(dot - name) + 1);
    }
    return NULL;
}

static struct error *no_light(const struct file *file, int parts, int deep)
{
    const exr_attr_chlist_t *list = NULL;
    if (deep == parts)
        return error_new("a deep OpenEXR picture, expected one sample a texel: flatten it");
    if (parts > 1)
        return error_new("an OpenEXR picture of %d parts (%d of them deep), of which none has "
                         "channels R, G and B, or Y",
                         parts, deep);
    const exr_result_t code = exr_get_channels(file->context, 0, &list);
    if (code != EXR_ERR_SUCCESS)
        return damaged(code);
    return error_new("an OpenEXR picture without channels R, G and B, or Y; it has %d, the first "
                     "is '%.40s'",
                     list->num_channels, list->num_channels ? list->entries[0].name.str : "");
}

/* The first part that is not deep and has light. */
static struct error *choose_part(struct file *file)
{
    int parts = 0, deep = 0;
    exr_result_t code = exr_get_count(file->context, &parts);
    bool found = false;
    struct error *err = NULL;
    for (int i = 0; i < parts && !found && !err && code == EXR_ERR_SUCCESS; i++) {
        exr_storage_t storage;
        file->part = i;
        code = exr_get_storage(file->context, i, &storage);
        if (code == EXR_ERR_SUCCESS &&
            (storage == EXR_STORAGE_DEEP_SCANLINE || storage == EXR_STORAGE_DEEP_TILED))
            deep++;
        else if (code == EXR_ERR_SUCCESS)
            err = choose_channels(file, &found);
    }
    if (!err && code != EXR_ERR_SUCCESS)
        err = damaged(code);
    return err || found ? err : no_light(file, parts, deep);
}

/* -- texels ----------------------------------------------------------------------------------- */

/* The decoded part of the picture, with its left upper texel at (left, top) of the file's. */
static struct error *put(const struct file *file, int64_t left, int64_t top)
{
    const exr_chunk_info_t *chunk = &file->decode.chunk;
    const int64_t plane = (int64_t)chunk->width * chunk->height;
    for (int64_t j = 0; j < chunk->height; j++) {
        const int64_t y = top + j - file->shown.min.y;
        if (y < 0 || y >= file->out->height)
            continue;
        for (int64_t i = 0; i < chunk->width; i++) {
            const int64_t x = left + i - file->shown.min.x;
            if (x < 0 || x >= file->out->width)
                continue;
            for (int c = 0; c < 3; c++) {
                const float light = file->chunk[c * plane + j * chunk->width + i];
                if (!isfinite(light))
                    return error_new("texel (%d, %d) of an OpenEXR picture: expected finite light, "
                                     "got %g",
                                     (int)x, (int)y, (double)light);
                /* filters ring below 0 */
                file->out->rgb[3 * ((size_t)y * file->out->width + (size_t)x) + (size_t)c] =
                    light > 0 ? light : 0;
            }
        }
    }
    return NULL;
}

/* The pipeline writes floats of each channel to a plane. Those that are no light go to one of their
 * own: the library (3.1.5) writes to channels without a place where a file has three or four. */
static struct error *aim(struct file *file)
{
    const exr_chunk_info_t *chunk = &file->decode.chunk;
    if (chunk->width < 1 || chunk->height < 1)
        return damaged(EXR_ERR_CORRUPT_CHUNK);
    const size_t plane = (size_t)chunk->width * (size_t)chunk->height;
    struct error *err =
        array_reserve(&file->chunk, &file->capacity, PLANES * plane, sizeof *file->chunk);
    for (int k = 0; k < file->decode.channel_count && !err; k++) {
        exr_coding_channel_info_t *channel = &file->decode.channels[k];
        float *to = file->chunk + (PLANES - 1) * plane;
        for (int c = 2; c >= 0; c--)
            if (!strcmp(channel->channel_name, file->channel[c]))
                to = file->chunk + (size_t)c * plane;
        channel->decode_to_ptr = (uint8_t *)to;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = (int32_t)sizeof(float) * chunk->width;
    }
    return err;
}

static const char *compression_name(const struct file *file)
{
    exr_compression_t compression;
    if (exr_get_compression(file->context, file->part, &compression) != EXR_ERR_SUCCESS)
        return "something";
    return compression == EXR_COMPRESSION_DWAA   ? "DWAA"
           : compression == EXR_COMPRESSION_DWAB ? "DWAB"
                                                 : "a method of its own";
}

static struct error *decode_chunk(struct file *file, const exr_chunk_info_t *chunk, int64_t left,
                                  int64_t top)
{
    exr_result_t code =
        file->decoding ? exr_decoding_update(file->context, file->part, chunk, &file->decode)
                       : exr_decoding_initialize(file->context, file->part, chunk, &file->decode);
    if (code != EXR_ERR_SUCCESS)
        return damaged(code);
    struct error *err = aim(file);
    if (err)
        return err;
    if (!file->decoding)
        code = exr_decoding_choose_default_routines(file->context, file->part, &file->decode);
    file->decoding = true;
    if (code == EXR_ERR_SUCCESS)
        code = exr_decoding_run(file->context, file->part, &file->decode);
    if (code == EXR_ERR_FEATURE_NOT_IMPLEMENTED)
        return error_new("an OpenEXR picture compressed with %s, which is not read: save it with "
                         "ZIP or PIZ",
                         compression_name(file));
    if (code != EXR_ERR_SUCCESS)
        return damaged(code);
    const size_t texels = (size_t)chunk->width * (size_t)chunk->height;
    for (size_t c = 1; c < 3 && !strcmp(file->channel[0], file->channel[1]); c++)
        memcpy(file->chunk + c * texels, file->chunk, texels * sizeof *file->chunk);
    return put(file, left, top);
}

static struct error *read_scanlines(struct file *file)
{
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(file->context, file->part, &lines);
    if (code != EXR_ERR_SUCCESS || lines < 1)
        return damaged(code);
    struct error *err = NULL;
    for (int64_t y = file->stored.min.y; y <= file->stored.max.y && !err; y += lines) {
        exr_chunk_info_t chunk;
        code = exr_read_scanline_chunk_info(file->context, file->part, (int)y, &chunk);
        err = code == EXR_ERR_SUCCESS ? decode_chunk(file, &chunk, file->stored.min.x, y)
                                      : damaged(code);
    }
    return err;
}

/* The largest level alone. */
static struct error *read_tiles(struct file *file)
{
    int32_t width = 0, height = 0;
    exr_result_t code = exr_get_tile_sizes(file->context, file->part, 0, 0, &width, &height);
    if (code != EXR_ERR_SUCCESS || width < 1 || height < 1)
        return damaged(code);
    const exr_attr_box2i_t all = file->stored;
    struct error *err = NULL;
    for (int64_t y = all.min.y; y <= all.max.y && !err; y += height)
        for (int64_t x = all.min.x; x <= all.max.x && !err; x += width) {
            exr_chunk_info_t chunk;
            code = exr_read_tile_chunk_info(file->context, file->part,
                                            (int)((x - all.min.x) / width),
                                            (int)((y - all.min.y) / height), 0, 0, &chunk);
            err = code == EXR_ERR_SUCCESS ? decode_chunk(file, &chunk, x, y) : damaged(code);
        }
    return err;
}

struct error *image_decode_exr(const void *data, size_t size, struct image_floats *out)
{
    *out = (struct image_floats){0};
    struct source source = {data, size};
    struct file file = {.out = out};
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = be_silent;
    start.user_data = &source;
    start.read_fn = read_bytes;
    start.size_fn = size_of;
    start.max_tile_width = start.max_tile_height = IMAGE_SIDE_MOST;
    start.flags = EXR_CONTEXT_FLAG_SILENT_HEADER_PARSE |
                  EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    const exr_result_t code = exr_start_read(&file.context, "picture", &start);
    if (code != EXR_ERR_SUCCESS)
        return damaged(code);
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    struct error *err = choose_part(&file);
    if (!err)
        err = read_windows(&file);
    if (!err)
        err = array_create(&out->rgb, 3 * (size_t)out->width * out->height, sizeof *out->rgb);
    if (!err) {
        exr_get_storage(file.context, file.part, &storage);
        err = storage == EXR_STORAGE_TILED ? read_tiles(&file) : read_scanlines(&file);
    }
    exr_decoding_destroy(file.context, &file.decode);
    exr_finish(&file.context);
    free(file.chunk);
    if (err) {
        free(out->rgb);
        out->rgb = NULL;
    }
    return err;
}
