/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/senders.h"
#include "base/array.h"
#include "base/error.h"
#include "interpolate/discs.h"
#include "math/hash.h"
#include "stream/header_number.h"
#include "stream/stream.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void senders_clear(struct senders *s)
{
    free(s->position);
    free(s->normal);
    free(s->radius);
    free(s->area);
    free(s->albedo);
    free(s->link);
    free(s->share);
    sender_tree_clear(&s->tree);
    *s = (struct senders){0};
}

static struct sender_points points_of(const struct senders *s)
{
    return (struct sender_points){s->count, s->position, s->normal, s->albedo};
}

/* -- tables ------------------------------------------------------------------------------------ */

/* Takes a column's values over. */
static struct error *take(const struct table *table, const char *name, size_t width, float **value)
{
    struct column *c = NULL;
    struct error *err = table_require(table, name, COLUMN_F32, width, &c);
    if (!err)
        err = array_create(value, width * table->rows, sizeof **value);
    if (!err)
        memcpy(*value, column_f32(c), width * table->rows * sizeof **value);
    return err;
}

static struct error *check_sender(const struct senders *s, size_t i)
{
    const float *n = s->normal + 3 * i, *a = s->albedo + 3 * i;
    const double length = sqrt((double)(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]));
    if (!(fabs(length - 1) < 1e-3))
        return error_new("row %zu: expected a normal of length 1, got %g,%g,%g", i, (double)n[0],
                         (double)n[1], (double)n[2]);
    if (!(s->radius[i] >= FLT_MIN && s->radius[i] <= FLT_MAX / 4))
        return error_new("row %zu: expected a radius above 0, got %g", i, (double)s->radius[i]);
    if (!(s->area[i] >= 0))
        return error_new("row %zu: expected an area of 0 or more, got %g", i, (double)s->area[i]);
    for (int c = 0; c < 3; c++)
        if (!(a[c] >= 0 && a[c] <= 1))
            return error_new("row %zu: expected an albedo of 0 to 1, got %g,%g,%g", i, (double)a[0],
                             (double)a[1], (double)a[2]);
    return NULL;
}

/* Takes what the senders are. */
static struct error *take_senders(struct senders *s, const struct table *table)
{
    struct column *position = NULL;
    if (!table->rows || table->rows > SENDERS_MOST)
        return error_new("expected 1 to %d senders, got %zu", (int)SENDERS_MOST, table->rows);
    s->count = table->rows;
    struct error *err = table_require(table, "position", COLUMN_F64, 3, &position);
    if (!err)
        err = array_create(&s->position, 3 * s->count, sizeof *s->position);
    if (!err)
        memcpy(s->position, column_f64(position), 3 * s->count * sizeof *s->position);
    if (!err)
        err = take(table, "normal", 3, &s->normal);
    if (!err)
        err = take(table, "radius", 1, &s->radius);
    if (!err)
        err = take(table, "area", 1, &s->area);
    if (!err)
        err = take(table, "albedo", 3, &s->albedo);
    for (size_t i = 0; i < s->count && !err; i++)
        err = check_sender(s, i);
    return err;
}

struct error *senders_read(struct senders *s, const char *path, size_t links)
{
    static const char *const needed[] = {"normal", "radius", "area", "albedo"};
    struct stream *stream = NULL;
    struct error *err = stream_read(&stream, path);
    if (err)
        return err;
    senders_clear(s);
    s->links = links;
    const struct table *table = stream_table(stream, "probe");
    if (!table)
        err = error_new("expected table probe");
    for (size_t i = 0; i < sizeof needed / sizeof *needed && !err; i++)
        if (!table_column(table, needed[i]))
            err = error_new("a sender needs a normal, a radius, an area and an albedo: there is no "
                            "column %s (probe-place poisson --areas writes them all)",
                            needed[i]);
    if (!err)
        err = take_senders(s, table);
    const struct sender_points points = points_of(s);
    if (!err)
        err = sender_tree_create(&s->tree, &points);
    stream_destroy(stream);
    return error_wrap(err, "%s", path);
}

/* -- streams ----------------------------------------------------------------------------------- */

enum { KEY_ROOM = 17 };

static void print_key(const struct senders *s, char text[KEY_ROOM])
{
    struct hash hash;
    hash_start(&hash, s->count);
    hash_add(&hash, s->position, 3 * s->count * sizeof *s->position);
    hash_add(&hash, s->normal, 3 * s->count * sizeof *s->normal);
    hash_add(&hash, s->radius, s->count * sizeof *s->radius);
    hash_add(&hash, s->area, s->count * sizeof *s->area);
    hash_add(&hash, s->albedo, 3 * s->count * sizeof *s->albedo);
    snprintf(text, KEY_ROOM, "%016" PRIx64, hash_value(&hash));
}

static struct error *check_links(const struct senders *s)
{
    for (size_t i = 0; i < s->count * s->links; i++)
        if (s->link[i] < 0 || (size_t)s->link[i] >= s->tree.nodes)
            return error_new("row %zu: expected links of 0 to %zu, got %d", i / s->links,
                             s->tree.nodes - 1, (int)s->link[i]);
    for (size_t i = 0; i < s->count * s->links; i++)
        if (!(s->share[i] >= 0 && s->share[i] <= 1))
            return error_new("row %zu: expected shares of 0 to 1, got %g", i / s->links,
                             (double)s->share[i]);
    return NULL;
}

struct error *senders_from_table(struct senders *s, const struct table *table,
                                 const struct stream_header *header)
{
    struct column *place = NULL, *link = NULL;
    char key[KEY_ROOM];
    int links = 0;
    senders_clear(s);
    struct error *err = header_require(header, SENDERS_LINKS_KEY);
    if (!err)
        err = header_get_int(header, SENDERS_LINKS_KEY, 1, SENDER_LINKS_MOST, &links);
    if (err)
        return err;
    s->links = (size_t)links;
    err = take_senders(s, table);
    if (!err)
        err = take(table, "share", s->links, &s->share);
    if (!err)
        err = table_require(table, "place", COLUMN_I32, 1, &place);
    if (!err)
        err = table_require(table, "link", COLUMN_I32, s->links, &link);
    const struct sender_points points = points_of(s);
    if (!err)
        err = sender_tree_take(&s->tree, &points, column_i32(place));
    if (!err)
        err = array_create(&s->link, s->count * s->links, sizeof *s->link);
    if (!err)
        memcpy(s->link, column_i32(link), s->count * s->links * sizeof *s->link);
    if (!err)
        err = check_links(s);
    if (!err) {
        print_key(s, key);
        const char *told = header_key(header, SENDERS_KEY);
        if (!told || strcmp(told, key))
            err = error_new("expected the senders of key %s %s, got those of %s", SENDERS_KEY,
                            told ? told : "(missing)", key);
    }
    return error_wrap(err, "table %s", table->name);
}

struct error *senders_check_same(const struct senders *s, const struct table *table)
{
    struct senders other = {0};
    char ours[KEY_ROOM], theirs[KEY_ROOM] = "";
    struct error *err = take_senders(&other, table);
    print_key(s, ours);
    if (!err)
        print_key(&other, theirs);
    if (!err && strcmp(ours, theirs))
        err = error_new("expected the %zu senders that the probes have links to, got %zu others",
                        s->count, other.count);
    senders_clear(&other);
    return err;
}

struct error *senders_to_table(const struct senders *s, struct table *table)
{
    const struct {
        const char *name;
        size_t width;
        const float *value;
    } columns[] = {{"normal", 3, s->normal},
                   {"radius", 1, s->radius},
                   {"area", 1, s->area},
                   {"albedo", 3, s->albedo},
                   {"share", s->links, s->share}};
    struct column *c = NULL;
    struct error *err = table_init(table, SENDERS_TABLE);
    if (!err)
        err = table_resize(table, s->count);
    if (!err)
        err = table_add_column(table, "position", COLUMN_F64, 3, &c);
    if (!err)
        memcpy(column_f64(c), s->position, 3 * s->count * sizeof *s->position);
    for (size_t i = 0; i < sizeof columns / sizeof *columns && !err; i++) {
        err = table_add_column(table, columns[i].name, COLUMN_F32, columns[i].width, &c);
        if (!err)
            memcpy(column_f32(c), columns[i].value, columns[i].width * s->count * sizeof(float));
    }
    if (!err)
        err = table_add_column(table, "place", COLUMN_I32, 1, &c);
    for (size_t i = 0; i < s->count && !err; i++)
        column_i32(c)[s->tree.sender[i]] = (int32_t)i;
    if (!err)
        err = table_add_column(table, "link", COLUMN_I32, s->links, &c);
    if (!err)
        memcpy(column_i32(c), s->link, s->links * s->count * sizeof *s->link);
    return err;
}

struct error *senders_to_header(const struct senders *s, struct stream_header *header)
{
    char key[KEY_ROOM];
    print_key(s, key);
    struct error *err = header_set_whole(header, SENDERS_LINKS_KEY, (int64_t)s->links);
    return err ? err : header_set_key(header, SENDERS_KEY, key);
}

struct error *senders_copy_keys(struct stream_header *to, const struct stream_header *from)
{
    static const char *const keys[] = {SENDERS_LINKS_KEY, SENDERS_KEY};
    struct error *err = NULL;
    for (size_t i = 0; i < sizeof keys / sizeof *keys && !err; i++) {
        const char *value = from ? header_key(from, keys[i]) : NULL;
        if (value)
            err = header_set_key(to, keys[i], value);
        else
            header_remove_key(to, keys[i]);
    }
    return err;
}

struct error *senders_add_columns(const struct senders *s, int order, struct table *table)
{
    const size_t width = table_column(table, "normal") ? 1 : (size_t)(order * order);
    struct column *c = table_column(table, SENDERS_TRANSFER);
    struct error *err = NULL;
    if (!c || c->width != width * s->links)
        err = table_add_column(table, SENDERS_TRANSFER, COLUMN_F32, width * s->links, NULL);
    c = err ? NULL : table_column(table, SENDERS_OF);
    if (!err && (!c || c->width != s->links))
        err = table_add_column(table, SENDERS_OF, COLUMN_I32, s->links, NULL);
    return err;
}

struct error *senders_find_columns(const struct senders *s, const struct table *table,
                                   size_t *width)
{
    struct column *transfer = NULL, *of = NULL;
    struct error *err = table_require(table, SENDERS_TRANSFER, COLUMN_F32, 0, &transfer);
    if (!err)
        err = table_require(table, SENDERS_OF, COLUMN_I32, s->links, &of);
    if (!err && transfer->width % s->links)
        err = error_new("column %s: expected a multiple of %zu values, got %zu", SENDERS_TRANSFER,
                        s->links, transfer->width);
    *width = err ? 0 : transfer->width / s->links;
    return err;
}

struct error *senders_discs(const struct senders *s, struct discs **discs)
{
    float *radius = NULL;
    struct error *err = array_create(&radius, s->count, sizeof *radius);
    for (size_t i = 0; i < s->count && !err; i++)
        radius[i] = 2 * s->radius[i];
    if (!err)
        err = discs_create(discs, &(struct disc_points){s->count, s->position, s->normal, radius});
    free(radius);
    return err;
}
