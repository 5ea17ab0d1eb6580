/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/header_number.h"
#include "base/error.h"
#include "base/number.h"
#include "stream/stream.h"

#include <float.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* -- setting ---------------------------------------------------------------------------------- */

struct error *header_set_whole(struct stream_header *header, const char *key, int64_t value)
{
    char text[32];
    snprintf(text, sizeof text, "%" PRId64, value);
    return header_set_key(header, key, text);
}

struct error *header_set_real(struct stream_header *header, const char *key, double value)
{
    return header_set_reals(header, key, 1, &value);
}

struct error *header_set_reals(struct stream_header *header, const char *key, int count,
                               const double *value)
{
    char text[HEADER_REALS_MOST * (NUMBER_ROOM + 1)], *at = text;
    for (int i = 0; i < count; i++) {
        at = number_write_f64(at, value[i]);
        *at++ = ',';
    }
    at[-1] = '\0';
    return header_set_key(header, key, text);
}

/* -- getting ---------------------------------------------------------------------------------- */

struct error *header_get_whole(const struct stream_header *header, const char *key, int64_t least,
                               int64_t most, int64_t *value)
{
    const char *text = header_key(header, key);
    if (!text)
        return NULL;
    char *end;
    const long long number = strtoll(text, &end, 10); /* what is too large is the largest */
    if (*text < '0' || *text > '9' || *end || number < least || number > most)
        return error_new("header key %s: expected a whole number from %" PRId64 " to %" PRId64
                         ", got '%s'",
                         key, least, most, text);
    *value = number;
    return NULL;
}

struct error *header_get_int(const struct stream_header *header, const char *key, int least,
                             int most, int *value)
{
    int64_t number = *value;
    struct error *err = header_get_whole(header, key, least, most, &number);
    *value = (int)number;
    return err;
}

struct error *header_get_real(const struct stream_header *header, const char *key, double least,
                              double most, double *value)
{
    return header_get_reals(header, key, 1, least, most, value);
}

static struct error *wrong_reals(const char *key, int count, double least, double most,
                                 const char *text)
{
    char what[40] = "a number", from[40] = "", to[40] = "";
    if (count > 1)
        snprintf(what, sizeof what, "%d numbers separated by commas", count);
    if (least > -DBL_MAX)
        snprintf(from, sizeof from, " from %.15g", least);
    if (most < DBL_MAX)
        snprintf(to, sizeof to, "%s %.15g", *from ? " to" : " up to", most);
    return error_new("header key %s: expected %s%s%s, got '%s'", key, what, from, to, text);
}

struct error *header_get_reals(const struct stream_header *header, const char *key, int count,
                               double least, double most, double *value)
{
    const char *text = header_key(header, key), *at = text;
    if (!text)
        return NULL;
    const char *end = text + strlen(text);
    double read[HEADER_REALS_MOST];
    for (int i = 0; i < count; i++) {
        at = number_read_f64(at, end, &read[i]);
        if (!at || *at != (i + 1 < count ? ',' : '\0') || !(read[i] >= least && read[i] <= most))
            return wrong_reals(key, count, least, most, text);
        at++;
    }
    memcpy(value, read, (size_t)count * sizeof *value);
    return NULL;
}

static struct error *wrong_choice(const char *key, const char *const *names, const char *text)
{
    char list[256];
    size_t used = 0;
    for (size_t i = 0; names[i] && used < sizeof list; i++) {
        const char *before = !i ? "" : names[i + 1] ? ", " : " or ";
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", before, names[i]);
    }
    return error_new("header key %s: expected %s, got '%s'", key, list, text);
}

struct error *header_get_choice(const struct stream_header *header, const char *key,
                                const char *const *names, int *choice)
{
    const char *text = header_key(header, key);
    for (int i = 0; text && names[i]; i++) {
        if (!strcmp(text, names[i])) {
            *choice = i;
            return NULL;
        }
    }
    return text ? wrong_choice(key, names, text) : NULL;
}

struct error *header_require(const struct stream_header *header, const char *key)
{
    return header_key(header, key) ? NULL
                                   : error_new("header key %s is expected, there is none", key);
}
