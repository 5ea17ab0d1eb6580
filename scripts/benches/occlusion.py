# SPDX-License-Identifier: Apache-2.0
"""ambient occlusion, and with what occluders scatter, against path-traced light of a white sky"""
import math
import shlex

from .inputs import scene_name, scene_of
from .running import output_of, scratch, shell, table


def rows(text):
    """The numbers of a stream's text."""
    lines = text.split("table probe", 1)[1].split("\n")[1:]
    return [[float(n) for n in line.split()] for line in lines if line and line != "end"]


def bench(options):
    scene = shlex.quote(scene_of(options))
    rays = options.size(4096, 16)
    white = "--light-scale 0 --sky 1,1,1"
    with scratch() as file:
        placed = file("placed.probe")
        shell(f"probe-place poisson -q --sky 1,1,1 --count {options.size(400, 8)}"
              f" -o {placed} {scene}")
        lit = rows(output_of("sh", "-c", f"probe-capture -q --text --rays {rays} {white}"
                             f" --columns ao,ao_bounced {scene} {placed} |"
                             " probe-cat --text --columns position,irradiance,ao,ao_bounced"))
    lit = [r for r in lit if not math.isnan(r[-1])]
    off = {"ao": 0.0, "ao_bounced": 0.0}
    mean = 0.0
    for r in lit:
        for c in range(3):
            truth = r[3 + c] / math.pi
            mean += truth
            off["ao"] += (r[6] - truth) ** 2
            off["ao_bounced"] += (r[7 + c] - truth) ** 2
    values = 3 * len(lit)
    table(f"occlusion: {scene_name(options)}, {len(lit)} points, {rays} rays, mean of the sky's"
          f" light {mean / values:.3f}", ("column", "rms error"),
          [(name, f"{math.sqrt(sum_ / values):.4f}") for name, sum_ in off.items()])
