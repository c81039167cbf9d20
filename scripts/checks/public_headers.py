#!/usr/bin/env python3
"""Public headers, as cmake/public_headers.cmake lists them: few, all in isopach/isopach.hpp, installed with what they include
and no other, and none of that needs headers of another library than oneTBB. Programs of examples/ and the documentation include no other."""

import re

from common import ROOT, code_of, finish, text_of, tracked

LIST = "cmake/public_headers.cmake"
ALL = "src/isopach/isopach.hpp"
MOST = 30  # public headers: a program's author has to find his way among them
found = []

public = re.findall(r"[a-z_]+(?:/[a-z_0-9]+)+\.hpp", "".join(re.findall(r"^set\(isopach_public_\w+[^)]*\)", text_of(LIST), re.MULTILINE)))
if not 0 < len(public) <= MOST:
    found.append((LIST, 1, f"{len(public)} public headers, at most {MOST}"))


def included(text, quote='"'):
    return re.findall(r'^\s*#\s*include\s*' + ('"isopach/([^"]+)"' if quote == '"' else "<([^>]+)>"), text, re.MULTILINE)


missing = set(public) ^ (set(included(code_of(ALL))) - {"version.hpp"})
for name in sorted(missing):
    found.append((ALL, 1, f"isopach/{name} stands here or in {LIST}, not in both"))

# What is installed: the public headers and all that they include.
todo, installed = [*public], set()
while todo:
    name = todo.pop()
    if name in installed or name == "version.hpp":
        continue
    installed.add(name)
    if not (ROOT / "src/isopach" / name).is_file():
        found.append((LIST, 1, f"there is no {name}"))
        continue
    code = code_of("src/isopach/" + name)
    todo += included(code)
    for header in included(code, "<"):
        if re.search(r"[/.]", header) and not header.startswith("oneapi/tbb/"):  # the standard's have neither
            found.append(("src/isopach/" + name, 1, f"is installed, and needs <{header}> of another library"))

for name in tracked("examples/*.cpp", "tests/consumer/*.cpp", "docs/*.md", "README.md"):
    for header in included(text_of(name)):
        if header not in (*public, "version.hpp", "isopach.hpp"):
            found.append((name, 1, f"isopach/{header} is not public: {LIST}"))
finish("public_headers", found)
