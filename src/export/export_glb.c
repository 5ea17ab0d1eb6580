/* SPDX-License-Identifier: Apache-2.0 */
/* Binary glTF 2.0 (the Khronos Group's specification, 4.4): a header, a chunk of JSON, a chunk of
 * arrays. There are three arrays of vertices and one of indices for all parts, a view each. */
#include "export/export_mesh.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/number.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of the specification. */
enum {
    MAGIC = 0x46546c67,
    VERSION = 2,
    JSON = 0x4e4f534a,
    BIN = 0x004e4942,
    FLOAT = 5126,
    UNSIGNED_INT = 5125,
    ARRAY = 34962,
    ELEMENTS = 34963,
};

enum { VIEWS = 4, OF_PART = 4 /* accessors: position, normal, colour, indices */ };

static void put_float(FILE *out, float value)
{
    char text[NUMBER_ROOM];
    fwrite(text, 1, (size_t)(number_write_f32(text, value) - text), out);
}

/* "name":[x,y,z] of the least, or the greatest, positions of a part. */
static void put_bound(FILE *out, const struct export_mesh *mesh, const struct export_part *part,
                      const char *name, float sign)
{
    fprintf(out, ",\"%s\":[", name);
    for (size_t k = 0; k < 3; k++) {
        const float *p = mesh->position + 3 * part->vertex + k;
        float most = sign * *p;
        for (size_t i = 1; i < part->vertices; i++)
            most = sign * p[3 * i] > most ? sign * p[3 * i] : most;
        fputs(k ? "," : "", out);
        put_float(out, sign * most);
    }
    fputc(']', out);
}

static void put_accessors(FILE *out, const struct export_mesh *mesh, size_t number)
{
    const struct export_part *part = &mesh->part[number];
    for (int view = 0; view < VIEWS; view++) {
        const bool index = view == VIEWS - 1;
        fprintf(out,
                "%s{\"bufferView\":%d,\"byteOffset\":%zu,\"componentType\":%d,\"count\":%zu,"
                "\"type\":\"%s\"",
                number || view ? "," : "", view, 12 * (index ? part->triangle : part->vertex),
                index ? UNSIGNED_INT : FLOAT, index ? 3 * part->triangles : part->vertices,
                index ? "SCALAR" : "VEC3");
        if (!view) {
            put_bound(out, mesh, part, "min", -1);
            put_bound(out, mesh, part, "max", 1);
        }
        fputc('}', out);
    }
}

static void put_name(FILE *out, const struct export_part *part)
{
    if (part->instance < 0)
        fputs("\"surface\"", out);
    else
        fprintf(out, "\"instance %d\"", (int)part->instance);
}

static void put_views(FILE *out, const struct export_mesh *mesh)
{
    const size_t vertices = 12 * mesh->vertices, triangles = 12 * mesh->triangles;
    fprintf(out, "\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[", 3 * vertices + triangles);
    for (int view = 0; view < VIEWS - 1; view++)
        fprintf(out,
                "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":12,"
                "\"target\":%d},",
                (size_t)view * vertices, vertices, ARRAY);
    fprintf(out, "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":%d}]",
            3 * vertices, triangles, ELEMENTS);
}

static void put_json(FILE *out, const struct export_mesh *mesh)
{
    fputs("{\"asset\":{\"version\":\"2.0\",\"generator\":\"probe-export\",\"extras\":{\"scale\":",
          out);
    put_float(out, (float)mesh->scale);
    fputs("}},\"extensionsUsed\":[\"KHR_materials_unlit\"],\"scene\":0,\"scenes\":[{\"nodes\":[",
          out);
    for (size_t i = 0; i < mesh->parts; i++)
        fprintf(out, "%s%zu", i ? "," : "", i);
    fputs("]}],\"nodes\":[", out);
    for (size_t i = 0; i < mesh->parts; i++) {
        fprintf(out, "%s{\"mesh\":%zu,\"name\":", i ? "," : "", i);
        put_name(out, &mesh->part[i]);
        fputc('}', out);
    }
    fputs("],\"meshes\":[", out);
    for (size_t i = 0; i < mesh->parts; i++) {
        fprintf(out, "%s{\"name\":", i ? "," : "");
        put_name(out, &mesh->part[i]);
        fprintf(out,
                ",\"primitives\":[{\"attributes\":{\"POSITION\":%zu,\"NORMAL\":%zu,"
                "\"COLOR_0\":%zu},\"indices\":%zu,\"material\":0}]}",
                OF_PART * i, OF_PART * i + 1, OF_PART * i + 2, OF_PART * i + 3);
    }
    fputs("],\"accessors\":[", out);
    for (size_t i = 0; i < mesh->parts; i++)
        put_accessors(out, mesh, i);
    fprintf(out,
            "],\"materials\":[{\"name\":\"baked\",\"doubleSided\":%s,\"pbrMetallicRoughness\":"
            "{\"metallicFactor\":0},\"extensions\":{\"KHR_materials_unlit\":{}}}],",
            mesh->both ? "false" : "true");
    put_views(out, mesh);
    fputc('}', out);
}

static struct error *make_json(const struct export_mesh *mesh, char **text, size_t *size)
{
    FILE *out = open_memstream(text, size);
    if (!out)
        return error_memory();
    put_json(out, mesh);
    for (long end = ftell(out); end % 4; end++)
        fputc(' ', out);
    const bool failed = ferror(out);
    return fclose(out) || failed ? error_memory() : NULL;
}

/* Little-endian words; floats have the same bytes there. */
static struct error *write_words(struct file_output *out, const void *words, size_t count)
{
    struct error *err = NULL;
    const unsigned char *from = words;
    for (size_t i = 0; i < count && !err; i++) {
        uint32_t word;
        char *room;
        memcpy(&word, from + 4 * i, sizeof word);
        err = file_output_room(out, 4, &room);
        for (int k = 0; k < 4 && !err; k++)
            room[k] = (char)(word >> 8 * k);
        if (!err) {
            out->count += 4;
            err = file_output_flush(out, false);
        }
    }
    return err;
}

static struct error *write_arrays(struct file_output *out, const struct export_mesh *mesh)
{
    struct error *err = write_words(out, mesh->position, 3 * mesh->vertices);
    if (!err)
        err = write_words(out, mesh->normal, 3 * mesh->vertices);
    if (!err)
        err = write_words(out, mesh->colour, 3 * mesh->vertices);
    return err ? err : write_words(out, mesh->index, 3 * mesh->triangles);
}

struct error *export_glb(const struct export_mesh *mesh, const char *path)
{
    const size_t arrays = 36 * mesh->vertices + 12 * mesh->triangles;
    struct file_output out;
    char *json = NULL;
    size_t size = 0;
    struct error *err = make_json(mesh, &json, &size);
    const uint64_t all = 12 + 8 + (uint64_t)size + 8 + arrays;
    if (!err && all > UINT32_MAX)
        err = error_new("a GLB of %llu bytes: expected less than 4 GiB", (unsigned long long)all);
    if (!err)
        err = file_output_open(&out, path, true);
    if (err) {
        free(json);
        return err;
    }
    const uint32_t head[] = {MAGIC, VERSION, (uint32_t)all, (uint32_t)size, JSON},
                   chunk[] = {(uint32_t)arrays, BIN};
    err = write_words(&out, head, 5);
    if (!err)
        err = file_output_write(&out, json, size);
    if (!err)
        err = write_words(&out, chunk, 2);
    if (!err)
        err = write_arrays(&out, mesh);
    free(json);
    if (!err)
        return file_output_finish(&out);
    file_output_abandon(&out);
    return err;
}
