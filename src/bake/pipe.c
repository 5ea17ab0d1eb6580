/* SPDX-License-Identifier: Apache-2.0 */
#include "bake/pipe.h"
#include "base/array.h"
#include "base/error.h"
#include "base/options.h"
#include "base/sibling.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

extern char **environ;

/* -- signals ---------------------------------------------------------------------------------- */

static const int ending[] = {SIGHUP, SIGINT, SIGTERM};
enum { ENDING = sizeof ending / sizeof *ending };

static volatile sig_atomic_t came;   /* the signal; 0: none */
static volatile sig_atomic_t over;   /* it ends all */
static volatile sig_atomic_t group;  /* the children's process group; 0: there are none */
static volatile sig_atomic_t keeper; /* the child that keeps what it has; 0: there is none */
static const char *said_of_keeping;

static void kill_group(int number)
{
    if (group)
        kill(-group, number);
}

/* timeout(1) sends its signal twice, to us and to our group: what comes so fast is one. */
static bool is_echo(int number)
{
    enum { ECHO_MS = 250 };
    static volatile long long last; /* milliseconds */
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    const long long now = 1000LL * t.tv_sec + t.tv_nsec / 1000000;
    const bool echo = came == number && now - last < ECHO_MS;
    last = now;
    return echo;
}

static void take_end(int number)
{
    const int saved = errno;
    const bool echo = is_echo(number), first = !came;
    if (echo)
        return;
    came = number;
    if (keeper && first && number != SIGHUP) {
        kill(keeper, number);
        if (said_of_keeping && write(STDERR_FILENO, said_of_keeping, strlen(said_of_keeping)) < 0)
            said_of_keeping = NULL; /* nobody listens */
    } else {
        over = 1;
        kill_group(SIGKILL);
    }
    errno = saved;
}

static void take_stop(int number)
{
    const int saved = errno;
    (void)number;
    kill_group(SIGSTOP);
    raise(SIGSTOP); /* and goes on from here */
    kill_group(SIGCONT);
    errno = saved;
}

static void catch_one(int number, void (*handler)(int))
{
    struct sigaction action = {.sa_handler = handler, .sa_flags = SA_RESTART}, before;
    sigemptyset(&action.sa_mask);
    if (!sigaction(number, NULL, &before) && before.sa_handler != SIG_IGN) /* nohup */
        sigaction(number, &action, NULL);
}

void pipe_catch(const char *said)
{
    said_of_keeping = said;
    for (int i = 0; i < ENDING; i++)
        catch_one(ending[i], take_end);
    catch_one(SIGTSTP, take_stop);
    signal(SIGCHLD, SIG_DFL); /* ignored, which may be inherited, it hides who failed */
    signal(SIGTTOU, SIG_IGN); /* the children's group may write to the terminal */
    signal(SIGPIPE, SIG_IGN); /* who writes hears of it, and can clean up */
}

bool pipe_interrupted(void)
{
    return over;
}

bool pipe_cut_short(void)
{
    return came && !over;
}

void pipe_pass_on(void)
{
    if (!came)
        return;
    signal(came, SIG_DFL);
    raise(came);
}

/* -- a stage ---------------------------------------------------------------------------------- */

struct running {
    pid_t pid; /* 0: it does not run */
    int to;    /* our copy of what it writes to: it ends for the reader when we say so; -1: none */
};

/* A descriptor above the standard ones, in place of `fd`; -1 with errno. */
static int above_standard(int fd)
{
    if (fd < 0 || fd > STDERR_FILENO)
        return fd;
    const int above = fcntl(fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1), number = errno;
    close(fd);
    errno = number;
    return above;
}

static void close_one(int *fd)
{
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
}

static struct error *make_pipe(int *from, int *to)
{
    int ends[2];
    if (pipe2(ends, O_CLOEXEC))
        return error_system(errno, "pipe");
    *from = above_standard(ends[0]);
    *to = above_standard(ends[1]);
    return *from < 0 || *to < 0 ? error_system(errno, "pipe") : NULL;
}

/* Signals are held back by the caller, so that none comes between a child and its group. */
static struct error *start(struct pipe_stage *stage, int from, int to, pid_t *pid)
{
    char path[PATH_MAX];
    char **argv = NULL;
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t none, usual;
    sigemptyset(&none);
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    sibling_find(stage->name, path);
    struct error *err = array_create(&argv, stage->words.count + 2, sizeof *argv);
    if (err)
        return err;
    argv[0] = path;
    for (size_t i = 0; i < stage->words.count; i++)
        argv[1 + i] = stage->words.list[i];
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, from, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, to, STDOUT_FILENO);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK |
                                              POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setpgroup(&attributes, group);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    const int number = posix_spawnp(pid, path, &files, &attributes, argv, environ);
    if (number)
        err = error_system(number, "%s", path);
    else if (!group)
        group = *pid;
    if (!number && stage->keeps)
        keeper = *pid;
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    free(argv);
    return err;
}

static struct error *start_all(struct pipe_stage *stages, size_t count, const char *output,
                               struct running *running)
{
    int from = above_standard(open("/dev/null", O_RDONLY | O_CLOEXEC));
    struct error *err = from < 0 ? error_system(errno, "/dev/null") : NULL;
    sigset_t held, before;
    sigfillset(&held);
    sigprocmask(SIG_BLOCK, &held, &before);
    for (size_t i = 0; i < count && !err; i++) {
        int next = -1;
        if (i + 1 < count) {
            err = make_pipe(&next, &running[i].to);
        } else {
            running[i].to =
                above_standard(open(output, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
            err = running[i].to < 0 ? error_system(errno, "%s", output) : NULL;
        }
        if (!err)
            err = start(&stages[i], from, running[i].to, &running[i].pid);
        close_one(&from);
        from = next;
    }
    close_one(&from);
    sigprocmask(SIG_SETMASK, &before, NULL);
    return err;
}

static double seconds_of(const struct rusage *usage)
{
    return (double)(usage->ru_utime.tv_sec + usage->ru_stime.tv_sec) +
           1e-6 * (double)(usage->ru_utime.tv_usec + usage->ru_stime.tv_usec);
}

/* The program's own message, if it had one, stands above ours. */
static struct error *failure(const char *name, int status)
{
    if (WIFSIGNALED(status))
        return error_new("probe-%s died: %s", name, strsignal(WTERMSIG(status)));
    return error_new("probe-%s failed with status %d", name, WEXITSTATUS(status));
}

/* Whether nothing has the other end of a pipe any more; of a file: no. */
static bool is_unread(int to)
{
    struct pollfd end = {.fd = to};
    return poll(&end, 1, 0) == 1 && end.revents & POLLERR;
}

/* Waits for all, and kills those that are left where one fails. */
static struct error *wait_for_all(struct pipe_stage *stages, size_t count, struct running *running,
                                  struct error *err)
{
    size_t left = 0;
    const char *unread = NULL;
    for (size_t i = 0; i < count; i++)
        left += running[i].pid > 0;
    if (err)
        kill_group(SIGKILL);
    while (left) {
        int status;
        struct rusage usage;
        const pid_t pid = wait4(-1, &status, 0, &usage);
        if (pid < 0 && errno == EINTR)
            continue;
        if (pid < 0)
            return err ? err : error_system(errno, "wait");
        for (size_t i = 0; i < count; i++) {
            if (running[i].pid != pid)
                continue;
            left--;
            if (stages[i].keeps)
                keeper = 0;
            stages[i].seconds = seconds_of(&usage);
            const bool kept = stages[i].keeps && came && WIFEXITED(status) &&
                              WEXITSTATUS(status) == 1;
            if (!status || kept) {
                close_one(&running[i].to);
            } else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGPIPE &&
                       is_unread(running[i].to)) {
                unread = stages[i].name; /* who did not read it failed, and says why */
            } else if (!err) {
                err = failure(stages[i].name, status);
                kill_group(SIGKILL);
            }
        }
    }
    return err || !unread ? err : error_new("probe-%s died: nobody read what it wrote", unread);
}

struct error *pipe_run(struct pipe_stage *stages, size_t count, const char *output)
{
    struct running *running = NULL;
    struct error *err = array_create(&running, count, sizeof *running);
    if (err)
        return err;
    for (size_t i = 0; i < count; i++)
        running[i] = (struct running){.to = -1};
    if (!over)
        err = start_all(stages, count, output, running);
    if (over) /* while they were started */
        kill_group(SIGKILL);
    err = wait_for_all(stages, count, running, err);
    group = keeper = 0;
    for (size_t i = 0; i < count; i++)
        close_one(&running[i].to);
    free(running);
    if (!over)
        return err;
    error_destroy(err);
    return error_new("interrupted");
}

struct error *pipe_stage_line(struct pipe_stage *stage, char **line)
{
    char path[PATH_MAX];
    struct program program = {0};
    sibling_find(stage->name, path);
    const char *slash = strrchr(path, '/');
    char *words = NULL;
    *line = NULL;
    struct error *err = options_record(&program, slash ? slash + 1 : path);
    if (!err && stage->words.count)
        err = words_line(&stage->words, &words);
    if (!err &&
        asprintf(line, "%s%s%s", program.recorded, words ? " " : "", words ? words : "") < 0)
        err = error_memory();
    free(words);
    program_clear(&program);
    return err;
}

void pipe_clear(struct pipe_stage *stages, size_t count)
{
    for (size_t i = 0; i < count; i++)
        words_clear(&stages[i].words);
}
