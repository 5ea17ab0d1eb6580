# SPDX-License-Identifier: Apache-2.0
"""Pictures of a sweep, by gnuplot: error against time, bytes and probes."""
import os
import re
import subprocess
import sys

from .advice import COSTS, amount, front

COLOURS = ["1b7837", "2166ac", "d95f02", "7570b3", "8c510a", "4d4d4d", "e7298a", "66a61e"]
STYLE = ["set grid xtics ytics lt 1 lw 1 lc rgb '#e0e0e0'", "set rmargin at screen 0.58",
         "set bmargin 4", "set key at screen 0.60,screen 0.02 left bottom Left reverse vertical"
         " samplen 2 noenhanced"]


def quote(text):
    return '"' + re.sub(r'[\\"]', " ", text) + '"'


def block(name, rows, cost):
    """Data of gnuplot: cost, error, the ends of its interval, number."""
    lines = []
    for i, r in enumerate(rows, 1):
        error = r["error"]
        low, high = max(r.get("error_low", error), error / 10), r.get("error_high", error)
        lines.append(f"{r[cost]:.9g} {error:.9g} {low:.9g} {high:.9g} {i}\n")
    return f"${name} << END\n" + "".join(lines) + "END\n"


def tick(x):
    for unit, size in (("M", 1e6), ("k", 1e3)):
        if x >= size:
            return f"{x / size:g} {unit}"
    return f"{x:g}"


def axis_range(letter, values):
    """Range and tics of a logarithmic axis."""
    low, high = min(values) / 1.4, max(values) * 1.4
    digits = (1, 2, 3, 5, 7) if high < 30 * low else (1, 2, 5) if high < 1e5 * low else (1,)
    tics = [d * 10.0 ** e for e in range(-12, 13) for d in digits if low <= d * 10.0 ** e <= high]
    named = ", ".join(f"{quote(tick(t))} {t:.9g}" for t in tics)
    return [f"set {letter}range [{low:.9g}:{high:.9g}]", f"set {letter}tics ({named})"]


def front_labels(best, cost, scale, unit):
    """The settings on the front, by number, beside the picture."""
    labels = [f"On the Pareto front: settings, error, {COSTS[cost][0]}"]
    for i, row in enumerate(best, 1):
        figure = {"cpu_s": f"{row['cpu_s']:.3g} s", "bytes": amount(row["bytes"]),
                  "probes": str(row["probes"])}[cost]
        labels.append(f"{i:2d}  {row['run']}:  {row['error'] * scale:.3g}{unit}, {figure}")
    step = min(0.033, 0.6 / len(labels))
    size = 11 if step > 0.02 else 8
    return [f"set label {i + 1} {quote(text)} at screen 0.60,{0.95 - i * step:.4f}"
            f" font ',{size}' noenhanced" for i, text in enumerate(labels)]


def draw(path, terminal, commands):
    text = "\n".join([f"set terminal {terminal} size 1400,800 font 'DejaVu Sans,12'",
                      f"set output {quote(path + '.part')}", *commands, "unset output", ""])
    drawn = subprocess.run(["gnuplot"], input=text, text=True, stderr=subprocess.PIPE, check=False)
    if drawn.returncode:
        sys.exit(f"sweep: gnuplot: {drawn.stderr.strip()}")
    os.replace(path + ".part", path)


def plot(sweep, rows, cost, options):
    """One picture, twice: the runs, a line for each dial, and the front, whose settings stand
    beside it by number."""
    name, axis = COSTS[cost]
    best = front(rows, cost)
    relative = "_relative" in options.measure
    share = options.measure.split(":")[0] in ("error", "bad", "error_seen", "bad_seen", "unseen")
    scale, unit = (100, " %") if relative or share else (1, "")
    title = f"{os.path.basename(sweep.scene)}: error against {name}"
    measured = options.measure + (", % of the mean irradiance" if relative else
                                  ", %" if share else "")
    script = ["set encoding utf8", "set logscale xy", f"set title {quote(title)} noenhanced",
              f"set xlabel {quote(axis)} noenhanced", f"set ylabel {quote(measured)} noenhanced",
              *STYLE]
    goal = options.error * scale if options.error else None
    errors = [r["error"] * scale for r in rows]
    if goal and 3 * goal > min(errors):
        errors.append(goal)
    script += axis_range("x", [r[cost] for r in rows]) + axis_range("y", errors)
    script += front_labels(best, cost, scale, unit)
    if goal:  # where it is outside of the picture, it is cut off
        script.append(f"set arrow from graph 0, first {goal:.9g} to graph 1, first {goal:.9g}"
                      " nohead dt 2 lc rgb '#606060'")
    data = [block("all", rows, cost), block("front", best, cost)]
    y = f"($2*{scale})"
    lines = [f"$all using 1:{y} with points pt 7 ps 0.5 lc rgb '#b0b0b0' title 'runs'"]
    for i, dial in enumerate(sweep.vary):
        series = sorted((r for r in rows if dial in r["dials"] or r["settings"] == sweep.base),
                        key=lambda r: (r[cost], r["error"]))
        if len(series) > 1:
            data.append(block(f"dial{i}", series, cost))
            lines.append(f"$dial{i} using 1:{y} with linespoints lw 1 pt 7 ps 0.5"
                         f" lc rgb '#{COLOURS[i % len(COLOURS)]}' title {quote(dial)}")
    lines += [f"$front using 1:{y}:($3*{scale}):($4*{scale}) with yerrorbars pt 0 lw 1"
              " lc rgb '#e0a0a0' title '95 % interval'",
              f"$front using 1:{y} with linespoints lw 2.5 pt 7 ps 0.9 lc rgb '#c00000'"
              " title 'Pareto front'",
              f"$front using 1:{y}:5 with labels offset 0.9,0.8 textcolor rgb '#c00000' notitle"]
    for terminal in ("pngcairo", "svg background rgb 'white'"):
        draw(os.path.join(options.output, f"{name}.{terminal[:3]}"), terminal,
             [*script, *data, "plot " + ", \\\n  ".join(lines)])
