/* SPDX-License-Identifier: Apache-2.0 */
/* STL, text and binary, with the colours of facets that two programs hide in the latter.
 *
 * Read here and not by OpenMesh, whose reader tells the two kinds apart by the file's name alone,
 * and passes over facets that are cut off.
 */
#include "base/number.h"
#include "import/import.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { HEADER = 84, FACET = 50 }; /* bytes of the binary kind */

/* -- text ------------------------------------------------------------------------------------- */

struct text {
    const char *at, *end;
};

/* Takes the next word; false at the end of the file. */
static bool take_word(struct text *text, const char **word, size_t *length)
{
    while (text->at < text->end && isspace((unsigned char)*text->at))
        text->at++;
    *word = text->at;
    while (text->at < text->end && !isspace((unsigned char)*text->at))
        text->at++;
    *length = (size_t)(text->at - *word);
    return *length > 0;
}

static bool is_word(const char *word, size_t length, const char *wanted)
{
    return length == strlen(wanted) && !strncasecmp(word, wanted, length);
}

static struct error *take_vertex(struct text *text, struct scene_faces *faces)
{
    double p[3];
    for (int axis = 0; axis < 3; axis++) {
        const char *word;
        size_t length;
        if (!take_word(text, &word, &length) ||
            number_read_f64(word, text->end, &p[axis]) != word + length)
            return error_new("facet %zu: expected 3 coordinates of a vertex", faces->count);
    }
    struct error *err = scene_faces_vertex(faces, p[0], p[1], p[2]);
    return err ? err : scene_faces_corner(faces, (uint32_t)(faces->vertex_count - 1));
}

static struct error *read_text(const char *data, size_t size, struct scene_import *import,
                               struct scene_faces *faces)
{
    struct text text = {data, data + size};
    struct error *err = NULL;
    bool in_loop = false, ended = false;
    const char *word;
    size_t length;
    while (!err && take_word(&text, &word, &length)) {
        ended = is_word(word, length, "endsolid");
        if (is_word(word, length, "loop")) {
            in_loop = true;
            err = scene_faces_begin(faces);
        } else if (is_word(word, length, "endloop")) {
            in_loop = false;
        } else if (in_loop && is_word(word, length, "vertex")) {
            err = take_vertex(&text, faces);
        } else if (in_loop || is_word(word, length, "vertex")) {
            err = scene_import_broken(import, "word in a loop", 0,
                                      "facet %zu: expected %s, got '%.*s'", faces->count,
                                      in_loop ? "vertex or endloop" : "a loop around vertices",
                                      (int)(length < 40 ? length : 40), word);
        } else if (ended || is_word(word, length, "solid")) { /* a name follows */
            while (text.at < text.end && *text.at != '\n')
                text.at++;
        }
    }
    if (!err && !ended)
        err = scene_import_broken(import, "file cut off", 0,
                                  "the file ends in facet %zu, without endsolid", faces->count);
    return err;
}

/* -- binary ----------------------------------------------------------------------------------- */

/* What colours mean, two bytes a facet: bits of VisCAM, with 15 where there is one; or of
 * Materialise Magics, whose header has one for all, with 15 where that is meant. */
struct paint {
    bool viscam, magics;
    double all[4];
};

static uint16_t facet_word(const char *data, size_t facet)
{
    uint16_t word;
    memcpy(&word, data + HEADER + facet * FACET + FACET - sizeof word, sizeof word);
    return word;
}

static struct paint find_paint(const char *data, size_t count)
{
    static const char mark[] = "COLOR=";
    struct paint paint = {0};
    const char *at = memmem(data, 80 - 4, mark, strlen(mark));
    if (at) {
        paint.magics = true;
        for (size_t k = 0; k < 4; k++)
            paint.all[k] = (uint8_t)at[strlen(mark) + k] / 255.0;
        return paint;
    }
    for (size_t f = 0; f < count; f++) {
        const uint16_t word = facet_word(data, f);
        paint.viscam = paint.viscam || word >> 15;
        if (word && !(word >> 15)) /* something else */
            return (struct paint){0};
    }
    return paint;
}

/* Gives the newest facet its colour, if it has one. */
static struct error *paint_facet(const struct paint *paint, uint16_t word,
                                 struct scene_faces *faces)
{
    const double low = (word & 31) / 31.0, middle = (word >> 5 & 31) / 31.0,
                 high = (word >> 10 & 31) / 31.0;
    const double viscam[4] = {high, middle, low, -1}, magics[4] = {low, middle, high, -1};
    const bool own = paint->viscam ? word >> 15 : !(word >> 15);
    if (paint->viscam ? !own : !paint->magics)
        return NULL;
    return scene_colours_set(&faces->face_colour, faces->count - 1,
                             paint->viscam ? viscam
                             : own         ? magics
                                           : paint->all);
}

static struct error *read_binary(const char *data, size_t size, struct scene_import *import,
                                 struct scene_faces *faces)
{
    uint32_t count;
    if (size < HEADER)
        return error_new("expected STL, got %zu bytes", size);
    memcpy(&count, data + HEADER - sizeof count, sizeof count);
    const size_t room = (size - HEADER) / FACET, behind = room > count ? room - count : 0;
    struct error *err = NULL;
    if (room < count) {
        err = scene_import_broken(import, "file cut off", 0,
                                  "the header promises %u facets, there is room for %zu",
                                  (unsigned)count, room);
        count = (uint32_t)room;
    }
    if (behind > 0)
        err = scene_import_broken(import, "behind the last facet", 0,
                                  "the header promises %u facets, and %zu more follow",
                                  (unsigned)count, behind);
    const struct paint paint = find_paint(data, count);
    for (size_t f = 0; f < count && !err; f++) {
        float p[12]; /* normal, then three vertices */
        memcpy(p, data + HEADER + f * FACET, sizeof p);
        err = scene_faces_begin(faces);
        for (size_t k = 3; k < 12 && !err; k += 3) {
            err = scene_faces_vertex(faces, (double)p[k], (double)p[k + 1], (double)p[k + 2]);
            if (!err)
                err = scene_faces_corner(faces, (uint32_t)(faces->vertex_count - 1));
        }
        if (!err)
            err = paint_facet(&paint, facet_word(data, f), faces);
    }
    return err;
}

/* Text begins with "solid", but so do headers of some binary files; in these there is some zero
 * byte, the highest of the count if no other. */
static bool is_text(const char *data, size_t size)
{
    uint32_t count = 0;
    if (size >= HEADER)
        memcpy(&count, data + HEADER - sizeof count, sizeof count);
    return !strncasecmp(data + strspn(data, " \t\r\n"), "solid", 5) &&
           (size < HEADER || (size != HEADER + FACET * (size_t)count && !memchr(data, 0, HEADER)));
}

struct error *scene_read_stl(struct scene_import *import)
{
    char *data = NULL;
    size_t size = 0;
    struct scene_faces faces = {0};
    scene_import_content(import, &data, &size);
    const char *text = data;
    size_t text_size = size;
    scene_import_bare(&text, &text_size);
    struct error *err = is_text(text, text_size) ? read_text(text, text_size, import, &faces)
                                                 : read_binary(data, size, import, &faces);
    if (!err)
        err = scene_import_faces(import, &faces);
    scene_faces_clear(&faces);
    free(data);
    return err;
}
