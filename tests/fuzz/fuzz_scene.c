/* SPDX-License-Identifier: Apache-2.0 */
/* A hostile scene: whatever bytes a file holds, reading it ends, with a legal scene or an error,
 * and harms nothing.
 *
 *     fuzz_scene [MUTATIONS [SEED]]     small files of every format, mutated;
 *                                        part of make check with few mutations
 *
 * For longer: fuzz_scene 1000000, or build with clang -fsanitize=fuzzer -DFUZZ_ENGINE, for which
 * LLVMFuzzerTestOneInput takes a byte that chooses the format and then the file.
 */
#include "base/error.h"
#include "base/warning.h"
#include "image/image.h"
#include "import/import_scene.h"
#include "scene/scene.h"
#include "scene/scene_settings.h"
#include "scene/scene_shade.h"
#include "support/files.h"
#include "support/tap.h"
#include "topology/decimate.h"
#include "topology/solids.h"

#include <stb_image_write.h>
#include <stdint.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What a read scene must hold; aborts when it does not. */
static void require(bool holds, const char *what)
{
    if (holds)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

static void check_mesh(const struct scene *s, const struct scene_mesh *mesh)
{
    require(mesh->triangle_count > 0, "no mesh is empty");
    for (size_t k = 0; k < 3 * mesh->vertex_count; k++)
        require(isfinite(mesh->position[k]), "positions are finite");
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const int32_t m = mesh->material[t];
        for (size_t k = 3 * t; k < 3 * t + 3; k++)
            require(mesh->index[k] < mesh->vertex_count, "indices are in range");
        require(m >= 0 && (size_t)m < s->material_count, "materials are in range");
        for (size_t k = 6 * t; mesh->uv && k < 6 * t + 6; k++)
            require(isfinite(mesh->uv[k]), "texture coordinates are finite");
        if (t < 1000) {
            const float u = mesh->uv ? mesh->uv[6 * t] : 0, v = mesh->uv ? mesh->uv[6 * t + 1] : 0;
            const struct vec3f a = scene_albedo(s, &s->materials[m], u, v),
                               e = scene_emission(s, &s->materials[m], u, v);
            const float passes = scene_transparency(s, &s->materials[m], u, v);
            require(a.x >= 0 && a.x <= 1 && a.y >= 0 && a.y <= 1 && a.z >= 0 && a.z <= 1,
                    "albedo is within 0 and 1");
            require(e.x >= 0 && isfinite(e.x) && e.y >= 0 && isfinite(e.y) && e.z >= 0 &&
                        isfinite(e.z),
                    "emission is legal");
            require(passes >= 0 && passes <= 1, "transparency is a share");
        }
    }
}

static void check_scene(const struct scene *s)
{
    for (size_t i = 0; i < s->mesh_count; i++)
        check_mesh(s, &s->meshes[i]);
    for (size_t i = 0; i < s->instance_count; i++)
        require(s->instances[i].mesh < s->mesh_count, "instances place meshes");
    if (scene_triangle_count(s) > 0)
        require(isfinite(s->box_min.x) && s->box_min.x <= s->box_max.x, "the box is finite");
    for (size_t i = 0; i < s->light_count; i++)
        require(isfinite(s->lights[i].intensity[0]) && s->lights[i].intensity[0] >= 0,
                "lights are legal");
    struct scene_solids solids;
    struct error *err = scene_solids(s, &solids, NULL);
    require(!err && solids.closed_count <= solids.count, "pieces are found");
    for (size_t t = 0; t < scene_triangle_count(s); t++)
        require(solids.piece_of[t] < solids.count, "every triangle has a piece");
    scene_solids_clear(&solids);
}

enum {
    FORMAT_OBJ,
    FORMAT_MTL,
    FORMAT_PLY,
    FORMAT_OFF,
    FORMAT_STL,
    FORMAT_PNG,
    FORMAT_HDR,
    FORMAT_GLTF,
    FORMAT_GLB,
    FORMATS
};

static const char *const names[FORMATS] = {"x.obj", "x.mtl", "x.ply",  "x.off", "x.stl",
                                           "x.png", "x.hdr", "x.gltf", "x.glb"};

static void read_scene(const char *name, const char *sky)
{
    struct scene *s = NULL;
    struct warnings warnings = {0};
    struct scene_settings settings = scene_settings_default();
    settings.sky_file = sky ? strdup(files_path(sky)) : NULL;
    struct error *err = scene_read(&s, files_path(name), &settings, true, &warnings);
    require(!err == (s != NULL), "a scene or an error");
    if (s) {
        check_scene(s);
        struct error *decimated = scene_decimate(s, 0.3, NULL);
        require(!decimated, "a scene can be decimated");
        check_scene(s);
    }
    error_destroy(err);
    scene_destroy(s);
    scene_settings_clear(&settings);
    warnings_clear(&warnings);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!*files_directory) {
        files_begin();
        atexit(files_end);
        files_write("fixed.obj",
                    "mtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl a\n"
                    "f 1/1 2/2 3/3\nusemtl b\nf 1/1 3/3 2/2\n");
        files_write(
            "textured.obj",
            "mtllib textured.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl a\n"
            "f 1/1 2/2 3/3\n");
        files_write("textured.mtl", "newmtl a\nmap_Kd x.png\nmap_d x.png\nmap_Ke x.hdr\n");
    }
    if (size == 0)
        return 0;
    const int format = data[0] % FORMATS;
    files_write_bytes(names[format], data + 1, size - 1);
    if (format == FORMAT_MTL)
        read_scene("fixed.obj", NULL);
    else if (format == FORMAT_PNG || format == FORMAT_HDR)
        read_scene("textured.obj", format == FORMAT_HDR ? "x.hdr" : NULL);
    else
        read_scene(names[format], NULL);
    return 0;
}

#ifndef FUZZ_ENGINE

/* -- seeds ------------------------------------------------------------------------------------ */

struct bytes {
    uint8_t data[8192];
    size_t size;
};

static struct bytes seeds[16];
static size_t seed_count;

static void put(struct bytes *to, const void *data, size_t size)
{
    if (to->size + size > sizeof to->data)
        bail("a seed too long");
    memcpy(to->data + to->size, data, size);
    to->size += size;
}

static void put_encoded(void *context, void *data, int size)
{
    put(context, data, (size_t)size);
}

static struct bytes *begin_seed(uint8_t format)
{
    struct bytes *seed = &seeds[seed_count++];
    put(seed, &format, 1);
    return seed;
}

static void add_text(uint8_t format, const char *text)
{
    put(begin_seed(format), text, strlen(text));
}

static void make_seeds(void)
{
    add_text(FORMAT_OBJ,
             "# cube\nmtllib x.mtl\nv 0 0 0 .1 1 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1 9 8 7\nv 1 "
             "0 1\nv 1 1 1\n"
             "v 0 1 1\nvt 0 0\nvt 1 0.5\n"
             "usemtl a\nf 4/1 3/2 2/1 1/2\nf 5 6 7 8\nf -8 -7 -3 -4\nusemtl b\nf 2//1 3//1 7 6\n"
             "f 3 4 8 \\\n7\nf 4 1 5 8\n");
    add_text(FORMAT_MTL,
             "newmtl a\nKd .5 .6 .7\nmap_Kd -s 1 2 -o .5 x.png\nd .5\nnewmtl b\nKe 1 2 3\nTr .2\n"
             "map_d none.png\n");
    add_text(FORMAT_PLY,
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty double y\n"
             "property int z\nproperty uchar red\nproperty uchar green\nproperty float blue\n"
             "property uchar alpha\nelement face 2\n"
             "property list uchar int vertex_indices\nend_header\n0 0 0 1 2 .3 9\n"
             "1 0 0 9 8 .7 6\n0 1 0 1 2 .3 255\n0 0 1 1 2 3 0\n3 0 1 2\n"
             "4 0 1 2 3\n");
    add_text(FORMAT_OFF, "COFF # c\n4 2 0\n0 0 0 1\n1 0 0 .1 .2 .3 .4\n0 1 0 1\n0 0 1 1\n3 0 1 2\n"
                         "4 0 1 2 3 9 9 9\n");
    add_text(FORMAT_OFF,
             "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2 1 0 0\n4 0 1 2 3 9 9 9\n");
    add_text(FORMAT_STL, "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 "
                         "0\nvertex 1 1 0\nendloop\n"
                         "endfacet\nendsolid\n");
    add_text(
        FORMAT_GLTF,
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
        "\"nodes\":[{\"mesh\":0,\"scale\":[1,2,3]}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":0}}]}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,"
        "\"uri\":"
        "\"data:application/"
        "octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}");
    const float stl[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0};
    const uint32_t one = 1;
    struct bytes *seed = begin_seed(FORMAT_STL);
    put(seed, (const uint8_t[80]){0}, 80);
    put(seed, &one, 4);
    put(seed, stl, 48);
    put(seed, "\0\0", 2);
    seed = begin_seed(FORMAT_PLY);
    static const char ply[] =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\n"
        "element face 1\nproperty list uint8 uint vertex_index\nend_header\n";
    put(seed, ply, sizeof ply - 1);
    put(seed, stl + 3, 36);
    put(seed, "\3", 1);
    put(seed, (const uint32_t[]){0, 1, 2}, 12);
    uint8_t codes[16 * 4 * 4];
    float radiance[16 * 4 * 3];
    for (size_t i = 0; i < sizeof codes; i++)
        codes[i] = (uint8_t)(i * 7);
    for (int i = 0; i < 16 * 4 * 3; i++)
        radiance[i] = (float)(i / 24);
    stbi_write_png_to_func(put_encoded, begin_seed(FORMAT_PNG), 16, 4, 4, codes, 64);
    stbi_write_jpg_to_func(put_encoded, begin_seed(FORMAT_PNG), 16, 4, 4, codes, 90);
    stbi_write_hdr_to_func(put_encoded, begin_seed(FORMAT_HDR), 8, 4, 3, radiance);
}

/* -- mutation --------------------------------------------------------------------------------- */

static uint64_t state;

static size_t number_below(size_t n)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (size_t)((state >> 16) % n);
}

/* Changes a few places: a bit, a byte, a number in the text, a piece cut out, doubled, or copied
 * from elsewhere. */
static void mutate(struct bytes *b)
{
    static const char *const words[] = {"-1",  "0",          "4294967295",  "1e999",
                                        "nan", "2147483648", "-9999999999", "",
                                        " ",   "\n",         "#",           "/"};
    for (size_t times = 1 + number_below(4); times > 0 && b->size > 1; times--) {
        const size_t at = 1 + number_below(b->size - 1), length = 1 + number_below(16);
        const size_t piece = length < b->size - at ? length : b->size - at;
        const char *word = words[number_below(sizeof words / sizeof *words)];
        switch (number_below(6)) {
        case 0: b->data[at] ^= (uint8_t)(1u << number_below(8)); break;
        case 1: b->data[at] = (uint8_t)number_below(256); break;
        case 2: /* cut out */
            memmove(b->data + at, b->data + at + piece, b->size - at - piece);
            b->size -= piece;
            break;
        case 3: /* cut off */ b->size = number_below(8) ? b->size : at; break;
        case 4: /* a word in place of what is there */
            memcpy(b->data + at, word, strlen(word) < piece ? strlen(word) : piece);
            break;
        default: /* double */
            if (b->size + piece <= sizeof b->data) {
                memmove(b->data + at + piece, b->data + at, b->size - at);
                b->size += piece;
            }
        }
    }
}

int main(int argc, char **argv)
{
    const unsigned long mutations = argc > 1 ? strtoul(argv[1], NULL, 10) : tap_cases(4000);
    state = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    state = state * 0x9E3779B97F4A7C15u + 88172645463325252u;
    make_seeds();
    for (size_t i = 0; i < seed_count; i++)
        LLVMFuzzerTestOneInput(seeds[i].data, seeds[i].size);
    for (unsigned long i = 0; i < mutations; i++) {
        struct bytes b = seeds[i % seed_count];
        mutate(&b);
        LLVMFuzzerTestOneInput(b.data, b.size);
    }
    ok(true, "%lu mutated files of %zu were read or refused", mutations, seed_count);
    return tap_done();
}

#endif
