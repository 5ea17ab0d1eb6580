/* SPDX-License-Identifier: Apache-2.0 */
/* PLY, text and binary. After: G. Turk, The PLY Polygon File Format (1994).
 *
 * Read here and not by OpenMesh, whose reader rounds positions to float, runs on without end where
 * a header is cut off, and does not know all types of a list's length.
 */
#include "base/number.h"
#include "import/import.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum type { INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT32, FLOAT64, TYPES };

static const struct {
    const char *names[2];
    size_t size;
} types[TYPES] = {
    [INT8] = {{"char", "int8"}, 1},        [UINT8] = {{"uchar", "uint8"}, 1},
    [INT16] = {{"short", "int16"}, 2},     [UINT16] = {{"ushort", "uint16"}, 2},
    [INT32] = {{"int", "int32"}, 4},       [UINT32] = {{"uint", "uint32"}, 4},
    [FLOAT32] = {{"float", "float32"}, 4}, [FLOAT64] = {{"double", "float64"}, 8},
};

enum { NAME_MOST = 64, PROPERTIES_MOST = 256, ELEMENTS_MOST = 64 };

/* How a row's values are used. */
enum role { SKIP, COORDINATE, COLOUR, CORNERS, STRIP };

struct property {
    char name[NAME_MOST];
    bool list;
    enum type length, type;
    enum role role;
    int axis; /* of a coordinate, or a colour's channel: red, green, blue, alpha */
};

struct element {
    char name[NAME_MOST];
    uint64_t count;
    struct property *properties; /* owned */
    size_t property_count;
    bool coloured; /* its properties have red, green and blue */
};

struct ply {
    const unsigned char *at, *end; /* what is left to read */
    char newline;                  /* what ends the header's lines */
    bool text, big_endian;
    struct element elements[ELEMENTS_MOST];
    size_t element_count;
};

/* -- the header ------------------------------------------------------------------------------- */

/* Takes the next line of the header, without its end and blanks before it, and with blanks for
 * tabs; false when there is none. Lines end with \n or, where the first one does, with \r alone. */
static bool take_line(struct ply *ply, char *line, size_t size)
{
    const size_t left = (size_t)(ply->end - ply->at);
    const unsigned char *newline = memchr(ply->at, ply->newline, left);
    if (!newline)
        return false;
    size_t length = (size_t)(newline - ply->at);
    const size_t kept = length < size ? length : size - 1;
    memcpy(line, ply->at, kept);
    line[kept] = 0;
    line[strcspn(line, "\r")] = 0;
    for (length = strlen(line); length > 0 && isspace((unsigned char)line[length - 1]);)
        line[--length] = 0;
    for (char *tab = line; (tab = strchr(tab, '\t'));)
        *tab = ' ';
    ply->at = newline + 1;
    return true;
}

static bool parse_type(const char *name, enum type *type)
{
    for (int t = 0; t < TYPES; t++) {
        if (!strcmp(name, types[t].names[0]) || !strcmp(name, types[t].names[1])) {
            *type = (enum type)t;
            return true;
        }
    }
    return false;
}

static struct error *parse_property(struct ply *ply, const char *line)
{
    char length[NAME_MOST], type[NAME_MOST];
    struct property property = {0};
    if (ply->element_count == 0)
        return error_new("'%s' stands before any element", line);
    property.list = sscanf(line, "property list %63s %63s %63s", length, type, property.name) == 3;
    if (!property.list && sscanf(line, "property %63s %63s", type, property.name) != 2)
        return error_new("expected a property, got '%s'", line);
    if (!parse_type(type, &property.type) ||
        (property.list && (!parse_type(length, &property.length) || property.length > UINT32)))
        return error_new("unknown type in '%s'", line);
    struct element *element = &ply->elements[ply->element_count - 1];
    if (element->property_count == PROPERTIES_MOST)
        return error_new("more than %d properties of one element", PROPERTIES_MOST);
    if (!element->properties) {
        struct error *err =
            array_create(&element->properties, PROPERTIES_MOST, sizeof *element->properties);
        if (err)
            return err;
    }
    element->properties[element->property_count++] = property;
    return NULL;
}

static struct error *parse_element(struct ply *ply, const char *line)
{
    unsigned long long count;
    if (ply->element_count == ELEMENTS_MOST)
        return error_new("more than %d elements", ELEMENTS_MOST);
    struct element *element = &ply->elements[ply->element_count];
    if (sscanf(line, "element %63s %llu", element->name, &count) != 2 || strchr(line, '-'))
        return error_new("expected an element and its count, got '%s'", line);
    element->count = count;
    ply->element_count++;
    return NULL;
}

static struct error *parse_header(struct ply *ply, const struct scene_import *import)
{
    char line[256], format[32] = "", picture[128];
    struct error *err = NULL;
    if (!take_line(ply, line, sizeof line) || strcmp(line, "ply"))
        return error_new("expected 'ply' in the first line");
    for (bool more = true; more && !err;) {
        if (!take_line(ply, line, sizeof line))
            return error_new("the header has no end_header");
        if (!strncmp(line, "format ", 7))
            sscanf(line, "format %31s", format);
        else if (sscanf(line, "comment TextureFile %127[^\n]", picture) == 1)
            warnings_add(import->warnings, "picture of PLY",
                         "%s: the picture %s is left out: it would be read from an OBJ or a glTF",
                         import->path, picture);
        else if (!strncmp(line, "element ", 8))
            err = parse_element(ply, line);
        else if (!strncmp(line, "property ", 9))
            err = parse_property(ply, line);
        else
            more = strcmp(line, "end_header") != 0;
    }
    ply->text = !strcmp(format, "ascii");
    ply->big_endian = !strcmp(format, "binary_big_endian");
    if (!err && !ply->text && !ply->big_endian && strcmp(format, "binary_little_endian"))
        err = error_new("unknown format '%s'", format);
    return err;
}

/* -- the body --------------------------------------------------------------------------------- */

/* The value of `size` bytes, which lie in the machine's (little-endian) order. */
static double decode(enum type type, const unsigned char *bytes)
{
    union {
        int8_t i8;
        uint8_t u8;
        int16_t i16;
        uint16_t u16;
        int32_t i32;
        uint32_t u32;
        float f32;
        double f64;
    } value;
    memcpy(&value, bytes, types[type].size);
    switch (type) {
    case INT8: return value.i8;
    case UINT8: return value.u8;
    case INT16: return value.i16;
    case UINT16: return value.u16;
    case INT32: return value.i32;
    case UINT32: return value.u32;
    case FLOAT32: return (double)value.f32;
    default: return value.f64;
    }
}

/* Takes one value; false when none is left, or a word that is no number. */
static bool take_value(struct ply *ply, enum type type, double *value)
{
    if (ply->text) {
        while (ply->at < ply->end && isspace(*ply->at))
            ply->at++;
        const char *end = scene_import_number((const char *)ply->at, (const char *)ply->end, value);
        if (!end || (end != (const char *)ply->end && !isspace((unsigned char)*end)))
            return false;
        ply->at = (const unsigned char *)end;
        return true;
    }
    const size_t size = types[type].size;
    unsigned char bytes[8];
    if ((size_t)(ply->end - ply->at) < size)
        return false;
    for (size_t i = 0; i < size; i++)
        bytes[i] = ply->at[ply->big_endian ? size - 1 - i : i];
    ply->at += size;
    *value = decode(type, bytes);
    return true;
}

/* A vertex's number; whatever is none becomes one that no vertex has. */
static uint32_t to_vertex(double value)
{
    const bool whole = value >= 0 && value < UINT32_MAX && (double)(uint32_t)value == value;
    return whole ? (uint32_t)value : UINT32_MAX;
}

/* The channel of a colour, as one of the spellings has it; -1: none. */
static int channel_of(const char *name)
{
    static const char *const names[][4] = {
        {"red", "green", "blue", "alpha"},
        {"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"},
        {"r", "g", "b", "a"}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        for (int k = 0; k < 4; k++)
            if (!strcmp(name, names[i][k]))
                return k;
    return -1;
}

static void set_role(const struct element *element, struct property *property)
{
    const bool vertex = !strcmp(element->name, "vertex"), face = !strcmp(element->name, "face");
    const int axis = property->name[0] - 'x', channel = channel_of(property->name);
    if (property->list) {
        if (!strcmp(property->name, "vertex_indices") || !strcmp(property->name, "vertex_index"))
            property->role = face ? CORNERS : !strcmp(element->name, "tristrips") ? STRIP : SKIP;
    } else if (vertex && axis >= 0 && axis < 3 && property->name[1] == 0) {
        property->role = COORDINATE;
        property->axis = axis;
    } else if ((vertex || face) && channel >= 0) {
        property->role = COLOUR;
        property->axis = channel;
    }
}

/* Sets what each property is for. */
static void set_roles(struct ply *ply)
{
    for (size_t e = 0; e < ply->element_count; e++) {
        struct element *element = &ply->elements[e];
        unsigned channels = 0;
        for (size_t k = 0; k < element->property_count; k++) {
            struct property *property = &element->properties[k];
            set_role(element, property);
            channels |= property->role == COLOUR ? 1u << property->axis : 0;
        }
        element->coloured = (channels & 7) == 7;
    }
}

/* A colour's channel as a share of white; of types that have more than one white, as it stands
 * (import.h). */
static double to_share(enum type type, double value)
{
    return type == UINT8 ? value / 255 : type == UINT16 ? value / 65535 : value;
}

/* A triangle of a strip: the newest three vertices, every other one turned; -1 begins a new
 * strip. */
static struct error *add_to_strip(struct scene_faces *faces, uint32_t vertex, uint32_t last[2],
                                  size_t *length)
{
    struct error *err = NULL;
    if (vertex == UINT32_MAX) {
        *length = 0;
        return NULL;
    }
    if (++*length > 2) {
        const bool turned = *length % 2 == 0;
        err = scene_faces_begin(faces);
        if (!err)
            err = scene_faces_corner(faces, last[turned]);
        if (!err)
            err = scene_faces_corner(faces, last[!turned]);
        if (!err)
            err = scene_faces_corner(faces, vertex);
    }
    last[0] = last[1];
    last[1] = vertex;
    return err;
}

static struct error *read_list(struct ply *ply, const struct property *property,
                               struct scene_faces *faces, bool *ended)
{
    const enum role role = property->role;
    double length = 0, value = 0;
    uint32_t last[2] = {0};
    size_t strip = 0;
    *ended = !take_value(ply, property->length, &length) || !(length >= 0);
    struct error *err = role == CORNERS && !*ended ? scene_faces_begin(faces) : NULL;
    for (double i = 0; i < length && !*ended && !err; i++) {
        *ended = !take_value(ply, property->type, &value);
        if (!*ended && role == CORNERS)
            err = scene_faces_corner(faces, to_vertex(value));
        else if (!*ended && role == STRIP)
            err = add_to_strip(faces, to_vertex(value), last, &strip);
    }
    return err;
}

static struct error *read_row(struct ply *ply, const struct element *element,
                              struct scene_faces *faces, bool *ended)
{
    double position[3] = {0}, rgba[4] = {0, 0, 0, -1}, value = 0;
    const size_t face_count = faces->count;
    struct error *err = NULL;
    for (size_t k = 0; k < element->property_count && !*ended && !err; k++) {
        const struct property *property = &element->properties[k];
        if (property->list) {
            err = read_list(ply, property, faces, ended);
            continue;
        }
        *ended = !take_value(ply, property->type, &value);
        if (property->role == COORDINATE)
            position[property->axis] = value;
        else if (property->role == COLOUR)
            rgba[property->axis] = to_share(property->type, value);
    }
    if (err || *ended)
        return err;
    const bool vertex = !strcmp(element->name, "vertex");
    if (vertex)
        err = scene_faces_vertex(faces, position[0], position[1], position[2]);
    if (!err && element->coloured && vertex)
        err = scene_colours_set(&faces->vertex_colour, faces->vertex_count - 1, rgba);
    else if (!err && element->coloured && faces->count == face_count + 1)
        err = scene_colours_set(&faces->face_colour, face_count, rgba);
    return err;
}

/* Takes back the faces behind the first `count`. */
static void forget_faces(struct scene_faces *faces, size_t count)
{
    while (faces->count > count)
        faces->corner_count -= faces->size[--faces->count];
}

static struct error *read_element(struct ply *ply, const struct element *element,
                                  struct scene_import *import, struct scene_faces *faces)
{
    struct error *err = NULL;
    bool ended = false;
    for (uint64_t row = 0; row < element->count && element->property_count > 0 && !ended && !err;
         row++) {
        const size_t face_count = faces->count;
        err = read_row(ply, element, faces, &ended);
        if (err || !ended)
            continue;
        forget_faces(faces, face_count);
        if (ply->text && ply->at < ply->end)
            err = error_new("%s %llu of %llu: expected a number", element->name,
                            (unsigned long long)row + 1, (unsigned long long)element->count);
        else
            err = scene_import_broken(
                import, "file cut off", 0, "%s %llu of %llu: the file ends here", element->name,
                (unsigned long long)row + 1, (unsigned long long)element->count);
        ply->at = ply->end;
    }
    return err;
}

/* What stands behind all that the header promises is lost: it promises too little. */
static struct error *check_end(struct ply *ply, struct scene_import *import)
{
    while (ply->at < ply->end && (isspace(*ply->at) || !*ply->at))
        ply->at++;
    if (ply->at == ply->end)
        return NULL;
    if (ply->text) /* some row may have had more numbers, and all behind it are others */
        return error_new(
            "%zu bytes follow all that the header promises: it counts too few rows, or "
            "too few properties of a row",
            (size_t)(ply->end - ply->at));
    return scene_import_broken(import, "behind the last element", 0,
                               "%zu bytes follow all that the header promises",
                               (size_t)(ply->end - ply->at));
}

/* Refuses vertices without coordinates. */
static struct error *check_vertices(const struct ply *ply)
{
    for (size_t e = 0; e < ply->element_count; e++) {
        const struct element *element = &ply->elements[e];
        unsigned found = 0;
        for (size_t k = 0; k < element->property_count; k++)
            if (element->properties[k].role == COORDINATE)
                found |= 1u << element->properties[k].axis;
        if (!strcmp(element->name, "vertex"))
            return found == 7 ? NULL : error_new("vertices have no x, y and z");
    }
    return error_new("the header has no element vertex");
}

struct error *scene_read_ply(struct scene_import *import)
{
    char *data = NULL;
    size_t size = 0;
    struct ply ply = {0};
    struct scene_faces faces = {0};
    scene_import_content(import, &data, &size);
    const char *text = data;
    size_t text_size = size;
    scene_import_bare(&text, &text_size);
    ply.at = (const unsigned char *)text;
    ply.end = (const unsigned char *)data + size;
    ply.newline = text[strcspn(text, "\r\n")] == '\r' && text[strcspn(text, "\r\n") + 1] != '\n'
                      ? '\r'
                      : '\n';
    struct error *err = parse_header(&ply, import);
    if (ply.text)
        ply.end = (const unsigned char *)text + text_size;
    set_roles(&ply);
    if (!err)
        err = check_vertices(&ply);
    for (size_t e = 0; e < ply.element_count && !err; e++)
        err = read_element(&ply, &ply.elements[e], import, &faces);
    if (!err)
        err = check_end(&ply, import);
    if (!err)
        err = scene_import_faces(import, &faces);
    if (!err && ply.text)
        scene_import_warn_end(import, import->path, text, text_size);
    scene_faces_clear(&faces);
    for (size_t e = 0; e < ply.element_count; e++)
        free(ply.elements[e].properties);
    free(data);
    return err;
}
