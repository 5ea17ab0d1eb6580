/* SPDX-License-Identifier: Apache-2.0 */
/* clock: how long things take. */
#ifndef CLOCK_H
#define CLOCK_H

/* Seconds since some moment: only differences mean anything. No change of the date moves it. */
double clock_seconds(void);

#endif
