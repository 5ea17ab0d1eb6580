/* SPDX-License-Identifier: Apache-2.0 */
/* light_options: the options that say what is done to a stream's light, the same in every program
 * that does it.
 *
 *     struct option_row rows[LIGHT_DERING_ROWS];
 *     ... groups[] = {light_dering_rows(&dering, rows), ...} ... options_parse ...
 *     err = light_dering_check(&dering);
 */
#ifndef LIGHT_OPTIONS_H
#define LIGHT_OPTIONS_H

struct dering_settings;
struct error;
struct option_row;

enum { LIGHT_DERING_ROWS = 3 };

/* Fills rows with --dering and --dering-floor, which write into settings, and returns them. */
const struct option_row *light_dering_rows(struct dering_settings *settings,
                                           struct option_row *rows);

/* Error: a floor without --dering. */
struct error *light_dering_check(const struct dering_settings *settings);

#endif
