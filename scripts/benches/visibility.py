# SPDX-License-Identifier: Apache-2.0
"""ways to keep light from going through walls: none, what cells keep of what they see
(probe-leakfix), octahedral maps of distance, rays, and more probes (probe-leakfix --rounds 4):
error against path-traced truth, what leaks, what it takes"""
import os
import shlex

from .inputs import error_effort, scene_name, scene_of
from .running import figures_of, run, scratch, shell, table

SAY = {"all": "all probes", "kept": "what cells keep", "depth8": "distances, 8 x 8",
       "depth16": "distances, 16 x 16", "rays": "rays"}


def bench(options):
    scene = shlex.quote(scene_of(options))
    with scratch() as file:
        count, rays = options.size((600, 1024), (60, 32))
        baked, more, truth = file("baked"), file("more"), file("truth")
        shell(f"probe-place grid -q --count {count} --inside drop {scene}"
              f" | probe-capture -q --rays {rays} {options.light} {scene} | probe-tet -q"
              f" -o {file('cells')}")
        run(f"probe-leakfix -q -o {baked} {scene} {file('cells')}")
        run(f"probe-leakfix -q --no-sight --rounds {options.size(4, 1)} -o {more} {scene}"
            f" {file('cells')}")
        run(f"probe-error -q {error_effort(options)} --truth {truth} --leak-samples 0 {scene}"
            f" {baked}")
        ways = [(way, baked, name) for way, name in SAY.items()] + [("all", more, "more probes")]
        found = [(name, figures_of(options, "bench_visibility", scene_of(options), stream, way,
                                   truth, options.size(200000, 2000)))
                 for way, stream, name in ways]
        extra = os.path.getsize(more) / os.path.getsize(file("cells"))
    rows = [[name, f"{100 * f['error']:.2f}", f"{100 * f['leak']:.3f}", f"{100 * f['blind']:.2f}",
             f"{f['bytes']:.0f}" if name != "more probes" else f"stream x {extra:.1f}",
             f"{f['lookup']:.2f}", f"{f['jumps']:.2f}"] for name, f in found]
    table(f"visibility: {scene_name(options)}, {count} probes asked for, {rays} rays; shares in %",
          ["way", "error", "leak", "blind", "bytes a probe", "us a lookup", "jumps in 1000 steps"],
          rows)
