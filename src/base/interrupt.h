/* SPDX-License-Identifier: Apache-2.0 */
/* interrupt: SIGINT and SIGTERM as a wish to end, for work that can be given back half done.
 *
 * The first signal only sets a flag, which long loops look at between two pieces of work; the
 * second ends the program at once, as it would have without this. A signal that is ignored (nohup,
 * a shell's background jobs) stays ignored. It is the one thing of the library that is global,
 * because signals are.
 */
#ifndef INTERRUPT_H
#define INTERRUPT_H

#include <stdbool.h>

struct error;

/* Signals set the flag from now on. */
void interrupt_catch(void);

/* Whether a signal has come. Any thread. */
bool interrupt_came(void);

/* An error that says so, for work of which nothing is left then; NULL: none has come. */
struct error *interrupt_error(void);

#endif
