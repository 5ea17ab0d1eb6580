# SPDX-License-Identifier: Apache-2.0
"""reading and writing streams of --probes probes, order 3, with tetrahedra, beside cat"""
import os

from .inputs import big_stream
from .running import medians, run, scratch, table


def bench(options):
    with scratch() as file:
        binary, text = big_stream(file, options.probes), file("big.text.probe")
        run(f"probe-cat --text -o {text} {binary}")
        for name, path in (("binary", binary), ("text", text)):
            # cat to /dev/null hardly touches its bytes; a stage of a pipe has them through a pipe
            ways = {"cat": f"cat {path}",
                    "read (--info)": f"probe-cat --info {path}",
                    "read and write, as it is": f"probe-cat --tables probe,tet {path}",
                    f"{name} to text": f"probe-cat --text {path}",
                    f"{name} to binary": f"probe-cat --binary {path}",
                    "cat | cat": f"sh -c 'cat {path} | cat'"}
            seconds = medians(ways.values(), options.runs)
            megabytes = os.path.getsize(path) / 1e6
            table(f"stream, {name}: {options.probes} probes, {megabytes:.0f} MB",
                  ("what", "s", "MB/s in", "times cat | cat"),
                  [(n, f"{s:.3f}", f"{megabytes / s:.0f}", f"{s / seconds[-1]:.2f}")
                   for n, s in zip(ways, seconds)])
