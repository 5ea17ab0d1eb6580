# SPDX-License-Identifier: Apache-2.0
"""the same beside Cycles (Debian's blender) at the same probes, each against its own converged
light; --plots DIR writes a table and a picture. Light: emitters, a --sky of a colour, suns
"""
import json
import os
import shlex
import shutil
import statistics
import subprocess
import sys

from .cache import GOALS, Curve, Probes, error_of, our_curves, show
from .inputs import scene_name, scene_of
from .running import scratch

SAMPLES = (1, 4, 16, 64, 256)
CONVERGED = 4096
SIZE = 32  # of pictures, in pixels


def light_of(options):
    """The sky and the suns of --light; None: there is what Cycles is not told."""
    sky, suns = [0, 0, 0], []
    words = shlex.split(options.light)
    for name, value in zip(words[::2], words[1::2]):
        try:
            numbers = [float(x) for x in value.split(",")]
        except ValueError:
            return None
        if name == "--sky" and len(numbers) == 3:
            sky = numbers
        elif name == "--sun" and len(numbers) == 6:
            suns.append(numbers)
        else:
            return None
    return None if len(words) % 2 else (sky, suns)


def rendered(options, file, probes):
    """What Blender tells of the probes (blender_light.py)."""
    sky, suns = light_of(options)
    samples = options.size(SAMPLES, SAMPLES[:2])
    runs = [(options.size(CONVERGED, 16), 1000)]
    runs += [(n, seed) for n in samples for seed in range(1, options.runs + 1)]
    with open(file("job.json"), "w") as f:
        json.dump({"scene": os.path.abspath(scene_of(options)), "points": probes.position,
                   "sky": sky, "suns": suns, "threads": 1, "size": options.size(SIZE, 8),
                   "runs": runs}, f)
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "blender_light.py")
    done = subprocess.run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "-P",
                           script, "--", file("job.json"), file("light.json")],
                          capture_output=True, text=True, check=False)
    if done.returncode or not os.path.exists(file("light.json")):
        sys.exit(f"bench: blender: exit status {done.returncode}\n{done.stdout}{done.stderr}")
    with open(file("light.json")) as f:
        return json.load(f)


def cycles_curve(told):
    truth = [p["light"] for p in told["runs"][0]["points"]]
    curve = Curve("Cycles", "samples a pixel")
    by_samples = {}
    for r in told["runs"][1:]:
        by_samples.setdefault(r["samples"], []).append(r["points"])
    for samples, runs in by_samples.items():
        seconds = statistics.median(statistics.mean(p["s"] for p in points) for points in runs)
        curve.add(samples, seconds - told["empty_s"],
                  [[p["light"] for p in points] for points in runs], truth)
    curve.note = (f"loading the scene and making ready {told['load_s']:.2f} s, and"
                  f" {1000 * told['empty_s']:.1f} ms a picture")
    return curve, truth


def write_tsv(path, curves):
    with open(path, "w") as f:
        f.write("way\tdial\tseconds\tmean\tmedian\tworst\n")
        for curve in curves:
            for dial, seconds, errors in curve.points:
                f.write(f"{curve.name}\t{dial}\t{seconds:.6g}\t{statistics.mean(errors):.6g}\t"
                        f"{statistics.median(errors):.6g}\t{max(errors):.6g}\n")


def draw(path, title, curves):
    """Error against time, by gnuplot: the mean as a line, from the median to the worst as a bar."""
    data, lines = [], []
    for i, curve in enumerate(curves):
        rows = "".join(f"{1000 * s:.6g} {100 * statistics.mean(e):.6g}"
                       f" {100 * statistics.median(e):.6g} {100 * max(e):.6g}\n"
                       for _, s, e in curve.points)
        data.append(f"$c{i} << END\n{rows}END\n")
        colour = ("d95f02", "2166ac", "1b7837")[i % 3]
        lines += [f"$c{i} using 1:2 with linespoints lw 2 pt 7 lc rgb '#{colour}'"
                  f" title '{curve.name}, mean'",
                  f"$c{i} using 1:4 with lines dt 2 lc rgb '#{colour}' title 'worst'"]
    goals = [f"set arrow from graph 0, first {100 * g} to graph 1, first {100 * g} nohead dt 3"
             for g in GOALS]
    text = "\n".join(["set terminal pngcairo size 1000,700 font 'DejaVu Sans,12'",
                      f"set output '{path}'", "set logscale xy", f"set title '{title}' noenhanced",
                      "set xlabel 'milliseconds of CPU a probe'",
                      "set ylabel 'error of irradiance, %'", "set key bottom left", "set grid",
                      *goals, *data, "plot " + ", \\\n  ".join(lines), "unset output", ""])
    subprocess.run(["gnuplot"], input=text, text=True, check=True)


def bench(options):
    if not shutil.which("blender"):
        print("bench: cycles: skipped: there is no blender (Debian's package)", file=sys.stderr)
        return
    if not light_of(options):
        print("bench: cycles: skipped: of --light, Cycles is told a --sky of a colour and suns"
              " alone", file=sys.stderr)
        return
    if options.plots and not shutil.which("gnuplot"):
        sys.exit("bench: --plots needs gnuplot (scripts/setup installs it)")
    with scratch() as file:
        probes = Probes(options, file)
        cycles, converged = cycles_curve(rendered(options, file, probes))
        plain, cached, truth = our_curves(options, file, probes)
    curves = (cycles, plain, cached)
    show("cycles", options, probes, curves)
    apart = statistics.mean(error_of(a, b) for a, b in zip(converged, truth))
    print(f"  the two programs' converged light is {apart:.2%} apart in the mean")
    for curve in (plain, cached):
        ratios = []
        for goal in GOALS:
            ours, theirs = curve.seconds_to(goal), cycles.seconds_to(goal)
            ratios.append("-" if ours is None or theirs is None else f"{theirs / ours:.2f}")
        print(f"  Cycles takes {', '.join(ratios)} times as long as {curve.name} to "
              + ", ".join(f"{g:.0%}" for g in GOALS))
    if options.plots:
        os.makedirs(options.plots, exist_ok=True)
        base = os.path.join(options.plots, "cycles-" + os.path.splitext(scene_name(options))[0])
        write_tsv(base + ".tsv", curves)
        draw(base + ".png", f"{scene_name(options)}: error against time", curves)
