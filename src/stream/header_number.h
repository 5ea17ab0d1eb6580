/* SPDX-License-Identifier: Apache-2.0 */
/* header_number: header keys that hold numbers, or one of some names.
 *
 * Getting checks what the value holds and its range; a key that is not there leaves the number as
 * it was, which is no error. Errors: "header key NAME: expected ..., got 'VALUE'".
 */
#ifndef HEADER_NUMBER_H
#define HEADER_NUMBER_H

#include <stdint.h>

struct error;
struct stream_header;

enum { HEADER_REALS_MOST = 16 }; /* numbers of a key */

struct error *header_set_whole(struct stream_header *header, const char *key, int64_t value);
struct error *header_set_real(struct stream_header *header, const char *key, double value);

/* Separated by commas. */
struct error *header_set_reals(struct stream_header *header, const char *key, int count,
                               const double *value);

/* A whole number from `least`, which is 0 or more, to `most`. */
struct error *header_get_whole(const struct stream_header *header, const char *key, int64_t least,
                               int64_t most, int64_t *value);
struct error *header_get_int(const struct stream_header *header, const char *key, int least,
                             int most, int *value);

/* Finite numbers from `least` to `most`; no limit: -DBL_MAX, DBL_MAX. On error none is set. */
struct error *header_get_real(const struct stream_header *header, const char *key, double least,
                              double most, double *value);
struct error *header_get_reals(const struct stream_header *header, const char *key, int count,
                               double least, double most, double *value);

/* Which of some names, of which a NULL is the last, the value is. */
struct error *header_get_choice(const struct stream_header *header, const char *key,
                                const char *const *names, int *choice);

/* That a key is there. */
struct error *header_require(const struct stream_header *header, const char *key);

#endif
