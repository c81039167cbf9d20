#!/usr/bin/env python3
"""Words that have no place, or one place only: printing, threads, GDAL, disabled tests, unfinished work, paths of a machine."""

import re

from common import KEY, KEY_TABLE, code_of, finish, literals, matches, option_keys, text_of, tracked

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

# The library knows no command line: messages carry the key of an option, "@max-edge" (base/option_key.hpp), and the
# command line spells it. A word behind -- that is none of its options is a property of a style sheet.
keys = option_keys()
options = {word for name in tracked("cli/*.cpp", "cli/*.hpp") for _, inside in literals(name)
           for word in re.findall(r"(?<![\w-])--([a-z][a-z0-9-]*)", inside)}
STYLE = {"media", "page", "keyframes"}  # what stands behind an @ in a style sheet
named = set()
for name in tracked("src/*.cpp", "src/*.hpp"):
    for line, inside in literals(name):
        for word in re.findall(r"--([a-z][a-z0-9-]*)", inside):
            if word in options or word in keys:
                found.append((name, line, f"the library spells no option: write '@{word}' instead of '--{word}'"))
        as_read = {match.start(): match.group(1) for match in KEY.finditer(inside)}
        for match in re.finditer(r"@([a-z][a-z0-9-]*)", inside):
            word = match.group(1)
            if word in STYLE and word not in keys:
                continue
            # "@start-{}": the rest of the key is put in at run time.
            several = {key for key in keys if inside.startswith("{", match.end()) and key.startswith(word)}
            named |= several or {word}
            if word not in keys and not several:
                found.append((name, line, f"'@{word}' names no key: add it to option_keys of {KEY_TABLE}"))
            elif as_read.get(match.start()) != word:
                found.append((name, line, f"'@{word}' is not read as a key beside the characters around it"))
for key in keys:
    if key not in named:
        found.append((KEY_TABLE, 1, f"no message names '@{key}': drop it from option_keys"))

# What a result says in words is spelled where it is shown: in report/ by message() and messages() of values.hpp and
# message_text() of words.hpp.
SAID = r"[.>](?:warnings|weak_directions|reason|skipped)\b(?!\.empty)(?!\()|\bsentence\("
for name in tracked("src/isopach/report/*.cpp", "src/isopach/report/*.hpp"):
    lines = code_of(name).split("\n")
    for line, code in enumerate(lines, 1):
        for match in re.finditer(SAID, code):
            passed_to = code[:match.start()]
            if re.search(r"\bfor \(", passed_to):
                passed_to = code + "".join(lines[line:line + 1])
            if not re.search(r"\bmessages?(?:_text)?\(", passed_to):
                found.append((name, line, f"'{match.group()}' is shown unspelled: see message_text() of report/page/words.hpp"))

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
