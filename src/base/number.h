/* SPDX-License-Identifier: Apache-2.0 */
/* number: numbers as text and back, exactly and fast, whatever the locale.
 *
 * Writing gives the shortest text that reads back to the same bits, as C++17's std::to_chars does
 * (floats by Schubfach, in two thirds of its time); reading rounds correctly (std::from_chars).
 */
#ifndef NUMBER_H
#define NUMBER_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { NUMBER_ROOM = 32 }; /* bytes that any number fits into */

/* Writes the number at `to` (room for NUMBER_ROOM bytes, no zero behind it); returns the end. Not
 * finite: "nan", "inf", "-inf". */
char *number_write_f32(char *to, float value);
char *number_write_f64(char *to, double value);
char *number_write_i32(char *to, int32_t value);

/* Reads a number that starts at `from` (no blanks, a leading + is allowed); returns the first byte
 * behind it, or NULL when there is no number or it does not fit the type. Decimal, "nan" and "inf"
 * in any case; what underflows is 0. `end` bounds the text. */
const char *number_read_f32(const char *from, const char *end, float *value);
const char *number_read_f64(const char *from, const char *end, double *value);
const char *number_read_i32(const char *from, const char *end, int32_t *value);

#ifdef __cplusplus
}
#endif

#endif
