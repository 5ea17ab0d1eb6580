# SPDX-License-Identifier: Apache-2.0
"""how far irradiance from SH, de-rung SH and other bases is from that of surfaces captured in 32
directions, with the bytes a probe: 48 probes of the Cornell box or --scene
"""
import json
import math
import shlex

from .inputs import place, scene_name, scene_of, text_rows
from .running import bench_program, output_of, run, scratch, table

DIRECTIONS = 32


def write_surfaces(path, positions):
    """A stream of surfaces, in every direction at each position: a spiral of equal steps in z,
    turned by the golden angle."""
    with open(path, "w") as f:
        f.write("#?probe 1\ntable probe position:f64:3 normal:f32:3\n")
        for x, y, up in positions:
            for i in range(DIRECTIONS):
                z = 1 - (2 * i + 1) / DIRECTIONS
                s, phi = math.sqrt(1 - z * z), 2.399963229728653 * i
                f.write(f"{x!r} {y!r} {up!r}"
                        f" {s * math.cos(phi):.9f} {s * math.sin(phi):.9f} {z:.9f}\n")
        f.write("end\n")


def bench(options):
    scene = shlex.quote(scene_of(options))
    with scratch() as file:
        placed, probes, bases, surfaces, truth = (
            file(f"{name}.probe") for name in ("placed", "probes", "bases", "surfaces", "truth"))
        place(options, placed, options.size(48, 4))
        run(f"probe-capture -q --order 6 --rays {options.size(65536, 64)} --columns none"
            f" {options.light} -o {probes} {scene} {placed}")
        run(f"probe-cat -q --basis cube,dice,dice-cubic,ahd -o {bases} {probes}")
        positions = text_rows(placed, "position")
        write_surfaces(surfaces, positions)
        run(f"probe-capture -q --rays {options.size(16384, 64)} --columns irradiance_error"
            f" {options.light} -o {truth} {scene} {surfaces}")
        lines = output_of(bench_program(options.build, "bench_bases"), bases, truth)
    rows = [json.loads(line) for line in lines.splitlines()]
    table(f"bases: {scene_name(options)}, {len(positions)} probes, {DIRECTIONS} directions",
          ("stored as", "bytes", "RMS", "95th", "worst", "below 0"),
          [(r["name"], r["bytes"], *(f"{r[k]:.1%}" for k in ("rms", "p95", "worst", "negative")))
           for r in rows])
