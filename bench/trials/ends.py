"""Runs that end before they are done, or stand in each other's way: kills, signals, limits, two runs into one folder."""

import random
import re
import resource
import shutil
import signal
import subprocess
import time

from .cases import LONGEST_S
from .injections import OF_LIBRARIES


def state_of(sandbox, case):
    """What stands in the folder, as a reader finds it who looks at the record first."""
    now = {n: b for n, b in (sandbox.state(case) or {}).items() if not n.startswith(".isopach-")}
    if now == case.before:
        return "the earlier result"
    if now == case.after:
        return "the new result"
    record = "truth.json" if case.verb == "simulate" else "result.json"
    if case.has_folder and record not in now:
        return "no record, until the next run"
    return "a mixture"


def check_kill(sandbox, case, tally, section, fault, command):
    """After a kill: what is there at once, and after the next run."""
    found = state_of(sandbox, case)
    offence = f"{found} after the kill" if found == "a mixture" else ""
    sandbox.sweep(case)
    after = state_of(sandbox, case)
    if case.target:
        after = after if after == "the new result" else "not the new file"
    if sandbox.leftovers():
        offence = offence or f"the next run left {sandbox.leftovers()}"
    if after not in ("the earlier result", "the new result"):
        offence = offence or f"{after} after the next run"
    tally.add(section, fault, case.verb, found, command, offence)


def kill_before_call(injector, sandbox, case, kind, number):
    sandbox.begin(case)
    done = sandbox.run(case.words, injector.environment(kind, number, "kill"))
    if done.returncode in (case.code, -signal.SIGKILL):
        command = f"ISOPACH_FAULT={kind}:{number} ISOPACH_FAULT_DO=kill {case.shown()}"
        check_kill(sandbox, case, injector.tally, "kills", f"before a call: {kind}", command)


CALL = re.compile(r"^(?:\d+ +)?(\w+)\(")


def on_one_thread(case):
    return case.words if "--threads" in case.words else [*case.words, "--threads", "1"]


def last_system_calls(sandbox, case, most):
    """The last calls of the kernel that a run makes, its commit among them: (name, how often it was called so far)."""
    if shutil.which("strace") is None:
        return []
    trace = sandbox.root.parent / "trace"
    sandbox.begin(case)
    subprocess.run(["strace", "-o", trace, sandbox.program, *on_one_thread(case)], cwd=sandbox.root, capture_output=True, timeout=LONGEST_S)
    calls, seen = [], {}
    for line in trace.read_text(errors="replace").splitlines():
        if match := CALL.match(line):
            seen[match.group(1)] = seen.get(match.group(1), 0) + 1
            calls.append((match.group(1), seen[match.group(1)]))
    return [call for call in calls[-most:] if call[0] not in ("exit_group", "execve")]


def kill_before_system_call(sandbox, case, tally, call):
    sandbox.begin(case)
    inject = f"inject={call[0]}:signal=KILL:when={call[1]}"
    subprocess.run(["strace", "-o", "/dev/null", "-e", inject, sandbox.program, *on_one_thread(case)], cwd=sandbox.root, capture_output=True,
                   timeout=LONGEST_S)
    check_kill(sandbox, case, tally, "kills", "before a call of the kernel", f"strace -e {inject} {case.shown()}")


def longest(sandbox, case):
    sandbox.begin(case)
    begin = time.monotonic()
    sandbox.run(case.words)
    return time.monotonic() - begin


def kill_at_random(sandbox, case, tally, share):
    """Killed after this share of the time that an undisturbed run takes."""
    wait = share * longest(sandbox, case)
    sandbox.begin(case)
    run = sandbox.popen(case.words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(wait)
    run.kill()
    run.wait()
    check_kill(sandbox, case, tally, "kills", "at random times", f"{case.shown()}, killed after {wait:.4f} s")


ENDING = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
IGNORED = [signal.SIGPIPE, signal.SIGXFSZ]


def signal_at_random(sandbox, case, tally, number, share):
    """Ends in one line with 130, or is done; signals of a broken pipe and of a full file change nothing by themselves."""
    sent = (ENDING + IGNORED)[number % 5]
    wait = share * longest(sandbox, case)
    sandbox.begin(case)
    run = sandbox.popen(case.words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    time.sleep(wait)
    begin = time.monotonic()
    run.send_signal(sent)
    command = f"{case.shown()}, {sent.name} after {wait:.4f} s"
    try:
        stderr = run.communicate(timeout=LONGEST_S)[1]
    except subprocess.TimeoutExpired:
        run.kill()
        run.wait()
        return tally.add("signals", sent.name, case.verb, "hung", command, "no end")
    if sent in ENDING:
        tally.most("longest answer to a signal", time.monotonic() - begin)
    check_signal(sandbox, case, tally, sent, run.returncode, stderr, command)


def check_signal(sandbox, case, tally, sent, code, stderr, command):
    found, offence = state_of(sandbox, case), ""
    if sandbox.leftovers():
        offence = f"left {sandbox.leftovers()}"
    if code == 130:
        outcome = "ended in one line, exit 130"
        if stderr.count("\n") != 1 or not stderr.startswith("isopach: interrupted") or sent in IGNORED:
            offence = f"not the line of an interrupted run: {stderr!r}"
        if found != "the earlier result" and (case.has_folder or case.target):
            offence = f"{found} after exit 130"
    elif code == case.code:
        outcome = "was done"
        if found != "the new result" and (case.has_folder or case.target):
            offence = f"{found} after exit {code}"
    else:
        # Before the program has begun, the signal does what it does to any program.
        outcome = "ended before it began"
        if code != -sent or stderr or found != "the earlier result" and (case.has_folder or case.target):
            offence = f"exit {code}: {stderr!r}, {found}"
    tally.add("signals", sent.name, case.verb, outcome, command, offence)


def file_limit(sandbox, case, tally, share):
    """A limit of file sizes, a share of the largest file of the result: as a disk that is full."""
    limit = int(share * max((len(b) for b in case.after.values() if b is not None), default=0))
    sandbox.begin(case)
    done = sandbox.run(case.words, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    check_limit(sandbox, case, tally, "file sizes limited", done, f"ulimit -f {limit} bytes; {case.shown()}", "cannot be written|standard output")


LOADED = 60_000_000  # with less the program may not even be loaded


def memory_limit(sandbox, case, tally, limit):
    """Address space from less than the program needs to start, to more than the run needs."""
    sandbox.begin(case)
    done = sandbox.run(case.words, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
    command = f"ulimit -v {limit // 1024}; {case.shown()}"
    if done.returncode == 127 or done.returncode < 0 and not done.stderr and limit < LOADED:
        return tally.add("limits", "memory limited", case.verb, "could not be loaded", command)
    check_limit(sandbox, case, tally, "memory limited", done, command, "memory|limit of this machine|library|LASzip|laszip|GDAL|thread|started")


def check_limit(sandbox, case, tally, fault, done, command, says):
    found, offence = state_of(sandbox, case), ""
    done.stderr = OF_LIBRARIES.sub("", done.stderr)
    if done.returncode == case.code:
        outcome = "was done"
        if (case.has_folder or case.target) and found != "the new result":
            offence = f"{found} after exit {done.returncode}"
    else:
        outcome = "failed in one line"
        if done.returncode not in ((1,) if fault.startswith("file") else (1, 3)):
            offence = f"exit {done.returncode}: {done.stderr}"
        elif done.stderr.count("\n") != 1 or not done.stderr.startswith("isopach: ") or not re.search(says, done.stderr):
            offence = f"not one line that says it: {done.stderr!r}"
        elif (case.has_folder or case.target) and found != "the earlier result":
            offence = f"{found} after exit {done.returncode}"
    if sandbox.leftovers():
        if not re.search("limit of this machine|ended at once|a library gave up", done.stderr):
            offence = offence or f"left {sandbox.leftovers()}"
        sandbox.sweep(case)
        if sandbox.leftovers():
            offence = offence or f"the next run left {sandbox.leftovers()}"
    tally.add("limits", fault, case.verb, outcome, command, offence)


def two_runs(sandbox, case, tally, count):
    """Two runs into one folder: one is refused, or both are done one after the other; the result is that of one."""
    rng = random.Random("two runs")
    other = [*case.words, "--title", "SECOND"]
    sandbox.begin(case)
    sandbox.run(other)
    results = [case.after, sandbox.state(case)]
    span = longest(sandbox, case)
    for number in range(count):
        if number % 2:
            sandbox.begin(case)
        else:
            sandbox.clear()
        runs = []
        for words in (case.words, other):
            runs.append(sandbox.popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE))
            time.sleep(rng.uniform(0, 0.6) * span)
        ends = [(run.communicate(timeout=LONGEST_S)[1], run.returncode) for run in runs]
        offence = ""
        for stderr, code in ends:
            if code not in (0, 2) or (code == 2 and (stderr.count("\n") != 1 or "another run" not in stderr)):
                offence = f"exit {code}: {stderr!r}"
        now = {n: b for n, b in (sandbox.state(case) or {}).items() if n != "mine.txt"}
        wanted = [{n: b for n, b in result.items() if n != "mine.txt"} for result in results]
        if not offence and (now not in wanted or sandbox.leftovers()):
            offence = f"not the result of one run: {sorted(now)}"
        refused = sum(code == 2 for _, code in ends)
        outcome = "both were done" if refused == 0 else "one was refused"
        if refused == 2:
            offence = "both were refused"
        tally.add("two runs", "into one folder", case.verb, outcome, f"{case.shown()}, twice", offence)
