/* SPDX-License-Identifier: Apache-2.0 */
/* file: bytes in and out of files, buffered; "-" is standard input or output; files that appear
 * under their name only when they are whole.
 *
 *     struct file_output out;
 *     err = file_output_open(&out, path, true);
 *     if (!err)
 *         err = file_output_write(&out, bytes, count);
 *     if (!err)
 *         return file_output_finish(&out);
 *     file_output_abandon(&out);
 *
 * Errors name the file, unless said otherwise. What is opened is claimed (claim.h): a file is not
 * read here and overwritten there.
 */
#ifndef FILE_H
#define FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct error;

enum {
    FILE_LINE_MOST = 16 << 20,   /* bytes of a line */
    FILE_BLOCK_BYTES = 256 << 10 /* that are written at once: they stay in the second-level cache */
};

/* Whether what comes from a path ("-": standard input) is a file of fewer bytes than that, or is
 * typed, or nothing; not what nobody knows the end of. */
bool file_is_small(const char *path, size_t bytes);

/* What messages call the file of this path: "-" is "stdin" or "stdout". */
const char *file_input_name(const char *path);
const char *file_output_name(const char *path);

/* The whole of a file in memory, one zero byte behind it; the caller frees it. Errors do not name
 * the file. "-" is no standard input here: files that other files name may be called anything. */
struct error *file_read(const char *path, char **data, size_t *size);

/* The same of what a command line names, where "-" is standard input. */
struct error *file_read_input(const char *path, char **data, size_t *size);

/* A usage error where two inputs of a command line ("the scene", "the probes") both come from
 * standard input, by whatever name. */
struct error *file_inputs_differ(const char *a, const char *a_is, const char *b, const char *b_is);

/* A usage error where `what` ("SCENE") cannot be read more than once, as by programs that are run:
 * standard input, by whatever name, a pipe or a device. A file that is not there is left to who
 * opens it. */
struct error *file_check_again(const char *path, const char *what);

/* Raises the limit of open files, as far as it may be, so that so many more can be open at once.
 * Errors: they cannot. */
struct error *file_make_room(size_t files);

/* -- in -------------------------------------------------------------------------------------- */

struct file_input {
    int fd;
    char *name;          /* for messages: the path, or "stdin" */
    unsigned char *data; /* bytes start .. end-1 are read and not yet consumed; owned */
    size_t start, end, capacity;
    uint64_t offset; /* of the next byte to be consumed */
    size_t line;     /* number of the last line that was consumed, from 1 */
    bool ended;      /* no more bytes to read */
};

/* Closed again on error. */
struct error *file_input_open(struct file_input *in, const char *path);
void file_input_close(struct file_input *in);

/* Reads what has come, up to `most` bytes, past the buffer; *got is 0 only at the end. */
struct error *file_input_read(struct file_input *in, void *bytes, size_t most, size_t *got);

/* Makes `count` bytes available at *bytes; *got is how many there are: fewer only when the input
 * ends. Memory grows with what arrives. */
struct error *file_input_peek(struct file_input *in, size_t count, const unsigned char **bytes,
                              size_t *got);

/* Consumes bytes that are available. */
void file_input_consume(struct file_input *in, size_t count);

/* The next line, not consumed: *line without its newline (NULL at the end of input), *bytes what it
 * takes with it. */
struct error *file_input_line(struct file_input *in, const char **line, size_t *length,
                              size_t *bytes);

/* All that is not consumed, as file_read gives it. */
struct error *file_input_rest(struct file_input *in, char **data, size_t *size);

/* -- out ------------------------------------------------------------------------------------- */

struct file_output {
    int fd;
    char *name;      /* for messages: the path, or "stdout" */
    char *target;    /* the file that appears at the end; NULL: written directly */
    char *temporary; /* its name until then; NULL: it has none yet (O_TMPFILE) */
    char *data;      /* bytes to be written; owned */
    size_t count, capacity;
};

/* binary: refused when the output is a terminal. Cleared on error. */
struct error *file_output_open(struct file_output *out, const char *path, bool binary);

/* Room for `count` bytes behind those not yet written; the caller fills them and adds to
 * out->count. */
struct error *file_output_room(struct file_output *out, size_t count, char **room);

/* Writes what is in memory when it is more than a block (always: all of it). */
struct error *file_output_flush(struct file_output *out, bool always);

/* Writes bytes that lie elsewhere, behind those in memory. */
struct error *file_output_write(struct file_output *out, const void *bytes, size_t count);

/* Flushes, closes, and gives the file its name. Clears, on error too. */
struct error *file_output_finish(struct file_output *out);

/* Closes without a name for the file. Clears. */
void file_output_abandon(struct file_output *out);

#endif
