/* SPDX-License-Identifier: Apache-2.0 */
/* options: a command line described by one table.
 *
 * A program lists its options once, in rows of name, letter, argument, help and where the value
 * goes. The table parses, checks ranges and trailing rubbish, prints --help with each default
 * (the value that stands in the variable before parsing), and writes the command line that
 * goes into the stream's provenance. --help and --version leave from here.
 *
 *     double spacing = 1;
 *     const struct option_row rows[] = {
 *         {.name = "spacing",
 *          .letter = 's',
 *          .argument = "LENGTH",
 *          .help = "distance between probes",
 *          .kind = OPTION_REAL,
 *          .value = &spacing,
 *          .least_open = true,
 *          .most = INFINITY},
 *         {0}};
 *     struct option_row shared[COMMON_ROWS];    (stream/common_options.h)
 *     const struct option_row *const groups[] = {
 *         rows, common_rows(&common, COMMON_STREAM, shared), NULL};
 *     struct program program = {.name = "probe-place", .usage = "grid [OPTION]... SCENE", ...};
 *     err = options_parse(&program, groups, argc, argv);
 *     ... program.operands, program.recorded ...
 *     program_clear(&program);
 */
#ifndef OPTIONS_H
#define OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

enum option_kind {
    OPTION_FLAG,    /* bool: present or not, no argument */
    OPTION_INT,     /* int, within least..most */
    OPTION_INTEGER, /* int64_t, within least..most */
    OPTION_REAL,    /* double, finite, within least..most */
    OPTION_REALS,   /* double[count]: comma-separated, each finite and within least..most */
    OPTION_TEXT,    /* const char *: as it stands; points into argv */
    OPTION_CHOICE,  /* OPTION_ENUM: index into choices */
    OPTION_SET,     /* OPTION_ENUM: set to `count` when the option is present, no argument */
    OPTION_CALL,    /* whatever parse makes of it; may repeat */
};

/* The value of OPTION_CHOICE and OPTION_SET: the address of an enum (or int). It is written as an
 * int, as C allows where the enum is compatible with int or unsigned; no other compiles. */
#define OPTION_ENUM(object) (_Generic(&(object), int * : &(object), unsigned * : &(object)))

struct option_row {
    const char *name;     /* without the dashes; NULL ends the table */
    char letter;          /* 0: none */
    const char *argument; /* its name in --help; NULL for a flag */
    const char *help;     /* one line, or several separated by \n */
    enum option_kind kind;
    void *value;
    double least, most;         /* the range, ends included; both 0: no limit */
    bool least_open;            /* least itself is not allowed */
    int count;                  /* REALS: how many; SET: the value */
    const char *const *choices; /* CHOICE: [ENUMERATOR] = "name", ..., NULL at the end */
    struct error *(*parse)(void *value, const char *text);
    const char *shown; /* the default as --help shows it; NULL: made from *value */
    bool *given;       /* set to true when the option is present; may be NULL */
    bool written;      /* TEXT: a file that the program writes, which nothing it reads may be */
    bool unrecorded;   /* cannot change the output's rows, so stays out of the provenance */
};

/* The row of that name; NULL: it is not among `rows`. For a program that words or follows a shared
 * option in a way of its own: option_row(shared, "seed")->given = &seed_given. */
struct option_row *option_row(struct option_row *rows, const char *name);

/* An option as it was given: its row, and its argument in argv, or NULL. */
struct option_given {
    const struct option_row *row;
    const char *text;
};

struct program {
    const char *name;    /* "probe-tet" */
    const char *usage;   /* what follows the name: "[OPTION]... [STREAM]" */
    const char *summary; /* one or a few sentences under the usage */
    int operands_least, operands_most;
    const char *notes; /* printed below the options: examples, files; may be NULL */

    /* Filled by options_parse: */
    const char **operands; /* point into argv */
    int operand_count;
    /* the command line for the provenance: options that matter, in order, quoted for a shell where
     * needed; no operands: options_record adds those that matter */
    char *recorded;
    struct option_given *given; /* all, in order, for who hands them on; owned */
    size_t given_count, given_capacity;
};

/* Parses argv by the tables in groups, NULL after the last, in whose order --help prints them; they
 * are not needed afterwards. On --help or --version prints to standard output and exits (0, or 1
 * when standard output cannot be written). A wrong command line is an error with exit status 2 that
 * names the option, what was expected and what came. Files of `written` options are claimed
 * (claim.h), and whatever else is opened from here on. */
struct error *options_parse(struct program *program, const struct option_row *const groups[],
                            int argc, char **argv);

/* Adds an operand (a scene's name, a method) to program->recorded, quoted where needed. */
struct error *options_record(struct program *program, const char *operand);

void program_clear(struct program *program);

/* A number from the whole of `text`, finite; `what` names it in the error ("--spacing"). */
struct error *options_real(const char *what, const char *text, double *value);

/* A share from 0 to 1, "0.1" or "10%", into a double: the `parse` of an OPTION_CALL. */
struct error *options_share(void *value, const char *text);

/* `count` comma-separated numbers from the whole of `text`. */
struct error *options_reals(const char *what, const char *text, int count, double *values);

#endif
