/* SPDX-License-Identifier: Apache-2.0 */
/* Based on: Amenta, Choi and Rote, "Incremental constructions con BRIO", SoCG 2003: the order in
 * which points are inserted. */
#include "base/array.h"
#include "base/error.h"
#include "tetra/tetra.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/* -- the order of insertion ------------------------------------------------------------------- */

enum { ROUNDS = 8, ROUND_BITS = 3 };

/* A point's round: 7 of 8 points are in the last, 7 of 8 of the others in the one before, and so
 * on, by a hash of its number. */
static int round_of(size_t i)
{
    uint64_t h = i * 0x9e3779b97f4a7c15u + 0x2545f4914f6cdd1du;
    h = (h ^ h >> 30) * 0xbf58476d1ce4e5b9u;
    h = (h ^ h >> 27) * 0x94d049bb133111ebu;
    int round = ROUNDS - 1;
    for (h ^= h >> 31; round && !(h & ((1 << ROUND_BITS) - 1)); h >>= ROUND_BITS)
        round--;
    return round;
}

/* The first four, then round by round in canonical order, in which each point is near the last. */
static struct error *make_order(size_t count, const size_t first[4], int32_t **order)
{
    struct error *err = array_create(order, count, sizeof **order);
    size_t start[ROUNDS + 1] = {4};
    for (size_t i = 0; i < count && !err; i++)
        start[round_of(i) + 1]++;
    for (size_t k = 0; k < 4 && !err; k++) {
        start[round_of(first[k]) + 1]--;
        (*order)[k] = (int32_t)first[k];
    }
    for (int round = 0; round < ROUNDS; round++)
        start[round + 1] += start[round];
    for (size_t i = 0; i < count && !err; i++)
        if (i != first[0] && i != first[1] && i != first[2] && i != first[3])
            (*order)[start[round_of(i)]++] = (int32_t)i;
    return err;
}

/* -- room for the result ---------------------------------------------------------------------- */

static size_t room_bytes(size_t cells)
{
    return 8 * cells * sizeof(int32_t);
}

static int32_t *map(int file, size_t bytes)
{
    void *room = mmap(NULL, bytes, PROT_READ | PROT_WRITE,
                      MAP_SHARED | MAP_POPULATE | (file < 0 ? MAP_ANONYMOUS : 0), file, 0);
    return room == MAP_FAILED ? NULL : room;
}

/* What TetGen is given. */
struct task {
    size_t count;
    const double *position; /* 3 * count */
    const int32_t *order;   /* which point is inserted when */
    int threads;
};

static long run(const struct task *task, const struct tetra_sink *sink)
{
    return tetra_tetgen(task->count, task->position, task->order, task->threads, sink);
}

/* -- a child ---------------------------------------------------------------------------------- */

/* What the child has: a file in memory, which outlives it, for cells, and a pipe to say that they
 * are whole. */
struct outlet {
    int file, whole;
};

/* Room of just the cells' size. */
static int32_t *make_room(void *context, size_t cells)
{
    const struct outlet *outlet = context;
    return cells && !ftruncate(outlet->file, (off_t)room_bytes(cells))
               ? map(outlet->file, room_bytes(cells))
               : NULL;
}

/* Says so; TetGen's memory goes with the process. */
static void say_whole(void *context)
{
    const struct outlet *outlet = context;
    _exit(write(outlet->whole, "", 1) == 1 ? 0 : 1);
}

/* What the child does: its streams go nowhere, its result into the file. Where standard descriptors
 * were closed, file and pipe may have their numbers. */
static _Noreturn void child(struct outlet outlet, const struct task *task)
{
    outlet.file = fcntl(outlet.file, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    outlet.whole = fcntl(outlet.whole, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    run(task, &(struct tetra_sink){make_room, say_whole, &outlet});
    _exit(1);
}

static void take_room(struct tetra *tetra, void *room, size_t cells)
{
    tetra->room = room;
    tetra->room_bytes = room_bytes(cells);
    tetra->cell_count = cells;
    tetra->vertex = room;
    tetra->neighbour = tetra->vertex + 4 * cells;
}

/* Waits for a child that never said that its cells are whole, and tells why. */
static struct error *explain_death(pid_t pid, size_t count)
{
    int status = 0;
    while (waitpid(pid, &status, 0) < 0)
        if (errno != EINTR)
            return error_system(errno, "waiting for TetGen");
    if (WIFSIGNALED(status))
        return error_new("TetGen died on %zu probes: %s", count, strsignal(WTERMSIG(status)));
    return error_new("TetGen failed on %zu probes", count);
}

static bool hears_whole(int whole)
{
    char byte;
    ssize_t got;
    do
        got = read(whole, &byte, 1);
    while (got < 0 && errno == EINTR);
    return got == 1;
}

static struct error *run_child(struct tetra *tetra, const struct task *task, int file, int whole[2])
{
    const pid_t pid = fork();
    if (pid == 0)
        child((struct outlet){file, whole[1]}, task);
    if (pid < 0)
        return error_system(errno, "starting TetGen");
    close(whole[1]); /* the child's end alone is left: its death ends the pipe */
    whole[1] = -1;
    /* While the child computes, the pages that its result is sure to fill are made; the file's size
     * is the child's to say, who may have said it already. */
    if (task->count >= 1000)
        (void)!fallocate(file, FALLOC_FL_KEEP_SIZE, 0, (off_t)room_bytes(5 * task->count));
    if (!hears_whole(whole[0]))
        return explain_death(pid, task->count);
    tetra->child = pid; /* the system frees what it held while we go on */
    const off_t bytes = lseek(file, 0, SEEK_END);
    void *room = bytes > 0 ? map(file, (size_t)bytes) : NULL;
    if (!room)
        return error_system(errno, "memory for the cells");
    take_room(tetra, room, (size_t)bytes / room_bytes(1));
    return NULL;
}

void tetra_await(struct tetra *tetra)
{
    while (tetra->child && waitpid(tetra->child, NULL, 0) < 0 && errno == EINTR)
        ;
    tetra->child = 0;
}

/* -- in this process -------------------------------------------------------------------------- */

static int32_t *own_room(void *context, size_t cells)
{
    struct tetra *tetra = context;
    int32_t *room = cells ? map(-1, room_bytes(cells)) : NULL;
    if (room)
        take_room(tetra, room, cells);
    return room;
}

static void stay(void *context)
{
    (void)context;
}

static struct error *run_with_file(struct tetra *tetra, const struct task *task)
{
    int whole[2];
    if (pipe2(whole, O_CLOEXEC))
        return error_system(errno, "a pipe from TetGen");
    const int file = memfd_create("tetra", MFD_CLOEXEC);
    struct error *err = file < 0 ? error_system(errno, "memory for the cells")
                                 : run_child(tetra, task, file, whole);
    for (int i = 0; i < 2; i++)
        if (whole[i] >= 0)
            close(whole[i]);
    if (file >= 0)
        close(file);
    return err;
}

struct error *tetra_run(struct tetra *tetra, size_t count, const double *position,
                        const size_t first[4], const struct tetra_settings *settings)
{
    int32_t *order = NULL;
    struct error *err = make_order(count, first, &order);
    const struct task task = {
        .count = count, .position = position, .order = order, .threads = settings->threads};
    if (!err && !settings->in_process)
        err = run_with_file(tetra, &task);
    else if (!err && run(&task, &(struct tetra_sink){own_room, stay, tetra}) < 0)
        err = error_new("TetGen failed on %zu probes", count);
    free(order);
    return err;
}
