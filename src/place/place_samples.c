/* SPDX-License-Identifier: Apache-2.0 */
/* The method `samples` of probe-place: points that are even over the faces between a stream's
 * probes, for probe-fit.
 *
 * Each face has samples in proportion to its area, by systematic sampling, and one at the least, so
 * that no vertex is without; column area is what each stands for, which keeps a sum over them
 * that of the surface. Where they are on a face goes by Sobol's points, seeded with the face.
 * A sample is what is interpolated there: position, and the normal that a renderer would shade by.
 */
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/options.h"
#include "math/random.h"
#include "math/sobol.h"
#include "math/vec.h"
#include "place/place.h"
#include "place/place_method.h"
#include "stream/faces.h"
#include "stream/stream.h"

#include <math.h>
#include <stdlib.h>

/* Samples a vertex, unless told otherwise: some five a triangle. */
enum { OF_A_VERTEX = 10 };

/* How many samples each face has, for the caller to free, and all of them. A face without an area
 * has none. */
static struct error *share_out(const struct faces *faces, double wanted, uint64_t seed,
                               uint32_t **samples, double *count)
{
    double all = 0, before = 0;
    struct random random = random_start(seed, faces->count, 0);
    const double start = random_double(&random);
    struct error *err = array_create(samples, faces->count, sizeof **samples);
    for (size_t i = 0; i < faces->count; i++)
        all += faces_area(faces, i);
    if (!err && !(all > 0))
        err = error_new("the faces have no area");
    *count = 0;
    for (size_t i = 0; i < faces->count && !err; i++) {
        const double area = faces_area(faces, i), to = before + wanted * (area / all);
        const double of_it = floor(to + start) - floor(before + start);
        (*samples)[i] = !(area > 0) ? 0 : of_it > 1 ? (uint32_t)of_it : 1;
        *count += (*samples)[i];
        before = to;
    }
    return err;
}

/* A point of the unit square as weights of a triangle's corners: halves are folded together. */
static void weights_of(double u, double v, float weight[3])
{
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    weight[1] = (float)u;
    weight[2] = (float)v;
    weight[0] = 1 - weight[1] - weight[2];
    weight[0] = weight[0] > 0 ? weight[0] : 0;
}

static struct error *append_sample(struct place *place, const struct faces *faces, size_t face,
                                   const float weight[3])
{
    struct vec3 position = {0, 0, 0}, normal = {0, 0, 0};
    for (size_t c = 0; c < 3; c++) {
        const size_t v = (size_t)faces->vertex[3 * face + c];
        const float *n = faces->normal + 3 * v;
        const double w = (double)weight[c];
        position = vec3_fma(position, w, vec3_load(faces->position + 3 * v));
        normal = vec3_fma(normal, w, (struct vec3){(double)n[0], (double)n[1], (double)n[2]});
    }
    double p[3], n[3];
    vec3_store(p, position);
    vec3_store(n, vec3_normalize(vec3_length(normal) > 1e-6 ? normal : faces_cross(faces, face)));
    for (size_t k = 0; k < 3; k++)
        place->normal[3 * place->count + k] = (float)n[k];
    return place_append(place, p);
}

static struct error *sample_face(struct place *place, const struct faces *faces, size_t face,
                                 uint32_t samples, uint64_t seed)
{
    struct random random = random_start(seed, face, 1);
    const uint32_t pair = random_u32(&random);
    const double area = faces_area(faces, face);
    struct table *columns = &place->columns;
    int32_t *of_face = column_i32(table_column(columns, "face"));
    float *weight = column_f32(table_column(columns, "weight")),
          *of_area = column_f32(table_column(columns, "area"));
    struct error *err = NULL;
    for (uint32_t i = 0; i < samples && !err; i++) {
        const size_t row = place->count;
        uint32_t u, v;
        sobol_pair(i, pair, &u, &v);
        weights_of(((double)u + .5) * 0x1p-32, ((double)v + .5) * 0x1p-32, weight + 3 * row);
        of_face[row] = (int32_t)face;
        of_area[row] = (float)(area / samples);
        err = append_sample(place, faces, face, weight + 3 * row);
    }
    return err;
}

static struct error *make(struct place *place, const struct faces *faces, double wanted,
                          const struct place_world *world)
{
    uint32_t *samples = NULL;
    double count = 0;
    struct error *err = share_out(faces, wanted, world->seed, &samples, &count);
    if (!err)
        err = place_check_count(count, world->most);
    if (!err)
        err = array_create(&place->normal, 3 * (size_t)count, sizeof *place->normal);
    if (!err)
        err = place_add_column(place, "face", COLUMN_I32, 1, NULL);
    if (!err)
        err = place_add_column(place, "weight", COLUMN_F32, 3, NULL);
    if (!err)
        err = place_add_column(place, "area", COLUMN_F32, 1, NULL);
    if (!err)
        err = table_resize(&place->columns, (size_t)count);
    for (size_t i = 0; i < faces->count && !err; i++)
        err = sample_face(place, faces, i, samples[i], world->seed);
    free(samples);
    return err;
}

static struct error *check(const struct place_options *o, bool scene)
{
    (void)o;
    return scene ? error_usage("samples: FILE has the faces: expected no SCENE") : NULL;
}

static struct error *place_by_options(struct place *place, const struct place_options *o,
                                      struct place_world *world)
{
    struct faces faces = {0};
    struct error *err = stream_read(&place->from, world->file);
    if (err)
        return err;
    err = faces_of(place->from, &faces);
    if (!err)
        err = make(place, &faces, o->count_given ? o->count : OF_A_VERTEX * (double)faces.vertices,
                   world);
    return error_wrap(err, "%s", file_input_name(world->file));
}

static const char *const shares[] = {"count", NULL};

const struct place_method place_method_samples = {.name = "samples",
                                                  .file_of = "vertices with faces",
                                                  .origin = 13,
                                                  .random = true,
                                                  .shares = shares,
                                                  .check = check,
                                                  .place = place_by_options};
