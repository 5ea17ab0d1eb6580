/* SPDX-License-Identifier: Apache-2.0 */
/* libprobe-query as a game has it, through its public header alone: it holds as many bytes as it
 * says, and no light; memory that runs out anywhere is a status and no leak; halves are the nearest
 * ones over a float's whole range; many threads may ask one volume; groups of lights are weighed as
 * a sum over them says; a header that lies is refused, whatever its checksum. */
#include "base/error.h"
#include "libprobe-query/probe-query.h"
#include "math/random.h"
#include "support/tap.h"
#include "tetra/tetra.h"

#include <float.h>
#include <pthread.h>
#include <stdint.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

/* -- an allocator that counts, and fails on request (the linker's --wrap) --------------------- */

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void __real_free(void *block);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void __wrap_free(void *block);

enum { BLOCKS = 64 };
static struct {
    bool on;
    struct {
        void *block;
        size_t size;
    } live[BLOCKS];
    size_t bytes, most, calls, fail; /* fail: this call, counted from 1 */
} heap;

static void heap_begin(size_t fail)
{
    memset(&heap, 0, sizeof heap);
    heap.on = true;
    heap.fail = fail;
}

static bool refuses(void)
{
    return heap.on && ++heap.calls == heap.fail;
}

static void *noted(void *block, size_t size)
{
    for (int i = 0; heap.on && block && i < BLOCKS; i++)
        if (!heap.live[i].block) {
            heap.live[i].block = block;
            heap.live[i].size = size;
            heap.bytes += size;
            heap.most = heap.bytes > heap.most ? heap.bytes : heap.most;
            break;
        }
    return block;
}

void *__wrap_malloc(size_t size)
{
    return refuses() ? NULL : noted(__real_malloc(size), size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return refuses() ? NULL : noted(__real_calloc(count, size), count * size);
}

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    return refuses() ? NULL : noted(__real_aligned_alloc(alignment, size), size);
}

void __wrap_free(void *block)
{
    for (int i = 0; heap.on && block && i < BLOCKS; i++)
        if (heap.live[i].block == block) {
            heap.live[i].block = NULL;
            heap.bytes -= heap.live[i].size;
            break;
        }
    __real_free(block);
}

/* -- meshes ----------------------------------------------------------------------------------- */

enum { MOST = 2000, WIDTH_MOST = 108 };

struct baked {
    double position[3 * MOST];
    struct tetra t;
    struct probe_mesh mesh;
    float sh[WIDTH_MOST * MOST];
};

/* Random probes in a box, a tilted plane, on a slanting line, or one: cells of 4, 3, 2 corners or
 * 1. */
static void bake(struct baked *b, int corners, size_t count)
{
    static const double axis[3][3] = {{1, 0.5, -0.25}, {-0.5, 1, 0.75}, {0.25, 0.5, 1}};
    struct random r = random_start(5, (uint64_t)corners, 0);
    for (size_t i = 0; i < count; i++)
        for (int j = 0; j < corners - 1; j++) {
            const double along = rint(4096 * random_double(&r)); /* whole: exactly in the plane */
            for (int k = 0; k < 3; k++)
                b->position[3 * i + (size_t)k] = (j ? b->position[3 * i + (size_t)k] : 0) +
                                                 along * axis[j][k];
        }
    if (corners == 1)
        memcpy(b->position, (const double[]){1, 2, 3}, 3 * sizeof(double));
    struct error *err = tetra_build(&b->t, corners == 1 ? 1 : count, b->position, NULL);
    if (err || b->t.corners != corners)
        bail("no cells of %d corners: %s", corners, err ? error_message(err) : "others");
    b->mesh = (struct probe_mesh){.probes = corners == 1 ? 1 : count,
                                  .position = b->position,
                                  .corners = corners,
                                  .cells = b->t.cell_count,
                                  .vertex = b->t.vertex,
                                  .neighbour = b->t.neighbour};
    for (size_t i = 0; i < WIDTH_MOST * b->mesh.probes; i++)
        b->sh[i] = 2 * random_float(&r) - 1;
}

static struct probe_volume *create(const struct baked *b, unsigned flags)
{
    struct probe_volume *v;
    const enum probe_status status = probe_volume_create(&v, &b->mesh, flags, NULL);
    if (status)
        bail("%s", probe_status_text(status));
    return v;
}

/* Of exactly its own bytes, so that a sanitizer sees what reads past them. */
static void *pack(const struct baked *b, int order, enum probe_packing packing, size_t *size)
{
    struct probe_volume *v = create(b, 0);
    *size = probe_volume_pack(v, order, b->sh, 0, packing, NULL, 0);
    void *image = malloc(*size);
    if (!*size || !image || probe_volume_pack(v, order, b->sh, 0, packing, image, *size) != *size)
        bail("nothing is packed");
    probe_volume_destroy(v);
    return image;
}

static struct probe_volume *open_image(const void *image, size_t size, unsigned flags)
{
    struct probe_volume *v;
    const enum probe_status status = probe_volume_open(&v, image, size, flags, NULL);
    if (status)
        bail("%s", probe_status_text(status));
    return v;
}

/* -- memory ----------------------------------------------------------------------------------- */

static void test_bytes(int corners)
{
    static struct baked b;
    bake(&b, corners, 1500);
    for (unsigned flags = 0; flags <= (PROBE_LEAN | PROBE_NEAREST | PROBE_EXTEND); flags++) {
        bool freed = true, says = true;
        size_t of_order[2];
        heap_begin(0);
        struct probe_volume *v = create(&b, flags);
        const size_t held = heap.bytes;
        says = probe_volume_bytes(v) == held;
        probe_volume_destroy(v);
        freed = !heap.bytes;
        heap.on = false;
        for (int high = 0; high < 2; high++) {
            size_t size;
            void *image = pack(&b, high ? 6 : 1, high ? PROBE_PACK_FLOAT : PROBE_PACK_HALF, &size);
            heap_begin(0);
            v = open_image(image, size, flags);
            of_order[high] = heap.bytes;
            says = says && probe_volume_bytes(v) == heap.bytes;
            probe_volume_destroy(v);
            freed = freed && !heap.bytes;
            heap.on = false;
            free(image);
        }
        ok(says && freed,
           "%d corners, flags %u: holds as many bytes as it says, %zu of arrays, %zu of a file "
           "(%.1f a cell), and frees them",
           corners, flags, held, of_order[0], (double)of_order[0] / (double)b.mesh.cells);
        ok(of_order[0] == of_order[1] && of_order[0] + 24 * b.mesh.probes <= held,
           "in a file, positions and light are used where they lie");
    }
    tetra_clear(&b.t);
}

/* Each allocation fails in turn. */
static void test_no_memory(void)
{
    static struct baked b;
    size_t size;
    bake(&b, 4, 200);
    void *image = pack(&b, 2, PROBE_PACK_HALF, &size);
    for (int what = 0; what < 3; what++) {
        struct probe_volume *asked = create(&b, 0), *v;
        size_t calls = 0;
        bool good = true, done = false;
        while (!done) {
            v = NULL;
            heap_begin(++calls);
            if (what == 2) {
                done = probe_volume_pack(asked, 2, b.sh, 0, PROBE_PACK_HALF, NULL, 0) > 0;
            } else {
                const enum probe_status status = what ? probe_volume_open(&v, image, size, 0, NULL)
                                                      : probe_volume_create(&v, &b.mesh, 0, NULL);
                good = good && (status == PROBE_OK ? v != NULL : status == PROBE_NO_MEMORY && !v);
                done = status == PROBE_OK;
                probe_volume_destroy(v);
            }
            good = good && !heap.bytes && done == (heap.calls < heap.fail);
            heap.on = false;
        }
        ok(good && calls > 1,
           "%s: each of %zu allocations may fail; that is a status, and nothing leaks",
           what == 0   ? "create"
           : what == 1 ? "open"
                       : "pack",
           calls - 1);
        probe_volume_destroy(asked);
    }
    free(image);
    tetra_clear(&b.t);
}

/* -- halves ----------------------------------------------------------------------------------- */

/* Order 6 of one probe, as halves and back. */
static void through_halves(const float sh[WIDTH_MOST], float back[WIDTH_MOST])
{
    static const double position[3] = {1, 2, 3};
    static const int32_t vertex = 0, neighbour = -1;
    const struct probe_mesh mesh = {.probes = 1,
                                    .position = position,
                                    .corners = 1,
                                    .cells = 1,
                                    .vertex = &vertex,
                                    .neighbour = &neighbour};
    struct probe_volume *v, *packed;
    uint64_t image[128];
    struct probe_place place = {.cell = PROBE_COLD};
    if (probe_volume_create(&v, &mesh, 0, NULL))
        bail("no volume of one point");
    const size_t size = probe_volume_pack(v, 6, sh, 0, PROBE_PACK_HALF, image, sizeof image);
    packed = open_image(image, size, 0);
    probe_volume_locate(packed, position, &place);
    probe_volume_light(packed, &place, back);
    probe_volume_destroy(packed);
    probe_volume_destroy(v);
}

static float half_value(int bits)
{
    return bits >> 10 ? ldexpf((float)(1024 + (bits & 1023)), (bits >> 10) - 25)
                      : ldexpf((float)bits, -24);
}

/* A coefficient of 1 makes the scale 2^-14. So a half h is that of h 2^-14, and halves up to 2^14,
 * the bits 0x7400, are used. */
static void test_every_half(void)
{
    enum { LAST = 0x7400, EACH = (WIDTH_MOST - 1) / 4 };
    const float scale = 0x1p-14f;
    size_t wrong = 0;
    for (int first = 0; first < LAST; first += EACH) {
        float sh[WIDTH_MOST] = {1}, back[WIDTH_MOST];
        for (int i = 0; i < EACH && first + i < LAST; i++) {
            /* exact */
            const float here = half_value(first + i), next = half_value(first + i + 1),
                        middle = (here + next) / 2;
            float *to = sh + 1 + 4 * i;
            to[0] = scale * here;
            to[1] = -scale * nextafterf(middle, 0);
            to[2] = scale * middle;
            to[3] = -scale * nextafterf(middle, INFINITY);
        }
        through_halves(sh, back);
        for (int i = 0; i < EACH && first + i < LAST; i++) {
            const float here = scale * half_value(first + i),
                        next = scale * half_value(first + i + 1);
            const float *got = back + 1 + 4 * i;
            wrong += got[0] != here || got[1] != -here ||
                     got[2] != ((first + i) % 2 ? next : here) || got[3] != -next;
        }
    }
    ok(wrong == 0, "each half comes back, and what is between two goes to the nearer one, or from "
                   "the middle to the even one");
}

/* Of any size: 2^-11 of itself, or 2^-39 of the largest one, or 2^-140. */
static void test_range(void)
{
    double worst = 0;
    bool finite = true;
    struct random r = random_start(6, 0, 0);
    for (int exponent = -149; exponent <= 127; exponent++)
        for (unsigned spread = 1; spread <= 64; spread *= 8) {
            float sh[WIDTH_MOST], back[WIDTH_MOST], most = 0;
            for (int i = 0; i < WIDTH_MOST; i++) {
                sh[i] = ldexpf(i ? 2 * random_float(&r) - 1 : 2 - FLT_EPSILON,
                               exponent - (i ? (int)(random_u32(&r) % spread) : 0));
                most = fmaxf(most, fabsf(sh[i]));
            }
            through_halves(sh, back);
            for (int i = 0; i < WIDTH_MOST; i++) {
                const double size = fabs((double)sh[i]);
                worst =
                    fmax(worst, fabs((double)back[i] - (double)sh[i]) /
                                    fmax(fmax(0x1p-11 * size, 0x1p-39 * (double)most), 0x1p-140));
                finite = finite && isfinite(back[i]);
            }
        }
    ok(finite && worst <= 1 && worst > 0.9,
       "halves are within their rounding from the least float to the largest (%.4f of it)", worst);
}

/* -- threads ---------------------------------------------------------------------------------- */

enum { ASKERS = 4, POINTS = 4000 };

struct asker {
    const struct probe_volume *volume;
    const double (*point)[3];
    int turn;
    uint64_t sum[POINTS]; /* of what each point got */
};

static void *ask(void *argument)
{
    struct asker *a = argument;
    const int order = probe_volume_image(a->volume).order;
    struct probe_place place = {.cell = PROBE_COLD}, many[8];
    static const int stride[ASKERS] = {1, 3, 7, 9};
    for (int n = 0; n < POINTS; n++) { /* each in an order of its own */
        const int i = (n * stride[a->turn] + a->turn * 997) % POINTS;
        struct {
            double weight[4], distance;
            int32_t probe[4];
            float sh[27], rgb[3];
        } got;
        memset(&got, 0, sizeof got); /* what is between them, too */
        if (n % 16 == 0 && i + 8 <= POINTS) {
            many[0] = place;
            probe_volume_locate_many(a->volume, 8, a->point[i], 3, NULL, many);
            place = many[0];
        } else {
            probe_volume_locate(a->volume, a->point[i], &place);
        }
        memcpy(got.weight, place.weight, sizeof got.weight);
        memcpy(got.probe, place.probe, sizeof got.probe);
        got.distance = place.distance;
        probe_volume_light(a->volume, &place, got.sh);
        probe_irradiance(order, got.sh, (const float[]){0, 0, 1}, got.rgb);
        a->sum[i] = XXH3_64bits(&got, sizeof got);
    }
    return NULL;
}

static void test_threads(unsigned flags)
{
    static struct baked b;
    static double point[POINTS][3];
    static struct asker asker[ASKERS + 1];
    size_t size;
    bake(&b, 4, 1500);
    void *image = pack(&b, 3, PROBE_PACK_HALF, &size);
    struct probe_volume *v = open_image(image, size, flags);
    struct random r = random_start(7, 0, 0);
    for (int i = 0; i < POINTS; i++) { /* some outside */
        const size_t near = random_u32(&r) % b.mesh.probes;
        for (int k = 0; k < 3; k++)
            point[i][k] = b.position[3 * near + (size_t)k] + 500 * (random_double(&r) - 0.5);
    }
    memset(asker, 0, sizeof asker);
    for (int i = 0; i <= ASKERS; i++) {
        asker[i].volume = v;
        asker[i].point = (const double(*)[3])point;
        asker[i].turn = i % ASKERS;
    }
    pthread_t thread[ASKERS];
    for (int i = 0; i < ASKERS; i++)
        if (pthread_create(&thread[i], NULL, ask, &asker[i]))
            bail("no thread");
    for (int i = 0; i < ASKERS; i++)
        pthread_join(thread[i], NULL);
    ask(&asker[ASKERS]);
    size_t differ = 0;
    for (int i = 0; i < ASKERS; i++)
        for (int n = 0; n < POINTS; n++)
            differ += asker[i].sum[n] != asker[ASKERS].sum[n];
    ok(differ == 0, "flags %u: %d threads that ask one volume at once get what one gets alone",
       flags, ASKERS);
    probe_volume_destroy(v);
    free(image);
    tetra_clear(&b.t);
}

/* -- hostile files ---------------------------------------------------------------------------- */

static void seal(void *image, size_t size)
{
    const uint64_t sum = XXH3_64bits((const char *)image + 16, size - 16);
    memcpy((char *)image + 8, &sum, sizeof sum);
}

/* Opens a copy with `bytes` at `at` changed, and its checksum right. */
static enum probe_status changed(const void *image, size_t size, size_t at, const void *to,
                                 size_t bytes)
{
    struct probe_volume *v;
    char *copy = malloc(size);
    if (!copy)
        bail("memory");
    memcpy(copy, image, size);
    memcpy(copy + at, to, bytes);
    seal(copy, size);
    const enum probe_status status = probe_volume_open(&v, copy, size, PROBE_LEAN, NULL);
    if ((status == PROBE_OK) != (v != NULL))
        bail("a volume and a status");
    probe_volume_destroy(v);
    free(copy);
    return status;
}

static void test_headers(void)
{
    static struct baked b;
    size_t size, float_size;
    bake(&b, 4, 100);
    char *image = pack(&b, 2, PROBE_PACK_HALF, &size),
         *floats = pack(&b, 2, PROBE_PACK_FLOAT, &float_size);
    uint64_t probes, cells;
    double step, origin;
    memcpy(&probes, image + 32, sizeof probes);
    memcpy(&cells, image + 40, sizeof cells);
    memcpy(&step, image + 48, sizeof step);
    memcpy(&origin, image + 56, sizeof origin);
    ok(changed(image, size, 0, "p", 1) == PROBE_OK, "what is not changed is taken");

    static const struct {
        size_t at, bytes;
        uint64_t number;
        enum probe_status status;
        const char *what;
    } whole[] = {{16, 4, 3, PROBE_NOT_AN_IMAGE, "version 3"},
                 {16, 4, 2, PROBE_BAD_IMAGE, "version 2, without groups"},
                 {16, 4, 0x01000000, PROBE_NOT_AN_IMAGE,
                  "a version as a machine of the other byte order sees it"},
                 {20, 1, 0, PROBE_BAD_IMAGE, "cells without corners"},
                 {20, 1, 5, PROBE_BAD_IMAGE, "cells of 5 corners"},
                 {20, 1, 3, PROBE_BAD_IMAGE, "cells of another number of corners"},
                 {21, 1, 7, PROBE_BAD_IMAGE, "order 7"},
                 {21, 1, 3, PROBE_BAD_IMAGE, "another order"},
                 {22, 1, 2, PROBE_BAD_IMAGE, "neither convolved nor not"},
                 {23, 1, 2, PROBE_BAD_IMAGE, "light of a third kind"},
                 {24, 1, 3, PROBE_BAD_IMAGE, "probes' numbers of 3 bytes"},
                 {25, 1, 8, PROBE_BAD_IMAGE, "cells' numbers of 8 bytes"},
                 {26, 1, 1, PROBE_BAD_IMAGE, "sight that it is too short for"},
                 {26, 1, 2, PROBE_BAD_IMAGE, "neither with sight nor without"},
                 {27, 1, 1, PROBE_NOT_AN_IMAGE, "a byte that is reserved"},
                 {84, 4, 1, PROBE_NOT_AN_IMAGE, "a number that is reserved"},
                 {127, 1, 1, PROBE_NOT_AN_IMAGE, "the last byte that is reserved"},
                 {32, 8, 0, PROBE_BAD_IMAGE, "no probes"},
                 {40, 8, 0, PROBE_BAD_IMAGE, "no cells"},
                 {32, 8, UINT64_MAX, PROBE_BAD_IMAGE, "2^64 - 1 probes"},
                 {40, 8, UINT64_C(1) << 31, PROBE_BAD_IMAGE, "2^31 cells"},
                 {88, 8, UINT64_C(1) << 40, PROBE_BAD_IMAGE, "another size"}};
    for (size_t i = 0; i < sizeof whole / sizeof *whole; i++)
        ok(changed(image, size, whole[i].at, &whole[i].number, whole[i].bytes) == whole[i].status,
           "refused: %s", whole[i].what);
    probes += UINT64_C(1) << 61;
    cells += UINT64_C(1) << 62;
    ok(changed(image, size, 32, &probes, 8) == PROBE_BAD_IMAGE &&
           changed(image, size, 40, &cells, 8) == PROBE_BAD_IMAGE,
       "refused: counts whose bytes come out right modulo 2^64");

    const double steps[] = {0, -step, 3 * step, 0.75 * step, NAN, INFINITY, 5e-324, 1e308};
    int taken = 0;
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++)
        taken += changed(image, size, 48, &steps[i], 8) == PROBE_OK;
    const double origins[] = {NAN, INFINITY, -INFINITY, origin + step / 2, 1e308};
    for (size_t i = 0; i < sizeof origins / sizeof *origins; i++)
        taken += changed(image, size, 56, &origins[i], 8) == PROBE_OK;
    ok(taken == 0,
       "refused: lattices whose step is no power of two, or whose origin is not of whole steps");
    const float scales[] = {0, -1, NAN, INFINITY, 3, 0x1p113f, 0x1p127f};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++)
        taken += changed(image, size, 80, &scales[i], 4) == PROBE_OK;
    const float two = 2;
    ok(taken == 0 && changed(image, size, 80, &two, 4) == PROBE_OK &&
           changed(floats, float_size, 80, &two, 4) == PROBE_BAD_IMAGE,
       "refused: scales of light that are no power of two or let it overflow, and of floats");

    const size_t site = 128;
    const double sites[] = {NAN, -1, 0.5, 0x1p41, INFINITY, -0x1p-1074};
    for (size_t i = 0; i < sizeof sites / sizeof *sites; i++)
        taken += changed(image, size, site + 8, &sites[i], 8) != PROBE_BAD_POSITION;
    ok(taken == 0, "refused: sites that are not on the lattice");
    const size_t light = (site + 24 * b.mesh.probes + 63) / 64 * 64;
    const uint16_t halves[] = {0x7c00, 0xfc00, 0x7e00};
    const float numbers[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < 3; i++) {
        taken += changed(image, size, light + 2, &halves[i], 2) != PROBE_BAD_IMAGE;
        taken += changed(floats, float_size, light + 4, &numbers[i], 4) != PROBE_BAD_IMAGE;
    }
    ok(taken == 0, "refused: light that is no number");
    const size_t vertex = (light + 24 * b.mesh.probes + 63) / 64 * 64,
                 neighbour = (vertex + 8 * b.mesh.cells + 63) / 64 * 64;
    const uint16_t none = 0xffff, one_too_many = (uint16_t)b.mesh.probes,
                   cell_too_many = (uint16_t)b.mesh.cells, itself = 0;
    ok(changed(image, size, vertex, &none, 2) == PROBE_BAD_VERTEX &&
           changed(image, size, vertex, &one_too_many, 2) == PROBE_BAD_VERTEX &&
           changed(image, size, neighbour, &cell_too_many, 2) == PROBE_BAD_NEIGHBOUR &&
           changed(image, size, neighbour, &itself, 2) == PROBE_BAD_NEIGHBOUR,
       "refused: cells that name what there is not, or themselves");

    struct probe_volume *v;
    char *shifted = malloc(size + 8);
    memcpy(shifted + 4, image, size);
    ok(probe_volume_open(&v, shifted + 4, size, 0, NULL) == PROBE_BAD_ARGUMENT && !v,
       "refused: a file on no multiple of 8 bytes");
    free(shifted);
    taken = 0;
    /* cut short, its size and checksum made right */
    for (size_t bytes = 0; bytes < size; bytes += bytes < 200 ? 1 : 64) {
        uint64_t *copy = malloc(bytes ? bytes : 1);
        const uint64_t says = bytes;
        memcpy(copy, image, bytes);
        if (bytes >= 128) {
            memcpy((char *)copy + 88, &says, sizeof says);
            seal(copy, bytes);
        }
        taken += probe_volume_open(&v, copy, bytes, 0, NULL) == PROBE_OK;
        free(copy);
    }
    ok(taken == 0, "refused: a file cut short that says so");

    v = create(&b, 0);
    ok(!probe_volume_pack(v, 7, b.sh, 0, PROBE_PACK_HALF, NULL, 0) &&
           !probe_volume_pack(v, -1, b.sh, 0, PROBE_PACK_HALF, NULL, 0) &&
           !probe_volume_pack(v, 2, NULL, 0, PROBE_PACK_FLOAT, NULL, 0) &&
           !probe_volume_pack(v, 2, b.sh, 0, (enum probe_packing)2, NULL, 0),
       "orders and packings that there are not are not packed");
    probe_volume_destroy(v);
    free(image);
    free(floats);
    tetra_clear(&b.t);
}

/* -- groups of lights ------------------------------------------------------------------------- */

enum { GROUPS = 3 };

static const char *const group_names[GROUPS] = {"alarm", "lamps-2", "rest"};

/* Each group's light is that of other probes, so that it is told apart. */
static void *pack_groups(const struct baked *b, int order, enum probe_packing packing, size_t *size,
                         const float *light[GROUPS])
{
    struct probe_volume *v = create(b, 0);
    for (size_t g = 0; g < GROUPS; g++)
        light[g] = b->sh + (g + 1) * 3 * (size_t)(order * order);
    const struct probe_groups groups = {GROUPS, group_names, light};
    *size = probe_volume_pack_groups(v, order, b->sh, 0, packing, &groups, NULL, 0);
    void *image = malloc(*size);
    if (!*size || !image ||
        probe_volume_pack_groups(v, order, b->sh, 0, packing, &groups, image, *size) != *size)
        bail("no groups are packed");
    probe_volume_destroy(v);
    return image;
}

/* What a packed file's probe number i is in the mesh: cells are the same. */
static void find_numbers(const struct probe_volume *v, const struct baked *b, int32_t *number)
{
    struct probe_place place = {.cell = PROBE_COLD};
    for (size_t i = 0; i < b->mesh.probes; i++) {
        probe_volume_locate(v, b->position + 3 * i, &place);
        for (int k = 0; k < 4; k++)
            if (place.weight[k] > 0.999999)
                number[place.probe[k]] = (int32_t)i;
    }
}

static void test_groups(int order)
{
    static const float weights[][9] = {
        {0, 0, 0, 1, 1, 1, 0, 0, 0}, {0.25f, 1.5f, 0, -0.3f, 7, 1e-3f, 1, 1.1f, 0.7f}, {0}};
    static struct baked b;
    static float lit[WIDTH_MOST * MOST];
    static int32_t number[MOST];
    const size_t width = (size_t)(3 * order * order);
    const float *light[GROUPS];
    struct random r = random_start(8, 0, 0);
    bake(&b, 4, 100);
    for (int half = 0; half < 2; half++) {
        size_t size;
        void *image =
            pack_groups(&b, order, half ? PROBE_PACK_HALF : PROBE_PACK_FLOAT, &size, light);
        struct probe_volume *v = open_image(image, size, 0);
        bool same = probe_volume_groups(v) == GROUPS && !probe_volume_group_name(v, GROUPS);
        for (size_t g = 0; g < GROUPS; g++)
            same = same && !strcmp(probe_volume_group_name(v, g), group_names[g]);
        find_numbers(v, &b, number);
        double worst = 0, apart = 0;
        heap_begin(0);
        for (size_t w = 0; w < sizeof weights / sizeof *weights; w++) {
            same = same && probe_volume_relight(v, weights[w], lit) == PROBE_OK;
            for (size_t i = 0; i < b.mesh.probes * width; i++) {
                const size_t from = (size_t)number[i / width] * width + i % width;
                double sum = 0, size_of_all = 0;
                for (size_t g = 0; g < GROUPS; g++) {
                    const double part = (double)weights[w][3 * g + i % 3] * (double)light[g][from];
                    sum += part;
                    size_of_all += fabs(part);
                }
                same = same && (half || lit[i] == (float)sum);
                worst = fmax(worst, fabs((double)lit[i] - sum) / (size_of_all + 1e-9));
            }
            for (int n = 0; n < 100; n++) {
                float here[WIDTH_MOST], there[WIDTH_MOST];
                const double p[3] = {4096 * random_double(&r), 4096 * random_double(&r),
                                     4096 * random_double(&r)};
                struct probe_place place = {.cell = PROBE_COLD};
                probe_volume_locate(v, p, &place);
                probe_blend(&place, lit, width, there);
                probe_volume_light_weighted(v, &place, weights[w], here);
                for (size_t k = 0; k < width; k++)
                    apart = fmax(apart, fabs((double)here[k] - (double)there[k]));
            }
        }
        same = same && !heap.calls;
        heap.on = false;
        ok(same && worst <= (half ? 0x1.1p-11 : 0x1p-24) && (half ? worst > 0x1p-13 : true),
           "order %d, %s: all probes' light is the sum of weighted groups (off by %g of it), and "
           "nothing is allocated",
           order, half ? "halves" : "floats", worst);
        ok(apart < 1e-5, "so is the light of a place (%g)", apart);
        const float bad[9] = {1, 1, 1, 1, NAN};
        ok(probe_volume_relight(v, bad, lit) == PROBE_BAD_ARGUMENT, "weights are numbers");
        probe_volume_destroy(v);
        free(image);
    }
    tetra_clear(&b.t);
}

static void test_group_files(void)
{
    static struct baked b;
    size_t size, plain_size;
    const float *light[GROUPS];
    float sh[3] = {1, 1, 1};
    bake(&b, 4, 100);
    char *image = pack_groups(&b, 1, PROBE_PACK_FLOAT, &size, light),
         *plain = pack(&b, 1, PROBE_PACK_FLOAT, &plain_size);
    struct probe_volume *v = open_image(plain, plain_size, 0);
    struct probe_place place = {.cell = PROBE_COLD};
    probe_volume_locate(v, b.position, &place);
    probe_volume_light_weighted(v, &place, NULL, sh);
    ok(!probe_volume_groups(v) && !probe_volume_group_name(v, 0) &&
           probe_volume_relight(v, NULL, NULL) == PROBE_NO_GROUPS && sh[0] + sh[1] + sh[2] == 0,
       "a file without groups says so");
    probe_volume_destroy(v);
    uint64_t name_bytes;
    memcpy(&name_bytes, image + 104, sizeof name_bytes);
    ok(name_bytes == 19 && changed(image, size, 0, "p", 1) == PROBE_OK &&
           !memcmp(image + 128, plain + 128, plain_size - 128),
       "groups stand behind what a file without them holds");

    static const struct {
        size_t at, bytes;
        uint64_t number;
        enum probe_status status;
        const char *what;
    } whole[] = {{16, 4, 1, PROBE_BAD_IMAGE, "version 1"},
                 {21, 1, 0, PROBE_BAD_IMAGE, "order 0"},
                 {84, 4, 0, PROBE_BAD_IMAGE, "no groups"},
                 {84, 4, 2, PROBE_BAD_IMAGE, "two groups, of three names"},
                 {84, 4, 4097, PROBE_BAD_IMAGE, "too many groups"},
                 {84, 4, UINT32_MAX, PROBE_BAD_IMAGE, "2^32 - 1 groups"},
                 {104, 8, 0, PROBE_BAD_IMAGE, "no names"},
                 {104, 8, 18, PROBE_BAD_IMAGE, "a last name that does not end"},
                 {104, 8, 20, PROBE_BAD_IMAGE, "a name of nothing"},
                 {104, 8, UINT64_MAX - 45, PROBE_BAD_IMAGE, "2^64 bytes of names"},
                 {112, 8, 1, PROBE_NOT_AN_IMAGE, "a number that is reserved"}};
    for (size_t i = 0; i < sizeof whole / sizeof *whole; i++)
        ok(changed(image, size, whole[i].at, &whole[i].number, whole[i].bytes) == whole[i].status,
           "refused with groups: %s", whole[i].what);
    const size_t names = plain_size, first = names + 64;
    const float numbers[] = {NAN, INFINITY};
    const size_t last = first + b.mesh.probes * 9 * sizeof(float) - sizeof(float);
    int taken = 0;
    for (size_t i = 0; i < 2; i++)
        taken += changed(image, size, first, &numbers[i], 4) != PROBE_BAD_IMAGE ||
                 changed(image, size, last, &numbers[i], 4) != PROBE_BAD_IMAGE;
    ok(taken == 0 && changed(image, size, names, "b", 1) == PROBE_OK &&
           changed(image, size, names, "B", 1) == PROBE_BAD_IMAGE &&
           changed(image, size, names, "", 1) == PROBE_BAD_IMAGE &&
           changed(image, size, names + 5, "x", 1) == PROBE_BAD_IMAGE,
       "refused: light that is no number, and names that are none");
    const uint64_t one_more = name_bytes + 1;
    image[names + name_bytes] = 'x';
    ok(changed(image, size, 104, &one_more, 8) == PROBE_BAD_IMAGE,
       "refused: enough names, and the beginning of another one");

    v = create(&b, 0);
    const char *const bad_names[] = {"Alarm", "", "a b"}, *const good[] = {"a"};
    static float broken[3 * 100];
    broken[7] = NAN;
    const float *const no_light = broken;
    struct probe_groups groups = {1, NULL, light};
    for (size_t i = 0; i < 3; i++) {
        groups.name = bad_names + i;
        taken += probe_volume_pack_groups(v, 1, b.sh, 0, PROBE_PACK_HALF, &groups, NULL, 0) != 0;
    }
    groups.name = good;
    taken += probe_volume_pack_groups(v, 0, b.sh, 0, PROBE_PACK_HALF, &groups, NULL, 0) != 0;
    groups.count = 0;
    const size_t none = probe_volume_pack_groups(v, 1, b.sh, 0, PROBE_PACK_FLOAT, &groups, NULL, 0);
    groups = (struct probe_groups){1, good, &no_light};
    taken += probe_volume_pack_groups(v, 1, b.sh, 0, PROBE_PACK_FLOAT, &groups, NULL, 0) != 0;
    ok(taken == 0 && none == plain_size,
       "names that are none, light that is no number, groups of nothing are not packed");
    probe_volume_destroy(v);
    free(image);
    free(plain);
    tetra_clear(&b.t);
}

int main(void)
{
    for (int corners = 1; corners <= 4; corners++)
        test_bytes(corners);
    test_no_memory();
    test_every_half();
    test_range();
    for (unsigned flags = 0; flags <= PROBE_LEAN; flags++)
        test_threads(flags);
    test_threads(PROBE_LAZY);
    test_headers();
    for (int order = 1; order <= 6; order += order == 3 ? 3 : 1)
        test_groups(order);
    test_group_files();
    return tap_done();
}
