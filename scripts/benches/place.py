# SPDX-License-Identifier: Apache-2.0
"""probe-place adaptive in the two rooms or --scene on one thread: its user seconds as captures of
the probes that it gives (below 20 is good), and its memory; what --reach takes a place
"""
import os
import shlex

from .inputs import SOURCE, place, scene_name
from .running import medians, output_of, run_peak, scratch, table, user_seconds


def probes_of(stream):
    return int(output_of("probe-cat", "--info", stream).split("table probe: ")[1].split()[0])


def bench(options):
    options.scene = options.scene or os.path.join(SOURCE, "scenes", "two-rooms.obj")
    scene = shlex.quote(options.scene)
    light = f"--threads 1 --rays {options.rays} {options.light}"
    rows = []
    with scratch() as file:
        placed, lit, start, reached = (file(n) for n in ("placed", "lit", "start", "reached"))
        for count in options.size((100, 300, 1000), (12,)):
            adaptive = f"probe-place adaptive -q --probes {count} {light} -o {placed} {scene}"
            peak = run_peak(adaptive)[1]
            seconds, capture = medians(
                [adaptive, f"probe-capture -q --again {light} -o {lit} {scene} {placed}"],
                options.runs, user_seconds)
            rows.append((probes_of(placed), f"{seconds:.2f}", f"{capture:.3f}",
                         f"{seconds / capture:.1f}", f"{peak:.0f}"))
        place(options, start, 4)
        reach, read = medians([f"probe-place reach -q -j 1 {start}.txt -o {reached} {scene}",
                               f"probe-place points -q -j 1 {start}.txt -o {start} {scene}"],
                              options.runs, user_seconds)
        places = probes_of(reached)
    table(f"place: {scene_name(options)}, adaptive, one thread, {options.rays} rays a probe",
          ("probes", "user s", "capture s", "captures", "peak MB"), rows)
    table("reach, without reading the scene", ("places", "user s", "us a place"),
          [(places, f"{reach - read:.2f}", f"{1e6 * (reach - read) / places:.1f}")])
