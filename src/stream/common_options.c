/* SPDX-License-Identifier: Apache-2.0 */
#include "stream/common_options.h"
#include "base/options.h"
#include "base/threads.h"

#include <unistd.h>

struct common common_default(void)
{
    return (struct common){.output = "-",
                           .encoding = STREAM_AS_READ,
                           .threads = threads_available(),
                           .progress = isatty(STDERR_FILENO)};
}

const struct option_row *common_rows(struct common *common, unsigned which, struct option_row *rows)
{
    size_t n = 0;
    if (which & COMMON_OUTPUT)
        rows[n++] =
            (struct option_row){.name = "output",
                                .letter = 'o',
                                .argument = "FILE",
                                .kind = OPTION_TEXT,
                                .help = "write to FILE, which appears only when it is whole;\n"
                                        "- is standard output",
                                .value = &common->output,
                                .written = true,
                                .unrecorded = true};
    if (which & COMMON_ENCODING) {
        rows[n++] =
            (struct option_row){.name = "text",
                                .kind = OPTION_SET,
                                .count = STREAM_TEXT,
                                .help = "write the stream as text (default: as it was read)",
                                .value = OPTION_ENUM(common->encoding),
                                .unrecorded = true};
        rows[n++] =
            (struct option_row){.name = "binary",
                                .kind = OPTION_SET,
                                .count = STREAM_BINARY,
                                .help = "write the stream as binary (default: as it was read)",
                                .value = OPTION_ENUM(common->encoding),
                                .unrecorded = true};
    }
    if (which & COMMON_SEED)
        rows[n++] = (struct option_row){.name = "seed",
                                        .argument = "N",
                                        .kind = OPTION_INTEGER,
                                        .most = 0x1p53,
                                        .help = "another seed gives other random numbers",
                                        .value = &common->seed};
    if (which & COMMON_THREADS)
        rows[n++] = (struct option_row){.name = "threads",
                                        .letter = 'j',
                                        .argument = "N",
                                        .kind = OPTION_INT,
                                        .least = 1,
                                        .most = 1024,
                                        .unrecorded = true,
                                        .help = "use N threads; the output does not depend on it",
                                        .value = &common->threads};
    if (which & COMMON_PROGRESS)
        rows[n++] = (struct option_row){
            .name = "progress",
            .kind = OPTION_FLAG,
            .unrecorded = true,
            .help = "show progress (default: when standard error is a terminal)",
            .value = &common->progress};
    rows[n++] = (struct option_row){.name = "quiet",
                                    .letter = 'q',
                                    .kind = OPTION_FLAG,
                                    .unrecorded = true,
                                    .help = "no warnings and no progress",
                                    .value = &common->quiet};
    rows[n] = (struct option_row){0};
    return rows;
}
