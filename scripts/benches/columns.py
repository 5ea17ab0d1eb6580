# SPDX-License-Identifier: Apache-2.0
"""what each column of probe-capture costs over none"""
import shlex

from .inputs import place, scene_name, scene_of
from .running import medians, scratch, table

COLUMNS = ("none", "sh_error", "sh_error,validity,depth,sky", "sh_gradient", "visibility", "ao",
           "rays", "sh_error,validity,depth,sky,sh_gradient,visibility,ao,rays")


def bench(options):
    scene = shlex.quote(scene_of(options))
    rays = options.size(4096, 16)
    with scratch() as file:
        placed, out = file("placed.probe"), file("out.probe")
        place(options, placed, options.size(200, 4))
        seconds = medians([f"probe-capture -q --threads 1 --rays {rays} --columns {columns}"
                           f" {options.light} -o {out} {scene} {placed}" for columns in COLUMNS],
                          options.runs)
    table(f"columns: {scene_name(options)}, {rays} rays, one thread",
          ("columns", "s", "times none"),
          [(c, f"{s:.3f}", f"{s / seconds[0]:.3f}") for c, s in zip(COLUMNS, seconds)])
