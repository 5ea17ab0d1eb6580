/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers as text: floats read back to the same bits, with the fewest digits that do, and of these
 * the nearest. */
#include "base/number.h"
#include "support/tap.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static float float_of(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool writes_as(float value, const char *expected)
{
    char text[NUMBER_ROOM + 1];
    *number_write_f32(text, value) = 0;
    return !strcmp(text, expected);
}

/* The digits that count, without point, sign, exponent, and zeros at either end. */
static int digits_of(const char *text, char digits[NUMBER_ROOM])
{
    int count = 0, last = 0;
    for (; *text && *text != 'e'; text++) {
        if (*text < '0' || *text > '9' || (!count && *text == '0'))
            continue;
        digits[count++] = *text;
        last = *text != '0' ? count : last;
    }
    digits[last] = 0;
    return last;
}

int main(void)
{
    /* Every so manieth float; PROBE_NUMBER_STEP=1: all of them, in an hour. */
    const char *step = getenv("PROBE_NUMBER_STEP");
    const uint64_t each = step ? strtoull(step, NULL, 10) : 20011;
    size_t floats = 0, lost = 0, long_ones = 0, off = 0;
    for (uint64_t bits = 1; bits < UINT64_C(1) << 32; bits += each) {
        const float value = float_of((uint32_t)bits);
        char text[NUMBER_ROOM + 1], printed[64], digits[NUMBER_ROOM], nearest[NUMBER_ROOM];
        float back = 0;
        if (!isfinite(value) || value == 0)
            continue;
        char *end = number_write_f32(text, value);
        *end = 0;
        floats++;
        lost += number_read_f32(text, end, &back) != end || memcmp(&back, &value, sizeof back) != 0;
        /* whole numbers are written with all their digits */
        if (value == floorf(value) && fabsf(value) > 0x1p24F)
            continue;
        const int count = digits_of(text, digits);
        snprintf(printed, sizeof printed, "%.*e", count - 1, (double)value);
        digits_of(printed, nearest);
        off += strtof(printed, NULL) == value && strcmp(digits, nearest) != 0;
        snprintf(printed, sizeof printed, "%.*e", count > 1 ? count - 2 : 0, (double)value);
        long_ones += count > 1 && strtof(printed, NULL) == value;
    }
    ok(floats > 1000 && !lost, "of %zu floats, %zu do not read back to the same bits", floats,
       lost);
    ok(!long_ones, "%zu of them have more digits than they need", long_ones);
    ok(!off, "%zu of them are not the nearest with as many digits", off);
    ok(writes_as(0, "0") && writes_as(-0.0F, "-0") && writes_as(1, "1") &&
           writes_as(-12.5F, "-12.5") && writes_as(0.001F, "0.001") && writes_as(10000, "10000") &&
           writes_as(100000, "1e+05") && writes_as(123456792, "123456792"),
       "fixed where that is no longer");
    ok(writes_as(1e-5F, "1e-05") && writes_as(1e30F, "1e+30") &&
           writes_as(FLT_MAX, "3.4028235e+38") && writes_as(0x1p-149F, "1e-45") &&
           writes_as(-1.25e-7F, "-1.25e-07"),
       "scientific where that is shorter");
    ok(writes_as(INFINITY, "inf") && writes_as(-INFINITY, "-inf") && writes_as(NAN, "nan") &&
           writes_as(-NAN, "nan"),
       "what is not finite");
    return tap_done();
}
