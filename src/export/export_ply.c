/* SPDX-License-Identifier: Apache-2.0 */
/* PLY (Turk, "The PLY polygon file format", 1994), binary and little-endian: one mesh, with colours
 * of 8 bits, which programs take for codes of a screen. */
#include "export/export_mesh.h"
#include "base/error.h"
#include "base/file.h"
#include "image/display.h"

#include <stdio.h>
#include <string.h>

static void put_word(char *to, uint32_t word)
{
    for (int k = 0; k < 4; k++)
        to[k] = (char)(word >> 8 * k);
}

static void put_floats(char *to, const float value[3])
{
    for (int k = 0; k < 3; k++) {
        uint32_t word;
        memcpy(&word, &value[k], sizeof word);
        put_word(to + 4 * k, word);
    }
}

static struct error *write_head(struct file_output *out, const struct export_mesh *mesh)
{
    char text[512];
    const int size =
        snprintf(text, sizeof text,
                 "ply\nformat binary_little_endian 1.0\ncomment probe-export scale %.9g\n"
                 "element vertex %zu\nproperty float x\nproperty float y\nproperty float z\n"
                 "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n"
                 "property uchar green\nproperty uchar blue\nelement face %zu\n"
                 "property list uchar uint vertex_indices\nend_header\n",
                 mesh->scale, mesh->vertices, mesh->triangles);
    return file_output_write(out, text, (size_t)size);
}

static struct error *write_vertices(struct file_output *out, const struct export_mesh *mesh)
{
    enum { BYTES = 27 };
    struct error *err = NULL;
    for (size_t i = 0; i < mesh->vertices && !err; i++) {
        char *to;
        err = file_output_room(out, BYTES, &to);
        if (err)
            break;
        put_floats(to, mesh->position + 3 * i);
        put_floats(to + 12, mesh->normal + 3 * i);
        for (size_t k = 0; k < 3; k++)
            to[24 + k] = (char)display_code((double)mesh->colour[3 * i + k]);
        out->count += BYTES;
        err = file_output_flush(out, false);
    }
    return err;
}

static struct error *write_faces(struct file_output *out, const struct export_mesh *mesh)
{
    enum { BYTES = 13 };
    struct error *err = NULL;
    for (size_t p = 0; p < mesh->parts; p++) {
        const struct export_part *part = &mesh->part[p];
        for (size_t i = 0; i < part->triangles && !err; i++) {
            const uint32_t *index = mesh->index + 3 * (part->triangle + i);
            char *to;
            err = file_output_room(out, BYTES, &to);
            if (err)
                break;
            to[0] = 3;
            for (size_t c = 0; c < 3; c++)
                put_word(to + 1 + 4 * c, (uint32_t)part->vertex + index[c]);
            out->count += BYTES;
            err = file_output_flush(out, false);
        }
    }
    return err;
}

struct error *export_ply(const struct export_mesh *mesh, const char *path)
{
    struct file_output out;
    struct error *err = file_output_open(&out, path, true);
    if (err)
        return err;
    err = write_head(&out, mesh);
    if (!err)
        err = write_vertices(&out, mesh);
    if (!err)
        err = write_faces(&out, mesh);
    if (!err)
        return file_output_finish(&out);
    file_output_abandon(&out);
    return err;
}
