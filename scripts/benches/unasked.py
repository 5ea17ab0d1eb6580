# SPDX-License-Identifier: Apache-2.0
"""what a scene pays for what it does not need (names to leave out, hints, frames, colours of
vertices, the look for what makes all black): user seconds of reading the Cornell box or --scene
and of capture in it, one thread; with every name kept by --only; and as ratios to the build of
another commit, where --beside DIR names one
"""
import os
import resource
import shlex
import statistics

from .inputs import place, scene_name, scene_of
from .running import run, scratch, table


def user_seconds(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    run(command)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def bench(options):
    scene = shlex.quote(scene_of(options))
    programs = os.path.join(options.build, "src", "probe-capture")
    builds = [shlex.quote(programs)]
    if options.beside:
        other = os.path.join(os.path.abspath(options.beside), "src", "probe-capture")
        builds.append(shlex.quote(other))
    with scratch() as file:
        placed, one = file("placed.probe"), file("one.probe")
        place(options, placed, options.size(64, 4))
        place(options, one, 1)
        capture = f"-q --threads 1 --columns none {options.light} -o {file('out.probe')} {scene}"
        asked = (("reading", f"--rays 1 --bounces 1 {capture} {one}"),
                 ("reading, --only '*'", f"--only '*' --rays 1 --bounces 1 {capture} {one}"),
                 (f"64 probes, {options.rays} rays each",
                  f"--rays {options.rays} {capture} {placed}"))
        commands = [(f"{build} {words}" if number == 0 or "--only" not in words else None)
                    for _, words in asked for number, build in enumerate(builds)]
        seconds = [[] for _ in commands]
        for turn in range(options.runs + 1):  # the first is not counted
            for found, command in zip(seconds, commands):
                took = user_seconds(command) if command else None
                if turn and command:
                    found.append(took)
    middle = [statistics.median(s) if s else None for s in seconds]
    rows = []
    for i, (name, _) in enumerate(asked):
        here = middle[i * len(builds)]
        other = middle[i * len(builds) + 1] if options.beside else None
        rows.append((name, f"{here:.3f}", f"{other:.3f}" if other else "-",
                     f"{here / other:.3f}" if other else "-"))
    table(f"unasked: {scene_name(options)}, one thread, medians of {options.runs} runs",
          ("what", "user s", "beside s", "ratio"), rows)
