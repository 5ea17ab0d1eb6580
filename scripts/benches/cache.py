# SPDX-License-Identifier: Apache-2.0
"""time to an error with and without --cache auto, whose making all share: 200 probes of the Cornell
box or --scene, of which 8 are judged, by the 27 coefficients of irradiance; one thread
"""
import math
import os
import re
import resource
import shlex
import statistics
import subprocess
import sys

from .inputs import place, scene_name, scene_of, text_rows, write_points
from .light import COSINE
from .running import run, scratch, table

GOALS = (0.05, 0.03, 0.01)
JUDGED, ALL = 8, 200
RAYS = tuple(64 * 4 ** i for i in range(7))


def cpu_seconds(command):
    """Runs one command; returns the CPU seconds of it, and what it says."""
    def used():
        of = resource.getrusage(resource.RUSAGE_CHILDREN)
        return of.ru_utime + of.ru_stime
    start = used()
    done = subprocess.run(shlex.split(command), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                          text=True, check=False)
    if done.returncode:
        sys.exit(f"bench: {command}: exit status {done.returncode}\n{done.stderr}")
    return used() - start, done.stderr


def irradiance(path):
    """Of each probe, its 27 coefficients A_l L_lm, colour by colour, from a stream of order 3."""
    return [[COSINE[int((i // 3) ** 0.5)] * row[3 + i] for i in range(27)]
            for row in text_rows(path, "position,sh")]


def error_of(light, truth):
    """The length of what 27 coefficients are off, in lengths of the true ones."""
    off = math.sqrt(sum((a - b) ** 2 for a, b in zip(light, truth)))
    size = math.sqrt(sum(t * t for t in truth))
    return off / size if size > 0 else 0


class Curve:
    """What one way of capturing takes: for each dial, seconds of CPU a probe, and the error of
    each probe, its mean over the seeds."""

    def __init__(self, name, dial):
        self.name, self.dial, self.note = name, dial, ""
        self.points = []

    def add(self, dial, seconds, lights, truth):
        errors = [statistics.mean(error_of(light[i], truth[i]) for light in lights)
                  for i in range(len(truth))]
        self.points.append((dial, max(seconds, 1e-9), errors))

    def seconds_to(self, goal):
        """Seconds until the mean error stays below; None: it never does. Between two, by a
        straight line of logarithms; beyond the first, it says the first."""
        errors = [statistics.mean(e) for _, _, e in self.points]
        seconds = [s for _, s, _ in self.points]
        if errors[-1] > goal:
            return None
        last = max((i for i, e in enumerate(errors) if e > goal), default=None)
        if last is None:
            return seconds[0]
        share = math.log(errors[last] / goal) / math.log(errors[last] / errors[last + 1])
        return seconds[last] * (seconds[last + 1] / seconds[last]) ** share

    def rows(self):
        return [(self.name, f"{dial} {self.dial}", f"{1000 * seconds:.3g}",
                 f"{statistics.mean(errors):.2%}", f"{statistics.median(errors):.2%}",
                 f"{max(errors):.2%}") for dial, seconds, errors in self.points]


HEADER = ("way", "dial", "ms a probe", "mean", "median", "worst")


class Probes:
    """Those that are captured, and those of them that are judged."""

    def __init__(self, options, file):
        self.all, self.judged = file("all.probe"), file("judged.probe")
        place(options, self.all, options.size(ALL, 20))
        at = text_rows(self.all, "position")
        count = min(options.size(JUDGED, 2), len(at))
        self.number = [i * len(at) // count for i in range(count)]
        self.count, self.position = len(at), [at[i] for i in self.number]
        write_points(file("judged.txt"), self.position)
        run(f"probe-place points {file('judged.txt')} -q -o {self.judged}")


def our_curves(options, file, probes):
    """The curves of probe-capture, without and with a cache, and the truth of both."""
    scene, out = shlex.quote(scene_of(options)), file("out.probe")
    capture = f"probe-capture --threads 1 --columns none {options.light} -o {out} {scene}"
    rays = options.size(RAYS, RAYS[:2])
    cpu_seconds(f"{capture} -q --seed 1000 --rays {options.size(1 << 21, 1024)} {probes.judged}")
    truth = irradiance(out)
    empty = statistics.median(cpu_seconds(f"{capture} -q --rays 1 --bounces 0 {probes.judged}")[0]
                              for _ in range(options.size(3, 1)))
    plain, cached = Curve("probe-capture", "rays"), Curve("with --cache auto", "rays")
    plain.note = f"opening the scene {empty:.2f} s"
    for number in rays:
        # of many probes, seconds of few rays are told well; those of many rays do with the judged
        many = number <= options.size(16384, number)
        for curve in (plain, cached) if many else (plain,):
            cache = "--cache auto" if curve is cached else ""
            seconds, lights = [], []
            for seed in range(1, options.runs + 1):
                took, says = cpu_seconds(f"{capture} {cache} --rays {number} --seed {seed}"
                                         f" {probes.all if many else probes.judged}")
                light = irradiance(out)
                seconds.append((took - empty) / len(light))
                lights.append([light[i] for i in probes.number] if many else light)
            curve.add(number, statistics.median(seconds), lights, truth)
            told = re.search(r"cache: (.*)", says)
            if curve is cached and told:
                curve.note = f"at {number} rays, {told[1]}"
    return plain, cached, truth


def goal_rows(curves):
    """Seconds to each goal, of each way."""
    rows = []
    for curve in curves:
        reached = [curve.seconds_to(goal) for goal in GOALS]
        rows.append((curve.name, *("not reached" if s is None else f"{1000 * s:.3g}"
                                   for s in reached)))
    return rows


def show(name, options, probes, curves):
    table(f"{name}: {scene_name(options)}, {len(probes.number)} probes,"
          f" {options.runs} seeds, error of the 27 coefficients of irradiance, a probe's mean;"
          f" caches are of {probes.count} probes, which share what they take",
          HEADER, [row for curve in curves for row in curve.rows()])
    table(f"{name}: {scene_name(options)}, milliseconds of CPU a probe to a mean error of",
          ("way", *(f"{g:.0%}" for g in GOALS)), goal_rows(curves))
    for curve in curves:
        if curve.note:
            print(f"  {curve.name}: {curve.note}")


def bench(options):
    with scratch() as file:
        probes = Probes(options, file)
        plain, cached, _ = our_curves(options, file, probes)
    show("cache", options, probes, (plain, cached))
