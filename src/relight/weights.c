/* SPDX-License-Identifier: Apache-2.0 */
#include "relight/weights.h"
#include "base/array.h"
#include "base/error.h"
#include "base/file.h"
#include "base/number.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CELLS_MOST = 8192, LISTED_BYTES = 400 };

static const char *const option_names[] = {[WEIGHTS_SKY] = "--sky",
                                           [WEIGHTS_SUN] = "--sun",
                                           [WEIGHTS_POINT] = "--point",
                                           [WEIGHTS_TIME] = "--time"};

static void forget_rows(struct weights *w)
{
    for (size_t r = 0; r < w->rows; r++)
        free(w->name[r]);
    for (size_t k = 0; k < w->rows * WEIGHTS_OPTIONS; k++)
        free(w->option[k]);
    w->rows = 0;
}

static struct error *add_row(struct weights *w)
{
    size_t capacity = w->capacity, room = w->capacity * w->groups * 3,
           options = w->capacity * WEIGHTS_OPTIONS;
    struct error *err = array_reserve(&w->name, &capacity, w->rows + 1, sizeof *w->name);
    if (!err)
        err = array_reserve(&w->weight, &room, capacity * w->groups * 3, sizeof *w->weight);
    if (!err)
        err = array_reserve(&w->option, &options, capacity * WEIGHTS_OPTIONS, sizeof *w->option);
    if (err)
        return err;
    w->capacity = capacity;
    w->name[w->rows] = NULL;
    for (size_t k = 0; k < WEIGHTS_OPTIONS; k++)
        w->option[w->rows * WEIGHTS_OPTIONS + k] = NULL;
    for (size_t i = 0; i < w->groups * 3; i++)
        w->weight[w->rows * w->groups * 3 + i] = 1;
    w->rows++;
    return NULL;
}

struct error *weights_init(struct weights *w, size_t groups, char *const *group)
{
    *w = (struct weights){.groups = groups, .group = group};
    return add_row(w);
}

void weights_clear(struct weights *w)
{
    forget_rows(w);
    free(w->name);
    free(w->option);
    free(w->weight);
    *w = (struct weights){0};
}

/* -- names and numbers ------------------------------------------------------------------------ */

static struct error *unknown(const struct weights *w, const char *name, size_t length)
{
    char list[LISTED_BYTES] = "";
    size_t used = 0;
    for (size_t g = 0; g < w->groups && used + 60 < sizeof list; g++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%.40s", g ? ", " : "",
                                 w->group[g]);
    if (!w->groups)
        return error_new("there is no group '%.*s': the stream has none (probe-capture --groups)",
                         (int)length, name);
    return error_new("there is no group '%.*s': expected one of %s%s", (int)length, name, list,
                     used + 60 < sizeof list ? "" : ", ...");
}

static struct error *find_group(const struct weights *w, const char *name, size_t length,
                                size_t *group)
{
    for (*group = 0; *group < w->groups; ++*group)
        if (strlen(w->group[*group]) == length && !memcmp(w->group[*group], name, length))
            return NULL;
    return unknown(w, name, length);
}

static const char *past_blanks(const char *at, const char *end)
{
    while (at < end && *at == ' ')
        at++;
    return at;
}

/* One number, or one a channel. */
static struct error *read_weight(const char *text, size_t length, double rgb[3])
{
    const char *end = text + length, *at = text;
    int count = 0;
    while (count < 3) {
        at = number_read_f64(past_blanks(at, end), end, &rgb[count]);
        if (!at || !isfinite(rgb[count]))
            break;
        count++;
        at = past_blanks(at, end);
        if (at == end || *at != ',')
            break;
        at++;
    }
    if (!at || at != end || count == 2 || count == 0 || !isfinite(rgb[count - 1]))
        return error_new("expected a finite number, or three as R,G,B, got '%.*s'", (int)length,
                         text);
    if (count == 1)
        rgb[1] = rgb[2] = rgb[0];
    return NULL;
}

/* -- settings --------------------------------------------------------------------------------- */

int weights_is_setting(const char *text)
{
    return strchr(text, '=') != NULL;
}

/* What is said of data, said of a command line. */
static struct error *as_usage(struct error *err)
{
    if (!err || err == error_memory())
        return err;
    struct error *usage = error_usage("--weights: %s", error_message(err));
    error_destroy(err);
    return usage;
}

struct error *weights_set(struct weights *w, const char *text)
{
    const char *equals = strchr(text, '=');
    size_t group = 0;
    double rgb[3];
    struct error *err = find_group(w, text, (size_t)(equals - text), &group);
    if (!err)
        err = read_weight(equals + 1, strlen(equals + 1), rgb);
    for (size_t r = 0; r < w->rows && !err; r++)
        memcpy(w->weight + 3 * (r * w->groups + group), rgb, sizeof rgb);
    return as_usage(err);
}

/* -- tables ----------------------------------------------------------------------------------- */

struct cell {
    const char *text;
    size_t length;
};

/* A column is a group's, the name's, or from here on that of an option. */
enum { NAME_COLUMN = -1, OPTION_COLUMN = -2 };

struct table_reader {
    struct weights *weights;
    struct cell *cell; /* of a line */
    long *column;      /* group, NAME_COLUMN or OPTION_COLUMN - option */
    size_t *line;      /* of the file, by row */
    size_t line_capacity;
    size_t columns; /* 0: the first line is still to come */
};

static size_t split(const char *line, size_t length, struct cell *cell)
{
    size_t count = 0;
    const char *end = line + length;
    for (const char *at = line; count < CELLS_MOST; count++) {
        const char *tab = memchr(at, '\t', (size_t)(end - at));
        const char *to = tab ? tab : end;
        const char *from = past_blanks(at, to);
        while (to > from && to[-1] == ' ')
            to--;
        cell[count] = (struct cell){from, (size_t)(to - from)};
        if (!tab)
            return count + 1;
        at = tab + 1;
    }
    return count;
}

static bool is_word(const struct cell *cell, const char *word)
{
    return cell->length == strlen(word) && !memcmp(cell->text, word, cell->length);
}

static struct error *find_column(const struct table_reader *t, const struct cell *cell,
                                 long *column)
{
    size_t group = 0;
    for (int k = 0; k < WEIGHTS_OPTIONS; k++)
        if (is_word(cell, option_names[k])) {
            *column = OPTION_COLUMN - k;
            return NULL;
        }
    *column = NAME_COLUMN;
    if (is_word(cell, "name"))
        return NULL;
    struct error *err = find_group(t->weights, cell->text, cell->length, &group);
    *column = (long)group;
    return err;
}

static struct error *read_head(struct table_reader *t, size_t count)
{
    struct error *err = NULL;
    for (size_t c = 0; c < count && !err; c++) {
        const struct cell *cell = &t->cell[c];
        err = find_column(t, cell, &t->column[c]);
        for (size_t b = 0; b < c && !err; b++)
            if (t->column[b] == t->column[c])
                err = error_new("column '%.*s' stands twice", (int)cell->length, cell->text);
    }
    t->columns = count;
    return err;
}

static struct error *name_row(struct weights *w, const struct cell *cell)
{
    const size_t row = w->rows - 1;
    if (!cell->length) /* it has its number */
        return NULL;
    w->name[row] = strndup(cell->text, cell->length);
    return w->name[row] ? NULL : error_memory();
}

/* An empty cell says nothing. */
static struct error *keep_option(struct weights *w, long column, const struct cell *cell)
{
    char **option = &w->option[(w->rows - 1) * WEIGHTS_OPTIONS + (size_t)(OPTION_COLUMN - column)];
    if (!cell->length)
        return NULL;
    *option = strndup(cell->text, cell->length);
    return *option ? NULL : error_memory();
}

static struct error *read_cell(struct weights *w, long column, const struct cell *cell)
{
    if (column == NAME_COLUMN)
        return name_row(w, cell);
    if (column < NAME_COLUMN)
        return keep_option(w, column, cell);
    double *weight = w->weight + 3 * ((w->rows - 1) * w->groups + (size_t)column);
    return error_wrap(read_weight(cell->text, cell->length, weight), "group %s", w->group[column]);
}

struct named_row {
    const char *name;
    size_t line;
};

static int compare_names(const void *a, const void *b)
{
    const struct named_row *x = a, *y = b;
    const int order = strcmp(x->name, y->name);
    return order ? order : x->line < y->line ? -1 : 1;
}

/* That no two rows have the same name. */
static struct error *check_names(const struct table_reader *t, const char *file)
{
    const struct weights *w = t->weights;
    struct named_row *row = NULL;
    size_t count = 0;
    struct error *err = array_create(&row, w->rows + 1, sizeof *row);
    for (size_t r = 0; r < w->rows && !err; r++)
        if (w->name[r])
            row[count++] = (struct named_row){w->name[r], t->line[r]};
    if (!err)
        qsort(row, count, sizeof *row, compare_names);
    for (size_t r = 1; r < count && !err; r++)
        if (!strcmp(row[r].name, row[r - 1].name))
            err = error_new("%s:%zu: there is a row '%s' already", file, row[r].line, row[r].name);
    free(row);
    return err;
}

static struct error *read_row(struct table_reader *t, size_t count, size_t line)
{
    if (count != t->columns)
        return error_new("expected %zu cells, as the first line has, got %zu", t->columns, count);
    struct weights *w = t->weights;
    struct error *err = array_reserve(&t->line, &t->line_capacity, w->rows + 1, sizeof *t->line);
    if (!err)
        err = add_row(w);
    if (!err)
        t->line[w->rows - 1] = line;
    for (size_t c = 0; c < count && !err; c++)
        err = read_cell(w, t->column[c], &t->cell[c]);
    return err;
}

static bool is_empty(const struct cell *cell, size_t count)
{
    size_t length = 0;
    for (size_t c = 0; c < count; c++)
        length += cell[c].length;
    return !length;
}

static struct error *read_table(struct table_reader *t, struct file_input *in)
{
    struct error *err = NULL;
    while (!err) {
        const char *line;
        size_t length, bytes;
        err = file_input_line(in, &line, &length, &bytes);
        if (err || !line)
            return err;
        in->line++;
        if (length && line[length - 1] == '\r')
            length--;
        /* a byte order mark */
        const size_t mark = in->line == 1 && length > 2 && !memcmp(line, "\xEF\xBB\xBF", 3) ? 3 : 0;
        const size_t count = split(line + mark, length - mark, t->cell);
        if (*line != '#' && !is_empty(t->cell, count))
            err = t->columns ? read_row(t, count, in->line) : read_head(t, count);
        err = error_wrap(err, "%s:%zu", in->name, in->line);
        file_input_consume(in, bytes);
    }
    return err;
}

struct error *weights_read(struct weights *w, const char *path)
{
    struct file_input in;
    struct table_reader t = {.weights = w};
    struct error *err = array_create(&t.cell, CELLS_MOST, sizeof *t.cell);
    if (!err)
        err = array_create(&t.column, CELLS_MOST, sizeof *t.column);
    if (!err)
        err = file_input_open(&in, path);
    if (!err) {
        forget_rows(w);
        err = read_table(&t, &in);
        if (!err && !w->rows)
            err = error_new("%s: expected a line of groups and one a row of weights, got no row",
                            in.name);
        if (!err)
            err = check_names(&t, in.name);
        file_input_close(&in);
    }
    free(t.line);
    free(t.cell);
    free(t.column);
    return err;
}

char *weights_row_name(const struct weights *w, size_t row)
{
    char *text = NULL;
    if (w->name[row])
        return strdup(w->name[row]);
    return asprintf(&text, "%zu", row) < 0 ? NULL : text;
}

/* By number where no row has that name. */
static size_t find_row(const struct weights *w, const char *row)
{
    size_t found = 0;
    while (found < w->rows && (!w->name[found] || strcmp(w->name[found], row)))
        found++;
    char *end;
    const unsigned long number = strtoul(row, &end, 10);
    if (found == w->rows && *row >= '0' && *row <= '9' && !*end && number < w->rows)
        found = number;
    return found;
}

struct error *weights_choose(struct weights *w, const char *row)
{
    const size_t found = find_row(w, row), width = 3 * w->groups;
    if (found == w->rows)
        return error_usage("--row: expected the name of a row, or a number below %zu, got '%s'",
                           w->rows, row);
    memmove(w->weight, w->weight + found * width, width * sizeof *w->weight);
    char *name = w->name[found], *option[WEIGHTS_OPTIONS];
    w->name[found] = NULL;
    for (size_t k = 0; k < WEIGHTS_OPTIONS; k++) {
        option[k] = w->option[found * WEIGHTS_OPTIONS + k];
        w->option[found * WEIGHTS_OPTIONS + k] = NULL;
    }
    forget_rows(w);
    w->rows = 1;
    w->name[0] = name;
    memcpy(w->option, option, sizeof option);
    return NULL;
}
