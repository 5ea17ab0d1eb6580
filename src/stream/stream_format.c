/* SPDX-License-Identifier: Apache-2.0 */
/* What text and binary share: the first line, the lines between rows, and where an error stands. */
#include "base/error.h"
#include "stream/stream_private.h"

#include <inttypes.h>
#include <string.h>

const char stream_magic_text[] = "#?probe 1", stream_magic_binary[] = "#?probe 1 binary";

struct error *reader_place(const struct stream_reader *reader, struct error *err)
{
    if (reader->encoding == STREAM_BINARY)
        return error_wrap(err, "%s: byte %" PRIu64, reader->in.name, reader->in.offset);
    return error_wrap(err, "%s:%zu", reader->in.name, reader->in.line);
}

struct error *ended_within(const struct stream_reader *reader, size_t further)
{
    return error_new("the stream ends within table %s, after %zu rows: it is not whole",
                     reader->schema.name, reader->row + further);
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

bool line_is_table(const char *line, size_t length)
{
    return length > 5 && !memcmp(line, "table", 5) && is_blank(line[5]);
}

bool line_is_end(const char *line, size_t length)
{
    return length >= 3 && !memcmp(line, "end", 3) && (length == 3 || is_blank(line[3]));
}
