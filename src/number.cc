#include "number.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace {

template <typename T> char *write(char *to, T value)
{
    return std::to_chars(to, to + NUMBER_ROOM, value).ptr;
}

template <typename T> char *write_real(char *to, T value)
{
    return write(to, std::isnan(value) ? std::abs(value) : value); /* "nan", whatever its sign */
}

/* from_chars gives no value when the number is out of range: what is too small is 0, what is too large is refused. */
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
        from; /* too small if the exponent is negative, or there is none and all that counts is behind the point */
    bool small = false;
    for (; digit < result.ptr; digit++)
        if (*digit == 'e' || *digit == 'E') {
            small = digit + 1 < result.ptr && digit[1] == '-';
            break;
        }
    if (digit == result.ptr)
        small = *from == '0' || *from == '.' || (*from == '-' && (from[1] == '0' || from[1] == '.'));
    if (!small)
        return nullptr;
    *value = *from == '-' ? T(-0.0) : T(0);
    return result.ptr;
}

} // namespace

extern "C" {

char *number_write_f32(char *to, float value)
{
    return write_real(to, value);
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
