# SPDX-License-Identifier: Apache-2.0
"""points a second of probe-query on at most 100000 probes, beside scipy and VTK on the same points,
cold lookups, opening, and on an octree
"""
import os
import statistics
import sys
import tempfile

from .inputs import big_stream, random_stream, write_points
from .octree import octree_in_cube
from .peers import rates_of_peers
from .running import figures_of, medians, run, scratch, table

BINARY = "--from binary --to binary"


def query_points(file, count):
    """Points along a smooth path through the unit cube, 60 to a cell or so, and at random, as
    doubles; with normals too; and four times as many along the path: what is fast needs many to be
    timed. Arrays and files, by name."""
    import numpy
    draw = numpy.random.default_rng(1)
    t = numpy.arange(4 * count) * 2e-4
    turns = [numpy.sin(0.7 * t), numpy.sin(1.1 * t + 1), numpy.sin(1.7 * t + 2)]
    path = 0.5 + 0.45 * numpy.stack(turns, axis=1)
    points = {"long path": path, "path": path[:count], "random": draw.random((count, 3))}
    normal = draw.standard_normal((count, 3))
    for name in ("path", "random"):
        points[f"{name}, irradiance"] = numpy.concatenate([points[name], normal], axis=1)
    files = {}
    for name, value in points.items():
        files[name] = file(name.replace(", ", "-").replace(" ", "-") + ".bin")
        value.tofile(files[name])
    return points, files


def commands_of(ask, files, text, count, shared):
    """What is timed on one thread: a name, how many points, the command."""
    one = f"{ask} -j 1 {BINARY}"
    rows = [("path", 4 * count, f"{one} {files['long path']}"),
            ("random order", count, f"{one} {files['random']}"),
            ("path, irradiance", count, f"{one} --normals {files['path, irradiance']}"),
            ("random order, irradiance", count, f"{one} --normals {files['random, irradiance']}"),
            ("path, text in and out", count // 8, f"{ask} -j 1 {text}"),
            ("path, into a pipe", count, f"sh -c '{one} {files['path']} | cat'"),
            ("path, irradiance, into a pipe", count,
             f"sh -c '{one} --normals {files['path, irradiance']} | cat'")]
    if shared:
        rows.append(("path, into /dev/shm", count, f"sh -c '{one} {files['path']} >{shared}'"))
    return rows


def bench_files(options, stream, files, text, light, count):
    """The program from files to files, on one thread, several, and as several processes; points a
    second by name."""
    ask = f"probe-query -q {stream}"
    shm = tempfile.NamedTemporaryFile(dir="/dev/shm") if os.path.isdir("/dev/shm") else None
    rows = commands_of(ask, files, text, count, shm and shm.name)
    copies = [("path, into a pipe", f"sh -c 'cat {light} | cat'")]
    if shm:
        copies.append(("path, into /dev/shm", f"sh -c 'cat {light} >{shm.name}'"))
    several = [n for n in (2, 4, 8, 16, 32) if n <= len(os.sched_getaffinity(0))]
    for n in several:
        rows += [(f"path, {n} threads", 4 * count, f"{ask} -j {n} {BINARY} {files['long path']}"),
                 (f"random order, {n} threads", count, f"{ask} -j {n} {BINARY} {files['random']}")]

    def at_once(n, path):
        return "sh -c '" + f"{ask} -j 1 {BINARY} {path} & " * n + "wait'"

    beside = [at_once(n, path) for n in several
              for path in ("/dev/null", files["long path"], files["random"])]
    seconds = medians([f"{ask} -j 1 {BINARY} /dev/null"] + [r[2] for r in rows]
                      + [c[1] for c in copies] + beside, options.runs)
    opening, seconds = seconds[0], seconds[1:]
    rates = {row[0]: row[1] / (s - opening) for row, s in zip(rows, seconds)}
    copied = {name: count / s for (name, _), s in zip(copies, seconds[len(rows):])}
    for i, n in enumerate(several):
        start, path, scattered = seconds[len(rows) + len(copies) + 3 * i:][:3]
        rates[f"path, {n} processes at once"] = n * 4 * count / (path - start)
        rates[f"random order, {n} processes at once"] = n * count / (scattered - start)
    shown = []
    for name, rate in rates.items():
        alone = rates["random order" if "random" in name else "path"]
        shown.append((name, f"{rate / 1e6:.2f}", f"{rate / alone:.2f}",
                      f"{rate / copied[name]:.2f}" if name in copied else ""))
    table(f"query: {min(options.probes, 100000)} probes, 27 coefficients, binary, one thread but"
          f" where said; reading the stream ({opening:.2f} s) is not counted",
          ("what", "M points/s", "times one thread", "times cat of the same light"), shown)
    return rates


def bench_opening(options, file, stream):
    """Until the first lookup, all checked: of the stream and its packed files, beside reading their
    bytes."""
    shown = []
    packed = {"stream": stream}
    for precision in ("float", "half"):
        packed[f"packed, {precision}"] = file(f"{precision}.pack")
        run(f"probe-query -q --pack {precision} -o {packed[f'packed, {precision}']} {stream}")
    seconds = medians([command for path in packed.values() for command in (
        f"probe-query -q -j 1 {BINARY} {path} /dev/null", f"sh -c 'cat {path} | cat'")],
                      options.runs)
    for name, opening, reading in zip(packed, seconds[::2], seconds[1::2]):
        shown.append((name, f"{opening:.3f}", f"{reading:.3f}", f"{opening / reading:.1f}"))
    table(f"query, opening: {min(options.probes, 100000)} probes, one thread, no points",
          ("what", "opening, s", "cat of the same bytes, s", "times"), shown)


def bench_octree(options, file, files, count):
    tree, size = octree_in_cube(file, options.size(100000, 300))
    ways = ("trilinear", "tricubic")
    seconds = medians([f"probe-query -q -j 1 --interpolate {way} {BINARY} {tree} {path}"
                       for way in ways for path in ("/dev/null", files["path"], files["random"])],
                      options.runs)
    table(f"query of an octree of {size} probes, one thread",
          ("how", "opening, s", "path, M points/s", "random order, M points/s"),
          [(way, f"{start:.2f}", f"{count / (path - start) / 1e6:.2f}",
            f"{count / (far - start) / 1e6:.2f}")
           for way, start, path, far in zip(ways, seconds[::3], seconds[1::3], seconds[2::3])])


def bench_peers(options, stream, points, files, few, rates):
    """The library and the program beside others, at the first `few` of the same points."""
    for name in ("path", "random"):
        points[name][:few].tofile(files[name] + ".few")
    ours = {name: figures_of(options, "bench_query", stream, files[name] + ".few", options.runs)
            for name in ("path", "random")}
    rows = [(f"library, {name}", f"{ours['path'][key]:.2f}", f"{ours['random'][key]:.3f}",
             "", "", "", "")
            for name, key in (("a call a point", "calls"), ("batches", "batch"),
                              ("a call a point, irradiance", "irradiance"))]
    try:
        others = rates_of_peers(stream, [points["path"][:few], points["random"][:few]],
                                options.runs)
    except ModuleNotFoundError as missing:
        print(f"bench: query: peers skipped: {missing} (scripts/setup installs it)",
              file=sys.stderr)
        others = {}
    for name, (path, scattered) in others.items():
        rows.append((name, f"{path / 1e6:.3f}", f"{scattered / 1e6:.3f}",
                     f"{ours['path']['batch'] * 1e6 / path:.1f}",
                     f"{ours['random']['batch'] * 1e6 / scattered:.1f}",
                     f"{rates['path'] / path:.1f}", f"{rates['random order'] / scattered:.1f}"))
    table(f"query beside peers, one thread, {few} of the same points: the library from memory to"
          " memory as they are, the program with all its points, from file to /dev/null",
          ("what", "path, M/s", "random, M/s", "library is times, path", "times, random",
           "program is times, path", "times, random"), rows)


def bench_cold(options):
    """Single lookups without a last cell: microseconds."""
    with scratch() as file:
        points, stream = file("points.probe"), file("cells.probe")
        random_stream(points, options.size(150000, 1000))
        run(f"probe-tet -q -o {stream} {points}")
        runs = [figures_of(options, "bench_cold", stream) for _ in range(options.runs)]
    table(f"query, cold: single lookups from PROBE_COLD in {runs[0]['cells']} cells, microseconds",
          ("volume", "median", "99th percentile"),
          [(name, *(f"{statistics.median(r[name][i] for r in runs):.2f}" for i in range(2)))
           for name in ("plain", "lean")])


def bench(options):
    count = options.size(4000000, 4000)
    with scratch() as file:
        stream = big_stream(file, min(options.probes, 100000))
        points, files = query_points(file, count)
        text, light = file("path.txt"), file("light.bin")
        write_points(text, points["path"][:count // 8].tolist())
        run(f"probe-query -q {stream} {BINARY} -o {light} {files['path']}")
        rates = bench_files(options, stream, files, text, light, count)
        bench_opening(options, file, stream)
        bench_octree(options, file, files, count)
        bench_peers(options, stream, points, files, options.size(100000, 400), rates)
    bench_cold(options)
