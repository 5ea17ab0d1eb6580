/* SPDX-License-Identifier: Apache-2.0 */
#include "light/rotate.h"
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "base/warning.h"
#include "light/basis.h"
#include "math/angle.h"
#include "math/sphere_rule.h"
#include "math/vec.h"
#include "stream/cells.h"
#include "stream/header_number.h"
#include "stream/light_columns.h"
#include "stream/sight_key.h"
#include "stream/stream.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- matrices --------------------------------------------------------------------------------- */

static void turn(const double m[9], const double v[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = m[3 * k] * v[0] + m[3 * k + 1] * v[1] + m[3 * k + 2] * v[2];
}

/* a b, or a times b transposed. */
static void multiply(const double a[9], const double b[9], bool transposed, double out[9])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double sum = 0;
            for (int k = 0; k < 3; k++)
                sum += a[3 * i + k] * (transposed ? b[3 * j + k] : b[3 * k + j]);
            out[3 * i + j] = sum;
        }
}

static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* How far the products of the rows are from what rotations have, in all. */
static double unlike_rotation(const double m[9])
{
    double gram[9], sum = 0;
    multiply(m, m, true, gram);
    for (int k = 0; k < 9; k++)
        sum += fabs(gram[k] - identity[k]);
    return sum;
}

/* Rounds a matrix to a rotation; or says why it is none. */
static const char *make_right(double m[9])
{
    if (!(unlike_rotation(m) <= 2e-5))
        return "expected a rotation: rows of length 1 at right angles to each other";
    struct vec3 x = vec3_normalize(vec3_load(m)), y = vec3_load(m + 3);
    y = vec3_normalize(vec3_fma(y, -vec3_dot(x, y), x));
    const struct vec3 z = vec3_cross(x, y);
    if (vec3_dot(z, vec3_load(m + 6)) < 0)
        return "expected a rotation: the matrix mirrors (its determinant is -1)";
    vec3_store(m, x);
    vec3_store(m + 3, y);
    vec3_store(m + 6, z);
    for (int k = 0; k < 9; k++)
        if (fabs(m[k] - round(m[k])) < 1e-15)
            m[k] = round(m[k]) + 0.0; /* 0 has no sign */
    return NULL;
}

/* Rodrigues' formula. */
static struct error *about_axis(const double axis[3], double degrees, double m[9])
{
    const double size = fmax(fmax(fabs(axis[0]), fabs(axis[1])), fabs(axis[2]));
    if (!(size > 0))
        return error_usage("expected an axis, got 0,0,0");
    if (!(fabs(degrees) <= 36000))
        return error_usage("expected an angle of -36000 to 36000 degrees, got %.15g", degrees);
    struct vec3 u = {axis[0] / size, axis[1] / size, axis[2] / size};
    u = vec3_normalize(u);
    const double angle = fmod(degrees, 360) * (ANGLE_PI / 180), c = angle_cos(angle),
                 s = angle_sin(angle);
    const double n[3] = {u.x, u.y, u.z}, across[9] = {0, -u.z, u.y, u.z, 0, -u.x, -u.y, u.x, 0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m[3 * i + j] = (1 - c) * n[i] * n[j] + c * identity[3 * i + j] + s * across[3 * i + j];
    return NULL;
}

struct error *rotation_parse(double matrix[9], const char *option, const char *text)
{
    double n[4];
    int commas = 0;
    for (const char *c = text; *c; c++)
        commas += *c == ',';
    if (commas != 3 && commas != 8)
        return error_usage("expected X,Y,Z,DEGREES or the nine numbers of a matrix, got '%s'",
                           text);
    if (commas == 3) {
        struct error *err = options_reals(option, text, 4, n);
        return err ? err : about_axis(n, n[3], matrix);
    }
    struct error *err = options_reals(option, text, 9, matrix);
    const char *why = err ? NULL : make_right(matrix);
    return why ? error_usage("%s", why) : err;
}

struct error *rotation_init(struct rotation *rotation, const double matrix[9])
{
    *rotation = (struct rotation){0};
    memcpy(rotation->matrix, matrix, sizeof rotation->matrix);
    const char *why = make_right(rotation->matrix);
    if (why)
        return error_new("%s", why);
    for (int i = 0; i < 3; i++)
        memcpy(rotation->cone[i], rotation->matrix + 3 * i, 3 * sizeof(double));
    rotation->cone[3][3] = 1;
    for (int k = 0; k < SPHERE_RULE_COUNT; k++) {
        double d[3], turned[3], y[SH_COUNT_MAX], y_turned[SH_COUNT_MAX];
        const double weight = sphere_rule(k, d);
        turn(rotation->matrix, d, turned);
        sh_basis(SH_ORDER_MAX, d, y);
        sh_basis(SH_ORDER_MAX, turned, y_turned);
        for (int l = 0; l < SH_ORDER_MAX; l++)
            for (int i = l * l; i < (l + 1) * (l + 1); i++)
                for (int j = l * l; j < (l + 1) * (l + 1); j++)
                    rotation->sh[i][j] += weight * y_turned[i] * y[j];
    }
    return NULL;
}

void rotation_sh(const struct rotation *rotation, int order, int channels, const double *in,
                 double *out)
{
    for (int l = 0; l < order; l++)
        for (int i = l * l; i < (l + 1) * (l + 1); i++)
            for (int c = 0; c < channels; c++) {
                double sum = 0;
                for (int j = l * l; j < (l + 1) * (l + 1); j++)
                    sum += rotation->sh[i][j] * in[channels * j + c];
                out[channels * i + c] = sum;
            }
}

/* -- columns ---------------------------------------------------------------------------------- */

/* A row: blocks of SH, or of plain numbers, that a matrix mixes among each other. */
struct row_shape {
    int order; /* of each block; 1: nothing to turn */
    int channels;
    size_t blocks;
    /* blocks^2, of block i from block j, `across` numbers from row to row; NULL: not mixed */
    const double *mix;
    size_t across;
};

/* Turns one row; squared: a standard error, whose squares the squared matrices turn. */
static void turn_row(const struct rotation *rotation, const struct row_shape *s, bool squared,
                     float *row, double *work)
{
    const size_t width = (size_t)(s->channels * s->order * s->order), all = s->blocks * width;
    double *in = work, *turned = work + all;
    for (size_t i = 0; i < all; i++)
        in[i] = squared ? (double)row[i] * (double)row[i] : (double)row[i];
    for (size_t b = 0; b < s->blocks; b++)
        rotation_sh(rotation, s->order, s->channels, in + b * width, turned + b * width);
    for (size_t b = 0; b < s->blocks; b++)
        for (size_t i = 0; i < width; i++) {
            double sum = s->mix ? 0 : turned[b * width + i];
            for (size_t k = 0; k < s->blocks && s->mix; k++) {
                const double m = s->mix[b * s->across + k];
                sum += (squared ? m * m : m) * turned[k * width + i];
            }
            row[b * width + i] = (float)(squared ? sqrt(sum) : sum);
        }
}

static struct error *turn_column(const struct rotation *rotation, const struct row_shape *shape,
                                 bool error, struct column *column, size_t rows)
{
    struct rotation squared = {0};
    double *work = NULL;
    struct error *err = array_create(&work, 2 * column->width, sizeof *work);
    if (error)
        for (int i = 0; i < SH_COUNT_MAX; i++)
            for (int j = 0; j < SH_COUNT_MAX; j++)
                squared.sh[i][j] = rotation->sh[i][j] * rotation->sh[i][j];
    for (size_t i = 0; i < rows && !err; i++) {
        float *row = column_f32(column) + i * column->width;
        if (!isnan(row[0]))
            turn_row(error ? &squared : rotation, shape, error, row, work);
    }
    free(work);
    return err;
}

static bool is_one_of(const char *name, const char *const *names)
{
    while (*names && strcmp(name, *names))
        names++;
    return *names != NULL;
}

/* The shape of a column of table probe that holds light. Of a transfer, block j is the answer to
 * function j of the sky, which turns, too: T' = M T M^-1. */
static bool shape_of_light(const struct rotation *rotation, const struct light_column *what,
                           bool sky, bool light_only, struct row_shape *shape)
{
    const bool matrix = what->transfer && !light_only && sky;
    *shape = (struct row_shape){
        .order = what->surface ? 1 : sh_order_of(3 * what->block / (size_t)what->channels),
        .channels = what->channels,
        .blocks = what->blocks,
        .across = matrix ? SH_COUNT_MAX : 3};
    if (matrix)
        shape->mix = rotation->sh[0];
    else if (what->role == LIGHT_GRADIENT && !light_only)
        shape->mix = rotation->matrix;
    return !matrix || what->blocks <= SH_COUNT_MAX;
}

/* The shape of a column of table probe that knows directions; false: it knows none. *error: it
 * holds standard errors. */
static bool find_shape(const struct rotation *rotation, const struct table *probes,
                       const struct column *c, bool light_only, struct row_shape *shape,
                       bool *error)
{
    static const char *const plain[] = {"normal", "hull_normal", NULL}, *const of_light[] = {
                                                                            "bent_normal",
                                                                            "gradient", NULL};
    const struct column *sh = table_column(probes, "sh");
    struct light_column what;
    *error = false;
    *shape = (struct row_shape){.order = 1, .channels = 1, .blocks = 1, .across = 3};
    if (light_column_of(c, sh ? sh->width : 0, &what)) {
        *error = what.role == LIGHT_ERROR;
        return shape_of_light(rotation, &what, !strncmp(c->name, "transfer_sky", 12), light_only,
                              shape);
    }
    if (!strcmp(c->name, "visibility") && c->type == COLUMN_F32) {
        shape->order = sh_order_of(3 * c->width);
        return shape->order > 0;
    }
    if (!strcmp(c->name, "cone") && c->type == COLUMN_F32 && c->width == 4) {
        shape->blocks = shape->across = 4;
        shape->mix = rotation->cone[0];
        return true;
    }
    shape->blocks = 3;
    shape->mix = rotation->matrix;
    return c->type == COLUMN_F32 && c->width == 3 &&
           (is_one_of(c->name, of_light) || (!light_only && is_one_of(c->name, plain)));
}

static struct error *turn_columns(struct table *probes, const struct rotation *rotation,
                                  bool light_only)
{
    struct error *err = NULL;
    for (size_t i = 0; i < probes->column_count && !err; i++) {
        struct row_shape shape;
        struct column *c = &probes->columns[i];
        bool error;
        if (find_shape(rotation, probes, c, light_only, &shape, &error))
            err = turn_column(rotation, &shape, error, c, probes->rows);
    }
    return err;
}

/* Positions, and the places of the surface that vertices stand off from. */
static void turn_positions(struct table *probes, const struct rotation *rotation)
{
    static const char *const names[] = {"position", "surface"};
    for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
        const struct column *column = table_column(probes, names[n]);
        double *p = column ? column_f64(column) : NULL;
        for (size_t i = 0; p && i < probes->rows; i++, p += 3) {
            const double before[3] = {p[0], p[1], p[2]};
            turn(rotation->matrix, before, p);
        }
    }
}

/* What is seen outside of the hull changes along the axes. */
static struct error *turn_cells(struct stream *stream, const struct rotation *rotation)
{
    struct error *err = NULL;
    for (size_t i = 0; i < stream->table_count && !err; i++) {
        struct table *table = &stream->tables[i];
        struct column *c = table_column(table, "sight_outside");
        if (!stream_cell_corners(table->name) || !c || c->width % 3)
            continue;
        const struct row_shape one = {
            .order = 1, .channels = 1, .blocks = 3, .mix = rotation->matrix, .across = 3};
        struct column part = {.type = COLUMN_F32, .width = 3, .data = c->data};
        err = turn_column(rotation, &one, false, &part, table->rows * (c->width / 3));
    }
    return err;
}

/* -- the header ------------------------------------------------------------------------------- */

static struct error *get_matrix(const struct stream_header *header, const char *key, double m[9])
{
    memcpy(m, identity, sizeof identity);
    struct error *err = header_get_reals(header, key, 9, -1.001, 1.001, m);
    const char *why = err ? NULL : make_right(m);
    return why ? error_new("header key %s: %s", key, why) : err;
}

/* No key where it is no turn. */
static struct error *set_matrix(struct stream_header *header, const char *key, const double m[9])
{
    double away = 0;
    for (int k = 0; k < 9; k++)
        away = fmax(away, fabs(m[k] - identity[k]));
    header_remove_key(header, key);
    return away < 1e-9 ? NULL : header_set_reals(header, key, 9, m);
}

/* The suns and points of a transfer stand elsewhere. */
static struct error *turn_lights(struct stream_header *header, const struct rotation *rotation)
{
    struct error *err = NULL;
    for (size_t k = 0; k < header->key_count && !err; k++) {
        const char *name = header->keys[k].name;
        double before[3], after[3];
        const bool sun = !strncmp(name, "transfer-sun-", 13);
        if (!sun && strncmp(name, "transfer-point-", 15) != 0)
            continue;
        err = header_get_reals(header, name, 3, sun ? -1.001 : -DBL_MAX, sun ? 1.001 : DBL_MAX,
                               before);
        if (err)
            break;
        turn(rotation->matrix, before, after);
        err = header_set_reals(header, name, 3, after);
    }
    return err;
}

/* The light alone was turned in the frame of the probes, which turns now: R L R^-1. */
static struct error *turn_header(struct stream_header *header, const struct rotation *rotation,
                                 bool light_only)
{
    double all[9], light[9], product[9];
    struct error *err = get_matrix(header, ROTATED_KEY, all);
    if (!err)
        err = get_matrix(header, ROTATED_LIGHT_KEY, light);
    if (err)
        return err;
    multiply(rotation->matrix, light, false, product);
    if (light_only)
        return set_matrix(header, ROTATED_LIGHT_KEY, product);
    multiply(product, rotation->matrix, true, light);
    multiply(rotation->matrix, all, false, product);
    err = set_matrix(header, ROTATED_LIGHT_KEY, light);
    if (!err)
        err = set_matrix(header, ROTATED_KEY, product);
    return err ? err : turn_lights(header, rotation);
}

/* -- streams ---------------------------------------------------------------------------------- */

static void forget_bases(struct table *probes, struct warnings *warnings)
{
    for (int i = 0; i < BASIS_COUNT; i++)
        if (table_column(probes, basis_column((enum basis)i)))
            warnings_add(warnings, "basis dropped",
                         "column %s is along the axes as they were: dropped (--basis %s makes it "
                         "anew)",
                         basis_column((enum basis)i), basis_name((enum basis)i));
    if (table_column(probes, "horizon")) {
        warnings_add(
            warnings, "horizon dropped",
            "column horizon is by azimuths as they were: dropped (probe-capture --light none "
            "makes it anew before)");
        table_remove_column(probes, "horizon");
    }
    basis_drop(probes);
}

/* The sight of cells stays true of these cells, wherever they are. */
static struct error *keep_sight(struct stream *stream)
{
    const char *surfaces = header_key(&stream->header, CELLS_SIGHT_SCENE);
    return surfaces ? sight_key_set(stream, strtoull(surfaces, NULL, 16)) : NULL;
}

static struct error *check(const struct table *probes, bool light_only)
{
    if (!probes)
        return error_new("there are no probes to turn (no table probe)");
    if (light_only && table_column(probes, "irradiance"))
        return error_new("the probes are of surfaces, whose irradiance is of one normal: expected "
                         "--rotate, which turns both");
    if (light_only && !table_column(probes, "sh"))
        return error_new("the probes have no light to turn (no column sh): run probe-capture");
    for (size_t i = 0; i < probes->column_count; i++)
        if (light_column_is_compressed(probes->columns[i].name))
            return error_new("groups and transfers are compressed (column %s), and cannot be "
                             "turned: turn the stream before probe-relight --compress, or what was "
                             "relit",
                             probes->columns[i].name);
    return NULL;
}

struct error *rotate_stream(struct stream *stream, const struct rotation *rotation, bool light_only,
                            struct warnings *warnings)
{
    struct table *probes = stream_table(stream, "probe");
    struct error *err = check(probes, light_only);
    if (!err)
        err = sight_drop_stale(stream, warnings);
    if (err)
        return err;
    forget_bases(probes, warnings);
    err = turn_columns(probes, rotation, light_only);
    if (!err && !light_only)
        err = turn_cells(stream, rotation);
    if (!err && !light_only)
        turn_positions(probes, rotation);
    if (!err && !light_only)
        err = keep_sight(stream);
    /* bare probes are of no scene */
    return !err && header_key(&stream->header, "scene-key")
               ? turn_header(&stream->header, rotation, light_only)
               : err;
}
