/* SPDX-License-Identifier: Apache-2.0 */
/* Colours of vertices and faces, from what files write to what a mesh has. */
#include "base/array.h"
#include "import/import.h"

#include <math.h>
#include <stdlib.h>

/* Between 1, which is white as a share, and 255, which is white as a code. */
static const float share_most = 2;

struct error *scene_colours_set(struct scene_colours *colours, size_t index, const double rgba[4])
{
    struct error *err =
        array_reserve(&colours->rgba, &colours->capacity, index + 1, 4 * sizeof *colours->rgba);
    if (err)
        return err;
    for (; colours->count <= index; colours->count++)
        colours->rgba[4 * colours->count] = NAN;
    for (int k = 0; k < 4; k++)
        colours->rgba[4 * index + (size_t)k] = (float)rgba[k];
    return NULL;
}

void scene_colours_clear(struct scene_colours *colours)
{
    free(colours->rgba);
    *colours = (struct scene_colours){0};
}

static uint16_t to_code(double share)
{
    return share > 0 ? share < 1 ? (uint16_t)(65535 * share + 0.5) : UINT16_MAX : 0;
}

/* The light of a share of sRGB's codes; between two codes, between their lights. */
static double to_light(double share)
{
    const double code = 255 * fmin(fmax(share, 0), 1);
    const int low = code < 254 ? (int)code : 254;
    const double light = (double)image_linear[low], next = (double)image_linear[low + 1];
    return light + (code - low) * (next - light);
}

/* What the colours are shares of: 1, or 255 where some are beyond any share. */
static double find_white(const struct scene_import *import, const struct scene_colours *colours)
{
    float most = 0;
    for (size_t i = 0; i < colours->count; i++)
        for (size_t k = 0; k < 3; k++)
            most = fmaxf(most, colours->rgba[4 * i + k]);
    if (most > 1 && most <= share_most)
        warnings_add(import->warnings, "colour above 1",
                     "%s: colours of vertices or faces of up to %g: 1 is used", import->path,
                     (double)most);
    return most > share_most ? 255 : 1;
}

/* Whether nothing is to be seen of anything. */
static bool all_hidden(const struct scene_colours *colours)
{
    bool hidden = colours->count > 0;
    for (size_t i = 0; i < colours->count && hidden; i++)
        hidden = colours->rgba[4 * i + 3] == 0;
    return hidden;
}

struct error *scene_import_colours(struct scene_import *import, const struct scene_colours *colours,
                                   size_t count, uint16_t **codes, bool *blended)
{
    const double white = find_white(import, colours);
    const bool hidden = all_hidden(colours);
    struct error *err = array_create(codes, 4 * count, sizeof **codes);
    if (err)
        return err;
    if (hidden)
        warnings_add(
            import->warnings, "alpha 0 everywhere",
            "%s: the colours of all vertices or faces have alpha 0, which hides all: taken "
            "for opaque",
            import->path);
    for (size_t i = 0; i < count; i++) {
        const float *from = colours->rgba + 4 * i;
        uint16_t *to = *codes + 4 * i;
        const bool stated = i < colours->count && !isnan(from[0]);
        for (int k = 0; k < 3; k++)
            to[k] = to_code(stated ? to_light((double)from[k] / white) : (double)colours->unstated);
        to[3] = stated && !hidden && from[3] >= 0 ? to_code((double)from[3] / white) : UINT16_MAX;
        *blended = *blended || to[3] < UINT16_MAX;
    }
    return NULL;
}
