# SPDX-License-Identifier: Apache-2.0
"""Running commands and bench programs, and printing what they took."""
import contextlib
import functools
import json
import os
import resource
import shlex
import statistics
import subprocess
import sys
import tempfile
import time


def run(command, before=()):
    """Runs one command, behind the words of another that runs it; returns wall seconds."""
    start = time.perf_counter()
    status = subprocess.run([*before, *shlex.split(command)], stdout=subprocess.DEVNULL,
                            check=False).returncode
    seconds = time.perf_counter() - start
    if status:
        sys.exit(f"bench: {command}: exit status {status}")
    return seconds


def run_peak(command):
    """The same, with the peak memory in MB. GNU time reads it, for a child of Python begins with
    Python's own."""
    with tempfile.NamedTemporaryFile("r") as note:
        seconds = run(command, ("time", "-q", "-f", "%M", "-o", note.name))
        return seconds, float(note.read()) / 1024


def user_seconds(command):
    """Runs one command; returns the user seconds of it and of what it ran: what others do on the
    machine is not in them, but for the caches."""
    start = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    run(command)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - start


def shell(pipe):
    """Runs a pipe, which has to succeed."""
    subprocess.run(["sh", "-c", pipe], check=True)


def output_of(*command):
    """What a command says on standard output."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def medians(commands, runs, seconds_of=run):
    """Median seconds of each command; they take turns, after one run that is not counted."""
    times = [[] for _ in commands]
    for turn in range(runs + 1):
        for i, command in enumerate(commands):
            seconds = seconds_of(command)
            if turn:
                times[i].append(seconds)
    return [statistics.median(t) for t in times]


@functools.lru_cache(None)
def bench_program(build, name):
    """The path of tests/bench/NAME, built before."""
    target = os.path.join("tests", "bench", name)
    # a make that runs this, as the test suite's does, has nothing to say to that one
    free = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    subprocess.run(["make", "-s", "-C", build, target], env=free, stdout=subprocess.DEVNULL,
                   check=True)
    return os.path.join(build, target)


def figures_of(options, name, *arguments):
    """The figures that a bench program prints: one object of JSON."""
    return json.loads(output_of(bench_program(options.build, name), *map(str, arguments)))


@contextlib.contextmanager
def scratch():
    """A temporary directory, as a function: the path of a file in it, by name."""
    with tempfile.TemporaryDirectory() as directory:
        yield functools.partial(os.path.join, directory)


def table(title, header, rows):
    print(f"\n{title}")
    widths = [max(len(str(r[i])) for r in [header] + rows) for i in range(len(header))]
    for row in [header] + rows:
        print("  " + "  ".join(str(c).ljust(w) for c, w in zip(row, widths)).rstrip())
