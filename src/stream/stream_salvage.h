/* SPDX-License-Identifier: Apache-2.0 */
/* stream_salvage: what is whole of a stream that was cut short or damaged.
 *
 * A killed capture leaves a stream without its end. Up to the damage its rows are good: in binary
 * every block that has the right checksum, in text every line that is a whole row. A text's last
 * line without its newline is not taken, even if it reads as a row: its last number may be half of
 * one.
 */
#ifndef STREAM_SALVAGE_H
#define STREAM_SALVAGE_H

#include "stream/stream.h"

struct warnings;

/* Reads as stream_read does, and of a stream that is not whole keeps the rows of table probe up to
 * the damage. Of any other table that is damaged nothing is kept; where probes were lost, no other
 * table is, since those speak of probes by number. A warning says where the damage is, and how many
 * rows were kept. Errors: the damage is in the header or before table probe, so that nothing is
 * known; memory is short. `path` outlives the warnings. */
struct error *stream_salvage(struct stream **stream, const char *path, struct warnings *warnings);

#endif
