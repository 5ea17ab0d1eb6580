/* SPDX-License-Identifier: Apache-2.0 */
/* Hostile meshes and packed files: whatever numbers they hold, making a volume ends, with a volume
 * or a status, and whatever a volume was made of, each point has a place, in bounds, with weights
 * that sum to 1.
 *
 *     fuzz_query [MUTATIONS [SEED]]     small meshes, mutated; part of make check with few
 *
 * For longer: fuzz_query 100000000, or build with clang -fsanitize=fuzzer -DFUZZ_ENGINE; an input's
 * first byte says by its lowest bit whether it is a packed file (whose checksum is made right) or a
 * mesh: corners, probes and cells (a byte each), then positions, vertices and neighbours, and, if
 * there is more, sight and stand-ins.
 */
#include "libprobe-query/probe-query.h"
#include "math/random.h"
#include "support/tap.h"

#include <stdint.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static unsigned long accepted, sighted;

static void require(bool holds, const char *what)
{
    if (holds)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

/* Asks for places near, on, between and far from what is there, and for the light. */
static void ask(const struct probe_volume *v, uint64_t seed)
{
    struct random r = random_start(seed, 1, 0);
    struct probe_place place = {.cell = PROBE_COLD}, many[32];
    double point[32][3];
    float sh[108];
    const struct probe_image_facts facts = probe_volume_image(v);
    for (int i = 0; i < 32; i++) {
        for (int k = 0; k < 3; k++) {
            const double at = 8 * random_double(&r) - 2;
            point[i][k] = i % 8 == 0   ? floor(at)
                          : i % 8 == 1 ? at * 1e300
                          : i % 8 == 2 ? at * 1e-300
                                       : at;
        }
        if (i % 5 == 0)
            place.cell = (int32_t)random_u32(&r);
        require(probe_volume_locate(v, point[i], &place) == PROBE_OK, "a finite point has a place");
        double sum = 0;
        for (int k = 0; k < 4; k++) {
            require(place.weight[k] >= 0 && place.probe[k] >= 0 &&
                        (size_t)place.probe[k] < probe_volume_probes(v),
                    "weights and probes are in bounds");
            sum += place.weight[k];
        }
        require(fabs(sum - 1) < 1e-6, "weights sum to 1");
        require(place.cell >= 0 && (size_t)place.cell < probe_volume_cells(v),
                "the cell is in bounds");
        require(place.inside ? place.distance == 0 : place.distance >= 0, "the distance is one");
        if (facts.order) {
            probe_volume_light(v, &place, sh);
            for (int k = 0; k < 3 * facts.order * facts.order; k++)
                require(!isnan(sh[k]), "light is a number");
        }
        if (i % 8 == 3 && facts.order && probe_volume_groups(v) <= 2) {
            const float weight[6] = {1, 0.5f, 0, 1, 1, 1};
            probe_volume_light_weighted(v, &place, weight, sh);
            for (int k = 0; k < 3 * facts.order * facts.order; k++)
                require(!isnan(sh[k]), "weighted light is a number");
        }
    }
    for (size_t g = 0; g < probe_volume_groups(v); g++)
        require(strlen(probe_volume_group_name(v, g)) < 256, "a group has a name");
    many[0].cell = PROBE_COLD;
    require(probe_volume_locate_many(v, 32, point[0], 3, NULL, many) == PROBE_OK, "many at once");
    uint32_t order[32];
    uint64_t room[96];
    probe_volume_order(v, 32, point[0], 3, order, room);
    for (int i = 0; i < 32; i++)
        require(order[i] < 32, "an order");
}

static void try_packed(const uint8_t *data, size_t size)
{
    uint64_t *image = malloc(size + 8);
    require(image, "memory");
    memcpy(image, data, size);
    /* the checksum stands behind 8 bytes, and is of all behind it; the size is at 88 */
    if (size >= 128) {
        image[11] = size;
        const uint64_t sum = XXH3_64bits((const char *)image + 16, size - 16);
        image[1] = sum;
    }
    for (unsigned flags = 0; flags <= PROBE_LAZY;
         flags += flags < PROBE_SEE_ALL ? 1 : PROBE_LAZY - PROBE_SEE_ALL) {
        struct probe_volume *v;
        const enum probe_status status = probe_volume_open(&v, image, size, flags, NULL);
        require((status == PROBE_OK) == (v != NULL), "a volume or a status");
        if (v)
            ask(v, size);
        accepted += v != NULL;
        sighted += v && probe_volume_sees(v);
        probe_volume_destroy(v);
    }
    free(image);
}

/* What is refused is not kept; what is taken can be taken back. */
static void try_sight(struct probe_volume *v, const float *sight, const int32_t *stand_in)
{
    const size_t bytes = probe_volume_bytes(v);
    size_t row;
    const enum probe_status status = probe_volume_set_sight(v, sight, stand_in, &row);
    require(status == PROBE_OK || (status == PROBE_BAD_SIGHT && row < probe_volume_cells(v)),
            "sight, or a status and a cell");
    require((status == PROBE_OK) == (probe_volume_sees(v) != 0), "a volume that sees, or a status");
    sighted += status == PROBE_OK;
    ask(v, bytes);
    if (probe_volume_corners(v) == 4 && status == PROBE_OK) { /* as many numbers, and of any size */
        const size_t less = probe_volume_bytes(v);
        const enum probe_status outside = probe_volume_set_sight_outside(v, sight, stand_in, &row);
        require(outside == PROBE_OK && probe_volume_bytes(v) >= less, "the outside, too");
        ask(v, bytes);
    }
    probe_volume_set_sight(v, NULL, NULL, NULL);
    require(!probe_volume_sees(v) && probe_volume_bytes(v) == bytes, "sight is taken back");
    if (bytes & 8)
        probe_volume_set_sight(v, sight, NULL, NULL);
    else
        probe_volume_set_sight(v, sight, stand_in, NULL);
}

static void try_mesh(const uint8_t *data, size_t size)
{
    static double position[3 * 256];
    static int32_t vertex[4 * 256], neighbour[4 * 256], stand_in[256];
    static float sight[12 * 256];
    struct probe_mesh m = {.position = position, .vertex = vertex, .neighbour = neighbour};
    if (size < 3)
        return;
    m.corners = data[0] % 6;
    m.probes = data[1];
    m.cells = data[2];
    const size_t corners = m.corners > 4 ? 4 : (size_t)m.corners;
    const size_t bytes[3] = {3 * m.probes * sizeof *position, corners * m.cells * 4,
                             corners * m.cells * 4};
    const size_t plain = 3 + bytes[0] + bytes[1] + bytes[2];
    if (size < plain)
        return;
    memcpy(position, data + 3, bytes[0]);
    memcpy(vertex, data + 3 + bytes[0], bytes[1]);
    memcpy(neighbour, data + 3 + bytes[0] + bytes[1], bytes[2]);
    const size_t sights = m.cells * corners * (corners - 1) * sizeof *sight;
    const bool sees = corners > 0 && size > plain && size - plain >= sights + m.cells * 4;
    if (sees) {
        memcpy(sight, data + plain, sights);
        memcpy(stand_in, data + plain + sights, m.cells * 4);
    }
    for (unsigned flags = 0; flags <= (PROBE_LEAN | PROBE_NEAREST | PROBE_EXTEND); flags++) {
        struct probe_volume *v;
        const enum probe_status status = probe_volume_create(&v, &m, flags, NULL);
        require((status == PROBE_OK) == (v != NULL), "a volume or a status");
        if (v && sees)
            try_sight(v, sight, stand_in);
        if (v)
            ask(v, size);
        accepted += v != NULL;
        probe_volume_destroy(v);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!size)
        return 0;
    if (data[0] & 1)
        try_packed(data + 1, size - 1);
    else
        try_mesh(data + 1, size - 1);
    return 0;
}

#ifndef FUZZ_ENGINE

enum { ROOM = 1 << 14, KINDS = 12 };

struct bytes {
    uint8_t data[ROOM];
    size_t size;
};

/* 2 x 2 x 2 cubes of six tetrahedra each around their diagonals, 3 x 3 triangles' squares, segments
 * or a point, of whole numbers. */
static void make_mesh(int corners, double position[3 * 27], int32_t *vertex, int32_t *neighbour,
                      struct probe_mesh *m)
{
    static const int walk[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                   {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    const int dimensions = corners - 1;
    *m = (struct probe_mesh){
        .corners = corners, .position = position, .vertex = vertex, .neighbour = neighbour};
    int32_t stride[3];
    m->probes = 1;
    for (int k = 0; k < dimensions; k++) {
        stride[k] = (int32_t)m->probes;
        m->probes *= 3;
    }
    for (size_t i = 0; i < m->probes; i++)
        for (int k = 0; k < 3; k++)
            position[3 * i + (size_t)k] = k < dimensions ? (double)((int32_t)i / stride[k] % 3) : 0;
    for (size_t i = 0; i < m->probes; i++) {
        bool low = true;
        for (int k = 0; k < dimensions; k++)
            low = low && position[3 * i + (size_t)k] < 2;
        for (int w = 0; w < 6 && low; w++) {
            int32_t v[4] = {(int32_t)i, 0, 0, 0};
            bool good = true;
            int at = 0;
            /* permutations of the axes that there are, those that are not last and in order */
            for (int k = 0; k < 3; k++) {
                if (walk[w][k] < dimensions) {
                    v[at + 1] = v[at] + stride[walk[w][k]];
                    at++;
                }
                good = good && (walk[w][k] < dimensions || (k >= dimensions && walk[w][k] == k));
            }
            if (!good)
                continue;
            int32_t *to = vertex + (size_t)corners * m->cells++;
            memcpy(to, v, (size_t)corners * sizeof *to);
            if (w >= 3 && corners == 4) {
                to[2] = v[3];
                to[3] = v[2];
            }
        }
    }
    for (size_t a = 0; a < m->cells * (size_t)corners; a++) {
        neighbour[a] = -1;
        const int32_t *va = vertex + a / (size_t)corners * (size_t)corners;
        for (size_t b = 0; b < m->cells; b++) {
            int shared = 0;
            for (int i = 0; i < corners; i++)
                for (int j = 0; j < corners; j++)
                    shared += i != (int)(a % (size_t)corners) &&
                              va[i] == vertex[b * (size_t)corners + (size_t)j];
            if (b != a / (size_t)corners && shared == corners - 1 && corners > 1)
                neighbour[a] = (int32_t)b;
        }
    }
}

/* Sight of all kinds, and stand-ins. */
static void make_sight(const struct probe_mesh *m, float sight[12 * 48], int32_t stand_in[48])
{
    static const float numbers[] = {0, 1.5f, 0, 4, -1, 60, 0, 1, 16384};
    const size_t width = (size_t)(m->corners * (m->corners - 1));
    for (size_t i = 0; i < width * m->cells; i++)
        sight[i] = i / width % 4 ? numbers[i * 5 % (sizeof numbers / sizeof *numbers)] : 0;
    for (size_t i = 0; i < m->cells; i++)
        stand_in[i] = (int32_t)(i * 7 % (m->probes + 1)) - 1;
}

/* Floats without sight and halves with it have groups of lights, too. */
static void make_seed(int corners, bool packed, bool sees, enum probe_packing packing,
                      struct bytes *seed)
{
    static double position[3 * 27];
    static int32_t vertex[4 * 48], neighbour[4 * 48];
    static float sh[27 * 27], sight[12 * 48];
    static int32_t stand_in[48];
    struct probe_mesh m;
    make_mesh(corners, position, vertex, neighbour, &m);
    make_sight(&m, sight, stand_in);
    uint8_t *at = seed->data;
    *at++ = packed;
    if (packed) {
        struct probe_volume *v;
        for (size_t i = 0; i < 27 * m.probes; i++)
            sh[i] = (float)(i * 7 % 13) / 8;
        if (probe_volume_create(&v, &m, 0, NULL) ||
            (sees && probe_volume_set_sight(v, sight, stand_in, NULL)) ||
            (sees && corners == 4 && probe_volume_set_sight_outside(v, sight, stand_in, NULL)))
            bail("no seed");
        static uint64_t image[ROOM / 8];
        const char *const names[] = {"alarm", "rest"};
        const float *const light[] = {sh, sh + 12};
        const struct probe_groups groups = {sees == (packing == PROBE_PACK_HALF) ? 2 : 0, names,
                                            light};
        const size_t bytes =
            probe_volume_pack_groups(v, 2, sh, 0, packing, &groups, image, ROOM - 1);
        if (!bytes || bytes > ROOM - 1)
            bail("no room for a seed");
        memcpy(at, image, bytes);
        at += bytes;
        probe_volume_destroy(v);
    } else {
        *at++ = (uint8_t)corners;
        *at++ = (uint8_t)m.probes;
        *at++ = (uint8_t)m.cells;
        memcpy(at, position, m.probes * 24);
        at += m.probes * 24;
        memcpy(at, vertex, m.cells * (size_t)corners * 4);
        at += m.cells * (size_t)corners * 4;
        memcpy(at, neighbour, m.cells * (size_t)corners * 4);
        at += m.cells * (size_t)corners * 4;
        if (sees) {
            const size_t sights = m.cells * (size_t)(corners * (corners - 1)) * sizeof *sight;
            memcpy(at, sight, sights);
            at += sights;
            memcpy(at, stand_in, m.cells * 4);
            at += m.cells * 4;
        }
    }
    seed->size = (size_t)(at - seed->data);
}

static uint32_t below(struct random *r, size_t n)
{
    return random_u32(r) % (uint32_t)n;
}

/* Changes a few places: a bit, an index, a coordinate. */
static void mutate(struct bytes *b, struct random *r)
{
    static const double numbers[] = {0,      1,      -1,     0.5, 1e-12,    1e300, -1e300,
                                     1e-310, 0x1p39, 0x1p40, 3,   INFINITY, NAN};
    for (uint32_t times = 1 + below(r, 3); times > 0; times--) {
        const size_t at = 1 + below(r, b->size - 9);
        const int32_t index = (int32_t)below(r, 50) - 1;
        const double number = numbers[below(r, sizeof numbers / sizeof *numbers)];
        switch (below(r, 6)) {
        case 0: b->data[at] ^= (uint8_t)(1u << below(r, 8)); break;
        case 1: b->data[at] = (uint8_t)below(r, 64); break;
        case 2:
            memcpy(b->data + (at - 1) / 4 * 4 + (b->data[0] ? 1 : 4), &index, b->data[0] ? 2 : 4);
            break;
        case 3:
            memcpy(b->data + (at - 1) / 8 * 8 + (b->data[0] ? 1 : 4), &number, sizeof number);
            break;
        case 4: { /* an index from elsewhere */
            const size_t from = 1 + below(r, b->size - 9);
            memmove(b->data + at, b->data + from, 4);
            break;
        }
        default: /* cut off, now and then */ b->size = below(r, 40) ? b->size : at + 9;
        }
    }
}

int main(int argc, char **argv)
{
    const unsigned long mutations = argc > 1 ? strtoul(argv[1], NULL, 10) : tap_cases(40000);
    struct random r = random_start(argc > 2 ? strtoull(argv[2], NULL, 10) : 1, 0, 0);
    /* meshes, packed floats, packed halves; then the same with sight */
    static struct bytes seeds[2 * KINDS], b;
    for (int i = 0; i < 2 * KINDS; i++) {
        const int kind = i % KINDS;
        make_seed(1 + kind % 4, kind >= 4, i >= KINDS,
                  kind >= 8 ? PROBE_PACK_HALF : PROBE_PACK_FLOAT, &seeds[i]);
        LLVMFuzzerTestOneInput(seeds[i].data, seeds[i].size);
    }
    ok(accepted == 2 * (4 * 8 + 8 * 10) && sighted == 4 * 8 + 8 * 9,
       "the seeds are meshes, of each dimension, plain and packed (%lu), half with sight (%lu)",
       accepted, sighted);
    for (unsigned long i = 0; i < mutations; i++) {
        /* tetrahedra more often */
        const struct bytes *seed =
            &seeds[(i % 3 ? i % KINDS : (i / 3) % 3 * 4 + 3) + (i / KINDS % 2 ? KINDS : 0)];
        b.size = seed->size;
        memcpy(b.data, seed->data, seed->size);
        mutate(&b, &r);
        LLVMFuzzerTestOneInput(b.data, b.size);
    }
    ok(accepted > mutations / 20, "%lu mutated meshes became volumes (%lu) or were refused",
       mutations, accepted);
    ok(sighted > mutations / 20, "%lu volumes saw", sighted);
    return tap_done();
}

#endif
