/* SPDX-License-Identifier: Apache-2.0 */
/* figures: what probe-error --tsv and probe-render print, read back.
 */
#ifndef FIGURES_H
#define FIGURES_H

#include "measure/report.h"

/* Appends the lines of the file: measure, of what, value, low, high (probe-error), or a name and a
 * value (probe-render), whose "of" is empty. Lines of another form are skipped. */
struct error *figures_read(struct report *report, const char *path);

#endif
