# SPDX-License-Identifier: Apache-2.0
"""capture on one thread beside a bare Embree loop over the very rays that it traced"""
import shlex

from .inputs import place, scene_name, scene_of
from .running import figures_of, run, scratch, table


def bench(options):
    scene = shlex.quote(scene_of(options))
    rows = []
    with scratch() as file:
        placed, captured = file("placed.probe"), file("captured.probe")
        place(options, placed, options.size(64, 4))
        for name, columns in (("light alone", "none"),
                              ("with its error, validity, depth, sky",
                               "sh_error,validity,depth,sky")):
            run(f"probe-capture -q --columns {columns} --rays {options.rays} {options.light}"
                f" -o {captured} {scene} {placed}")
            found = figures_of(options, "bench_rays", scene_of(options), captured, options.runs)
            rows.append((name, found["probes"], found["rays"], f"{found['capture_mrays']:.2f}",
                         f"{found['bare_mrays']:.2f}", f"{found['ratio']:.0%}"))
    table(f"rays of all kinds, one thread: {scene_name(options)}, {options.rays} rays a probe",
          ("what", "probes", "rays", "capture M/s", "bare loop M/s", "of the bare loop"), rows)
