/* SPDX-License-Identifier: Apache-2.0 */
/* Surfaces: discs (discs.h) with irradiance, and packed files of them, as man/libprobe-query.3
 * specifies them: a header of 128 bytes, the discs, what they hold.
 *
 * Based on: Collet, XXH3, https://xxhash.com: the checksum.
 */
#include "discs.h"
#include "half.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

enum { SURFACE_VERSION = 1 };

struct surface_header {
    char magic[8];
    uint64_t checksum; /* XXH3-64 of all that follows it */
    uint32_t version;
    uint8_t packing, nothing[3];
    uint64_t probes;
    double origin[3], scale; /* of the grid, as discs_grid has them */
    int32_t cells[3];
    float light_scale; /* irradiance = light_scale * what is stored */
    uint64_t size;     /* of the whole */
    uint64_t unused[5];
};
_Static_assert(sizeof(struct surface_header) == 128, "the header is packed");

static const char surface_magic[8] = {'p', 'r', 'o', 'b', 'e', 's', 'r', 'f'};

struct probe_surface {
    struct discs *discs;     /* owned */
    const float *irradiance; /* 3 a probe */
    float *own;              /* the same, of halves; owned */
    size_t probes;           /* of the arrays; of a packed file, discs */
};

static size_t value_bytes(const struct surface_header *h)
{
    return h->packing == PROBE_PACK_HALF ? 2 : 4;
}

/* Parts begin at multiples of 64: a header has 128, a disc 32. */
static size_t values_at(const struct surface_header *h)
{
    return (sizeof *h + (size_t)h->probes * sizeof(struct disc) + 63) / 64 * 64;
}

static size_t size_of(const struct surface_header *h)
{
    return (values_at(h) + 3 * (size_t)h->probes * value_bytes(h) + 63) / 64 * 64;
}

static uint64_t checksum_of(const void *image, size_t size)
{
    const size_t from = offsetof(struct surface_header, version);
    return XXH3_64bits((const char *)image + from, size - from);
}

static bool all_finite(const float *x, size_t count)
{
    for (size_t k = 0; k < count; k++)
        if (!isfinite(x[k]))
            return false;
    return true;
}

/* -- making ------------------------------------------------------------------------------------ */

/* Takes the status of what it is made with; ends it, where that is none. */
static enum probe_status hand_out(struct probe_surface *s, enum probe_status status,
                                  struct probe_surface **surface)
{
    if (status)
        probe_surface_destroy(s);
    else
        *surface = s;
    return status;
}

enum probe_status probe_surface_create(struct probe_surface **surface, const struct probe_discs *of,
                                       size_t *row)
{
    size_t nowhere;
    *surface = NULL;
    row = row ? row : &nowhere;
    if (of->probes > INT32_MAX)
        return PROBE_BAD_ARGUMENT;
    for (*row = 0; *row < of->probes; ++*row) {
        const double *p = of->position + 3 * *row;
        if (!(of->radius[*row] > 0))
            continue;
        if (!isfinite(of->radius[*row]) || !all_finite(of->normal + 3 * *row, 3) ||
            !all_finite(of->irradiance + 3 * *row, 3))
            return PROBE_BAD_DISC;
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
            return PROBE_BAD_POSITION;
    }
    *row = 0;
    struct probe_surface *s = calloc(1, sizeof *s);
    if (!s)
        return PROBE_NO_MEMORY;
    const struct disc_points points = {of->probes, of->position, of->normal, of->radius};
    s->irradiance = of->irradiance;
    s->probes = of->probes;
    return hand_out(s, discs_make(&s->discs, &points), surface);
}

static bool sane_scale(const struct surface_header *h)
{
    int exponent;
    if (h->packing == PROBE_PACK_FLOAT)
        return !(h->light_scale < 1 || h->light_scale > 1);
    return h->light_scale > 0 && h->light_scale <= 0x1p112f &&
           !(frexpf(h->light_scale, &exponent) > 0.5f);
}

/* What this version does not use is 0, so that a later one may. */
static bool knows_all(const struct surface_header *h)
{
    uint64_t other = 0;
    for (size_t i = 0; i < sizeof h->nothing; i++)
        other |= h->nothing[i];
    for (size_t i = 0; i < sizeof h->unused / sizeof *h->unused; i++)
        other |= h->unused[i];
    return !other;
}

static enum probe_status check_header(const struct surface_header *h, const void *image,
                                      size_t size)
{
    if (memcmp(h->magic, surface_magic, sizeof h->magic) || h->version != SURFACE_VERSION)
        return PROBE_NOT_AN_IMAGE;
    if (h->packing > PROBE_PACK_HALF || h->probes > INT32_MAX || !sane_scale(h) ||
        h->size != size || size_of(h) != size || h->checksum != checksum_of(image, size))
        return PROBE_BAD_IMAGE;
    return knows_all(h) ? PROBE_OK : PROBE_NOT_AN_IMAGE;
}

/* Irradiance where it lies, or of halves. */
static enum probe_status take_values(struct probe_surface *s, const struct surface_header *h,
                                     const char *image)
{
    const size_t count = 3 * s->probes;
    const void *values = image + values_at(h);
    if (h->packing == PROBE_PACK_FLOAT) {
        s->irradiance = values;
        return all_finite(s->irradiance, count) ? PROBE_OK : PROBE_BAD_IMAGE;
    }
    const uint16_t *half = values;
    s->own = malloc(count * sizeof *s->own);
    s->irradiance = s->own;
    if (!s->own)
        return PROBE_NO_MEMORY;
    for (size_t i = 0; i < count; i++) {
        if (!half_finite(half[i]))
            return PROBE_BAD_IMAGE;
        s->own[i] = h->light_scale * half_value(half[i]);
    }
    return PROBE_OK;
}

enum probe_status probe_surface_open(struct probe_surface **surface, const void *image, size_t size,
                                     size_t *row)
{
    struct surface_header h;
    size_t nowhere;
    *surface = NULL;
    row = row ? row : &nowhere;
    *row = 0;
    if ((uintptr_t)image % 8)
        return PROBE_BAD_ARGUMENT;
    if (size < sizeof h)
        return size >= sizeof h.magic && !memcmp(image, surface_magic, sizeof h.magic)
                   ? PROBE_BAD_IMAGE
                   : PROBE_NOT_AN_IMAGE;
    memcpy(&h, image, sizeof h);
    enum probe_status status = check_header(&h, image, size);
    if (status)
        return status;
    struct probe_surface *s = calloc(1, sizeof *s);
    if (!s)
        return PROBE_NO_MEMORY;
    s->probes = (size_t)h.probes;
    status = take_values(s, &h, image);
    struct discs_grid grid = {.scale = h.scale};
    memcpy(grid.origin, h.origin, sizeof grid.origin);
    memcpy(grid.cells, h.cells, sizeof grid.cells);
    if (!status)
        status = discs_make_again(&s->discs, (const void *)((const char *)image + sizeof h),
                                  s->probes, &grid, row);
    return hand_out(s, status, surface);
}

void probe_surface_destroy(struct probe_surface *s)
{
    if (!s)
        return;
    discs_destroy(s->discs);
    free(s->own);
    free(s);
}

size_t probe_surface_probes(const struct probe_surface *s)
{
    size_t count;
    discs_list(s->discs, &count);
    return count;
}

size_t probe_surface_bytes(const struct probe_surface *s)
{
    return sizeof *s + discs_bytes(s->discs) + (s->own ? 3 * s->probes * sizeof *s->own : 0);
}

const struct discs *surface_discs(const struct probe_surface *s, const float **irradiance)
{
    *irradiance = s->irradiance;
    return s->discs;
}

/* -- asking ------------------------------------------------------------------------------------ */

enum probe_status probe_surface_irradiance(const struct probe_surface *s, const double point[3],
                                           const float normal[3], int falloff, float rgb[3],
                                           int *covered)
{
    const double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
    rgb[0] = rgb[1] = rgb[2] = 0;
    if (covered)
        *covered = 0;
    if (falloff < 1 || falloff > 3)
        return PROBE_BAD_ARGUMENT;
    if (!isfinite(point[0]) || !isfinite(point[1]) || !isfinite(point[2]) || !all_finite(normal, 3))
        return PROBE_BAD_POINT;
    const enum discs_answer answer =
        discs_blend(s->discs, point, n, falloff, s->irradiance, 3, rgb);
    if (covered)
        *covered = answer == DISCS_COVERED;
    return answer == DISCS_NONE ? PROBE_NO_DISCS : PROBE_OK;
}

/* -- packing ----------------------------------------------------------------------------------- */

static void put_parts(const struct probe_surface *s, const struct surface_header *h, char *image)
{
    size_t count;
    const struct disc *list = discs_list(s->discs, &count);
    struct disc *disc = (struct disc *)(void *)(image + sizeof *h);
    float *value = (float *)(void *)(image + values_at(h));
    uint16_t *half = (uint16_t *)(void *)(image + values_at(h));
    memset(image, 0, (size_t)h->size);
    for (size_t i = 0; i < count; i++) {
        const float *from = s->irradiance + 3 * (size_t)list[i].point;
        disc[i] = list[i];
        disc[i].point = (uint32_t)i;
        for (size_t k = 0; k < 3; k++)
            if (h->packing == PROBE_PACK_HALF)
                half[3 * i + k] = half_of(from[k] / h->light_scale);
            else
                value[3 * i + k] = from[k];
    }
    memcpy(image, h, sizeof *h);
    const uint64_t sum = checksum_of(image, (size_t)h->size);
    memcpy(image + offsetof(struct surface_header, checksum), &sum, sizeof sum);
}

size_t probe_surface_pack(const struct probe_surface *s, enum probe_packing packing, void *image,
                          size_t size)
{
    size_t count;
    const struct disc *list = discs_list(s->discs, &count);
    const struct discs_grid *grid = discs_grid_of(s->discs);
    float most = 0;
    if (packing != PROBE_PACK_FLOAT && packing != PROBE_PACK_HALF)
        return 0;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 3; k++)
            most = fmaxf(most, fabsf(s->irradiance[3 * (size_t)list[i].point + k]));
    struct surface_header h = {.version = SURFACE_VERSION,
                               .packing = (uint8_t)packing,
                               .probes = count,
                               .scale = grid->scale,
                               .light_scale = packing == PROBE_PACK_HALF ? half_scale(most) : 1};
    memcpy(h.origin, grid->origin, sizeof h.origin);
    memcpy(h.cells, grid->cells, sizeof h.cells);
    memcpy(h.magic, surface_magic, sizeof h.magic);
    h.size = size_of(&h);
    if (size >= h.size)
        put_parts(s, &h, image);
    return (size_t)h.size;
}
