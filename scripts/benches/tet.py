# SPDX-License-Identifier: Apache-2.0
"""probe-tet, from stream to stream, beside TetGen alone on the same points in the same order:
random ones from 1e3 to 1e6 (--probes), and a grid of as many
"""
import shlex
import statistics
import subprocess
import time

from .inputs import random_stream
from .running import bench_program, figures_of, run, scratch, table


def peak_of_all(command):
    """The peak memory in MB of a command and its children together, what they share counted once
    (proportional set size)."""
    process = subprocess.Popen(shlex.split(command), stdout=subprocess.DEVNULL)
    peak = 0
    while process.poll() is None:
        total = 0
        try:
            with open(f"/proc/{process.pid}/task/{process.pid}/children") as f:
                children = f.read().split()
        except OSError:  # it has just ended
            children = []
        for pid in [str(process.pid)] + children:
            try:
                with open(f"/proc/{pid}/smaps_rollup") as f:
                    total += sum(int(line.split()[1]) for line in f if line.startswith("Pss:"))
            except OSError:
                pass
        peak = max(peak, total)
        time.sleep(0.002)
    return peak / 1024


def write_stream(path, kind, count):
    if kind == "random":
        random_stream(path, count)
        return
    side = round(count ** (1 / 3))
    run(f"probe-place grid --binary --spacing 1 --clearance 50%"
        f" --bounds 0,0,0,{side},{side},{side} -o {path}")


def bench(options):
    bare = bench_program(options.build, "bench_tetgen")
    counts = [n for n in (1000, 10000, 100000, 1000000) if n <= options.probes]
    rows = []
    with scratch() as file:
        stream, points = file("points.probe"), file("points.raw")
        for kind, count in [("random", n) for n in counts] + [("grid", n) for n in counts[-2:]]:
            write_stream(stream, kind, count)
            run(f"{bare} order {stream} {points}")
            ours, theirs = [], []
            for turn in range(options.runs + 1):
                seconds = run(f"sh -c 'probe-tet -q {stream} | cat >/dev/null'")
                result = figures_of(options, "bench_tetgen", "run", points)
                if turn:
                    ours.append(seconds)
                    theirs.append(result["seconds"])
            own = peak_of_all(f"{bare} run {points}")
            peak = peak_of_all(f"probe-tet -q {stream}")
            s, t = statistics.median(ours), statistics.median(theirs)
            rows.append((f"{kind} {count}", result["cells"], f"{s:.3f}", f"{t:.3f}", f"{s / t:.2f}",
                         f"{peak:.0f}", f"{own:.0f}", f"{peak / own:.2f}" if own else "-"))
    table("probe-tet beside TetGen alone",
          ("probes", "TetGen's cells", "s", "TetGen s", "ratio", "peak MB", "TetGen MB", "ratio"),
          rows)
