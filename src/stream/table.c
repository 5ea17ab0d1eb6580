/* SPDX-License-Identifier: Apache-2.0 */
/* Tables and headers in memory. */
#include "base/array.h"
#include "base/error.h"
#include "stream/table_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

size_t column_type_size(enum column_type type)
{
    return type == COLUMN_F64 ? 8 : 4;
}

const char *column_type_name(enum column_type type)
{
    static const char *const names[] = {
        [COLUMN_F32] = "f32", [COLUMN_F64] = "f64", [COLUMN_I32] = "i32"};
    return names[type];
}

const char *const stream_cell_table[STREAM_CORNERS_MOST] = {"point", "segment", "tri", "tet"};

int stream_cell_corners(const char *table)
{
    for (int i = 0; i < STREAM_CORNERS_MOST; i++)
        if (!strcmp(table, stream_cell_table[i]))
            return i + 1;
    return 0;
}

bool stream_name_valid(const char *name)
{
    const size_t valid = strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789_-");
    return *name >= 'a' && *name <= 'z' && !name[valid] && valid <= STREAM_NAME_MOST;
}

static struct error *copy_text(char **to, const char *from)
{
    *to = strdup(from);
    return *to ? NULL : error_memory();
}

/* -- header ---------------------------------------------------------------------------------- */

static struct key *find_key(const struct stream_header *header, const char *name)
{
    for (size_t i = 0; i < header->key_count; i++)
        if (!strcmp(header->keys[i].name, name))
            return &header->keys[i];
    return NULL;
}

const char *header_key(const struct stream_header *header, const char *name)
{
    const struct key *key = find_key(header, name);
    return key ? key->value : NULL;
}

struct error *header_set_key(struct stream_header *header, const char *name, const char *value)
{
    bool printable = true;
    for (const char *c = value; *c; c++)
        printable = printable && ((unsigned char)*c >= ' ' || *c == '\t') && *c != 0x7f;
    if (!stream_name_valid(name) || strchr(name, '_') || !strcmp(name, "table") ||
        !strcmp(name, "end") || !printable)
        return error_new("header key %.*s: expected a name of a-z, 0-9 and -, and a value without "
                         "control characters",
                         STREAM_NAME_MOST, name);
    char *copy = NULL;
    struct error *err = copy_text(&copy, value);
    if (err)
        return err;
    struct key *key = find_key(header, name);
    if (key) {
        free(key->value);
        key->value = copy;
        return NULL;
    }
    if (header->key_count == STREAM_NAMES_MOST) {
        free(copy);
        return error_new("more than %d header keys", STREAM_NAMES_MOST);
    }
    struct key *grown = realloc(header->keys, (header->key_count + 1) * sizeof *grown);
    if (!grown) {
        free(copy);
        return error_memory();
    }
    header->keys = grown;
    char *name_copy = NULL;
    err = copy_text(&name_copy, name);
    if (err) {
        free(copy);
        return err;
    }
    header->keys[header->key_count++] = (struct key){.name = name_copy, .value = copy};
    return NULL;
}

void header_remove_key(struct stream_header *header, const char *name)
{
    struct key *key = find_key(header, name);
    if (!key)
        return;
    free(key->name);
    free(key->value);
    const size_t index = (size_t)(key - header->keys);
    memmove(key, key + 1, (--header->key_count - index) * sizeof *key);
}

struct error *header_add_provenance(struct stream_header *header, const char *command_line)
{
    char **grown = realloc(header->provenance, (header->provenance_count + 1) * sizeof *grown);
    if (!grown)
        return error_memory();
    header->provenance = grown;
    char *copy = NULL;
    struct error *err = copy_text(&copy, command_line);
    if (err)
        return err;
    for (char *c = copy; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 0x7f)
            *c = '?';
    header->provenance[header->provenance_count++] = copy;
    return NULL;
}

struct error *header_copy(struct stream_header *to, const struct stream_header *from)
{
    *to = (struct stream_header){0};
    struct error *err = NULL;
    for (size_t i = 0; i < from->provenance_count && !err; i++)
        err = header_add_provenance(to, from->provenance[i]);
    for (size_t i = 0; i < from->key_count && !err; i++)
        err = header_set_key(to, from->keys[i].name, from->keys[i].value);
    if (err)
        header_clear(to);
    return err;
}

void header_clear(struct stream_header *header)
{
    for (size_t i = 0; i < header->provenance_count; i++)
        free(header->provenance[i]);
    for (size_t i = 0; i < header->key_count; i++) {
        free(header->keys[i].name);
        free(header->keys[i].value);
    }
    free(header->provenance);
    free(header->keys);
    *header = (struct stream_header){0};
}

/* -- tables ---------------------------------------------------------------------------------- */

struct error *table_init(struct table *table, const char *name)
{
    *table = (struct table){0};
    return copy_text(&table->name, name);
}

static void column_clear(struct column *column)
{
    free(column->name);
    free(column->data);
}

void table_clear(struct table *table)
{
    for (size_t i = 0; i < table->column_count; i++)
        column_clear(&table->columns[i]);
    free(table->columns);
    free(table->name);
    *table = (struct table){0};
}

struct column *table_column(const struct table *table, const char *name)
{
    for (size_t i = 0; i < table->column_count; i++)
        if (!strcmp(table->columns[i].name, name))
            return &table->columns[i];
    return NULL;
}

struct error *table_require(const struct table *table, const char *name, enum column_type type,
                            size_t width, struct column **column)
{
    *column = table_column(table, name);
    if (!*column)
        return error_new("table %s: expected a column %s:%s, there is none", table->name, name,
                         column_type_name(type));
    if ((*column)->type != type || (width && (*column)->width != width)) {
        struct error *err = error_new("table %s: column %s: expected %s:%zu, got %s:%zu",
                                      table->name, name, column_type_name(type),
                                      width ? width : (*column)->width,
                                      column_type_name((*column)->type), (*column)->width);
        *column = NULL;
        return err;
    }
    return NULL;
}

size_t table_row_bytes(const struct table *table)
{
    size_t bytes = 0;
    for (size_t i = 0; i < table->column_count; i++)
        bytes += table->columns[i].width * column_type_size(table->columns[i].type);
    return bytes;
}

size_t table_block_rows(const struct table *table)
{
    const size_t bytes = table_row_bytes(table);
    return bytes && bytes < STREAM_BLOCK_BYTES ? STREAM_BLOCK_BYTES / bytes : 1;
}

/* Rows first .. first+count-1 become missing values. */
static void fill_missing(struct column *column, size_t first, size_t count)
{
    const size_t begin = first * column->width, end = (first + count) * column->width;
    switch (column->type) {
    case COLUMN_F32:
        for (size_t i = begin; i < end; i++)
            column_f32(column)[i] = NAN;
        break;
    case COLUMN_F64:
        for (size_t i = begin; i < end; i++)
            column_f64(column)[i] = (double)NAN;
        break;
    case COLUMN_I32:
        for (size_t i = begin; i < end; i++)
            column_i32(column)[i] = -1;
        break;
    }
}

struct error *table_add_column(struct table *table, const char *name, enum column_type type,
                               size_t width, struct column **column)
{
    struct column *place = table_column(table, name);
    if (!place) {
        struct column *grown = realloc(table->columns, (table->column_count + 1) * sizeof *grown);
        if (!grown)
            return error_memory();
        table->columns = grown;
    }
    struct column fresh = {.type = type, .width = width};
    struct error *err = copy_text(&fresh.name, name);
    if (!err)
        err = array_create(&fresh.data, table->capacity, width * column_type_size(type));
    if (err) {
        column_clear(&fresh);
        return err;
    }
    fill_missing(&fresh, 0, table->rows);
    if (place)
        column_clear(place);
    else
        place = &table->columns[table->column_count++];
    *place = fresh;
    if (column)
        *column = place;
    return NULL;
}

void table_remove_column(struct table *table, const char *name)
{
    struct column *column = table_column(table, name);
    if (!column)
        return;
    column_clear(column);
    const size_t index = (size_t)(column - table->columns);
    memmove(column, column + 1, (--table->column_count - index) * sizeof *column);
}

struct error *table_reserve(struct table *table, size_t rows)
{
    if (rows <= table->capacity)
        return NULL;
    if (rows > INT32_MAX)
        return error_new("table %s: more than %d rows", table->name, INT32_MAX);
    size_t capacity = table->capacity + table->capacity / 2;
    if (capacity < rows)
        capacity = rows;
    for (size_t i = 0; i < table->column_count; i++) {
        struct column *c = &table->columns[i];
        size_t room = table->capacity;
        struct error *err =
            array_reserve(&c->data, &room, capacity, c->width * column_type_size(c->type));
        if (err)
            return err;
    }
    table->capacity = capacity;
    return NULL;
}

struct error *table_resize(struct table *table, size_t rows)
{
    struct error *err = table_reserve(table, rows);
    if (err)
        return err;
    if (rows > table->rows)
        for (size_t i = 0; i < table->column_count; i++)
            fill_missing(&table->columns[i], table->rows, rows - table->rows);
    table->rows = rows;
    return NULL;
}

struct error *table_copy_schema(struct table *to, const struct table *from)
{
    struct error *err = table_init(to, from->name);
    for (size_t i = 0; i < from->column_count && !err; i++)
        err = table_add_column(to, from->columns[i].name, from->columns[i].type,
                               from->columns[i].width, NULL);
    if (err)
        table_clear(to);
    return err;
}

void table_copy_rows(struct table *to, size_t to_first, const struct table *from, size_t from_first,
                     size_t count)
{
    for (size_t i = 0; i < from->column_count; i++) {
        const struct column *source = &from->columns[i];
        struct column *target = table_column(to, source->name);
        if (!target || target->type != source->type || target->width != source->width)
            continue;
        const size_t bytes = source->width * column_type_size(source->type);
        memcpy((char *)target->data + to_first * bytes,
               (const char *)source->data + from_first * bytes, count * bytes);
    }
}
