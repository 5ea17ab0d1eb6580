# SPDX-License-Identifier: Apache-2.0
"""each way of probe-query --interpolate, with probes that take equal bytes (340 times each of
--counts), against truth at 1000 points of the Cornell box or --scene, in --region; octrees are
refined by light, and near surfaces
"""
import random
import shlex
import statistics

from .inputs import scene_name, scene_of, text_rows, write_points
from .light import percentile, rms
from .octree import octree_of
from .running import run, scratch, shell, table

# Bytes of a probe: its position, its light, its gradient; with cells, of which there are 6.5 each.
POSITION, LIGHT, GRADIENT, CELLS = 24, 108, 324, 6.5 * 32
WITH_CELLS, FREE = POSITION + LIGHT + CELLS, POSITION + LIGHT
# where its probes are, and how many bytes one takes
WAYS = {
    "barycentric": ("grid", WITH_CELLS),
    "gradient": ("grid", WITH_CELLS + GRADIENT),
    "cubic": ("grid", WITH_CELLS + GRADIENT),
    "nearest": ("grid", FREE),
    "shepard": ("grid", FREE),
    "shepard --falloff quadratic": ("grid", FREE),
    "shepard --falloff cubic": ("grid", FREE),
    "trilinear": ("full grid", LIGHT),
    "tricubic": ("full grid", LIGHT),
    "trilinear, octree by light": ("octree by light", FREE),
    "tricubic, octree by light": ("octree by light", FREE),
    "trilinear, octree near surfaces": ("octree", FREE),
    "tricubic, octree near surfaces": ("octree", FREE),
}


def times_of(error, base):
    """How many times the mean of `base` that of `error` is, at the same points, with the 95 %
    interval for other points."""
    draw = random.Random(1)
    sets = [draw.choices(range(len(error)), k=len(error)) for _ in range(1000)]
    found = sorted(sum(error[i] for i in s) / sum(base[i] for i in s) for s in sets)
    return f"{sum(error) / sum(base):.2f} ({found[25]:.2f}-{found[974]:.2f})"


class World:
    """A scene to bake and measure in, with the files that this needs."""

    def __init__(self, options, file):
        self.options, self.file = options, file
        self.scene, self.light = shlex.quote(scene_of(options)), options.light
        self.region = f"--bounds={options.region}"
        self.points, self.truth_rays = options.size(1000, 100), options.size(32768, 64)
        if options.scene:
            numbers = list(map(float, options.region.split(",")))
            low, high, self.bounds = numbers[:3], numbers[3:6], self.region
        else:  # probes fill the whole box
            low, high, self.bounds = [0, 0, 0], [556, 548.8, 559.2], ""
        self.box = ([a + 0.01 * (b - a) for a, b in zip(low, high)],
                    [b - 0.01 * (b - a) for a, b in zip(low, high)])
        self.baked = {}

    def place(self, kind, count, placed):
        if kind.startswith("octree"):
            positions = self.file("positions.txt")
            write_points(positions, octree_of(self.scene, self.light, self.box, count,
                                              "light" in kind, self.file))
            run(f"probe-place points {positions} -q -o {placed}")
        else:
            inside = "--inside keep" if kind == "full grid" else ""
            run(f"probe-place grid -q --count {count} {inside} {self.bounds} -o {placed}"
                f" {self.scene}")

    def bake(self, placed, how, rays, output):
        gradient = ",sh_gradient" if how in ("gradient", "cubic") else ""
        shell(f"probe-capture -q --rays {rays} --columns rays{gradient} {self.light} {self.scene}"
              f" {placed} | probe-tet -q -o {output}")

    def bake_for(self, how, room):
        """The stream of the probes that fit into so many bytes, baked once."""
        kind, size = WAYS[how]
        key = kind, int(room / size)
        if key not in self.baked:
            placed, output = self.file("placed"), self.file(f"{len(self.baked)}.probe")
            self.place(*key, placed)
            self.bake(placed, how, self.options.rays, output)
            self.baked[key] = output
        return self.baked[key]

    def measure(self, how, baked):
        """Of each point: position, error, truth, unseen, outside."""
        truth, points = self.file("truth"), self.file("map")
        run(f"probe-error -q --points {self.points} --paths 0 --leak-samples 0"
            f" --truth-rays {self.truth_rays} --truth {truth} --map {points} {self.region}"
            f" --outside extend --interpolate {how.split(',')[0]} {self.scene} {baked}")
        return text_rows(points, "position,error,truth,unseen,outside")

    def cut_off(self, rows):
        """The error at each point with a probe at each: what order 3 cuts off."""
        positions, placed, own = (self.file(name) for name in ("points.txt", "placed", "own.probe"))
        write_points(positions, [row[:3] for row in rows])
        run(f"probe-place points {positions} -q -o {placed}")
        self.bake(placed, "nearest", self.truth_rays, own)
        return [row[3] for row in self.measure("nearest", own)]


def rows_of(results, own, mean, seen):
    """Of each way: its errors as shares of the mean, at all points; and, less what order 3 cuts
    off, at those seen."""
    parts = {how: ([row[3] / mean for row in rows],
                   [max(rows[i][3] ** 2 - own[i] ** 2, 0) ** 0.5 / mean for i in seen])
             for how, (_, rows) in results.items()}
    for how, (probes, _) in results.items():
        cells = [how, probes]
        for error, base in zip(parts[how], parts["barycentric"]):
            ranked = sorted(error)
            cells += [f"{100 * x:.1f}" for x in (ranked[len(error) // 2], rms(error),
                                                 percentile(ranked, 0.95))]
            cells.append(times_of(error, base))
        yield cells


def bench(options):
    """Each way to interpolate, with as many probes as fit into equal bytes, against the truth of
    probe-error: at all points; and, less what order 3 cuts off, at those that are in the hull and
    see all probes of their cell, whichever row's probes are taken."""
    with scratch() as file:
        world, own = World(options, file), None
        for count in map(int, options.counts.split(",")):
            room, results = WITH_CELLS * count, {}
            world.baked.clear()
            for how in WAYS:
                baked = world.bake_for(how, room)
                results[how] = len(text_rows(baked, "position")), world.measure(how, baked)
            barycentric = results["barycentric"][1]
            own = own or world.cut_off(barycentric)
            mean = statistics.mean(row[4] for row in barycentric)
            seen = [i for i in range(len(own))
                    if not any(rows[i][5] or rows[i][6] for _, rows in results.values())]
            table(f"interpolate: {scene_name(options)}, probes in {room / 1000:.0f} kB,"
                  f" {options.rays} rays each; errors in % of the mean irradiance: at {len(own)}"
                  f" points, {100 / mean * rms(own):.1f} % RMS of it what order 3 cuts off; and,"
                  f" less that, at the {len(seen)} that are in the hull and see all probes of their"
                  " cell; times: barycentric's mean error",
                  ("how", "probes") + 2 * ("median", "RMS", "95th", "times"),
                  list(rows_of(results, own, mean, seen)))
