# SPDX-License-Identifier: Apache-2.0
"""A sweep file: what it says, the runs that it asks for and the commands of each."""
import itertools
import os
import re
import shlex
import shutil
import sys

from .keys import one_thread

LEAST = {"scene": 1, "light": 0, "base": 2, "vary": 2, "cross": 2, "run": 1, "stage": 2, "size": 2,
         "measure": 1}  # words after each
NAMED = ("base", "stage", "size", "vary", "cross")  # their first word is a name
NAME = r"\{([^{}]*)\}"  # in a command


class Sweep:
    """What a sweep file says; each command keeps its line, for messages."""

    def __init__(self, path):
        self.path, self.scene, self.light = path, None, ""
        self.base, self.lines, self.vary, self.cross = {}, {}, {}, {}
        self.stages, self.sizes, self.measure, self.more = [], [], None, []
        try:
            with open(path, encoding="utf-8") as f:
                lines = f.read().splitlines()
        except (OSError, UnicodeDecodeError) as e:
            print(f"sweep: {path}: {getattr(e, 'strerror', None) or 'not text'}", file=sys.stderr)
            sys.exit(2)
        for number, line in enumerate(lines, 1):
            try:
                words = shlex.split(line, comments=True)
            except ValueError as e:
                self.refuse(number, f"{e} in {line.strip()}")
            if words:
                self.read(number, words, line)
        for what, there in (("stage", self.stages), ("measure", self.measure)):
            if not there:
                self.refuse(len(lines), f"expected a {what} before the end, got none")

    def refuse(self, number, message):
        print(f"sweep: {self.path}:{number}: {message}", file=sys.stderr)
        sys.exit(2)

    def dials(self):
        return ", ".join(self.base) or "none"

    def check_words(self, number, key, rest):
        """As many words as there must be, names as names are, and nothing said twice."""
        if key not in LEAST:
            self.refuse(number, f"expected {', '.join(LEAST)}, got {key}")
        most = {"scene": 1, "base": 2}.get(key)
        if len(rest) < LEAST[key] or most and len(rest) > most:
            expected = {"scene": "one word", "base": "two words"}.get(
                key, f"{LEAST[key]} or more words")
            self.refuse(number, f"{key}: expected {expected}, got {len(rest)}")
        if key in NAMED and not re.fullmatch(r"[a-z][a-z0-9-]*", rest[0]):
            self.refuse(number, f"{key}: expected a name of small letters, digits and dashes,"
                        f" got {rest[0]}")
        there = {"scene": self.scene, "measure": self.measure, "light": self.light}.get(key)
        if key == "base":
            there = rest[0] in self.base
        if key in ("stage", "size"):
            there = rest[0] in [s[0] for s in self.stages + self.sizes]
        if there:
            self.refuse(number, f"{' '.join([key] + rest[:1])}: there is one already")

    def read(self, number, words, line):
        key, rest = words[0], words[1:]
        self.check_words(number, key, rest)
        if key in ("vary", "cross"):
            if rest[0] not in self.base:
                self.refuse(number, f"{key} {rest[0]}: expected a base {rest[0]} before it")
            getattr(self, key).setdefault(rest[0], []).extend(rest[1:])
        elif key == "run":
            settings = dict(word.split("=", 1) for word in rest if "=" in word)
            for word in rest:
                if word.split("=", 1)[0] not in self.base or "=" not in word:
                    self.refuse(number, "run: expected DIAL=VALUE of dials before it"
                                f" ({self.dials()}), got {word}")
            self.more.append(settings)
        elif key == "base":
            if rest[0] in ("scene", "light"):
                self.refuse(number, f"base {rest[0]}: the name is taken")
            self.base[rest[0]], self.lines[rest[0]] = rest[1], number
        elif key == "scene":
            self.scene = os.path.join(os.path.dirname(os.path.abspath(self.path)), rest[0])
        elif key == "light":
            self.light = shlex.join(rest)
        elif key == "measure":
            self.measure = ("measure", number, line.split(None, 1)[1])
        else:  # as they are written: dials in them are replaced before they are split into words
            commands = self.stages if key == "stage" else self.sizes
            commands.append((rest[0], number, line.split(None, 2)[2]))

    def check(self):
        """Before anything runs: every name in braces is known, every dial has an effect, every
        program is there."""
        used = set()
        for name, number, command in self.stages + self.sizes + [self.measure]:
            for word in re.findall(NAME, command):
                if word not in self.base and word not in ("scene", "light"):
                    self.refuse(number, f"{name}: expected {{scene}}, {{light}} or a dial"
                                f" ({self.dials()}), got {{{word}}}")
                used.add(word)
        for dial in self.base:
            if dial not in used:
                self.refuse(self.lines[dial], f"base {dial}: no command has {{{dial}}}")
        for settings, _ in self.runs():
            for command in self.stages + self.sizes:
                self.command(command, settings)
            if not self.command(self.measure, settings):
                self.refuse(self.measure[1], "measure: expected a command, got none")

    def runs(self):
        """Settings of all runs, and of each the dials whose table it is in. Base comes first if
        anything varies or nothing does."""
        runs = {}

        def add(settings, dial):
            key = tuple({**self.base, **settings}.items())
            runs.setdefault(key, set()).update([dial] if dial else [])

        if self.vary or not self.cross and not self.more:
            add({}, None)
        for dial, values in self.vary.items():
            for value in values:
                add({dial: value}, dial)
        if self.cross:
            for values in itertools.product(*self.cross.values()):
                add(dict(zip(self.cross, values)), None)
        for settings in self.more:
            add(settings, None)
        return [(dict(settings), dials) for settings, dials in runs.items()]

    def run_name(self, settings):
        """What differs from base, or from a sweep without base runs, what varies."""
        differs = [f"{d} {v or 'none'}" for d, v in settings.items()
                   if v != self.base[d] or d in self.cross]
        return ", ".join(differs) or "base"

    def command(self, command, settings):
        """The words of a command under given settings; none: nothing to do."""
        _, number, text = command
        known = {**settings, "light": self.light}

        def value(match):
            if match[1] == "scene":
                return shlex.quote(self.scene)
            return known.get(match[1], match[0])

        for _ in range(2):  # a value may name the scene
            text = re.sub(NAME, value, text)
        try:
            words = shlex.split(text, comments=True)
        except ValueError as e:
            self.refuse(number, f"{e} in {text}")
        if words:
            program = shutil.which(words[0])
            if not program:
                self.refuse(number, f"{words[0]}: no such program")
            words[1:1] = one_thread(program, words)
            words[0] = program
        return words
