"""docs/use/warnings.md against the program: a warning names no option that one of its verbs lacks, the advice beside it none
that all of them lack."""

import pathlib
import re
import subprocess
import sys
import unittest

from support import BIN, CliTest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts/checks"))
import warnings_listed  # noqa: E402
from common import KEY_TABLE, option_keys  # noqa: E402

OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")


class Options(CliTest):
    @classmethod
    def setUpClass(cls):
        overview = subprocess.run([BIN, "--help"], capture_output=True, text=True, check=True).stdout
        cls.verbs = re.findall(r"^  (\w+) {2,}\S", overview[overview.index("Verbs:"):], re.M)
        cls.options = {}
        for verb in cls.verbs:
            text = subprocess.run([BIN, verb, "--help"], capture_output=True, text=True, check=True).stdout
            # Only where an option is declared: at the beginning of its lines.
            cls.options[verb] = set(re.findall(r"^ +(?:-\w,? *)?(--[a-z][a-z0-9-]*)", text, re.M))
        cls.rows = warnings_listed.rows()

    def test_help_is_understood(self):
        self.assertIn("compare", self.verbs)
        self.assertLessEqual({"--output", "--sigma1", "--threads", "--no-map"}, self.options["compare"])
        self.assertNotIn("--sigma1", self.options["distance"])

    def test_every_key_that_messages_may_name_is_an_option(self):
        keys = option_keys()
        self.assertGreater(len(keys), 50)
        known = set().union(*self.options.values())
        for key in keys:
            self.assertIn("--" + key, known, f"{KEY_TABLE}: no verb has it")

    def test_rows_name_verbs_of_the_program(self):
        self.assertGreater(len(self.rows), 30)
        for row in self.rows:
            with self.subTest(row=row.phrases):
                self.assertTrue(row.verbs)
                self.assertLessEqual(set(row.verbs), set(self.verbs))

    def test_no_warning_names_an_option_that_a_verb_of_it_lacks(self):
        seen = 0
        for warning in warnings_listed.warnings()[0]:
            for row in warnings_listed.row_of(warning, self.rows):
                for option in OPTION.findall(warning.text):
                    for verb in row.verbs:
                        seen += 1
                        self.assertIn(option, self.options[verb],
                                      f"{warning.file}:{warning.line} names {option}, which {verb} lacks: name another "
                                      f"remedy, or correct the verbs of line {row.line} of docs/use/warnings.md")
        self.assertGreater(seen, 20)

    def test_advice_names_options_that_one_of_the_verbs_has(self):
        for row in self.rows:
            known = set().union(*(self.options[verb] for verb in row.verbs), self.options["convert"])
            for option in OPTION.findall(row.advice):
                self.assertIn(option, known, f"docs/use/warnings.md:{row.line}")


if __name__ == "__main__":
    unittest.main()
