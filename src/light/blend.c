/* SPDX-License-Identifier: Apache-2.0 */
#include "light/blend.h"
#include "base/error.h"
#include "base/warning.h"
#include "light/basis.h"
#include "light/rotate.h"
#include "stream/header_number.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <math.h>
#include <string.h>

/* -- whether they can be ----------------------------------------------------------------------- */

static struct error *check_keys(const struct stream_header *to, const struct stream_header *from)
{
    static const char *const same[] = {"sh-content", ROTATED_KEY, ROTATED_LIGHT_KEY};
    const struct stream_header *const both[] = {to, from};
    for (int turn = 0; turn < 2; turn++)
        for (size_t k = 0; k < both[turn]->key_count; k++) {
            const char *name = both[turn]->keys[k].name, *ours = header_key(to, name),
                       *theirs = header_key(from, name);
            bool matters = light_key_is_split(name);
            for (size_t i = 0; i < sizeof same / sizeof *same; i++)
                matters = matters || !strcmp(name, same[i]);
            if (matters && (!ours || !theirs || strcmp(ours, theirs)))
                return error_new("%s is %s in the first and %s in the second", name,
                                 ours ? ours : "not there", theirs ? theirs : "not there");
        }
    if (header_key(to, LIGHT_BASIS_KEY))
        return error_new("groups and transfers are compressed (key %s): expected the streams "
                         "before probe-relight --compress, or what was relit",
                         LIGHT_BASIS_KEY);
    if (header_key(to, LIGHT_SENDERS_KEY))
        return error_new("the probes have links to senders (key %s), which two bakes cannot share: "
                         "expected what was relit",
                         LIGHT_SENDERS_KEY);
    return NULL;
}

static struct error *check_probes(const struct table *to, const struct table *from)
{
    const struct column *ours = table_column(to, "normal"), *theirs = table_column(from, "normal");
    if (to->rows != from->rows)
        return error_new("expected the same probes, got %zu and %zu", to->rows, from->rows);
    for (size_t i = 0; i < to->rows; i++) {
        const double *p = column_f64(table_column(to, "position")) + 3 * i,
                     *q = column_f64(table_column(from, "position")) + 3 * i;
        if (p[0] != q[0] || p[1] != q[1] || p[2] != q[2])
            return error_new("expected the same probes in the same order: probe %zu is at "
                             "%g,%g,%g in the first and at %g,%g,%g in the second",
                             i, p[0], p[1], p[2], q[0], q[1], q[2]);
        if (ours && theirs &&
            memcmp(column_f32(ours) + 3 * i, column_f32(theirs) + 3 * i, 3 * sizeof(float)))
            return error_new("expected the same probes: probe %zu has another normal in each", i);
    }
    return NULL;
}

static size_t sh_width(const struct table *probes)
{
    const struct column *sh = table_column(probes, "sh");
    return sh ? sh->width : 0;
}

/* Whether each column of light of one is in the other; counts those that are values. */
static struct error *check_light(const struct table *a, const struct table *b, size_t *values)
{
    struct light_column what;
    *values = 0;
    for (size_t i = 0; i < a->column_count; i++) {
        const struct column *c = &a->columns[i], *other = table_column(b, c->name);
        if (!light_column_of(c, sh_width(a), &what))
            continue;
        *values += what.role == LIGHT_VALUE;
        if (!other || other->type != c->type || other->width != c->width)
            return error_new("expected the same columns of light: %s is %s:%zu in one, and %s in "
                             "the other",
                             c->name, column_type_name(c->type), c->width,
                             other ? "of another width" : "not");
    }
    return NULL;
}

/* -- blending ---------------------------------------------------------------------------------- */

static void blend_column(struct column *to, const struct column *from, size_t rows, double weight,
                         bool error)
{
    float *a = column_f32(to);
    const float *b = column_f32(from);
    for (size_t i = 0; i < rows * to->width; i++) {
        const double x = (1 - weight) * (double)a[i], y = weight * (double)b[i];
        a[i] = (float)(error ? sqrt(x * x + y * y) : x + y);
    }
}

static void drop_stale(struct table *probes, struct warnings *warnings)
{
    bool any = table_column(probes, "sh_window");
    for (int b = 0; b < BASIS_COUNT; b++)
        any = any || table_column(probes, basis_column((enum basis)b));
    if (any)
        warnings_add(warnings, "blend",
                     "sh_window and other bases are of the light as it was: dropped (--basis makes "
                     "them anew)");
    table_remove_column(probes, "sh_window");
    basis_drop(probes);
}

struct error *blend_streams(struct stream *to, const struct stream *from, double weight,
                            struct warnings *warnings)
{
    struct table *ours = stream_table(to, "probe"), *theirs = stream_table(from, "probe");
    size_t values = 0;
    if (!ours || !theirs)
        return error_new("a stream has no table probe");
    struct error *err = check_probes(ours, theirs);
    if (!err)
        err = check_keys(&to->header, &from->header);
    if (!err)
        err = check_light(theirs, ours, &values);
    if (!err)
        err = check_light(ours, theirs, &values);
    if (!err && !values)
        err = error_new("the probes have no light (no column sh or irradiance): run "
                        "probe-capture");
    if (err)
        return err;
    for (size_t i = 0; i < ours->column_count; i++) {
        struct light_column what;
        struct column *c = &ours->columns[i];
        if (light_column_of(c, sh_width(ours), &what))
            blend_column(c, table_column(theirs, c->name), ours->rows, weight,
                         what.role == LIGHT_ERROR);
    }
    drop_stale(ours, warnings);
    return header_set_real(&to->header, BLEND_KEY, weight);
}
