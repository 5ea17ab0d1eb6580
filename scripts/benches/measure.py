# SPDX-License-Identifier: Apache-2.0
"""probe-error beside the capture that it measures: its truth traced, and at hand"""
import shlex

from .inputs import error_effort, place, scene_name, scene_of
from .running import medians, run, scratch, table


def bench(options):
    scene = shlex.quote(scene_of(options))
    with scratch() as file:
        placed, captured, cells, truth = (file(name) for name in ("placed.probe", "captured.probe",
                                                                  "cells.probe", "truth"))
        place(options, placed, options.size(600, 20))
        rays = options.size("", "--rays 16")
        capture = f"probe-capture -q {rays} {options.light} -o {captured} {scene} {placed}"
        run(capture)
        run(f"probe-tet -o {cells} {captured}")
        measure = f"probe-error -q {error_effort(options)} --truth {truth} {scene} {cells}"
        seconds = medians([capture, f"sh -c {shlex.quote(f'rm -f {truth}; {measure}')}", measure],
                          options.runs)
    names = ("probe-capture", "probe-error, truth traced", "probe-error, truth at hand")
    table(f"measure: {scene_name(options)}, with the scene's reading",
          ("command", "s", "times capture"),
          [(c, f"{s:.2f}", f"{s / seconds[0]:.2f}") for c, s in zip(names, seconds)])
