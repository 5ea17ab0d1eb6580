#include "interpolate.h"
#include "array.h"
#include "content.h"
#include "error.h"
#include "mesh.h"
#include "sh.h"
#include "stream.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* -- opening --------------------------------------------------------------------------------- */

static struct error *open_column(struct interpolate *in, const struct stream *stream)
{
    const struct table *probes = stream_table(stream, "probe");
    const char *name = in->settings.column;
    const bool sh = !strcmp(name, "sh");
    struct column *column = NULL;
    if (!probes)
        return error_new("there is no table probe");
    if (sh && !table_column(probes, "sh"))
        return error_new("the probes have no light (no column sh): run probe-capture");
    struct error *err = table_require(probes, name, COLUMN_F32, 0, &column);
    if (err)
        return err;
    in->value = column_f32(column);
    in->width = column->width;
    in->order = sh ? sh_order_of(column->width) : 0;
    return sh ? content_from_header(&stream->header, &in->convolved) : NULL;
}

struct error *interpolate_open(struct interpolate **interpolate, const struct stream *stream, const struct interpolate_settings *settings)
{
    struct interpolate *in = NULL;
    struct probe_mesh mesh;
    *interpolate = NULL;
    struct error *err = array_create(&in, 1, sizeof *in);
    if (err)
        return err;
    *in = (struct interpolate){.settings = *settings, .stream = stream};
    err = mesh_find(stream, &mesh);
    if (!err)
        err = open_column(in, stream);
    if (!err)
        err = mesh_volume(&mesh, settings->nearest ? PROBE_NEAREST : 0, &in->volume);
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
    const bool packed = fd >= 0 && !fstat(fd, &status) && S_ISREG(status.st_mode) && read(fd, start, sizeof start) == sizeof start &&
                        !memcmp(start, "probepak", sizeof start);
    if (fd >= 0)
        close(fd);
    return packed;
}

static struct error *map_file(const char *path, void **image, size_t *bytes)
{
    struct stat status;
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    *image = MAP_FAILED;
    if (fd >= 0 && !fstat(fd, &status) && status.st_size > 0) {
        *bytes = (size_t)status.st_size;
        *image = mmap(NULL, *bytes, PROT_READ, MAP_PRIVATE, fd, 0);
    }
    struct error *err = *image == MAP_FAILED ? error_system(errno, "%s", path) : NULL;
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
        const struct probe_place at = {.probe = {(int32_t)i, (int32_t)i, (int32_t)i, (int32_t)i}, .weight = {1, 0, 0, 0}};
        probe_volume_light(in->volume, &at, in->owned + i * in->width);
    }
    in->value = in->owned;
    return err;
}

struct error *interpolate_open_packed(struct interpolate **interpolate, const char *path, const struct interpolate_settings *settings)
{
    struct interpolate *in = NULL;
    size_t row = 0;
    *interpolate = NULL;
    struct error *err = array_create(&in, 1, sizeof *in);
    if (err)
        return err;
    in->settings = *settings;
    err = map_file(path, &in->image, &in->image_bytes);
    if (!err) {
        const enum probe_status status = probe_volume_open(&in->volume, in->image, in->image_bytes, settings->nearest ? PROBE_NEAREST : 0, &row);
        err = error_wrap(mesh_error(status, row), "%s", path);
    }
    if (!err) {
        const struct probe_image_facts facts = probe_volume_image(in->volume);
        in->order = facts.order;
        in->width = (size_t)(3 * facts.order * facts.order);
        in->convolved = facts.convolved;
        if (strcmp(settings->column, "sh"))
            err = error_new("%s: a packed file holds the column sh, and not %s", path, settings->column);
        else if (!facts.order)
            err = error_new("%s: the probes have no light", path);
        else
            err = unpack_light(in);
    }
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
    free(in->owned);
    if (in->image)
        munmap(in->image, in->image_bytes);
    free(in);
}

/* -- at a point ------------------------------------------------------------------------------ */

void interpolate_find(const struct interpolate *in, const double point[3], struct probe_place *place)
{
    probe_volume_locate(in->volume, point, place);
}

void interpolate_find_many(const struct interpolate *in, size_t count, const double *point, size_t stride, const uint32_t *order, struct probe_place *place)
{
    probe_volume_locate_many(in->volume, count, point, stride, order, place);
}

void interpolate_fetch(const struct interpolate *in, const struct probe_place *place)
{
    for (int i = 0; i < 4; i++) {
        const char *row = (const char *)(in->value + (size_t)place->probe[i] * in->width);
        for (size_t at = 0; at < in->width * sizeof(float); at += 64)
            __builtin_prefetch(row + at);
    }
}

/* The blend is NaN: because of which probe. */
static struct error *missing(const struct interpolate *in, const struct probe_place *place)
{
    for (int i = 0; i < 4; i++)
        if (place->weight[i] > 0 && isnan(in->value[(size_t)place->probe[i] * in->width]))
            return error_new("probe %d has no %s: run probe-capture", place->probe[i], in->order ? "light" : in->settings.column);
    return NULL;
}

struct error *interpolate_at(const struct interpolate *in, const double point[3], const struct probe_place *place, float *out)
{
    (void)point;
    probe_blend(place, in->value, in->width, out);
    return isnan(out[0]) ? missing(in, place) : NULL;
}
