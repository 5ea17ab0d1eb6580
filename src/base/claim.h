/* SPDX-License-Identifier: Apache-2.0 */
/* claim: no program overwrites what it reads, nor writes two things into one file.
 *
 * options_parse claims what the command line names to be written (option_row.written), before
 * anything is opened; file.h claims whatever it opens. So who comes second is refused, whether the
 * scene is read first, with its textures, or the output is opened first. Files are told apart by
 * device and inode, those that are not there yet by folder and name; pipes, terminals and devices
 * are nobody's. The process has one list of claims, which begins with claim_begin: before, as in
 * tests of modules, all is allowed. Any thread may call.
 *
 * A filter may write in place: its output appears, in place of what it read, when it is whole.
 */
#ifndef CLAIM_H
#define CLAIM_H

#include <stdbool.h>

struct error;

/* From here on files are claimed. */
void claim_begin(void);

/* `path` is written ("-": to standard output), because of --`option`; NULL: of no option, and a
 * file that --option claims is the same output. A usage error names the file, and which other
 * option or input it is, or says that there is no name. */
struct error *claim_output(const char *path, const char *option);

/* What the descriptor reads. The error does not name the file. */
struct error *claim_input(int fd);

/* A file that other programs read, on behalf of this one: it may be missing. */
struct error *claim_input_of(const char *path);

/* The file at `path`, if there is one, is about to be replaced by an output that is whole: nothing
 * can overwrite it any more, and its inode may be that of another file soon. */
void claim_end(const char *path);

/* The stream `path` ("-": standard input) may be replaced by --output, but not by writing into it
 * as a shell's > does. Before it is opened. */
void claim_in_place(const char *path);

#endif
