/* SPDX-License-Identifier: Apache-2.0 */
/* error: errors are values that gain context on the way up.
 *
 * A function that can fail returns a `struct error *`: NULL is success. The lowest layer
 * says what it saw ("expected 3 coordinates, got 2"), each layer above adds where with
 * error_wrap ("stdin:12"), and main ends with error_exit, which prints
 *
 *     probe-tet: stdin:12: expected 3 coordinates, got 2
 *
 * and gives the exit status. Nothing below main prints or exits.
 *
 * The check idiom, everywhere:
 *
 *     struct error *err = first_step(&a);
 *     if (!err) err = second_step(a, &b);
 *     a_destroy(a);
 *     return err;
 *
 * Ownership: whoever receives an error frees it, by error_destroy, by error_exit, or by
 * handing it on. No function here can itself fail: when memory is short the message is lost
 * and a static out-of-memory error takes its place.
 */
#ifndef ERROR_H
#define ERROR_H

#include <stdbool.h>

struct error;

/* Exit statuses of every program (man probe-tools(7)). */
enum { EXIT_DONE = 0, EXIT_BAD_DATA = 1, EXIT_BAD_USAGE = 2, EXIT_ABOVE = 3 };

/* A new error whose message is printf-formatted; its exit status is EXIT_BAD_DATA. */
struct error *error_new(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* As error_new, for a wrong command line: exit status EXIT_BAD_USAGE. */
struct error *error_usage(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* As error_new, for work that is done and whole, but above a limit that the command line set: exit
 * status EXIT_ABOVE. */
struct error *error_above(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* As error_new, with ": " and strerror(number) behind the message. A broken pipe (EPIPE)
 * gives an error that error_exit does not print: a closed pipe is no news. */
struct error *error_system(int number, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The error for memory that could not be had. Static: destroying it is legal and does nothing. */
struct error *error_memory(void);

/* Where `err` is that, an error that says what was asked for as well; others stay as they are. */
struct error *error_memory_for(struct error *err, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Puts a printf-formatted context and ": " before the message of `err`; takes `err` and
 * returns it changed. NULL stays NULL, so a whole call can be wrapped unconditionally. */
struct error *error_wrap(struct error *err, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The message, without a program's name; owned by `err`. */
const char *error_message(const struct error *err);

/* Whether `err` is of data, which may be done without: neither short memory nor wrong use. */
bool error_is_of_data(const struct error *err);

/* The exit status that `err` asks for; EXIT_DONE for NULL. */
int error_status(const struct error *err);

void error_destroy(struct error *err);

/* Prints "program: message" to standard error (a usage error also points at --help), frees
 * `err`, and returns the exit status for main. NULL prints nothing and gives EXIT_DONE. */
int error_exit(const char *program, struct error *err);

#endif
