# SPDX-License-Identifier: Apache-2.0
"""Jobs, which GNU parallel starts one by one, and the directory of what they finished."""
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys

DRIVER = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "sweep")


def load(path):
    try:
        with open(path, encoding="utf-8") as f:
            return json.load(f)
    except (OSError, ValueError):
        return None


def save(path, value):
    with open(f"{path}.{os.getpid()}", "w", encoding="utf-8") as f:
        json.dump(value, f)
    os.replace(f"{path}.{os.getpid()}", path)


# -- one job, as GNU parallel starts it ------------------------------------------------------------

def run(words, stdin, stdout, directory):
    """Runs one command: its status, message, CPU seconds and peak memory. GNU time reads the peak,
    for a child of Python begins with Python's own."""
    note = f"{stdout}.note"
    with open(stdin, "rb") as source, open(stdout, "wb") as target, \
            open(f"{stdout}.err", "w+b") as log:
        process = subprocess.Popen(["time", "-q", "-f", "%M", "-o", note, *words], stdin=source,
                                   stdout=target, stderr=log, cwd=directory)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        log.seek(0)
        said = log.read().decode(errors="replace").strip().splitlines()
    message = [line for line in said if not line.startswith("Try '")]
    with open(note, encoding="utf-8") as f:
        peak = float(f.read().split()[-1] or "nan") / 1024
    os.remove(note)
    os.remove(f"{stdout}.err")
    return {"status": process.returncode,
            "message": re.sub(r"\s+", " ", message[-1]) if message else "",
            "cpu_s": usage.ru_utime + usage.ru_stime, "peak_mb": peak}


def take_sizes(job, temporary, result):
    """Adds what each size command writes, in bytes, and how many rows the bake has."""
    for name, size in job["sizes"].items():
        counted = run(size, job["stdin"], f"{temporary}.size", job["directory"])
        result.setdefault("sizes", {})[name] = os.path.getsize(f"{temporary}.size")
        os.remove(f"{temporary}.size")
        if counted["status"]:
            result.update(status=counted["status"], message=f"{name}: {counted['message']}")
    info = subprocess.run([shutil.which("probe-cat"), "--info", job["stdin"]],
                          capture_output=True, text=True, check=False).stdout
    result["rows"] = {name: int(rows)
                      for name, rows in re.findall(r"(?m)^table (\S+): (\d+) rows", info)}


def do_job(path):
    """A job: words, stdin, directory, and where the output goes; for the truth, the file that the
    command itself writes; for a measure, the sizes to take too. The result's file appears last:
    what has none was not finished."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    job = load(path)
    output, temporary = job["output"], f"{job['output']}.{os.getpid()}"
    words = [w.replace("{output}", temporary) for w in job["words"]]
    stdout = f"{temporary}.out" if job["kind"] == "truth" else temporary
    result = run(words, job["stdin"], stdout, job["directory"])
    if job["kind"] == "truth" and os.path.exists(stdout):
        os.remove(stdout)
    if job["kind"] == "measure" and not result["status"]:
        take_sizes(job, temporary, result)
    if result["status"]:
        if os.path.exists(temporary):
            os.remove(temporary)
    else:
        os.replace(temporary, output)
    save(job["result"], result)


# -- all jobs --------------------------------------------------------------------------------------

class Work:
    """The directory of finished work, and the jobs that are to be done."""

    def __init__(self, directory, jobs, directory_of_commands):
        self.directory, self.jobs, self.where = directory, jobs, directory_of_commands
        os.makedirs(directory, exist_ok=True)

    def file(self, key, suffix):
        return os.path.join(self.directory, key + suffix)

    def finished(self, key):
        result = load(self.file(key, ".json"))
        return result if result and not result["status"] else None

    def do(self, name, jobs, threads=None):
        """Does what is not finished of jobs, {key: job}; returns all results."""
        todo = [key for key in jobs if not self.finished(key)]
        print(f"sweep: {name}: {len(todo)} to do, {len(jobs) - len(todo)} done before",
              file=sys.stderr)
        for key in todo:
            if os.path.exists(self.file(key, ".json")):
                os.remove(self.file(key, ".json"))
            job = {"directory": self.where, "result": self.file(key, ".json"), **jobs[key]}
            save(self.file(key, ".job"), job)
        if todo:
            self.start([self.file(key, ".job") for key in todo], threads or self.jobs)
        for key in todo:
            if os.path.exists(self.file(key, ".job")):
                os.remove(self.file(key, ".job"))
        missing = {"status": 1, "message": "was killed", "cpu_s": math.nan, "peak_mb": math.nan}
        return {key: load(self.file(key, ".json")) or missing for key in jobs}

    @staticmethod
    def start(files, threads):
        """Runs the jobs in these files, so many at once."""
        # setpriv: should this script be killed, parallel starts nothing more.
        command = ["setpriv", "--pdeathsig", "TERM", "parallel", "--will-cite",
                   "--jobs", str(threads)]
        command += ["--bar"] if sys.stderr.isatty() else []
        command += [sys.executable, DRIVER, "--job"]
        parallel = subprocess.Popen(command, stdin=subprocess.PIPE, text=True)
        try:
            parallel.communicate("".join(path + "\n" for path in files))
        except BaseException:  # asked to end: the second TERM ends its jobs too
            for _ in range(2):
                parallel.send_signal(signal.SIGTERM)
            parallel.wait()
            raise
