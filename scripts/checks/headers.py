#!/usr/bin/env python3
"""Every header begins with #pragma once and compiles alone, with the flags of the release build.

A header that is the first thing its own source file includes has been compiled alone with that file: where the object of
the release build is newer than both, it is not compiled again.
"""

import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import subprocess

from common import ROOT, code_of, finish, text_of, tracked

commands = ROOT / "build" / "release" / "compile_commands.json"
if not commands.is_file():
    finish("headers", [("build/release/compile_commands.json", 1, "not there: run make build first")])
ENTRIES = json.loads(commands.read_text())


def words_of(entry):
    """The command from the compiler on, without its input and output."""
    words = shlex.split(entry["command"])
    words = words[next(i for i, word in enumerate(words) if re.search(r"(?:\+\+|cc)(?:-\d+)?$", word)):]
    pairs = list(zip([""] + words, words))
    return [word for before, word in pairs if word not in ("-o", "-c") and before not in ("-o", "-c")]


def flags():
    """Compiler and flags of the library, with the folders of headers of all of its parts."""
    found = []
    for entry in ENTRIES:
        if "/src/isopach/" not in entry["file"]:
            continue
        words = words_of(entry)
        found = found or words
        for before, word in zip(words, words[1:]):
            if before == "-isystem" and word not in found:
                found += [before, word]
    if not found:
        finish("headers", [("build/release/compile_commands.json", 1, "has no file of the library")])
    return found


FLAGS = [word for word in flags() if not re.match(r"-O|-g|-Wpedantic|.*_EXPORTS", word)]


def objects():
    """The objects of the release build of each source file."""
    result = {}
    for entry in ENTRIES:
        output = re.search(r" -o (\S+)", entry["command"])
        if output:
            name = os.path.relpath(entry["file"], ROOT)
            result.setdefault(name, []).append(pathlib.Path(entry["directory"]) / output.group(1))
    return result


OBJECTS = objects()


def compiled_first(name):
    """Whether the build has compiled the header as the first thing in its own source file."""
    source = name.removesuffix(".hpp") + ".cpp"
    built = [path.stat().st_mtime for path in OBJECTS.get(source, []) if path.is_file()]
    if not built or not (ROOT / source).is_file():
        return False
    first = re.match(r'\s*#\s*include\s*"([^"]+)"', code_of(source))
    if first is None or ("src/" + first.group(1) != name and first.group(1) != name):
        return False
    return max(built) > max((ROOT / file).stat().st_mtime for file in (name, source))


def check(name):
    findings = []
    if not re.search(r"^#pragma once$", text_of(name), re.MULTILINE):
        findings.append((name, 1, "no #pragma once"))
    if compiled_first(name):
        return findings
    command = FLAGS + [f"-I{ROOT}", "-fsyntax-only", "-x", "c++", "-"]
    run = subprocess.run(command, input=f'#include "{ROOT / name}"\n', capture_output=True, text=True)
    if run.returncode != 0:
        error = next((line for line in run.stderr.split("\n") if "error:" in line), run.stderr[:200])
        findings.append((name, 1, "does not compile alone: " + error.replace(str(ROOT) + "/", "")))
    return findings


names = [name for name in tracked("src/*.hpp", "cli/*.hpp", "tests/*.hpp", "bench/*.hpp")]
with concurrent.futures.ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
    found = [finding for findings in pool.map(check, names) for finding in findings]
finish("headers", found)
