# SPDX-License-Identifier: Apache-2.0
"""64 probes of the Cornell box or --scene, decimated to shares of its triangles: seconds of
decimation, of making the acceleration structure and of capture on one thread, and how far the
light is from the whole scene's
"""
import shlex
import statistics

from .inputs import place, scene_name, scene_of
from .light import captured_light, percentile, relative_errors, rms
from .running import figures_of, run, scratch, table

SHARES = (1, 0.5, 0.25, 0.1)


def bench(options):
    scene = shlex.quote(scene_of(options))
    many_rays = options.size(100000, 256)
    with scratch() as file:
        placed, many = file("placed.probe"), file("many.probe")
        timed = [file(f"{share}.probe") for share in SHARES]
        place(options, placed, options.size(64, 4))
        capture = f"probe-capture -q --columns rays {options.light}"
        for share, path in zip(SHARES, timed):
            run(f"{capture} --decimate {share} --rays {options.rays} -o {path} {scene} {placed}")
        found = [[] for _ in SHARES]
        for _ in range(options.runs):
            for path, of_share in zip(timed, found):
                of_share.append(figures_of(options, "bench_rays", scene_of(options), path, 1))

        def light_of(dials):
            run(f"{capture} {dials} --rays {many_rays} -o {many} {scene} {placed}")
            return captured_light(many)[0]

        truth = light_of("--seed 1000")
        whole = statistics.median(f["capture_s"] for f in found[0])
        rows = []
        for share, of_share in zip(SHARES, found):
            light = light_of(f"--decimate {share}")
            errors = relative_errors(light, truth)
            bias = sum(a[0] - b[0] for a, b in zip(light, truth)) / sum(b[0] for b in truth)
            decimate, build, seconds, rate = (
                statistics.median(f[k] for f in of_share)
                for k in ("decimate_s", "build_s", "capture_s", "capture_mrays"))
            rows.append((share, of_share[0]["triangles"], f"{decimate:.2f}", f"{build:.3f}",
                         f"{rate:.2f}", f"{seconds / whole:.2f}", f"{rms(errors):.2%}",
                         f"{percentile(errors, 0.95):.2%}", f"{errors[-1]:.2%}", f"{bias:+.2%}"))
    table(f"decimate: {scene_name(options)}, {len(truth)} probes, one thread, {options.rays} rays a"
          f" probe; error at {many_rays} rays, of 1: its noise",
          ("share", "triangles", "decimate s", "build s", "M rays/s", "capture, times 1", "RMS",
           "95th", "worst", "mean"), rows)
