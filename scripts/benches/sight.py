# SPDX-License-Identifier: Apache-2.0
"""1000 probes of the two rooms or --scene on one thread: what probe-leakfix takes to look from them
as a share of their capture, and what a lookup by sight takes of one without
"""
import array
import os
import random
import shlex
import statistics

from .inputs import SOURCE, scene_name, text_rows
from .running import figures_of, medians, output_of, run, scratch, table


def write_points_around(probes, along, scattered, count):
    """As doubles, in the box of the probes: along a straight way and back, and at random."""
    rows = text_rows(probes, "position")
    low, high = [min(c) for c in zip(*rows)], [max(c) for c in zip(*rows)]
    draw = random.Random(1)
    for path, shares in ((along, [(abs(2 * i / count - 1),) * 3 for i in range(count)]),
                         (scattered, [tuple(draw.random() for _ in range(3))
                                      for _ in range(count)])):
        with open(path, "wb") as f:
            array.array("d", [a + s * (b - a) for point in shares
                              for a, b, s in zip(low, high, point)]).tofile(f)


def bench(options):
    options.scene = options.scene or os.path.join(SOURCE, "scenes", "two-rooms.obj")
    scene = shlex.quote(options.scene)
    with scratch() as file:
        placed, lit, cells = file("placed.probe"), file("lit.probe"), file("cells.probe")
        seen, along, scattered = file("seen.probe"), file("along.bin"), file("scattered.bin")
        run(f"probe-place grid -q --count {options.size(1000, 60)} -o {placed} {scene}")
        capture = f"probe-capture -q -j 1 --rays {options.rays} {options.light} -o {lit} {scene}"
        run(f"{capture} {placed}")
        run(f"probe-tet -q -o {cells} {lit}")
        seconds = medians([f"{capture} {placed}",
                           f"probe-leakfix -q -j 1 -o {seen} {scene} {cells}",
                           f"probe-leakfix -q -j 1 --no-sight -o {file('blind')} {scene} {cells}"],
                          options.runs)
        sight = seconds[1] - seconds[2]
        write_points_around(cells, along, scattered, options.size(400000, 100))
        rates = {(stream, points): [] for points in (along, scattered) for stream in (cells, seen)}
        for _ in range(options.runs):
            for (stream, points), found in rates.items():
                found.append(figures_of(options, "bench_query", stream, points, 3)["calls"])
        rates = {which: statistics.median(found) for which, found in rates.items()}
        count = output_of("probe-cat", "--info", seen).split("table probe: ")[1].split()[0]
    table(f"sight: {scene_name(options)}, {count} probes, one thread, {options.rays} rays a probe",
          ("what", "seconds", "of capture"),
          [("probe-capture", f"{seconds[0]:.2f}", "1"),
           ("probe-leakfix", f"{seconds[1]:.2f}", f"{seconds[1] / seconds[0]:.3f}"),
           ("  of that, sight", f"{sight:.2f}", f"{sight / seconds[0]:.3f}")])
    table("lookups of the library, M points/s",
          ("points", "without", "with sight", "times the time"),
          [(name, f"{rates[cells, points]:.2f}", f"{rates[seen, points]:.2f}",
            f"{rates[cells, points] / rates[seen, points]:.2f}")
           for name, points in (("along a line", along), ("random", scattered))])
