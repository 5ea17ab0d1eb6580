/* SPDX-License-Identifier: Apache-2.0 */
/* pipe: programs of ours that run side by side, each reading what the one before it writes.
 *
 * A pipe is whole or it is nothing: where a program fails or dies, all others are killed before
 * they see their input end, so none takes a part for the whole or complains about it. They are a
 * process group of their own, with all that they start. A signal (SIGHUP, SIGINT, SIGTERM) that is
 * caught kills them all; SIGTSTP stops them and SIGCONT lets them go on. But while a stage runs
 * that keeps what it has, the first SIGINT or SIGTERM is for it alone, and the others go on with
 * what it writes then.
 *
 *     pipe_catch(NULL);
 *     err = pipe_run(stages, count, "folder/out");
 *     ... clean up ...
 *     pipe_pass_on();      a signal that came ends this program too, now that all is clean
 */
#ifndef PIPE_H
#define PIPE_H

#include "bake/words.h"

#include <stdbool.h>
#include <stddef.h>

struct pipe_stage {
    const char *name;   /* "capture": of probe-capture */
    struct words words; /* behind the program's name */
    bool keeps;         /* a signal ends it with status 1, and its output is whole */
    double seconds;     /* out: of all cores, with what it started */
};

/* Signals are caught from now on. said: goes to standard error where a stage keeps what it has;
 * NULL: nothing does. */
void pipe_catch(const char *said);

/* Runs the stages and waits for their end. The first reads nothing, the last writes the file
 * `output`, which is made or emptied. Errors: which program is not to be found, failed or died; a
 * signal came that ends all. */
struct error *pipe_run(struct pipe_stage *stages, size_t count, const char *output);

/* Whether a signal came that ends all. */
bool pipe_interrupted(void);

/* Whether a signal came, and what a stage had by then was kept, if it does not end all as well. */
bool pipe_cut_short(void);

/* Ends the program by the signal that came, if one did, whatever was kept. */
void pipe_pass_on(void);

/* "probe-capture --rays 512 scene.obj", with the program's name as it is installed; the caller
 * frees *line. */
struct error *pipe_stage_line(struct pipe_stage *stage, char **line);

void pipe_clear(struct pipe_stage *stages, size_t count);

#endif
