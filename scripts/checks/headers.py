#!/usr/bin/env python3
"""Every header begins with #pragma once and compiles alone, with the flags of the release build."""

import concurrent.futures
import json
import os
import re
import shlex
import subprocess

from common import ROOT, finish, text_of, tracked

commands = ROOT / "build" / "release" / "compile_commands.json"
if not commands.is_file():
    finish("headers", [("build/release/compile_commands.json", 1, "not there: run make build first")])


def flags():
    """Compiler and include flags of the library, taken from its build."""
    for entry in json.loads(commands.read_text()):
        if "/src/isopach/" in entry["file"]:
            words = shlex.split(entry["command"])
            words = [word for word in words if not word.endswith("ccache")]
            keep, skip = [], False
            for word in words:
                if skip:
                    skip = False
                elif word in ("-o", "-c"):
                    skip = True
                else:
                    keep.append(word)
            return keep
    finish("headers", [("build/release/compile_commands.json", 1, "has no file of the library")])


FLAGS = [word for word in flags() if not re.match(r"-O|-g|-Wpedantic|.*_EXPORTS", word)]


def check(name):
    findings = []
    if not re.search(r"^#pragma once$", text_of(name), re.MULTILINE):
        findings.append((name, 1, "no #pragma once"))
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
