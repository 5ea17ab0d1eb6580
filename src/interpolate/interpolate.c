/* Based on:
 * Tatarchuk, "Irradiance volumes for games", GDC Europe, 2005: a first-order Taylor expansion from
 * each probe before blending; tricubic interpolation. Farin, "Triangular Bernstein-Bezier patches",
 * Computer Aided Geometric Design 3, 1986: cubics with quadratic precision. Bikker, Reijerse, "A
 * precalculated point set for caching shading information", Eurographics short papers, 2009.
 * Shepard, "A two-dimensional interpolation function for irregularly-spaced data", ACM, 1968.
 */
#include "interpolate/interpolate.h"
#include "base/array.h"
#include "base/error.h"
#include "interpolate/cells_volume.h"
#include "interpolate/scatter.h"
#include "libprobe-query/sh.h"
#include "light/content.h"
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
    if (!table_column(probes, full) && in->order)
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

static struct error *unknown(const struct interpolate *in, int32_t probe)
{
    return error_new("probe %d has no %s: run probe-capture", probe,
                     in->order ? "light" : in->settings.column);
}

static bool is_missing(const void *context, size_t probe)
{
    const struct interpolate *in = context;
    return isnan(in->value[probe * in->width]);
}

/* Why the probes are neither what one error says nor the other; takes both. */
static struct error *neither(struct error *grid, struct error *octree)
{
    struct error *err = error_new("%s; nor: %s", error_message(grid), error_message(octree));
    error_destroy(grid);
    error_destroy(octree);
    return err;
}

/* Probes are a grid, or else an octree, whose made nodes need the values of all. */
static struct error *open_nodes(struct interpolate *in, size_t probes)
{
    struct error *no_grid = nodes_find(&in->nodes, probes, in->position);
    if (!no_grid)
        return NULL;
    struct error *err = octree_find(&in->octree, probes, in->position);
    if (err)
        return neither(no_grid, err);
    error_destroy(no_grid);
    for (size_t i = 0; i < probes && !err; i++)
        err = is_missing(in, i) ? unknown(in, (int32_t)i) : NULL;
    return err ? err
               : octree_fill(&in->octree, in->settings.kind == INTERPOLATE_TRICUBIC, in->width,
                             in->value, &in->data);
}

/* What a kind needs beside the column. */
static struct error *open_kind(struct interpolate *in, const struct stream *stream,
                               const struct probe_mesh *mesh)
{
    const struct table *probes = stream_table(stream, "probe");
    struct error *err = NULL;
    switch (in->settings.kind) {
    case INTERPOLATE_NEAREST:
    case INTERPOLATE_SHEPARD:
        err = scatter_create(&in->scatter, probes->rows, in->position, is_missing, in);
        if (!err && !(in->settings.radius > 0))
            in->settings.radius = scatter_spacing(in->scatter);
        return err;
    case INTERPOLATE_TRILINEAR:
    case INTERPOLATE_TRICUBIC: return open_nodes(in, probes->rows);
    case INTERPOLATE_GRADIENT:
    case INTERPOLATE_CUBIC: err = open_gradient(in, stream); break;
    default: break;
    }
    return err ? err : mesh_volume(mesh, in->settings.outside, &in->volume);
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
    if (settings->kind <= INTERPOLATE_CUBIC)
        err = mesh_find(stream, &mesh);
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
    const bool packed = fd >= 0 && !fstat(fd, &status) && S_ISREG(status.st_mode) &&
                        read(fd, start, sizeof start) == sizeof start &&
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
        const struct probe_place at = {.probe = {(int32_t)i, (int32_t)i, (int32_t)i, (int32_t)i},
                                       .weight = {1, 0, 0, 0}};
        probe_volume_light(in->volume, &at, in->owned + i * in->width);
    }
    in->value = in->owned;
    return err;
}

struct error *interpolate_open_packed(struct interpolate **interpolate, const char *path,
                                      const struct interpolate_settings *settings)
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
        const enum probe_status status =
            probe_volume_open(&in->volume, in->image, in->image_bytes, settings->outside, &row);
        err = error_wrap(mesh_error(status, row), "%s", path);
    }
    if (!err) {
        const struct probe_image_facts facts = probe_volume_image(in->volume);
        in->order = facts.order;
        in->width = (size_t)(3 * facts.order * facts.order);
        in->convolved = facts.convolved;
        if (settings->kind != INTERPOLATE_BARYCENTRIC)
            err = error_new(
                "%s: a packed file is interpolated from cells alone: --interpolate barycentric",
                path);
        else if (strcmp(settings->column, "sh"))
            err = error_new("%s: a packed file holds the column sh, and not %s", path,
                            settings->column);
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
    scatter_destroy(in->scatter);
    nodes_clear(&in->nodes);
    octree_clear(&in->octree);
    free(in->data);
    free(in->owned);
    if (in->image)
        munmap(in->image, in->image_bytes);
    free(in);
}

/* -- places ---------------------------------------------------------------------------------- */

/* Whether p is within the box of a grid or octree, and how far outside. */
static void find_in_box(const struct interpolate *in, const double p[3], struct probe_place *place)
{
    double square = 0;
    for (int k = 0; k < 3; k++) {
        const double low = in->data ? in->octree.low[k] : in->nodes.at[k][0],
                     high = in->data ? in->octree.high[k] : in->nodes.at[k][in->nodes.count[k] - 1],
                     off = fmax(fmax(low - p[k], p[k] - high), 0);
        square += off * off;
    }
    *place =
        (struct probe_place){.cell = PROBE_COLD, .inside = square == 0, .distance = sqrt(square)};
}

void interpolate_find(const struct interpolate *in, const double point[3],
                      struct probe_place *place)
{
    if (in->volume)
        probe_volume_locate(in->volume, point, place);
    else if (in->nodes.probe || in->data)
        find_in_box(in, point, place);
    else
        *place = (struct probe_place){.cell = PROBE_COLD,
                                      .inside = 1}; /* points without cells have no outside */
}

void interpolate_find_many(const struct interpolate *in, size_t count, const double *point,
                           size_t stride, const uint32_t *order, struct probe_place *place)
{
    if (in->volume)
        probe_volume_locate_many(in->volume, count, point, stride, order, place);
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

/* The blend is NaN: because of which probe. */
static struct error *missing(const struct interpolate *in, const struct probe_place *place)
{
    for (int i = 0; i < 4; i++) {
        const size_t probe = (size_t)place->probe[i];
        if (!(place->weight[i] > 0))
            continue;
        if (isnan(in->value[probe * in->width]))
            return unknown(in, place->probe[i]);
        if (in->gradient && isnan(in->gradient[3 * probe * in->width]))
            return error_new("probe %d has no gradient: run probe-capture", place->probe[i]);
    }
    return NULL;
}

/* How much of the value of corner i, and of its gradient along which way, a kind takes. u:
 * barycentric; way[i][j]: from corner i to corner j. */
static void taylor(const double u[4], double way[4][4][3], int i, double *value, double along[3])
{
    *value = u[i]; /* u_i (f_i + g_i . (q - p_i)), q - p_i = sum_j u_j way_ij */
    for (int j = 0; j < 4; j++)
        for (int k = 0; k < 3; k++)
            along[k] += u[i] * u[j] * way[i][j][k];
}

/* Farin 1986: control points on edges from the slopes at corners, b_iij = f_i + g_i . way_ij / 3;
 * in the middle of faces a quarter of the sum of the face's six of these less a sixth of its
 * corners' sum, which keeps quadratics. The Bernstein polynomials of all are gathered by corner. */
static void bezier(const double u[4], double way[4][4][3], int i, double *value, double along[3])
{
    *value = u[i] * u[i] * (3 - 2 * u[i]);
    for (int j = 0; j < 4; j++) {
        double others = 0;
        for (int k = 0; k < 4 && j != i; k++)
            others += k != i && k != j ? u[k] : 0;
        if (j == i)
            continue;
        *value += u[i] * u[j] * others; /* 6 u_i u_j u_k / 3 for each face, met twice */
        const double slope = u[i] * u[i] * u[j] + u[i] * u[j] * others / 2;
        for (int k = 0; k < 3; k++)
            along[k] += slope * way[i][j][k];
    }
}

static struct error *blend_gradients(const struct interpolate *in, const struct probe_place *place,
                                     float *out)
{
    double way[4][4][3];
    const size_t width = in->width;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            for (size_t k = 0; k < 3; k++)
                way[i][j][k] = in->position[3 * (size_t)place->probe[j] + k] -
                               in->position[3 * (size_t)place->probe[i] + k];
    for (size_t k = 0; k < width; k++)
        out[k] = 0;
    for (int i = 0; i < 4; i++) {
        double value = 0, along[3] = {0};
        if (!(place->weight[i] > 0))
            continue;
        (in->settings.kind == INTERPOLATE_CUBIC ? bezier : taylor)(place->weight, way, i, &value,
                                                                   along);
        const float v = (float)value, x = (float)along[0], y = (float)along[1], z = (float)along[2];
        const float *f = in->value + (size_t)place->probe[i] * width,
                    *g = in->gradient + 3 * (size_t)place->probe[i] * width;
        for (size_t k = 0; k < width; k++)
            out[k] += v * f[k] + ((x * g[k] + y * g[width + k]) + z * g[2 * width + k]);
    }
    return isnan(out[0]) ? missing(in, place) : NULL;
}

/* Weights of the nodes of a grid. */
static struct error *blend_nodes(const struct interpolate *in, const double p[3], float *out)
{
    size_t node[3][4];
    double weight[3][4];
    for (int k = 0; k < 3; k++)
        (in->settings.kind == INTERPOLATE_TRICUBIC ? nodes_cubic : nodes_linear)(
            &in->nodes, k, p[k], node[k], weight[k]);
    for (size_t k = 0; k < in->width; k++)
        out[k] = 0;
    for (int z = 0; z < 4; z++)
        for (int y = 0; y < 4; y++)
            for (int x = 0; x < 4; x++) {
                const float w = (float)(weight[0][x] * weight[1][y] * weight[2][z]);
                if (w == 0) /* what has no weight has no say, not even as a missing value */
                    continue;
                const int32_t probe =
                    in->nodes
                        .probe[(node[2][z] * in->nodes.count[1] + node[1][y]) * in->nodes.count[0] +
                               node[0][x]];
                const float *f = in->value + (size_t)probe * in->width;
                if (isnan(f[0]))
                    return unknown(in, probe);
                for (size_t k = 0; k < in->width; k++)
                    out[k] += w * f[k];
            }
    return NULL;
}

struct shepard {
    const struct interpolate *in;
    double sum;
    float *out;
};

static void add_probe(void *context, int32_t probe, double distance)
{
    struct shepard *s = context;
    const struct interpolate *in = s->in;
    const double c = 1 - distance / in->settings.radius;
    const double weight = in->settings.falloff == INTERPOLATE_FALL_LINEAR      ? c
                          : in->settings.falloff == INTERPOLATE_FALL_QUADRATIC ? c * c
                                                                               : c * c * c;
    const float *f = in->value + (size_t)probe * in->width;
    s->sum += weight;
    for (size_t k = 0; k < in->width; k++)
        s->out[k] += (float)weight * f[k];
}

/* Bikker and Reijerse 2009, section 5. Where no probe is within the radius, the nearest one's
 * value: that is what the sum becomes as the last one leaves. */
static void blend_scattered(const struct interpolate *in, const double p[3], float *out)
{
    struct shepard s = {.in = in, .out = out};
    for (size_t k = 0; k < in->width; k++)
        out[k] = 0;
    if (in->settings.kind == INTERPOLATE_SHEPARD)
        scatter_within(in->scatter, p, in->settings.radius, add_probe, &s);
    double distance;
    if (s.sum > 0)
        for (size_t k = 0; k < in->width; k++)
            out[k] = (float)((double)out[k] / s.sum);
    else
        memcpy(out, in->value + (size_t)scatter_nearest(in->scatter, p, &distance) * in->width,
               in->width * sizeof *out);
}

struct error *interpolate_at(const struct interpolate *in, const double point[3],
                             const struct probe_place *place, float *out)
{
    if (in->gradient)
        return blend_gradients(in, place, out);
    if (in->nodes.probe)
        return blend_nodes(in, point, out);
    if (in->data) {
        octree_at(&in->octree, in->settings.kind == INTERPOLATE_TRICUBIC, in->width, in->data,
                  point, out);
        return NULL;
    }
    if (in->scatter) {
        blend_scattered(in, point, out);
        return NULL;
    }
    probe_blend(place, in->value, in->width, out);
    return isnan(out[0]) ? missing(in, place) : NULL;
}
