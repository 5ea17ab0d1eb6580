/* SPDX-License-Identifier: Apache-2.0 */
/* Based on:
 * Giulietti, "The Schubfach way to render doubles", 2020: the shortest decimal that reads back, for
 * floats.
 */
#include "base/number.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <system_error>

namespace
{

template <typename T> char *write(char *to, T value)
{
    return std::to_chars(to, to + NUMBER_ROOM, value).ptr;
}

template <typename T> char *write_real(char *to, T value)
{
    return write(to, std::isnan(value) ? std::abs(value) : value); /* "nan", whatever its sign */
}

/* -- the shortest decimal of a float ---------------------------------------------------------- */

__extension__ typedef unsigned __int128 wide;

constexpr int exponent_least = -31, exponent_most = 45; /* of the powers of ten that floats need */

constexpr int log2_of_ten_to(int k) /* rounded down */
{
    return k * 1741647 >> 19;
}

struct powers {
    uint64_t of[exponent_most - exponent_least + 1];
};

/* The first 64 bits of 10^k, and one more in the last place (Giulietti, section 9.8). 10^k 2^n =
 * 5^k 2^(n + k). */
constexpr powers make_powers()
{
    powers p{};
    for (int k = exponent_least; k <= exponent_most; k++) {
        const int shift = 63 - log2_of_ten_to(k) + k;
        wide five = 1, rest = 1;
        uint64_t bits = 0;
        for (int i = 0; i < (k < 0 ? -k : k); i++)
            five *= 5;
        for (int i = 0; i < shift && k < 0; i++) { /* 2^shift / 5^-k, bit by bit */
            rest *= 2;
            bits = 2 * bits + (rest >= five);
            rest -= rest >= five ? five : 0;
        }
        if (k >= 0)
            bits = uint64_t(shift >= 0 ? five << shift : five >> -shift);
        p.of[k - exponent_least] = bits + 1;
    }
    return p;
}

constexpr powers power = make_powers();

struct decimal {
    uint32_t digits; /* digits * 10^exponent */
    int exponent;
};

/* c times a power of ten, rounded down, but to odd where it is not whole (section 9.5). */
inline uint32_t round_to_odd(uint64_t power_of_ten, uint32_t c)
{
    const wide product = wide(power_of_ten) * c;
    return uint32_t(product >> 64) | (uint32_t(product >> 32) > 1);
}

/* Of a float that is not 0: the decimal with the fewest digits that reads back to it, of these the
 * nearest; there may be zeros at its end. Names as in Giulietti's figure 4: the float is c 2^q; s,
 * and t with one digit less, are 10^k and 10^(k + 1) below it; all in quarters of 10^k. */
inline decimal shortest(uint32_t bits)
{
    const uint32_t mantissa = bits & 0x7fffff, biased = bits >> 23 & 0xff;
    const uint32_t c = biased ? mantissa | 0x800000 : mantissa;
    const int q = (biased ? int(biased) : 1) - 150;
    /* the float below is half as far as the one above */
    const bool odd = c & 1, closer = mantissa == 0 && biased > 1;
    const int k = (q * 1262611 - (closer ? 524031 : 0)) >> 22, h = q + log2_of_ten_to(-k) + 1;
    const uint64_t g = power.of[-k - exponent_least];
    const uint32_t least = round_to_odd(g, (4 * c - 2 + closer) << h) + odd,
                   most = round_to_odd(g, (4 * c + 2) << h) - odd;
    const uint32_t v = round_to_odd(g, 4 * c << h), s = v / 4, t = s / 10;
    const bool t_down = least <= 40 * t, t_up = 40 * t + 40 <= most, down = least <= 4 * s,
               up = 4 * s + 4 <= most;
    const bool nearer_up = v + (s & 1) > 4 * s + 2; /* to even */
    const uint32_t longer = s + (down != up ? up : nearer_up);
    const bool shorter = t_down != t_up; /* whether is anybody's guess: no branch */
    return {shorter ? t + t_up : longer, k + shorter};
}

/* -- its text --------------------------------------------------------------------------------- */

constexpr uint32_t ten_to[] = {1,      10,      100,      1000,      10000,
                               100000, 1000000, 10000000, 100000000, 1000000000};

inline int count_digits(uint32_t n) /* > 0 */
{
    const int about = (32 - __builtin_clz(n)) * 1233 >> 12; /* of bits: times log10(2) */
    return about + (n >= ten_to[about]);
}

/* Eight digits, the first in the lowest byte: halves, halves of these, and of these. */
inline uint64_t eight_digits(uint32_t n)
{
    const uint64_t fours = n / 10000 | uint64_t(n % 10000) << 32;
    const uint64_t hundreds = fours * 10486 >> 20 & 0x7f0000007f,
                   twos = hundreds | (fours - 100 * hundreds) << 16;
    const uint64_t tens = twos * 103 >> 10 & 0x000f000f000f000f;
    return tens | (twos - 10 * tens) << 8;
}

/* As std::to_chars writes a float: fixed, or scientific where that is shorter; whole numbers with
 * all their digits. Digits are written nine at a time, and what is too many is written over. */
inline char *write_float(char *to, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    if ((bits >> 23 & 0xff) == 0xff)
        return write_real(to, value);
    if (!(bits & 0x7fffffff))
        return write(to, value);
    *to = '-';
    to += bits >> 31;
    const decimal d = shortest(bits);
    /* digits, and those before the point */
    const int all = count_digits(d.digits), whole = all + d.exponent;
    const uint32_t nine = d.digits * ten_to[9 - all];
    const uint64_t behind = eight_digits(nine % 100000000), text = behind | 0x3030303030303030;
    const char first = char('0' + nine / 100000000);
    const int count = behind ? 9 - __builtin_clzll(behind) / 8 : 1; /* without zeros at the end */
    const int fixed = whole >= count ? whole
                      : whole > 0    ? count + 1
                                     : count + 2 - whole,
              scientific = count + (count > 1) + 4;
    if (fixed <= scientific && whole <= 0) { /* 0.00123 */
        memcpy(to, "0.000000", 8);
        to[2 - whole] = first;
        memcpy(to + 3 - whole, &text, sizeof text);
        return to + fixed;
    }
    if (fixed <= scientific && whole >= count) /* 123000 */
        return write(to, uint64_t(std::abs(value)));
    if (fixed <= scientific && whole > 1) { /* 12.3 */
        to[0] = first;
        memcpy(to + 1, &text, sizeof text);
        memmove(to + whole + 1, to + whole, size_t(count - whole));
        to[whole] = '.';
        return to + fixed;
    }
    to[0] = first; /* 1.23, or 1.23e-45 */
    to[1] = '.';
    memcpy(to + 2, &text, sizeof text);
    if (fixed <= scientific)
        return to + fixed;
    to += scientific - 4;
    const int power_of_ten = whole < 1 ? 1 - whole : whole - 1;
    to[0] = 'e';
    to[1] = whole < 1 ? '-' : '+';
    to[2] = char('0' + power_of_ten / 10);
    to[3] = char('0' + power_of_ten % 10);
    return to + 4;
}

/* -- reading --------------------------------------------------------------------------------- */

/* from_chars gives no value when the number is out of range: what is too small is 0, what is too
 * large is refused. */
template <typename T> const char *read_real(const char *from, const char *end, T *value)
{
    if (from < end && *from == '+' && from + 1 < end && from[1] != '-')
        from++;
    const auto result = std::from_chars(from, end, *value);
    if (result.ec == std::errc())
        return result.ptr;
    if (result.ec != std::errc::result_out_of_range)
        return nullptr;
    const char *digit =
        /* too small if the exponent is negative, or there is none and all that counts is behind the
         * point */
        from;
    bool small = false;
    for (; digit < result.ptr; digit++)
        if (*digit == 'e' || *digit == 'E') {
            small = digit + 1 < result.ptr && digit[1] == '-';
            break;
        }
    if (digit == result.ptr)
        small = *from == '0' || *from == '.' ||
                (*from == '-' && (from[1] == '0' || from[1] == '.'));
    if (!small)
        return nullptr;
    *value = *from == '-' ? T(-0.0) : T(0);
    return result.ptr;
}

} // namespace

extern "C" {

char *number_write_f32(char *to, float value)
{
    return write_float(to, value);
}

char *number_write_f64(char *to, double value)
{
    return write_real(to, value);
}

char *number_write_i32(char *to, int32_t value)
{
    return write(to, value);
}

const char *number_read_f32(const char *from, const char *end, float *value)
{
    return read_real(from, end, value);
}

const char *number_read_f64(const char *from, const char *end, double *value)
{
    return read_real(from, end, value);
}

const char *number_read_i32(const char *from, const char *end, int32_t *value)
{
    if (from < end && *from == '+' && from + 1 < end && from[1] != '-')
        from++;
    const auto result = std::from_chars(from, end, *value);
    return result.ec == std::errc() ? result.ptr : nullptr;
}

} // extern "C"
