"""One run of every case under valgrind."""

import re
import shutil
import subprocess


def under_valgrind(sandbox, cases, tally):
    if shutil.which("valgrind") is None:
        print("valgrind is not here: left out", flush=True)
        return
    for case in cases:
        sandbox.begin(case)
        log = sandbox.root.parent / "valgrind.log"
        done = subprocess.run(["valgrind", f"--log-file={log}", "--error-exitcode=99", sandbox.program, *case.words, "--threads", "1"]
                              if "--threads" not in case.words else
                              ["valgrind", f"--log-file={log}", "--error-exitcode=99", sandbox.program, *case.words],
                              cwd=sandbox.root, capture_output=True, text=True, timeout=3600)
        summary = re.search(r"ERROR SUMMARY: (\d+) errors", log.read_text())
        errors = int(summary.group(1)) if summary else -1
        offence = "" if errors == 0 and done.returncode == case.code else f"exit {done.returncode}, {errors} errors: {log.read_text()[:3000]}"
        tally.add("valgrind", "memory", case.verb, "0 errors" if errors == 0 else "errors", case.shown(), offence)
