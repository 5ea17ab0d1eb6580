# SPDX-License-Identifier: Apache-2.0
"""The stages and the measuring of all runs, and the table of what came out.

A run is a row, a dictionary: settings, dials, run (its name), status and key, then what each step
adds."""
import csv
import math
import os
import re
import shlex
import shutil
import sys

from .keys import key_of

# header keys the truth depends on
LIGHT_KEYS = re.compile(r"capture-light|sky|sun|point|spot|emit|albedo-scale|max-albedo|"
                        r"light-scale")


def fails(row, name, result):
    if result["status"] and row["status"] == "ok":
        said = result["message"] or "exit status " + str(result["status"])
        row["status"] = f"{name}: {said}"
    return bool(result["status"])


def bake(sweep, work, rows):
    """All stages of all runs, stage after stage; a row gets the key of its bake."""
    for name, number, command in sweep.stages:
        jobs = {}
        for row in rows:
            words = row["words"] = sweep.command((name, number, command), row["settings"])
            cost = 0 if not words and row["status"] == "ok" else math.nan
            row[f"{name}_cpu_s"] = row[f"{name}_peak_mb"] = cost
            if words and row["status"] == "ok":
                before, row["key"] = row["key"], key_of(sweep, words, row["key"])
                jobs[row["key"]] = {
                    "kind": "stage", "words": words,
                    "stdin": work.file(before, ".probe") if before else os.devnull,
                    "output": work.file(row["key"], ".probe")}
        results = work.do(name, jobs)
        for row in rows:
            if row["status"] == "ok" and row["words"]:
                result = results[row["key"]]
                row[f"{name}_cpu_s"], row[f"{name}_peak_mb"] = result["cpu_s"], result["peak_mb"]
                fails(row, name, result)


def light_of(path, words):
    """What the truth of a bake depends on beside the command that measures: the light in the
    header."""
    light = []
    with open(path, "rb") as f:
        for line in f:
            key = line.split(b" ", 1)[0].decode(errors="replace")
            if key in ("table", "end"):
                break
            if (LIGHT_KEYS.match(key) or key == "capture-bounces" and "--bounces" not in words
                    or key == "scene-key" and "--any-scene" not in words):
                light.append(line.decode(errors="replace"))
    return "".join(sorted(light))


def measure_truth(work, key, group):
    """The truth that a group of runs shares, by all threads, of the first bake that can be
    measured."""
    for row in group:
        words = row["words"]
        threads = [w for i, w in enumerate(words)
                   if w != "--threads" and words[i - 1] != "--threads"]
        job = {"kind": "truth", "words": threads + ["-q", "--tsv", "--truth", "{output}"],
               "stdin": row["stream"], "output": work.file(key, ".truth")}
        result = work.do("truth", {key: job}, 1)[key]
        if not fails(row, "measure", result):
            print(f"sweep: truth: {result['cpu_s']:.1f} CPU s", file=sys.stderr)
            break


def measure_job(sweep, work, row):
    """What measures a bake against its truth, and its sizes."""
    sizes = {"bytes": [shutil.which("probe-cat"), "--binary", "--no-provenance"]}
    sizes.update({f"{s[0]}_bytes": sweep.command(s, row["settings"]) for s in sweep.sizes})
    truth = work.file(row["truth"], ".truth")
    return {"kind": "measure", "words": row["words"] + ["-q", "--tsv", "--truth", truth],
            "stdin": row["stream"], "output": work.file(row["measured"], ".tsv"),
            "sizes": {n: w for n, w in sizes.items() if w}}


def measure(sweep, work, rows):
    """The truth, once for all that share it, by all threads; then every bake against it."""
    groups, jobs = {}, {}
    for row in rows:
        if row["status"] == "ok":
            row["words"] = sweep.command(sweep.measure, row["settings"])
            row["stream"] = work.file(row["key"], ".probe")
            light = light_of(row["stream"], row["words"])
            row["truth"] = key_of(sweep, row["words"], "truth", light)
            groups.setdefault(row["truth"], []).append(row)
    for key, group in groups.items():
        measure_truth(work, key, group)
        for row in group:
            if row["status"] == "ok":
                sizes = shlex.join(w for s in sweep.sizes
                                   for w in sweep.command(s, row["settings"]))
                row["measured"] = key_of(sweep, row["words"], row["key"], key, sizes)
                jobs[row["measured"]] = measure_job(sweep, work, row)
    results = work.do("measure", jobs)
    for row in rows:
        if row["status"] == "ok" and not fails(row, "measure", results[row["measured"]]):
            result = results[row["measured"]]
            row.update(result["sizes"], probes=result["rows"].get("probe", 0),
                       tetrahedra=result["rows"].get("tet", 0),
                       error_cpu_s=result["cpu_s"], error_peak_mb=result["peak_mb"])
            row["cpu_s"] = sum(row[f"{s[0]}_cpu_s"] for s in sweep.stages)
            row["peak_mb"] = max(row[f"{s[0]}_peak_mb"] for s in sweep.stages)
            row["figures"] = figures(work.file(row["measured"], ".tsv"))


def figures(path):
    """What probe-error printed, {column: value as text}."""
    values = {}
    with open(path, encoding="utf-8") as f:
        for line in list(f)[1:]:
            name, part, value, low, high = line.rstrip("\n").split("\t")
            of = "" if part == "all" else ":" + part
            values[name + of] = value
            if low != "nan":
                values[f"{name}_low{of}"], values[f"{name}_high{of}"] = low, high
    return values


def write_tsv(sweep, rows, path):
    columns = ["run", *sweep.base, "status", "stream", "probes", "tetrahedra", "bytes"]
    columns += [f"{s[0]}_bytes" for s in sweep.sizes]
    columns += [f"{s[0]}{what}" for s in sweep.stages for what in ("_cpu_s", "_peak_mb")]
    columns += ["cpu_s", "peak_mb", "error_cpu_s", "error_peak_mb"]
    columns += dict.fromkeys(name for row in rows for name in row.get("figures", {}))
    with open(f"{path}.{os.getpid()}", "w", newline="", encoding="utf-8") as f:
        writer = csv.writer(f, delimiter="\t", lineterminator="\n", quoting=csv.QUOTE_NONE,
                            quotechar=None)
        writer.writerow(columns)
        for row in rows:
            values = {**row["settings"], **row.get("figures", {}),
                      **{k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()}}
            values["stream"] = "nan"
            if "stream" in row:
                values["stream"] = os.path.relpath(row["stream"], os.path.dirname(path))
            writer.writerow([str(values.get(c, "nan")).replace("\t", " ") for c in columns])
    os.replace(f"{path}.{os.getpid()}", path)
