"""scripts/checks/record: its command lines use every choice of every option, and their results do not depend on threads.

Takes some ten seconds of one core, since the program runs nearly a hundred times: that is what is tested."""

import importlib.machinery
import importlib.util
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from support import BIN, CliTest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/checks/record"
# One of each kind of work that is cut into blocks for the threads; the whole record takes half a minute.
FAST = ["compare.both", "compare.noise-floor-overlay", "compare.currents", "compare.polygons-dv", "compare.gaussian", "compare.cubic",
        "match.icp-plane", "distance.plain", "refused.p*"]
# How a run reports, and a table of names; other tests of this folder have them.
NOT_HERE = {"--progress", "--palette", "--unit"}
PLACEHOLDERS = {"N", "S", "Nx", "LENGTH", "SHARE", "FILE", "REG", "DEGREES", "FORMULA"}


def script():
    loader = importlib.machinery.SourceFileLoader("record", str(SCRIPT))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("record", loader))
    sys.dont_write_bytecode = True
    loader.exec_module(module)
    return module


class RecordTest(CliTest):
    def record(self, *words, code=0):
        done = subprocess.run([sys.executable, "-B", SCRIPT, *map(str, words)], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout

    def test_any_number_of_threads_gives_the_same_record(self):
        only = [word for name in FAST for word in ("--only", name)]
        for threads in (1, 3):
            self.record("write", self.path(f"{threads}.json"), "--full", "--isopach", BIN, "--threads", threads, *only)
        one, three = (json.loads(self.path(f"{n}.json").read_text()) for n in (1, 3))
        self.assertEqual(list(script().differences(one, three)), [])
        self.assertGreaterEqual(len(one["runs"]), 12)
        for name, run in one["runs"].items():
            if name.startswith("refused."):
                self.assertIn(run["exit"], (2, 3, 4, 5), name)
                self.assertTrue(run["stderr"], name)
            elif not name.startswith("simulate."):
                self.assertEqual(run["exit"], 0, (name, run["stderr"]))
                self.assertIn("numbers", run, name)

    def test_what_differs_is_named_and_can_be_excused_with_a_reason_alone(self):
        only = ["--only", "compare.plain", "--isopach", BIN]
        self.record("write", self.path("old.json"), *only)
        self.assertIn("ok", self.record("compare", self.path("old.json"), *only))
        text = self.path("old.json").read_text()
        old = json.loads(text)
        net = old["runs"]["compare.plain"]["numbers"]["volume"]["net"]
        old["runs"]["compare.plain"]["numbers"]["volume"]["net"] = net + 1
        self.path("old.json").write_text(json.dumps(old))
        said = self.record("compare", self.path("old.json"), *only, code=1)
        self.assertIn(f"compare.plain: numbers.volume.net: {net + 1} -> {net}\n", said)
        self.path("excused.txt").write_text("# lines of reasons\ncompare.* numbers.volume.* the rim is cut exactly\n")
        self.assertIn("ok", self.record("compare", self.path("old.json"), *only, "--except", self.path("excused.txt")))
        self.path("excused.txt").write_text("compare.* numbers.volume.*\n")
        self.record("compare", self.path("old.json"), *only, "--except", self.path("excused.txt"), code=1)
        self.path("old.json").write_text(text)
        self.path("excused.txt").write_text("compare.* numbers.volume.* the rim is cut exactly\n")
        said = self.record("compare", self.path("old.json"), *only, "--except", self.path("excused.txt"), code=1)
        self.assertIn("excused.txt:1: nothing differs there", said)

    def test_every_verb_and_every_choice_of_every_option_is_in_it(self):
        lines = list(script().commands().values())
        verbs = re.findall(r"^  (\w+) ", self.run_cli("--help").stdout.split("Verbs:")[1].split("\n\n")[0], re.MULTILINE)
        self.assertGreaterEqual(len(verbs), 13)
        missing = [verb for verb in verbs if all(words[0] != verb for words in lines)]
        for option, choices in sorted({pair for verb in verbs for pair in self.choices(verb)}):
            # An option that verbs share is read by one piece of code: one verb with each choice is enough.
            given = {words[i + 1] for words in lines for i, word in enumerate(words[:-1]) if word == option}
            missing += [f"{option} {choice}" for choice in choices if choice not in given]
        self.assertEqual(missing, [])

    def choices(self, verb):
        """(option, choices) of the verb's help; of several that are no words but values (X,Y,Z, FILE) none."""
        for option, values in re.findall(r"^ +(?:-\w )?(--[a-z0-9-]+) ([^\s]+\|[^\s]+)", self.run_cli(verb, "--help").stdout, re.MULTILINE):
            if option not in NOT_HERE:
                yield option, tuple(v for v in values.split("|") if re.fullmatch(r"[A-Za-z0-9-]+", v) and v not in PLACEHOLDERS)


if __name__ == "__main__":
    unittest.main()
