/* SPDX-License-Identifier: Apache-2.0 */
/* glTF and GLB: what the specification says of containers, accessors, primitives, nodes, materials,
 * textures and lights holds of the scene; what cannot be honoured is refused by name; hostile
 * numbers harm nothing.
 *
 * Files are put together here: JSON is written with ' for ", and the binary buffer is cut into
 * views, one for each call of view().
 */
#include "base/error.h"
#include "base/warning.h"
#include "image/image.h"
#include "import/import_scene.h"
#include "math/affine.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "scene/scene_shade.h"
#include "support/files.h"
#include "support/tap.h"
#include "topology/solids.h"

#include <stb_image_write.h>
#include <stdint.h>
#include <string.h>
#include <webp/encode.h>

/* -- putting files together ------------------------------------------------------------------- */

struct bytes {
    uint8_t data[1 << 16];
    size_t size;
};

static struct bytes buffer; /* the scene's binary buffer */
static char views[1 << 14]; /* its views, as JSON */
static int view_count;
static char *text; /* the JSON that was written last */
static struct warnings warnings;
static bool lenient; /* as --lenient */

static void put(struct bytes *to, const void *data, size_t size)
{
    if (to->size + size > sizeof to->data)
        bail("a file too long for its test");
    memcpy(to->data + to->size, data, size);
    to->size += size;
}

static void begin(void)
{
    buffer.size = 0;
    views[0] = 0;
    view_count = 0;
}

/* Appends bytes to the buffer, aligned to 4, as a view with this stride (0: none stated); gives the
 * view's number. */
static int view(const void *data, size_t size, unsigned stride)
{
    char *end = views + strlen(views), stated[32] = "";
    if (stride)
        snprintf(stated, sizeof stated, ",'byteStride':%u", stride);
    snprintf(end, sizeof views - strlen(views),
             "%s{'buffer':0,'byteOffset':%zu,'byteLength':%zu%s}", view_count ? "," : "",
             buffer.size, size, stated);
    put(&buffer, data, size);
    put(&buffer, "\0\0\0", (4 - size % 4) % 4);
    return view_count++;
}

static void require(bool done)
{
    if (!done)
        bail("no memory for a test's file");
}

/* Writes JSON with " for '. */
static void quote(char *json)
{
    for (char *c = json; (c = strchr(c, '\'')); c++)
        *c = '"';
}

/* Makes `text` of the buffer and its views, and what the test has to say. `uri`: of the buffer, or
 * NULL. */
static void compose(const char *uri, const char *format, va_list args)
{
    char *rest = NULL, *head = NULL;
    require(vasprintf(&rest, format, args) >= 0);
    if (buffer.size)
        require(asprintf(&head, "'buffers':[{'byteLength':%zu%s%s%s}],'bufferViews':[%s],",
                         buffer.size, uri ? ",'uri':'" : "", uri ? uri : "", uri ? "'" : "",
                         views) >= 0);
    free(text);
    require(asprintf(&text, "{'asset':{'version':'2.0'},%s%s}", head ? head : "", rest) >= 0);
    quote(text);
    free(head);
    free(rest);
}

static struct error *read_file(const char *name, struct scene **scene)
{
    struct scene_settings settings = scene_settings_default();
    settings.lenient = lenient;
    warnings_clear(&warnings);
    return scene_read(scene, files_path(name), &settings, true, &warnings);
}

/* Reads the scene that the JSON describes; its buffer lies in x.bin. */
static __attribute__((format(printf, 1, 2))) struct scene *read_scene(const char *format, ...)
{
    struct scene *scene = NULL;
    va_list args;
    va_start(args, format);
    compose("x.bin", format, args);
    va_end(args);
    files_write_bytes("x.bin", buffer.data, buffer.size);
    files_write("x.gltf", text);
    struct error *err = read_file("x.gltf", &scene);
    if (err)
        bail("%s\n# %.2000s", error_message(err), text);
    return scene;
}

/* A damaged scene: expects an error that holds `part`. */
static void expect_error(const char *what, const char *name, const char *part)
{
    struct scene *scene = NULL;
    struct error *err = read_file(name, &scene);
    ok(err && !scene && strstr(error_message(err), part) && strstr(error_message(err), name),
       "%s: %s", what, err ? strrchr(error_message(err), '/') + 1 : "(accepted)");
    error_destroy(err);
    scene_destroy(scene);
}

static __attribute__((format(printf, 3, 4))) void refuse(const char *what, const char *part,
                                                         const char *format, ...)
{
    va_list args;
    va_start(args, format);
    compose("x.bin", format, args);
    va_end(args);
    files_write_bytes("x.bin", buffer.data, buffer.size);
    files_write("x.gltf", text);
    expect_error(what, "x.gltf", part);
}

static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* A triangle (0 0 0), (1 0 0), (0 1 0) in view 0, which is accessor 0. */
static void begin_triangle(void)
{
    begin();
    view(corners, sizeof corners, 0);
}

#define ACCESSOR "{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}"
#define ACCESSORS "'accessors':[" ACCESSOR "]"
#define MESHES "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"
#define PLAIN ACCESSORS "," MESHES ",'nodes':[{'mesh':0}]"

/* -- what was read ---------------------------------------------------------------------------- */

/* Vertex `corner` of triangle `t` of an instance, in the scene. */
static struct vec3 placed(const struct scene *s, size_t instance, size_t t, size_t corner)
{
    const struct scene_mesh *mesh = &s->meshes[s->instances[instance].mesh];
    return affine_point(s->instances[instance].transform,
                        mesh->position + 3 * (size_t)mesh->index[3 * t + corner]);
}

static bool is_at(struct vec3 p, double x, double y, double z)
{
    return fabs(p.x - x) + fabs(p.y - y) + fabs(p.z - z) < 1e-6;
}

static bool is_colour(struct vec3f c, float x, float y, float z)
{
    return fabsf(c.x - x) + fabsf(c.y - y) + fabsf(c.z - z) < 1e-6f;
}

/* Twice the area of all triangles, as a vector along their normals: its length tells a wrong
 * corner, its direction a wrong winding. */
static struct vec3 area(const struct scene *s)
{
    struct vec3 sum = {0, 0, 0};
    for (size_t i = 0; i < s->instance_count; i++)
        for (size_t t = 0; t < s->meshes[s->instances[i].mesh].triangle_count; t++) {
            const struct vec3 a = placed(s, i, t, 0);
            sum = vec3_add(
                sum, vec3_cross(vec3_sub(placed(s, i, t, 1), a), vec3_sub(placed(s, i, t, 2), a)));
        }
    return sum;
}

/* -- accessors and primitives ----------------------------------------------------------------- */

/* Positions (0 0 0), (most 0 0), (0 most 0) of any component type, as they are and normalized. */
static void expect_components(const char *name, int type, const void *data, size_t size,
                              unsigned stride, double most)
{
    for (int normalized = 0; normalized < (most > 1 ? 2 : 1); normalized++) {
        begin();
        view(data, size, stride);
        struct scene *s = read_scene("'extensionsRequired':['KHR_mesh_quantization'],'accessors':[{"
                                     "'bufferView':0,'componentType':%d,'count':3,"
                                     "'type':'VEC3','normalized':%s}]," MESHES
                                     ",'nodes':[{'mesh':0}]",
                                     type, normalized ? "true" : "false");
        const double edge = normalized ? 1 : most;
        ok(is_at(area(s), 0, 0, edge * edge), "positions of %s%s", name,
           normalized ? ", normalized" : "");
        scene_destroy(s);
    }
}

static void test_components(void)
{
    const int8_t bytes[12] = {0, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0, 0};
    const uint8_t unsigned_bytes[12] = {0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0};
    const int16_t shorts[12] = {0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0};
    const uint16_t unsigned_shorts[12] = {0, 0, 0, 0, 65535, 0, 0, 0, 0, 65535, 0, 0};
    expect_components("bytes", 5120, bytes, sizeof bytes - 1, 4, 127);
    expect_components("unsigned bytes", 5121, unsigned_bytes, sizeof unsigned_bytes - 1, 4, 255);
    expect_components("shorts", 5122, shorts, sizeof shorts - 2, 8, 32767);
    expect_components("unsigned shorts", 5123, unsigned_shorts, sizeof unsigned_shorts - 2, 8,
                      65535);
    expect_components("floats", 5126, corners, sizeof corners, 0, 1);

    const uint8_t index8[3] = {2, 0, 1};
    const uint16_t index16[3] = {2, 0, 1};
    const uint32_t index32[3] = {2, 0, 1};
    const void *const index[3] = {index8, index16, index32};
    for (int k = 0; k < 3; k++) {
        const int type = k == 0 ? 5121 : k == 1 ? 5123 : 5125;
        begin_triangle();
        view(index[k], (size_t)3 << k, 0);
        struct scene *s =
            read_scene("'accessors':[" ACCESSOR ",{'bufferView':1,'componentType':%d,'count':3,"
                       "'type':'SCALAR'}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},"
                       "'indices':1}]}],'nodes':[{'mesh':0}]",
                       type);
        ok(is_at(placed(s, 0, 0, 0), 0, 1, 0) && is_at(area(s), 0, 0, 1), "indices of %d bytes",
           1 << k);
        scene_destroy(s);
    }
}

static void test_layout(void)
{
    /* Two accessors share a view with a stride: positions, and 4 bytes behind each that are
     * none. */
    const float woven[12] = {0, 0, 0, 99, 1, 0, 0, 99, 0, 1, 0, 99};
    begin();
    view(corners, 12, 0);
    view(woven, sizeof woven - 4, 16);
    struct scene *s = read_scene(
        "'accessors':[{'bufferView':1,'componentType':5126,'count':3,'type':'VEC3'}]," MESHES
        ",'nodes':[{'mesh':0}]");
    ok(is_at(area(s), 0, 0, 1), "a byte stride, up to the view's last byte");
    scene_destroy(s);
    begin();
    view(woven, sizeof woven - 5, 16);
    refuse("a view one byte too short", "do not fit", PLAIN);

    /* Offsets of accessor and view add up. */
    const float behind[11] = {7, 7, 0, 0, 0, 2, 0, 0, 0, 2, 0};
    begin();
    view(behind, sizeof behind, 0);
    s = read_scene("'accessors':[{'bufferView':0,'byteOffset':8,'componentType':5126,'count':3,'"
                   "type':'VEC3'}]," MESHES ",'nodes':[{'mesh':0}]");
    ok(is_at(area(s), 0, 0, 4), "a byte offset");
    scene_destroy(s);

    /* Sparse: replaces elements of what is there, or of zeros. */
    const uint16_t element[2] = {1, 2};
    const float value[6] = {3, 0, 0, 0, 3, 0};
    for (int base = 0; base < 2; base++) {
        begin_triangle();
        const int index_view = view(element, sizeof element, 0),
                  value_view = view(value, sizeof value, 0);
        s = read_scene(
            "'accessors':[{%s'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':2,'"
            "indices':"
            "{'bufferView':%d,'componentType':5123},'values':{'bufferView':%d}}}]," MESHES
            ",'nodes':[{'mesh':0}]",
            base ? "'bufferView':0," : "", index_view, value_view);
        ok(is_at(area(s), 0, 0, 9), "a sparse accessor %s", base ? "on data" : "on zeros");
        scene_destroy(s);
    }
    begin_triangle();
    view((const uint16_t[]){1, 3}, 4, 0);
    view(value, sizeof value, 0);
    refuse("a sparse index out of range", "sparse index 3",
           "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3','sparse':{'"
           "count':2,'indices':"
           "{'bufferView':1,'componentType':5123},'values':{'bufferView':2}}}]," MESHES
           ",'nodes':[{'mesh':0}]");
}

static void test_modes(void)
{
    /* A strip, a fan and a list of the same square, wound alike; one vertex too many for whole
     * triangles, which is told. */
    static const struct {
        int mode;
        const char *name;
        float p[21];
        size_t vertices, triangles;
    } modes[] = {
        {5, "a strip", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, 4, 2},
        {6, "a fan", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 4, 2},
        {4, "a list", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 9, 9, 9}, 7, 2},
        {0, "points", {0, 0, 0, 1, 0, 0, 0, 1, 0}, 3, 0},
        {1, "lines", {0, 0, 0, 1, 0, 0, 0, 1, 0}, 3, 0},
    };
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
        begin();
        view(modes[i].p, modes[i].vertices * 12, 0);
        struct scene *s = read_scene(
            "'accessors':[{'bufferView':0,'componentType':5126,'count':%zu,'type':'VEC3'}],"
            "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':%d}]}],"
            "'nodes':[{'mesh':0}]",
            modes[i].vertices, modes[i].mode);
        ok(scene_triangle_count(s) == modes[i].triangles &&
               is_at(area(s), 0, 0, (double)modes[i].triangles) &&
               (warnings_of_kind(&warnings, "points and lines") > 0) == (modes[i].triangles == 0) &&
               warnings_of_kind(&warnings, "part of a triangle") == (modes[i].mode == 4),
           "%s: %zu triangles, the front in front", modes[i].name, scene_triangle_count(s));
        scene_destroy(s);
    }
}

static void test_shared_vertices(void)
{
    /* Primitives that share one list of vertices take from it what they use. */
    const float p[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0};
    const uint16_t index[6] = {0, 1, 2, 5, 3, 4};
    begin();
    view(p, sizeof p, 0);
    view(index, sizeof index, 0);
    struct scene *s = read_scene("'accessors':[{'bufferView':0,'componentType':5126,'count':6,'"
                                 "type':'VEC3'},{'bufferView':1,"
                                 "'componentType':5123,'count':3,'type':'SCALAR'},{'bufferView':1,'"
                                 "byteOffset':6,'componentType':5123,'count':3,"
                                 "'type':'SCALAR'}],'meshes':[{'primitives':[{'attributes':{'"
                                 "POSITION':0},'indices':1},{'attributes':"
                                 "{'POSITION':0},'indices':2}]}],'nodes':[{'mesh':0}]");
    ok(s->mesh_count == 1 && s->meshes[0].vertex_count == 6 && is_at(placed(s, 0, 1, 0), 5, 1, 0) &&
           is_at(placed(s, 0, 1, 1), 5, 0, 0),
       "primitives of one mesh share a list of vertices");
    scene_destroy(s);

    const uint16_t wrong[6] = {0, 1, 6, 65535, 3, 4};
    begin();
    view(p, sizeof p, 0);
    view(wrong, sizeof wrong, 0);
    view(index, sizeof index, 0);
    lenient = true;
    s = read_scene("'accessors':[{'bufferView':0,'componentType':5126,'count':6,'type':'VEC3'},{'"
                   "bufferView':1,"
                   "'componentType':5123,'count':6,'type':'SCALAR'},{'bufferView':2,'componentType'"
                   ":5123,'count':6,"
                   "'type':'SCALAR'}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'"
                   "indices':1},{'attributes':"
                   "{'POSITION':0},'indices':2}]}],'nodes':[{'mesh':0}]");
    lenient = false;
    ok(scene_triangle_count(s) == 2 && warnings_of_kind(&warnings, "index out of range") == 2,
       "triangles with a corner that is no vertex are left out, with a warning");
    scene_destroy(s);
    expect_error("without --lenient", "x.gltf", "is not among its primitive's vertices");
}

/* -- nodes ------------------------------------------------------------------------------------ */

static void test_nodes(void)
{
    begin_triangle();
    struct scene *s = read_scene(
        ACCESSORS
        "," MESHES ",'scene':0,'scenes':[{'nodes':[0]}],'nodes':["
        "{'children':[1,2],'translation':[10,0,0]},"
        "{'mesh':0,'rotation':[0,0,0.7071067811865476,0.7071067811865476],'scale':[2,3,4]},"
        "{'mesh':0,'matrix':[0,0,2,0, 0,1,0,0, 3,0,0,0, 5,6,7,1]},{'mesh':0}]");
    ok(s->instance_count == 2 && s->mesh_count == 1,
       "a mesh placed twice stays one; nodes outside the scene are not there");
    ok(is_at(placed(s, 0, 0, 1), 10, 2, 0) && is_at(placed(s, 0, 0, 2), 7, 0, 0),
       "translation times rotation times scale, below the parent's");
    ok(is_at(placed(s, 1, 0, 0), 15, 6, 7) && is_at(placed(s, 1, 0, 1), 15, 6, 9),
       "a matrix is column-major");
    scene_destroy(s);

    static const struct {
        const char *name, *json;
        double x;
    } scenes[] = {
        {"the default scene", "'scene':1,'scenes':[{'nodes':[0]},{'nodes':[1]}]", 1},
        {"without a default, the first", "'scenes':[{'nodes':[2]},{'nodes':[1]}]", 2},
        {"without scenes, every root", "'cameras':[]", 0},
    };
    for (size_t i = 0; i < 3; i++) {
        s = read_scene(ACCESSORS "," MESHES ",'nodes':[{'mesh':0},{'mesh':0,'translation':[1,0,0]},"
                                 "{'mesh':0,'translation':[2,0,0]}],%s",
                       scenes[i].json);
        ok(s->instance_count == (i < 2 ? 1 : 3) && is_at(placed(s, 0, 0, 0), scenes[i].x, 0, 0),
           "%s", scenes[i].name);
        scene_destroy(s);
    }

    s = read_scene(
        ACCESSORS
        "," MESHES ",'extensionsRequired':['KHR_node_visibility'],'nodes':["
        "{'children':[1],'extensions':{'KHR_node_visibility':{'visible':false}}},{'mesh':0},"
        "{'mesh':0,'translation':[7,0,0],'extensions':{'KHR_node_visibility':{'visible':true}}}]");
    ok(s->instance_count == 1 && is_at(placed(s, 0, 0, 0), 7, 0, 0),
       "what hangs below an invisible node is not there");
    scene_destroy(s);
}

/* A closed tetrahedron keeps its inside whichever way it is mirrored: glTF 2.0, 3.7.4. */
static void test_mirrors(void)
{
    const float p[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const uint8_t index[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const char *const scales[] = {"[1,1,1]", "[-1,1,1]", "[-1,-2,-3]", "[-1,-1,1]"};
    for (size_t i = 0; i < 4; i++) {
        begin();
        view(p, sizeof p, 0);
        view(index, sizeof index, 0);
        struct scene *s = read_scene("'accessors':[{'bufferView':0,'componentType':5126,'count':4,'"
                                     "type':'VEC3'},{'bufferView':1,"
                                     "'componentType':5121,'count':12,'type':'SCALAR'}],'meshes':[{"
                                     "'primitives':[{'attributes':{'POSITION':0},"
                                     "'indices':1}]}],'nodes':[{'mesh':0,'scale':%s}]",
                                     scales[i]);
        struct scene_solids solids;
        struct error *err = scene_solids(s, &solids, &warnings);
        ok(!err && solids.closed_count == 1 && solids.volume[0] > 0,
           "scaled by %s, the inside stays inside", scales[i]);
        error_destroy(err);
        scene_solids_clear(&solids);
        scene_destroy(s);
    }
}

static void test_instancing(void)
{
    const float t[9] = {1, 0, 0, 2, 0, 0, 3, 0, 0}, scale[9] = {1, 1, 1, 2, 2, 2, 1, 1, 1};
    /* the last: half a turn about z */
    const int16_t q[12] = {0, 0, 0, 32767, 0, 0, 0, 32767, 0, 0, 32767, 0};
    begin_triangle();
    view(t, sizeof t, 0);
    view(q, sizeof q, 0);
    view(scale, sizeof scale, 0);
    const char *const head =
        "'extensionsRequired':['EXT_mesh_gpu_instancing'],'accessors':[" ACCESSOR
        ",{'bufferView':1,"
        "'componentType':5126,'count':3,'type':'VEC3'},{'bufferView':2,'componentType':5122,'"
        "normalized':true,"
        "'count':3,'type':'VEC4'},{'bufferView':3,'componentType':5126,'count':%d,'type':'VEC3'}]"
        "," MESHES ",'nodes':[{'mesh':0,'translation':[0,0,9],'extensions':{'EXT_mesh_gpu_"
        "instancing':{'attributes':"
        "{'TRANSLATION':1,'ROTATION':2,'SCALE':3,'_ID':0,'_COLOR_0':0}}}}]";
    char json[1024];
    snprintf(json, sizeof json, head, 3);
    struct scene *s = read_scene("%s", json);
    ok(s->instance_count == 3 && s->mesh_count == 1 && is_at(placed(s, 0, 0, 1), 2, 0, 9) &&
           is_at(placed(s, 1, 0, 1), 4, 0, 9) && is_at(placed(s, 2, 0, 1), 2, 0, 9),
       "EXT_mesh_gpu_instancing: one mesh, three places within the node's");
    ok(warnings_of_kind(&warnings, "colours of instances") == 1, "their colours are missed");
    scene_destroy(s);
    snprintf(json, sizeof json, head, 2);
    refuse("instances whose attributes differ in number", "differ in number", "%s", json);
}

/* -- materials and textures ------------------------------------------------------------------- */

static void append(void *context, void *data, int size)
{
    put(context, data, (size_t)size);
}

/* Red, green; blue, white at half the alpha: top row first. */
static const uint8_t texels[16] = {255, 0, 0,   255, 0,   255, 0,   255,
                                   0,   0, 255, 255, 255, 255, 255, 128};

static struct bytes png(void)
{
    struct bytes out = {.size = 0};
    stbi_write_png_to_func(append, &out, 2, 2, 4, texels, 8);
    return out;
}

/* A triangle whose corners look at the middle of the red, the green and the blue texel: first set
 * of coordinates; at the green, the blue and the red: second set. Texture 0 is x.png. */
static void begin_textured(void)
{
    const float first[6] = {0.25f, 0.25f, 0.75f, 0.25f, 0.25f, 0.75f};
    const float second[6] = {0.75f, 0.25f, 0.25f, 0.75f, 0.25f, 0.25f};
    const struct bytes picture = png();
    files_write_bytes("x.png", picture.data, picture.size);
    begin_triangle();
    view(first, sizeof first, 0);
    view(second, sizeof second, 0);
}

#define TEXTURED                                                                                   \
    "'accessors':[" ACCESSOR                                                                       \
    ",{'bufferView':1,'componentType':5126,'count':3,'type':'VEC2'},{'bufferView':2,"              \
    "'componentType':5126,'count':3,'type':'VEC2'}],'meshes':[{'primitives':[{'attributes':{'"     \
    "POSITION':0,"                                                                                 \
    "'TEXCOORD_0':1,'TEXCOORD_1':2},'material':0}]}],'nodes':[{'mesh':0}]"
#define TEXTURE "'textures':[{'source':0}],'images':[{'uri':'x.png'}]"
#define SAMPLED "'textures':[{'source':0,'sampler':0}],'images':[{'uri':'x.png'}]"

static struct vec3f albedo_at(const struct scene *s, size_t corner)
{
    const float *const uv = s->meshes[0].uv;
    return scene_albedo(s, &s->materials[s->meshes[0].material[0]], uv ? uv[2 * corner] : 0,
                        uv ? uv[2 * corner + 1] : 0);
}

/* Whether the corners show three texels: 'r', 'g', 'b'. */
static bool shows(const struct scene *s, const char *colours)
{
    bool right = s->texture_count == 1;
    for (size_t k = 0; k < 3 && right; k++)
        right = is_colour(albedo_at(s, k), colours[k] == 'r', colours[k] == 'g', colours[k] == 'b');
    return right;
}

/* The same of what the first mesh emits. */
static bool glows(const struct scene *s, const char *colours)
{
    const struct scene_mesh *mesh = &s->meshes[0];
    bool right = mesh->emission_uv != NULL;
    for (size_t k = 0; k < 3 && right; k++)
        right = is_colour(scene_emission(s, &s->materials[mesh->material[0]],
                                         mesh->emission_uv[2 * k], mesh->emission_uv[2 * k + 1]),
                          colours[k] == 'r', colours[k] == 'g', colours[k] == 'b');
    return right;
}

static void test_factors(void)
{
    begin_triangle();
    struct scene *s = read_scene(PLAIN);
    ok(is_colour(albedo_at(s, 0), 1, 1, 1) && !s->meshes[0].uv && warnings.count == 0,
       "no material: white");
    scene_destroy(s);

    const char *const one = "'materials':[{%s}],'accessors':[" ACCESSOR
                            "],'meshes':[{'primitives':[{'attributes':"
                            "{'POSITION':0},'material':0}]}],'nodes':[{'mesh':0}]";
    char json[1024];
    snprintf(json, sizeof json, one,
             "'name':'a','doubleSided':true,'emissiveFactor':[1,0.5,0],'extensions':"
             "{'KHR_materials_emissive_strength':{'emissiveStrength':8}},"
             "'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.25,1,0.4],'metallicFactor':1}");
    s = read_scene("%s", json);
    ok(is_colour(albedo_at(s, 0), 0.5f, 0.25f, 1) && is_colour(s->materials[0].emission, 8, 4, 0) &&
           !strcmp(s->materials[0].name, "a"),
       "factors are linear; emissive strength multiplies; metalness is left alone");
    ok(scene_transparency(s, &s->materials[0], 0, 0) == 0 && warnings.count == 1 &&
           warnings_of_kind(&warnings, "opaque by its mode") == 1,
       "alpha counts for nothing unless asked for, and that is said");
    scene_destroy(s);

    snprintf(json, sizeof json, one,
             "'pbrMetallicRoughness':{'baseColorFactor':[0.1,0.1,0.1,1]},'extensions':"
             "{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':[0.5,0.25,0.75,1]},"
             "'KHR_materials_unlit':{},'KHR_materials_transmission':{'transmissionFactor':0.5}}");
    s = read_scene("%s", json);
    ok(is_colour(albedo_at(s, 0), 0.5f / 1.5f, 0.25f / 1.5f, 0.75f / 1.5f),
       "the diffuse factor of KHR_materials_pbrSpecularGlossiness, less what passes");
    ok(warnings_of_kind(&warnings, "unlit") == 1 &&
           warnings_of_kind(&warnings, "transmission") == 1,
       "unlit materials and coloured glass are warned about");
    scene_destroy(s);

    static const struct {
        const char *alpha, *factor;
        float base[2], through, albedo; /* base: colour and alpha */
    } panes[] = {{"OPAQUE", "1", {1, 1}, 1, -1},
                 {"OPAQUE", "0.5", {1, 1}, 0.5f, 1},
                 {"OPAQUE", "0.5", {0.5f, 0.3f}, 0.25f, 0.5f * 0.5f / 0.75f},
                 {"BLEND", "0.5", {1, 0.5f}, 0.75f, 1},
                 {"OPAQUE", "0", {1, 1}, 0, 1}};
    for (size_t i = 0; i < sizeof panes / sizeof *panes; i++) {
        const double c = (double)panes[i].base[0];
        s = read_scene(ACCESSORS
                       ",'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],"
                       "'nodes':[{'mesh':0}],'extensionsUsed':['KHR_materials_transmission'],"
                       "'materials':[{'alphaMode':'%s','pbrMetallicRoughness':{'baseColorFactor':"
                       "[%g,%g,%g,%g]},'extensions':{'KHR_materials_transmission':"
                       "{'transmissionFactor':%s}}}]",
                       panes[i].alpha, c, c, c, (double)panes[i].base[1], panes[i].factor);
        ok(fabsf(scene_transparency(s, &s->materials[0], 0, 0) - panes[i].through) < 1e-6f &&
               (panes[i].albedo < 0 || fabsf(albedo_at(s, 0).x - panes[i].albedo) < 1e-6f) &&
               warnings.count == 0,
           "a pane, %s, that transmits %s of %g lets %g through", panes[i].alpha, panes[i].factor,
           c, (double)panes[i].through);
        scene_destroy(s);
    }
    s = read_scene(ACCESSORS
                   ",'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],"
                   "'nodes':[{'mesh':0}],'materials':[{'name':'glass','alphaMode':'BLEND',"
                   "'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.12]},'extensions':"
                   "{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':[1,1,1,1]}}}]");
    ok(warnings_of_kind(&warnings, "two opacities") == 1,
       "opacities of two models that contradict each other are warned about");
    scene_destroy(s);

    static const struct {
        const char *material, *kind;
    } odd[] = {
        {"'alphaMode':'MASK','alphaCutoff':1.5", "nothing to be seen"},
        {"'alphaMode':'MASK','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.4]}",
         "nothing to be seen"},
        {"'alphaMode':'BLEND','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0]}",
         "nothing to be seen"},
        {"'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.12]}", "opaque by its mode"},
        {"'pbrMetallicRoughness':{'baseColorFactor':[1,0.8,0,1]},'extensions':"
         "{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':[0,0,0,1]}}",
         "two colours"},
        {"'extensions':{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':[0,0,0,1]}}", NULL},
        {"'alphaMode':'MASK','alphaCutoff':1", NULL},
        {"'alphaMode':'BLEND','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.01]}", NULL}};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        snprintf(json, sizeof json, one, odd[i].material);
        s = read_scene("%s", json);
        ok(warnings.count == (odd[i].kind != NULL) &&
               (!odd[i].kind || warnings_of_kind(&warnings, odd[i].kind) == 1),
           "%s: %s", odd[i].material, odd[i].kind ? odd[i].kind : "nothing is odd");
        scene_destroy(s);
    }

    snprintf(json, sizeof json, one,
             "'alphaMode':'MASK','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.4]}");
    s = read_scene("%s", json);
    ok(scene_transparency(s, &s->materials[0], 0, 0) == 1,
       "MASK: below the cut-off, which is 0.5 by itself, a hole");
    scene_destroy(s);
    snprintf(json, sizeof json, one,
             "'alphaMode':'BLEND','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.4]}");
    s = read_scene("%s", json);
    ok(fabsf(scene_transparency(s, &s->materials[0], 0, 0) - 0.6f) < 1e-6f,
       "BLEND: lets light pass in proportion");
    scene_destroy(s);
}

/* A triangle whose vertices have these colours; `material` follows. Gives its scene. */
static struct scene *read_colours(const void *colours, size_t size, unsigned stride,
                                  const char *type, const char *material)
{
    begin_triangle();
    view(colours, size, stride);
    return read_scene("'accessors':[" ACCESSOR ",{'bufferView':1,'count':3,%s}],'meshes':"
                      "[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':1},'material':0},"
                      "{'attributes':{'POSITION':0}}]}],'nodes':[{'mesh':0}],'materials':[{%s}]",
                      type, material);
}

/* Whether vertex v of the first mesh has a colour, to the rounding of its 16 bits. */
static bool has_colour(const struct scene *s, size_t v, double r, double g, double b, double a)
{
    const double wanted[4] = {r, g, b, a};
    bool right = s->meshes[0].colour != NULL && v < s->meshes[0].vertex_count;
    for (size_t k = 0; k < 4 && right; k++)
        right = fabs(s->meshes[0].colour[4 * v + k] / 65535.0 - wanted[k]) <= 0.51 / 65535;
    return right;
}

static void test_colours(void)
{
    static const float rgb[9] = {0.5f, 0.25f, 0, 1, 2, -1, 0.125f, 0, 1},
                       rgba[12] = {0.5f, 0.25f, 0, 0.75f, 1, 2, -1, 1, 0.125f, 0, 1, 0};
    static const uint8_t bytes[12] = {51, 102, 0, 153, 255, 255, 0, 255, 0, 0, 255, 0},
                         three[12] = {51, 102, 0, 9, 255, 255, 0, 9, 0, 0, 255, 9},
                         none[12] = {255, 255, 255, 0, 255, 255, 255, 9, 255, 255, 255, 99};
    static const uint16_t shorts[12] = {13107, 26214, 0, 39321, 65535, 65535,
                                        0,     65535, 0, 0,     65535, 0};
#define FLOATS "'componentType':5126,'type':"
#define BYTES "'componentType':5121,'normalized':true,'type':"
#define SHORTS "'componentType':5123,'normalized':true,'type':"
    struct scene *s = read_colours(rgb, sizeof rgb, 0, FLOATS "'VEC3'", "");
    ok(has_colour(s, 0, 0.5, 0.25, 0, 1) && has_colour(s, 1, 1, 1, 0, 1) && warnings.count == 0,
       "COLOR_0 in floats: linear, and from 0 to 1");
    ok(has_colour(s, 3, 1, 1, 1, 1) && s->meshes[0].vertex_count == 6,
       "a primitive without colours beside it is white");
    scene_destroy(s);
    s = read_colours(rgba, sizeof rgba, 0, FLOATS "'VEC4'", "'alphaMode':'BLEND'");
    ok(has_colour(s, 0, 0.5, 0.25, 0, 0.75) && has_colour(s, 2, 0.125, 0, 1, 0),
       "with the alpha of a blended material");
    scene_destroy(s);
    s = read_colours(bytes, sizeof bytes, 0, BYTES "'VEC4'", "'alphaMode':'MASK'");
    ok(has_colour(s, 0, 0.2, 0.4, 0, 0.6) && has_colour(s, 1, 1, 1, 0, 1), "in bytes");
    scene_destroy(s);
    s = read_colours(three, sizeof three, 4, BYTES "'VEC3'", "'alphaMode':'MASK'");
    ok(has_colour(s, 0, 0.2, 0.4, 0, 1) && has_colour(s, 2, 0, 0, 1, 1), "in three of four bytes");
    scene_destroy(s);
    s = read_colours(shorts, sizeof shorts, 0, SHORTS "'VEC4'", "'alphaMode':'MASK'");
    ok(has_colour(s, 0, 0.2, 0.4, 0, 0.6) && has_colour(s, 2, 0, 0, 1, 0), "in 16 bits");
    scene_destroy(s);
    s = read_colours(bytes, sizeof bytes, 0, "'componentType':5121,'type':'VEC4'", "");
    ok(has_colour(s, 0, 0.2, 0.4, 0, 1) && warnings_of_kind(&warnings, "colours not normalized"),
       "whole numbers that are not said to be normalized: as if they were, with a warning");
    scene_destroy(s);
    s = read_colours(none, sizeof none, 0, BYTES "'VEC4'", "");
    ok(!s->meshes[0].colour, "white is kept by none, nor an alpha that an opaque material has not");
    scene_destroy(s);
    begin_triangle();
    view(rgb, 24, 0);
    refuse("fewer colours than vertices", "2 colours for 3 vertices",
           "'accessors':[" ACCESSOR ",{'bufferView':1,'count':2," FLOATS "'VEC3'}],'meshes':"
           "[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':1}}]}],'nodes':[{'mesh':0}]");
}

static void test_textures(void)
{
    begin_textured();
    struct scene *s = read_scene(
        TEXTURED "," TEXTURE
                 ",'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}}]");
    ok(shows(s, "rgb"), "a texture, its (0, 0) at the top left");
    scene_destroy(s);
    s = read_scene(
        TEXTURED
        "," TEXTURE
        ",'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1}}}]");
    ok(shows(s, "gbr"), "the second set of texture coordinates");
    scene_destroy(s);
    s = read_scene(
        TEXTURED
        "," TEXTURE
        ",'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':"
        "{'KHR_texture_transform':{'texCoord':1}}}}}]");
    ok(shows(s, "gbr"), "KHR_texture_transform names the set");
    scene_destroy(s);
    s = read_scene(TEXTURED "," TEXTURE
                            ",'materials':[{'extensions':{'KHR_materials_pbrSpecularGlossiness':"
                            "{'diffuseTexture':{'index':0,'texCoord':1}}}}]");
    ok(shows(s, "gbr"), "the diffuse texture of KHR_materials_pbrSpecularGlossiness");
    scene_destroy(s);

    s = read_scene(TEXTURED "," TEXTURE
                            ",'materials':[{'emissiveFactor':[2,2,2],'emissiveTexture':{'index':0},"
                            "'alphaMode':'MASK','alphaCutoff':0.6,'pbrMetallicRoughness':{'"
                            "baseColorTexture':{'index':0}}}]");
    ok(is_colour(scene_emission(s, &s->materials[0], 0.25f, 0.25f), 0, 0, 2),
       "an emissive texture times its factor");
    ok(scene_transparency(s, &s->materials[0], 0.75f, 0.25f) == 1 &&
           scene_transparency(s, &s->materials[0], 0.25f, 0.25f) == 0,
       "the alpha of a cut-out's texture, against its cut-off");
    scene_destroy(s);
    s = read_scene(
        TEXTURED
        "," TEXTURE
        ",'materials':[{'emissiveFactor':[1,1,1],'emissiveTexture':{'index':0,'texCoord':1},"
        "'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}}]");
    ok(warnings.count == 0 && shows(s, "rgb") && glows(s, "gbr"),
       "two sets in one material: each picture reads its own");
    scene_destroy(s);
    s = read_scene(TEXTURED "," TEXTURE
                            ",'materials':[{'emissiveFactor':[1,1,1],'emissiveTexture':{'index':0},"
                            "'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':"
                            "{'KHR_texture_transform':{'texCoord':1}}}}}]");
    ok(warnings.count == 0 && shows(s, "gbr") && glows(s, "rgb"),
       "the other way round, by KHR_texture_transform");
    scene_destroy(s);
    s = read_scene(TEXTURED "," TEXTURE
                            ",'materials':[{'emissiveFactor':[1,1,1],'emissiveTexture':{'index':0,"
                            "'texCoord':1},'pbrMetallicRoughness':{'baseColorTexture':{'index':0,"
                            "'texCoord':1}}}]");
    ok(warnings.count == 0 && shows(s, "gbr") && !s->meshes[0].emission_uv,
       "nothing is kept twice where both read the same");
    scene_destroy(s);
    s = read_scene(TEXTURED "," TEXTURE
                            ",'materials':[{'emissiveTexture':{'index':0},'pbrMetallicRoughness':"
                            "{'baseColorFactor':[0,0,0,1],'baseColorTexture':{'index':0}}}]");
    ok(warnings_of_kind(&warnings, "baseColorFactor 0 with a picture") == 1 &&
           warnings_of_kind(&warnings, "emissiveFactor 0 with a picture") == 1,
       "factors of 0 that take pictures away are named");
    scene_destroy(s);
    s = read_scene(TEXTURED "," TEXTURE ",'materials':[{'alphaMode':'MASK','alphaCutoff':0.6,"
                            "'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.5],"
                            "'baseColorTexture':{'index':0}}}]");
    ok(warnings_of_kind(&warnings, "nothing to be seen") == 1,
       "a cut-out whose picture never reaches its cut-off");
    scene_destroy(s);
    s = read_scene(TEXTURED "," TEXTURE ",'materials':[{'pbrMetallicRoughness':"
                            "{'baseColorTexture':{'index':0,'texCoord':2}}}]");
    ok(warnings_of_kind(&warnings, "texture coordinates missing") == 1 && warnings.count == 1,
       "a set that a mesh has not is missed");
    scene_destroy(s);

    const uint8_t grey[3] = {128, 128, 128};
    struct bytes picture = {.size = 0};
    stbi_write_png_to_func(append, &picture, 1, 1, 3, grey, 3);
    files_write_bytes("x.png", picture.data, picture.size);
    s = read_scene(TEXTURED "," TEXTURE
                            ",'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0},"
                            "'baseColorFactor':[0.5,1,1,1]}}]");
    ok(is_colour(albedo_at(s, 0), 0.5f * image_linear[128], image_linear[128], image_linear[128]),
       "codes are sRGB: 128 is %.4f, times the factor", (double)image_linear[128]);
    scene_destroy(s);
}

/* KHR_texture_transform against its formula: translation times rotation (counter-clockwise as seen,
 * v being down) times scale. */
static void test_transforms(void)
{
    static const struct {
        double offset[2], rotation, scale[2];
    } all[] = {{{0, 0}, 0, {1, 1}},
               {{0.25, 0.5}, 0, {1, 1}},
               {{0, 0}, 0.5, {1, 1}},
               {{0, 0}, 0, {2, -3}},
               {{0, 1}, 1.5707963267948966, {0.5, 0.5}},
               {{-3.5, 0.125}, -2.5, {0.3, 7}}};
    double worst = 0;
    begin_textured();
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        struct scene *s = read_scene(
            TEXTURED
            "," TEXTURE
            ",'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':"
            "{'KHR_texture_transform':{'offset':[%.17g,%.17g],'rotation':%.17g,'scale':[%.17g,%."
            "17g]}}}}}]",
            all[i].offset[0], all[i].offset[1], all[i].rotation, all[i].scale[0], all[i].scale[1]);
        const float *const m = s->materials[0].albedo_map.transform;
        const double c = cos(all[i].rotation), sine = sin(all[i].rotation);
        for (int point = 0; point < 4; point++) {
            const double u = point & 1 ? 0.9 : 0.2, v = point & 2 ? -0.4 : 0.7; /* v down */
            const double su = all[i].scale[0] * u, sv = all[i].scale[1] * v;
            const double want_u = c * su + sine * sv + all[i].offset[0],
                         want_v = c * sv - sine * su + all[i].offset[1];
            const double got_u = (double)m[0] * u + (double)m[1] * (1 - v) + (double)m[2];
            const double got_v = 1 - ((double)m[3] * u + (double)m[4] * (1 - v) + (double)m[5]);
            worst = fmax(worst, fmax(fabs(got_u - want_u), fabs(got_v - want_v)));
        }
        scene_destroy(s);
    }
    ok(worst < 1e-5, "KHR_texture_transform is its formula: within %.2g", worst);

    struct scene *s = read_scene(
        TEXTURED "," TEXTURE ",'extensionsRequired':['KHR_texture_transform'],'materials':["
                 "{'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':"
                 "{'KHR_texture_transform':{'offset':[0,1],'rotation':1.5707963267948966,"
                 "'scale':[0.5,0.5]}}}}}]");
    const struct scene_map *const map = &s->materials[0].albedo_map;
    float rgba[4];
    scene_map_sample(s, map, 0.5f, 0.5f, rgba);
    ok(rgba[2] == 1 && rgba[0] == 0, "its example shows the lower left quarter");
    scene_destroy(s);
}

static void test_samplers(void)
{
    static const struct {
        const char *json;
        enum scene_wrap u, v;
        bool nearest;
    } all[] = {{"{}", SCENE_REPEAT, SCENE_REPEAT, false},
               {"{'wrapS':33071,'wrapT':33648,'magFilter':9728}", SCENE_CLAMP, SCENE_MIRROR, true},
               {"{'wrapS':10497,'wrapT':33071,'magFilter':9729,'minFilter':9728}", SCENE_REPEAT,
                SCENE_CLAMP, false}};
    begin_textured();
    for (size_t i = 0; i < 3; i++) {
        struct scene *s =
            read_scene(TEXTURED "," SAMPLED ",'samplers':[%s],'materials':[{'pbrMetallicRoughness':"
                                "{'baseColorTexture':{'index':0}}}]",
                       all[i].json);
        const struct scene_texture *const t = s->textures;
        ok(t->wrap_u == all[i].u && t->wrap_v == all[i].v && t->nearest == all[i].nearest,
           "sampler %s", all[i].json);
        scene_destroy(s);
    }
}

/* The same picture, wherever it lies. */
static void expect_picture(const char *name, const char *images)
{
    struct scene *s = read_scene(
        TEXTURED ",'textures':[{'source':0}],'images':[%s],'materials':[{'pbrMetallicRoughness':"
                 "{'baseColorTexture':{'index':0}}}]",
        images);
    ok(shows(s, "rgb") && warnings.count == 0, "a picture %s", name);
    scene_destroy(s);
}

static void test_pictures(void)
{
    const struct bytes picture = png();
    begin_textured();
    files_make_directory("textures");
    files_write_bytes("textures/a b+c.png", picture.data, picture.size);
    files_write_bytes("50%25.png", picture.data, picture.size);
    expect_picture("beside the file", "{'uri':'x.png'}");
    expect_picture("in a folder, percent-encoded", "{'uri':'textures%2Fa%20b+c.png'}");
    expect_picture("whose name is not encoded though it holds a percent sign",
                   "{'uri':'50%25.png'}");
    expect_picture("at a path with ..", "{'uri':'textures/../x.png'}");
    expect_picture(
        "in a data: URI",
        "{'uri':'data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAIAAAD91JpzAAAAEklEQ"
        "VR4nGP4z8DAAMIM/4EAAB/uBfsL2WiLAAAAAElFTkSuQmCC'}");
    expect_picture("in a data: URI of a type that is none, percent-encoded",
                   "{'uri':'data:;base64,"
                   "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAIAAAD91JpzAAAAEklEQVR4nGP4z8DAAMIM%2F4EAAB%2F"
                   "uBfsL2WiLAAAAAElFTkSuQmCC'}");
    char json[64];
    snprintf(json, sizeof json, "{'bufferView':%d,'mimeType':'image/png'}",
             view(picture.data, picture.size, 0));
    expect_picture("in a buffer view", json);

    uint8_t *webp = NULL;
    const size_t webp_size = WebPEncodeLosslessRGBA(texels, 2, 2, 8, &webp);
    files_write_bytes("x.webp", webp, webp_size);
    WebPFree(webp);
    struct scene *s = read_scene(
        TEXTURED
        ",'extensionsRequired':['EXT_texture_webp'],'textures':[{'source':1,'extensions':"
        "{'EXT_texture_webp':{'source':0}}}],'images':[{'uri':'x.webp'},{'uri':'gone.png'}],"
        "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}}]");
    ok(shows(s, "rgb") && warnings.count == 0, "EXT_texture_webp goes before the fallback");
    scene_destroy(s);
}

/* Pictures that are not there, or of no known format: the factor alone, with a warning. */
static void test_missing_pictures(void)
{
    static const struct {
        const char *name, *json, *kind;
    } all[] = {
        {"a missing file", "'textures':[{'source':0}],'images':[{'uri':'no%2Fsuch.png'}]",
         "texture missing"},
        {"a file elsewhere",
         "'textures':[{'source':0}],'images':[{'uri':'https://x.example/y.png'}]",
         "texture missing"},
        {"what is no picture",
         "'textures':[{'source':0}],'images':[{'uri':'data:image/png;base64,AAAA'}]",
         "texture not understood"},
        {"an empty picture", "'textures':[{'source':0}],'images':[{'uri':'data:,'}]",
         "texture not understood"},
        {"a texture of an unknown kind",
         "'textures':[{'extensions':{'KHR_texture_basisu':{'source':0}}}],'images':"
         "[{'uri':'x.ktx2'}]",
         "texture missing"},
        {"no such texture", "'textures':[]", "texture missing"},
        {"no such picture", "'textures':[{'source':7}]", "texture missing"},
    };
    begin_textured();
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        struct scene *s = read_scene(
            TEXTURED ",%s,'materials':[{'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.5,0.5,1],"
                     "'baseColorTexture':{'index':0}}}]",
            all[i].json);
        ok(is_colour(albedo_at(s, 0), 0.5f, 0.5f, 0.5f) &&
               warnings_of_kind(&warnings, all[i].kind) == 1,
           "%s: the factor alone, and a warning", all[i].name);
        scene_destroy(s);
    }
}

/* -- lights ----------------------------------------------------------------------------------- */

static void test_lights(void)
{
    begin_triangle();
    struct scene *s =
        read_scene(PLAIN ",'extensionsRequired':['KHR_lights_punctual'],'extensions':{'KHR_lights_"
                         "punctual':{'lights':["
                         "{'type':'point','intensity':10,'color':[1,0.5,0],'range':5},"
                         "{'type':'spot','intensity':2,'spot':{'innerConeAngle':0.5,'"
                         "outerConeAngle':1.0471975511965976}},"
                         "{'type':'directional'},{'type':'spot','spot':{}}]}},"
                         "'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0},{'children':[2,3,4,5],'"
                         "translation':[1,2,3],'scale':[9,9,9]},"
                         "{'translation':[1,0,0],'extensions':{'KHR_lights_punctual':{'light':0}}},"
                         "{'rotation':[0,0.7071067811865476,0,0.7071067811865476],'extensions':{'"
                         "KHR_lights_punctual':{'light':1}}},"
                         "{'extensions':{'KHR_lights_punctual':{'light':2}}},{'extensions':{'KHR_"
                         "lights_punctual':{'light':3}}}]");
    const struct scene_light *const l = s->lights;
    ok(s->light_count == 4 && l[0].kind == SCENE_POINT && is_at(l[0].position, 10, 2, 3),
       "a point light where its node is");
    ok(l[0].intensity[0] == 10 && l[0].intensity[1] == 5 && l[0].intensity[2] == 0 &&
           l[0].range == 5,
       "colour times intensity, whatever the node's scale; the range is kept");
    ok(l[1].kind == SCENE_SPOT && is_at(l[1].direction, -1, 0, 0),
       "a spot shines along its node's -Z");
    ok(fabs(l[1].cos_inner - cos(0.5)) < 1e-15 && fabs(l[1].cos_outer - 0.5) < 1e-15,
       "with its cone");
    ok(l[3].cos_inner == 1 && fabs(l[3].cos_outer - sqrt(0.5)) < 1e-9,
       "which is 0 to 45 degrees by itself");
    ok(l[2].kind == SCENE_SUN && is_at(l[2].direction, 0, 0, -1) && l[2].intensity[2] == 1 &&
           l[2].range == 0,
       "a sun");
    scene_destroy(s);
    refuse("a light that does not exist", "light 1 does not exist",
           PLAIN ",'nodes':[{'extensions':{'KHR_lights_punctual':{'light':1}}}]");
    refuse("a light of no known type", "got 'area'",
           ACCESSORS ",'extensions':{'KHR_lights_punctual':{'lights':[{'type':'area'}]}},"
                     "'nodes':[{'extensions':{'KHR_lights_punctual':{'light':0}}}]");
    s = read_scene(ACCESSORS
                   "," MESHES
                   ",'extensions':{'KHR_lights_punctual':{'lights':[{'type':'directional'},{'type':"
                   "'point','intensity':-1}]}},'nodes':[{'mesh':0},{'scale':[0,0,0],'extensions':{'"
                   "KHR_lights_punctual':"
                   "{'light':0}}},{'extensions':{'KHR_lights_punctual':{'light':1}}}]");
    ok(s->light_count == 0 && warnings_of_kind(&warnings, "light out of range") == 2,
       "a light without direction, and one of negative intensity, are left out with a warning");
    scene_destroy(s);
}

/* -- the file --------------------------------------------------------------------------------- */

static void put_word(struct bytes *to, uint32_t word)
{
    for (int i = 0; i < 4; i++)
        put(to, &(uint8_t){(uint8_t)(word >> 8 * i)}, 1);
}

static void put_chunk(struct bytes *to, const char *type, const void *data, size_t size)
{
    put_word(to, (uint32_t)(size + 3) / 4 * 4);
    put(to, type, 4);
    put(to, data, size);
    put(to, *type == 'J' ? "   " : "\0\0\0", (4 - size % 4) % 4);
}

/* A GLB of the JSON and the buffer. */
static __attribute__((format(printf, 1, 2))) struct bytes glb(const char *format, ...)
{
    struct bytes out = {.size = 0};
    va_list args;
    va_start(args, format);
    compose(NULL, format, args);
    va_end(args);
    put(&out, "glTF\2\0\0\0\0\0\0", 12);
    put_chunk(&out, "JSON", text, strlen(text));
    put_chunk(&out, "BIN", buffer.data, buffer.size);
    put_chunk(&out, "MORE", "whatever", 8);
    for (int i = 0; i < 4; i++)
        out.data[8 + i] = (uint8_t)(out.size >> 8 * i);
    return out;
}

static uint64_t key_of(const char *name)
{
    struct scene *s = NULL;
    struct error *err = read_file(name, &s);
    if (err)
        bail("%s", error_message(err));
    const uint64_t key = scene_key(s);
    scene_destroy(s);
    return key;
}

static void test_glb(void)
{
    begin_textured();
    const struct bytes picture = png();
    const int at = view(picture.data, picture.size, 0);
    const char *const textured =
        ",'textures':[{'source':0}],'materials':[{'pbrMetallicRoughness':{'baseColorTexture':"
        "{'index':0}}}],'images':[{'bufferView':";
    struct scene *s = read_scene(TEXTURED "%s%d}]", textured, at);
    const uint64_t key = scene_key(s);
    scene_destroy(s);
    struct bytes whole = glb(TEXTURED "%s%d}]", textured, at);
    files_write_bytes("x.glb", whole.data, whole.size);
    ok(key_of("x.glb") == key, "a GLB is the same scene as its parts, whatever chunks follow");
    files_write_bytes("y.gltf", whole.data, whole.size);
    ok(key_of("y.gltf") == key, "whatever its name says");
    put(&whole, "rubbish", 7);
    files_write_bytes("x.glb", whole.data, whole.size);
    ok(key_of("x.glb") == key, "whatever stands behind its end");

    bool refused = true;
    whole = glb(PLAIN);
    for (size_t size = 0; size < whole.size && refused; size++) {
        files_write_bytes("x.glb", whole.data, size);
        struct error *err = read_file("x.glb", &s);
        refused = err != NULL;
        error_destroy(err);
        scene_destroy(s);
    }
    ok(refused, "cut off at any of its %zu bytes, it is refused", whole.size);

    struct bytes other = whole;
    other.data[4] = 1;
    files_write_bytes("x.glb", other.data, other.size);
    expect_error("an older GLB", "x.glb", "version 1");
    other = whole;
    other.data[15] = 0x7f;
    files_write_bytes("x.glb", other.data, other.size);
    expect_error("a chunk longer than the file", "x.glb", "beyond the file's end");
    other = whole;
    other.data[16] = 'X';
    files_write_bytes("x.glb", other.data, other.size);
    expect_error("a GLB without JSON", "x.glb", "not JSON");
    for (size_t length = 1; length < 5; length++) {
        begin_triangle();
        other = glb("'x':'%.*s'," PLAIN, (int)length, "xxxx");
        memset(other.data + 20 + strlen(text), 0, (4 - strlen(text) % 4) % 4);
        files_write_bytes("x.glb", other.data, other.size);
        key_of("x.glb");
    }
    ok(true, "JSON that is padded with zeros is read");
}

/* The buffer at this URI. */
static bool reads_buffer(const char *uri)
{
    struct scene *s = NULL;
    free(text);
    require(asprintf(
                &text,
                "{'asset':{'version':'2.0'},'buffers':[{'byteLength':36,'uri':'%s'}],'bufferViews':"
                "[{'buffer':0,'byteLength':36}]," PLAIN "}",
                uri) >= 0);
    quote(text);
    files_write("x.gltf", text);
    struct error *err = read_file("x.gltf", &s);
    const bool right = !err && is_at(area(s), 0, 0, 1);
    if (err)
        printf("# %s\n", error_message(err));
    error_destroy(err);
    scene_destroy(s);
    return right;
}

static void test_buffers(void)
{
    uint8_t longer[40] = {0};
    memcpy(longer, corners, sizeof corners);
    files_make_directory("data");
    files_write_bytes("data/a+b c.bin", corners, sizeof corners);
    files_write_bytes("longer.bin", longer, sizeof longer);
    files_write_bytes("shorter.bin", longer, 35);
    ok(reads_buffer("data/a+b c.bin") && reads_buffer("data%2fa%2Bb%20c.bin") &&
           reads_buffer("DATA/A+B C.BIN"),
       "a buffer in a folder: as it is named, percent-encoded, in other letters");
    ok(reads_buffer("longer.bin"), "a file that is longer than its buffer");
    const char *const base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    const char *const types[] = {"application/octet-stream", "application/gltf-buffer", "",
                                 "text/plain;charset=x"};
    for (size_t i = 0; i < 4; i++) {
        char uri[256];
        snprintf(uri, sizeof uri, "data:%s;base64,%s", types[i], base64);
        ok(reads_buffer(uri), "a data: URI of the type '%s'", types[i]);
    }
    begin();
#define BUFFER(json) "'buffers':[{" json "}],'bufferViews':[{'buffer':0,'byteLength':36}]," PLAIN
    refuse("a missing buffer", "buffer 0: gone.bin is missing",
           BUFFER("'byteLength':36,'uri':'gone.bin'"));
    refuse("a missing buffer that nothing uses", "gone.bin",
           "'buffers':[{'byteLength':4,'uri':'gone.bin'}]");
    refuse("a buffer that is cut off", "shorter.bin has 35 bytes, expected 36",
           BUFFER("'byteLength':36,'uri':'shorter.bin'"));
    refuse("a data: URI that is too short", "data: URI has 3 bytes",
           BUFFER("'byteLength':36,'uri':'data:;base64,AAAA'"));
    refuse("a buffer without a place", "neither a URI", BUFFER("'byteLength':36"));
    refuse("a buffer without a length", "byteLength", BUFFER("'uri':'longer.bin'"));
    refuse("a buffer that is a folder", "missing", BUFFER("'byteLength':36,'uri':'data'"));
}

static void test_documents(void)
{
    static const struct {
        const char *name, *text, *part;
    } all[] = {
        {"nothing", "", ""},
        {"no JSON", "not JSON", "JSON"},
        {"JSON that is cut off", "{\"asset\":{\"version\":\"2.0\"}", "JSON"},
        {"a list", "[1,2]", "not glTF"},
        {"a number beyond doubles", "{\"asset\":{\"version\":\"2.0\"},\"x\":1e999}", "JSON"},
        {"glTF 1.0", "{\"asset\":{\"version\":\"1.0\"}}", "version 1.0"},
        {"a newer glTF", "{\"asset\":{\"version\":\"2.1\",\"minVersion\":\"2.1\"}}", "version 2.1"},
        {"no version", "{}", "version"},
    };
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        files_write("x.gltf", all[i].text);
        expect_error(all[i].name, "x.gltf", all[i].part);
    }
    begin_triangle();
    const char *const unknown[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                   "KHR_texture_basisu"};
    for (size_t i = 0; i < 3; i++) {
        refuse("a required extension", unknown[i],
               PLAIN ",'extensionsUsed':['%s'],'extensionsRequired':['%s']", unknown[i],
               unknown[i]);
        struct scene *s = read_scene(PLAIN ",'extensionsUsed':['%s']", unknown[i]);
        ok(scene_triangle_count(s) == 1 && warnings_of_kind(&warnings, "unknown extension") == 1,
           "%s that is not required is no hindrance, and named", unknown[i]);
        scene_destroy(s);
    }
    static const char *const lights[] = {"EXT_lights_image_based", "EXT_lights_ies",
                                         "FB_environment_sky"};
    for (size_t i = 0; i < sizeof lights / sizeof *lights; i++) {
        struct scene *s = read_scene(PLAIN ",'extensionsUsed':['%s']", lights[i]);
        ok(warnings_of_kind(&warnings, "light of an unknown extension") == 1,
           "the light of %s is missed", lights[i]);
        scene_destroy(s);
    }
    struct scene *s = read_scene(
        PLAIN ",'skins':[{'joints':[0]}],'animations':[{'channels':[{}],'samplers':[{}]}],"
              "'cameras':[{'type':'odd'}],'extras':{'a':[1,{'b':null}]}");
    ok(scene_triangle_count(s) == 1 && warnings.count == 0,
       "animations, cameras and extras are left alone, sound or not");
    scene_destroy(s);
    s = read_scene(PLAIN ",'materials':[{'name':null,'alphaMode':null}],'skins':null");
    ok(scene_triangle_count(s) == 1 && warnings_of_kind(&warnings, "glTF null") == 3,
       "what is null is not there");
    scene_destroy(s);
    s = read_scene(
        ACCESSORS
        ",'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':0,'COLOR_0':0,'JOINTS_0':0}"
        ","
        "'targets':[{'POSITION':0}]}]}],'nodes':[{'mesh':0}]");
    ok(scene_triangle_count(s) == 1 && warnings.count == 0, "attributes of all kinds");
    scene_destroy(s);
    static const char *const wrong[][2] = {
        {"'meshes':{'primitives':[]}", "meshes: expected a list of objects, got {"},
        {"'meshes':[{'primitives':{}}]", "meshes 0: primitives: expected a list of objects"},
        {"'meshes':[{'primitives':[{'attributes':[0]}]}]",
         "meshes 0, primitives 0: attributes: expected an object, got [0]"},
        {"'nodes':[{'mesh':'0'}]",
         "nodes 0: mesh: expected a whole number of 0 or more, got \"0\""},
        {"'nodes':[{'translation':[0,'1',2]}]",
         "nodes 0: translation: expected a list of 3 numbers"},
        {"'nodes':[3]", "nodes: expected a list of objects"},
        {"'scenes':[{'nodes':0}]",
         "scenes 0: nodes: expected a list of whole numbers of 0 or more, got 0"},
        {"'materials':[{'pbrMetallicRoughness':1}]", "pbrMetallicRoughness: expected an object"},
        {"'materials':[{'alphaMode':2}]", "materials 0: alphaMode: expected text, got 2"},
        {"'meshes':[\n{'name':'a\\'}[','primitives':[\n{},\n{'mode':'4'}]}]",
         ":4: meshes 0, primitives 1: mode: expected a whole number"},
        {"'meshes':[{'primitives':[\n{'attributes':{'POSITION':'0'}}]}]",
         ":2: meshes 0, primitives 0, attributes: POSITION: expected a whole number"},
        {"'materials':[{},\n\n{'pbrMetallicRoughness':{'baseColorFactor':'red'}}]",
         ":3: materials 1, pbrMetallicRoughness: baseColorFactor: expected a list of 3 numbers"},
        {"'materials':[{'emissiveTexture':{'index':[1]}}]",
         "emissiveTexture: index: expected a whole number"},
        {"'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'},\n{'type':'point',"
         "'intensity':'9'}]}}",
         ":2: extensions, KHR_lights_punctual, lights 1: intensity: expected a number"},
        {"'scene':'main'", "scene: expected a whole number of 0 or more, got \"main\""},
        {"'nodes':[{'name':7}]", "nodes 0: name: expected text, got 7"},
        {"'meshes':[{'name':['a'],'primitives':[]}]", "meshes 0: name: expected text, got [\"a\"]"},
        {"'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','name':1}]}}",
         "lights 0: name: expected text, got 1"},
        {"'extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot',"
         "'spot':{'outerConeAngle':'1'}}]}}",
         "lights 0, spot: outerConeAngle: expected a number, got \"1\""},
        {"'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','color':[1,0]}]}}",
         "lights 0: color: expected a list of 3 numbers, got [1,0]"},
        {"'nodes':[{'mesh':-1}]", "nodes 0: mesh: expected a whole number of 0 or more, got -1"},
        {"'nodes':[{'translation':[0,1]}]", "nodes 0: translation: expected a list of 3 numbers"},
        {"'nodes':[{'rotation':[0,0,0]}]", "nodes 0: rotation: expected a list of 4 numbers"},
        {"'nodes':[{'scale':2}]", "nodes 0: scale: expected a list of 3 numbers, got 2"},
        {"'nodes':[{'translation':[0,null,0]}]", "nodes 0: translation: expected a list of 3"},
        {"'nodes':[{'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'SCALE':'1'}}}}]",
         "EXT_mesh_gpu_instancing, attributes: SCALE: expected a whole number"},
        {"'nodes':[{'extensions':{'KHR_node_visibility':{'visible':'no'}}}]",
         "KHR_node_visibility: visible: expected true or false, got \"no\""},
        {"'materials':[{'doubleSided':1}]", "materials 0: doubleSided: expected true or false"},
        {"'materials':[{'emissiveFactor':[1]}]", "emissiveFactor: expected a list of 3 numbers"},
        {"'materials':[{'extensions':{'KHR_materials_transmission':{'transmissionFactor':true}}}]",
         "KHR_materials_transmission: transmissionFactor: expected a number, got true"},
        {"'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':'1'}}}]",
         "baseColorTexture: texCoord: expected a whole number"},
        {"'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':"
         "{'KHR_texture_transform':{'offset':[1]}}}}}]",
         "KHR_texture_transform: offset: expected a list of 2 numbers, got [1]"},
        {"'materials':[{'extensions':{'KHR_materials_pbrSpecularGlossiness':"
         "{'diffuseFactor':[1,1,1]}}}]",
         "diffuseFactor: expected a list of 4 numbers"},
        {"'textures':[{'extensions':{'EXT_texture_webp':{'source':'0'}}}]",
         "EXT_texture_webp: source: expected a whole number"},
        {"'meshes':[{'primitives':[{'attributes':{},'targets':[{'POSITION':'0'}]}]}]",
         "targets 0: POSITION: expected a whole number"},
        {"'extensionsUsed':'KHR_x'", "extensionsUsed: expected a list of texts, got \"KHR_x\""}};
    refuse("a mode that glTF has not", "a primitive of mode 9, expected 0 to 6",
           ACCESSORS ",'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':9}]}],"
                     "'nodes':[{'mesh':0}]");
    refuse("an alphaMode that glTF has not", "material 'm': alphaMode 'blend', expected OPAQUE",
           ACCESSORS ",'materials':[{'name':'m','alphaMode':'blend'}],'meshes':[{'primitives':"
                     "[{'attributes':{'POSITION':0},'material':0}]}],'nodes':[{'mesh':0}]");
    refuse("a sparse count of text", "accessors 0, sparse: count: expected a whole number",
           "'accessors':[{'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':'3'}}]");
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        refuse(wrong[i][1], wrong[i][1], "%s", wrong[i][0]);
        lenient = true;
        s = read_scene("%s", wrong[i][0]);
        ok(warnings_of_kind(&warnings, "glTF of the wrong type") > 0, "a warning when lenient");
        scene_destroy(s);
        lenient = false;
    }
}

/* -- extremes --------------------------------------------------------------------------------- */

static void test_depth(void)
{
    enum { DEEP = 20000 };
    struct scene *s;
    char *json = malloc(DEEP * 64), *at = json;
    require(json);
    at += sprintf(at, "%s", ACCESSORS "," MESHES ",'nodes':[");
    for (int i = 0; i < DEEP; i++)
        at += sprintf(at, "{'children':[%d],'translation':[1,0,0]},", i + 1);
    sprintf(at, "{'mesh':0}]");
    begin_triangle();
    s = read_scene("%s", json);
    ok(is_at(placed(s, 0, 0, 0), DEEP, 0, 0), "nodes %d deep", DEEP);
    scene_destroy(s);

    memset(json, '[', DEEP);
    memset(json + DEEP, ']', DEEP);
    json[2 * DEEP] = 0;
    refuse("JSON nested too deep", "deep", PLAIN ",'extras':%s", json);
    refuse("JSON nested without end", "", PLAIN ",'extras':%.*s", DEEP, json);
    free(json);
}

static void test_graph(void)
{
    begin_triangle();
    refuse("a node below itself", "its own ancestor",
           ACCESSORS "," MESHES
                     ",'scenes':[{'nodes':[0]}],'nodes':[{'children':[1]},{'children':[0]}]");
    refuse("a node with two parents", "two parents",
           ACCESSORS "," MESHES ",'nodes':[{'children':[2]},{'children':[2]},{'mesh':0}]");
    refuse("a node placed twice", "two parents",
           ACCESSORS "," MESHES ",'scenes':[{'nodes':[0,0]}],'nodes':[{'mesh':0}]");
    refuse("a node that does not exist", "node 7",
           ACCESSORS "," MESHES ",'scenes':[{'nodes':[7]}],'nodes':[{'mesh':0}]");
    refuse("a node of negative number", "scenes 0: nodes: expected a list of whole numbers",
           ACCESSORS "," MESHES ",'scenes':[{'nodes':[-1]}],'nodes':[{'mesh':0}]");
    refuse("a scene that does not exist", "scene 3", PLAIN ",'scene':3,'scenes':[{'nodes':[0]}]");
    refuse("a mesh that does not exist", "mesh 4", ACCESSORS "," MESHES ",'nodes':[{'mesh':4}]");
    refuse("a matrix of three numbers", "16 numbers",
           ACCESSORS "," MESHES ",'nodes':[{'mesh':0,'matrix':[1,2,3]}]");
    refuse("a place beyond numbers", "",
           ACCESSORS "," MESHES ",'nodes':[{'scale':[1e300,1,1],'children':[1]},{'mesh':0,"
                     "'scale':[1e300,1,1]}]");
    struct scene *s =
        read_scene(ACCESSORS "," MESHES ",'nodes':[{'mesh':0,'scale':[0,0,0]},{'mesh':0}]");
    ok(scene_triangle_count(s) == 1, "what is scaled to nothing is not there");
    scene_destroy(s);
    s = read_scene(ACCESSORS ",'meshes':[{'primitives':[]},{'primitives':[{'attributes':{}}]},{'"
                             "primitives':[{'attributes':"
                             "{'POSITION':0}}]}],'nodes':[{'mesh':0},{'mesh':1},{'mesh':2},{}]");
    ok(scene_triangle_count(s) == 1, "empty meshes and nodes are none");
    scene_destroy(s);
}

/* Two joints at x of 10 and y of 20, bound at x of 1; the mesh's node is at 100. */
static void test_poses(void)
{
    const float p[9] = {1, 0, 0, 2, 0, 0, 1, 1, 0}, by[9] = {0, 0, 4, 0, 0, 0, 0, 0, 0};
    const uint8_t joint[12] = {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0};
    const uint8_t weight[12] = {255, 0, 0, 0, 255, 0, 0, 0, 51, 204, 0, 0};
    const float bind[32] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1,
                            1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1};
    begin();
    view(p, sizeof p, 0);
    view(joint, sizeof joint, 0);
    view(weight, sizeof weight, 0);
    view(bind, sizeof bind, 0);
    view(by, sizeof by, 0);
#define POSED POSED_WITH("")
#define POSED_WITH(attributes)                                                                     \
    "'accessors':[" ACCESSOR ",{'bufferView':1,'componentType':5121,'count':3,'type':'VEC4'},"     \
    "{'bufferView':2,'componentType':5121,'normalized':true,'count':3,'type':'VEC4'},"             \
    "{'bufferView':3,'componentType':5126,'count':2,'type':'MAT4'},"                               \
    "{'bufferView':4,'componentType':5126,'count':3,'type':'VEC3'}],"                              \
    "'meshes':[{'weights':[0.5],'primitives':[{'attributes':{'POSITION':0,'JOINTS_0':1,"           \
    "'WEIGHTS_0':2" attributes "},'targets':[{'POSITION':4}]}]}],"
    struct scene *s = read_scene(
        POSED "'nodes':[{'mesh':0,'skin':0,'translation':[100,0,0]},{'translation':[10,0,0],"
              "'children':[2]},{'translation':[-10,20,0]}],'scenes':[{'nodes':[0,1]}],"
              "'skins':[{'joints':[1,2],'inverseBindMatrices':3}]");
    ok(is_at(placed(s, 0, 0, 0), 10, 0, 2) && is_at(placed(s, 0, 0, 1), 1, 20, 0) &&
           is_at(placed(s, 0, 0, 2), 2, 17, 0) && warnings.count == 0,
       "a skin: joints by inverse bind matrices, the node ignored; morphed by the mesh's weights");
    scene_destroy(s);
    s = read_scene(POSED "'nodes':[{'mesh':0,'weights':[1]},{'mesh':0,'translation':[5,0,0]},"
                         "{'mesh':0,'weights':[-1]}]");
    ok(s->instance_count == 3 && is_at(placed(s, 0, 0, 0), 1, 0, 4) &&
           is_at(placed(s, 1, 0, 0), 6, 0, 2) && is_at(placed(s, 2, 0, 0), 1, 0, -4),
       "morph targets by the node's weights, else the mesh's");
    scene_destroy(s);
    s = read_scene(POSED "'nodes':[{'mesh':0,'skin':0},{'translation':[7,0,0]},{}],"
                         "'skins':[{'joints':[1,2]}]");
    ok(is_at(placed(s, 0, 0, 0), 8, 0, 2), "without inverse bind matrices: the identity");
    scene_destroy(s);
    s = read_scene(POSED_WITH(",'COLOR_0':2") "'nodes':[{'mesh':0,'skin':0},{'translation':[7,0,"
                                              "0]},{}],'skins':[{'joints':[1,2]}]");
    ok(is_at(placed(s, 0, 0, 0), 8, 0, 2) && has_colour(s, 0, 1, 0, 0, 1) &&
           has_colour(s, 2, 0.2, 0.8, 0, 1),
       "skins keep the colours of their vertices");
    scene_destroy(s);
    refuse("a skin that does not exist", "skin 1 does not exist",
           POSED "'nodes':[{'mesh':0,'skin':1}],'skins':[{'joints':[0]}]");
    refuse("a joint that the skin lacks", "joint 1 of 1",
           POSED "'nodes':[{'mesh':0,'skin':0}],'skins':[{'joints':[0]}]");
    refuse("fewer matrices than joints", "has 3 joints and 2 inverse bind matrices",
           POSED "'nodes':[{'mesh':0,'skin':0},{},{}],"
                 "'skins':[{'joints':[0,1,2],'inverseBindMatrices':3}]");
}

static void test_bounds(void)
{
#define ONE(accessor) "'accessors':[{" accessor "}]," MESHES ",'nodes':[{'mesh':0}]"
    static const struct {
        const char *name, *json;
    } all[] = {
        {"more elements than bytes",
         ONE("'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'")},
        {"a count near 2^64",
         ONE("'bufferView':0,'componentType':5126,'count':18446744073709551615,'type':'VEC3'")},
        {"a count whose bytes wrap around",
         ONE("'bufferView':0,'componentType':5126,'count':1537228672809129302,'type':'VEC3'")},
        {"an offset beyond the view",
         ONE("'bufferView':0,'byteOffset':40,'componentType':5126,'count':1,'type':'VEC3'")},
        {"an offset near 2^64", ONE("'bufferView':0,'byteOffset':18446744073709551600,'"
                                    "componentType':5126,'count':3,'type':'VEC3'")},
        {"a view that does not exist",
         ONE("'bufferView':9,'componentType':5126,'count':3,'type':'VEC3'")},
        {"many elements without data", ONE("'componentType':5126,'count':60000000,'type':'VEC3'")},
        {"two numbers for a position",
         ONE("'bufferView':0,'componentType':5126,'count':3,'type':'VEC2'")},
        {"a type that glTF has not",
         ONE("'bufferView':0,'componentType':5130,'count':1,'type':'VEC3'")},
        {"a type of no number", ONE("'bufferView':0,'componentType':1,'count':1,'type':'VEC3'")},
        {"an accessor that does not exist", "'accessors':[]," MESHES ",'nodes':[{'mesh':0}]"},
        {"an accessor of negative number", ACCESSORS
         ",'meshes':[{'primitives':[{'attributes':{'POSITION':-3}}]}],'nodes':[{'mesh':0}]"},
        {"a sparse accessor of negative numbers",
         ONE("'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':-1,'indices':{'"
             "bufferView':0,"
             "'componentType':5121},'values':{'bufferView':0}}")},
        {"a sparse accessor beyond its view",
         ONE("'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':3,'indices':{'"
             "bufferView':0,"
             "'componentType':5121},'values':{'bufferView':0,'byteOffset':4}}")},
    };
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        begin_triangle();
        refuse(all[i].name, "", "%s", all[i].json);
    }
    begin();
    const char *const views_json[] = {"'byteLength':37", "'byteOffset':1,'byteLength':36",
                                      "'byteOffset':18446744073709551615,'byteLength':36",
                                      "'byteOffset':36,'byteLength':18446744073709551610"};
    files_write_bytes("36.bin", corners, sizeof corners);
    for (size_t i = 0; i < 4; i++)
        refuse(
            "a view beyond its buffer", "beyond its buffer",
            "'buffers':[{'byteLength':36,'uri':'36.bin'}],'bufferViews':[{'buffer':0,%s}]," PLAIN,
            views_json[i]);
    refuse("a view of no buffer", "buffer 5",
           "'buffers':[{'byteLength':36,'uri':'36.bin'}],'bufferViews':[{'buffer':5,"
           "'byteLength':36}]," PLAIN);
    /* tinygltf itself would read this picture a long way behind the buffer */
    refuse("a picture beyond its buffer", "image 0",
           "'buffers':[{'byteLength':36,'uri':'36.bin'}],'bufferViews':[{'buffer':0,'byteLength':"
           "36},{'buffer':0,"
           "'byteOffset':4000000000,'byteLength':1000000}],'accessors':[" ACCESSOR
           "],'images':[{'bufferView':1}],"
           "'textures':[{'source':0}],'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'"
           "index':0}}}]");
}

static void test_numbers(void)
{
    const float nan = (float)NAN, inf = (float)INFINITY;
    const float p[27] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0,   nan, 0,
                         0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, inf, 0};
    begin();
    view(p, sizeof p, 0);
    struct scene *s = read_scene(
        "'accessors':[{'bufferView':0,'componentType':5126,'count':9,'type':'VEC3'}]," MESHES
        ",'nodes':[{'mesh':0}]");
    ok(scene_triangle_count(s) == 1 && s->degenerate_count == 2,
       "triangles at NaN and infinity are left out");
    scene_destroy(s);
    begin_triangle();
    s = read_scene("'materials':[{'pbrMetallicRoughness':{'baseColorFactor':[1e300,-1,0.5,1]},'"
                   "emissiveFactor':[-1e200,0,0]}],'accessors':[" ACCESSOR
                   "],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],'"
                   "nodes':[{'mesh':0}]");
    const struct vec3f a = albedo_at(s, 0), e = s->materials[0].emission;
    ok(a.x >= 0 && a.x <= 1 && a.y == 0 && e.x == 0 &&
           warnings_of_kind(&warnings, "material out of range") > 0,
       "factors beyond numbers become legal, with a warning");
    scene_destroy(s);
    refuse("light that no float holds", "beyond what 32 bits can hold",
           "'materials':[{'emissiveFactor':[1,0,0],'extensions':{'KHR_materials_emissive_strength':"
           "{'emissiveStrength':1e200}}}],"
           "'accessors':[" ACCESSOR "],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'"
           "material':0}]}],'nodes':[{'mesh':0}]");
    refuse("a material that does not exist", "material 77 does not exist",
           ACCESSORS ",'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':77}"
                     "]}],'nodes':[{'mesh':0}]");
    lenient = true;
    s = read_scene(ACCESSORS ",'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':77}"
                             "]}],'nodes':[{'mesh':0}]");
    lenient = false;
    ok(is_colour(albedo_at(s, 0), 1, 1, 1) && warnings_of_kind(&warnings, "material missing") == 1,
       "a material that does not exist is white, with a warning");
    scene_destroy(s);
}

int main(void)
{
    files_begin();
    test_components();
    test_layout();
    test_modes();
    test_shared_vertices();
    test_nodes();
    test_mirrors();
    test_instancing();
    test_factors();
    test_colours();
    test_textures();
    test_transforms();
    test_samplers();
    test_pictures();
    test_missing_pictures();
    test_lights();
    test_glb();
    test_buffers();
    test_documents();
    test_depth();
    test_graph();
    test_poses();
    test_bounds();
    test_numbers();
    files_end();
    warnings_clear(&warnings);
    free(text);
    return tap_done();
}
