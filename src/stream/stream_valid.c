/* SPDX-License-Identifier: Apache-2.0 */
/* What every stream must satisfy (man probe.5, "Validity"). */
#include "base/error.h"
#include "libprobe-query/sh.h"
#include "stream/header_number.h"
#include "stream/light_columns.h"
#include "stream/stream_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Columns with a fixed meaning: all that man probe.5 has. */
enum { ANY = STREAM_ROW_MOST };
static const struct known {
    const char *table, *column;
    enum column_type type;
    size_t width;    /* 0: follows `sh`; ANY: as it is */
    size_t of_order; /* so many times n^2 for SH of order n */
} known_columns[] = {
    {"probe", "position", COLUMN_F64, 3, 0},
    {"probe", "sh", COLUMN_F32, 0, 3},
    {"probe", "sh_error", COLUMN_F32, 0, 3},
    {"probe", "sh_gradient", COLUMN_F32, 0, 9},
    {"probe", "visibility", COLUMN_F32, 0, 1},
    {"probe", "irradiance", COLUMN_F32, 3, 0},
    {"probe", "irradiance_error", COLUMN_F32, 3, 0},
    {"probe", "rays", COLUMN_I32, 1, 0},
    {"probe", "inside", COLUMN_I32, 1, 0},
    {"probe", "validity", COLUMN_F32, 1, 0},
    {"probe", "depth", COLUMN_F32, 1, 0},
    {"probe", "sky", COLUMN_F32, 1, 0},
    {"probe", "ao", COLUMN_F32, 1, 0},
    {"probe", "radius", COLUMN_F32, 1, 0},
    {"probe", "area", COLUMN_F32, 1, 0},
    {"probe", "albedo", COLUMN_F32, 3, 0},
    {"probe", "normal", COLUMN_F32, 3, 0},
    {"probe", "bent_normal", COLUMN_F32, 3, 0},
    {"probe", "bent_length", COLUMN_F32, 1, 0},
    {"probe", "cone", COLUMN_F32, 4, 0},
    {"probe", "ao_bounced", COLUMN_F32, 3, 0},
    {"probe", "horizon", COLUMN_F32, ANY, 0},
    {"probe", "hull_normal", COLUMN_F32, 3, 0},
    {"probe", "sh_window", COLUMN_F32, 1, 0},
    {"probe", "ambient_cube", COLUMN_F32, 18, 0},
    {"probe", "ambient_dice", COLUMN_F32, 36, 0},
    {"probe", "ambient_dice_cubic", COLUMN_F32, 108, 0},
    {"probe", "ahd", COLUMN_F32, 9, 0},
    {"probe", "merged", COLUMN_I32, 1, 0},
    {"probe", "filled", COLUMN_I32, 1, 0},
    {"probe", "origin", COLUMN_I32, 1, 0},
    {"probe", "gradient", COLUMN_F32, 3, 0},
    {"probe", "steps", COLUMN_I32, 1, 0},
    {"probe", "back", COLUMN_I32, 1, 0},
    {"probe", "cluster", COLUMN_I32, 1, 0},
    {"probe", "level", COLUMN_I32, 1, 0},
    {"probe", "time", COLUMN_F64, 1, 0},
    {"sender", "position", COLUMN_F64, 3, 0},
    {"sender", "normal", COLUMN_F32, 3, 0},
    {"sender", "radius", COLUMN_F32, 1, 0},
    {"sender", "area", COLUMN_F32, 1, 0},
    {"sender", "albedo", COLUMN_F32, 3, 0},
    {"sender", "place", COLUMN_I32, 1, 0},
    {"probe", "face", COLUMN_I32, 1, 0},
    {"probe", "weight", COLUMN_F32, 3, 0},
    {"face", "vertex", COLUMN_I32, 3, 0},
    {"face", "triangle", COLUMN_I32, 1, 0},
    {"face", "instance", COLUMN_I32, 1, 0},
    {"tet", "vertex", COLUMN_I32, 4, 0},
    {"tet", "neighbour", COLUMN_I32, 4, 0},
    {"tet", "occlusion", COLUMN_I32, 6, 0},
    {"tet", "sight", COLUMN_F32, 12, 0},
    {"tet", "stand_in", COLUMN_I32, 1, 0},
    {"tet", "sight_outside", COLUMN_F32, 12, 0},
    {"tet", "stand_in_outside", COLUMN_I32, 1, 0},
    {"tet", "leak", COLUMN_F32, 1, 0},
    {"tri", "vertex", COLUMN_I32, 3, 0},
    {"tri", "neighbour", COLUMN_I32, 3, 0},
    {"tri", "occlusion", COLUMN_I32, 3, 0},
    {"tri", "sight", COLUMN_F32, 6, 0},
    {"tri", "stand_in", COLUMN_I32, 1, 0},
    {"tri", "leak", COLUMN_F32, 1, 0},
    {"segment", "vertex", COLUMN_I32, 2, 0},
    {"segment", "neighbour", COLUMN_I32, 2, 0},
    {"segment", "occlusion", COLUMN_I32, 1, 0},
    {"segment", "sight", COLUMN_F32, 2, 0},
    {"segment", "stand_in", COLUMN_I32, 1, 0},
    {"segment", "leak", COLUMN_F32, 1, 0},
    {"point", "vertex", COLUMN_I32, 1, 0},
    {"point", "neighbour", COLUMN_I32, 1, 0},
};

struct stream_validity validity_start(void)
{
    return (struct stream_validity){.vertex = {.most = -1},
                                    .neighbour = {.most = -1},
                                    .stand_in = {.most = -1},
                                    .merged = {.most = -1}};
}

static struct error *check_sh(const struct stream_header *header, const struct column *sh)
{
    const int order = sh_order_of(sh->width);
    if (!order)
        return error_new("column sh: expected a width of 3 n^2 for an order n of 1 to %d, got %zu",
                         SH_ORDER_MAX, sh->width);
    const char *stated = header_key(header, "sh-order");
    if (stated && (strlen(stated) != 1 || *stated - '0' != order))
        return error_new("column sh has order %d, but the header's sh-order is '%s'", order,
                         stated);
    return NULL;
}

static struct error *check_known(const struct known *known, const struct table *table,
                                 const struct column *column)
{
    const struct column *sh = table_column(table, "sh");
    size_t width = known->width;
    if (!width && !sh && known->of_order > 1)
        return error_new("column %s needs a column sh, there is none", known->column);
    if (!width && !sh && !sh_order_of(3 * column->width))
        return error_new("column %s: expected a width of n^2 for an order n of 1 to %d, got %zu",
                         known->column, SH_ORDER_MAX, column->width);
    if (!width)
        width = sh ? known->of_order * (sh->width / 3) : column->width;
    if (width == ANY)
        width = column->width;
    if (column->type != known->type || column->width != width)
        return error_new("column %s: expected %s:%zu, got %s:%zu", known->column,
                         column_type_name(known->type), width, column_type_name(column->type),
                         column->width);
    return NULL;
}

/* Where a header says that light is split, the columns of its parts. */
static struct error *check_parts(const struct stream_header *header, const struct table *table)
{
    const struct column *sh = table_column(table, "sh");
    const size_t width = sh ? sh->width : 3;
    struct error *err = NULL;
    int64_t order = 0, links = 0;
    if (!sh && !table_column(table, "irradiance")) /* whose width it has is not there */
        return NULL;
    if (!header_key(header, "group-1") && !header_key(header, "transfer-sky") &&
        !header_key(header, "transfer-sun-1") && !header_key(header, "transfer-point-1") &&
        !header_key(header, "transfer-surfaces"))
        return NULL;
    err = header_get_whole(header, "transfer-sky", 1, SH_ORDER_MAX, &order);
    if (!err)
        err = header_get_whole(header, "transfer-surfaces", 1, STREAM_NAMES_MOST, &links);
    for (size_t i = 0; i < table->column_count && !err; i++) {
        const struct column *c = &table->columns[i];
        struct light_column what;
        const bool sky = !strncmp(c->name, "transfer_sky", strlen("transfer_sky"));
        if (!light_column_is_split(c->name) || light_column_is_compressed(c->name))
            continue;
        if (!strcmp(c->name, "transfer_senders")) {
            if (c->type != COLUMN_I32 || (links && c->width != (size_t)links))
                err = error_new("column %s: expected i32:%d, as the header's transfer-surfaces "
                                "says, got %s:%zu",
                                c->name, (int)links, column_type_name(c->type), c->width);
            continue;
        }
        if (!light_column_of(c, sh ? sh->width : 0, &what))
            err = error_new("column %s: expected f32 and %zu values, as its light has, or a "
                            "multiple of them, got %s:%zu",
                            c->name, width, column_type_name(c->type), c->width);
        else if (sky && order && what.blocks != (size_t)(order * order))
            err = error_new("column %s has %zu blocks, but the header's transfer-sky is %d",
                            c->name, what.blocks, (int)order);
        else if (what.channels == 1 && links && what.blocks != (size_t)links)
            err = error_new("column %s has %zu blocks, but the header's transfer-surfaces is %d",
                            c->name, what.blocks, (int)links);
    }
    return err;
}

struct error *validity_schema(const struct stream_header *header, const struct table *table)
{
    struct error *err = NULL;
    if (!table->column_count)
        err = error_new("expected at least one column, got none");
    if (!err && table->column_count > STREAM_NAMES_MOST)
        err = error_new("more than %d columns", STREAM_NAMES_MOST);
    if (!err && table_row_bytes(table) > STREAM_ROW_MOST)
        err = error_new("a row takes %zu bytes, more than %d", table_row_bytes(table),
                        STREAM_ROW_MOST);
    if (!err && !strcmp(table->name, "probe") && !table_column(table, "position"))
        err = error_new("expected a column position:f64:3, there is none");
    for (size_t i = 0; i < sizeof known_columns / sizeof *known_columns && !err; i++) {
        const struct known *known = &known_columns[i];
        const struct column *column =
            strcmp(known->table, table->name) ? NULL : table_column(table, known->column);
        if (column && !strcmp(known->column, "sh"))
            err = check_sh(header, column);
        if (column && !err)
            err = check_known(known, table, column);
    }
    if (!err && !strcmp(table->name, "probe"))
        err = check_parts(header, table);
    return error_wrap(err, "table %s", table->name);
}

/* -- rows ------------------------------------------------------------------------------------ */

/* The loops over many values go in strides of a fixed length, which compilers turn into vector
 * code. */
enum { STRIDE = 32 };

/* Whether any of `count` values is not finite: all ones in the exponent. */
static bool any_special_f32(const float *value, size_t count)
{
    uint32_t special[STRIDE] = {0}, bits[STRIDE];
    size_t i = 0;
    for (; i + STRIDE <= count; i += STRIDE) {
        memcpy(bits, value + i, sizeof bits);
        for (size_t k = 0; k < STRIDE; k++)
            special[k] |= (bits[k] & 0x7f800000u) == 0x7f800000u;
    }
    for (; i < count; i++) {
        memcpy(bits, value + i, sizeof *bits);
        special[0] |= (bits[0] & 0x7f800000u) == 0x7f800000u;
    }
    uint32_t any = 0;
    for (size_t k = 0; k < STRIDE; k++)
        any |= special[k];
    return any;
}

static bool any_special_f64(const double *value, size_t count)
{
    uint64_t any = 0;
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &value[i], sizeof bits);
        any |= (bits & 0x7ff0000000000000u) == 0x7ff0000000000000u;
    }
    return any;
}

/* Lowers *low and raises *high to what `count` values hold. */
static void widen_range(const int32_t *value, size_t count, int32_t *low, int32_t *high)
{
    size_t i = 0;
    if (count >= STRIDE) {
        int32_t least[STRIDE], most[STRIDE];
        memcpy(least, value, sizeof least);
        memcpy(most, value, sizeof most);
        for (; i + STRIDE <= count; i += STRIDE)
            for (size_t k = 0; k < STRIDE; k++) {
                least[k] = value[i + k] < least[k] ? value[i + k] : least[k];
                most[k] = value[i + k] > most[k] ? value[i + k] : most[k];
            }
        for (size_t k = 0; k < STRIDE; k++) {
            *low = least[k] < *low ? least[k] : *low;
            *high = most[k] > *high ? most[k] : *high;
        }
    }
    for (; i < count; i++) {
        *low = value[i] < *low ? value[i] : *low;
        *high = value[i] > *high ? value[i] : *high;
    }
}

/* One row of a float column: no infinity, NaN for all of it or none, and always the same NaN. */
static struct error *check_special(const struct column *c, size_t row, bool missing_allowed)
{
    size_t missing = 0;
    for (size_t k = 0; k < c->width; k++) {
        const size_t i = row * c->width + k;
        const double value = c->type == COLUMN_F32 ? (double)column_f32(c)[i] : column_f64(c)[i];
        if (isinf(value))
            return error_new("column %s: expected finite numbers, got %s", c->name,
                             value < 0 ? "-inf" : "inf");
        if (!isnan(value))
            continue;
        missing++;
        if (c->type == COLUMN_F32)
            column_f32(c)[i] = NAN;
        else
            column_f64(c)[i] = (double)NAN;
    }
    if (missing && !missing_allowed)
        return error_new("column %s: expected finite numbers, got nan", c->name);
    if (missing && missing < c->width)
        return error_new("column %s: %zu of %zu numbers are nan; all or none may be", c->name,
                         missing, c->width);
    return NULL;
}

static struct error *check_floats(const struct column *c, size_t first, size_t count,
                                  bool missing_allowed, size_t *row)
{
    const size_t begin = first * c->width, values = count * c->width;
    if (c->type == COLUMN_F32 ? !any_special_f32(column_f32(c) + begin, values)
                              : !any_special_f64(column_f64(c) + begin, values))
        return NULL;
    struct error *err = NULL;
    for (size_t i = 0; i < count && !err; i++) {
        *row = first + i;
        err = check_special(c, *row, missing_allowed);
    }
    return err;
}

/* Rows that are checked: from `first` of the table, which is `number` of the stream's. */
struct rows {
    size_t first, count, number;
};

/* Index columns: least value, and the largest seen. */
static struct error *check_indices(const struct column *c, const struct rows *rows, int32_t least,
                                   struct index_most *seen, size_t *row)
{
    const int32_t *value = column_i32(c) + rows->first * c->width;
    const size_t count = rows->count * c->width;
    int32_t low = least, high = seen->most;
    widen_range(value, count, &low, &high);
    for (size_t i = 0; i < count && (low < least || high > seen->most); i++) {
        if (value[i] == low && low < least) {
            *row = rows->first + i / c->width;
            return error_new("column %s: expected an index of %d or more, got %d", c->name, least,
                             low);
        }
        if (value[i] == high && low >= least) {
            *seen = (struct index_most){high, rows->number + i / c->width};
        }
    }
    return NULL;
}

/* Whether any of `count` tetrahedra has a corner twice. */
static bool any_twice(const int32_t *v, size_t count)
{
    int any = 0;
    for (size_t i = 0; i < count; i++, v += 4)
        any |= (v[0] == v[1]) | (v[0] == v[2]) | (v[0] == v[3]) | (v[1] == v[2]) | (v[1] == v[3]) |
               (v[2] == v[3]);
    return any;
}

static struct error *check_distinct(const struct column *c, size_t first, size_t count, size_t *row)
{
    const int32_t *v = column_i32(c) + first * c->width;
    if (c->width == 4 && !any_twice(v, count))
        return NULL;
    for (size_t i = 0; i < count; i++, v += c->width)
        for (size_t k = 1; k < c->width; k++)
            for (size_t j = 0; j < k; j++)
                if (v[j] == v[k]) {
                    *row = first + i;
                    return error_new("column %s: expected %zu different probes, got %d twice",
                                     c->name, c->width, v[k]);
                }
    return NULL;
}

struct error *validity_rows(struct stream_validity *validity, const struct table *table,
                            size_t first, size_t count, size_t number)
{
    const bool probes = !strcmp(table->name, "probe");
    const int cells = stream_cell_corners(table->name);
    const struct rows rows = {first, count, number};
    struct error *err = NULL;
    size_t row = first;
    if (cells && validity->corners && validity->corners != cells)
        return error_new("table %s: there are cells in table %s already", table->name,
                         stream_cell_table[validity->corners - 1]);
    validity->corners = cells ? cells : validity->corners;
    for (size_t i = 0; i < table->column_count && !err; i++) {
        const struct column *c = &table->columns[i];
        if (c->type != COLUMN_I32) {
            err = check_floats(c, first, count, !probes || strcmp(c->name, "position"), &row);
        } else if (cells && !strcmp(c->name, "vertex")) {
            err = check_indices(c, &rows, 0, &validity->vertex, &row);
            if (!err)
                err = check_distinct(c, first, count, &row);
        } else if (probes && !strcmp(c->name, "merged")) {
            err = check_indices(c, &rows, -1, &validity->merged, &row);
        } else if (cells && !strcmp(c->name, "neighbour")) {
            err = check_indices(c, &rows, -1, &validity->neighbour, &row);
        } else if ((cells > 1 && !strcmp(c->name, "stand_in")) ||
                   (cells == 4 && !strcmp(c->name, "stand_in_outside"))) {
            err = check_indices(c, &rows, -1, &validity->stand_in, &row);
        }
    }
    if (!err && number + count > INT32_MAX)
        err = error_new("more than %d rows", INT32_MAX);
    validity->probes += probes ? count : 0;
    validity->cells += cells ? count : 0;
    return err ? error_wrap(err, "table %s: row %zu", table->name, number + row - first) : NULL;
}

static struct error *check_most(const char *table, const char *column, const char *of,
                                const struct index_most *seen, size_t count)
{
    if (seen->most < 0 || (size_t)seen->most < count)
        return NULL;
    return error_new(
        "table %s: row %zu: column %s: expected an index below the number of %s, %zu, got %d",
        table, seen->row, column, of, count, seen->most);
}

struct error *validity_end(const struct stream_validity *v)
{
    const char *cells = stream_cell_table[v->corners ? v->corners - 1 : STREAM_CORNERS_MOST - 1];
    if (v->cells && !v->probes)
        return error_new("table %s has %zu rows, but there are no probes", cells, v->cells);
    struct error *err = check_most(cells, "vertex", "probes", &v->vertex, v->probes);
    if (!err)
        err = check_most(cells, "neighbour", "cells", &v->neighbour, v->cells);
    if (!err)
        err = check_most(cells, "stand_in", "probes", &v->stand_in, v->probes);
    return err ? err : check_most("probe", "merged", "probes", &v->merged, v->probes);
}

struct error *stream_check(const struct stream *stream)
{
    struct stream_validity validity = validity_start();
    struct error *err = NULL;
    for (size_t i = 0; i < stream->table_count && !err; i++) {
        err = validity_schema(&stream->header, &stream->tables[i]);
        if (!err)
            err = validity_rows(&validity, &stream->tables[i], 0, stream->tables[i].rows, 0);
    }
    return err ? err : validity_end(&validity);
}
