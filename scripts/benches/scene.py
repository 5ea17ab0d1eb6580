# SPDX-License-Identifier: Apache-2.0
"""every stage of the pipeline on --scene: seconds, peak memory, rows, bytes"""
import os
import shlex
import sys

from .inputs import error_effort, scene_of
from .running import output_of, run_peak, scratch, table


def bench(options):
    if not options.scene and not options.short:
        sys.exit("bench: scene: name one with --scene")
    scene = shlex.quote(scene_of(options))
    rows = []
    with scratch() as file:
        out = [file(f"{n}.probe") for n in range(5)]
        stages = (f"probe-place grid --count {options.count} -o {out[0]} {scene}",
                  f"probe-capture --rays {options.rays} {options.light} -o {out[1]} {scene}"
                  f" {out[0]}",
                  f"probe-tet -o {out[2]} {out[1]}",
                  f"probe-leakfix -o {out[3]} {scene} {out[2]}",
                  f"probe-error -q {error_effort(options)} -o {out[4]} {scene} {out[3]}")
        for path, stage in zip(out, stages):
            seconds, megabytes = run_peak(stage)
            info = output_of("probe-cat", "--info", path)
            counts = ", ".join(line.strip() for line in info.splitlines()
                               if line.lstrip().startswith("table"))
            rows.append((stage.split()[0], f"{seconds:.2f}", f"{megabytes:.0f}",
                         f"{os.path.getsize(path) / 1e6:.2f}", counts))
    table(f"pipeline: {scene_of(options)}", ("stage", "s", "peak MB", "MB out", "tables"), rows)
