/* SPDX-License-Identifier: Apache-2.0 */
#include "capture/openings.h"
#include "base/array.h"
#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NEAR = 3 /* cells about an open one */, BITS = 16 /* of a place within a cell */ };

struct error *openings_init(struct openings *openings, int rows, int columns)
{
    *openings = (struct openings){.rows = rows, .columns = columns};
    return array_create(&openings->open, (size_t)rows * (size_t)columns, 1);
}

void openings_clear(struct openings *openings)
{
    free(openings->open);
    free(openings->cell);
    *openings = (struct openings){0};
}

/* Opens the cells of a row that are near open ones; `was` has room for a row. */
static void widen_row(uint8_t *open, int columns, uint8_t *was)
{
    memcpy(was, open, (size_t)columns);
    for (int i = 0; i < columns; i++)
        for (int k = -NEAR; k <= NEAR && was[i]; k++)
            open[((i + k) % columns + columns) % columns] = 1;
}

static void widen_rows(const struct openings *o, const uint8_t *from, uint8_t *to)
{
    const size_t columns = (size_t)o->columns;
    for (int row = 0; row < o->rows; row++)
        for (int r = row - NEAR; r <= row + NEAR; r++)
            for (size_t i = 0; i < columns && r >= 0 && r < o->rows; i++)
                to[(size_t)row * columns + i] |= from[(size_t)r * columns + i];
}

struct error *openings_find(struct openings *openings)
{
    const size_t cells = (size_t)openings->rows * (size_t)openings->columns;
    uint8_t *wide = NULL;
    struct error *err = array_create(&wide, cells, 1);
    if (!err)
        err = array_create(&openings->cell, cells, sizeof *openings->cell);
    if (err || !memchr(openings->open, 1, cells)) {
        free(wide);
        return err;
    }
    for (int row = 0; row < openings->rows; row++) /* room for a row, before it is used */
        widen_row(openings->open + row * openings->columns, openings->columns, wide);
    memset(wide, 0, cells);
    widen_rows(openings, openings->open, wide);
    free(openings->open);
    openings->open = wide;
    for (size_t i = 0; i < cells; i++)
        if (wide[i])
            openings->cell[openings->count++] = (uint32_t)i;
    return NULL;
}

/* Every second bit. */
static uint32_t gather_bits(uint32_t x)
{
    uint32_t bits = 0;
    for (int i = 0; i < BITS; i++)
        bits |= (x >> 2 * i & 1) << i;
    return bits;
}

/* Within a cell, t goes along a Morton curve. */
void openings_draw(const struct openings *openings, double t, double *x, double *y)
{
    const double along = t * (double)openings->count;
    const size_t last = openings->count - 1, k = along < (double)last ? (size_t)along : last;
    const uint32_t code = (uint32_t)fmin((along - (double)k) * 0x1p32, 0xffffffff);
    const uint32_t cell = openings->cell[k], columns = (uint32_t)openings->columns;
    const double within_x = (gather_bits(code) + 0.5) * 0x1p-16,
                 within_y = (gather_bits(code >> 1) + 0.5) * 0x1p-16;
    *x = (cell % columns + within_x) / openings->columns;
    *y = (cell / columns + within_y) / openings->rows;
}

double openings_density(const struct openings *openings, double x, double y)
{
    const int column = (int)(x * openings->columns), row = (int)(y * openings->rows);
    const size_t cells = (size_t)openings->rows * (size_t)openings->columns,
                 cell = (size_t)(row < openings->rows ? row : openings->rows - 1) *
                            (size_t)openings->columns +
                        (size_t)(column < openings->columns ? column : openings->columns - 1);
    return openings->count && openings->open[cell] ? (double)cells / (double)openings->count : 0;
}
