# SPDX-License-Identifier: Apache-2.0
"""64 probes of the Cornell box or --scene: rays, seconds and RMS error, rays fixed and spent by
--error, and the time to 10, 3 and 1 % RMS, for running beside another renderer
"""
import math
import shlex
import statistics

from .inputs import place, scene_name, scene_of
from .light import captured_light, floor_of, percentile, relative_errors, rms
from .running import run, scratch, table

FIXED = (64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768, 65536)
ASKED = (0.1, 0.05, 0.03, 0.02, 0.01)


def time_to(curve, goal):
    """Seconds at which an error is reached, between two measured ones along a straight line of
    logarithms. Those of few rays may be less than none: the time without rays is taken off."""
    for (e0, s0), (e1, s1) in zip(curve, curve[1:]):
        if e0 >= goal >= e1:
            if min(s0, s1) <= 0:
                return f"below {max(s0, s1, 0.001):.3f}"
            share = math.log(e0 / goal) / math.log(e0 / e1) if e0 > e1 > 0 else 0
            return f"{s0 * (s1 / s0) ** share:.3f}"
    return f"below {curve[0][1]:.3f}" if curve[0][0] < goal else f"above {curve[-1][1]:.3f}"


def bench(options):
    scene = shlex.quote(scene_of(options))
    truth_rays = options.size(400000, 1024)
    capture = f"probe-capture -q --columns rays {options.light}"
    with scratch() as file:
        placed, out, many = file("placed.probe"), file("out.probe"), file("many.probe")

        def seconds_of(dials):
            return run(f"{capture} {dials} -o {out} {scene} {placed}")

        place(options, placed, options.size(64, 4))
        run(f"{capture} --seed 1000 --rays {truth_rays} -o {many} {scene} {placed}")
        truth, _ = captured_light(many)
        floor = floor_of(truth) * 0.28209479177387814
        empty = statistics.median(seconds_of("--rays 1 --bounces 0") for _ in range(options.runs))
        ways = [(f"--rays {n}", "") for n in options.size(FIXED, FIXED[:2])]
        ways += [(f"--error {e}", f"--error-floor {floor:.6g}")
                 for e in options.size(ASKED, ASKED[:1])]
        rows, curve = [], []
        for dial, with_it in ways:
            errors, rays, times = [], [], []
            for seed in range(options.runs):
                times.append(seconds_of(f"{dial} {with_it} --seed {seed}") - empty)
                light, spent = captured_light(out)
                errors += relative_errors(light, truth)
                rays += spent
            errors.sort()
            seconds = statistics.median(times)
            rows.append((dial, f"{statistics.mean(rays):.0f}", f"{seconds:.3f}",
                         f"{rms(errors):.2%}", f"{percentile(errors, 0.95):.2%}",
                         f"{errors[-1]:.2%}"))
            if dial.startswith("--rays"):
                curve.append((rms(errors), seconds))
    table(f"error: {scene_name(options)}, {len(truth)} probes, {options.runs} seeds, truth of"
          f" {truth_rays} rays; reading the scene took {empty:.2f} s",
          ("dial", "rays a probe", "s", "RMS", "95th", "worst"), rows)
    print("\n  seconds to an RMS error of "
          + ", ".join(f"{goal:.0%}: {time_to(curve, goal)}" for goal in (0.1, 0.03, 0.01)))
