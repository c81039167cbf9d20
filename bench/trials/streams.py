"""Standard streams that are closed, full, or have no reader; inputs that come through a pipe; bits of results."""

import itertools
import os
import random
import signal
import subprocess
import threading

from .cases import LONGEST_S
from .ends import state_of


def closed(numbers):
    def close():
        for number in numbers:
            os.close(number)
    return close


def closed_streams(sandbox, case, tally):
    """Every choice of the three standard streams closed: no file of a result may take the place of one of them."""
    loud = [w for w in case.words if w != "--quiet"]
    for many in (1, 2, 3):
        for numbers in itertools.combinations((0, 1, 2), many):
            sandbox.begin(case)
            run = subprocess.Popen([sandbox.program, *loud], cwd=sandbox.root, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, preexec_fn=closed(numbers))
            code = run.wait(LONGEST_S)
            found, offence = state_of(sandbox, case), ""
            if code not in (case.code, 1) or (code == 1 and 1 not in numbers):
                offence = f"exit {code}"
            elif (case.has_folder or case.target) and found not in (["the new result"] if code != 1 else ["the earlier result", "the new result"]):
                offence = f"{found} after exit {code}"
            if sandbox.leftovers():
                offence = offence or f"left {sandbox.leftovers()}"
            signs = "".join(f" {n}>&-" for n in numbers)
            tally.add("streams", "closed", case.verb, "failed" if code == 1 else "was done", case.shown() + signs, offence)


def full_streams(sandbox, case, tally):
    if not os.path.exists("/dev/full"):
        return
    loud = [w for w in case.words if w != "--quiet"]
    for name in ("stdout", "stderr"):
        sandbox.begin(case)
        with open("/dev/full", "w") as full:
            done = sandbox.run(loud, **{name: full})
        wrote = case.verb != "convert" and name == "stdout"
        offence = ""
        if done.returncode not in ((case.code, 1) if name == "stdout" else (case.code,)):
            offence = f"exit {done.returncode}"
        if done.returncode == 1 and "standard output" not in (done.stderr or ""):
            offence = f"says not what is full: {done.stderr!r}"
        if (case.has_folder or case.target) and state_of(sandbox, case) != "the new result":
            offence = offence or f"{state_of(sandbox, case)} after exit {done.returncode}"
        if wrote and done.returncode == 0 and sandbox.run(loud).stdout:
            offence = offence or "exit 0, and what it had to say is lost"
        tally.add("streams", "full", case.verb, "failed in one line" if done.returncode else "was done", f"{case.shown()}, {name} full", offence)


def readers_that_leave(sandbox, case, tally):
    """The reader of standard output leaves before it has read: a quiet end, and the files are there."""
    loud = [w for w in case.words if w != "--quiet"]
    sandbox.begin(case)
    run = sandbox.popen(loud, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    run.stdout.close()
    with run.stderr:
        stderr = run.stderr.read()
    code = run.wait(LONGEST_S)
    offence = ""
    if code not in (case.code, -signal.SIGPIPE) or code == -signal.SIGPIPE and stderr:
        offence = f"exit {code}: {stderr!r}"
    if (case.has_folder or case.target) and state_of(sandbox, case) != "the new result":
        offence = offence or f"{state_of(sandbox, case)} after exit {code}"
    tally.add("streams", "reader leaves", case.verb, "was done" if code == case.code else "ended quietly", f"{case.shown()} | true", offence)


def pipes(sandbox, tally, names):
    """`info` of every input through a pipe and through a FIFO: what it says of the file itself."""
    def said(text, name):
        return [line for line in text.replace(name, "FILE").splitlines()]

    for name in names:
        plain = sandbox.run(["info", f"in/{name}", "--json", "-"])
        data = (sandbox.root / "in" / name).read_bytes()
        piped = subprocess.run([sandbox.program, "info", "/dev/stdin", "--json", "-"], cwd=sandbox.root, input=data, capture_output=True,
                               timeout=LONGEST_S)
        fifo = sandbox.root / "fifo"
        fifo.unlink(missing_ok=True)
        os.mkfifo(fifo)
        writer = threading.Thread(target=lambda: fifo.write_bytes(data), daemon=True)
        writer.start()
        by_fifo = sandbox.run(["info", "fifo", "--json", "-"])
        writer.join(5)
        for how, code, text, other in (("a pipe", piped.returncode, piped.stdout.decode(errors="replace"), "/dev/stdin"),
                                       ("a FIFO", by_fifo.returncode, by_fifo.stdout, "fifo")):
            offence = ""
            if code != 0 or said(text, other) != said(plain.stdout, f"in/{name}"):
                offence = f"exit {code}, or says another thing than of the file"
            tally.add("streams", f"input by {how}", "info", "read as the file", f"{name} through {how}", offence)


def same_bits(sandbox, case, tally):
    """The results for 1, 2, 3 and 7 threads."""
    words = [w for i, w in enumerate(case.words) if w != "--threads" and case.words[i - 1] != "--threads"]
    for threads in ("1", "2", "3", "7"):
        sandbox.begin(case)
        done = sandbox.run([*words, "--threads", threads])
        now = sandbox.state(case)
        offence = "" if done.returncode == case.code else f"exit {done.returncode}: {done.stderr}"
        if not offence:
            offence = of_threads(now, case.after)
        if not (case.has_folder or case.target) and done.stdout != case.stdout:
            offence = "says another thing"
        tally.add("same bits", "threads", case.verb, "the same", f"{case.shown()} --threads {threads}", offence)


def of_threads(now, wanted):
    """What differs but for the number of threads itself, which results tell."""
    def without(name, data):
        if data is None or not name.endswith((".json", ".html")):
            return data
        lines = data.replace(b"{", b"\n").replace(b",", b"\n").splitlines()
        return [line for line in lines if b"threads" not in line]

    other = [n for n in sorted(set(now) | set(wanted)) if n not in now or n not in wanted or without(n, now[n]) != without(n, wanted[n])]
    return f"other bytes: {', '.join(other)}" if other else ""


def shuffled_text(text, seed):
    """A scan as text with its points in another order."""
    lines = text.splitlines()
    head = [line for line in lines if line.startswith("#")]
    body = [line for line in lines if not line.startswith("#")]
    random.Random(seed).shuffle(body)
    return "\n".join(head + body) + "\n"


def same_in_any_order(sandbox, tally, verbs):
    """Points of both scans in another order: result.json is the same. `verbs`: lines with the text scans they read."""
    for line in verbs:
        words, told = line.split(), []
        for seed in (0, 1, 2):
            sandbox.clear()
            for name in [w for w in words if w.endswith(".xyz")]:
                text = (sandbox.root / "in" / name).read_text()
                (sandbox.root / name).write_text(shuffled_text(text, seed) if seed else text)
            done = sandbox.run([*words, "-o", "out", "--quiet"])
            found = sandbox.root / "out" / "result.json"
            told.append((done.returncode, without_times(found.read_text()) if found.exists() else done.stderr))
            if seed:
                tally.add("same bits", "order of points", words[0], "the same", line, "" if told[0] == told[-1] else "another result.json")


def without_times(text):
    import json
    told = json.loads(text)
    told.pop("timing_s", None)
    return json.dumps(told)
