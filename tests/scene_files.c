/* SPDX-License-Identifier: Apache-2.0 */
/* PLY, OFF and STL: what they hold is what the scene holds, in double where they say double; counts
 * that lie, and ends that come too soon, are errors that say where. */
#include "base/error.h"
#include "base/warning.h"
#include "import/import_scene.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "support/files.h"
#include "support/tap.h"

#include <stdint.h>
#include <string.h>

static struct warnings warnings;

/* A file put together piece by piece. */
struct bytes {
    uint8_t data[4096];
    size_t size;
};

static void put(struct bytes *to, const void *data, size_t size)
{
    if (to->size + size > sizeof to->data)
        bail("a file too long for its test");
    memcpy(to->data + to->size, data, size);
    to->size += size;
}

static void put_text(struct bytes *to, const char *text)
{
    put(to, text, strlen(text));
}

/* A number's bytes, the other way round when `turned`. */
static void put_number(struct bytes *to, const void *number, size_t size, bool turned)
{
    uint8_t bytes[8];
    for (size_t i = 0; i < size; i++)
        bytes[i] = ((const uint8_t *)number)[turned ? size - 1 - i : i];
    put(to, bytes, size);
}

static bool lenient = true;

/* Reads the file and expects so many triangles and this sum over their corners' x. */
static void expect(const char *what, const char *name, const void *data, size_t size,
                   size_t triangles, double x)
{
    struct scene *s = NULL;
    warnings_clear(&warnings);
    files_write_bytes(name, data, size);
    struct scene_settings settings = scene_settings_default();
    settings.lenient = lenient;
    struct error *err = scene_read(&s, files_path(name), &settings, true, &warnings);
    double sum = 0;
    for (size_t k = 0; s && s->mesh_count && k < 3 * s->meshes[0].triangle_count; k++)
        sum += s->meshes[0].position[3 * s->meshes[0].index[k]];
    ok(!err && scene_triangle_count(s) == triangles && sum == x, "%s: %s", what,
       err                                    ? error_message(err)
       : scene_triangle_count(s) == triangles ? "as it should be"
                                              : "the wrong triangles");
    if (!err && sum != x)
        printf("# sum of x %.17g, expected %.17g\n", sum, x);
    const bool coloured = !err && triangles && s->meshes[0].colour;
    if (!err && triangles)
        ok(s->materials[0].albedo.x == (coloured ? 1 : 0.8f), "%s: %s", what,
           coloured ? "white, times its colours" : "grey of 0.8");
    error_destroy(err);
    scene_destroy(s);
}

static void expect_text(const char *what, const char *name, const char *text, size_t triangles,
                        double x)
{
    expect(what, name, text, strlen(text), triangles, x);
}

static void refuse(const char *what, const char *name, const void *data, size_t size,
                   const char *part)
{
    struct scene *s = NULL;
    files_write_bytes(name, data, size);
    struct error *err = scene_read(&s, files_path(name), NULL, true, &warnings);
    ok(err && !s && strstr(error_message(err), part) && strstr(error_message(err), name), "%s: %s",
       what, err ? strrchr(error_message(err), '/') : "(accepted)");
    error_destroy(err);
    scene_destroy(s);
}

static void refuse_text(const char *what, const char *name, const char *text, const char *part)
{
    refuse(what, name, text, strlen(text), part);
}

/* -- PLY -------------------------------------------------------------------------------------- */

static const double far_away = 4000000.123456789; /* a float would round it to 4000000 */

/* Bytes of a whole number's type. */
static size_t bytes_of(const char *type)
{
    if (strstr(type, "char") || strstr(type, "int8"))
        return 1;
    return strstr(type, "short") || strstr(type, "16") ? 2 : 4;
}

/* A square in any of the kinds that PLY knows: one quadrilateral, with properties that nobody uses
 * on either side. */
static struct bytes make_ply(const char *format, const char *real, const char *length,
                             const char *index)
{
    struct bytes out = {.size = 0};
    char header[1024];
    const bool turned = !strcmp(format, "binary_big_endian"), text = !strcmp(format, "ascii");
    const bool wide = !strcmp(real, "double") || !strcmp(real, "float64");
    snprintf(header, sizeof header,
             "ply\nformat %s 1.0\ncomment end_header is not here\nobj_info x\nelement vertex "
             "4\nproperty uchar red\n"
             "property %s x\nproperty %s y\n"
             "property %s z\nproperty list uchar float more\nelement face 1\nproperty int flags\n"
             "property list %s %s vertex_indices\n"
             "property float quality\nelement edge 1\nproperty int vertex1\nend_header\n",
             format, real, real, real, length, index);
    put_text(&out, header);
    const double x[4] = {0, wide ? far_away : 1, wide ? far_away : 1, 0}, y[4] = {0, 0, 1, 1};
    for (int v = 0; v < 4; v++) {
        const double p[3] = {x[v], y[v], 0};
        if (text) {
            char line[128];
            snprintf(line, sizeof line, "255 %.17g %.17g 0 2 7 8\n", p[0], p[1]);
            put_text(&out, line);
            continue;
        }
        put(&out, "\xff", 1);
        for (int k = 0; k < 3; k++) {
            const float f = (float)p[k];
            put_number(&out, wide ? (const void *)&p[k] : &f, wide ? 8 : 4, turned);
        }
        const float more[2] = {7, 8};
        put(&out, "\2", 1);
        put_number(&out, &more[0], 4, turned);
        put_number(&out, &more[1], 4, turned);
    }
    if (text) {
        put_text(&out, "-7 4 0 1 2 3 0.5\n9\n");
        return out;
    }
    const int32_t flags = -7, nine = 9;
    const float quality = 0.5f;
    const size_t length_size = bytes_of(length), index_size = bytes_of(index);
    put_number(&out, &flags, 4, turned);
    for (uint32_t k = 0; k < 5; k++) {
        const uint32_t value = k == 0 ? 4 : k - 1;
        put_number(&out, &value, k == 0 ? length_size : index_size, turned);
    }
    put_number(&out, &quality, 4, turned);
    put_number(&out, &nine, 4, turned);
    return out;
}

/* Triangles of a strip all turn one way, and -1 begins another. */
static void test_strip(void)
{
    files_write("strip.ply",
                "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                "property float z\n"
                "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
                "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 4 -1 2 3 4\n");
    struct scene *s = NULL;
    struct error *err = scene_read(&s, files_path("strip.ply"), NULL, false, &warnings);
    bool left = !err && scene_triangle_count(s) == 4;
    for (size_t t = 0; left && t < 4; t++) {
        const double *p = s->meshes[0].position;
        const uint32_t *i = s->meshes[0].index + 3 * t;
        left = vec3_cross(vec3_sub(vec3_load(p + 3 * i[1]), vec3_load(p + 3 * i[0])),
                          vec3_sub(vec3_load(p + 3 * i[2]), vec3_load(p + 3 * i[0])))
                   .z == 1;
    }
    ok(left, "strips of triangles");
    error_destroy(err);
    scene_destroy(s);
}

static void test_ply(void)
{
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    static const char *const kinds[][3] = {
        {"float", "uchar", "int"},    {"double", "uchar", "uint"},  {"float64", "uint8", "int32"},
        {"float32", "int", "ushort"}, {"float", "uint32", "int16"}, {"double", "ushort", "uint8"}};
    for (size_t f = 0; f < 3; f++)
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
            const struct bytes file = make_ply(formats[f], kinds[k][0], kinds[k][1], kinds[k][2]);
            char what[128];
            snprintf(what, sizeof what, "PLY %s with %s, %s and %s", formats[f], kinds[k][0],
                     kinds[k][1], kinds[k][2]);
            const bool wide = !strncmp(kinds[k][0], "double", 6) || !strcmp(kinds[k][0], "float64");
            expect(what, "x.ply", file.data, file.size, 2, 3 * (wide ? far_away : 1));
        }
    for (size_t f = 0; f < 3; f++) { /* cut off anywhere */
        const struct bytes file = make_ply(formats[f], "float", "uchar", "int");
        struct scene *s = NULL;
        size_t accepted = 0;
        /* the text may lose its last line end */
        for (size_t size = 0; size + (f == 0 ? 2 : 1) <= file.size; size++) {
            files_write_bytes("cut.ply", file.data, size);
            struct error *err = scene_read(&s, files_path("cut.ply"), NULL, true, &warnings);
            accepted += !err;
            error_destroy(err);
            scene_destroy(s);
        }
        ok(accepted == 0, "PLY %s cut off anywhere is refused", formats[f]);
    }
#define PLY_VERTICES                                                                               \
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float " \
    "z\n"
    expect_text(
        "PLY of Windows", "x.ply",
        "ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\n"
        "property float z\r\n"
        "element face 1\r\nproperty list uchar int vertex_index\r\nend_header\r\n0 0 0\r\n1 0 "
        "0\r\n1 1 0\r\n"
        "3 0 1 2\r\n",
        1, 2);
    expect_text("faces before vertices", "x.ply",
                "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int "
                "vertex_indices\nelement vertex 3\n"
                "property float z\n"
                "property float y\nproperty float x\nend_header\n3 0 1 2\n0 0 0\n0 0 1\n0 1 1\n",
                1, 2);
    test_strip();
    expect_text("no faces", "x.ply", PLY_VERTICES "end_header\n0 0 0\n1 0 0\n1 1 0\n", 0, 0);
    expect_text(
        "indices out of range", "x.ply",
        PLY_VERTICES
        "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n"
        "3 0 1 3\n3 -1 1 2\n3 0 1 9999999999\n3 0 1 2\n",
        1, 2);
    ok(warnings_of_kind(&warnings, "index out of range") == 3, "with a warning");
    expect_text(
        "doubled and non-manifold faces", "x.ply",
        PLY_VERTICES
        "element face 3\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n"
        "3 0 1 2\n3 0 1 2\n3 2 1 0\n",
        3, 6);
    expect_text(
        "coordinates that are no numbers", "x.ply",
        PLY_VERTICES
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\nnan 0 0\n"
        "1 inf 0\n3 0 1 2\n",
        0, 0);
    refuse_text(
        "a lying count of vertices", "x.ply",
        "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n1 0 0\n",
        "vertex 3 of 4000000000: the file ends here");
    refuse_text(
        "of faces", "x.ply",
        PLY_VERTICES
        "element face 18446744073709551615\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n",
        "face 2 of 18446744073709551615: the file ends here");
    refuse_text(
        "of corners", "x.ply",
        PLY_VERTICES
        "element face 1\nproperty list uint int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n"
        "4000000000 0 1 2\n",
        "face 1 of 1: the file ends here");
    refuse_text("a word for a number", "x.ply", PLY_VERTICES "end_header\n0 0 0\n1 zero 0\n1 1 0\n",
                "vertex 2 of 3: expected a number");
#define PLY_FACE                                                                                   \
    PLY_VERTICES                                                                                   \
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n"
    refuse_text("more faces than promised", "x.ply", PLY_FACE "3 0 1 2\n3 0 2 1\n",
                "8 bytes follow all that the header promises");
    refuse_text("a corner between two vertices", "x.ply", PLY_FACE "3 0 1 1.5\n",
                "face 1 has a corner that is not");
    refuse_text(
        "a coordinate that is no number", "x.ply",
        PLY_VERTICES
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 nan\n"
        "1 1 0\n3 0 1 2\n",
        "face 1 has a corner at 1 0 nan");
    refuse_text("a face of two corners", "x.ply", PLY_FACE "2 0 1\n", "face 1 has 2 corners");
    warnings_clear(&warnings);
    expect_text("a last line without an end", "x.ply", PLY_FACE "3 0 1 2", 1, 2);
    ok(warnings_of_kind(&warnings, "last line without an end") == 1, "with a warning");
    refuse_text("no end_header", "x.ply", PLY_VERTICES, "no end_header");
    refuse_text("a property before any element", "x.ply",
                "ply\nformat ascii 1.0\nproperty float x\nend_header\n", "before any element");
    refuse_text("an unknown type", "x.ply",
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n",
                "unknown type");
    refuse_text("an unknown format", "x.ply",
                "ply\nformat binary_middle_endian 1.0\nelement vertex 0\n"
                "property float x\nproperty float y\nproperty float z\nend_header\n",
                "unknown format");
    refuse_text("no coordinates", "x.ply",
                "ply\nformat ascii 1.0\nelement vertex 4000000000\nend_header\n", "no x, y and z");
    refuse_text("no vertices", "x.ply", "ply\nformat ascii 1.0\nend_header\n", "no element vertex");
    refuse_text("something else", "x.ply", "PLY is not what this is\n", "expected 'ply'");
}

/* -- OFF -------------------------------------------------------------------------------------- */

static void test_off(void)
{
    expect_text(
        "OFF", "x.off",
        "OFF\n4 1 0\n0 0 0\n4000000.123456789 0 0\n4000000.123456789 1 0\n0 1 0\n4 0 1 2 3\n", 2,
        3 * far_away);
    expect_text("comments, empty lines and counts in the first line", "x.off",
                "# made by hand\nOFF 3 1 0 # counts\n\n0 0 0 # a vertex\n1 0 0\n\n# more\n1 1 0\n3 "
                "0 1 2 # a face",
                1, 2);
    expect_text("colours of vertices and faces", "x.off",
                "COFF\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n1 1 0 1 0 0 1\n"
                "3 0 1 2 0.5 0.5 0.5\n",
                1, 2);
    expect_text(
        "normals and texture coordinates", "x.off",
        "STCNOFF\n3 2 0\n0 0 0 0 0 1 .5 1 1 1 0 0\n1 0 0 0 0 1 1 1 1 1 0 0\n1 1 0 0 0 1 1 1 "
        "1 1 0 0\n"
        "3 0 1 2 9 9 9\n3 0 1 2\n",
        2, 4);
    expect_text("Windows", "x.off", "OFF\r\n3 1 0\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n3 0 1 2\r\n", 1, 2);
    expect_text("an index out of range", "x.off",
                "OFF\n3 2 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 3\n3 0 1 2\n", 1, 2);
    refuse_text("an index out of range, but for --lenient", "x.off",
                "OFF\n3 2 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 3\n3 0 1 2\n", "face 1 has a corner");
    refuse_text("a lying count of vertices", "x.off", "OFF\n4000000000 1 0\n0 0 0\n1 0 0\n",
                "vertex 3 of 4000000000: the file ends here");
    refuse_text("of faces", "x.off", "OFF\n3 4000000000 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n",
                "face 2 of 4000000000: the file ends here");
    refuse_text("of corners", "x.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n4000000000 0 1 2\n",
                "face 1 of 1: the file ends here");
    refuse_text("a word for a number", "x.off", "OFF\n3 1 0\n0 0 zero\n",
                "vertex 1 of 3: expected a number");
#define OFF_CORNERS "\n3 2 0\n0 0 0\n1 0 0\n1 1 0\n"
    refuse_text("a count below 0", "x.off", "OFF\n-3 1 0\n0 0 0\n",
                "counts of vertices, faces and edges: expected numbers from 0");
    refuse_text("a colour of two numbers", "x.off",
                "OFF" OFF_CORNERS "3 0 1 2 255 0\n3 0 1 2 255 0 0\n",
                "face 1 of 2: expected a col");
    refuse_text(
        "a colour cut off within its numbers", "x.off",
        "OFF" OFF_CORNERS "3 0 1 2 .5 .5 .5 1\n3 0 1 2 .5 .5 .5",
        "face 2 of 2: the file ends, without a line end, in a colour of 3 numbers after one of 4");
    refuse_text(
        "and before them", "x.off", "OFF" OFF_CORNERS "3 0 1 2 9 9 9\n3 0 1 2 ",
        "face 2 of 2: the file ends, without a line end, in a colour of 0 numbers after one of 3");
    refuse_text("within an exponent", "x.off",
                "OFF" OFF_CORNERS "3 0 1 2 .5 .5 .5\n3 0 1 2 .5 .5 5e",
                "face 2 of 2: expected a number");
    refuse_text("vertices without the colours that are promised", "x.off",
                "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 255 0\n1 1 0 255 0 0 255\n3 0 1 2\n",
                "vertex 2 of 3: expected 4 numbers behind the coordinates, got 2");
    refuse_text("a corner between two vertices", "x.off",
                "OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 1.5\n", "expected a whole number, got 1.5");
    refuse_text("more faces than promised", "x.off",
                "OFF" OFF_CORNERS "3 0 1 2\n3 0 1 2\n3 0 2 1\n", "more follows the 2 faces");
    expect_text("points and edges", "x.off", "OFF" OFF_CORNERS "2 0 1\n3 0 1 2\n", 1, 2);
    warnings_clear(&warnings);
    expect_text("a last line without an end", "x.off", "OFF" OFF_CORNERS "3 0 1 2\n3 0 1 2", 2, 4);
    ok(warnings_of_kind(&warnings, "last line without an end") == 1, "with a warning");
    refuse_text("four dimensions", "x.off", "4OFF\n3 1 0\n", "only three dimensions");
    refuse_text("binary", "x.off", "OFF BINARY\n", "binary OFF");
    refuse_text("something else", "x.off", "offside\n", "expected OFF");
}

/* -- colours ---------------------------------------------------------------------------------- */

/* Reads two triangles over the corners of a square and expects the colours of their first corners,
 * in light, and whether they are blended. */
static void expect_colours(const char *what, const char *name, const char *text, const float a[4],
                           const float b[4], bool blended, const char *warning)
{
    struct scene *s = NULL;
    warnings_clear(&warnings);
    files_write(name, text);
    struct error *err = scene_read(&s, files_path(name), NULL, true, &warnings);
    if (err)
        bail("%s", error_message(err));
    const struct scene_mesh *mesh = &s->meshes[0];
    bool right = mesh->colour && mesh->triangle_count == 2;
    for (size_t k = 0; k < 4 && right; k++)
        right = fabs(mesh->colour[4 * mesh->index[0] + k] / 65535.0 - (double)a[k]) < 2e-5 &&
                fabs(mesh->colour[4 * mesh->index[3] + k] / 65535.0 - (double)b[k]) < 2e-5;
    ok(right && s->materials[0].albedo.x == 1 &&
           s->materials[0].alpha == (blended ? SCENE_BLEND : SCENE_OPAQUE),
       "%s: colours", what);
    ok(warning ? warnings_of_kind(&warnings, warning) == 1 && warnings.count == 1
               : warnings.count == 0,
       "%s: %s", what, warning ? warning : "no warning");
    scene_destroy(s);
}

#define PLY_POINTS                                                                                 \
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"                \
    "property float z\n"
#define PLY_FACES "element face 2\nproperty list uchar int vertex_indices\n"
#define PLY_END "end_header\n"
#define BOTH "3 0 1 2\n3 2 3 0\n"

static void test_colours(void)
{
    /* the light of codes 128, 51 and 255 */
    static const float first[4] = {0.2158605f, 0.0331048f, 1, 1}, last[4] = {0, 1, 0, 1},
                       thin[4] = {0.2158605f, 0.0331048f, 1, 0.2f}, grey[4] = {0.8f, 0.8f, 0.8f, 1},
                       half[4] = {0.2140411f, 0.0331048f, 1, 1};
    expect_colours(
        "PLY in bytes", "x.ply",
        PLY_POINTS
        "property uchar red\nproperty uchar green\nproperty uchar blue\n" PLY_FACES PLY_END
        "0 0 0 128 51 255\n1 0 0 9 9 9\n1 1 0 0 255 0\n"
        "0 1 0 9 9 9\n" BOTH,
        first, last, false, NULL);
    expect_colours("PLY with alpha", "x.ply",
                   PLY_POINTS
                   "property uchar alpha\nproperty uchar diffuse_red\n"
                   "property uchar diffuse_green\nproperty uchar diffuse_blue\n" PLY_FACES PLY_END
                   "0 0 0 255 128 51 255\n1 0 0 255 9 9 9\n1 1 0 255 0 255 0\n"
                   "0 1 0 255 9 9 9\n" BOTH,
                   first, last, false, NULL);
    expect_colours("PLY with an alpha that blends", "x.ply",
                   PLY_POINTS "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                              "property uchar alpha\n" PLY_FACES PLY_END
                              "0 0 0 128 51 255 51\n1 0 0 9 9 9 255\n1 1 0 0 255 0 255\n"
                              "0 1 0 9 9 9 0\n" BOTH,
                   thin, last, true, NULL);
    expect_colours("PLY with an alpha that hides all", "x.ply",
                   PLY_POINTS
                   "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                   "property uchar alpha\n" PLY_FACES PLY_END
                   "0 0 0 128 51 255 0\n1 0 0 9 9 9 0\n1 1 0 0 255 0 0\n0 1 0 9 9 9 0\n" BOTH,
                   first, last, false, "alpha 0 everywhere");
    expect_colours("PLY in 16 bits", "x.ply",
                   PLY_POINTS
                   "property ushort red\nproperty ushort green\n"
                   "property ushort blue\n" PLY_FACES PLY_END
                   "0 0 0 32896 13107 65535\n1 0 0 9 9 9\n1 1 0 0 65535 0\n0 1 0 9 9 9\n" BOTH,
                   first, last, false, NULL);
    expect_colours(
        "PLY in floats", "x.ply",
        PLY_POINTS
        "property float red\nproperty float green\nproperty float blue\n" PLY_FACES PLY_END
        "0 0 0 .5 .2 1\n1 0 0 0 0 0\n1 1 0 0 1 0\n0 1 0 0 0 0\n" BOTH,
        half, last, false, NULL);
    expect_colours(
        "PLY in floats up to 255", "x.ply",
        PLY_POINTS
        "property float red\nproperty float green\nproperty float blue\n" PLY_FACES PLY_END
        "0 0 0 128 51 255\n1 0 0 0 0 0\n1 1 0 0 255 0\n"
        "0 1 0 0 0 0\n" BOTH,
        first, last, false, NULL);
    expect_colours(
        "PLY in floats beyond 1", "x.ply",
        PLY_POINTS
        "property float red\nproperty float green\nproperty float blue\n" PLY_FACES PLY_END
        "0 0 0 .5 .2 1.5\n1 0 0 0 0 0\n1 1 0 0 1 0\n0 1 0 0 0 0\n" BOTH,
        half, last, false, "colour above 1");
    expect_colours("PLY with colours of faces", "x.ply",
                   PLY_POINTS PLY_FACES
                   "property uchar red\nproperty uchar green\nproperty uchar blue\n" PLY_END
                   "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 128 51 255\n3 2 3 0 0 255 0\n",
                   first, last, false, NULL);
    expect_colours("PLY with a picture", "x.ply",
                   "ply\nformat ascii 1.0\ncomment TextureFile a b.png\nelement vertex 4\n"
                   "property float x\nproperty float y\nproperty float z\n" PLY_FACES
                   "property uchar red\nproperty uchar green\nproperty uchar blue\n" PLY_END
                   "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 128 51 255\n3 2 3 0 0 255 0\n",
                   first, last, false, "picture of PLY");
    expect_colours("COFF in whole numbers", "x.off",
                   "COFF\n4 2 0\n0 0 0 128 51 255 255\n1 0 0 9 9 9 255\n1 1 0 0 255 0 255\n"
                   "0 1 0 9 9 9 255\n" BOTH,
                   first, last, false, NULL);
    expect_colours("COFF in shares, with alpha", "x.off",
                   "COFF\n4 2 0\n0 0 0 .5019608 .2 1 .2\n1 0 0 1 0 0 1\n1 1 0 0 1 0 1\n"
                   "0 1 0 1 0 0 1\n" BOTH,
                   thin, last, true, NULL);
    expect_colours("CNOFF: normals first", "x.off",
                   "CNOFF\n4 2 0\n0 0 0 0 0 1 128 51 255\n1 0 0 0 0 1 9 9 9\n"
                   "1 1 0 0 0 1 0 255 0\n0 1 0 0 0 1 9 9 9\n" BOTH,
                   first, last, false, NULL);
    expect_colours("OFF with colours of faces", "x.off",
                   "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 128 51 255 255\n3 2 3 0\n",
                   first, grey, false, NULL);
    struct scene *s = NULL;
    files_write("x.off", "OFF\n4 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 1 0 0\n3 2 3 0 0 1 0\n"
                         "3 0 1 3 1 0 0\n");
    must(scene_read(&s, files_path("x.off"), NULL, true, &warnings));
    ok(s->meshes[0].vertex_count == 7, "vertices between faces of two colours are two: %zu of 7",
       s->meshes[0].vertex_count);
    scene_destroy(s);
}

/* -- STL -------------------------------------------------------------------------------------- */

static struct bytes make_stl(const char *header, uint32_t promised, int facets)
{
    struct bytes out = {.size = 0};
    uint8_t name[80] = {0};
    memcpy(name, header, strlen(header));
    put(&out, name, sizeof name);
    put(&out, &promised, sizeof promised);
    for (int f = 0; f < facets; f++) {
        const float numbers[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, (float)f};
        put(&out, numbers, sizeof numbers);
        put(&out, "\0\0", 2);
    }
    return out;
}

static void test_stl(void)
{
#define FACET                                                                                      \
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 4000000.123456789 0 0\n"            \
    "  vertex 4000000.123456789 1 0\n endloop\nendfacet\n"
    expect_text("STL", "x.stl",
                "solid a vertex of names\n" FACET FACET "endsolid a vertex of names\n", 2,
                4 * far_away);
    expect_text("several solids, in capitals", "x.stl",
                "SOLID\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 1 1 "
                "0\nENDLOOP\nENDFACET\n"
                "ENDSOLID\nsolid b\n" FACET "endsolid",
                2, 2 + 2 * far_away);
    expect_text("a loop of four", "x.stl",
                "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 "
                "0\nendloop\nendfacet\n"
                "endsolid\n",
                2, 3);
    struct bytes file = make_stl("made by hand", 3, 3);
    expect("binary STL", "x.stl", file.data, file.size, 3, 6);
    file = make_stl("solid made by a liar", 3, 3);
    expect("binary STL that calls itself solid", "x.stl", file.data, file.size, 3, 6);
    file = make_stl("made by hand", 2, 3);
    expect("bytes behind the last facet", "x.stl", file.data, file.size, 2, 4);
    const struct bytes data_of_two = file;
    file = make_stl("made by hand", 4000000000u, 3);
    refuse("a header that counts the facets wrong", "x.stl", data_of_two.data, data_of_two.size,
           "promises 2 facets, and 1 more follow");
    refuse("a lying count", "x.stl", file.data, file.size,
           "promises 4000000000 facets, there is room for 3");
    refuse("a header cut off", "x.stl", file.data, 83, "expected STL");
    refuse_text("cut off in a facet", "x.stl",
                "solid\n" FACET "facet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
                "without endsolid");
    refuse_text("cut off between facets", "x.stl", "solid\n" FACET, "without endsolid");
    refuse_text("cut off in endsolid", "x.stl", "solid\n" FACET "endsol", "without endsolid");
    refuse_text("a loop of two corners", "x.stl",
                "solid\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendsolid\n",
                "face 1 has 2 corners");
    refuse_text("an unknown word in a loop", "x.stl", "solid\nouter loop\nvertx 0 0 0\n",
                "facet 1: expected vertex or endloop, got 'vertx'");
    refuse_text("a vertex outside of loops", "x.stl", "solid\nvertex 0 0 0\nendsolid\n",
                "expected a loop around vertices, got 'vertex'");
    refuse_text("a word for a number", "x.stl", "solid\nouter loop\nvertex 0 zero 0\n",
                "expected 3 coordinates");
}

/* The content tells the format where the name does not. */
/* Facets of one triangle each with these two bytes. */
static void expect_paint(const char *what, const char *header, size_t header_size, uint16_t first,
                         uint16_t second, const float *a, const float *b)
{
    struct bytes out = make_stl("", 2, 2);
    struct scene *s = NULL;
    memcpy(out.data, header, header_size);
    memcpy(out.data + 84 + 48, &first, 2);
    memcpy(out.data + 84 + 50 + 48, &second, 2);
    files_write_bytes("x.stl", out.data, out.size);
    must(scene_read(&s, files_path("x.stl"), NULL, true, &warnings));
    const struct scene_mesh *mesh = &s->meshes[0];
    bool right = a ? mesh->colour != NULL : !mesh->colour;
    for (size_t k = 0; k < 4 && right && a; k++)
        right = fabs(mesh->colour[4 * mesh->index[0] + k] / 65535.0 - (double)a[k]) < 2e-5 &&
                fabs(mesh->colour[4 * mesh->index[3] + k] / 65535.0 - (double)b[k]) < 2e-5;
    ok(right, "STL: %s", what);
    scene_destroy(s);
}

static void test_paint(void)
{
    static const float red[4] = {1, 0, 0, 1}, blue[4] = {0, 0, 1, 1}, grey[4] = {.8f, .8f, .8f, 1};
    expect_paint("VisCAM's colours, of a facet with one and one without", "x", 1, 0x8000 | 31 << 10,
                 0, red, grey);
    expect_paint("those of Magics, of a facet's own and of all", "COLOR=\x00\x00\xff\xff", 10, 31,
                 0x8000, red, blue);
    expect_paint("other bytes are no colours", "x", 1, 0x8000 | 31 << 10, 7, NULL, NULL);
}

static void test_guess(void)
{
    const struct bytes ply = make_ply("binary_little_endian", "float", "uchar", "int"),
                       stl = make_stl("made by hand", 3, 3);
    expect("PLY by content", "ply.dat", ply.data, ply.size, 2, 3);
    expect("binary STL by content", "stl.dat", stl.data, stl.size, 3, 6);
    expect_text("STL by content", "stl.txt", "solid\n" FACET "endsolid\n", 1, 2 * far_away);
    expect_text("OFF by content", "off", "OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n", 1, 2);
}

/* -- oddities --------------------------------------------------------------------------------- */

#define BARE_PLY                                                                                   \
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"                     \
    "property float nx\nelement face 1\nproperty list uchar int vertex_indices\n"
#define BARE_STL                                                                                   \
    "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n"          \
    "endloop\nendfacet\nendsolid x\n"

/* What exporters write and what takes nothing away. */
static void test_oddities(void)
{
    static const char body[] = "0 0 0 nan\n1 0 0 -nan(ind)\n1 1 0 -1.#IND00\nnan nan nan 1.#QNAN\n"
                               "3 0 1 2\n";
    struct bytes file = {.size = 0};
    char ply[1024];
    lenient = false;
    snprintf(ply, sizeof ply, "\xef\xbb\xbfply \nformat ascii 1.0\n" BARE_PLY "end_header \n%s\x1a",
             body);
    expect_text("a byte order mark, blanks, Ctrl-Z, and numbers of Windows that are none",
                "odd.ply", ply, 1, 2);
    snprintf(ply, sizeof ply, "ply\nformat ascii 1.0\n" BARE_PLY "end_header\n%s", body);
    for (char *at = ply; (at = strchr(at, '\n'));)
        *at = '\r';
    expect_text("lines of PLY that end as on old Macs", "mac.ply", ply, 1, 2);
    for (char *at = ply; (at = strstr(at, "element "));)
        at[7] = '\t';
    expect_text("and tabs", "tabs.ply", ply, 1, 2);
    expect_text("a byte order mark of STL", "odd.stl", "\xef\xbb\xbf" BARE_STL, 1, 2);
    expect_text("no blank behind OFF, as in ModelNet", "odd.off",
                "OFF3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n", 1, 2);
    expect_text("a byte order mark and Ctrl-Z of OFF", "odd.off",
                "\xef\xbb\xbfOFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n\x1a", 1, 2);
    put_text(&file, "solid of a program that pads its files");
    const float facet[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0};
    const uint32_t one = 1;
    memset(file.data + file.size, ' ', 80 - file.size);
    memcpy(file.data + 80, &one, sizeof one);
    memcpy(file.data + 84, facet, sizeof facet);
    memset(file.data + 84 + sizeof facet, 0, 4);
    expect("binary STL that begins with solid, with bytes behind it", "pad.stl", file.data, 84 + 52,
           1, 2);
    lenient = true;
    snprintf(ply, sizeof ply, "ply\nformat ascii 1.0\n%send_header\n%s4 0 1 2", BARE_PLY, body);
    *strstr(strstr(ply, "face 1"), "1") = '2';
    expect_text("the whole faces of a PLY that is cut off, with --lenient", "cut.ply", ply, 1, 2);
    expect_text("those of a text of STL", "cut.stl",
                "solid\n" FACET "facet normal 0 0 1\nouter loop\nvertex 9 0 0\n", 1, 2 * far_away);
    file = make_stl("made by hand", 4000000000u, 3);
    expect("and those of a binary one", "cut.stl", file.data, file.size, 3, 6);
}

int main(void)
{
    files_begin();
    test_oddities();
    test_ply();
    test_off();
    test_colours();
    test_stl();
    test_paint();
    test_guess();
    warnings_clear(&warnings);
    files_end();
    return tap_done();
}
