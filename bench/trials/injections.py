"""One call of the system fails, or the program is killed before it: every case, every kind of call, one call after another."""

import os
import re
import signal
import subprocess

from .cases import LONGEST_S

#: kind, deed, least bytes of a request of memory, section
KINDS = [("memory", "fail", 1 << 16), ("memory", "fail", 1), ("open", "fail", 0), ("read", "fail", 0), ("write", "fail", 0),
         ("close", "fail", 0), ("rename", "fail", 0), ("fsync", "fail", 0), ("mkdir", "fail", 0), ("remove", "fail", 0),
         ("stat", "fail", 0), ("list", "fail", 0), ("lock", "fail", 0), ("thread", "fail", 0), ("read", "short", 0),
         ("write", "short", 0), ("read", "again", 0), ("write", "again", 0)]
#: exit codes that a fault of this kind may end with; 0 with the undisturbed result is always right
CODES = {"memory": {1}, "open": {1, 2, 3}, "read": {1, 2, 3}, "write": {1}, "close": {1}, "rename": {1}, "fsync": {1}, "mkdir": {1, 2},
         "remove": {1}, "stat": {1, 2, 3}, "list": {1, 2, 3}, "lock": {1}, "thread": {1}}
NO_MEMORY = re.compile(r"memory|limit of this machine|LASzip|GDAL|could not be started|thread|library|No space for output buffer|[Cc]annot allocate")
# Lines that libraries print themselves: fonts, codecs and certificates that they look for and isopach does not use.
# What libraries print themselves; fontconfig prints bytes that it did not read before "(errno".
OF_LIBRARIES = re.compile(r"^Fontconfig error: (?:.|\n)*?\(errno \d+\)\n?"
                          r"|^(?:Fontconfig (?:error|warning)|Out of memory$|Error in GnuTLS|Failed to allocate memory|.*GnuTLS).*\n?",
                          re.MULTILINE)
# The heap, which LASzip damages where it does not look whether it got memory, and checks inside libraries, before they end.
OF_THE_HEAP = re.compile(r"^(?:free\(\)|double free|malloc\(\)|corrupted|munmap_chunk).*\n|^.*: Assertion .* failed\.\n", re.MULTILINE)
PLACE = re.compile(r"\bin/|\bout\b|\bx\.\w+|folder|memory|thread|limit of this machine|library|LASzip|GDAL|standard output")
LEFT_TO_THE_NEXT = re.compile(r"limit of this machine|ended at once|a library gave up")


def name_of(kind, deed, least):
    if kind == "memory":
        return "memory, 64 kB or more" if least > 1 else "memory, any request"
    return {"fail": kind, "short": f"{kind}, half done", "again": f"{kind}, interrupted", "kill": f"kill before {kind}"}[deed]


class Injector:
    def __init__(self, library, program, tally):
        self.library, self.program, self.tally = library, program, tally

    def environment(self, kind, number, deed="fail", least=1 << 16, **more):
        return {**os.environ, "LD_PRELOAD": self.library, "ISOPACH_FAULT": f"{kind}:{number}", "ISOPACH_FAULT_DO": deed,
                "ISOPACH_FAULT_LEAST": str(max(least, 1)), **more}

    def counted(self, sandbox, case, least):
        """An undisturbed run, and how many calls of each kind it makes."""
        told = sandbox.root.parent / (sandbox.root.name + ".calls")
        done = sandbox.run(case.words, self.environment("all", 0, least=least, ISOPACH_FAULT_COUNT=str(told)))
        if done.returncode not in (0, 5):
            raise SystemExit(f"{case.shown()}: exit {done.returncode}: {done.stderr}")
        return done, {kind: int(number) for kind, number in (line.split() for line in told.read_text().splitlines())}

    def fault(self, sandbox, case, kind, deed, least, number):
        """One trial: the run, what it left, and whether that is what the contract says."""
        sandbox.begin(case)
        crash = sandbox.root.parent / (sandbox.root.name + ".crash")
        crash.unlink(missing_ok=True)
        fault, command = name_of(kind, deed, least), f"ISOPACH_FAULT={kind}:{number} ISOPACH_FAULT_DO={deed} " \
            f"ISOPACH_FAULT_LEAST={max(least, 1)} {case.shown()}"
        environment = self.environment(kind, number, deed, least, ISOPACH_FAULT_CRASH=str(crash))
        try:
            done = sandbox.run(case.words, environment)
        except subprocess.TimeoutExpired:
            return self.tally.add("faults", fault, case.verb, "hung", command, f"no end within {LONGEST_S} s")
        outcome, offence = self.judged(sandbox, case, kind, deed, done, crash)
        self.tally.add("faults", fault, case.verb, outcome, command, offence)

    def judged(self, sandbox, case, kind, deed, done, crash):
        if kind == "memory" and done.stderr.startswith("Operating system error: Cannot allocate memory"):
            sandbox.sweep(case)  # libgfortran, one of the libraries that GDAL loads, ends the program as it begins
            return "ended by libgfortran", "" if sandbox.state(case) in (case.before, case.after) else "and the result is not whole"
        if kind == "memory" and done.returncode == 127 and done.stderr.strip() == "out of memory":
            sandbox.sweep(case)
            return "ended by the loader", "" if sandbox.state(case) in (case.before, case.after) else "and the result is not whole"
        done.stderr = OF_LIBRARIES.sub("", done.stderr)
        if kind == "memory" and "isopach: a library gave up" in done.stderr:
            done.stderr = OF_THE_HEAP.sub("", done.stderr)
        if done.returncode == case.code:
            offence = self.against_undisturbed(sandbox, case, kind, done)
            if offence and case.verb == "sequence" and b"was skipped: in/frames" in (sandbox.state(case).get("result.json") or b""):
                return "a frame was skipped, as the result says", ""
            if not offence and case.has_folder and sandbox.state(case) != case.after:
                return "as without the fault, but for the font of the pictures", ""
            if offence and kind == "memory" and same_points(sandbox, case):
                return "as without the fault, but for LASzip's table of chunks", ""
            return "as without the fault", offence
        line = done.stderr.strip()
        if deed != "fail":
            return "failed", f"exit {done.returncode}, and the call can be done again: {line}"
        if done.returncode < 0:
            return self.ended_by_signal(sandbox, case, kind, done, crash)
        offence = ""
        if done.returncode not in CODES[kind] and not (kind == "memory" and re.search("(?i:laszip)|GDAL", line)):
            offence = f"exit {done.returncode}: {line}"
        elif done.stderr.count("\n") != 1 or not line.startswith("isopach: ") or ".isopach-" in line:
            offence = f"not one line of ours: {line!r}"
        elif not (NO_MEMORY if kind == "memory" else PLACE).search(line):
            offence = f"says not what happened: {line}"
        else:
            offence = self.against_earlier(sandbox, case, kind, line)
        if kind == "memory" and done.returncode == 3:
            return "failed in one line, as of LASzip or GDAL", offence
        new = not offence and (case.has_folder or case.target) and sandbox.state(case) == case.after
        return "failed in one line, new result in place" if new else "failed in one line", offence

    def against_undisturbed(self, sandbox, case, kind, done):
        """The fault was borne: then nothing may differ from an undisturbed run."""
        if done.stderr != case.stderr or done.stdout != case.stdout:
            return f"exit {done.returncode}, but other words: {done.stderr or done.stdout}"
        if sandbox.leftovers():
            if kind not in ("remove", "open", "list", "stat", "memory", "lock"):
                return f"left {sandbox.leftovers()}"
            sandbox.sweep(case)
        if sandbox.leftovers():
            return f"the next run left {sandbox.leftovers()}"
        now = sandbox.state(case)
        fonts = kind in ("memory", "open", "read", "list", "stat", "close")  # fontconfig takes another where it cannot have one
        if now == case.after or fonts and case.has_folder and without_pictures(now) == without_pictures(case.after):
            return ""
        return f"exit {done.returncode}, but another result: {differing(now, case.after)}"

    def against_earlier(self, sandbox, case, kind, line):
        """The run failed: what was there before is there, and nothing else, perhaps after the next run."""
        if sandbox.leftovers():
            if kind not in ("remove", "open", "list", "stat") and not LEFT_TO_THE_NEXT.search(line):
                return f"left {sandbox.leftovers()}: {line}"
            sandbox.sweep(case)
            if sandbox.leftovers():
                return f"the next run left {sandbox.leftovers()}: {line}"
        state = sandbox.state(case)
        if state in (case.before, case.after) or case.has_folder and without_pictures(state) == without_pictures(case.after):
            return ""
        return f"neither the earlier result nor the new one: {differing(state, case.before)}: {line}"

    def ended_by_signal(self, sandbox, case, kind, done, crash):
        """A crash is against the contract but in a library that does not look whether it got memory."""
        library = crashed_in(crash, self.program)
        name = signal.Signals(-done.returncode).name
        if kind != "memory" or library is None:
            return "crashed", f"{name}: {crash.read_text() if crash.exists() else done.stderr}"
        sandbox.sweep(case)
        state = sandbox.state(case)
        whole = not sandbox.leftovers() and (state in (case.before, case.after))
        return f"crash in {library}", "" if whole else f"{name} in {library}, and the earlier result is not whole"


def same_points(sandbox, case):
    """Whether a LAZ file that is another one has the same header and points: LASzip does not look whether it got memory for
    what comes behind them, the table of chunks."""
    if not (case.target or "").endswith(".laz"):
        return False
    texts = []
    for data in (sandbox.state(case)[case.target], case.after[case.target]):
        (sandbox.root / "again.laz").write_bytes(data)
        done = sandbox.run(["convert", "again.laz", "again.las", "--quiet"])
        texts.append((done.returncode, (sandbox.root / "again.las").read_bytes() if done.returncode == 0 else None))
    return texts[0] == texts[1] and texts[0][0] == 0


def without_pictures(files):
    """A result without the pixels of its pictures: what they are called stays."""
    def plain(name, data):
        if name.endswith(".png"):
            return b"" if data else data
        return re.sub(rb"data:image/png;base64,[A-Za-z0-9+/=]*", b"", data) if name.endswith(".html") and data else data

    return {name: plain(name, data) for name, data in (files or {}).items()}


def differing(now, wanted):
    if now is None or wanted is None:
        return f"{'no folder' if now is None else 'a folder'}"
    return ", ".join(f"{n} is {'missing' if n not in now else 'new' if n not in wanted else 'another'}"
                     for n in sorted(set(now) | set(wanted)) if now.get(n, 0) != wanted.get(n, 0))


LIBRARIES = {"liblaszip": "LASzip", "libgdal": "GDAL", "libcairo": "cairo", "libpixman": "cairo", "libfontconfig": "fontconfig",
             "libfreetype": "FreeType", "libproj": "PROJ", "libtbb": "oneTBB", "libmuparser": "muParser", "libexpat": "expat",
             "libpng": "libpng"}
TEMPLATES = {"nlohmann::": "nlohmann-json", "CLI::": "CLI11"}


def crashed_in(crash, program):
    """The library in which a run crashed, by the first frame behind the C library; None where it is our own."""
    if not crash.exists():
        return None
    for line in crash.read_text().splitlines():
        path, _, place = line.partition("(")
        if not place or re.search(r"lib(?:c|stdc\+\+|gcc_s|m|pthread|isopach-faults)\.so|faults\.so|ld-linux", path):
            continue
        for library, name in LIBRARIES.items():
            if library in path:
                return name
        if os.path.basename(path) == os.path.basename(program):
            return template_at(program, place)
        return os.path.basename(path)
    return None


def template_at(program, place):
    """A library of templates is compiled into the program: the name of the function tells it."""
    offset = re.search(r"\+?(0x[0-9a-f]+)\)", place)
    if not offset:
        return None
    told = subprocess.run(["addr2line", "-fCe", program, offset.group(1)], capture_output=True, text=True).stdout
    return next((name for word, name in TEMPLATES.items() if told.lstrip().startswith(word)), None)


def sampled(count, most):
    """The numbers 1 to `count`, or `most` of them evenly spread, the first and the last among them."""
    most = min(most, count)
    return sorted({1 + round(i * (count - 1) / max(most - 1, 1)) for i in range(most)})


def plan(cases, most):
    """All trials of all cases: (case, kind, deed, least, number); `most` numbers of each kind for a case of share 1."""
    trials = []
    for case in cases:
        many, any_request = case.calls, case.requests
        for kind, deed, least in KINDS:
            number = any_request if least == 1 else many[kind]
            few = max(2, round(most * case.share * (8 if least == 1 else 1)))
            trials += [(case, kind, deed, least, n) for n in sampled(number, few)]
    return trials
