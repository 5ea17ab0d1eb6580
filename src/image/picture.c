/* SPDX-License-Identifier: Apache-2.0 */
#include "image/picture.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "image/display.h"
#include "image/image.h"

#include <math.h>
#include <stb_image_write.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct error *picture_init(struct picture *p, size_t width, size_t height)
{
    *p = (struct picture){.width = width, .height = height};
    if (width < 1 || height < 1 || width > PICTURE_SIDE_MOST || height > PICTURE_SIDE_MOST)
        return error_new("a picture of %zu x %zu pixels, expected 1 to %d a side", width, height,
                         PICTURE_SIDE_MOST);
    return array_create(&p->rgb, 3 * width * height, sizeof *p->rgb);
}

void picture_clear(struct picture *p)
{
    free(p->rgb);
    *p = (struct picture){0};
}

void picture_paste(const struct picture *to, size_t x, size_t y, const struct picture *from)
{
    for (size_t row = 0; row < from->height && y + row < to->height; row++)
        for (size_t column = 0; column < from->width && x + column < to->width; column++)
            picture_set(to, x + column, y + row, picture_get(from, column, row));
}

/* -- writing ---------------------------------------------------------------------------------- */

static struct error *put(struct file_output *out, const void *bytes, size_t count)
{
    char *room;
    struct error *err = file_output_room(out, count, &room);
    if (err)
        return err;
    memcpy(room, bytes, count);
    out->count += count;
    return file_output_flush(out, false);
}

/* What stb_image_write hands on, and what became of it. */
struct png_target {
    struct file_output *out;
    struct error *err;
};

static void put_png(void *context, void *bytes, int count)
{
    struct png_target *target = context;
    if (!target->err)
        target->err = put(target->out, bytes, (size_t)count);
}

static struct error *write_png(const struct picture *p, struct file_output *out)
{
    uint8_t *code = NULL;
    const size_t count = p->width * p->height;
    struct png_target target = {.out = out};
    struct error *err = array_create(&code, 3 * count, 1);
    if (err)
        return err;
    display_codes(count, p->rgb, 1, code);
    const int done = stbi_write_png_to_func(put_png, &target, (int)p->width, (int)p->height, 3,
                                            code, 3 * (int)p->width);
    free(code);
    return target.err || done ? target.err : error_memory();
}

static struct error *write_pfm(const struct picture *p, struct file_output *out)
{
    char header[64];
    const int length = snprintf(header, sizeof header, "PF\n%zu %zu\n-1.0\n", p->width, p->height);
    struct error *err = put(out, header, (size_t)length);
    for (size_t row = p->height; row-- > 0 && !err;)
        err = put(out, p->rgb + 3 * row * p->width, 3 * p->width * sizeof *p->rgb);
    return err;
}

struct error *picture_try(const char *path)
{
    struct file_output out;
    struct stat status;
    if (!strcmp(path, "-") ||
        (!stat(path, &status) && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)))
        return NULL;
    struct error *err = file_output_open(&out, path, false);
    if (!err)
        file_output_abandon(&out);
    return err;
}

struct error *picture_write(const struct picture *p, const char *path, bool png)
{
    struct file_output out;
    struct error *err = file_output_open(&out, path, false);
    if (err)
        return err;
    if (isatty(out.fd)) {
        file_output_abandon(&out);
        return error_new("%s is a terminal, and a picture is binary: give a file with --output",
                         file_output_name(path));
    }
    err = png ? write_png(p, &out) : write_pfm(p, &out);
    if (!err)
        return file_output_finish(&out);
    file_output_abandon(&out);
    return err;
}

/* -- reading ---------------------------------------------------------------------------------- */

static float float_at(const unsigned char *byte, bool little)
{
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++)
        bits |= (uint32_t)byte[i] << (little ? 8 * i : 24 - 8 * i);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static struct error *read_pfm(struct picture *p, const char *data, size_t size)
{
    size_t width = 0, height = 0;
    double scale = 0;
    int at = 0;
    if (sscanf(data, "PF %5zu %5zu %lf%n", &width, &height, &scale, &at) != 3 ||
        !(scale < 0 || scale > 0))
        return error_new(
            "expected a colour PFM: PF, width, height, and -1 or 1 for the order of bytes");
    struct error *err = picture_init(p, width, height);
    if (err)
        return err;
    /* one blank behind the scale */
    const size_t start = (size_t)at + 1, bytes = 12 * width * height;
    if (size < start || size - start != bytes)
        return error_new("expected %zu bytes of pixels, got %zu", bytes,
                         size < start ? 0 : size - start);
    for (size_t row = 0; row < height; row++) {
        const unsigned char *from = (const unsigned char *)data + start +
                                    12 * (height - 1 - row) * width;
        for (size_t i = 0; i < 3 * width; i++) {
            const float value = float_at(from + 4 * i, scale < 0);
            if (!isfinite(value))
                return error_new("pixel (%zu, %zu): expected finite numbers, got %g", i / 3, row,
                                 (double)value);
            p->rgb[3 * row * width + i] = value;
        }
    }
    return NULL;
}

static struct error *read_image(struct picture *p, const char *data, size_t size)
{
    struct image image;
    struct error *err = image_decode(&image, data, size, IMAGE_COLOUR);
    if (!err)
        err = picture_init(p, image.width, image.height);
    for (size_t i = 0; !err && i < p->width * p->height; i++)
        for (size_t k = 0; k < 3; k++) {
            const size_t from = image.channels * i + k;
            p->rgb[3 * i + k] = image.bytes ? image_linear[((const uint8_t *)image.texels)[from]]
                                            : ((const float *)image.texels)[from];
        }
    free(image.texels);
    return err;
}

struct error *picture_read(struct picture *p, const char *path)
{
    char *data = NULL;
    size_t size = 0;
    *p = (struct picture){0};
    struct file_input in;
    struct error *err = file_input_open(&in, path);
    if (!err)
        err = file_input_rest(&in, &data, &size);
    file_input_close(&in);
    if (err)
        return err;
    err = size >= 2 && data[0] == 'P' && data[1] == 'F' ? read_pfm(p, data, size)
                                                        : read_image(p, data, size);
    free(data);
    if (err)
        picture_clear(p);
    return error_wrap(err, "%s", file_input_name(path));
}
