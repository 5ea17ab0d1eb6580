/* SPDX-License-Identifier: Apache-2.0 */
/* OFF in text: Geomview's Object File Format, with or without colours of vertices (COFF) or faces;
 * normals and texture coordinates are left alone.
 *
 * Read here and not by OpenMesh, whose reader rounds positions to float and knows neither comments
 * nor counts in the first line.
 */
#include "base/number.h"
#include "import/import.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

struct off {
    const char *at, *end;
    bool coloured; /* vertices have colours, behind: */
    bool normals;
    size_t last_colour; /* how many numbers the colour of the last face had */
};

enum { REST_MOST = 16 };

/* Moves to the next word, over line ends and comments; false at the end of the file. */
static bool skip_blanks(struct off *off)
{
    while (off->at < off->end && (isspace((unsigned char)*off->at) || *off->at == '#')) {
        if (*off->at == '#')
            while (off->at < off->end && *off->at != '\n')
                off->at++;
        else
            off->at++;
    }
    return off->at < off->end;
}

static bool ends_number(const struct off *off, const char *at)
{
    return at == off->end || isspace((unsigned char)*at) || *at == '#';
}

/* Takes the numbers that are left on the line, and moves to its end; keeps REST_MOST of them. */
static struct error *take_rest(struct off *off, double rest[REST_MOST], size_t *count)
{
    double more;
    for (*count = 0;; ++*count) {
        while (off->at < off->end && *off->at != '\n' && isspace((unsigned char)*off->at))
            off->at++;
        if (off->at == off->end || *off->at == '\n' || *off->at == '#')
            break;
        const char *end =
            number_read_f64(off->at, off->end, *count < REST_MOST ? &rest[*count] : &more);
        if (!end || !ends_number(off, end))
            return error_new("expected a number");
        off->at = end;
    }
    while (off->at < off->end && *off->at != '\n')
        off->at++;
    *count = *count < REST_MOST ? *count : REST_MOST;
    return NULL;
}

static struct error *take_number(struct off *off, double *value)
{
    if (!skip_blanks(off))
        return error_new("the file ends here");
    const char *end = number_read_f64(off->at, off->end, value);
    if (!end || !ends_number(off, end))
        return error_new("expected a number");
    off->at = end;
    return NULL;
}

/* A whole number below 2^32 - 1; anything else becomes UINT32_MAX. */
static struct error *take_index(struct off *off, uint32_t *index)
{
    double value = 0;
    struct error *err = take_number(off, &value);
    *index = value >= 0 && value < UINT32_MAX ? (uint32_t)value : UINT32_MAX;
    if (!err && *index != UINT32_MAX && (double)*index != value)
        err = error_new("expected a whole number, got %g", value);
    return err;
}

/* The first word: OFF behind what vertices carry, N normals, C colours, ST texture coordinates; 4
 * and n are other dimensions. */
static struct error *take_header(struct off *off, uint32_t *vertices, uint32_t *faces)
{
    uint32_t edges;
    skip_blanks(off);
    const char *word = off->at;
    off->at += strspn(word, "STCN4n");
    if (off->end - off->at < 3 || memcmp(off->at, "OFF", 3))
        return error_new("expected OFF");
    off->at += 3; /* the counts may follow without a blank, as in ModelNet */
    const size_t length = (size_t)(off->at - word);
    if (strcspn(word, "4n") < length)
        return error_new("%.*s: only three dimensions are understood", (int)length, word);
    off->coloured = strcspn(word, "C") < length;
    off->normals = strcspn(word, "N") < length;
    skip_blanks(off);
    if (off->end - off->at >= 6 && !memcmp(off->at, "BINARY", 6))
        return error_new("binary OFF is not understood");
    struct error *err = take_index(off, vertices);
    if (!err)
        err = take_index(off, faces);
    if (!err)
        err = take_index(off, &edges);
    if (!err && (*vertices == UINT32_MAX || *faces == UINT32_MAX))
        err = error_new("expected numbers from 0 to 2^32 - 2");
    return error_wrap(err, "counts of vertices, faces and edges");
}

static struct error *take_vertex(struct off *off, struct scene_import *import,
                                 struct scene_faces *faces)
{
    double p[3] = {0}, rest[REST_MOST];
    struct error *err = NULL;
    for (int axis = 0; axis < 3 && !err; axis++)
        err = take_number(off, &p[axis]);
    if (!err)
        err = scene_faces_vertex(faces, p[0], p[1], p[2]);
    size_t count = 0;
    const size_t first = off->normals ? 3 : 0;
    if (!err)
        err = take_rest(off, rest, &count);
    if (!err && off->coloured && count < first + 3)
        err = error_new("expected %zu numbers behind the coordinates, got %zu: the first word "
                        "promises %scolours",
                        first + 4, count, off->normals ? "normals and " : "");
    if (err)
        return err;
    if (!off->coloured && count > first + 2)
        warnings_add(import->warnings, "numbers behind vertices",
                     "%s: %zu numbers behind the coordinates of vertices are left out: colours are "
                     "read from files that begin with COFF",
                     import->path, count);
    if (!off->coloured)
        return NULL;
    const bool alpha = count == first + 4 || count == first + 6; /* 2: texture coordinates */
    const double rgba[4] = {rest[first], rest[first + 1], rest[first + 2],
                            alpha ? rest[first + 3] : -1};
    return scene_colours_set(&faces->vertex_colour, faces->vertex_count - 1, rgba);
}

static struct error *take_face(struct off *off, struct scene_import *import,
                               struct scene_faces *faces)
{
    double rest[REST_MOST];
    uint32_t size = 0, vertex = 0;
    struct error *err = take_index(off, &size);
    if (!err)
        err = scene_faces_begin(faces);
    for (uint32_t k = 0; k < size && !err; k++) {
        err = take_index(off, &vertex);
        if (!err)
            err = scene_faces_corner(faces, vertex);
    }
    size_t count = 0;
    if (!err)
        err = take_rest(off, rest, &count);
    if (!err && off->at == off->end && count < off->last_colour)
        err =
            error_new("the file ends, without a line end, in a colour of %zu numbers after one of "
                      "%zu",
                      count, off->last_colour);
    if (!err && count == 2)
        err = error_new("expected a colour of 1, 3 or 4 numbers, got 2");
    if (err)
        return err;
    off->last_colour = count;
    if (count == 1)
        warnings_add(import->warnings, "colours by number",
                     "%s: faces name their colours by number, in a map that is not there: they are "
                     "left out",
                     import->path);
    if (count < 3)
        return NULL;
    const double rgba[4] = {rest[0], rest[1], rest[2], count > 3 ? rest[3] : -1};
    return scene_colours_set(&faces->face_colour, faces->count - 1, rgba);
}

struct error *scene_read_off(struct scene_import *import)
{
    char *data = NULL;
    size_t size = 0;
    uint32_t vertex_count = 0, face_count = 0;
    struct scene_faces faces = {.edges = true};
    scene_import_content(import, &data, &size);
    const char *text = data;
    scene_import_bare(&text, &size);
    struct off off = {.at = text, .end = text + size};
    struct error *err = take_header(&off, &vertex_count, &face_count);
    for (uint32_t v = 0; v < vertex_count && !err; v++)
        err = error_wrap(take_vertex(&off, import, &faces), "vertex %u of %u", v + 1, vertex_count);
    for (uint32_t f = 0; f < face_count && !err; f++)
        err = error_wrap(take_face(&off, import, &faces), "face %u of %u", f + 1, face_count);
    if (!err && skip_blanks(&off))
        err = scene_import_broken(import, "behind the last face", 0,
                                  "more follows the %u faces that the header promises", face_count);
    if (!err)
        err = scene_import_faces(import, &faces);
    if (!err)
        scene_import_warn_end(import, import->path, text, size);
    scene_faces_clear(&faces);
    free(data);
    return err;
}
