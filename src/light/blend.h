/* SPDX-License-Identifier: Apache-2.0 */
/* blend: the light of two bakes of the same probes, as of a door that is open in one and closed in
 * the other, as one.
 */
#ifndef BLEND_H
#define BLEND_H

struct error;
struct stream;
struct warnings;

/* The weight of the second stream, in a header; capture takes it away. */
#define BLEND_KEY "light-blend"

/* Makes the light of `to` 1 - weight times its own plus weight (0 to 1) times that of `from`: all
 * columns of light (light_columns.h); standard errors as of independent ones. A probe without light
 * in one has none. Other columns, tables and keys of `to` stay, those of `from` do not matter;
 * windows and other bases go, with a warning. Errors: other probes, or in another order; light in
 * other columns, of another content, split or turned otherwise; compressed light. */
struct error *blend_streams(struct stream *to, const struct stream *from, double weight,
                            struct warnings *warnings);

#endif
