# SPDX-License-Identifier: Apache-2.0
"""Keys: what makes a result what it is, as a digest of command lines, files and programs."""
import hashlib
import json
import os
import re
import shutil
import subprocess

STARTS = {"probe-leakfix": ["probe-tet"]}  # programs that run others
# what names other files in a scene's: materials, textures, buffers
NAMES = {".obj": rb"(?m)^\s*mtllib\s+(.*\S)", ".mtl": rb"(?mi)^\s*map_\S+\s(?:.*\s)?(\S+)",
         ".gltf": rb'"uri"\s*:\s*"([^"]*)"'}

cache = {}


def once(function):
    def wrapped(argument, *rest):
        key = (function, argument)
        if key not in cache:
            cache[key] = function(argument, *rest)
        return cache[key]
    return wrapped


@once
def one_thread_option(program):
    text = subprocess.run([program, "--help"], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, check=False).stdout
    return ["--threads", "1"] if "--threads" in text else []


def one_thread(program, words):
    given = any(re.match(r"--threads|-j", w) for w in words)
    if given or not os.path.basename(program).startswith("probe-"):
        return []
    return one_thread_option(program)


@once
def digest_file(path):
    """Of a file, and of those that a scene names: materials, textures, buffers."""
    with open(path, "rb") as f:
        data = f.read()
    digest = hashlib.sha256(data)
    pattern = NAMES.get(os.path.splitext(path)[1].lower())
    for name in sorted(set(re.findall(pattern, data))) if pattern else []:
        name = name.decode(errors="replace").replace("\\", "/")
        named = os.path.join(os.path.dirname(path), name)
        if os.path.isfile(named) and os.path.realpath(named) != os.path.realpath(path):
            digest.update(digest_file(named).encode())
    return digest.hexdigest()


def key_of(sweep, words, *inputs):
    """Of a command line: files count by what is in them, wherever they are."""
    directory = os.path.dirname(os.path.abspath(sweep.path))
    started = STARTS.get(os.path.basename(words[0]), [])
    programs = [words[0]] + [shutil.which(p) or p for p in started]
    parts = [digest_file(p) for p in programs if os.path.isfile(p)] + list(inputs)
    for word in words[1:]:
        path = os.path.join(directory, word)
        parts.append(digest_file(path) if os.path.isfile(path) else word)
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:20]
