# SPDX-License-Identifier: Apache-2.0
"""Octrees of probes: one around a sphere, and ones that follow the light or the surfaces of a
scene. A cell is its lowest corner, in whole units, and its size."""
import functools
import itertools
import math

from .inputs import captured_under_sky, text_rows, write_points
from .light import captured_light
from .running import run, shell


def nodes(cell, parts):
    """The corners of a cell's so many parts each way."""
    x, size = cell
    return [tuple(u + i * size // parts for u, i in zip(x, at))
            for at in itertools.product(range(parts + 1), repeat=3)]


def children(cell):
    x, size = cell
    return [(tuple(u + size // 2 * i for u, i in zip(x, at)), size // 2)
            for at in itertools.product(range(2), repeat=3)]


def samples(cell):
    """Nine places in a cell: its middle, and those of its children."""
    x, size = cell
    return [tuple(u + size // 2 for u in x)] + [
        tuple(u + size // 4 * (1 + 2 * i) for u, i in zip(x, at))
        for at in itertools.product(range(2), repeat=3)]


def octree_in_cube(file, probes):
    """A stream of at most so many probes at the corners of an octree in the unit cube, cut where a
    sphere passes, under a sky; and how many there are."""
    deep, found = 1 << 10, set()
    leaves = [((0, 0, 0), deep)]
    while len(found) <= probes and leaves[0][1] > 1:
        last, smaller = found, []
        found = set(last)
        for cell in leaves:
            x, size = cell
            middle = math.dist(x, 3 * [deep / 2 - size / 2]) / deep
            if abs(middle - 0.4) * deep > 0.9 * size and size < deep:
                continue
            found.update(nodes(cell, 2))
            smaller += children(cell)
        leaves = smaller
    points, out = file("octree.txt"), file("octree.probe")
    write_points(points, [[u / deep for u in x] for x in sorted(last)])
    shell(f"{captured_under_sky(points, file)} | probe-cat --binary -o {out}")
    return out, len(last)


class Cutting:
    """What the light of a scene says about where an octree in its box [low, high] is to be cut."""
    DEEP = 1 << 12  # units of a root cell

    def __init__(self, scene, light, box, probes, by_light, file):
        self.scene, self.light, self.by_light, self.file = scene, light, by_light, file
        self.low, high = box
        step = min(b - a for a, b in zip(self.low, high)) / 2
        self.roots = [max(1, round((b - a) / step)) for a, b in zip(self.low, high)]
        self.root = [(b - a) / n for a, b, n in zip(self.low, high, self.roots)]
        # spacing of as many on a grid: nearer surfaces count as that near
        volume = math.prod(b - a for a, b in zip(self.low, high))
        self.even = (volume / probes) ** (1 / 3)
        self.known = {}  # of a place: whether it is free, how far surfaces are, its light

    def place(self, x):
        """In the scene's coordinates."""
        return [a + r * u / self.DEEP for a, r, u in zip(self.low, self.root, x)]

    def learn(self, cells):
        """Captures the places of cells that are not known yet."""
        wanted = {s for c in cells for s in samples(c) + (nodes(c, 1) if self.by_light else [])}
        places = sorted(wanted - self.known.keys())
        positions, placed, seen = (self.file(f"octree.{name}")
                                   for name in ("txt", "placed", "seen"))
        write_points(positions, map(self.place, places))
        run(f"probe-place points {positions} -q -o {placed}")
        rays = "--rays 256" if self.by_light else "--rays 64 --bounces 0"
        run(f"probe-capture -q {rays} --columns validity,depth,rays {self.light} -o {seen}"
            f" {self.scene} {placed}")
        lights = captured_light(seen)[0] if self.by_light else places
        of_probes = text_rows(seen, "position,validity,depth")
        for x, (*_, validity, depth), light in zip(places, of_probes, lights):
            self.known[x] = validity > 0.5, depth, light

    @functools.lru_cache(None)
    def need(self, cell):
        """How much a cell that is known needs to be cut."""
        size = cell[1]
        free = [(i, self.known[s]) for i, s in enumerate(samples(cell)) if self.known[s][0]]
        if not self.by_light:
            return max((size / max(depth, self.even) for _, (_, depth, _) in free), default=0)
        corners = [self.known[n][2] for n in nodes(cell, 1)]
        square = 0
        for i, (_, _, light) in free:
            # trilinear, of corner a, at sample i
            weights = [0.125 if not i else
                       math.prod((0.25, 0.75)[(a >> k & 1) == (i - 1 >> k & 1)] for k in range(3))
                       for a in range(8)]
            square += sum((sum(w * c[k] for w, c in zip(weights, corners)) - light[k]) ** 2
                          for k in range(9))
        return square * size ** 3


def octree_of(scene, light, box, probes, by_light, file):
    """Positions of at most `probes` probes, the corners of an octree's cells, which is cut in
    rounds, each captured at once. Near surfaces: the cell that is largest beside the harmonic mean
    distance of surfaces from the best of nine places in it, as Ward, Rubinstein and Clear (1988)
    space what they keep. By light: the one with the most squared error of trilinear interpolation
    at the nine, times volume."""
    cutting = Cutting(scene, light, box, probes, by_light, file)
    leaves = [(tuple(i * cutting.DEEP for i in at), cutting.DEEP)
              for at in itertools.product(*map(range, cutting.roots))]
    found = set().union(*(nodes(cell, 1) for cell in leaves))
    cutting.learn(leaves)
    while True:
        leaves.sort(key=cutting.need)
        cut, smaller = 0, []
        while leaves and cut < max(8, probes // 200):
            cell = leaves.pop()
            more = found.union(nodes(cell, 2))
            if len(more) > probes or cell[1] < 8:
                leaves.append(cell)
                break
            found = more
            cut += 1
            smaller += children(cell)
        if not smaller:
            return [cutting.place(x) for x in sorted(found)]
        cutting.learn(smaller)
        leaves += smaller
