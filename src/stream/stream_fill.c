/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/stream_fill.h"
#include "base/array.h"
#include "base/error.h"
#include "base/warning.h"
#include "stream/light_columns.h"
#include "stream/sight_key.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- header ----------------------------------------------------------------------------------- */

static bool has_provenance(const struct stream_header *header, const char *line)
{
    for (size_t i = 0; i < header->provenance_count; i++)
        if (!strcmp(header->provenance[i], line))
            return true;
    return false;
}

/* Whether light depends on the key (man probe.5, "Keys"). */
static bool is_of_light(const char *key)
{
    static const char *const names[] = {"sky",           "sky-key",     "sky-map",   "sky-turn",
                                        "sky-up",        "sky-scale",   "emit",      "albedo-scale",
                                        "max-albedo",    "light-scale", "scene-key", "rotated",
                                        "rotated-light", "light-blend"};
    static const char *const families[] = {"sh-",   "capture-", "sun-",   "point-",
                                           "spot-", "relit-",   "weight-"};
    if (light_key_is_split(key))
        return true;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (!strcmp(key, names[i]))
            return true;
    for (size_t i = 0; i < sizeof families / sizeof *families; i++)
        if (!strncmp(key, families[i], strlen(families[i])))
            return true;
    return false;
}

/* That the light of both, where both have some, is split into the same parts, turned, relit and lit
 * by lights of options in the same way: a key that one lacks says that it is not. */
static struct error *check_parts(const struct stream_header *to, const struct stream_header *from)
{
    const struct stream_header *const both[] = {to, from};
    if (!header_key(to, "capture-rays") || !header_key(from, "capture-rays"))
        return NULL;
    for (int turn = 0; turn < 2; turn++)
        for (size_t i = 0; i < both[turn]->key_count; i++) {
            const char *name = both[turn]->keys[i].name, *ours = header_key(to, name),
                       *theirs = header_key(from, name);
            if (ours && theirs)
                continue;
            if (light_key_is_split(name))
                return error_new("its light is not split as that of the probes to be filled: %s is "
                                 "%s, and theirs is %s",
                                 name, theirs ? theirs : "none", ours ? ours : "none");
            if (light_key_changes(name))
                return error_new("its light is not that of the probes to be filled: %s is %s, and "
                                 "theirs is %s",
                                 name, theirs ? theirs : "none", ours ? ours : "none");
        }
    return NULL;
}

static struct error *fill_header(struct stream_header *to, const struct stream_header *from,
                                 const char *file, struct warnings *warnings)
{
    struct error *err = check_parts(to, from);
    for (size_t i = 0; i < from->provenance_count && !err; i++)
        if (!has_provenance(to, from->provenance[i]))
            err = header_add_provenance(to, from->provenance[i]);
    for (size_t i = 0; i < from->key_count && !err; i++) {
        const char *name = from->keys[i].name, *theirs = from->keys[i].value,
                   *ours = header_key(to, name);
        if (sight_key_is(name)) /* of cells, which are not filled */
            continue;
        if (!ours)
            err = header_set_key(to, name, theirs);
        else if (strcmp(ours, theirs) && is_of_light(name))
            err = error_new(
                "its light is not that of the probes to be filled: %s is %s, and theirs is %s",
                name, theirs, ours);
        else if (strcmp(ours, theirs) && strcmp(name, "scene-told"))
            warnings_add(warnings, "key differs",
                         "%s: key %s is '%s', and '%s' in the stream to be filled: that stays",
                         file, name, theirs, ours);
    }
    return err;
}

/* -- finding probes again --------------------------------------------------------------------- */

enum { POSITION_BYTES = 3 * sizeof(double), NORMAL_BYTES = 3 * sizeof(float) };

/* Where a probe is, to the bit. */
struct site {
    unsigned char bytes[POSITION_BYTES + NORMAL_BYTES];
    size_t row;
};

static int compare_places(const struct site *a, const struct site *b)
{
    return memcmp(a->bytes, b->bytes, sizeof a->bytes);
}

static int compare_sites(const void *a, const void *b)
{
    const struct site *x = a, *y = b;
    const int order = compare_places(x, y);
    return order ? order : x->row < y->row ? -1 : 1;
}

/* The sites of all rows, in order; normals: whether they count. */
static struct error *sort_sites(const struct table *probes, bool normals, struct site **sites)
{
    const struct column *position = table_column(probes, "position"),
                        *normal = normals ? table_column(probes, "normal") : NULL;
    struct error *err = array_create(sites, probes->rows, sizeof **sites);
    for (size_t i = 0; i < probes->rows && !err; i++) {
        struct site *site = &(*sites)[i];
        memcpy(site->bytes, column_f64(position) + 3 * i, POSITION_BYTES);
        if (normal)
            memcpy(site->bytes + POSITION_BYTES, column_f32(normal) + 3 * i, NORMAL_BYTES);
        site->row = i;
    }
    if (!err)
        qsort(*sites, probes->rows, sizeof **sites, compare_sites);
    return err;
}

/* A row of each table that are the same probe. */
struct pair {
    size_t to, from;
    bool lit; /* its light is taken */
};

/* Finds all pairs: walks both tables in the order of their sites. */
static struct error *find_pairs(const struct table *to, const struct table *from,
                                struct pair **pairs, size_t *count)
{
    const bool normals = table_column(to, "normal") && table_column(from, "normal");
    struct site *ours = NULL, *theirs = NULL;
    *count = 0;
    struct error *err = array_create(pairs, to->rows, sizeof **pairs);
    if (!err)
        err = sort_sites(to, normals, &ours);
    if (!err)
        err = sort_sites(from, normals, &theirs);
    for (size_t i = 0, k = 0; !err && i < to->rows && k < from->rows;) {
        const int order = compare_places(&ours[i], &theirs[k]);
        if (!order)
            (*pairs)[(*count)++] = (struct pair){.to = ours[i].row, .from = theirs[k].row};
        i += order <= 0;
        k += order >= 0;
    }
    free(ours);
    free(theirs);
    return err;
}

/* -- filling ---------------------------------------------------------------------------------- */

static bool is_missing(const struct column *c, size_t row)
{
    const size_t i = row * c->width;
    return c->type == COLUMN_F32   ? isnan(column_f32(c)[i])
           : c->type == COLUMN_F64 ? isnan(column_f64(c)[i])
                                   : column_i32(c)[i] == -1;
}

static bool has_light(const struct table *probes, size_t row)
{
    const struct column *light = table_column(probes, "sh");
    if (!light)
        light = table_column(probes, "irradiance");
    return light && !is_missing(light, row);
}

/* Whether capture writes the column beside a probe's light, in place of what was there before, as
 * the ao of probe-place poisson. */
static bool goes_with_light(const char *column)
{
    static const char *const names[] = {"validity",   "depth",       "sky",         "visibility",
                                        "ao",         "bent_normal", "bent_length", "cone",
                                        "ao_bounced", "horizon"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (!strcmp(column, names[i]))
            return true;
    return false;
}

/* Copies a column's values to the probes that lack them (all: to every probe that is in both). */
static void fill_column(struct column *to, const struct column *from, const struct pair *pairs,
                        size_t count, bool all)
{
    const size_t bytes = to->width * column_type_size(to->type);
    const bool with_light = goes_with_light(from->name);
    for (size_t i = 0; i < count; i++)
        if (all || is_missing(to, pairs[i].to) ||
            (with_light && pairs[i].lit && !is_missing(from, pairs[i].from)))
            memcpy((char *)to->data + pairs[i].to * bytes,
                   (const char *)from->data + pairs[i].from * bytes, bytes);
}

static struct error *fill_probes(struct table *to, const struct table *from, struct pair *pairs,
                                 size_t count)
{
    struct error *err = NULL;
    for (size_t i = 0; i < count; i++)
        pairs[i].lit = !has_light(to, pairs[i].to) && has_light(from, pairs[i].from);
    for (size_t i = 0; i < from->column_count && !err; i++) {
        const struct column *theirs = &from->columns[i];
        struct column *ours = table_column(to, theirs->name);
        const bool added = !ours;
        if (!strcmp(theirs->name, "hull_normal") || !strcmp(theirs->name, "merged"))
            continue;
        if (ours && (ours->type != theirs->type || ours->width != theirs->width))
            err = error_new("column %s is %s:%zu, and %s:%zu in the stream to be filled",
                            theirs->name, column_type_name(theirs->type), theirs->width,
                            column_type_name(ours->type), ours->width);
        if (added)
            err = table_add_column(to, theirs->name, theirs->type, theirs->width, &ours);
        if (!err)
            fill_column(ours, theirs, pairs, count, added);
    }
    return err;
}

struct error *stream_fill(struct stream *to, const struct stream *from, const char *name,
                          struct warnings *warnings)
{
    struct table *ours = stream_table(to, "probe"), *theirs = stream_table(from, "probe");
    struct pair *pairs = NULL;
    size_t count = 0;
    struct error *err = NULL;
    if (!ours || !theirs)
        err =
            error_new("nothing can be filled: %s has no table probe", theirs ? "the input" : "it");
    if (!err)
        err = fill_header(&to->header, &from->header, name, warnings);
    if (!err)
        err = find_pairs(ours, theirs, &pairs, &count);
    if (!err)
        err = fill_probes(ours, theirs, pairs, count);
    if (!err && count < theirs->rows)
        warnings_add(
            warnings, "strangers",
            "%s: %zu of its %zu probes are not among those to be filled: they are left out", name,
            theirs->rows - count, theirs->rows);
    free(pairs);
    return error_wrap(err, "%s", name);
}
