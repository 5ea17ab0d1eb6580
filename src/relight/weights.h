/* SPDX-License-Identifier: Apache-2.0 */
/* weights: how bright each group of lights is to be, for one output or several.
 *
 * A weight is a number, or a number a channel, which multiplies the group's light. A table of them
 * is a text of lines whose cells are separated by tabs: the first line names the groups, each
 * other one is an output:
 *
 *     name     lamps       windows        --sky        --time
 *     evening  1           0.1,0.08,0.05  .3,.2,.1     18.5
 *     night    0.3         0
 *
 * The column `name` may be missing. Columns --sky, --sun, --point and --time hold what these
 * options would be given; an empty cell is the command line's. Lines that are empty or begin with #
 * are skipped.
 * Groups that are not named have weight 1. A negative weight takes light away.
 */
#ifndef WEIGHTS_H
#define WEIGHTS_H

#include <stddef.h>

struct error;

enum weights_option { WEIGHTS_SKY, WEIGHTS_SUN, WEIGHTS_POINT, WEIGHTS_TIME, WEIGHTS_OPTIONS };

struct weights {
    size_t groups;
    char *const *group; /* their names; borrowed */
    size_t rows, capacity;
    double *weight; /* rows * groups * 3, channel fastest; owned */
    char **name;    /* of rows; NULL: it has none; owned, as are they, and so: */
    char **option;  /* WEIGHTS_OPTIONS a row; NULL: it says nothing of it */
};

/* One row of ones. */
struct error *weights_init(struct weights *weights, size_t groups, char *const *group);
void weights_clear(struct weights *weights);

/* Takes rows from a table ("-": standard input) in place of those that are there. Errors name file
 * and line: a group that there is not (it lists what there is), a row of more or fewer cells, what
 * is no number, two rows of one name. Options are taken as they stand. */
struct error *weights_read(struct weights *weights, const char *path);

/* Whether an option's text sets a weight, NAME=w or NAME=R,G,B, and is not a file's name. */
int weights_is_setting(const char *text);

/* Sets it in all rows. Errors: as above, of a command line. */
struct error *weights_set(struct weights *weights, const char *text);

/* Keeps one row alone, by its name or, counted from 0, its number. */
struct error *weights_choose(struct weights *weights, const char *row);

/* What a row is called: its name, or its number. The caller frees it; NULL: no memory. */
char *weights_row_name(const struct weights *weights, size_t row);

#endif
