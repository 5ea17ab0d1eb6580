# SPDX-License-Identifier: Apache-2.0
"""What parts measure on: scenes, probes placed in them, and streams of random probes."""
import os
import random
import shlex
import statistics
import subprocess

from .running import output_of, run, shell

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def scene_of(options):
    return options.scene or os.path.join(SOURCE, "scenes", "cornell-box.obj")


def scene_name(options):
    """As titles of tables say it."""
    return os.path.basename(shlex.quote(scene_of(options)))


def text_rows(path, columns):
    """The rows of table probe, as lists of numbers."""
    text = output_of("probe-cat", "--text", "--tables", "probe", "--columns", columns, path)
    return [list(map(float, line.split())) for line in text.splitlines()
            if line and line[0] in "-0123456789"]


def write_points(path, points):
    """A file of positions, x y z a line, to the last digit."""
    with open(path, "w") as f:
        f.writelines(" ".join(map(repr, p)) + "\n" for p in points)


def place(options, path, count):
    """Probes for a capture: those of --points; else as many, evenly from a finer grid, of those
    that light reaches: behind the walls of a building it is dark, and nothing is to be learned
    there."""
    scene = shlex.quote(scene_of(options))
    if options.points:
        run(f"probe-place points {shlex.quote(options.points)} -q -o {path} {scene}")
        return
    run(f"probe-place grid --count {16 * count} -q -o {path} {scene}")
    run(f"probe-capture -q --order 1 --columns none --rays 256 {options.light} -o {path}.lit"
        f" {scene} {path}")
    rows = text_rows(f"{path}.lit", "position,sh")
    bright = [sum(row[3:6]) for row in rows]
    lit = [row for row, b in zip(rows, bright) if b > 0.05 * statistics.mean(bright)]
    chosen = [lit[i * len(lit) // min(count, len(lit))] for i in range(min(count, len(lit)))]
    write_points(f"{path}.txt", [row[:3] for row in chosen])
    run(f"probe-place points {path}.txt -q -o {path} {scene}")


def error_effort(options):
    """Options of probe-error: its own but for --short."""
    return options.size("", "--points 20 --truth-rays 16 --paths 1 --leak-samples 2")


def captured_under_sky(points, file):
    """The pipe from a file of points to light under a sky, beside one triangle far off."""
    with open(file("scene.obj"), "w") as f:
        f.write("v -9 -9 -9\nv 9 -9 -9\nv 0 -9 9\nf 1 2 3\n")
    return (f"probe-place points -q {points}"
            f" | probe-capture -q --rays 4 --bounces 1 --sky 1,2,3 {file('scene.obj')}")


def big_stream(file, probes):
    """A stream of random probes in a unit cube under a sky, with its tetrahedra."""
    draw = random.Random(1)
    with open(file("points.txt"), "w") as f:
        for _ in range(probes):
            f.write(f"{draw.random():.6f} {draw.random():.6f} {draw.random():.6f}\n")
    path = file("big.probe")
    shell(f"{captured_under_sky(file('points.txt'), file)} | probe-tet -q -o {path}")
    return path


def random_stream(path, count):
    """A stream of so many random positions in the unit cube, and nothing else."""
    draw = random.Random(1)
    text = "".join(f"{draw.random()!r} {draw.random()!r} {draw.random()!r}\n" for _ in range(count))
    subprocess.run(["probe-cat", "--binary", "-o", path], text=True, check=True,
                   input=f"#?probe 1\ntable probe position:f64:3\n{text}end\n")
