/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/sight_key.h"
#include "base/error.h"
#include "base/warning.h"
#include "math/hash.h"
#include "stream/cells.h"
#include "stream/stream.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { DIGITS = 24 };

static void print_key(char text[DIGITS], uint64_t key)
{
    snprintf(text, DIGITS, "%016" PRIx64, key);
}

/* Where all probes stand, and which make each cell. */
static uint64_t key_of_cells(const struct table *probes, const struct cells *cells)
{
    struct hash hash;
    const uint64_t shape[] = {probes->rows, cells->table->rows, (uint64_t)cells->corners};
    hash_start(&hash, 0);
    hash_add(&hash, shape, sizeof shape);
    hash_add(&hash, column_f64(table_column(probes, "position")),
             3 * probes->rows * sizeof(double));
    hash_add(&hash, cells->vertex,
             (size_t)cells->corners * cells->table->rows * sizeof *cells->vertex);
    return hash_value(&hash);
}

struct error *sight_key_set(struct stream *stream, uint64_t surfaces)
{
    char text[DIGITS];
    struct cells cells = {0};
    const struct table *probes = stream_table(stream, "probe");
    sight_key_remove(&stream->header);
    struct error *err = probes && cells_exist(stream) ? cells_find(stream, &cells) : NULL;
    if (err || !cells.sight)
        return err;
    print_key(text, surfaces);
    err = header_set_key(&stream->header, CELLS_SIGHT_SCENE, text);
    print_key(text, key_of_cells(probes, &cells));
    return err ? err : header_set_key(&stream->header, CELLS_SIGHT_CELLS, text);
}

void sight_key_remove(struct stream_header *header)
{
    header_remove_key(header, CELLS_SIGHT_SCENE);
    header_remove_key(header, CELLS_SIGHT_CELLS);
}

bool sight_key_is(const char *name)
{
    return !strcmp(name, CELLS_SIGHT_SCENE) || !strcmp(name, CELLS_SIGHT_CELLS);
}

bool sight_key_other_scene(const struct stream_header *header, uint64_t surfaces)
{
    char text[DIGITS];
    const char *stated = header_key(header, CELLS_SIGHT_SCENE);
    print_key(text, surfaces);
    return stated && strcmp(stated, text);
}

struct error *sight_drop_stale(struct stream *stream, struct warnings *warnings)
{
    char text[DIGITS];
    struct cells cells = {0};
    const struct table *probes = stream_table(stream, "probe");
    const char *stated = header_key(&stream->header, CELLS_SIGHT_CELLS);
    struct error *err = stated && probes && cells_exist(stream) ? cells_find(stream, &cells) : NULL;
    if (err || !cells.sight)
        return err;
    print_key(text, key_of_cells(probes, &cells));
    if (!strcmp(stated, text))
        return NULL;
    sight_key_remove(&stream->header);
    char list[] = SIGHT_COLUMNS, *rest = list;
    for (char *name = strsep(&rest, ","); name; name = strsep(&rest, ","))
        table_remove_column(cells.table, name);
    warnings_add(warnings, "sight",
                 "what cells keep of what their points see is of other probes or cells: left out "
                 "(probe-leakfix looks anew)");
    return NULL;
}

void sight_warn_other_scene(const struct stream *stream, uint64_t surfaces, const char *path,
                            struct warnings *warnings)
{
    bool sees = false;
    for (size_t i = 0; i < stream->table_count; i++)
        sees = sees || (stream_cell_corners(stream->tables[i].name) &&
                        table_column(&stream->tables[i], "sight"));
    if (sees && sight_key_other_scene(&stream->header, surfaces))
        warnings_add(warnings, "sight",
                     "%s: what cells keep of what their points see is of other surfaces "
                     "(probe-leakfix looks anew)",
                     path);
}
