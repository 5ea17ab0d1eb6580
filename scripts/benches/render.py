# SPDX-License-Identifier: Apache-2.0
"""a path traced picture on one thread, 320 x 180 pixels of 16 paths, beside capture: rays a
second
"""
import shlex

from .inputs import place, scene_name, scene_of
from .running import figures_of, run, scratch, table


def bench(options):
    scene = shlex.quote(scene_of(options))
    with scratch() as file:
        placed, captured = file("placed.probe"), file("captured.probe")
        place(options, placed, options.size(64, 4))
        run(f"probe-capture -q --rays {options.rays} {options.light} -o {captured} {scene}"
            f" {placed}")
        found = figures_of(options, "bench_rays", "--render", scene_of(options), captured,
                           options.runs)
    table(f"rays of all kinds, one thread: {scene_name(options)}",
          ("capture M/s", "render M/s", "render / capture", "paths M/s"),
          [(f"{found['capture_mrays']:.2f}", f"{found['render_mrays']:.2f}",
            f"{found['ratio']:.2f}", f"{found['paths']:.3f}")])
