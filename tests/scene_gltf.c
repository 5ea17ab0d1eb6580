/* glTF import: what the specification says about accessors, nodes, instances, materials, textures and lights, on files that this program
 * writes; what cannot be honoured is refused by name. */
#include "error.h"
#include "scene.h"
#include "tap.h"
#include "vec.h"
#include "warning.h"

#include <stdarg.h>
#include <string.h>
#include <unistd.h>

static char directory[] = "/tmp/probe-gltf-XXXXXX";
static char path[64];

/* Three corners (0 0 0), (1 0 0), (0 1 0) as floats; texture coordinates of the same; indices 0 1 2 as bytes, padded. */
#define TRIANGLE "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"
#define UV "AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/"
#define INDEX "AAECAA=="
#define BUFFERS "\"buffers\":[{\"byteLength\":64,\"uri\":\"data:application/octet-stream;base64," TRIANGLE UV INDEX "\"}]," \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":24},{\"buffer\":0,\"byteOffset\":60,\"byteLength\":3}]"
#define ACCESSORS "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}," \
    "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"},{\"bufferView\":2,\"componentType\":5121,\"count\":3,\"type\":\"SCALAR\"}]"
#define MESH "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"indices\":2,\"material\":0}]}]"
#define BARE_MESH "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]"
#define ASSET "{\"asset\":{\"version\":\"2.0\"},"
#define MATERIAL "\"materials\":[{\"name\":\"a\"}]"
#define NODE "\"nodes\":[{\"mesh\":0}]"
/* A PNG of 2 x 2: red, green; blue, white. */
#define PNG "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAIAAAD91JpzAAAAEklEQVR4nGP4z8DAAMIM/4EAAB/uBfsL2WiLAAAAAElFTkSuQmCC"

static struct scene *read_text(const char *text, struct warnings *warnings, struct error **err)
{
    FILE *f = fopen(path, "w");
    if (!f || fputs(text, f) < 0 || fclose(f))
        bail("cannot write %s", path);
    struct scene_settings settings = scene_settings_default();
    struct scene *scene = NULL;
    *err = scene_read(&scene, path, &settings, true, warnings);
    return scene;
}

static struct scene *read_good(const char *text)
{
    struct error *err = NULL;
    struct scene *scene = read_text(text, NULL, &err);
    if (err)
        bail("%s\n# %s", error_message(err), text);
    return scene;
}

static void refused(const char *text, const char *message)
{
    struct error *err = NULL;
    struct scene *scene = read_text(text, NULL, &err);
    ok(err && strstr(error_message(err), message), "refused: %s", err ? error_message(err) : "(accepted)");
    error_destroy(err);
    scene_destroy(scene);
}

static struct vec3 placed(const struct scene *s, size_t instance, size_t vertex)
{
    const double *m = s->instances[instance].transform, *p = s->meshes[s->instances[instance].mesh].position + 3 * vertex;
    return (struct vec3){m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3], m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7],
                         m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11]};
}

static bool near(struct vec3 p, double x, double y, double z)
{
    return fabs(p.x - x) + fabs(p.y - y) + fabs(p.z - z) < 1e-6;
}

static void test_basic(void)
{
    struct scene *s = read_good(ASSET BUFFERS "," ACCESSORS "," MESH "," MATERIAL "," NODE "}");
    ok(s->instance_count == 1 && scene_triangle_count(s) == 1 && near(placed(s, 0, 1), 1, 0, 0), "a triangle is read");
    ok(s->materials[0].albedo.x == 1 && s->materials[0].albedo.z == 1, "albedo is white where none is stated");
    const float *uv = s->meshes[0].uv;
    ok(!uv || (uv[0] == 0 && uv[1] == 1), "v is turned up, or left out where no texture is read");
    scene_destroy(s);
    s = read_good(ASSET BUFFERS "," ACCESSORS ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]," NODE "}");
    ok(scene_triangle_count(s) == 1 && s->materials[s->meshes[0].material[0]].albedo.x == 1, "without indices and material as well");
    scene_destroy(s);
    s = read_good(ASSET BUFFERS "," ACCESSORS ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":1}]}]," NODE "}");
    ok(scene_triangle_count(s) == 0, "lines are left out");
    scene_destroy(s);
}

static void test_nodes(void)
{
    struct scene *s = read_good(ASSET BUFFERS "," ACCESSORS "," MESH "," MATERIAL ",\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":["
                                "{\"children\":[1,2],\"translation\":[10,0,0]},"
                                "{\"mesh\":0,\"rotation\":[0,0,0.7071067811865476,0.7071067811865476],\"scale\":[2,2,2]},"
                                "{\"mesh\":0,\"matrix\":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1]},{\"mesh\":0}]}");
    ok(s->instance_count == 2 && s->mesh_count == 1, "one mesh placed twice stays one mesh; nodes outside the scene are not there");
    ok(near(placed(s, 0, 1), 10, 2, 0) && near(placed(s, 0, 2), 8, 0, 0), "translation, rotation and scale, in the order T R S");
    ok(near(placed(s, 1, 1), 14, 6, 7), "a matrix is column-major");
    scene_destroy(s);

    /* A chain of nodes that is far deeper than any stack. */
    enum { DEEP = 20000 };
    char *text = malloc(DEEP * 64 + 4096);
    char *at = text + sprintf(text, "%s", ASSET BUFFERS "," ACCESSORS "," MESH "," MATERIAL ",\"nodes\":[");
    for (int i = 0; i < DEEP; i++)
        at += sprintf(at, "{\"children\":[%d],\"translation\":[1,0,0]},", i + 1);
    sprintf(at, "{\"mesh\":0}]}");
    s = read_good(text);
    ok(near(placed(s, 0, 0), DEEP, 0, 0), "%d nodes deep", DEEP);
    scene_destroy(s);
    free(text);
    refused(ASSET BUFFERS "," ACCESSORS "," MESH "," MATERIAL ",\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[1]},{\"children\":[0]}]}", "its own ancestor");
    refused(ASSET BUFFERS "," ACCESSORS "," MESH "," MATERIAL ",\"scenes\":[{\"nodes\":[7]}],\"nodes\":[{\"mesh\":0}]}", "node 7 does not exist");
}

static void test_materials(void)
{
    struct scene *s = read_good(ASSET BUFFERS "," ACCESSORS "," MESH "," NODE ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,1,0.4],"
                                "\"baseColorTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0,1],\"rotation\":1.5707963267948966,\"scale\":[0.5,0.5]}}}},"
                                "\"alphaMode\":\"MASK\",\"alphaCutoff\":0.3,\"emissiveFactor\":[1,0.5,0],"
                                "\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":8}}}],"
                                "\"textures\":[{\"source\":0,\"sampler\":0}],\"samplers\":[{\"wrapS\":33071,\"wrapT\":33648,\"magFilter\":9728}],"
                                "\"images\":[{\"uri\":\"data:image/png;base64," PNG "\"}]}");
    const struct scene_material *m = &s->materials[0];
    ok(m->emission.x == 8 && m->emission.y == 4, "emissive strength multiplies the factor");
    ok(m->alpha == SCENE_CUTOUT && m->cutoff == 0.3f && m->opacity == 0.4f, "a cut-out with its cut-off and factor");
    const bool textured = ok(s->texture_count == 1 && m->albedo_map.texture == 0, "a data: URI is a texture");
    if (textured) {
        ok(s->textures[0].wrap_u == SCENE_CLAMP && s->textures[0].wrap_v == SCENE_MIRROR && s->textures[0].nearest, "with its sampler");
        /* The specification's example: offset 0 1, rotation 90 degrees, scale 1/2 show the lower left quarter: v-down (0.25, 0.75). */
        const float *t = m->albedo_map.transform;
        const float u = t[0] * 0.5f + t[1] * 0.5f + t[2], v = t[3] * 0.5f + t[4] * 0.5f + t[5];
        ok(fabsf(u - 0.25f) < 1e-6f && fabsf(1 - v - 0.75f) < 1e-6f, "its transform is KHR_texture_transform's: (%.3f, %.3f)", (double)u, (double)(1 - v));
    }
    scene_destroy(s);

    struct warnings w = {0};
    struct error *err = NULL;
    s = read_text(ASSET BUFFERS "," ACCESSORS "," MESH "," NODE ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
                  "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"no%2Fsuch.png\"}]}", &w, &err);
    ok(!err && s && s->materials[0].albedo_map.texture == SCENE_NONE && w.count == 1, "a missing texture is a warning: %s", err ? error_message(err) : "");
    error_destroy(err);
    warnings_clear(&w);
    scene_destroy(s);
}

static void test_lights(void)
{
    struct scene *s = read_good(ASSET BUFFERS "," ACCESSORS "," MESH "," MATERIAL ",\"extensions\":{\"KHR_lights_punctual\":{\"lights\":["
                                "{\"type\":\"point\",\"intensity\":10,\"color\":[1,0.5,0]},"
                                "{\"type\":\"spot\",\"intensity\":2,\"spot\":{\"innerConeAngle\":0,\"outerConeAngle\":1.0471975511965976}},{\"type\":\"directional\"}]}},"
                                "\"nodes\":[{\"translation\":[1,2,3],\"scale\":[9,9,9],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
                                "{\"rotation\":[0,0.7071067811865476,0,0.7071067811865476],\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},"
                                "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}},{\"mesh\":0}]}");
    const struct scene_light *l = s->lights;
    ok(s->light_count == 3 && l[0].kind == SCENE_POINT && near(l[0].position, 1, 2, 3) && l[0].intensity[0] == 10 && l[0].intensity[1] == 5,
       "a point light, its colour times its intensity, not scaled by its node");
    ok(l[1].kind == SCENE_SPOT && near(l[1].direction, -1, 0, 0) && fabs(l[1].cos_outer - 0.5) < 1e-12 && l[1].cos_inner == 1,
       "a spot shines along its node's -Z");
    ok(l[2].kind == SCENE_SUN && near(l[2].direction, 0, 0, -1) && l[2].intensity[2] == 1, "a sun");
    scene_destroy(s);
}

static void test_refused(void)
{
    refused("{", "");
    refused("not JSON", "");
    refused(ASSET "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]}", "KHR_draco_mesh_compression");
    refused(ASSET "\"buffers\":[{\"byteLength\":4,\"uri\":\"gone.bin\"}]}", "gone.bin");
    refused(ASSET BUFFERS ",\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}]," BARE_MESH "," MATERIAL "," NODE "}", "do not fit");
    refused(ASSET BUFFERS ",\"accessors\":[{\"bufferView\":0,\"byteOffset\":18446744073709551600,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]," BARE_MESH "," MATERIAL "," NODE "}", "");
    refused(ASSET BUFFERS ",\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}]," BARE_MESH "," MATERIAL "," NODE "}", "expected 3 numbers");
    refused(ASSET BUFFERS "," ACCESSORS ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":9}}]}]," MATERIAL "," NODE "}", "accessor 9 does not exist");
    refused(ASSET BUFFERS ",\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"},"
            "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"},{\"bufferView\":2,\"componentType\":5121,\"count\":3,\"type\":\"SCALAR\"}],"
            MESH "," MATERIAL "," NODE "}", "index 2 is out of range");
}

int main(void)
{
    if (!mkdtemp(directory))
        bail("no temporary directory");
    snprintf(path, sizeof path, "%s/scene.gltf", directory);
    test_basic();
    test_nodes();
    test_materials();
    test_lights();
    test_refused();
    unlink(path);
    rmdir(directory);
    return tap_done();
}
