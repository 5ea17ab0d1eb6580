/* SPDX-License-Identifier: Apache-2.0 */
/* Packed files, as man/libprobe-query.3 specifies them: a header of 128 bytes, then what a volume
 * is made of, used where it lies.
 *
 * Based on: Collet, XXH3, https://xxhash.com: the checksum.
 */
#include "sight.h"
#include "volume.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

/* The later version is of files with groups of lights: what does not know them must not open them.
 */
enum { IMAGE_VERSION = 1, IMAGE_OF_GROUPS = 2, IMAGE_ALIGNMENT = 64, GROUPS_MOST = 4096 };

struct image_header {
    char magic[8];
    uint64_t checksum; /* XXH3-64 of all that follows it */
    uint32_t version;
    uint8_t corners, order, convolved, packing, vertex_bytes, neighbour_bytes, sight, nothing[5];
    uint64_t probes, cells;
    double step, origin[3]; /* position = origin + step * site */
    float light_scale;      /* coefficient = light_scale * what is stored */
    uint32_t groups;        /* of lights; version 2 */
    uint64_t size;          /* of the whole */
    uint64_t outside;       /* cells that something stands beyond, outside of the hull */
    uint64_t name_bytes;    /* of all groups' names; version 2 */
    uint64_t unused[2];
};
_Static_assert(sizeof(struct image_header) == 128, "the header is packed");
_Static_assert(sizeof(struct volume_beyond) == 56, "what is outside is packed");

static const char image_magic[8] = {'p', 'r', 'o', 'b', 'e', 'p', 'a', 'k'};

/* Where the parts of an image lie. */
struct layout {
    size_t site, light, vertex, neighbour, sight, stand_in, beyond, names, group_light, size;
};

static size_t align(size_t at)
{
    return (at + IMAGE_ALIGNMENT - 1) / IMAGE_ALIGNMENT * IMAGE_ALIGNMENT;
}

static size_t width_of(const struct image_header *h)
{
    return (size_t)(3 * h->order * h->order);
}

static size_t light_bytes(const struct image_header *h)
{
    return h->packing == PROBE_PACK_HALF ? 2 : 4;
}

static struct layout lay_out(const struct image_header *h)
{
    struct layout at = {.site = align(sizeof *h)};
    at.light = align(at.site + h->probes * 3 * sizeof(double));
    at.vertex = align(at.light + h->probes * width_of(h) * light_bytes(h));
    at.neighbour = align(at.vertex + h->cells * h->corners * h->vertex_bytes);
    at.sight = align(at.neighbour + h->cells * h->corners * h->neighbour_bytes);
    const uint64_t walled = h->sight ? h->cells : 0;
    at.stand_in = align(at.sight + walled * (uint64_t)sight_width(h->corners) * 2);
    at.beyond = align(at.stand_in + walled * h->vertex_bytes);
    at.names = align(at.beyond + h->outside * sizeof(struct volume_beyond));
    const bool grouped = h->version == IMAGE_OF_GROUPS;
    at.group_light = align(at.names + (grouped ? h->name_bytes : 0));
    at.size = align(at.group_light +
                    (grouped ? h->probes * h->groups * width_of(h) * light_bytes(h) : 0));
    return at;
}

static uint64_t image_checksum(const void *image, size_t size)
{
    const size_t from = offsetof(struct image_header, version);
    return XXH3_64bits((const char *)image + from, size - from);
}

/* -- opening ---------------------------------------------------------------------------------- */

static bool power_of_two(double x)
{
    int exponent;
    return x > 0 && x < INFINITY && frexp(x, &exponent) == 0.5;
}

/* Doubles that differ are no more than 2^53 times as large as their difference, and a lattice has
 * 2^40 steps of a power of two, counted from 0; only one point needs none. */
static bool sane_lattice(const struct image_header *h)
{
    bool sane = power_of_two(h->step) || (h->step == 0 && h->corners == 1);
    for (int k = 0; k < 3; k++) {
        const double steps = h->origin[k] / h->step;
        sane = sane && (h->step > 0 ? fabs(steps) <= 0x1p100 && steps == rint(steps)
                                    : isfinite(h->origin[k]));
    }
    return sane;
}

/* The largest half, 65504, times the largest scale is a float. */
static bool sane_scale(const struct image_header *h)
{
    if (h->packing == PROBE_PACK_FLOAT)
        return h->light_scale == 1;
    return power_of_two((double)h->light_scale) && h->light_scale <= 0x1p112f;
}

/* What this version does not use is 0, so that a later one may. */
static bool knows_all(const struct image_header *h)
{
    uint64_t other = h->version == IMAGE_OF_GROUPS ? 0 : h->groups | h->name_bytes;
    for (size_t i = 0; i < sizeof h->nothing; i++)
        other |= h->nothing[i];
    for (size_t i = 0; i < sizeof h->unused / sizeof *h->unused; i++)
        other |= h->unused[i];
    return !other;
}

static bool sane_groups(const struct image_header *h, size_t size)
{
    return h->version != IMAGE_OF_GROUPS ||
           (h->groups > 0 && h->groups <= GROUPS_MOST && h->order > 0 && h->name_bytes <= size);
}

/* Each is such as a column may have, and ends with a 0. */
static bool sane_names(const char *names, size_t bytes, size_t groups)
{
    size_t ends = 0, length = 0;
    for (size_t i = 0; i < bytes; i++) {
        const char c = names[i];
        const bool part = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
        if (!part && (c || !length))
            return false;
        length = part ? length + 1 : 0;
        ends += !part;
    }
    return !length && ends == groups;
}

static enum probe_status check_header(const struct image_header *h, const void *image, size_t size)
{
    /* a big-endian machine sees another version */
    if (memcmp(h->magic, image_magic, sizeof h->magic) ||
        (h->version != IMAGE_VERSION && h->version != IMAGE_OF_GROUPS))
        return PROBE_NOT_AN_IMAGE;
    const bool sane = h->corners >= 1 && h->corners <= 4 && h->order <= 6 && h->convolved <= 1 &&
                      h->packing <= PROBE_PACK_HALF && h->sight <= 1 &&
                      (h->vertex_bytes == 2 || h->vertex_bytes == 4) &&
                      (h->neighbour_bytes == 2 || h->neighbour_bytes == 4) &&
                      h->probes <= INT32_MAX && h->cells <= INT32_MAX &&
                      h->outside <= (h->sight && h->corners == 4 ? h->cells : 0) &&
                      sane_lattice(h) && sane_scale(h) && sane_groups(h, size);
    if (!sane || h->size != size || lay_out(h).size != size ||
        h->checksum != image_checksum(image, size))
        return PROBE_BAD_IMAGE;
    return knows_all(h) ? PROBE_OK : PROBE_NOT_AN_IMAGE;
}

/* Whether no number's exponent is all ones: the least one added to it does not reach the sign.
 * Eight bytes at a time; exponent, one: of the numbers in them. */
static bool all_finite(const void *numbers, size_t bytes, uint64_t exponent, uint64_t one)
{
    const char *at = numbers;
    const size_t whole = bytes / sizeof(uint64_t) * sizeof(uint64_t);
    uint64_t any = 0, some;
    for (size_t i = 0; i < whole; i += sizeof some) {
        memcpy(&some, at + i, sizeof some);
        any |= (some & exponent) + one;
    }
    some = 0;
    memcpy(&some, at + whole, bytes - whole);
    any |= (some & exponent) + one;
    return !(any & (exponent + one));
}

static bool finite_light(const struct probe_volume *v, const void *light, size_t count)
{
    return v->image.packing == PROBE_PACK_HALF
               ? all_finite(light, 2 * count, 0x7c007c007c007c00, 0x0400040004000400)
               : all_finite(light, 4 * count, 0x7f8000007f800000, 0x0080000000800000);
}

/* Sites are whole numbers of the lattice; coefficients are finite. */
static enum probe_status check_numbers(const struct probe_volume *v, size_t *row)
{
    const double most = (double)((uint64_t)1 << LATTICE_BITS);
    for (size_t i = 0; i < 3 * v->probes; i++)
        if (!(v->site[i] >= 0 && v->site[i] <= most &&
              v->site[i] == (double)lattice_whole(v->site[i]))) {
            *row = i / 3;
            return PROBE_BAD_POSITION;
        }
    const size_t n = v->probes * (size_t)(3 * v->image.order * v->image.order);
    return finite_light(v, v->light, n) && finite_light(v, v->group_light, n * v->groups)
               ? PROBE_OK
               : PROBE_BAD_IMAGE;
}

enum probe_status probe_volume_open(struct probe_volume **volume, const void *image, size_t size,
                                    unsigned flags, size_t *row)
{
    struct image_header h;
    size_t nowhere;
    *volume = NULL;
    row = row ? row : &nowhere;
    *row = 0;
    if ((uintptr_t)image % 8)
        return PROBE_BAD_ARGUMENT;
    if (size < sizeof h)
        return size >= sizeof image_magic && !memcmp(image, image_magic, sizeof image_magic)
                   ? PROBE_BAD_IMAGE
                   : PROBE_NOT_AN_IMAGE;
    memcpy(&h, image, sizeof h);
    enum probe_status status = check_header(&h, image, size);
    if (status)
        return status;
    const struct layout at = lay_out(&h);
    const char *bytes = image;
    if (!sane_names(bytes + at.names, (size_t)h.name_bytes, h.groups))
        return PROBE_BAD_IMAGE;
    struct probe_volume *v = calloc(1, sizeof *v);
    if (!v)
        return PROBE_NO_MEMORY;
    *v = (struct probe_volume){
        .flags = flags,
        .corners = h.corners,
        .probes = (size_t)h.probes,
        .cells = (size_t)h.cells,
        .lattice = {.step = h.step, .origin = {h.origin[0], h.origin[1], h.origin[2]}},
        .site = (const double *)(const void *)(bytes + at.site),
        .vertex = bytes + at.vertex,
        .neighbour = bytes + at.neighbour,
        .vertex_bytes = h.vertex_bytes,
        .neighbour_bytes = h.neighbour_bytes,
        .lazy = flags & PROBE_LAZY && !(flags & PROBE_LEAN),
        .sight = h.sight && !(flags & PROBE_SEE_ALL)
                     ? (const uint16_t *)(const void *)(bytes + at.sight)
                     : NULL,
        .stand_in = h.sight ? bytes + at.stand_in : NULL,
        .stand_in_bytes = h.vertex_bytes,
        .beyond = (const struct volume_beyond *)(const void *)(bytes + at.beyond),
        .beyonds = (size_t)h.outside,
        .light = bytes + at.light,
        .light_scale = h.light_scale,
        .groups = h.groups,
        .group_names = bytes + at.names,
        .group_light = bytes + at.group_light};
    v->image = (struct probe_image_facts){
        .order = h.order,
        .convolved = h.convolved,
        .packing = (enum probe_packing)h.packing,
        .vertex_bytes = h.vertex_bytes,
        .neighbour_bytes = h.neighbour_bytes,
        .bytes_per_probe = 3 * sizeof(double) + (1 + h.groups) * width_of(&h) * light_bytes(&h),
        .bytes_per_cell = (size_t)h.corners * (size_t)(h.vertex_bytes + h.neighbour_bytes) +
                          (h.sight ? (size_t)sight_width(h.corners) * 2 + h.vertex_bytes : 0),
        .bytes = size};
    status = check_numbers(v, row);
    if (!status)
        status = volume_check_sight(v, row);
    return volume_finish(v, status, row, volume);
}

struct probe_image_facts probe_volume_image(const struct probe_volume *v)
{
    return v->image;
}

/* -- packing ---------------------------------------------------------------------------------- */

static void put_index(void *to, int bytes, size_t i, int32_t value)
{
    if (bytes == 4)
        ((int32_t *)to)[i] = value;
    else
        ((uint16_t *)to)[i] = value < 0 ? UINT16_MAX : (uint16_t)value;
}

/* New numbers of the probes that cells use, in order of first use: near ones come to lie near.
 * Returns how many. */
static size_t number_probes(const struct probe_volume *v, int32_t *fresh, int32_t *old)
{
    size_t used = 0;
    for (size_t i = 0; i < v->probes; i++)
        fresh[i] = -1;
    for (size_t cell = 0; cell < v->cells; cell++)
        for (int k = 0; k < v->corners; k++) {
            const int32_t p = volume_vertex(v, cell, k);
            if (fresh[p] < 0) {
                old[used] = p;
                fresh[p] = (int32_t)used++;
            }
        }
    return used;
}

/* The largest coefficient; infinite: one is not finite. */
static float most_of(const struct image_header *h, const int32_t *old, const float *sh)
{
    const size_t width = width_of(h);
    float most = 0;
    for (size_t i = 0; i < h->probes; i++)
        for (size_t k = 0; k < width; k++) {
            const float x = fabsf(sh[(size_t)old[i] * width + k]);
            if (!isfinite(x))
                return INFINITY;
            most = x > most ? x : most;
        }
    return most;
}

/* What coefficients are divided by. 0: one is not finite. */
static float scale_of(const struct image_header *h, const int32_t *old, const float *sh,
                      const struct probe_groups *groups)
{
    float most = most_of(h, old, sh);
    for (size_t g = 0; g < h->groups; g++)
        most = fmaxf(most, most_of(h, old, groups->sh[g]));
    if (!isfinite(most))
        return 0;
    return h->packing == PROBE_PACK_HALF ? half_scale(most) : 1;
}

/* Rows of SH, the first of them `first` numbers from `to`, and each `step` behind the last. */
static void put_light(const struct image_header *h, const int32_t *old, const float *sh,
                      size_t first, size_t step, char *to)
{
    const size_t width = width_of(h);
    float *light = (float *)(void *)to + first;
    uint16_t *half = (uint16_t *)(void *)to + first;
    for (size_t i = 0; i < h->probes; i++)
        for (size_t k = 0; k < width; k++) {
            const float x = sh[(size_t)old[i] * width + k];
            if (h->packing == PROBE_PACK_HALF)
                half[i * step + k] = half_of(x / h->light_scale);
            else
                light[i * step + k] = x;
        }
}

static void put_groups(const struct image_header *h, const int32_t *old,
                       const struct probe_groups *groups, char *image)
{
    const struct layout at = lay_out(h);
    const size_t width = width_of(h);
    char *name = image + at.names;
    for (size_t g = 0; g < h->groups; g++) {
        const size_t bytes = strlen(groups->name[g]) + 1;
        memcpy(name, groups->name[g], bytes);
        name += bytes;
        put_light(h, old, groups->sh[g], g * width, h->groups * width, image + at.group_light);
    }
}

/* Records of cells by their own order, as open wants them; those of the volume are few. */
static void put_outside(const struct probe_volume *v, uint64_t count, const int32_t *fresh,
                        char *image)
{
    struct volume_beyond *to = (struct volume_beyond *)(void *)image;
    for (size_t cell = 0; cell < v->cells && count; cell++) {
        const struct volume_beyond *from = volume_beyond_of(v, volume_number(v, cell));
        if (!from)
            continue;
        *to = *from;
        to->cell = (int32_t)cell;
        to->stand_in = from->stand_in < 0 ? -1 : fresh[from->stand_in];
        to++;
    }
}

static void put_parts(const struct probe_volume *v, const struct image_header *h,
                      const int32_t *fresh, const int32_t *old, const float *sh,
                      const struct probe_groups *groups, char *image)
{
    const struct layout at = lay_out(h);
    double *site = (double *)(void *)(image + at.site);
    memset(image, 0, at.size);
    for (size_t i = 0; i < h->probes; i++)
        memcpy(site + 3 * i, volume_site(v, old[i]), 3 * sizeof *site);
    put_light(h, old, sh, 0, width_of(h), image + at.light);
    put_groups(h, old, groups, image);
    for (size_t cell = 0; cell < v->cells; cell++)
        for (int k = 0; k < v->corners; k++) {
            const size_t i = cell * (size_t)v->corners + (size_t)k;
            put_index(image + at.vertex, h->vertex_bytes, i, fresh[volume_vertex(v, cell, k)]);
            put_index(image + at.neighbour, h->neighbour_bytes, i, volume_neighbour(v, cell, k));
        }
    /* cells in their own order, as sight has them */
    for (size_t cell = 0; cell < v->cells && h->sight; cell++) {
        const size_t from = (size_t)volume_number(v, cell),
                     width_of_sight = (size_t)sight_width(v->corners);
        const int32_t stand_in = volume_index(v->stand_in, v->stand_in_bytes, from);
        memcpy(image + at.sight + 2 * width_of_sight * cell, v->sight + width_of_sight * from,
               2 * width_of_sight);
        put_index(image + at.stand_in, h->vertex_bytes, cell, stand_in < 0 ? -1 : fresh[stand_in]);
    }
    put_outside(v, h->outside, fresh, image + at.beyond);
    memcpy(image, h, sizeof *h);
    const uint64_t sum = image_checksum(image, at.size);
    memcpy(image + offsetof(struct image_header, checksum), &sum, sizeof sum);
}

/* The bytes of all names; 0: one is no name of a group. */
static size_t count_names(const struct probe_groups *groups)
{
    size_t bytes = 0;
    for (size_t g = 0; g < groups->count; g++) {
        const size_t length = strlen(groups->name[g]) + 1;
        if (!sane_names(groups->name[g], length, 1))
            return 0;
        bytes += length;
    }
    return bytes;
}

size_t probe_volume_pack(const struct probe_volume *v, int order, const float *sh, int convolved,
                         enum probe_packing packing, void *image, size_t size)
{
    return probe_volume_pack_groups(v, order, sh, convolved, packing, NULL, image, size);
}

size_t probe_volume_pack_groups(const struct probe_volume *v, int order, const float *sh,
                                int convolved, enum probe_packing packing,
                                const struct probe_groups *groups, void *image, size_t size)
{
    const bool grouped = groups && groups->count;
    const size_t name_bytes = grouped ? count_names(groups) : 0;
    const bool sane = order >= 0 && order <= 6 && (order == 0 || sh) &&
                      (packing == PROBE_PACK_FLOAT || packing == PROBE_PACK_HALF) &&
                      (!grouped || (order > 0 && name_bytes && groups->count <= GROUPS_MOST));
    int32_t *fresh = sane ? malloc(2 * (v->probes + 1) * sizeof *fresh) : NULL;
    if (!fresh)
        return 0;
    int32_t *old = fresh + v->probes + 1;
    struct image_header h = {
        .version = grouped ? IMAGE_OF_GROUPS : IMAGE_VERSION,
        .corners = (uint8_t)v->corners,
        .order = (uint8_t)order,
        .convolved = convolved != 0,
        .packing = (uint8_t)packing,
        .groups = grouped ? (uint32_t)groups->count : 0,
        .name_bytes = name_bytes,
        .sight = v->sight != NULL,
        .outside = v->sight ? v->beyonds : 0,
        .cells = v->cells,
        .step = v->lattice.step,
        .origin = {v->lattice.origin[0], v->lattice.origin[1], v->lattice.origin[2]}};
    memcpy(h.magic, image_magic, sizeof h.magic);
    h.probes = number_probes(v, fresh, old);
    h.vertex_bytes = h.probes < UINT16_MAX ? 2 : 4;
    h.neighbour_bytes = h.cells < UINT16_MAX ? 2 : 4;
    h.light_scale = scale_of(&h, old, sh, groups);
    h.size = lay_out(&h).size;
    if (h.light_scale > 0 && size >= h.size)
        put_parts(v, &h, fresh, old, sh, groups, image);
    free(fresh);
    return h.light_scale > 0 ? (size_t)h.size : 0;
}
