/* SPDX-License-Identifier: Apache-2.0 */
/* Packed files: what a stream's probes hold of light, for libprobe-query. */
#include "base/array.h"
#include "base/error.h"
#include "interpolate/interpolate.h"
#include "interpolate/interpolate_kind.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GROUPS_MOST = 4096 }; /* of a packed file */

/* The groups of a packed file, as probe_groups has them, and what of them is owned. */
struct groups {
    size_t count, name_capacity, sh_capacity, copy_capacity;
    char **name;      /* owned, and what they point to */
    const float **sh; /* owned */
    float **copy;     /* owned, and what they point to: sh, where it is no column; else NULL */
};

static void clear_groups(struct groups *g)
{
    for (size_t i = 0; i < g->count; i++) {
        free(g->name[i]);
        free(g->copy[i]);
    }
    free(g->name);
    free(g->sh);
    free(g->copy);
}

/* Takes name (NULL: there was no memory for it) and copy (NULL: sh is a column), on error too. */
static struct error *add_group(struct groups *g, char *name, const float *sh, float *copy)
{
    struct error *err = name ? NULL : error_memory();
    if (!err)
        err = array_reserve(&g->name, &g->name_capacity, g->count + 1, sizeof *g->name);
    if (!err)
        err = array_reserve(&g->sh, &g->sh_capacity, g->count + 1, sizeof *g->sh);
    if (!err)
        err = array_reserve(&g->copy, &g->copy_capacity, g->count + 1, sizeof *g->copy);
    if (err) {
        free(name);
        free(copy);
        return err;
    }
    g->name[g->count] = name;
    g->sh[g->count] = sh;
    g->copy[g->count++] = copy;
    return NULL;
}

/* Each block of a transfer is what a group is: light that a weight multiplies. Skies are numbered
 * from 0, as SH are, suns from 1, as their header keys. */
static struct error *add_blocks(struct groups *g, const struct column *column,
                                const struct light_column *what, size_t rows)
{
    const size_t first = !!strcmp(column->name, "transfer_sky");
    struct error *err = NULL;
    for (size_t b = 0; b < what->blocks && !err; b++) {
        float *copy = NULL;
        char *name = NULL;
        err = array_create(&copy, rows * what->block, sizeof *copy);
        for (size_t i = 0; i < rows && !err; i++)
            memcpy(copy + i * what->block, column_f32(column) + i * column->width + b * what->block,
                   what->block * sizeof *copy);
        if (!err && asprintf(&name, "%s_%zu", column->name, first + b) < 0)
            name = NULL;
        if (!err)
            err = add_group(g, name, copy, copy);
    }
    return err;
}

/* In the order of the columns, groups before transfers. Without groups all light is one, rest, as
 * for probe-relight. */
static struct error *find_groups(struct groups *g, const struct table *probes, unsigned parts)
{
    const struct column *sh = table_column(probes, "sh");
    struct light_column what;
    struct error *err = NULL;
    for (size_t i = 0; i < probes->column_count && !err; i++) {
        const struct column *column = &probes->columns[i];
        if (light_column_of(column, sh->width, &what) && what.group && !what.surface &&
            what.role == LIGHT_VALUE)
            err = add_group(g, strdup(column->name + strlen("sh_")), column_f32(column), NULL);
    }
    if (!err && !g->count && parts & INTERPOLATE_GROUPS)
        err = error_new("the probes have no groups of lights (no column sh_NAME): run "
                        "probe-capture --groups");
    if (!err && !g->count)
        err = add_group(g, strdup("rest"), column_f32(sh), NULL);
    const size_t lights = g->count;
    for (size_t i = 0; i < probes->column_count && !err && parts & INTERPOLATE_TRANSFER; i++) {
        const struct column *column = &probes->columns[i];
        if (light_column_of(column, sh->width, &what) && what.transfer && what.channels == 3 &&
            what.role == LIGHT_VALUE)
            err = add_blocks(g, column, &what, probes->rows);
    }
    if (!err && parts & INTERPOLATE_TRANSFER && g->count == lights)
        err = error_new("the probes have no transfer (no column transfer_sky, _suns or _points): "
                        "run probe-capture --transfer");
    if (!err && g->count > GROUPS_MOST)
        err = error_new("a packed file has %d groups of lights and blocks of transfers at the "
                        "most, got %zu",
                        GROUPS_MOST, g->count);
    return err;
}

struct error *interpolate_pack(const struct interpolate *in, enum probe_packing packing,
                               unsigned parts, size_t *size, void *image)
{
    struct groups g = {0};
    struct error *err = NULL;
    if (parts && !in->stream)
        return error_new("a packed file with groups of lights is made of a stream");
    if (parts && in->settings.kind->pack)
        return error_new("discs are packed without groups of lights");
    if (in->settings.kind->pack)
        return in->settings.kind->pack(in, packing, size, image);
    if (parts)
        err = find_groups(&g, stream_table(in->stream, "probe"), parts);
    if (!err) {
        const struct probe_groups groups = {g.count, (const char *const *)g.name, g.sh};
        *size = probe_volume_pack_groups(in->volume, in->order, in->value, in->convolved, packing,
                                         &groups, image, *size);
    }
    if (!err && !*size)
        err = error_new("some probes have no light: run probe-capture");
    clear_groups(&g);
    return err;
}
