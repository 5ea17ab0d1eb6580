# SPDX-License-Identifier: Apache-2.0
"""lookups by discs on 60000 and 110000 points of probe-place poisson, beside the nearest point,
Shepard, and the ray that found the place
"""
import shlex

from .inputs import scene_name, scene_of
from .running import figures_of, run, scratch, table

WAYS = (("discs", "discs"), ("discs, fetched ahead", "discs_fetched"), ("nearest", "nearest"),
        ("Shepard", "shepard"), ("a ray of Embree", "ray"))


def bench(options):
    scene = shlex.quote(scene_of(options))
    figures = []
    with scratch() as file:
        for count in (options.size(60000, 300), options.size(110000, 500)):
            points = file(f"{count}.probe")
            run(f"probe-place poisson -q --count {count} {options.light} -o {points} {scene}")
            figures.append(figures_of(options, "bench_discs", scene_of(options), points,
                                      options.runs))
    names = [f"{f['points']} points" for f in figures]
    rows = [(name, *(cell for f in figures
                     for cell in (f"{f[key]:.3f}", f"{f[key] / f['ray']:.2f}")))
            for name, key in WAYS]
    table(f"discs: {scene_name(options)}, three values at {figures[0]['places']} places that rays"
          " met, without order, one thread, microseconds of CPU a place; making the discs took"
          f" {figures[-1]['made_s']:.2f} s for the last",
          ("what", *(cell for name in names for cell in (name, "times a ray"))), rows)
