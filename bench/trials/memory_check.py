"""A run of a case under valgrind."""

import re
import subprocess


def under_valgrind(sandbox, case, tally):
    sandbox.begin(case)
    log = sandbox.root.parent / (sandbox.root.name + ".valgrind")
    words = case.words if "--threads" in case.words else [*case.words, "--threads", "1"]
    done = subprocess.run(["valgrind", f"--log-file={log}", "--error-exitcode=99", sandbox.program, *words], cwd=sandbox.root,
                          capture_output=True, text=True)
    told = log.read_text()
    summary = re.search(r"ERROR SUMMARY: (\d+) errors", told)
    clean = summary is not None and summary.group(1) == "0" and done.returncode == case.code
    tally.add("valgrind", "one run", case.verb, "0 errors" if clean else "errors", case.shown(),
              "" if clean else f"exit {done.returncode}: {told[:3000]}")
