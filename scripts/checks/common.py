"""What the checks share: the tracked files, their lines without comments, and one way to report."""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def tracked(*patterns):
    """Paths of the project's files (tracked, or new and not ignored), relative to its root."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *patterns]
    names = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\n")
    return [name for name in names if name and (ROOT / name).is_file()]


def text_of(name):
    return (ROOT / name).read_bytes().decode("utf-8", errors="replace")


TOKEN = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(?P<tag>[^(\s]*)\(.*?\)(?P=tag)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'(?![\w])',
    re.DOTALL)


# A message's mention of an option, "@max-edge", where base/option_key.cpp takes it for one.
KEY = re.compile(r"(?<![\w./@'\"`\u0080-\U0010ffff-])@([a-z][a-z0-9-]*)(?![\w/@\u0080-\U0010ffff-]|\.\w)")
KEY_TABLE = "src/isopach/base/option_key.cpp"


def option_keys():
    """The options that messages may name."""
    table = re.search(r"option_keys\[\] = \{(.*?)\};", text_of(KEY_TABLE), re.DOTALL)
    return re.findall(r'"([^"]*)"', table.group(1)) if table else []


def for_shell(text):
    """A message as the command line shows it."""
    return KEY.sub(lambda match: "--" + match.group(1), text)


def literals(name):
    """(line number, inside) of each string literal of a source."""
    text = text_of(name)
    for token in TOKEN.finditer(text):
        if token.group().startswith(('"', 'R"')):
            inside = token.group()[token.group().index('"') + 1:-1]
            yield text.count("\n", 0, token.start()) + 1, inside


def code_of(name):
    """The file's text with comments and the insides of strings blanked; lines keep their numbers."""

    def blank(match):
        token = match.group()
        if token.startswith('"') and text.rfind("#include", text.rfind("\n", 0, match.start()) + 1, match.start()) >= 0:
            return token
        return re.sub(r"[^\n]", " ", token)

    text = text_of(name)
    return TOKEN.sub(blank, text)


def matches(pattern, text):
    """(line number, matched text) of each match."""
    for match in re.finditer(pattern, text):
        yield text.count("\n", 0, match.start()) + 1, match.group()


def finish(check, found):
    """Prints file:line: message for each finding and ends with 1 if there are any."""
    for name, line, message in found:
        print(f"{name}:{line}: {message}")
    print(f"{check}: {'ok' if not found else f'{len(found)} found'}")
    sys.exit(1 if found else 0)
