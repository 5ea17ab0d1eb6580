/* SPDX-License-Identifier: Apache-2.0 */
#include "render/overlay.h"
#include "base/array.h"
#include "base/error.h"
#include "base/threads.h"
#include "interpolate/baked.h"
#include "interpolate/cells_volume.h"
#include "math/angle.h"
#include "math/box.h"
#include "math/power.h"
#include "math/sort.h"
#include "scene/scene.h"
#include "stream/cells.h"
#include "stream/stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TILE = RENDER_TILE, ACROSS = 4 }; /* rays of a pixel: ACROSS^2 */

static const double line_width = 1; /* pixels */
static const float line_opacity = 0.5f;
/* share of its distance by which a line may be behind a surface that it lies on */
static const double line_lift = 1e-4;
const struct vec3f overlay_line = {0.95f, 0.75f, 0.05f};

/* A cell's edge on the picture: its ends in pixels, and 1 / depth there. */
struct line {
    double x[2], y[2], nearness[2];
};

/* Numbers of things, by the tile that they may touch. */
struct bins {
    size_t *start; /* tile t: item[start[t] .. start[t + 1]) */
    uint32_t *item;
};

struct drawing {
    const struct render *render;
    const struct baked *baked;
    const double *position;
    size_t probes;
    double radius, share; /* of a sphere; at most, of its distance */
    struct line *lines;
    size_t line_count;
    size_t across, tiles;
    struct bins sphere_bins, line_bins;
    const struct overlay *overlay;
};

static double sphere_radius(const struct drawing *d, size_t probe)
{
    const struct vec3 way = vec3_sub(vec3_load(d->position + 3 * probe), d->render->camera->eye);
    return d->share > 0 ? fmin(d->radius, d->share * vec3_length(way)) : d->radius;
}

/* -- which tiles ------------------------------------------------------------------------------ */

struct rectangle {
    double left, top, right, bottom; /* pixels */
};

static struct rectangle everywhere(const struct camera *c)
{
    return (struct rectangle){0, 0, (double)c->width, (double)c->height};
}

/* Extremes of a / z over a in [a0, a1] and z in [z0, z1], z0 > 0. */
static void quotient_range(double a0, double a1, double z0, double z1, double *low, double *high)
{
    *low = a0 < 0 ? a0 / z0 : a0 / z1;
    *high = a1 > 0 ? a1 / z0 : a1 / z1;
}

/* Around a sphere; false: it is not in the picture. */
static bool sphere_rectangle(const struct camera *c, struct vec3 centre, double radius,
                             struct rectangle *rectangle)
{
    const struct vec3 way = vec3_sub(centre, c->eye);
    const double x = vec3_dot(way, c->right), y = -vec3_dot(way, c->up),
                 z = vec3_dot(way, c->forward);
    *rectangle = everywhere(c);
    if (z + radius <= 0)
        return false;
    if (z - radius <= radius / 16)
        return true;
    double low, high;
    quotient_range(x - radius, x + radius, z - radius, z + radius, &low, &high);
    rectangle->left = (low / c->half_width + 1) / 2 * (double)c->width;
    rectangle->right = (high / c->half_width + 1) / 2 * (double)c->width;
    quotient_range(y - radius, y + radius, z - radius, z + radius, &low, &high);
    rectangle->top = (low / c->half_height + 1) / 2 * (double)c->height;
    rectangle->bottom = (high / c->half_height + 1) / 2 * (double)c->height;
    return rectangle->right > 0 && rectangle->left < (double)c->width && rectangle->bottom > 0 &&
           rectangle->top < (double)c->height;
}

/* Cuts a line to the picture, with a margin (Liang and Barsky 1984); false: nothing is left. */
static bool cut_line(const struct camera *c, struct line *l)
{
    const double margin = 2 * line_width, low[2] = {-margin, -margin};
    const double high[2] = {(double)c->width + margin, (double)c->height + margin};
    const double start[2] = {l->x[0], l->y[0]}, step[2] = {l->x[1] - l->x[0], l->y[1] - l->y[0]};
    double from = 0, to = 1;
    for (int k = 0; k < 2; k++) {
        if (step[k] == 0 && (start[k] < low[k] || start[k] > high[k]))
            return false;
        if (step[k] == 0)
            continue;
        const double a = (low[k] - start[k]) / step[k], b = (high[k] - start[k]) / step[k];
        from = fmax(from, fmin(a, b));
        to = fmin(to, fmax(a, b));
    }
    if (!(from < to))
        return false;
    const struct line whole = *l;
    for (int end = 0; end < 2; end++) {
        const double s = end ? to : from;
        l->x[end] = whole.x[0] + s * step[0];
        l->y[end] = whole.y[0] + s * step[1];
        l->nearness[end] = whole.nearness[0] + s * (whole.nearness[1] - whole.nearness[0]);
    }
    return true;
}

/* Squared distance of (x, y) from a line; *at: where along it, 0 .. 1. */
static double line_square(const struct line *l, double x, double y, double *at)
{
    const double dx = l->x[1] - l->x[0], dy = l->y[1] - l->y[0], length = dx * dx + dy * dy;
    const double s = length > 0 ? ((x - l->x[0]) * dx + (y - l->y[0]) * dy) / length : 0;
    *at = fmin(fmax(s, 0), 1);
    const double px = l->x[0] + *at * dx - x, py = l->y[0] + *at * dy - y;
    return px * px + py * py;
}

static size_t tile_of(double pixel, size_t count)
{
    const double t = floor(pixel / TILE);
    return t < 0 ? 0 : t < (double)count ? (size_t)t : count - 1;
}

/* Calls once for each tile that item i may touch: counts them, or where bins->item is there puts i
 * into them. */
static void touch(const struct drawing *d, struct bins *bins, uint32_t i,
                  const struct rectangle *rectangle, const struct line *line)
{
    const size_t down = d->tiles / d->across;
    const double reach = TILE * 0.70710678118654752 + line_width;
    for (size_t row = tile_of(rectangle->top, down); row <= tile_of(rectangle->bottom, down); row++)
        for (size_t column = tile_of(rectangle->left, d->across);
             column <= tile_of(rectangle->right, d->across); column++) {
            double at;
            const double x = ((double)column + 0.5) * TILE, y = ((double)row + 0.5) * TILE;
            if (line && line_square(line, x, y, &at) > reach * reach)
                continue;
            size_t *count = &bins->start[row * d->across + column + 1];
            if (bins->item)
                bins->item[*count] = i;
            ++*count;
        }
}

/* Visits all items, lines or spheres. */
static void touch_all(const struct drawing *d, struct bins *bins, bool lines)
{
    for (size_t i = 0; lines && i < d->line_count; i++) {
        const struct line *l = &d->lines[i];
        const struct rectangle rectangle = {
            fmin(l->x[0], l->x[1]) - line_width, fmin(l->y[0], l->y[1]) - line_width,
            fmax(l->x[0], l->x[1]) + line_width, fmax(l->y[0], l->y[1]) + line_width};
        touch(d, bins, (uint32_t)i, &rectangle, l);
    }
    struct rectangle rectangle;
    for (size_t i = 0; !lines && d->radius > 0 && i < d->probes; i++)
        if (sphere_rectangle(d->render->camera, vec3_load(d->position + 3 * i), sphere_radius(d, i),
                             &rectangle))
            touch(d, bins, (uint32_t)i, &rectangle, NULL);
}

/* Two passes: counts become starts, and each item that is put in moves its tile's start on, to the
 * next's in the end. */
static struct error *bins_init(struct bins *bins, const struct drawing *d, bool lines)
{
    struct error *err = array_create(&bins->start, d->tiles + 1, sizeof *bins->start);
    if (err)
        return err;
    touch_all(d, bins, lines);
    size_t sum = 0;
    for (size_t t = 1; t <= d->tiles; t++) {
        const size_t count = bins->start[t];
        bins->start[t] = sum;
        sum += count;
    }
    err = array_create(&bins->item, sum, sizeof *bins->item);
    if (!err)
        touch_all(d, bins, lines);
    return err;
}

/* -- lines ------------------------------------------------------------------------------------ */

static int compare_edges(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Every edge of the cells once, as lower probe << 32 | higher; *edge is the caller's to free. */
static struct error *find_edges(const struct stream *stream, uint64_t **edge, size_t *count)
{
    struct probe_mesh mesh;
    *edge = NULL;
    *count = 0;
    struct error *err = cells_volume_mesh(stream, &mesh);
    if (err)
        return err;
    const size_t corners = (size_t)mesh.corners, most = mesh.cells * (corners * (corners - 1) / 2);
    err = array_create(edge, most, sizeof **edge);
    if (err)
        return err;
    size_t all = 0;
    for (size_t cell = 0; cell < mesh.cells; cell++)
        for (size_t i = 0; i < corners; i++)
            for (size_t k = i + 1; k < corners; k++) {
                const uint64_t a = (uint64_t)mesh.vertex[corners * cell + i],
                               b = (uint64_t)mesh.vertex[corners * cell + k];
                (*edge)[all++] = a < b ? a << 32 | b : b << 32 | a;
            }
    qsort(*edge, most, sizeof **edge, compare_edges);
    for (size_t i = 0; i < most; i++)
        if (!i || (*edge)[i] != (*edge)[i - 1])
            (*edge)[(*count)++] = (*edge)[i];
    return NULL;
}

/* An edge as it falls on the picture; false: it does not. */
static bool project_edge(const struct camera *c, struct vec3 a, struct vec3 b, struct line *l)
{
    const double za = vec3_dot(vec3_sub(a, c->eye), c->forward),
                 zb = vec3_dot(vec3_sub(b, c->eye), c->forward);
    const double near = 1e-6 * (fabs(za) + fabs(zb));
    double depth;
    if (!(za > near || zb > near))
        return false;
    if (za < near)
        a = vec3_fma(a, (near - za) / (zb - za), vec3_sub(b, a));
    if (zb < near)
        b = vec3_fma(b, (near - zb) / (za - zb), vec3_sub(a, b));
    if (!camera_project(c, a, &l->x[0], &l->y[0], &depth))
        return false;
    l->nearness[0] = 1 / depth;
    if (!camera_project(c, b, &l->x[1], &l->y[1], &depth))
        return false;
    l->nearness[1] = 1 / depth;
    return cut_line(c, l);
}

static struct error *find_lines(struct drawing *d, const struct stream *stream)
{
    uint64_t *edge = NULL;
    size_t count = 0;
    struct error *err = find_edges(stream, &edge, &count);
    if (!err)
        err = array_create(&d->lines, count, sizeof *d->lines);
    for (size_t i = 0; i < count && !err; i++) {
        const double *a = d->position + 3 * (size_t)(edge[i] >> 32),
                     *b = d->position + 3 * (size_t)(edge[i] & UINT32_MAX);
        d->line_count +=
            project_edge(d->render->camera, vec3_load(a), vec3_load(b), &d->lines[d->line_count]);
    }
    free(edge);
    return err;
}

/* -- rays ------------------------------------------------------------------------------------- */

/* How far the scene is along a direction; cut-outs are holes. */
static double scene_depth(const struct render *r, struct vec3 direction)
{
    const double skipped = render_ray(r, direction).skipped;
    double start[3], way[3];
    vec3_store(start, vec3_fma(r->camera->eye, skipped, direction));
    vec3_store(way, direction);
    const struct trace_hit hit = trace_nearest(r->path->tracer, start, way, (double)INFINITY);
    return hit.hit ? skipped + hit.distance : (double)INFINITY;
}

/* The nearest sphere before `depth`: its number, or SIZE_MAX; *depth becomes its own. */
static size_t nearest_sphere(const struct drawing *d, size_t tile, struct vec3 direction,
                             double *depth)
{
    size_t found = SIZE_MAX;
    for (size_t k = d->sphere_bins.start[tile]; k < d->sphere_bins.start[tile + 1]; k++) {
        const size_t i = d->sphere_bins.item[k];
        const struct vec3 way = vec3_sub(vec3_load(d->position + 3 * i), d->render->camera->eye);
        const double along = vec3_dot(way, direction);
        const struct vec3 aside = vec3_fma(way, -along, direction);
        const double radius = sphere_radius(d, i), under = radius * radius - vec3_dot(aside, aside),
                     t = along - sqrt(fmax(under, 0));
        if (under > 0 && t > 0 && t < *depth) {
            *depth = t;
            found = i;
        }
    }
    return found;
}

static bool line_before(const struct drawing *d, size_t tile, double x, double y, double depth)
{
    for (size_t k = d->line_bins.start ? d->line_bins.start[tile] : 0;
         d->line_bins.start && k < d->line_bins.start[tile + 1]; k++) {
        const struct line *l = &d->lines[d->line_bins.item[k]];
        double at;
        if (line_square(l, x, y, &at) > line_width * line_width / 4)
            continue;
        const double z = 1 / (l->nearness[0] + at * (l->nearness[1] - l->nearness[0]));
        if (z <= depth * (1 + line_lift))
            return true;
    }
    return false;
}

static struct vec3f sphere_light(const struct drawing *d, size_t probe, struct vec3 direction,
                                 double depth)
{
    const struct vec3 at = vec3_fma(d->render->camera->eye, depth, direction);
    const struct vec3 normal = vec3_normalize(vec3_sub(at, vec3_load(d->position + 3 * probe)));
    double n[3], e[3];
    vec3_store(n, normal);
    for (int k = 0; k < 3; k++)
        e[k] = -vec3_dot(normal, direction); /* grey, as if lit from the eye */
    if (d->baked)
        baked_probe_irradiance(d->baked, probe, n, e);
    return (struct vec3f){(float)(e[0] / ANGLE_PI), (float)(e[1] / ANGLE_PI),
                          (float)(e[2] / ANGLE_PI)};
}

static void draw_pixel(const struct drawing *d, size_t tile, size_t x, size_t y)
{
    const struct camera *c = d->render->camera;
    struct vec3f light = {0};
    int spheres = 0, lines = 0;
    for (int i = 0; i < ACROSS * ACROSS; i++) {
        const double px = (double)x + (i % ACROSS + 0.5) / ACROSS,
                     py = (double)y + (0.5 + (double)(i / ACROSS)) / ACROSS;
        const struct vec3 direction = camera_direction(c, px, py);
        double depth = scene_depth(d->render, direction);
        const size_t sphere = nearest_sphere(d, tile, direction, &depth);
        if (line_before(d, tile, px, py, depth * vec3_dot(direction, c->forward))) {
            lines++;
        } else if (sphere != SIZE_MAX) {
            spheres++;
            light = vec3f_add(light, sphere_light(d, sphere, direction, depth));
        }
    }
    if (spheres)
        picture_set(&d->overlay->light, x, y, vec3f_scale(1 / (float)spheres, light));
    const float rays = ACROSS * ACROSS;
    picture_set(&d->overlay->share, x, y,
                (struct vec3f){(float)spheres / rays, line_opacity * (float)lines / rays, 0});
}

static struct error *draw_tile(void *context, size_t tile, int thread)
{
    (void)thread;
    const struct drawing *d = context;
    const struct camera *c = d->render->camera;
    const bool spheres = d->sphere_bins.start[tile] < d->sphere_bins.start[tile + 1];
    const bool lines = d->line_bins.start &&
                       d->line_bins.start[tile] < d->line_bins.start[tile + 1];
    const size_t left = tile % d->across * TILE, top = tile / d->across * TILE;
    if (!spheres && !lines)
        return NULL;
    for (size_t y = top; y < top + TILE && y < c->height; y++)
        for (size_t x = left; x < left + TILE && x < c->width; x++)
            draw_pixel(d, tile, x, y);
    return NULL;
}

/* -- all of it -------------------------------------------------------------------------------- */

struct error *overlay_init(struct overlay *overlay, const struct render *render,
                           const struct stream *stream, const struct baked *baked,
                           const struct overlay_settings *settings)
{
    const struct camera *c = render->camera;
    const struct table *probes = stream_table(stream, "probe");
    if (!probes)
        return error_new("there is no table probe");
    struct drawing d = {.render = render,
                        .baked = baked,
                        .position = column_f64(table_column(probes, "position")),
                        .probes = probes->rows,
                        .radius = settings->probe_radius,
                        .share = settings->probe_share,
                        .across = (c->width + TILE - 1) / TILE,
                        .tiles = render_tiles(c),
                        .overlay = overlay};
    struct error *err = picture_init(&overlay->light, c->width, c->height);
    if (!err)
        err = picture_init(&overlay->share, c->width, c->height);
    if (!err)
        err = bins_init(&d.sphere_bins, &d, false);
    if (!err && settings->cells)
        err = find_lines(&d, stream);
    if (!err && settings->cells)
        err = bins_init(&d.line_bins, &d, true);
    if (!err)
        err = threads_for(render->threads, d.tiles, draw_tile, &d);
    free(d.lines);
    free(d.sphere_bins.start);
    free(d.sphere_bins.item);
    free(d.line_bins.start);
    free(d.line_bins.item);
    return err;
}

void overlay_clear(struct overlay *overlay)
{
    picture_clear(&overlay->light);
    picture_clear(&overlay->share);
}

struct error *overlay_spacing(const struct stream *stream, double *spacing)
{
    const struct table *probes = stream_table(stream, "probe");
    uint64_t *edge = NULL;
    double *length = NULL;
    size_t count = 0;
    if (!probes || !probes->rows)
        return error_new("there are no probes");
    const double *p = column_f64(table_column(probes, "position"));
    struct error *err = NULL;
    if (cells_exist(stream))
        err = find_edges(stream, &edge, &count);
    if (!err)
        err = array_create(&length, count, sizeof *length);
    for (size_t i = 0; i < count && !err; i++)
        length[i] = vec3_length(vec3_sub(vec3_load(p + 3 * (edge[i] >> 32)),
                                         vec3_load(p + 3 * (edge[i] & UINT32_MAX))));
    if (count && !err) {
        sort_doubles(count, length);
        *spacing = length[count / 2];
    } else if (!err) {
        const struct box box = box_of(probes->rows, p);
        double volume = 1;
        for (int k = 0; k < 3; k++)
            volume *= box.high[k] - box.low[k];
        *spacing = power_of(volume / (double)probes->rows, 1.0 / 3);
    }
    free(edge);
    free(length);
    return err;
}

struct vec3f overlay_over(const struct overlay *o, size_t x, size_t y, struct vec3f under,
                          struct vec3f light, struct vec3f line)
{
    const struct vec3f share = picture_get(&o->share, x, y);
    return vec3f_add(vec3f_scale(1 - share.x - share.y, under),
                     vec3f_add(vec3f_scale(share.x, light), vec3f_scale(share.y, line)));
}
