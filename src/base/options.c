/* SPDX-License-Identifier: Apache-2.0 */
#include "base/options.h"
#include "base/array.h"
#include "base/claim.h"
#include "base/error.h"
#include "config.h"

#include <ctype.h>
#include <errno.h>
#include <getopt.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What getopt_long returns, beyond letters: LETTERLESS + i for the i-th row. */
enum { ID_HELP = 256, ID_VERSION, LETTERLESS };

struct option_row *option_row(struct option_row *rows, const char *name)
{
    while (rows->name && strcmp(rows->name, name))
        rows++;
    return rows->name ? rows : NULL;
}

/* -- numbers --------------------------------------------------------------------------------- */

/* One number at the start of `text`; *end is what follows it. */
static struct error *real_prefix(const char *what, const char *text, const char **end,
                                 double *value)
{
    char *stop;
    const double x = strtod(text, &stop);
    if (stop == text || isspace((unsigned char)*text))
        return error_usage("%s: expected a number, got '%s'", what, text);
    if (!isfinite(x))
        return error_usage("%s: expected a finite number, got '%s'", what, text);
    *end = stop;
    *value = x;
    return NULL;
}

struct error *options_real(const char *what, const char *text, double *value)
{
    const char *end = text;
    struct error *err = real_prefix(what, text, &end, value);
    if (!err && *end)
        err = error_usage("%s: expected a number, got '%s'", what, text);
    return err;
}

struct error *options_share(void *value, const char *text)
{
    char number[64];
    double *share = value;
    const size_t length = strlen(text);
    const bool percent = length && text[length - 1] == '%', fits = length < sizeof number;
    snprintf(number, sizeof number, "%.*s", fits ? (int)(length - percent) : 0, text);
    struct error *err = options_real("share", number, share);
    *share /= percent ? 100 : 1;
    if (!err && *share >= 0 && *share <= 1)
        return NULL;
    error_destroy(err);
    return error_usage("expected a share from 0 to 1, or a percentage as in 10%%, got '%s'", text);
}

struct error *options_reals(const char *what, const char *text, int count, double *values)
{
    const char *at = text;
    for (int i = 0; i < count; i++) {
        const char *end = at;
        struct error *err = real_prefix(what, at, &end, &values[i]);
        /* too few, too many, or rubbish between */
        if (!err && *end != (i + 1 < count ? ',' : '\0'))
            err = error_usage("not a number list");
        if (err) {
            error_destroy(err);
            return count == 1
                       ? error_usage("%s: expected a finite number, got '%s'", what, text)
                       : error_usage("%s: expected %d finite numbers separated by commas, got "
                                     "'%s'",
                                     what, count, text);
        }
        at = end + 1;
    }
    return NULL;
}

static bool ranged(const struct option_row *row)
{
    return row->least < row->most || row->least > 0;
}

static struct error *check_range(const struct option_row *row, const char *what, double value)
{
    if (!ranged(row))
        return NULL;
    const bool low = row->least_open ? value <= row->least : value < row->least;
    if (!low && value <= row->most)
        return NULL;
    const char *relation = row->least_open ? "greater than" : "at least";
    if (isinf(row->most))
        return error_usage("%s: expected a number %s %.15g, got %.15g", what, relation, row->least,
                           value);
    if (isinf(row->least))
        return error_usage("%s: expected a number at most %.15g, got %.15g", what, row->most,
                           value);
    return error_usage("%s: expected a number %s %.15g and at most %.15g, got %.15g", what,
                       relation, row->least, row->most, value);
}

static struct error *parse_integer(const struct option_row *row, const char *what, const char *text)
{
    char *end;
    errno = 0;
    const long long value = strtoll(text, &end, 10);
    if (end == text || *end || isspace((unsigned char)*text))
        return error_usage("%s: expected a whole number, got '%s'", what, text);
    struct error *err = errno == ERANGE ? NULL : check_range(row, what, (double)value);
    const bool fits = row->kind == OPTION_INTEGER || (value >= INT_MIN && value <= INT_MAX);
    if (!err && (errno == ERANGE || !fits))
        err = error_usage("%s: the number %s is too large", what, text);
    if (!err && row->kind == OPTION_INT)
        *(int *)row->value = (int)value;
    else if (!err)
        *(int64_t *)row->value = value;
    return err;
}

static struct error *parse_choice(const struct option_row *row, const char *what, const char *text)
{
    char list[256] = "";
    for (int i = 0; row->choices[i]; i++) {
        if (!strcmp(row->choices[i], text)) {
            *(int *)row->value = i;
            return NULL;
        }
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", row->choices[i]);
    }
    return error_usage("%s: expected one of %s, got '%s'", what, list, text);
}

static struct error *parse_value(const struct option_row *row, const char *text)
{
    char what[64];
    snprintf(what, sizeof what, "--%s", row->name);
    struct error *err = NULL;
    switch (row->kind) {
    case OPTION_FLAG: *(bool *)row->value = true; break;
    case OPTION_SET: *(int *)row->value = row->count; break;
    case OPTION_INT:
    case OPTION_INTEGER: err = parse_integer(row, what, text); break;
    case OPTION_REAL: {
        double value = 0;
        err = options_real(what, text, &value);
        if (!err)
            err = check_range(row, what, value);
        if (!err)
            *(double *)row->value = value;
        break;
    }
    case OPTION_REALS: {
        double values[16];
        err = options_reals(what, text, row->count, values);
        for (int i = 0; i < row->count && !err; i++)
            err = check_range(row, what, values[i]);
        if (!err)
            memcpy(row->value, values, (size_t)row->count * sizeof *values);
        break;
    }
    case OPTION_TEXT: *(const char **)row->value = text; break;
    case OPTION_CHOICE: err = parse_choice(row, what, text); break;
    case OPTION_CALL:
        err = row->parse(row->value, text);
        if (err && error_status(err) == EXIT_BAD_USAGE && strncmp(error_message(err), "--", 2) != 0)
            err = error_wrap(err, "%s", what);
        break;
    }
    if (!err && row->given)
        *row->given = true;
    return err;
}

static bool takes_argument(const struct option_row *row)
{
    return row->kind != OPTION_FLAG && row->kind != OPTION_SET;
}

/* -- help ------------------------------------------------------------------------------------ */

/* The default as text; empty when there is none to speak of. */
static void show_default(const struct option_row *row, char *text, size_t size)
{
    *text = 0;
    if (row->shown) {
        snprintf(text, size, "%s", row->shown);
        return;
    }
    switch (row->kind) {
    case OPTION_INT: snprintf(text, size, "%d", *(const int *)row->value); break;
    case OPTION_INTEGER:
        snprintf(text, size, "%lld", (long long)*(const int64_t *)row->value);
        break;
    case OPTION_REAL:
        if (isfinite(*(const double *)row->value))
            snprintf(text, size, "%.15g", *(const double *)row->value);
        break;
    case OPTION_REALS:
        for (int i = 0; i < row->count; i++) {
            const double x = ((const double *)row->value)[i];
            if (!isfinite(x)) {
                *text = 0;
                break;
            }
            const size_t used = strlen(text);
            snprintf(text + used, size - used, "%s%.15g", i ? "," : "", x);
        }
        break;
    case OPTION_TEXT:
        if (*(const char *const *)row->value)
            snprintf(text, size, "%s", *(const char *const *)row->value);
        break;
    case OPTION_CHOICE:
        if (*(const int *)row->value >= 0)
            snprintf(text, size, "%s", row->choices[*(const int *)row->value]);
        break;
    case OPTION_FLAG:
    case OPTION_SET:
    case OPTION_CALL: break;
    }
}

enum { HELP_COLUMN = 28 };

static void print_row(const struct option_row *row)
{
    char head[128];
    if (row->letter)
        snprintf(head, sizeof head, "  -%c, --%s%s%s", row->letter, row->name,
                 row->argument ? " " : "", row->argument ? row->argument : "");
    else
        snprintf(head, sizeof head, "      --%s%s%s", row->name, row->argument ? " " : "",
                 row->argument ? row->argument : "");
    printf("%-*s", HELP_COLUMN - 1, head);
    if (strlen(head) >= HELP_COLUMN - 1)
        printf("\n%-*s", HELP_COLUMN - 1, "");
    putchar(' ');
    for (const char *c = row->help; *c; c++) {
        putchar(*c);
        if (*c == '\n')
            printf("%-*s", HELP_COLUMN, "");
    }
    char text[256];
    show_default(row, text, sizeof text);
    if (*text)
        printf(" (default: %s)", text);
    putchar('\n');
}

static void print_help(const struct program *program, const struct option_row *const groups[])
{
    printf("Usage: %s %s\n%s\n\nOptions:\n", program->name, program->usage, program->summary);
    for (; *groups; groups++)
        for (const struct option_row *row = *groups; row->name; row++)
            print_row(row);
    printf("  -h, --help                show this help and exit\n"
           "      --version             show the version and exit\n");
    if (program->notes)
        printf("\n%s\n", program->notes);
}

/* Leaves the program after --help or --version. */
static _Noreturn void leave(const struct program *program)
{
    struct error *err = NULL;
    if (fflush(stdout) || ferror(stdout))
        err = error_system(errno, "stdout");
    exit(error_exit(program->name, err));
}

/* -- provenance ------------------------------------------------------------------------------ */

static bool plain(const char *word)
{
    if (!*word)
        return false;
    for (const char *c = word; *c; c++)
        if (!isalnum((unsigned char)*c) && !strchr("+-_./,:=@%^", *c))
            return false;
    return true;
}

/* Appends one word, quoted for a shell where needed. */
static struct error *record(struct program *program, const char *word)
{
    const size_t used = program->recorded ? strlen(program->recorded) : 0;
    char *grown = realloc(program->recorded, used + 4 * strlen(word) + 4);
    if (!grown)
        return error_memory();
    program->recorded = grown;
    char *to = grown + used;
    if (used)
        *to++ = ' ';
    if (plain(word)) {
        strcpy(to, word);
        return NULL;
    }
    *to++ = '\'';
    for (const char *c = word; *c; c++) {
        if (*c == '\'') {
            memcpy(to, "'\\''", 4);
            to += 4;
        } else {
            *to++ = *c;
        }
    }
    *to++ = '\'';
    *to = 0;
    return NULL;
}

struct error *options_record(struct program *program, const char *operand)
{
    return record(program, operand);
}

static struct error *record_option(struct program *program, const struct option_row *row,
                                   const char *text)
{
    if (row->unrecorded)
        return NULL;
    char name[64];
    snprintf(name, sizeof name, "--%s", row->name);
    struct error *err = record(program, name);
    if (!err && takes_argument(row))
        err = record(program, text);
    return err;
}

static struct error *keep_given(struct program *program, const struct option_row *row,
                                const char *text)
{
    struct error *err = array_reserve(&program->given, &program->given_capacity,
                                      program->given_count + 1, sizeof *program->given);
    if (!err)
        program->given[program->given_count++] = (struct option_given){row, text};
    return err;
}

/* -- parsing --------------------------------------------------------------------------------- */

/* The table in the form of getopt_long; its arrays are owned. */
struct getopt_table {
    const struct option_row **rows;
    struct option *longs;
    char *letters;
    int count;
};

static void getopt_table_clear(struct getopt_table *table)
{
    free(table->rows);
    free(table->longs);
    free(table->letters);
}

static size_t count_rows(const struct option_row *const groups[])
{
    size_t count = 0;
    for (; *groups; groups++)
        for (const struct option_row *row = *groups; row->name; row++)
            count++;
    return count;
}

static struct error *getopt_table_init(struct getopt_table *table,
                                       const struct option_row *const groups[])
{
    const size_t rows = count_rows(groups);
    struct error *err = array_create(&table->rows, rows, sizeof *table->rows);
    if (!err) /* and help, version, the end */
        err = array_create(&table->longs, rows + 3, sizeof *table->longs);
    if (!err) /* a letter and a colon each, and ":h" */
        err = array_create(&table->letters, 2 * rows + 3, 1);
    if (err)
        return err;
    char *letter = table->letters;
    *letter++ = ':'; /* a missing argument is told apart from an unknown option */
    *letter++ = 'h';
    for (; *groups; groups++) {
        for (const struct option_row *row = *groups; row->name; row++) {
            const int id = table->count++;
            table->rows[id] = row;
            table->longs[id] =
                (struct option){.name = row->name,
                                .has_arg = takes_argument(row) ? required_argument : no_argument,
                                .val = row->letter ? row->letter : LETTERLESS + id};
            if (row->letter) {
                *letter++ = row->letter;
                if (takes_argument(row))
                    *letter++ = ':';
            }
        }
    }
    *letter = 0;
    table->longs[table->count] = (struct option){.name = "help", .val = ID_HELP};
    table->longs[table->count + 1] = (struct option){.name = "version", .val = ID_VERSION};
    return NULL;
}

static const struct option_row *row_of(const struct getopt_table *table, int id)
{
    for (int i = 0; i < table->count; i++)
        if (table->longs[i].val == id)
            return table->rows[i];
    return NULL;
}

static struct error *bad_option(const struct getopt_table *table, char **argv, int result)
{
    const struct option_row *row = row_of(table, optopt);
    const char *word = argv[optind - 1];
    if (result == ':' && row)
        return error_usage("--%s: expected an argument %s", row->name, row->argument);
    if (row)
        return error_usage("--%s takes no argument", row->name);
    if (optopt && !strncmp(word, "--", 2)) /* --help=x */
        return error_usage("%s takes no argument", word);
    if (optopt)
        return error_usage("unknown option '-%c'", optopt);
    return error_usage("unknown or ambiguous option '%s'", word);
}

/* Before anything is opened. */
static struct error *claim_written(const struct option_row *const groups[])
{
    struct error *err = NULL;
    claim_begin();
    for (; *groups; groups++)
        for (const struct option_row *row = *groups; row->name && !err; row++) {
            const char *const *path = row->value;
            if (row->written && *path)
                err = claim_output(*path, row->name);
        }
    return err;
}

struct error *options_parse(struct program *program, const struct option_row *const groups[],
                            int argc, char **argv)
{
    struct getopt_table table = {0};
    struct error *err = getopt_table_init(&table, groups);
    if (!err)
        err = record(program, program->name);
    opterr = 0;
    optind = 0; /* glibc: start anew */
    while (!err) {
        const int id = getopt_long(argc, argv, table.letters, table.longs, NULL);
        if (id == -1)
            break;
        if (id == 'h' || id == ID_HELP) {
            print_help(program, groups);
            leave(program);
        }
        if (id == ID_VERSION) {
            printf("%s (%s) %s\n", program->name, PACKAGE_NAME, PACKAGE_VERSION);
            leave(program);
        }
        const struct option_row *row = id == '?' || id == ':' ? NULL : row_of(&table, id);
        err = row ? parse_value(row, optarg) : bad_option(&table, argv, id);
        if (!err)
            err = record_option(program, row, optarg);
        if (!err)
            err = keep_given(program, row, optarg);
    }
    getopt_table_clear(&table);
    if (err)
        return err;
    program->operands = (const char **)(argv + optind);
    program->operand_count = argc - optind;
    if (program->operand_count < program->operands_least)
        return error_usage("expected %s, got %d operand%s", program->usage, program->operand_count,
                           program->operand_count == 1 ? "" : "s");
    if (program->operands_most >= 0 && program->operand_count > program->operands_most)
        return error_usage("unexpected operand '%s'", program->operands[program->operands_most]);
    return claim_written(groups);
}

void program_clear(struct program *program)
{
    free(program->recorded);
    free(program->given);
    program->recorded = NULL;
    program->given = NULL;
    program->given_count = program->given_capacity = 0;
}
