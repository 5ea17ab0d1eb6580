# SPDX-License-Identifier: Apache-2.0
"""capture on 1, 2, ... threads: the speed-up, beside that of as many processes that share
nothing
"""
import os
import shlex

from .inputs import place, scene_name, scene_of
from .running import medians, scratch, table


def bench(options):
    scene = shlex.quote(scene_of(options))
    rays = options.size(8192, 16)
    with scratch() as file:
        placed = file("placed.probe")
        place(options, placed, options.size(500, 20))
        counts = [n for n in (1, 2, 4, 8, 16, 32, 64) if n <= len(os.sched_getaffinity(0))]
        capture = f"probe-capture -q --columns none --rays {rays} {options.light} {scene} {placed}"
        alone = [f"{capture} --threads {n}" for n in counts]
        # what the machine gives: n captures of one thread at once, each of all the probes
        beside = ["sh -c '" + " & ".join([f"{capture} --threads 1 >/dev/null"] * n) + " & wait'"
                  for n in counts]
        seconds = medians(alone + beside, options.runs)
    one, many = seconds[:len(counts)], seconds[len(counts):]
    rows = []
    for n, s, m in zip(counts, one, many):
        gained, given = one[0] / s, n * many[0] / m
        rows.append((n, f"{s:.2f}", f"{gained:.2f}", f"{gained / n:.0%}", f"{given:.2f}",
                     f"{gained / given:.0%}"))
    table(f"capture on threads: {scene_name(options)}, {rays} rays",
          ("threads", "s", "speed-up", "per thread", "processes give", "of that"), rows)
