/* SPDX-License-Identifier: Apache-2.0 */
#include "base/array.h"
#include "base/error.h"
#include "image/image_formats.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Rec. 709's RGB of XYZ about the white of equal energy: the rows of the matrix for D65 (IEC
 * 61966-2-1), each over its sum. */
static const double rgb_of_xyz[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                        {-0.9692660, 1.8760108, 0.0415560},
                                        {0.0556434, -0.2040259, 1.0572252}};

enum { LINE_MOST = 4096 }; /* of a header's line, what is looked at */

struct reader {
    const unsigned char *at, *end;
    bool xyz;
    double divide[3]; /* EXPOSURE times COLORCORR */
    /* the picture's place for the texel `slow * length + fast` of the file */
    uint32_t count, length;             /* scan lines, texels of each */
    bool columns, slow_back, fast_back; /* scan lines are columns; go to the left or up */
    struct image_floats *out;
};

bool image_is_hdr(const void *data, size_t size)
{
    return size >= 2 && !memcmp(data, "#?", 2);
}

/* -- header ----------------------------------------------------------------------------------- */

/* The next line, without what ends it, cut at LINE_MOST; false at the end of the file. */
static bool next_line(struct reader *in, char line[LINE_MOST])
{
    const unsigned char *end = memchr(in->at, '\n', (size_t)(in->end - in->at));
    if (!end)
        return false;
    size_t length = (size_t)(end - in->at);
    if (length && in->at[length - 1] == '\r')
        length--;
    if (length > LINE_MOST - 1)
        length = LINE_MOST - 1;
    memcpy(line, in->at, length);
    line[length] = 0;
    in->at = end + 1;
    return true;
}

/* What stands behind `NAME=`, or NULL. Lines that begin with a blank tell of pictures that this one
 * was made of. */
static const char *value_of(const char *line, const char *name)
{
    const size_t length = strlen(name);
    if (strncmp(line, name, length))
        return NULL;
    line += length;
    line += strspn(line, " \t");
    if (*line++ != '=')
        return NULL;
    return line + strspn(line, " \t");
}

static struct error *take_format(struct reader *in, const char *value)
{
    in->xyz = !strncmp(value, "32-bit_rle_xyze", 15);
    if (in->xyz || !strncmp(value, "32-bit_rle_rgbe", 15))
        return NULL;
    return error_new("a .hdr picture: expected FORMAT 32-bit_rle_rgbe or 32-bit_rle_xyze, got "
                     "'%.40s'",
                     value);
}

static struct error *take_factors(struct reader *in, const char *name, const char *value, int count)
{
    const char *at = value;
    double factor = 0;
    for (int c = 0; c < 3; c++) {
        char *end;
        if (c < count) {
            factor = strtod(at, &end);
            if (end == at || !(factor > 0 && isfinite(factor)))
                return error_new("a .hdr picture: %s: expected %s above 0, got '%.40s'", name,
                                 count == 1 ? "a number" : "3 numbers", value);
            at = end;
        }
        in->divide[c] *= factor;
    }
    return NULL;
}

/* Up to the empty line. */
static struct error *read_keys(struct reader *in)
{
    char line[LINE_MOST];
    const char *value;
    struct error *err = NULL;
    bool more = next_line(in, line); /* the name */
    while (more && !err) {
        more = next_line(in, line);
        if (more && !*line)
            return NULL;
        if ((value = value_of(line, "FORMAT")))
            err = take_format(in, value);
        else if ((value = value_of(line, "EXPOSURE")))
            err = take_factors(in, "EXPOSURE", value, 1);
        else if ((value = value_of(line, "COLORCORR")))
            err = take_factors(in, "COLORCORR", value, 3);
    }
    return err ? err : error_new("a .hdr picture whose header does not end");
}

/* The line `-Y 512 +X 1024`: scan lines, then texels of each, and which way they go. */
static struct error *read_resolution(struct reader *in)
{
    char line[LINE_MOST], sign[2], axis[2];
    long side[2];
    if (!next_line(in, line))
        return error_new("a .hdr picture that is cut off");
    if (sscanf(line, "%c%c %9ld %c%c %9ld", &sign[0], &axis[0], &side[0], &sign[1], &axis[1],
               &side[1]) != 6 ||
        (sign[0] != '-' && sign[0] != '+') || (sign[1] != '-' && sign[1] != '+') ||
        !((axis[0] == 'X' && axis[1] == 'Y') || (axis[0] == 'Y' && axis[1] == 'X')))
        return error_new("a .hdr picture: expected its sides as in '-Y 512 +X 1024', got '%.40s'",
                         line);
    in->columns = axis[0] == 'X';
    struct error *err = image_check_sides(side[!in->columns], side[in->columns]);
    if (err)
        return err;
    /* +Y is up, and our rows go down */
    in->slow_back = sign[0] == (in->columns ? '-' : '+');
    in->fast_back = sign[1] == (in->columns ? '+' : '-');
    in->count = (uint32_t)side[0];
    in->length = (uint32_t)side[1];
    in->out->width = in->columns ? in->count : in->length;
    in->out->height = in->columns ? in->length : in->count;
    return NULL;
}

/* -- texels ----------------------------------------------------------------------------------- */

static struct error *put(const struct reader *in, size_t number, const unsigned char rgbe[4])
{
    uint32_t slow = (uint32_t)(number / in->length), fast = (uint32_t)(number % in->length);
    if (in->slow_back)
        slow = in->count - 1 - slow;
    if (in->fast_back)
        fast = in->length - 1 - fast;
    const size_t x = in->columns ? slow : fast, y = in->columns ? fast : slow;
    float *to = in->out->rgb + 3 * (y * in->out->width + x);
    const double unit = rgbe[3] ? ldexp(1, rgbe[3] - 136) : 0;
    double light[3];
    for (int c = 0; c < 3; c++)
        light[c] = rgbe[c] * unit / in->divide[c];
    for (int c = 0; c < 3; c++) {
        const double *row = rgb_of_xyz[c];
        double value = light[c];
        if (in->xyz)
            value = fmax((row[0] * light[0] + row[1] * light[1] + row[2] * light[2]) /
                             (row[0] + row[1] + row[2]),
                         0);
        to[c] = (float)value;
        if (!isfinite(to[c]))
            return error_new("a .hdr picture: texel (%zu, %zu) is too bright for a float", x, y);
    }
    return NULL;
}

static struct error *cut_off(void)
{
    return error_new("a .hdr picture that is cut off");
}

/* A scan line of four channels, each in runs: a count above 128 is that of a byte that repeats, one
 * of up to 128 that of bytes as they are. */
static struct error *read_channels(struct reader *in, unsigned char *row, size_t number)
{
    struct error *err = NULL;
    for (int c = 0; c < 4; c++)
        for (uint32_t x = 0; x < in->length;) {
            if (in->end - in->at < 2)
                return cut_off();
            const unsigned code = *in->at++;
            const bool run = code > 128;
            const unsigned count = run ? code - 128 : code;
            if (!count || count > in->length - x)
                return error_new("a damaged .hdr picture: scan line %zu has a run of %u texels",
                                 number / in->length + 1, count);
            if (!run && (size_t)(in->end - in->at) < count)
                return cut_off();
            for (unsigned i = 0; i < count; i++)
                row[4 * (x++) + (uint32_t)c] = in->at[run ? 0 : i];
            in->at += run ? 1 : count;
        }
    for (uint32_t x = 0; x < in->length && !err; x++)
        err = put(in, number + x, row + 4 * (size_t)x);
    return err;
}

/* Whether a scan line of channels begins here. */
static bool has_channels(const struct reader *in)
{
    return in->length >= 8 && in->length < 32768 && in->end - in->at >= 4 && in->at[0] == 2 &&
           in->at[1] == 2 && in->at[2] < 128;
}

/* All texels. Those as they are, and the old run lengths: 1, 1, 1, n repeats the last texel n
 * times, the next of them n * 256 times, and so on. */
static struct error *read_texels(struct reader *in, unsigned char *row)
{
    const size_t all = (size_t)in->count * in->length;
    unsigned char last[4] = {0};
    unsigned shift = 0;
    struct error *err = NULL;
    for (size_t number = 0; number < all && !err;) {
        if (in->end - in->at < 4)
            return cut_off();
        const unsigned char *texel = in->at;
        const bool channels = number % in->length == 0 && has_channels(in);
        in->at += 4;
        if (channels) {
            const unsigned length = (unsigned)texel[2] << 8 | texel[3];
            if (length != in->length)
                return error_new("a damaged .hdr picture: a scan line of %u texels, expected %u",
                                 length, (unsigned)in->length);
            err = read_channels(in, row, number);
            number += in->length;
            continue;
        }
        size_t count = 1;
        if (texel[0] == 1 && texel[1] == 1 && texel[2] == 1) {
            count = shift > 24 ? 0 : (size_t)texel[3] << shift;
            shift += 8;
            if (!number || shift > 32 || count > all - number)
                return error_new("a damaged .hdr picture: a run that goes beyond its texels");
        } else {
            memcpy(last, texel, sizeof last);
            shift = 0;
        }
        for (size_t i = 0; i < count && !err; i++)
            err = put(in, number++, last);
    }
    return err;
}

struct error *image_decode_hdr(const void *data, size_t size, struct image_floats *out)
{
    *out = (struct image_floats){0};
    unsigned char *row = NULL;
    struct reader in = {
        .at = data, .end = (const unsigned char *)data + size, .divide = {1, 1, 1}, .out = out};
    struct error *err = read_keys(&in);
    if (!err)
        err = read_resolution(&in);
    if (!err)
        err = array_create(&row, in.length, 4);
    if (!err)
        err = array_create(&out->rgb, 3 * (size_t)out->width * out->height, sizeof *out->rgb);
    if (!err)
        err = read_texels(&in, row);
    free(row);
    if (err) {
        free(out->rgb);
        out->rgb = NULL;
    }
    return err;
}
