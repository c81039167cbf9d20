#!/usr/bin/env python3
"""Words that have no place, or one place only: printing, threads, GDAL, disabled tests, unfinished work, paths of a machine."""

import re

from common import TOKEN, code_of, finish, matches, text_of, tracked

found = []

# The library does not print.
for name in tracked("src/*.cpp", "src/*.hpp"):
    for line, word in matches(r"\b(?:std::)?(?:cout|cerr|clog|f?printf|f?puts|putchar|perror)\b|\bfmt::print\b", code_of(name)):
        found.append((name, line, f"the library does not print: '{word}'"))

# Threads are named in one place.
THREADS = r"\bstd::(?:thread|jthread|async|mutex|shared_mutex|atomic\w*|condition_variable\w*|call_once|once_flag)\b" \
          r"|\b(?:oneapi::)?tbb::|\bpthread_\w+|#\s*include\s*<(?:thread|mutex|atomic|future|condition_variable|tbb/[^>]*|oneapi/[^>]*)>"
for name in tracked("src/*.cpp", "src/*.hpp"):
    if re.match(r"src/isopach/base/(?:parallel\.[ch]pp|context\.hpp)$", name):
        continue
    for line, word in matches(THREADS, code_of(name)):
        found.append((name, line, f"thread words belong in base/parallel: '{word}'"))

# GDAL is loaded, not linked: only the files that call it through its table see its headers.
for name in tracked("src/*.cpp", "src/*.hpp"):
    if re.match(r"src/isopach/io/gdal[^/]*$", name):
        continue
    for line, word in matches(r"#\s*include\s*<(?:gdal|ogr|cpl_|proj)\w*\.h>", code_of(name)):
        found.append((name, line, f"GDAL's headers belong in io/gdal*: '{word}'"))

# Options belong to the command line. Messages of the library that spell one ("--weight: ...") may become fewer, not more:
# a new message names its subject in words, and the verb that calls adds the option.
OPTIONS_SPELLED = 324
spelled = sum(len(re.findall(r"--[a-z]", token.group())) for name in tracked("src/*.cpp", "src/*.hpp")
              for token in TOKEN.finditer(text_of(name)) if token.group().startswith(('"', 'R"')))
if spelled != OPTIONS_SPELLED:
    why = "the library spells more options" if spelled > OPTIONS_SPELLED else "fewer: lower OPTIONS_SPELLED"
    found.append(("scripts/checks/words.py", 1, f"{why}: {spelled} of them, OPTIONS_SPELLED is {OPTIONS_SPELLED}"))

# No test is switched off. A skip says why, and the one reason is data that is not there.
for name in tracked("tests/*.cpp", "tests/*.hpp", "tests/*.py"):
    text = text_of(name)
    for line, word in matches(r"\bDISABLED_\w*|@unittest\.skip\b|@unittest\.expectedFailure|^\s*//\s*TEST(?:_[FP])?\(|#\s*if\s+0\b", text):
        found.append((name, line, f"disabled test: '{word.strip()}'"))
    for match in re.finditer(r"GTEST_SKIP\(\)([^;]*);", text):
        if not re.search(r"shared|data", match.group(1)):
            line = text.count("\n", 0, match.start()) + 1
            found.append((name, line, "GTEST_SKIP() without a message about shared data"))

# Nothing unfinished, nothing of one machine. (This file spells the words in pieces, so that it passes itself.)
UNFINISHED = r"\b(?:TO" r"DO|FIX" r"ME|X" r"XX)\b"
MACHINE = r"(?<![\w.$}/])/(?:wo" r"rk|ro" r"ot|ho" r"me|tm" r"p)(?:/|\b(?!\w))"
for name in tracked():
    if name.endswith((".png", ".ply", ".las", ".laz")) or "/found/" in name:
        continue
    text = text_of(name)
    for line, word in matches(UNFINISHED, text):
        found.append((name, line, f"unfinished: '{word}'"))
    for line, word in matches(MACHINE, text):
        found.append((name, line, f"a path of one machine: '{word}'"))
finish("words", sorted(set(found)))
