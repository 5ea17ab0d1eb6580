/* SPDX-License-Identifier: Apache-2.0 */
/* A hostile stream: whatever bytes a file holds, reading it ends, with a valid stream or an error,
 * and harms nothing.
 *
 *     fuzz_stream [MUTATIONS [SEED]]     small streams, mutated; part of make check with few
 * mutations
 *
 * Half of the mutated binary streams get their checksums made right again, so that the reader sees
 * what lies behind them. For longer: fuzz_stream 10000000, or build with clang -fsanitize=fuzzer
 * -DFUZZ_ENGINE; an input's first byte says by its lowest bit whether its checksums are made right,
 * the rest is the stream.
 */
#include "base/error.h"
#include "math/random.h"
#include "stream/stream.h"
#include "support/files.h"
#include "support/tap.h"

#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What must hold; aborts when it does not. */
static void require(bool holds, const char *what)
{
    if (holds)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

/* A file in memory with a path; its descriptor. */
static int memory_file(char path[32])
{
    const int fd = memfd_create("stream", 0);
    if (fd < 0)
        bail("no file in memory");
    snprintf(path, 32, "/proc/self/fd/%d", fd);
    return fd;
}

static void write_file(int fd, const uint8_t *data, size_t size)
{
    if (ftruncate(fd, 0) || pwrite(fd, data, size, 0) != (ssize_t)size)
        bail("no room in memory");
}

/* -- checksums made right (man probe.5, "Binary") ---------------------------------------------- */

struct sealer {
    uint8_t *at, *end, *from; /* from: first byte that no checksum covers yet */
    uint64_t sum;
};

/* The checksum of from .. at-1 and `count` further bytes behind `skip`. */
static uint64_t seal(struct sealer *s, size_t skip, size_t count)
{
    XXH3_state_t *state = XXH3_createState();
    require(state, "memory");
    XXH3_64bits_reset_withSeed(state, s->sum);
    XXH3_64bits_update(state, s->from, (size_t)(s->at - s->from));
    XXH3_64bits_update(state, s->at + skip, count);
    s->sum = XXH3_64bits_digest(state);
    XXH3_freeState(state);
    s->at += skip + count;
    s->from = s->at;
    return s->sum;
}

static void seal_blocks(struct sealer *s)
{
    for (uint32_t counts[2] = {1, 0}; counts[0] && s->end - s->at >= 16;) {
        memcpy(counts, s->at, sizeof counts);
        const size_t left = (size_t)(s->end - s->at) - 16,
                     bytes = counts[1] < left ? counts[1] : left;
        s->at += 8;
        uint8_t *place = s->at;
        const uint64_t sum = seal(s, 8, bytes);
        memcpy(place, &sum, sizeof sum);
    }
}

static void seal_stream(uint8_t *data, size_t size)
{
    static const char magic[] = "#?probe 1 binary\n";
    struct sealer s = {.at = data, .end = data + size, .from = data};
    if (size < sizeof magic - 1 || memcmp(data, magic, sizeof magic - 1))
        return;
    while (s.at < s.end) {
        uint8_t *newline = memchr(s.at, '\n', (size_t)(s.end - s.at));
        const size_t length = newline ? (size_t)(newline - s.at) : (size_t)(s.end - s.at);
        if (length == 20 && !memcmp(s.at, "end ", 4)) {
            char hex[17];
            s.at += 4;
            uint8_t *place = s.at;
            snprintf(hex, sizeof hex, "%016llx", (unsigned long long)seal(&s, 0, 0));
            memcpy(place, hex, 16);
            return;
        }
        const bool table = length > 6 && !memcmp(s.at, "table ", 6);
        s.at += length + (newline != NULL);
        if (table)
            seal_blocks(&s);
    }
}

/* -- one input -------------------------------------------------------------------------------- */

static bool same_columns(const struct table *a, const struct table *b)
{
    bool same = a->rows == b->rows && a->column_count == b->column_count &&
                !strcmp(a->name, b->name);
    for (size_t i = 0; same && i < a->column_count; i++)
        same = !strcmp(a->columns[i].name, b->columns[i].name) &&
               a->columns[i].width == b->columns[i].width &&
               !memcmp(a->columns[i].data, b->columns[i].data,
                       a->rows * a->columns[i].width * column_type_size(a->columns[i].type));
    return same;
}

/* What was read can be written, in either encoding, and comes back. */
static void check_round_trip(const struct stream *s, enum stream_encoding encoding)
{
    struct stream *again = NULL;
    struct error *err = stream_write(s, files_path("again"), encoding);
    if (!err)
        err = stream_read(&again, files_path("again"));
    require(!err, err ? error_message(err) : "");
    require(again->table_count == s->table_count && again->header.key_count == s->header.key_count,
            "all tables and keys come back");
    for (size_t i = 0; i < s->table_count; i++)
        require(same_columns(&s->tables[i], &again->tables[i]), "every bit comes back");
    stream_destroy(again);
}

static unsigned long accepted;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char path[32];
    static int fd = -1;
    if (fd < 0) {
        fd = memory_file(path);
        files_begin();
        atexit(files_end);
    }
    uint8_t *copy = malloc(size + 1);
    if (!size || !copy) {
        free(copy);
        return 0;
    }
    memcpy(copy, data + 1, size - 1);
    if (data[0] & 1)
        seal_stream(copy, size - 1);
    write_file(fd, copy, size - 1);
    free(copy);

    struct stream *s = NULL;
    struct error *err = stream_read(&s, path);
    require(!err == (s != NULL), "a stream or an error");
    if (s) {
        accepted++;
        err = stream_check(s);
        require(!err, "what is read is valid");
        check_round_trip(s, STREAM_TEXT);
        check_round_trip(s, STREAM_BINARY);
    }
    error_destroy(err);
    stream_destroy(s);
    return 0;
}

#ifndef FUZZ_ENGINE

enum { ROOM = 1 << 14 };

struct bytes {
    uint8_t data[ROOM];
    size_t size;
};

/* A small stream with all that a stream can hold, as an input. */
static void make_seed(struct bytes *seed, enum stream_encoding encoding)
{
    struct stream *s = NULL;
    struct table *probes = NULL, *cells = NULL;
    struct error *err = stream_create(&s);
    if (!err)
        err = header_add_provenance(&s->header, "probe-place grid --spacing 1");
    if (!err)
        err = header_set_key(&s->header, "sh-order", "1");
    if (!err)
        err = stream_add_table(s, "probe", &probes);
    if (!err)
        err = table_add_column(probes, "position", COLUMN_F64, 3, NULL);
    if (!err)
        err = table_add_column(probes, "sh", COLUMN_F32, 3, NULL);
    if (!err)
        err = table_add_column(probes, "origin", COLUMN_I32, 1, NULL);
    if (!err)
        err = table_resize(probes, 5);
    if (err)
        bail("%s", error_message(err));
    for (int i = 0; i < 15; i++) {
        column_f64(&probes->columns[0])[i] = i * i % 7 / 3.0;
        if (i < 12) /* the last probe has no light */
            column_f32(&probes->columns[1])[i] = (float)(i - 5) / 7.0f;
    }
    err = stream_add_table(s, "tet", &cells);
    if (!err)
        err = table_add_column(cells, "vertex", COLUMN_I32, 4, NULL);
    if (!err)
        err = table_add_column(cells, "neighbour", COLUMN_I32, 4, NULL);
    if (!err)
        err = table_resize(cells, 2);
    if (!err) {
        memcpy(cells->columns[0].data, (const int32_t[]){0, 1, 2, 3, 1, 2, 3, 4}, 32);
        memcpy(cells->columns[1].data, (const int32_t[]){1, -1, -1, -1, -1, -1, -1, 0}, 32);
        err = stream_write(s, files_path("seed"), encoding);
    }
    FILE *f = err ? NULL : fopen(files_path("seed"), "rb");
    if (!f)
        bail("%s", err ? error_message(err) : "no seed");
    seed->data[0] = 0;
    seed->size = 1 + fread(seed->data + 1, 1, ROOM / 2, f);
    fclose(f);
    stream_destroy(s);
}

static uint32_t number_below(struct random *r, size_t n)
{
    return random_u32(r) % (uint32_t)n;
}

/* Changes a few places: a bit, a byte, a word in the text, a piece cut out, doubled, or moved. */
static void mutate(struct bytes *b, struct random *r)
{
    static const char *const words[] = {
        "-1",         "0",  "4294967295", "1e999", "nan", "inf",     "end",  "table x y:f32:1\n",
        " ",          "\n", "#",          ":",     "f64", "1048576", "\r\n", "\xff\xff\xff\xff",
        "key value\n"};
    b->data[0] = (uint8_t)number_below(r, 2);
    for (uint32_t times = 1 + number_below(r, 4); times > 0 && b->size > 2; times--) {
        const size_t at = 1 + number_below(r, b->size - 1), length = 1 + number_below(r, 40);
        const size_t piece = length < b->size - at ? length : b->size - at,
                     from = 1 + number_below(r, b->size - piece);
        const char *word = words[number_below(r, sizeof words / sizeof *words)];
        switch (number_below(r, 7)) {
        case 0: b->data[at] ^= (uint8_t)(1u << number_below(r, 8)); break;
        case 1: b->data[at] = (uint8_t)number_below(r, 256); break;
        case 2: /* cut out */
            memmove(b->data + at, b->data + at + piece, b->size - at - piece);
            b->size -= piece;
            break;
        case 3: /* cut off, now and then */ b->size = number_below(r, 8) ? b->size : at; break;
        case 4: /* a word in place of what is there */
            memcpy(b->data + at, word, strlen(word) < b->size - at ? strlen(word) : b->size - at);
            break;
        case 5: /* a piece from elsewhere */ memmove(b->data + at, b->data + from, piece); break;
        default: /* doubled */
            if (b->size + piece <= ROOM) {
                memmove(b->data + at + piece, b->data + at, b->size - at);
                b->size += piece;
            }
        }
    }
}

int main(int argc, char **argv)
{
    const unsigned long mutations = argc > 1 ? strtoul(argv[1], NULL, 10) : tap_cases(40000);
    struct random r = random_start(argc > 2 ? strtoull(argv[2], NULL, 10) : 1, 0, 0);
    static struct bytes seeds[2];
    LLVMFuzzerTestOneInput((const uint8_t *)"", 0); /* makes the directory */
    make_seed(&seeds[0], STREAM_TEXT);
    make_seed(&seeds[1], STREAM_BINARY);
    for (int i = 0; i < 2; i++) {
        LLVMFuzzerTestOneInput(seeds[i].data, seeds[i].size);
        seeds[i].data[0] = 1;
        LLVMFuzzerTestOneInput(seeds[i].data, seeds[i].size);
    }
    ok(accepted == 4, "the seeds are streams, and making right checksums changes none");
    for (unsigned long i = 0; i < mutations; i++) {
        struct bytes b = seeds[i % 2];
        mutate(&b, &r);
        LLVMFuzzerTestOneInput(b.data, b.size);
    }
    ok(true, "%lu mutated streams were read (%lu) or refused", mutations, accepted);
    return tap_done();
}

#endif
