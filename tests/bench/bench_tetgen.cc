/* SPDX-License-Identifier: Apache-2.0 */
// TetGen alone, for scripts/bench tet: what it takes on just the points that probe-tet gives it, in
// their canonical order.
//
//     bench_tetgen order STREAM FILE   the sites of a stream's probes, ordered and scaled as
//     probe-tet does, as raw doubles bench_tetgen run FILE            tetrahedralises those: prints
//     seconds, cells and the peak memory in MB as JSON
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sys/resource.h>
#include <unistd.h>
#include <vector>
#define TETLIBRARY
#include <tetgen.h>
extern "C" {
#include "base/error.h"
#include "stream/stream.h"
#include "tetra/sites.h"
}

static int fail(const char *what)
{
    std::fprintf(stderr, "bench_tetgen: %s\n", what);
    return 1;
}

static int order(const char *stream_path, const char *path)
{
    struct stream *stream = nullptr;
    struct error *err = stream_read(&stream, stream_path);
    if (err)
        return fail(error_message(err));
    const struct table *probes = stream_table(stream, "probe");
    struct sites sites;
    const struct sites_settings settings = {1e-12, nullptr, 0, 1};
    err = sites_make(&sites, probes->rows, column_f64(table_column(probes, "position")), &settings);
    if (err)
        return fail(error_message(err));
    std::vector<double> scaled(sites.site, sites.site + 3 * sites.count);
    for (double &x : scaled)
        x *= 0x1p-40;
    FILE *file = std::fopen(path, "wb");
    if (!file || std::fwrite(scaled.data(), sizeof(double), scaled.size(), file) != scaled.size() ||
        std::fclose(file))
        return fail("cannot write");
    return 0;
}

static int run(const char *path)
{
    FILE *file = std::fopen(path, "rb");
    if (!file || std::fseek(file, 0, SEEK_END))
        return fail("cannot read");
    const size_t count = static_cast<size_t>(std::ftell(file)) / (3 * sizeof(double));
    std::rewind(file);
    tetgenio *in = new tetgenio, *out = new tetgenio;
    in->numberofpoints = static_cast<int>(count);
    in->pointlist = new double[3 * count];
    if (std::fread(in->pointlist, 3 * sizeof(double), count, file) != count)
        return fail("cannot read");
    char switches[] = "Qzn";
    const auto start = std::chrono::steady_clock::now();
    tetrahedralize(switches, in, out);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    std::printf("{\"seconds\": %.6f, \"cells\": %d, \"megabytes\": %.1f}\n", seconds,
                out->numberoftetrahedra, static_cast<double>(usage.ru_maxrss) / 1024);
    std::fflush(stdout);
    _exit(0); // as TetGen leaves it
}

int main(int argc, char **argv)
{
    if (argc == 4 && !std::strcmp(argv[1], "order"))
        return order(argv[2], argv[3]);
    if (argc == 3 && !std::strcmp(argv[1], "run"))
        return run(argv[2]);
    return fail("usage: order STREAM FILE | run FILE");
}
