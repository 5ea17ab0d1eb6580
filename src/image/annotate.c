/* SPDX-License-Identifier: Apache-2.0 */
#include "image/annotate.h"

#include <string.h>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#pragma GCC diagnostic ignored "-Wmissing-braces"
#include <stb_easy_font.h>
#pragma GCC diagnostic pop

/* letters of a text; floats of a quad: 4 corners of x, y, z and a colour */
enum { TEXT_MOST = 96, QUAD_FLOATS = 16 };

static double letter_scale(const struct picture *p)
{
    const size_t scale = (p->height < p->width ? p->height : p->width) / 200;
    return scale > 1 ? (double)scale : 1;
}

static void fill(const struct picture *p, double left, double top, double right, double bottom,
                 struct vec3f colour)
{
    for (double y = top < 0 ? 0 : top; y < bottom && y < (double)p->height; y++)
        for (double x = left < 0 ? 0 : left; x < right && x < (double)p->width; x++)
            picture_set(p, (size_t)x, (size_t)y, colour);
}

/* stb_easy_font takes text that it does not change, but not as const. */
static void copy_text(const char *text, char copy[TEXT_MOST])
{
    strncpy(copy, text, TEXT_MOST - 1);
    copy[TEXT_MOST - 1] = 0;
}

double annotate_width(const struct picture *p, const char *text)
{
    char copy[TEXT_MOST];
    copy_text(text, copy);
    return letter_scale(p) * stb_easy_font_width(copy);
}

double annotate_height(const struct picture *p)
{
    return 12 * letter_scale(p);
}

/* Each letter is made of rectangles; all of them grown by `grow` pixels. */
static void draw(const struct picture *p, double x, double y, const char *text, double grow,
                 struct vec3f colour)
{
    char copy[TEXT_MOST];
    float quad[TEXT_MOST * 24][QUAD_FLOATS]; /* no letter has more than 24 */
    const double scale = letter_scale(p);
    copy_text(text, copy);
    const int count = stb_easy_font_print(0, 0, copy, NULL, quad, (int)sizeof quad);
    for (int i = 0; i < count; i++)
        fill(p, x + scale * (double)quad[i][0] - grow, y + scale * (double)quad[i][1] - grow,
             x + scale * (double)quad[i][8] + grow, y + scale * (double)quad[i][9] + grow, colour);
}

void annotate_text(const struct picture *p, double x, double y, const char *text)
{
    x = (double)(long)x;
    y = (double)(long)y;
    draw(p, x, y, text, letter_scale(p), (struct vec3f){0, 0, 0});
    draw(p, x, y, text, 0, (struct vec3f){1, 1, 1});
}

void annotate_scale(const struct picture *p, enum colour_map map, const char *title,
                    const char *const label[3])
{
    const double line = annotate_height(p), left = line, width = (double)p->width - 2 * line,
                 bottom = (double)p->height - line / 2;
    const double bar_bottom = bottom - line, bar_top = bar_bottom - line, edge = letter_scale(p);
    fill(p, left - edge, bar_top - edge, left + width + edge, bar_bottom + edge,
         (struct vec3f){0, 0, 0});
    for (double x = 0; x < width; x++)
        fill(p, left + x, bar_top, left + x + 1, bar_bottom, colour_map_at(map, (x + 0.5) / width));
    for (int i = 0; i < 3; i++) {
        const double room = width - annotate_width(p, label[i]);
        annotate_text(p, left + room * i / 2, bar_bottom + edge * 3, label[i]);
    }
    annotate_text(p, left, bar_top - line, title);
}
