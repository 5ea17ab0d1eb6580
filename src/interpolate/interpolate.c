/* SPDX-License-Identifier: Apache-2.0 */
#include "interpolate/interpolate.h"
#include "base/array.h"
#include "base/claim.h"
#include "base/error.h"
#include "interpolate/cells_volume.h"
#include "interpolate/interpolate_kind.h"
#include "libprobe-query/sh.h"
#include "light/content.h"
#include "stream/light_columns.h"
#include "stream/stream.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

const struct interpolate_kind *const interpolate_kinds[] = {
    &interpolate_barycentric,
    &interpolate_gradient,
    &interpolate_cubic,
    &interpolate_nearest,
    &interpolate_shepard,
    &interpolate_trilinear,
    &interpolate_tricubic,
    &interpolate_trilinear_gradient,
    &interpolate_inverse,
    &interpolate_discs,
    NULL, /* a row a line */
};

const struct interpolate_kind *interpolate_kind_find(const char *name)
{
    int i = 0;
    while (interpolate_kinds[i] && strcmp(interpolate_kinds[i]->name, name))
        i++;
    return interpolate_kinds[i];
}

void interpolate_kind_names(char *text, size_t size, bool need_cells, const char *last)
{
    const char *names[16]; /* room for more kinds than there are */
    size_t count = 0, used = 0;
    for (int i = 0; interpolate_kinds[i] && count < 16; i++)
        if (interpolate_kinds[i]->needs_cells || !need_cells)
            names[count++] = interpolate_kinds[i]->name;
    for (size_t i = 0; i < count && used < size; i++) {
        const char *between = i + 1 < count ? ", " : last;
        used += (size_t)snprintf(text + used, size - used, "%s%s", i ? between : "", names[i]);
    }
}

/* -- opening --------------------------------------------------------------------------------- */

struct error *interpolate_no_light(const struct table *probes)
{
    if (table_column(probes, "normal") && table_column(probes, "irradiance"))
        return error_new("the probes are at surfaces: each has the irradiance of its own normal "
                         "(--column irradiance) and no light from all sides (no column sh)");
    return error_new("the probes have no light (no column sh): run probe-capture");
}

/* Whether a column is SH of light: all of it, or that of a group. */
static bool is_sh(const struct table *probes, const struct column *column)
{
    const struct column *sh = table_column(probes, "sh");
    struct light_column what;
    return sh && light_column_of(column, sh->width, &what) && what.role == LIGHT_VALUE &&
           !what.surface && !what.transfer;
}

static struct error *open_column(struct interpolate *in, const struct stream *stream)
{
    const struct table *probes = stream_table(stream, "probe");
    const char *name = in->settings.column;
    struct column *column = NULL;
    if (!probes)
        return error_new("there is no table probe");
    if (!strcmp(name, "sh") && !table_column(probes, "sh"))
        return interpolate_no_light(probes);
    struct error *err = table_require(probes, name, COLUMN_F32, 0, &column);
    if (err)
        return err;
    const bool sh = is_sh(probes, column);
    in->position = column_f64(table_column(probes, "position"));
    in->value = column_f32(column);
    in->width = column->width;
    in->order = sh ? sh_order_of(column->width) : 0;
    return sh ? content_from_header(&stream->header, &in->convolved) : NULL;
}

/* The column of gradients. */
static struct error *open_gradient(struct interpolate *in, const struct stream *stream)
{
    const struct table *probes = stream_table(stream, "probe");
    const char *name = in->settings.column;
    char *full = NULL;
    struct column *column = NULL;
    if (asprintf(&full, "%s_gradient", name) < 0)
        return error_memory();
    struct error *err = NULL;
    if (!table_column(probes, full) && in->order && strcmp(name, "sh") != 0)
        err = error_new("gradients are known of all light alone: --column sh, not %s", name);
    else if (!table_column(probes, full) && in->order)
        err = error_new(
            "the probes have no gradients (no column %s): run probe-capture --columns sh_gradient",
            full);
    else
        err = table_require(probes, full, COLUMN_F32, 3 * in->width, &column);
    if (!err)
        in->gradient = column_f32(column);
    free(full);
    return err;
}

struct error *interpolate_unknown(const struct interpolate *in, int32_t probe)
{
    return error_new("probe %d has no %s: run probe-capture", probe,
                     in->order ? "light" : in->settings.column);
}

bool interpolate_has(const struct interpolate *in, size_t probe)
{
    return !isnan(in->value[probe * in->width]);
}

/* What a kind needs beside the column. */
static struct error *open_kind(struct interpolate *in, const struct stream *stream,
                               const struct probe_mesh *mesh)
{
    const struct interpolate_kind *kind = in->settings.kind;
    struct error *err = NULL;
    if (kind->needs_gradients)
        err = open_gradient(in, stream);
    if (!err && kind->needs_cells)
        err = cells_volume_open(stream, mesh, in->settings.outside, &in->volume);
    if (!err && kind->open)
        err = kind->open(in, stream_table(stream, "probe")->rows);
    return err;
}

/* The kind that a column is asked by. */
static struct error *along_kind(struct interpolate_settings *settings)
{
    const bool cubic = settings->kind == &interpolate_cubic;
    if (!cubic && settings->kind != &interpolate_barycentric)
        return error_new("along a column light is linear, or cubic where there are gradients "
                         "(--interpolate barycentric or cubic), not %s",
                         settings->kind->name);
    settings->kind = cubic ? &interpolate_along_cubic : &interpolate_along_linear;
    return NULL;
}

struct error *interpolate_open(struct interpolate **interpolate, const struct stream *stream,
                               const struct interpolate_settings *settings)
{
    struct interpolate *in = NULL;
    struct probe_mesh mesh = {0};
    *interpolate = NULL;
    struct error *err = array_create(&in, 1, sizeof *in);
    if (err)
        return err;
    *in = (struct interpolate){.settings = *settings, .stream = stream};
    if (!settings->kind)
        in->settings.kind = &interpolate_barycentric;
    if (settings->along)
        err = along_kind(&in->settings);
    if (!err && in->settings.kind->needs_cells)
        err = cells_volume_mesh(stream, &mesh);
    if (!err)
        err = open_column(in, stream);
    if (!err)
        err = open_kind(in, stream, &mesh);
    if (err)
        interpolate_close(in);
    else
        *interpolate = in;
    return err;
}

bool interpolate_is_packed(const char *path)
{
    char start[8] = {0};
    const int fd = strcmp(path, "-") ? open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK) : -1;
    struct stat status;
    const bool packed =
        fd >= 0 && !fstat(fd, &status) && S_ISREG(status.st_mode) &&
        read(fd, start, sizeof start) == sizeof start &&
        (!memcmp(start, "probepak", sizeof start) || !memcmp(start, "probesrf", sizeof start));
    if (fd >= 0)
        close(fd);
    return packed;
}

/* Whether a mapped file is one of discs. */
static bool is_surface(const struct interpolate *in)
{
    return in->image_bytes >= 8 && !memcmp(in->image, "probesrf", 8);
}

static struct error *map_file(const char *path, void **image, size_t *bytes)
{
    struct stat status;
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    *image = MAP_FAILED;
    struct error *err = fd >= 0 ? error_wrap(claim_input(fd), "%s", path) : NULL;
    if (!err && fd >= 0 && !fstat(fd, &status) && status.st_size > 0) {
        *bytes = (size_t)status.st_size;
        *image = mmap(NULL, *bytes, PROT_READ, MAP_PRIVATE, fd, 0);
    }
    if (!err && *image == MAP_FAILED)
        err = error_system(errno, "%s", path);
    if (fd >= 0)
        close(fd);
    if (err)
        *image = NULL;
    return err;
}

/* The light of all probes as floats. */
static struct error *unpack_light(struct interpolate *in)
{
    const size_t probes = probe_volume_probes(in->volume);
    struct error *err = array_create(&in->owned, probes * in->width, sizeof *in->owned);
    for (size_t i = 0; i < probes && !err; i++) {
        const struct probe_place at = {.probe = {(int32_t)i, (int32_t)i, (int32_t)i, (int32_t)i},
                                       .weight = {1, 0, 0, 0}};
        probe_volume_light(in->volume, &at, in->owned + i * in->width);
    }
    in->value = in->owned;
    return err;
}

/* The light of one group alone. */
static struct error *unpack_group(struct interpolate *in, size_t group)
{
    float *weight = NULL;
    struct error *err =
        array_create(&in->owned, probe_volume_probes(in->volume) * in->width, sizeof *in->owned);
    if (!err)
        err = array_create(&weight, 3 * probe_volume_groups(in->volume), sizeof *weight);
    for (size_t k = 0; k < 3 && !err; k++)
        weight[3 * group + k] = 1;
    if (!err)
        probe_volume_relight(in->volume, weight, in->owned);
    free(weight);
    in->value = in->owned;
    return err;
}

static struct error *open_light(struct interpolate *in)
{
    const char *column = in->settings.column;
    const size_t groups = probe_volume_groups(in->volume);
    if (!strcmp(column, "sh"))
        return unpack_light(in);
    for (size_t g = 0; g < groups && !strncmp(column, "sh_", 3); g++)
        if (!strcmp(column + 3, probe_volume_group_name(in->volume, g)))
            return unpack_group(in, g);
    return error_new("a packed file holds the column sh, and not %s%s", column,
                     groups ? "; this one holds those of its groups, too" : "");
}

static struct error *open_volume(struct interpolate *in)
{
    const struct interpolate_settings *settings = &in->settings;
    size_t row = 0;
    const enum probe_status status =
        probe_volume_open(&in->volume, in->image, in->image_bytes, settings->outside, &row);
    if (status)
        return cells_volume_error(status, row);
    const struct probe_image_facts facts = probe_volume_image(in->volume);
    in->order = facts.order;
    in->width = (size_t)(3 * facts.order * facts.order);
    in->convolved = facts.convolved;
    if (!interpolate_kind_is_plain(settings->kind))
        return error_new("a packed file of cells is interpolated from cells alone: --interpolate "
                         "barycentric");
    if (!facts.order)
        return error_new("the probes have no light");
    return open_light(in);
}

static struct error *open_surface(struct interpolate *in)
{
    const struct interpolate_settings *settings = &in->settings;
    if (!settings->kind->open_packed)
        return error_new("a packed file of discs is asked as such: --interpolate discs");
    if (strcmp(settings->column, "irradiance"))
        return error_new("a packed file of discs holds the column irradiance, and not %s",
                         settings->column);
    if (settings->radius > 0)
        return error_new("a packed file of discs has their radii: no --radius");
    return settings->kind->open_packed(in);
}

struct error *interpolate_open_packed(struct interpolate **interpolate, const char *path,
                                      const struct interpolate_settings *settings)
{
    struct interpolate *in = NULL;
    *interpolate = NULL;
    struct error *err = array_create(&in, 1, sizeof *in);
    if (err)
        return err;
    in->settings = *settings;
    if (!settings->kind)
        in->settings.kind = &interpolate_barycentric;
    err = map_file(path, &in->image, &in->image_bytes);
    if (!err)
        err = error_wrap(is_surface(in) ? open_surface(in) : open_volume(in), "%s", path);
    if (err)
        interpolate_close(in);
    else
        *interpolate = in;
    return err;
}

void interpolate_close(struct interpolate *in)
{
    if (!in)
        return;
    probe_volume_destroy(in->volume);
    if (in->own)
        in->settings.kind->close(in->own);
    free(in->owned);
    if (in->image)
        munmap(in->image, in->image_bytes);
    free(in);
}

/* -- places ---------------------------------------------------------------------------------- */

struct error *interpolate_set_sight(struct interpolate *in, const struct interpolate_sight *sight)
{
    if (!in->volume || !interpolate_kind_is_plain(in->settings.kind))
        return error_new("visibility is of the probes of cells: it needs --interpolate %s",
                         interpolate_barycentric.name);
    in->sight = *sight;
    return NULL;
}

static void see(const struct interpolate *in, const double point[3], struct probe_place *place)
{
    if (in->sight.see)
        in->sight.see(in->sight.own, point, place);
}

void interpolate_find(const struct interpolate *in, const double point[3],
                      struct probe_place *place)
{
    if (in->volume)
        probe_volume_locate(in->volume, point, place);
    else if (in->settings.kind->find)
        in->settings.kind->find(in, point, place);
    else
        *place = (struct probe_place){.cell = PROBE_COLD,
                                      .inside = 1}; /* points without cells have no outside */
    see(in, point, place);
}

void interpolate_find_many(const struct interpolate *in, size_t count, const double *point,
                           size_t stride, const uint32_t *order, struct probe_place *place)
{
    if (in->volume)
        probe_volume_locate_many(in->volume, count, point, stride, order, place);
    for (size_t k = 0; k < count && in->sight.see; k++)
        see(in, point + stride * (order ? order[k] : k), &place[k]);
    for (size_t k = 0; k < count && !in->volume; k++)
        interpolate_find(in, point + stride * (order ? order[k] : k), &place[k]);
}

void interpolate_fetch(const struct interpolate *in, const struct probe_place *place)
{
    for (int i = 0; i < 4 && in->volume; i++) {
        const char *row = (const char *)(in->value + (size_t)place->probe[i] * in->width);
        for (size_t at = 0; at < in->width * sizeof(float); at += 64)
            __builtin_prefetch(row + at);
    }
}

/* -- values at places ------------------------------------------------------------------------ */

struct error *interpolate_missing(const struct interpolate *in, const struct probe_place *place)
{
    for (int i = 0; i < 4; i++) {
        const size_t probe = (size_t)place->probe[i];
        if (!(place->weight[i] > 0))
            continue;
        if (isnan(in->value[probe * in->width]))
            return interpolate_unknown(in, place->probe[i]);
        if (in->gradient && isnan(in->gradient[3 * probe * in->width]))
            return error_new("probe %d has no gradient: run probe-capture", place->probe[i]);
    }
    return NULL;
}

bool interpolate_of_surfaces(const struct interpolate *in)
{
    return in->settings.kind->surface;
}

struct error *interpolate_surface(const struct interpolate *in, const double point[3],
                                  const double n[3], float *out, bool *covered)
{
    return in->settings.kind->surface(in, point, n, out, covered);
}

void interpolate_fetch_surfaces(const struct interpolate *in, size_t count, const double *point,
                                const double *n, size_t stride)
{
    in->settings.kind->fetch(in, count, point, n, stride);
}

struct error *interpolate_at(const struct interpolate *in, const double point[3],
                             const struct probe_place *place, float *out)
{
    if (in->settings.kind->at)
        return in->settings.kind->at(in, point, place, out);
    probe_blend(place, in->value, in->width, out);
    return isnan(out[0]) ? interpolate_missing(in, place) : NULL;
}
