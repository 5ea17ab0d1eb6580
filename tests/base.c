/* SPDX-License-Identifier: Apache-2.0 */
/* The lowest layer: errors gain context, arrays refuse to overflow, loops report the first failure
 * whatever the threads do, options mean what they say, files are read whole and appear whole. */
#include "base/array.h"
#include "base/claim.h"
#include "base/error.h"
#include "base/file.h"
#include "base/once.h"
#include "base/options.h"
#include "base/threads.h"
#include "base/warning.h"
#include "stream/common_options.h"
#include "support/files.h"
#include "support/tap.h"

#include <errno.h>
#include <stdint.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static void test_error(void)
{
    struct error *err = error_new("expected %d coordinates, got %d", 3, 2);
    err = error_wrap(err, "line %d", 12);
    err = error_wrap(err, "stdin");
    ok(!strcmp(error_message(err), "stdin: line 12: expected 3 coordinates, got 2"),
       "context is put in front");
    ok(error_status(err) == EXIT_BAD_DATA, "bad data by default");
    error_destroy(err);
    err = error_wrap(error_usage("no such option"), "--x");
    ok(error_status(err) == EXIT_BAD_USAGE, "a usage error stays one under context");
    error_destroy(err);
    ok(!error_wrap(NULL, "nothing"), "success stays success under context");
    ok(error_wrap(error_memory(), "anywhere") == error_memory(), "memory shortage needs no memory");
    err = error_system(ENOENT, "a.obj");
    ok(!strcmp(error_message(err), "a.obj: No such file or directory"),
       "system errors say what the system says");
    error_destroy(err);
}

static void test_array(void)
{
    double *a = NULL;
    size_t capacity = 0;
    struct error *err = array_reserve(&a, &capacity, 5, sizeof *a);
    ok(!err && a && capacity >= 5, "room for 5");
    a[4] = 7;
    err = array_reserve(&a, &capacity, 5000, sizeof *a);
    ok(!err && a[4] == 7 && capacity >= 5000, "growth keeps what was there");
    double *const before = a;
    err = array_reserve(&a, &capacity, SIZE_MAX / 2, sizeof *a);
    ok(err && a == before, "an overflowing size is an error and changes nothing");
    error_destroy(err);
    free(a);
    err = array_create(&a, SIZE_MAX / 2, sizeof *a);
    ok(err && !a, "so it is for a new array");
    error_destroy(err);
}

static bool fails_with(struct error *err, const char *message)
{
    const bool same = err && !strcmp(error_message(err), message);
    if (!same)
        printf("# %s\n", err ? error_message(err) : "no error");
    error_destroy(err);
    return same;
}

static void test_file_read(void)
{
    char *data = NULL, *big = NULL;
    size_t size = 0;
    files_write_bytes("a", "a\0b\n", 4);
    struct error *err = file_read(files_path("a"), &data, &size);
    ok(!err && size == 4 && !memcmp(data, "a\0b\n", 5), "a file, and a zero byte behind it");
    free(data);
    files_write("empty", "");
    err = file_read(files_path("empty"), &data, &size);
    ok(!err && size == 0 && data[0] == 0, "an empty one is that byte alone");
    free(data);
    ok(fails_with(file_read(files_path("none"), &data, &size), "No such file or directory") &&
           !data && !size,
       "one that is not there");
    ok(fails_with(file_read(files_directory, &data, &size), "Is a directory") && !data,
       "a directory");

    /* a pipe does not say how long it is */
    enum { BIG = 300000 };
    int ends[2];
    const bool piped = !pipe(ends);
    const pid_t child = piped ? fork() : -1;
    if (child == 0) {
        static char zeros[BIG];
        close(ends[0]);
        for (size_t done = 0; done < sizeof zeros;) {
            const ssize_t put = write(ends[1], zeros + done, sizeof zeros - done);
            if (put < 0)
                _exit(1);
            done += (size_t)put;
        }
        _exit(0);
    }
    close(ends[1]);
    struct file_input in;
    const unsigned char *bytes;
    char path[32];
    size_t got = 0;
    snprintf(path, sizeof path, "/proc/self/fd/%d", ends[0]);
    err = file_input_open(&in, path);
    if (!err)
        err = file_input_peek(&in, 10, &bytes, &got);
    if (!err)
        file_input_consume(&in, 10);
    if (!err)
        err = file_input_rest(&in, &big, &size);
    ok(!err && got == 10 && size == BIG - 10 && big[size] == 0,
       "the rest of a pipe, behind what was consumed: %zu bytes", size);
    file_input_close(&in);
    close(ends[0]);
    waitpid(child, NULL, 0);
    free(big);
}

static void test_file_lines(void)
{
    struct file_input in;
    const char *line = NULL;
    size_t length = 0, bytes = 0;
    files_write("lines", "one\n\ntwo");
    struct error *err = file_input_open(&in, files_path("lines"));
    if (!err)
        err = file_input_line(&in, &line, &length, &bytes);
    ok(!err && length == 3 && bytes == 4 && !memcmp(line, "one", 3), "a line without its newline");
    file_input_consume(&in, bytes);
    err = file_input_line(&in, &line, &length, &bytes);
    ok(!err && length == 0 && bytes == 1, "an empty one");
    file_input_consume(&in, bytes);
    err = file_input_line(&in, &line, &length, &bytes);
    ok(!err && length == 3 && bytes == 3, "the last, which has no newline");
    file_input_consume(&in, bytes);
    err = file_input_line(&in, &line, &length, &bytes);
    ok(!err && !line && in.offset == 8, "and then no more");
    file_input_close(&in);
}

static void test_file_write(void)
{
    struct file_output out;
    char *data = NULL;
    size_t size = 0;
    files_write("out", "before");
    struct error *err = file_output_open(&out, files_path("out"), true);
    if (!err)
        err = file_output_write(&out, "after", 5);
    ok(!err && !file_read(files_path("out"), &data, &size) && !strcmp(data, "before"),
       "until it is finished, a file is as it was");
    free(data);
    file_output_abandon(&out);
    ok(!file_read(files_path("out"), &data, &size) && !strcmp(data, "before"),
       "given up, it stays so");
    free(data);
    err = file_output_open(&out, files_path("out"), true);
    char *room = NULL;
    if (!err)
        err = file_output_room(&out, 3, &room);
    if (!err) {
        memcpy(room, "in ", 3);
        out.count += 3;
        err = file_output_write(&out, "order", 5);
    }
    if (!err)
        err = file_output_finish(&out);
    ok(!err && !file_read(files_path("out"), &data, &size) && !strcmp(data, "in order"),
       "finished, it holds what was written, in order");
    free(data);
    ok(!strcmp(file_input_name("-"), "stdin") && !strcmp(file_output_name("-"), "stdout") &&
           !strcmp(file_input_name("a"), "a") && !strcmp(file_output_name("a"), "a"),
       "messages call - what it is");
}

static void test_file(void)
{
    files_begin();
    test_file_read();
    test_file_lines();
    test_file_write();
    files_end();
}

static struct error *square_or_fail(void *context, size_t i, int thread)
{
    (void)thread;
    ((size_t *)context)[i] = i * i;
    return i == 700 || i == 300 ? error_new("item %zu", i) : NULL;
}

static void test_threads(void)
{
    static size_t squares[1000];
    struct error *err = threads_for(4, 300, square_or_fail, squares);
    bool all = true;
    for (size_t i = 0; i < 300; i++)
        all = all && squares[i] == i * i;
    ok(!err && all, "every item is done once, on 4 threads");
    for (int threads = 1; threads <= 4; threads++) {
        err = threads_for(threads, 1000, square_or_fail, squares);
        ok(err && !strcmp(error_message(err), "item 300"),
           "the first failure is reported with %d threads", threads);
        error_destroy(err);
    }
    ok(!threads_for(4, 0, square_or_fail, squares), "an empty loop is done at once");
}

static struct error *count_or_fail(void *context)
{
    int *count = context;
    return ++*count < 100 ? NULL : error_new("no more");
}

struct making {
    struct once *once;
    int count;
};

static struct error *make_one(void *context, size_t index, int thread)
{
    (void)index, (void)thread;
    struct making *making = context;
    return once_do(making->once, count_or_fail, &making->count);
}

static void test_once(void)
{
    for (int first = 0; first < 100; first += 99) {
        struct making making = {.count = first};
        struct error *err = once_create(&making.once);
        if (!err)
            err = threads_for(4, 300, make_one, &making);
        ok(making.count == first + 1, "300 askers on 4 threads make a thing once");
        ok(first ? err && !strcmp(error_message(err), "no more") : !err,
           first ? "its error is the askers'" : "and get it");
        error_destroy(err);
        once_destroy(making.once);
    }
    once_destroy(NULL);
}

static void test_warnings(void)
{
    struct warnings w = {0};
    for (int i = 0; i < 5; i++)
        warnings_add(&w, "texture missing", "texture %d", i);
    warnings_add(&w, "other", "something");
    warnings_add(NULL, "other", "nobody listens");
    ok(w.count == 2 && warnings_of_kind(&w, "texture missing") == 5,
       "warnings are counted by kind");
    warnings_clear(&w);
}

/* Parses one command line ("probe-x" and the words, separated by |) and checks the message or the
 * record. */
static void parse(const char *words, const char *expected)
{
    double spacing = 1.5, vector[3] = {1, 2, 3};
    int64_t rays = 10;
    int kind = 0;
    bool flag = false;
    const char *name = NULL;
    static const char *const kinds[] = {"all", "direct", NULL};
    const struct option_row rows[] = {
        {.name = "spacing",
         .letter = 's',
         .argument = "S",
         .help = "",
         .kind = OPTION_REAL,
         .value = &spacing,
         .least_open = true,
         .most = (double)INFINITY},
        {.name = "vector",
         .argument = "X,Y,Z",
         .help = "",
         .kind = OPTION_REALS,
         .count = 3,
         .value = vector},
        {.name = "rays",
         .argument = "N",
         .help = "",
         .kind = OPTION_INTEGER,
         .least = 1,
         .most = 100,
         .value = &rays},
        {.name = "light",
         .argument = "L",
         .help = "",
         .kind = OPTION_CHOICE,
         .choices = kinds,
         .value = &kind},
        {.name = "flag", .help = "", .kind = OPTION_FLAG, .value = &flag},
        {.name = "name", .argument = "N", .help = "", .kind = OPTION_TEXT, .value = &name},
        {0}};
    struct common common = common_default();
    struct option_row shared[COMMON_ROWS];
    const struct option_row *const groups[] = {rows, common_rows(&common, ~0u, shared), NULL};
    struct program program = {
        .name = "probe-x", .usage = "FILE", .summary = "", .operands_most = 1};
    char buffer[256];
    char *argv[16];
    int argc = 0;
    snprintf(buffer, sizeof buffer, "probe-x%s%s", *words ? "|" : "", words);
    for (char *save = NULL, *word = strtok_r(buffer, "|", &save); word;
         word = strtok_r(NULL, "|", &save))
        argv[argc++] = word;
    argv[argc] = NULL;
    struct error *err = options_parse(&program, groups, argc, argv);
    const char *got = err ? error_message(err) : program.recorded;
    ok(!strcmp(got, expected) && (!err || error_status(err) == EXIT_BAD_USAGE), "%s: %s", words,
       got);
    error_destroy(err);
    program_clear(&program);
}

enum shade { SHADE_PALE, SHADE_GREY, SHADE_DARK };

/* Values arrive where they live, each in its own type, and nothing beside it is touched. */
static void test_option_values(void)
{
    struct {
        int before, depth, after;
        enum shade shade, worn;
        int64_t rays;
    } v = {.before = -1, .depth = 4, .after = -1, .shade = SHADE_GREY};
    bool seed_given = false;
    static const char *const shades[] = {[SHADE_DARK] = "dark",
                                         [SHADE_PALE] = "pale",
                                         [SHADE_GREY] = "grey",
                                         [SHADE_DARK + 1] = NULL};
    const struct option_row rows[] = {
        {.name = "depth", .argument = "N", .help = "", .kind = OPTION_INT, .value = &v.depth},
        {.name = "rays", .argument = "N", .help = "", .kind = OPTION_INTEGER, .value = &v.rays},
        {.name = "shade",
         .argument = "WHICH",
         .help = "",
         .kind = OPTION_CHOICE,
         .choices = shades,
         .value = OPTION_ENUM(v.shade)},
        {.name = "worn",
         .help = "",
         .kind = OPTION_SET,
         .count = SHADE_PALE + 1,
         .value = OPTION_ENUM(v.worn)},
        {0}};
    struct common common = common_default();
    struct option_row shared[COMMON_ROWS];
    const struct option_row *const groups[] = {rows, common_rows(&common, ~0u, shared), NULL};
    option_row(shared, "seed")->given = &seed_given;
    char *argv[] = {"probe-x",      "--depth=-7", "--rays=-9876543210",
                    "--shade=dark", "--worn",     "--seed=5",
                    "--threads=3",  "--binary",   NULL};
    struct program program = {.name = "probe-x", .usage = "", .summary = ""};
    struct error *err = options_parse(&program, groups, 8, argv);
    ok(!err && v.depth == -7 && v.before == -1 && v.after == -1 && v.rays == -9876543210,
       "an int and a wide integer arrive, and nothing beside them is written");
    ok(v.shade == SHADE_DARK && v.worn == SHADE_GREY, "names find their enumerator in any order");
    ok(common.seed == 5 && common.threads == 3 && common.encoding == STREAM_BINARY,
       "shared options arrive");
    ok(seed_given, "a shared row is found by its name and followed");
    ok(!option_row(shared, "see") && !option_row(shared, "seeds"), "a name is a whole name");
    ok(program.given_count == 7 && program.given[0].row == &rows[0] &&
           !strcmp(program.given[0].text, "-7") && program.given[3].row == &rows[3] &&
           !program.given[3].text,
       "what was given is kept, in order");
    program_clear(&program);
    ok(!program.given_count && !program.given, "and forgotten");
    argv[1] = "--depth=2147483648";
    err = options_parse(&program, groups, 2, argv);
    ok(err && !strcmp(error_message(err), "--depth: the number 2147483648 is too large") &&
           v.depth == -7,
       "what does not fit an int is refused");
    error_destroy(err);
    program_clear(&program);
}

/* However many rows a table has, none is passed over. */
static void test_many_options(void)
{
    enum { MANY = 1000 };
    static struct option_row rows[MANY + 1];
    static char name[MANY][24];
    static int value[MANY];
    for (int i = 0; i < MANY; i++) {
        snprintf(name[i], sizeof name[i], "value-%04d", i);
        rows[i] = (struct option_row){
            .name = name[i], .argument = "N", .help = "", .kind = OPTION_INT, .value = &value[i]};
    }
    rows[MANY - 1].letter = 'z';
    const struct option_row *const groups[] = {rows, NULL};
    struct program program = {.name = "probe-x", .usage = "", .summary = ""};
    char *argv[] = {"probe-x", "--value-0000=1", "--value-0998=2", "-z", "3", NULL};
    struct error *err = options_parse(&program, groups, 5, argv);
    ok(!err && value[0] == 1 && value[MANY - 2] == 2 && value[MANY - 1] == 3,
       "the last of a thousand options is taken");
    error_destroy(err);
    program_clear(&program);
}

static void test_options(void)
{
    parse("", "probe-x");
    parse("-s|2|--rays=7|--light|direct|file", "probe-x --spacing 2 --rays 7 --light direct");
    /* what cannot change the light */
    parse("--threads|3|--quiet|--progress|-o|x|--text|--binary", "probe-x");
    parse("--seed|3|--flag", "probe-x --seed 3 --flag");
    parse("--name|it's a name", "probe-x --name 'it'\\''s a name'");
    parse("--spacing|0", "--spacing: expected a number greater than 0, got 0");
    parse("--spacing|nan", "--spacing: expected a finite number, got 'nan'");
    parse("--spacing|1x", "--spacing: expected a number, got '1x'");
    parse("--spacing|1e999", "--spacing: expected a finite number, got '1e999'");
    parse("--spacing", "--spacing: expected an argument S");
    parse("--rays|0", "--rays: expected a number at least 1 and at most 100, got 0");
    parse("--rays|1.5", "--rays: expected a whole number, got '1.5'");
    parse("--rays|99999999999999999999", "--rays: the number 99999999999999999999 is too large");
    parse("--vector|1,2", "--vector: expected 3 finite numbers separated by commas, got '1,2'");
    parse("--vector|1,2,3,4",
          "--vector: expected 3 finite numbers separated by commas, got '1,2,3,4'");
    parse("--light|sun", "--light: expected one of all, direct, got 'sun'");
    parse("--flag=1", "--flag takes no argument");
    parse("--nothing", "unknown or ambiguous option '--nothing'");
    parse("-Z", "unknown option '-Z'");
    parse("a|b", "unexpected operand 'b'");
    parse("--|--flag", "probe-x");
}

/* What options_parse begins. A second name keeps what the first one stood for, as the inode of a
 * replaced file may come back in another. */
static void test_claims(void)
{
    struct file_output out;
    char *data = NULL;
    size_t size;
    files_begin();
    files_write("kept", "old");
    const char *kept = files_path("kept");
    const bool linked = !link(kept, files_path("old"));
    claim_begin();
    struct error *err = claim_output(kept, "output");
    ok(linked && !err, "an output is claimed");
    err = file_read(kept, &data, &size);
    ok(error_status(err) == EXIT_BAD_USAGE &&
           fails_with(err, "it is read, and --output would overwrite it"),
       "and not read");
    err = file_output_open(&out, kept, false);
    if (!err)
        err = file_output_finish(&out);
    ok(!err, "but written");
    err = file_read(files_path("old"), &data, &size);
    ok(!err && size == 3, "what it replaced may be read from then on");
    error_destroy(err);
    free(data);
    files_end();
}

int main(void)
{
    test_error();
    test_array();
    test_file();
    test_threads();
    test_once();
    test_warnings();
    test_options();
    test_option_values();
    test_many_options();
    test_claims();
    return tap_done();
}
