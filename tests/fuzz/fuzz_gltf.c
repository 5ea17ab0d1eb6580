/* SPDX-License-Identifier: Apache-2.0 */
/* A hostile glTF file: as tests/fuzz_scene.c, which holds the target (LLVMFuzzerTestOneInput) and
 * what a scene that was read must be like, but with a seed that uses all that the importer reads,
 * and mutations that know JSON.
 *
 *     fuzz_gltf [MUTATIONS [SEED]]      part of make check with few mutations;
 *                                       for longer: fuzz_gltf 1000000
 */
#include "base/error.h"
#include "import/import_scene.h"
#include "scene/scene.h"
#include "support/files.h"
#include "support/tap.h"

#include <stb_image_write.h>
#include <stdint.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { FORMAT_GLTF = 7, FORMAT_GLB = 8 }; /* the target's first byte */

struct bytes {
    uint8_t data[1 << 14];
    size_t size;
};

/* Appends as much as there is room for. */
static void put(struct bytes *to, const void *data, size_t size)
{
    const size_t room = sizeof to->data - to->size, count = size < room ? size : room;
    memcpy(to->data + to->size, data, count);
    to->size += count;
}

static void put_text(struct bytes *to, const char *text)
{
    put(to, text, strlen(text));
}

static void put_encoded(void *context, void *data, int size)
{
    put(context, data, (size_t)size);
}

/* -- the seed --------------------------------------------------------------------------------- */

/* The buffer: 4 vertices of 16 bytes with a stride, 8 texture coordinates, indices, a sparse
 * accessor's, 2 instances, then a picture. */
static struct bytes make_buffer(size_t *picture_size)
{
    static const float vertex[16] = {0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0, 9, 1, 1, 1, 9};
    static const float uv[16] = {0, 0, 1, 0, 0, 1, 1, 1, 0.5f, 0, 1, 0.5f, 0, 1, 2, -1};
    static const uint16_t index[8] = {0, 1, 2, 2, 1, 3, 0, 3};
    static const float moved[6] = {0, 0, 2, 1, 0, 2}, instance[6] = {5, 0, 0, 0, 5, 0};
    struct bytes out = {.size = 0};
    uint8_t texels[16];
    for (size_t i = 0; i < sizeof texels; i++)
        texels[i] = (uint8_t)(i * 37);
    put(&out, vertex, sizeof vertex);
    put(&out, uv, sizeof uv);
    put(&out, index, sizeof index);
    put(&out, moved, sizeof moved);
    put(&out, instance, sizeof instance);
    const size_t before = out.size;
    stbi_write_png_to_func(put_encoded, &out, 2, 2, 4, texels, 8);
    *picture_size = out.size - before;
    put(&out, "\0\0\0", (4 - out.size % 4) % 4);
    return out;
}

static void put_base64(struct bytes *to, const struct bytes *from)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < from->size; i += 3) {
        uint32_t three = 0;
        for (size_t k = i; k < i + 3; k++)
            three = three << 8 | (k < from->size ? from->data[k] : 0);
        const char four[4] = {digits[three >> 18], digits[three >> 12 & 63],
                              i + 1 < from->size ? digits[three >> 6 & 63] : '=',
                              i + 2 < from->size ? digits[three & 63] : '='};
        put(to, four, 4);
    }
}

/* The JSON, written with ' for "; with the buffer in it, or for a GLB, which has it behind. */
static struct bytes make_json(const struct bytes *buffer, size_t picture_size, bool with_buffer)
{
    static const char head[] =
        "{'asset':{'version':'2.0'},'scene':0,'scenes':[{'nodes':[0,2,3,4]}],"
        "'extensionsRequired':['KHR_lights_punctual','KHR_texture_transform'],"
        "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':3,'color':[1,0."
        "5,0],'range':4},"
        "{'type':'spot','spot':{'innerConeAngle':0.2,'outerConeAngle':0.7}},{'type':'directional'}]"
        "}},"
        "'nodes':[{'children':[1],'matrix':[-1,0,0,0,0,2,0,0,0,0,1,0,3,4,5,1]},"
        "{'mesh':0,'translation':[1,2,3],'rotation':[0,0.6,0,0.8],'scale':[1,-2,3],"
        "'extensions':{'KHR_lights_punctual':{'light':0}}},"
        "{'mesh':1,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':5}},"
        "'KHR_lights_punctual':{'light':1}}},"
        "{'mesh':0,'skin':0,'extensions':{'KHR_node_visibility':{'visible':true},'KHR_lights_"
        "punctual':{'light':2}}},"
        "{'mesh':2}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':1,'TEXCOORD_1':2},'"
        "indices':3,'material':0},"
        "{'attributes':{'POSITION':4},'material':1,'mode':5}]},"
        "{'primitives':[{'attributes':{'POSITION':0},'mode':6,'targets':[{'POSITION':0}]}]},"
        "{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':0,'TEXCOORD_0':1},'indices':3,'mode':"
        "5,'material':2}]}],"
        "'materials':[{'name':'a','alphaMode':'MASK','alphaCutoff':0.3,'emissiveFactor':[1,0.5,0],'"
        "emissiveTexture':"
        "{'index':1,'texCoord':1},'extensions':{'KHR_materials_emissive_strength':{'"
        "emissiveStrength':8}},"
        "'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.6,0.7,0.8],'baseColorTexture':{'index':0,"
        "'extensions':"
        "{'KHR_texture_transform':{'offset':[0.1,0.2],'rotation':0.3,'scale':[2,3],'texCoord':1}}}}"
        "},"
        "{'alphaMode':'BLEND','extensions':{'KHR_materials_unlit':{},'KHR_materials_"
        "pbrSpecularGlossiness':"
        "{'diffuseFactor':[0.1,0.2,0.3,0.4],'diffuseTexture':{'index':1}}}},"
        "{'pbrMetallicRoughness':{'baseColorTexture':{'index':1}}}],"
        "'textures':[{'source':0,'sampler':0},{'source':7,'extensions':{'EXT_texture_webp':{'"
        "source':0}}}],"
        "'samplers':[{'wrapS':33071,'wrapT':33648,'magFilter':9728}],"
        "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"
        "{'bufferView':1,'componentType':5126,'count':4,'type':'VEC2'},"
        "{'bufferView':1,'byteOffset':32,'componentType':5126,'count':4,'type':'VEC2'},"
        "{'bufferView':2,'componentType':5123,'count':6,'type':'SCALAR'},"
        "{'componentType':5126,'count':4,'type':'VEC3','sparse':{'count':2,'indices':{'bufferView':"
        "2,'byteOffset':2,"
        "'componentType':5123},'values':{'bufferView':3}}},"
        "{'bufferView':4,'componentType':5126,'count':2,'type':'VEC3'}],"
        "'bufferViews':[{'buffer':0,'byteLength':64,'byteStride':16},{'buffer':0,'byteOffset':64,'"
        "byteLength':64},"
        "{'buffer':0,'byteOffset':128,'byteLength':16},{'buffer':0,'byteOffset':144,'byteLength':"
        "24},"
        "{'buffer':0,'byteOffset':168,'byteLength':24},{'buffer':0,'byteOffset':192,'byteLength':%"
        "zu}],"
        "'images':[{'bufferView':5,'mimeType':'image/png'}],'buffers':[{'byteLength':%zu";
    struct bytes out = {.size = 0};
    char text[sizeof head + 64];
    snprintf(text, sizeof text, head, picture_size, buffer->size);
    put_text(&out, text);
    if (with_buffer) {
        put_text(&out, ",'uri':'data:application/octet-stream;base64,");
        put_base64(&out, buffer);
        put_text(&out, "'");
    }
    put_text(&out, "}]}");
    for (size_t i = 0; i < out.size; i++)
        if (out.data[i] == '\'')
            out.data[i] = '"';
    return out;
}

static void put_word(struct bytes *to, size_t word)
{
    const uint8_t bytes[4] = {(uint8_t)word, (uint8_t)(word >> 8), (uint8_t)(word >> 16),
                              (uint8_t)(word >> 24)};
    put(to, bytes, 4);
}

/* What the target takes: the format, then the file. */
static struct bytes pack(const struct bytes *json, const struct bytes *buffer)
{
    struct bytes out = {.size = 0};
    put(&out, &(uint8_t){buffer ? FORMAT_GLB : FORMAT_GLTF}, 1);
    if (buffer) {
        const size_t padding = (4 - json->size % 4) % 4, text = json->size + padding;
        put_text(&out, "glTF");
        put_word(&out, 2);
        put_word(&out, 12 + 8 + text + 8 + buffer->size);
        put_word(&out, text);
        put_text(&out, "JSON");
        put(&out, json->data, json->size);
        put(&out, "   ", padding);
        put_word(&out, buffer->size);
        put(&out, "BIN", 4);
        put(&out, buffer->data, buffer->size);
    } else {
        put(&out, json->data, json->size);
    }
    return out;
}

/* A seed that is refused would try nothing. */
static void expect_read(const char *name, const struct bytes *file)
{
    struct scene *s = NULL;
    files_begin();
    files_write_bytes(name, file->data + 1, file->size - 1);
    struct error *err = scene_read(&s, files_path(name), NULL, false, NULL);
    ok(!err && scene_triangle_count(s) == 14 && s->light_count == 3 && s->instance_count == 5 &&
           s->texture_count == 2,
       "the seed %s is read%s%s", name, err ? ": " : "", err ? error_message(err) : "");
    error_destroy(err);
    scene_destroy(s);
    files_end();
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

/* A piece of the text: data[at..at + size). */
struct piece {
    size_t at, size;
};

/* Some piece that begins with one of these characters and ends where `length` says; nothing when
 * there is none. */
static struct piece find_piece(const struct bytes *b, const char *first,
                               size_t (*length)(const char *text, size_t room))
{
    const size_t start = number_below(b->size);
    for (size_t i = 0; i < b->size; i++) {
        const size_t at = (start + i) % b->size;
        if (b->data[at] && strchr(first, b->data[at]))
            return (struct piece){at, length((const char *)b->data + at, b->size - at)};
    }
    return (struct piece){0, 0};
}

static size_t number_length(const char *text, size_t room)
{
    size_t n = 0;
    while (n < room && text[n] && strchr("-+.eE0123456789", text[n]))
        n++;
    return n;
}

/* A word in quotes, with them. */
static size_t word_length(const char *text, size_t room)
{
    const char *const end = memchr(text + 1, '"', room - 1);
    return end ? (size_t)(end - text) + 1 : room;
}

/* An object or list, with its brackets. */
static size_t group_length(const char *text, size_t room)
{
    size_t n = 0;
    int depth = 0;
    do {
        depth += text[n] == '{' || text[n] == '[' ? 1 : text[n] == '}' || text[n] == ']' ? -1 : 0;
        n++;
    } while (n < room && depth > 0);
    return n;
}

/* Puts `size` bytes in place of a piece, if there is room. */
static void replace(struct bytes *b, struct piece p, const void *with, size_t size)
{
    char copy[sizeof b->data];
    if (b->size - p.size + size > sizeof b->data)
        return;
    memcpy(copy, with, size); /* it may be a part of what is moved */
    memmove(b->data + p.at + size, b->data + p.at + p.size, b->size - p.at - p.size);
    memcpy(b->data + p.at, copy, size);
    b->size = b->size - p.size + size;
}

static void mutate_json(struct bytes *b)
{
    static const char *const numbers[] = {"0",
                                          "1",
                                          "2",
                                          "3",
                                          "4",
                                          "5",
                                          "6",
                                          "-1",
                                          "-0.5",
                                          "1e30",
                                          "1e-310",
                                          "-1e308",
                                          "255",
                                          "256",
                                          "65535",
                                          "2147483647",
                                          "2147483648",
                                          "4294967295",
                                          "4294967297",
                                          "9223372036854775807",
                                          "18446744073709551615",
                                          "18446744073709551600",
                                          "5120",
                                          "5121",
                                          "5122",
                                          "5123",
                                          "5124",
                                          "5125",
                                          "5126",
                                          "5130",
                                          "16",
                                          "252",
                                          "1000000",
                                          "null",
                                          "true",
                                          "\"x\"",
                                          "{}",
                                          "[]",
                                          "[1,2,3]"};
    const size_t kind = number_below(8);
    const char *const first = kind < 4 ? "-0123456789" : kind < 6 ? "\"" : "{[";
    size_t (*const length)(const char *, size_t) = kind < 4   ? number_length
                                                   : kind < 6 ? word_length
                                                              : group_length;
    const struct piece a = find_piece(b, first, length), other = find_piece(b, first, length);
    const char *const number = numbers[number_below(sizeof numbers / sizeof *numbers)];
    if (kind < 3 || (kind < 5 && number_below(4) == 0))
        replace(b, a, number, strlen(number));
    else if (kind < 7) /* another piece of its kind */
        replace(b, a, b->data + other.at, other.size);
    else
        replace(b, a, "{}", number_below(2) ? 2 : 0);
}

static void mutate_bytes(struct bytes *b)
{
    if (b->size < 2)
        return;
    const size_t at = 1 + number_below(b->size - 1);
    if (number_below(8) == 0)
        b->size = at;
    else if (number_below(2))
        b->data[at] ^= (uint8_t)(1u << number_below(8));
    else
        b->data[at] = (uint8_t)number_below(256);
}

int main(int argc, char **argv)
{
    const unsigned long mutations = argc > 1 ? strtoul(argv[1], NULL, 10) : tap_cases(3000);
    state = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    state = state * 0x9E3779B97F4A7C15u + 88172645463325252u;
    size_t picture_size;
    const struct bytes buffer = make_buffer(&picture_size);
    const struct bytes seeds[2] = {make_json(&buffer, picture_size, true),
                                   make_json(&buffer, picture_size, false)};
    const struct bytes sound = pack(&seeds[0], NULL), sound_glb = pack(&seeds[1], &buffer);
    expect_read("x.gltf", &sound);
    expect_read("x.glb", &sound_glb);
    for (unsigned long i = 0; i < mutations; i++) {
        struct bytes json = seeds[i % 2], body = buffer;
        for (size_t times = number_below(6); times > 0 && json.size > 1; times--)
            mutate_json(&json);
        for (size_t times = number_below(3); times > 0; times--)
            mutate_bytes(&body);
        struct bytes file = pack(&json, i % 2 ? &body : NULL);
        if (number_below(8) == 0)
            mutate_bytes(&file);
        LLVMFuzzerTestOneInput(file.data, file.size);
    }
    ok(true, "%lu mutated files were read or refused", mutations);
    return tap_done();
}
