#!/usr/bin/env python3
"""Every warning of the program is listed in docs/use/warnings.md, and every one listed there is one of the program.

A warning is what is pushed to a list called warnings, notes, remarks or weak_directions, or set as a note. Its text is
its string literals with … for what is put in at run time, options spelled as at the command line. A row of the page
begins with a phrase of that text in backticks; tests/cli/warnings_test.py then asks whether the verbs of the row have the options that the text names."""

import re
from collections import namedtuple

from common import TOKEN, finish, for_shell, text_of, tracked

PAGE = "docs/use/warnings.md"
Warning = namedtuple("Warning", "file line text")
Row = namedtuple("Row", "line phrases verbs advice")

PUSH = re.compile(r"(?:\b|_)(?:warnings|notes|remarks|weak_directions|weak|weakly_held|directions)_?(?:\.|->)(?:push_back|emplace_back)\(")
NOTE = re.compile(r"\bnote\s*=\s*(?=[^=])")  # of a layout, in io/
PASSED_ON = re.compile(r"^\(?(?:std::move\()?(?:layout\.)?(?:note|weak|warning|w|text)\)?\)?$|^note\.rfind\(name, 0\)|^\{?\}?$")


def argument(text, begin):
    """From behind the opening parenthesis to its partner; of an assignment to its semicolon."""
    depth, i = 1, begin
    for token in TOKEN.finditer(text, begin):
        for k in range(i, token.start()):
            depth += {"(": 1, ")": -1}.get(text[k], 0)
            if depth == 0 or (text[k] == ";" and depth == 1):
                return text[begin:k]
        i = token.end()
    for k in range(i, len(text)):
        depth += {"(": 1, ")": -1}.get(text[k], 0)
        if depth == 0 or (text[k] == ";" and depth == 1):
            return text[begin:k]
    return text[begin:]


def words_of(code):
    """The string literals of an expression as one text, neighbours joined, … between those that are apart."""
    out, end = "", 0
    for token in TOKEN.finditer(code):
        if not token.group().startswith('"'):
            continue
        gap = code[end:token.start()].strip()
        out += ("" if not gap and out else "…") + for_shell(token.group()[1:-1])
        end = token.end()
    out += "…"
    out = re.sub(r"\{[^{}]*\}", "…", out.replace('\\"', '"').replace("\\\\", "\\"))
    return re.sub(r"\s*(?:…\s*)+", lambda m: ("…" if m.group()[0] == "…" else " …") + (" " if m.group()[-1] == " " else ""),
                  re.sub(r"[ \n]+", " ", out)).strip("… ").strip()


def warnings():
    """(all warnings of the sources, findings)"""
    all_of_them, found = [], []
    for name in tracked("src/*.cpp", "src/*.hpp", "cli/*.cpp", "cli/*.hpp"):
        text = text_of(name)
        notes = list(NOTE.finditer(text)) if "/io/" in name else []
        for match in [*PUSH.finditer(text), *notes]:
            code = argument(text, match.end()).strip()
            line = text.count("\n", 0, match.start()) + 1
            words = words_of(code)
            if len(re.sub(r"[^A-Za-z]", "", words)) >= 6:
                all_of_them.append(Warning(name, line, words))
            elif not words and not PASSED_ON.match(re.sub(r"\s+", " ", code)):
                found.append((name, line, f"a warning whose text is not where it is given ({code[:60]}): write its words "
                                          "into the call, or call the variable note, weak or warning where it is passed on"))
    return all_of_them, found


def rows():
    found = []
    for number, line in enumerate(text_of(PAGE).split("\n"), 1):
        cells = [cell.strip() for cell in line.strip().strip("|").split(" | ")]
        if not line.startswith("| `") or len(cells) != 3:
            continue
        found.append(Row(number, [clean(p) for p in re.findall(r"`([^`]+)`", cells[0])],
                         re.findall(r"`([^`]+)`", cells[1]), cells[2]))
    return found


def clean(phrase):
    return phrase.strip("… ").strip()


def row_of(warning, table):
    """The rows that list it."""
    return [row for row in table if any(phrase in warning.text for phrase in row.phrases)]


def main():
    sources, found = warnings()
    table = rows()
    if not table:
        found.append((PAGE, 1, "holds no table of warnings"))
    for warning in sources:
        if not row_of(warning, table):
            found.append((warning.file, warning.line, f"not in {PAGE}: add a row '| `{warning.text}` | `verb`, … | what it "
                                                      "means and what to do |' with the verbs that can give it"))
    for row in table:
        for phrase in row.phrases:
            if not any(phrase in warning.text for warning in sources):
                found.append((PAGE, row.line, f"no warning of the program says '{phrase}': correct or drop the row"))
    finish("warnings_listed", sorted(set(found)))


if __name__ == "__main__":
    main()
