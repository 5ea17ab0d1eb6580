/* SPDX-License-Identifier: Apache-2.0 */
/* Cold lookups, for scripts/bench query: single calls from PROBE_COLD at random points of the
 * probes' box.
 *
 *     bench_cold STREAM      prints cells, and the median and the 99th percentile of microseconds,
 *                            plain and lean, as JSON
 */
#include "base/error.h"
#include "libprobe-query/probe-query.h"
#include "math/box.h"
#include "math/random.h"
#include "math/sort.h"
#include "stream/stream.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { LOOKUPS = 200000 };

static double microseconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}

int main(int argc, char **argv)
{
    static double took[LOOKUPS];
    struct stream *stream = NULL;
    struct error *err = argc == 2 ? stream_read(&stream, argv[1])
                                  : error_new("a stream is expected");
    if (err) {
        fprintf(stderr, "bench_cold: %s\n", error_message(err));
        return 1;
    }
    const struct table *probes = stream_table(stream, "probe"),
                       *cells = stream_table(stream, "tet");
    if (!probes || !cells)
        return 1;
    const struct probe_mesh mesh = {.probes = probes->rows,
                                    .position = column_f64(table_column(probes, "position")),
                                    .corners = 4,
                                    .cells = cells->rows,
                                    .vertex = column_i32(table_column(cells, "vertex")),
                                    .neighbour = column_i32(table_column(cells, "neighbour"))};
    const struct box box = box_of(mesh.probes, mesh.position);
    printf("{\"cells\": %zu", mesh.cells);
    for (unsigned flags = 0; flags <= PROBE_LEAN; flags += PROBE_LEAN) {
        struct probe_volume *volume;
        if (probe_volume_create(&volume, &mesh, flags, NULL))
            return 1;
        struct random r = random_start(1, flags, 0);
        for (size_t i = 0; i < LOOKUPS; i++) {
            struct probe_place place = {.cell = PROBE_COLD};
            double p[3];
            for (int k = 0; k < 3; k++)
                p[k] = box.low[k] + (box.high[k] - box.low[k]) * random_double(&r);
            const double start = microseconds();
            probe_volume_locate(volume, p, &place);
            took[i] = microseconds() - start;
        }
        sort_doubles(LOOKUPS, took);
        printf(", \"%s\": [%.3f, %.3f]", flags ? "lean" : "plain", took[LOOKUPS / 2],
               took[LOOKUPS / 100 * 99]);
        probe_volume_destroy(volume);
    }
    printf("}\n");
    stream_destroy(stream);
    return 0;
}
