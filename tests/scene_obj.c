/* SPDX-License-Identifier: Apache-2.0 */
/* OBJ and MTL as real files are: each kind of dirt is read for what it means, or left out with a
 * warning. */
#include "base/error.h"
#include "base/warning.h"
#include "import/import_scene.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "scene/scene_shade.h"
#include "support/files.h"
#include "support/tap.h"

#include <stb_image_write.h>
#include <stdint.h>
#include <string.h>

static struct warnings warnings;

/* Reads "x.obj" of this text. */
static struct scene *read_obj(const char *text)
{
    struct scene *scene = NULL;
    warnings_clear(&warnings);
    files_write("x.obj", text);
    struct scene_settings settings = scene_settings_default();
    settings.lenient = true;
    struct error *err = scene_read(&scene, files_path("x.obj"), &settings, true, &warnings);
    if (err)
        bail("%s", error_message(err));
    return scene;
}

static double area(const struct scene *s)
{
    double sum = 0;
    for (size_t i = 0; i < s->mesh_count; i++) {
        const struct scene_mesh *m = &s->meshes[i];
        for (size_t t = 0; t < m->triangle_count; t++) {
            const struct vec3 a = vec3_load(m->position + 3 * (size_t)m->index[3 * t]),
                              b = vec3_load(m->position + 3 * (size_t)m->index[3 * t + 1]),
                              c = vec3_load(m->position + 3 * (size_t)m->index[3 * t + 2]);
            sum += 0.5 * vec3_length(vec3_cross(vec3_sub(b, a), vec3_sub(c, a)));
        }
    }
    return sum;
}

#define CORNERS "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

/* Reads the text and expects so many triangles, this area, and `kind` of warning (NULL: none at
 * all). */
static void expect(const char *name, const char *text, size_t triangles, double wanted,
                   const char *kind)
{
    struct scene *s = read_obj(text);
    const double got = area(s);
    const bool warned = kind ? warnings_of_kind(&warnings, kind) > 0 : warnings.count == 0;
    ok(scene_triangle_count(s) == triangles && fabs(got - wanted) < 1e-12 && warned,
       "%s: %zu triangles, area %g, %s", name, scene_triangle_count(s), got,
       warned ? "warned as it should" : "the wrong warnings");
    if (!warned)
        warnings_print(&warnings, "#");
    scene_destroy(s);
}

static void test_geometry(void)
{
    expect("a quadrilateral", CORNERS "f 1 2 3 4\n", 2, 1, NULL);
    expect("negative indices", CORNERS "f -4 -3 -2 -1\n", 2, 1, NULL);
    expect("a hollow polygon",
           "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 3 1 0\nv 1 1 0\nv 0 4 0\nf 1 2 3 4 5 6\n", 4, 16 - 9,
           NULL);
    expect("a hollow quadrilateral far from the origin",
           "v 100 100 9\nv 102 101 9\nv 100 102 9\nv 100.5 101 9\n"
           "f 1 2 3 4\n",
           2, 1.5, NULL);
    expect("comments behind values",
           "v 0 0 0 # first\nv 1 0 0# second\nv 1 1 0\t# third\nv 0 1 0\n"
           "f 1 2 3 4# the face\n",
           2, 1, NULL);
    expect("comments behind faces", CORNERS "f 1/1 2/2 3/3 #4/4\nf 1 3 4 # 1 2\n#f 1 2 3\n", 2, 1,
           NULL);
    expect("tabs and blanks", "v\t0\t0\t0 \n  v 1 0 0\nv  1   1\t0\nv 0 1 0\n\tf\t1\t2  3 4  \n", 2,
           1, NULL);
    expect("Windows line ends", "v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nf 1 2 3\r\n", 1, 0.5, NULL);
    expect("old Macintosh line ends", "v 0 0 0\rv 1 0 0\rv 1 1 0\rf 1 2 3\r", 1, 0.5, NULL);
    expect("a byte order mark", "\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", 1, 0.5, NULL);
    expect("continued lines", "v 0 0 \\\n0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 \\\r\n3 \\\n4\n", 2, 1,
           NULL);
    expect("no line end at the end", CORNERS "f 1 2 3 4", 2, 1, "last line without an end");
    expect("no line end behind a comment", CORNERS "f 1 2 3 4 # 2", 2, 1, NULL);
    expect("no line end behind a name", CORNERS "f 1 2 3 4\ng 2b", 2, 1, NULL);
    expect("vertices behind the faces that use them", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 1 1 0\n", 1,
           0.5, NULL);
    expect("exponents and signs", "v +0 -0 .0\nv 1e0 0. 0E-3\nv 10.e-1 +.1E+1 0\nf 1 2 3\n", 1, 0.5,
           NULL);
    expect("vertex colours and weights", "v 0 0 0 .1 .2 .3\nv 1 0 0 1 0 0\nv 1 1 0 1\nf 1 2 3\n", 1,
           0.5, NULL);
    expect("all kinds of corners",
           CORNERS "vn 0 0 1\nvt 0 0\nf 1 2 3\nf 1/1 3/1 4/1\nf 1//1 2//1 3//1\n"
                   "f 1/1/1 2/1/1 3/1/1\nf 1/ 2/ 3/\n",
           5, 2.5, NULL);
    expect("points, lines, groups, smoothing",
           CORNERS "p 1\nl 1 2 3\ng a b\ng\no thing\ns 1\ns off\nf 1 2 3\nl 1 2\n", 1, 0.5, NULL);
    expect("the old word for a face", CORNERS "fo 1 2 3\n", 1, 0.5, NULL);
    expect("faces of one and two corners", CORNERS "f 1\nf 1 2\nf 1 2 3\n", 1, 0.5,
           "faces of fewer than 3 corners");
    expect("an index beyond the vertices", CORNERS "f 1 2 3\nf 1 2 9\nf 1 3 4\n", 2, 1,
           "index out of range");
    expect("an index before the vertices", CORNERS "f -5 -3 -2\nf 1 2 3\n", 1, 0.5,
           "index out of range");
    expect("index 0, and words", CORNERS "f 0 1 2\nf a b c\nf 1 2 3\n", 1, 0.5,
           "index out of range");
    expect("indices that wrap round", CORNERS "f 4294967297 4294967298 4294967299\nf 1 2 3\n", 1,
           0.5, "index out of range");
    expect("coordinates that are no numbers",
           CORNERS "v nan 0 0\nv 1 inf 0\nv 1 2\nv 0,5 0 0\nv 1.#QNAN 0 0\nf 1 2 3\n"
                   "f 1 2 5\nf 1 2 6\nf 1 2 7\nf 1 2 8\nf 1 2 9\n",
           1, 0.5, "vertex not understood");
    expect("numbers beyond double", CORNERS "v 1e999 0 0\nf 1 2 3\nf 1 2 5\n", 1, 0.5,
           "vertex not finite");
    expect("corners that are no whole numbers", CORNERS "f 1.0 2 3\nf 1/1/1/1 2 3\nf 1 2 3\n", 1,
           0.5, "index out of range");
    expect("duplicate and non-manifold faces",
           CORNERS "v 0 0 1\nf 1 2 3\nf 1 2 3\nf 3 2 1\nf 1 2 5\n", 4, 2, NULL);
    expect("a T-junction", CORNERS "v .5 0 0\nf 1 2 3\nf 1 3 4\nf 1 5 3\n", 3, 1.25, NULL);
    expect("free-form surfaces", CORNERS "cstype bspline\nsurf 0 1 0 1 1 2 3\nend\nf 1 2 3\n", 1,
           0.5, "free-form geometry");
    expect("nothing at all", "", 0, 0, "file empty");
    expect("a face that is cut off", CORNERS "f 1 2 3\nf 1 3", 1, 0.5, "file cut off");
    expect("the last vertices without a face", CORNERS "f 1 2 3 4\nv 5 0 0\nv 6 0 0\nv 6 1 0\n", 2,
           1, "vertices without faces");
    expect("such vertices of a line", CORNERS "f 1 2 3 4\nv 5 0 0\nv 6 0 0\nv 6 1 0\nl 5 6 7\n", 2,
           1, NULL);
    expect("two vertices to spare", CORNERS "f 1 2 3 4\nv 5 0 0\nv 6 0 0\n", 2, 1, NULL);
    expect("the last material without a face", CORNERS "f 1 2 3 4\nusemtl lamp\n", 2, 1,
           "material without faces");
    expect("materials without a face before others", CORNERS "usemtl\nf 1 2 3 4\n", 2, 1,
           "material missing");
    ok(warnings.count == 1, "and no word of a file that is cut off");

    expect("statements that say nothing of triangles",
           CORNERS "g\no x\ns 1\nmg 1 2\nlod 1\nusemap off\nmaplib a\nbevel on\nc_interp off\n"
                   "d_interp off\nshadow_obj a\ntrace_obj a\nvn 0 0 1\nvp 0 0\n#\n# v\nf 1 2 3\n",
           1, 0.5, NULL);
    expect("statements that OBJ has not", CORNERS "F 1 2 3\nfoo\nF 1 3 4\nf 1 2 3\n", 1, 0.5,
           "statement unknown");
    ok(warnings.count == 1 &&
           strstr(warnings.list[0].message, ": 3 lines that begin with 'F', 'foo' are no"),
       "they are named once");
    static char text[20000];
    char *to = text + sprintf(text, CORNERS);
    for (int i = 0; i < 300; i++)
        to += sprintf(to, i % 10 < 7 ? "f 1 2 2\n" : "f 1 2 3\n");
    struct scene *s = read_obj(text);
    ok(scene_triangle_count(s) == 90 && s->degenerate_count == 210 && warnings.count == 1,
       "70 %% of faces without area: %zu left out", s->degenerate_count);
    scene_destroy(s);

    to = text + sprintf(text, "v 0 0 0\n");
    for (int i = 0; i < 300; i++)
        to += sprintf(to, "v %.15g %.15g 0\n", cos(i * 2 * acos(-1.0) / 300),
                      sin(i * 2 * acos(-1.0) / 300));
    to += sprintf(to, "f");
    for (int i = 0; i < 300; i++)
        to += sprintf(to, " %d", i + 2);
    s = read_obj(text);
    ok(scene_triangle_count(s) == 298 && fabs(area(s) - 150 * sin(2 * acos(-1.0) / 300)) < 1e-12,
       "a polygon of 300 corners");
    scene_destroy(s);
}

static void test_numbers(void)
{
    struct scene *s =
        read_obj("v 500000.123456789 4000000.987654321 0.1\nv 1 0.588 0\nv 0 1 1e-5\nf 1 2 3\n");
    const double *p = s->meshes[0].position;
    ok(fabs(p[0] / 500000.123456789 - 1) < 1e-15 && fabs(p[1] / 4000000.987654321 - 1) < 1e-15 &&
           fabs(p[4] / 0.588 - 1) < 1e-15,
       "positions keep the precision of double");
    scene_destroy(s);
}

/* -- materials -------------------------------------------------------------------------------- */

#define FACE CORNERS "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"

/* Reads one square of material m, which the MTL text defines. */
static struct scene *read_mtl(const char *text)
{
    files_write("x.mtl", text);
    return read_obj("mtllib x.mtl\n" FACE "usemtl m\nf 1/1 2/2 3/3 4/4\n");
}

static bool is_colour(struct vec3f c, double r, double g, double b)
{
    const bool is = fabs((double)c.x - r) < 1e-6 && fabs((double)c.y - g) < 1e-6 &&
                    fabs((double)c.z - b) < 1e-6;
    if (!is)
        printf("# colour %g %g %g\n", (double)c.x, (double)c.y, (double)c.z);
    return is;
}

/* Expects the albedo of material m at the middle of the square, and a kind of warning (NULL:
 * none). */
static void expect_albedo(const char *name, const char *text, double r, double g, double b,
                          const char *kind)
{
    struct scene *s = read_mtl(text);
    const bool warned = kind ? warnings_of_kind(&warnings, kind) > 0 : warnings.count == 0;
    ok(s->material_count == 1 &&
           is_colour(scene_albedo(s, &s->materials[0], 0.5f, 0.5f), r, g, b) && warned,
       "%s%s", name, warned ? "" : ": the wrong warnings");
    if (!warned)
        warnings_print(&warnings, "#");
    scene_destroy(s);
}

/* Pictures of 2 x 2 texels: all of one colour, a mask whose left half is 0, the same as alpha, and
 * a red-green-blue-white one. */
static void write_pictures(void)
{
    uint8_t code[16];
    memset(code, 188, 12); /* linear 0.50289 */
    stbi_write_png(files_path("grey.png"), 2, 2, 3, code, 6);
    files_make_directory("a dir");
    stbi_write_png(files_path("a dir/My Grey.png"), 2, 2, 3, code, 6);
    stbi_write_png(files_path("50%# grey.png"), 2, 2, 3, code, 6);
    files_make_directory("sub");
    stbi_write_png(files_path("sub/beside.png"), 2, 2, 3, code, 6);
    const uint8_t mask[4] = {0, 255, 0, 255};
    stbi_write_png(files_path("mask.png"), 2, 2, 1, mask, 2);
    const uint8_t alpha[16] = {9, 9, 9, 0, 9, 9, 9, 255, 9, 9, 9, 0, 9, 9, 9, 255};
    stbi_write_png(files_path("alpha.png"), 2, 2, 4, alpha, 8);
    const uint8_t four[12] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
    stbi_write_png(files_path("four.png"), 2, 2, 3, four, 6);
    const float radiance[12] = {8, 4, 2, 8, 4, 2, 8, 4, 2, 8, 4, 2};
    stbi_write_hdr(files_path("lamp.hdr"), 2, 2, 3, radiance);
    files_write("broken.png", "\x89PNG\r\n\x1a\n and no more");
}

static void test_albedo(void)
{
    const double grey = 0.502886;
    expect_albedo("Kd", "newmtl m\nKd .1 .2 .3\n", .1, .2, .3, NULL);
    expect_albedo("no Kd", "newmtl m\nNs 10\n", .8, .8, .8, NULL);
    expect_albedo("no Kd, after a material with it", "newmtl a\nKd .1 .2 .3\nnewmtl m\nillum 2\n",
                  .8, .8, .8, NULL);
    expect_albedo("Kd 0", "newmtl m\nKd 0 0 0\n", 0, 0, 0, NULL);
    expect_albedo("Kd of one number", "newmtl m\nKd .4\n", .4, .4, .4, NULL);
    expect_albedo("Kd of words", "newmtl m\nKd spectral a.rfl\n", .8, .8, .8,
                  "colour not understood");
    expect_albedo("Kd of no numbers", "newmtl m\nKd nan nan nan\n", .8, .8, .8,
                  "colour not understood");
    expect_albedo("Kd 0 with a picture", "newmtl m\nKd 0 0 0\nmap_Kd four.png\n", 0, 0, 0,
                  "Kd 0 with a picture");
    expect_albedo("Kd 0 alone", "newmtl m\nKd 0 0 0\n", 0, 0, 0, NULL);
    expect_albedo("d 0", "newmtl m\nKd 1 1 1\nd 0\n", 1, 1, 1, "nothing to be seen");
    expect_albedo("d against Tr", "newmtl m\nKd 1 1 1\nd 1\nTr 1\n", 1, 1, 1, "d against Tr");
    expect_albedo("d and Tr", "newmtl a\nd .5\nnewmtl m\nKd 1 1 1\nTr .25\nd .75\n", 1, 1, 1, NULL);
    expect_albedo("Tr 1", "newmtl m\nKd 1 1 1\nTr 1\n", 1, 1, 1, "nothing to be seen");
    expect_albedo("a lamp that is lost", "newmtl m\nKd 1 1 1\nnewmtl lamp\nKe 9 9 9\n", 1, 1, 1,
                  "light that nothing has");
    expect_albedo("Kd below 0", "newmtl m\nKd .5 -.5 .5\n", .5, 0, .5, "material out of range");
    expect_albedo("Kd above 1", "newmtl m\nKd 2 .5 .5\n", 1, .5, .5, "albedo limited");
    expect_albedo("tabs, blanks and comments", "  newmtl\tm \n\tKd\t.1  .2\t.3 # colour\n", .1, .2,
                  .3, NULL);
    expect_albedo("a byte order mark and Windows line ends",
                  "\xef\xbb\xbfnewmtl m\r\nKd .1 .2 .3\r\n", .1, .2, .3, NULL);
    expect_albedo("keys in small letters", "newmtl m\nkd .1 .2 .3\n", .1, .2, .3, NULL);
    expect_albedo("a comment behind the name", "newmtl m # main\nKd .1 .2 .3\n", .1, .2, .3, NULL);
    expect_albedo("a name twice", "newmtl m\nKd .1 .2 .3\nnewmtl m\nKd .4 .5 .6\n", .1, .2, .3,
                  "material defined twice");
    expect_albedo("no such material", "newmtl n\nKd .1 .2 .3\n", .8, .8, .8, "material missing");
    expect_albedo("an empty file", "", .8, .8, .8, "material file missing");
    expect_albedo("Kd and map_Kd", "newmtl m\nKd .5 .5 1\nmap_Kd grey.png\n", grey / 2, grey / 2,
                  grey, NULL);
    expect_albedo("map_Kd without Kd", "newmtl m\nmap_Kd grey.png\n", grey, grey, grey, NULL);
    expect_albedo("map_Kd before Kd", "newmtl m\nmap_Kd grey.png\nKd .5 .5 1\n", grey / 2, grey / 2,
                  grey, NULL);
    expect_albedo("a texture that is missing", "newmtl m\nKd .5 .5 1\nmap_Kd none.png\n", .5, .5, 1,
                  "texture missing");
    expect_albedo("and no Kd", "newmtl m\nmap_Kd none.png\n", .8, .8, .8, "texture missing");
    expect_albedo("a texture that is damaged", "newmtl m\nmap_Kd broken.png\n", .8, .8, .8,
                  "texture damaged");
    expect_albedo("a directory for a texture", "newmtl m\nmap_Kd sub\n", .8, .8, .8,
                  "texture missing");
    expect_albedo("blanks in its path", "newmtl m\nmap_Kd a dir/My Grey.png\n", grey, grey, grey,
                  NULL);
    expect_albedo("quotes around its path", "newmtl m\nmap_Kd \"a dir/My Grey.png\"\n", grey, grey,
                  grey, NULL);
    expect_albedo("backslashes in its path", "newmtl m\nmap_Kd a dir\\My Grey.png\r\n", grey, grey,
                  grey, NULL);
    expect_albedo("its letters in another case", "newmtl m\nmap_Kd A DIR\\MY GREY.PNG\n", grey,
                  grey, grey, NULL);
    expect_albedo("the path of another machine", "newmtl m\nmap_Kd C:\\work\\textures\\Grey.png\n",
                  grey, grey, grey, NULL);
    expect_albedo("a comment behind its path", "newmtl m\nmap_Kd grey.png # wall\n", grey, grey,
                  grey, NULL);
    expect_albedo("signs in its name", "newmtl m\nmap_Kd 50%# grey.png\n", grey, grey, grey, NULL);
    expect_albedo("options before its path",
                  "newmtl m\nmap_Kd -blendu on -blendv off -boost 1 -clamp on -bm 0.5 -texres 64 "
                  "-imfchan r -type "
                  "sphere -colorspace sRGB grey.png\n",
                  grey, grey, grey, NULL);
    expect_albedo("options of one and two numbers",
                  "newmtl m\nmap_Kd -s 2 -o 0.5 0.5 -t 0 grey.png\n", grey, grey, grey, NULL);
    expect_albedo("-mm changes the texture's values, which we do not follow",
                  "newmtl m\nmap_Kd -mm 0 2 grey.png\n", grey, grey, grey, "texture option");
    files_write("sub/y.mtl", "newmtl m\nmap_Kd beside.png\n");
    struct scene *s = read_obj("mtllib sub/y.mtl\n" FACE "usemtl m\nf 1 2 3\n");
    ok(warnings.count == 0 && is_colour(s->materials[0].albedo, 1, 1, 1) && s->texture_count == 1,
       "a texture beside its MTL file");
    scene_destroy(s);
}

/* Whether the vertices of the first mesh have these colours, in light of their codes. */
static bool has_colours(const struct scene *s, size_t count, const double *rgb)
{
    const struct scene_mesh *mesh = &s->meshes[0];
    bool right = mesh->colour && mesh->vertex_count == count;
    for (size_t i = 0; i < 3 * count && right; i++)
        right = fabs(mesh->colour[4 * (i / 3) + i % 3] / 65535.0 - rgb[i]) < 2e-5;
    return right;
}

static void test_colours(void)
{
    static const double wanted[9] = {0.2140411, 0, 1, 0, 1, 0, 1, 1, 1};
    struct scene *s = read_obj("v 0 0 0 .5 0 1\nv 1 0 0 0 1 0 1\nv 1 1 0\nf 1 2 3\n");
    ok(has_colours(s, 3, wanted) && is_colour(s->materials[0].albedo, 1, 1, 1) &&
           warnings.count == 0,
       "colours behind the coordinates: codes of a screen; of no material they are the colour");
    scene_destroy(s);
    s = read_obj("v 0 0 0 127.5 0 255\nv 1 0 0 0 255 0\nv 1 1 0 255 255 255\nf 1 2 3\n");
    ok(has_colours(s, 3, wanted), "from 0 to 255");
    scene_destroy(s);
    s = read_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\n#MRGB ff8000ffff00ff00\n#MRGB ffffffff\n"
                 "f 1 2 3\n");
    static const double painted[9] = {0.2158605, 0, 1, 0, 1, 0, 1, 1, 1};
    ok(has_colours(s, 3, painted), "ZBrush's polypaint");
    scene_destroy(s);
    files_write("x.mtl", "newmtl m\nKd .5 .25 .125\n");
    s = read_obj("mtllib x.mtl\nv 0 0 0 .5 0 1\nv 1 0 0 0 1 0\nv 1 1 0 1 1 1\nusemtl m\nf 1 2 3\n");
    ok(has_colours(s, 3, wanted) && is_colour(s->materials[0].albedo, .5f, .25f, .125f),
       "they multiply Kd");
    scene_destroy(s);
    s = read_obj("v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 1 1 0 1 1 1\nf 1 2 3\n");
    ok(!s->meshes[0].colour, "white is kept by none");
    scene_destroy(s);
}

static void test_maps(void)
{
    struct scene *s = read_mtl("newmtl m\nmap_Kd four.png\n");
    const struct scene_material *m = &s->materials[0];
    ok(is_colour(scene_albedo(s, m, .25f, .75f), 1, 0, 0) &&
           is_colour(scene_albedo(s, m, .75f, .75f), 0, 1, 0) &&
           is_colour(scene_albedo(s, m, .25f, .25f), 0, 0, 1),
       "the picture's top left is u = 0, v = 1");
    const float *uv = s->meshes[0].uv;
    const uint32_t *index = s->meshes[0].index;
    bool same = uv != NULL;
    for (size_t k = 0; k < 6 && same; k++)
        same = uv[2 * k] == (float)s->meshes[0].position[3 * index[k]] &&
               uv[2 * k + 1] == (float)s->meshes[0].position[3 * index[k] + 1];
    ok(same, "each corner has the texture coordinates that the file gives it");
    scene_destroy(s);

    s = read_mtl("newmtl m\nmap_Kd -s 0.5 0.5 -o 0.5 0 four.png\n");
    m = &s->materials[0];
    /* reads (.75, .25) */
    ok(is_colour(scene_albedo(s, m, .5f, .5f), 1, 1, 1), "-s scales and -o moves the coordinates");
    scene_destroy(s);
    s = read_mtl("newmtl m\nmap_Kd four.png\n");
    const struct vec3f repeated = scene_albedo(s, &s->materials[0], 1.25f, .75f);
    scene_destroy(s);
    s = read_mtl("newmtl m\nmap_Kd -clamp on four.png\n");
    ok(is_colour(repeated, 1, 0, 0) &&
           is_colour(scene_albedo(s, &s->materials[0], 1.25f, .75f), 0, 1, 0),
       "-clamp ends the repetition");
    scene_destroy(s);

    s = read_obj("mtllib x.mtl\n" FACE "usemtl m\nf 1/1 2/2 3/3\nf 1 3 4\nf 1/9 2/-9 3/0\n");
    uv = s->meshes[0].uv;
    ok(scene_triangle_count(s) == 3 && uv[8] == 0 && uv[12] == 0 &&
           warnings_of_kind(&warnings, "texture coordinate missing") == 1 &&
           warnings_of_kind(&warnings, "texture coordinate left out") == 1,
       "corners without texture coordinates read the texture at 0");
    scene_destroy(s);
}

static void test_alpha(void)
{
    static const char *const masks[] = {"mask.png", "alpha.png"};
    for (int i = 0; i < 2; i++) {
        char text[64];
        snprintf(text, sizeof text, "newmtl m\nmap_d %s\n", masks[i]);
        struct scene *s = read_mtl(text);
        const struct scene_material *m = &s->materials[0];
        ok(m->alpha == SCENE_CUTOUT && scene_transparency(s, m, .25f, .5f) == 1 &&
               scene_transparency(s, m, .75f, .5f) == 0,
           "map_d cuts holes: %s", masks[i]);
        scene_destroy(s);
    }
    const struct {
        const char *text;
        double passes;
    } blends[] = {{"newmtl m\nd .25\n", .75},          {"newmtl m\nd -halo .25\n", .75},
                  {"newmtl m\nTr .25\n", .25},         {"newmtl m\nd 1\nTr 1\n", 0},
                  {"newmtl m\nTr 1\nd 1\n", 0},        {"newmtl m\nd .5\nmap_d mask.png\n", .5},
                  {"newmtl m\nmap_d none.png\n", 0},   {"newmtl m\nd x\n", 0},
                  {"newmtl m\nillum 4\nTf 0 0 0\n", 0}};
    for (size_t i = 0; i < sizeof blends / sizeof *blends; i++) {
        struct scene *s = read_mtl(blends[i].text);
        const float passes = scene_transparency(s, &s->materials[0], .75f, .5f);
        ok(fabs((double)passes - blends[i].passes) < 1e-6, "share that passes: %g", (double)passes);
        scene_destroy(s);
    }
    struct scene *s = read_mtl("newmtl m\nmap_Kd alpha.png\n");
    ok(scene_transparency(s, &s->materials[0], .25f, .5f) == 0,
       "the alpha of map_Kd alone cuts nothing");
    scene_destroy(s);
}

static void test_emission(void)
{
    const struct {
        const char *text;
        double r, g, b;
    } cases[] = {{"newmtl m\nKe 17 12 4\n", 17, 12, 4},
                 {"newmtl m\nKe 2 2 2\nmap_Ke grey.png\n", 2 * .502886, 2 * .502886, 2 * .502886},
                 {"newmtl m\nmap_Ke lamp.hdr\n", 8, 4, 2},
                 {"newmtl m\nKe 0 0 0\nmap_Ke lamp.hdr\n", 0, 0, 0},
                 {"newmtl m\nmap_Ke none.hdr\n", 0, 0, 0},
                 {"newmtl m\nKd 1 1 1\n", 0, 0, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene *s = read_mtl(cases[i].text);
        const struct vec3f e = scene_emission(s, &s->materials[0], .5f, .5f);
        ok(is_colour(e, cases[i].r, cases[i].g, cases[i].b) &&
               scene_emits(&s->materials[0]) == (cases[i].r > 0),
           "emission %g %g %g", (double)e.x, (double)e.y, (double)e.z);
        scene_destroy(s);
    }
}

static void test_libraries(void)
{
    files_write("one.mtl", "newmtl a\nKd .1 .1 .1\n");
    files_write("two three.mtl", "newmtl b\nKd .2 .2 .2\n");
    files_write("sub/four.mtl", "newmtl c d\nKd .3 .3 .3\n");
    files_write("five.mtl", "newmtl Gr\xc3\xbcn\nKd .4 .4 .4\n");
    const char *const used = FACE
        "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 4\nusemtl c d\nf 2 3 4\nusemtl Gr\xc3\xbcn\n"
        "f 1 3 4\n";
    static const char *const headers[] = {
        "mtllib one.mtl\nmtllib two three.mtl\nmtllib sub\\four.mtl\nmtllib FIVE.mtl\n",
        "mtllib \"two three.mtl\"\nmtllib one.mtl sub/four.mtl five.mtl\nmtllib one.mtl\n",
    };
    for (int i = 0; i < 2; i++) {
        char text[1024];
        snprintf(text, sizeof text, "%s%s", headers[i], used);
        struct scene *s = read_obj(text);
        bool right = s->material_count == 4 && warnings.count == 0;
        for (int m = 0; m < 4 && right; m++)
            right = is_colour(s->materials[m].albedo, .1 * (m + 1), .1 * (m + 1), .1 * (m + 1));
        ok(right && !strcmp(s->materials[3].name, "Gr\xc3\xbcn"),
           "several material files, whatever they and their materials are called");
        if (!right)
            warnings_print(&warnings, "#");
        scene_destroy(s);
    }
    struct scene *s = read_obj("mtllib none.mtl\n" FACE "usemtl a\nf 1 2 3\n");
    ok(is_colour(s->materials[0].albedo, .8, .8, .8) && warnings.count == 1 &&
           warnings_of_kind(&warnings, "material file missing") == 1,
       "a missing material file is said, and grey used");
    scene_destroy(s);
    s = read_obj("mtllib none.mtl nor.mtl\n" FACE
                 "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 4\nusemtl a\nf 1 3 4\n");
    ok(warnings.count == 1 && warnings.list[0].count == 1 &&
           strstr(warnings.list[0].message, "none.mtl, nor.mtl are missing") &&
           strstr(warnings.list[0].message, " 2 of them are lost"),
       "once, with how many materials are lost");
    scene_destroy(s);
    files_write("page.mtl", "<html>404</html>\n");
    s = read_obj("mtllib page.mtl\n" FACE "usemtl a\nf 1 2 3\n");
    ok(warnings.count == 1 &&
           strstr(warnings.list[0].message, "page.mtl (it holds none) are missing"),
       "and so is a file without materials");
    scene_destroy(s);
    s = read_obj("mtllib one.mtl\n" FACE
                 "f 1 2 3\nusemtl a\nf 1 2 4\nusemtl b\nf 2 3 4\nusemtl a # again\nf 1 3 4\n");
    const int32_t *m = s->meshes[0].material;
    ok(s->material_count == 2 && m[0] == m[2] && m[1] == m[3] && m[0] != m[1] &&
           is_colour(s->materials[m[0]].albedo, .8, .8, .8),
       "faces before any material, and of an unknown one, are grey; unused materials are not kept");
    scene_destroy(s);
}

/* -- files ------------------------------------------------------------------------------------ */

static void refuse(const char *name, bool empty_allowed, const char *part)
{
    struct scene *scene = NULL;
    struct error *err = scene_read(&scene, files_path(name), NULL, empty_allowed, &warnings);
    ok(err && !scene && strstr(error_message(err), part) && strstr(error_message(err), name),
       "refused: %s", err ? strrchr(error_message(err), '/') : "(accepted)");
    error_destroy(err);
    scene_destroy(scene);
}

/* What exporters write and what takes nothing away is read, at most with a warning. */
static void test_oddities(void)
{
    static const struct {
        const char *text, *kind; /* the only warning, or NULL */
    } odd[] = {
        {CORNERS "f 1 2 3\nf 1 2\n", "faces of fewer than 3 corners"}, /* edges of Blender 2.4 */
        {CORNERS "f 1 \\ \n2 \\\t\n3\n", NULL},
        {"# C:\\models\\\n" CORNERS "f 1 2 3\n", NULL},
        {"# C:\\models\\\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", NULL},
        {CORNERS "f 1 2 3\n\x1a", NULL},
        {CORNERS "vt nan nan\nf 1/1 2/1 3/1\n", "texture coordinate not finite"},
        {CORNERS "vt 0 -nan(ind)\nf 1/1 2/1 3/1\n", "texture coordinate not finite"},
        {CORNERS "vt -1.#IND00 0\nf 1/1 2/1 3/1\n", "texture coordinate not finite"},
        {CORNERS "v nan nan nan\nv -1.#INF 0 0\nf 1 3 4\n", NULL},
    };
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        struct warnings found = {0};
        struct scene *s = NULL;
        files_write("odd.obj", odd[i].text);
        struct error *err = scene_read(&s, files_path("odd.obj"), NULL, false, &found);
        ok(!err && scene_triangle_count(s) == 1 && found.count == (odd[i].kind ? 1 : 0) &&
               (!odd[i].kind || !strcmp(found.list[0].kind, odd[i].kind)),
           "oddity %zu is read: %s", i, err ? error_message(err) : "");
        error_destroy(err);
        scene_destroy(s);
        warnings_clear(&found);
    }
}

static void test_files(void)
{
    refuse("none.obj", true, ": No such file or directory");
    refuse("sub", true, ": Is a directory");
    files_write("empty.obj", "");
    refuse("empty.obj", true, ": the file is empty");
    files_write("none.ply", " \n");
    refuse("none.ply", true, ": the file is empty");
    files_write("some.obj", CORNERS);
    refuse("some.obj", false, ": no triangle");
    static const char *const broken[][2] = {
        {CORNERS "f 1 2 3\nf 1 2 9\n", "x.obj:6: face 2"},
        {CORNERS "# f\n\nf 1 \\\n2 3\nf -5 2 3\n", "x.obj:9: face 2"},
        {CORNERS "f\nf 0 1 2\n", "x.obj:6: face 1"},
        {"v 0 0 0\nv 1 2\nf 1 1 2\n", "x.obj:2: expected a vertex of three numbers, got 'v 1 2'"},
        {CORNERS "f 1 2 3\nv 1 2", "x.obj:6: expected a vertex"},
        {CORNERS "f 1 2 3\nf 2 3", "x.obj:6: the file is cut off in the face 'f 2 3'"},
        {CORNERS "f 1 2 3\nf", "x.obj:6: the file is cut off"},
        {CORNERS "v nan 0 0\nf 1 2 3\nf 1 2 5\n", "x.obj:7: face 2 has a corner at inf 0 0"},
        {CORNERS "f 1 2 3\nf 1//1 2//1 3/", "x.obj:6: the file is cut off in the face"},
        {CORNERS "f 1 2 3\nf 1/1/1 2/1/1 3/1", "x.obj:6: the file is cut off in the face"},
        {CORNERS "f 1 2 3\nf 1/1/1 2/1/1 3/1/", "x.obj:6: the file is cut off in the face"},
        {CORNERS "f 1 2 3\nusemt", "x.obj:6: the file is cut off in 'usemt'"},
        {CORNERS "f 1 2 3\nusemtl lam", "x.obj: the file is cut off: no face follows"},
        {CORNERS "f 1 2 3\nv 1 0 0\nv 2 0 0\nv 1 1 ", "x.obj:8: expected a vertex"},
        {CORNERS "f 1 2 3\nv 1 0 0\nv 2 0 0\nv 1 1 0", "x.obj: the file is cut off: the last"},
        {CORNERS "f 1 2 3\nv 1 0 0 .5 .5", "x.obj:6: expected a vertex of 3 numbers, 4, or 6"},
        {CORNERS "vt\nf 1 2 3\n", "x.obj:5: expected a texture coordinate"},
        {CORNERS "v 1e999 0 0\nf 1 2 5\n", "x.obj:6: face 1 has a corner at inf 0 0"},
        {"\xff\xfev", "x.obj: a text in UTF-16"},
        {CORNERS "f 1 2 3\ncall b.obj\n", "x.obj:6: what is in the file b.obj is not read"},
        {"mtllib two.mtl\n" CORNERS "f 1 2 3\n", "two.mtl:2: material 'm': Ke: expected one or"},
        {"mtllib d.mtl\n" CORNERS "f 1 2 3\n", "d.mtl:3: material 'm': d: expected a number"},
        {CORNERS "vt 0 0\nf 1/1 2/1 3/2\n", "x.obj:6: a corner names texture coordinate 2 of 1"},
        {"mtllib broken.mtl\n" CORNERS "usemtl m\nf 1 2 3\n", "texture broken.png: a damaged"}};
    files_write("two.mtl", "newmtl m\nKe 9 9");
    files_write("d.mtl", "newmtl m\n\nd\n");
    files_write("broken.mtl", "newmtl m\nmap_Kd broken.png\n");
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        files_write("x.obj", broken[i][0]);
        refuse("x.obj", true, broken[i][1]);
    }
    test_oddities();
    files_write("flat.obj", CORNERS "f 1 1 2\nf 2 2 2\n");
    refuse("flat.obj", false, ": no triangle with an area among 2");
    files_write("what.txt", "This is not a scene.\n");
    refuse("what.txt", true, "expected OBJ, glTF, GLB, PLY, OFF or STL");
    files_write("what", "# made by hand\n\n" CORNERS "f 1 2 3\n");
    struct scene *s = NULL;
    struct error *err = scene_read(&s, files_path("what"), NULL, false, &warnings);
    ok(!err && scene_triangle_count(s) == 1, "content tells the format where the name does not");
    error_destroy(err);
    scene_destroy(s);
    files_write("LOUD.OBJ", CORNERS "f 1 2 3\n");
    err = scene_read(&s, files_path("LOUD.OBJ"), NULL, false, &warnings);
    ok(!err && scene_triangle_count(s) == 1, "endings in any case of letters");
    error_destroy(err);
    scene_destroy(s);
}

/* 60 bytes a face, 200000 faces: parsing is linear, or this would take minutes. */
static void test_large(void)
{
    enum { SIDE = 300 };
    FILE *file = fopen(files_path("large.obj"), "w");
    if (!file)
        bail("large.obj");
    for (int i = 0; i <= SIDE; i++)
        for (int j = 0; j <= SIDE; j++)
            fprintf(file, "v %.6f %.6f %.6f\nvt %.6f %.6f\n", i / 300.0, j / 300.0, 0.0, i / 300.0,
                    j / 300.0);
    for (int i = 0; i < SIDE; i++)
        for (int j = 0; j < SIDE; j++) {
            const int a = i * (SIDE + 1) + j + 1, b = a + SIDE + 1;
            fprintf(file, "f %d/%d/1 %d/%d/1 %d/%d/1 %d/%d/1\n", a, a, b, b, b + 1, b + 1, a + 1,
                    a + 1);
        }
    fclose(file);
    struct scene *s = NULL;
    struct error *err = scene_read(&s, files_path("large.obj"), NULL, false, &warnings);
    ok(!err && scene_triangle_count(s) == 2 * SIDE * SIDE && fabs(area(s) - 1) < 1e-6,
       "%d triangles", 2 * SIDE * SIDE);
    error_destroy(err);
    scene_destroy(s);
}

int main(void)
{
    files_begin();
    write_pictures();
    test_geometry();
    test_numbers();
    test_albedo();
    test_colours();
    test_maps();
    test_alpha();
    test_emission();
    test_libraries();
    test_files();
    test_large();
    warnings_clear(&warnings);
    files_end();
    return tap_done();
}
