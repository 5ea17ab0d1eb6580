/* SPDX-License-Identifier: Apache-2.0 */
/* sibling: where another of the programs is, for one that runs it. */
#ifndef SIBLING_H
#define SIBLING_H

#include <limits.h>

/* Writes where probe-NAME is: beside the running program, under a name that was changed in the same
 * way (x-probe-bake, x-probe-tet: --program-prefix and the like) or under its own; or, without a
 * folder, what is to be found on the PATH. */
void sibling_find(const char *name, char path[PATH_MAX]);

#endif
