"""What messages name: one of exit 2 the option or argument, one of exit 3 or 4 the file. Over every option of every verb with
values that are wrong in one way or another, and every input of every verb with files that are."""

import concurrent.futures
import os
import re
import subprocess
import unittest

from support import BIN, CliTest, points

INPUTS = {"compare": ("a.xyz", "b.xyz"), "match": ("a.xyz", "b.xyz"), "distance": ("a.xyz", "b.xyz"), "asymmetry": ("a.xyz",),
          "accuracy": ("a.xyz", "b.xyz"), "scanners": ("a.xyz", "b.xyz", "c.xyz"), "roughness": ("a.xyz", "b.xyz"),
          "sequence": ("a.xyz", "b.xyz", "c.xyz"), "combine": ("a.xyz", "b.xyz", "--reference", "c.xyz"), "info": ("a.xyz",), "simulate": ("terrain",),
          "demo": (), "convert": ("a.xyz", "out.ply")}
SCANS = {verb: [k for k, word in enumerate(words) if word.endswith(".xyz")] for verb, words in INPUTS.items()}
WRONG = ["nonsense", "-1", "nan", "", "1,2"]
SMALL = {"simulate": ("--points", "120"), "demo": ("--points", "200")}  # beside a folder of their own


def with_argument(help_text):
    """Options that take a value."""
    return sorted(set(re.findall(r"^ +(?:-\w,? )?(--[a-z0-9][a-z0-9-]*) [^ ]", help_text, re.MULTILINE)))


class Messages(CliTest):
    def setUp(self):
        super().setUp()
        self.write("a.xyz", points(1, n=180))
        self.write("b.xyz", points(2, n=190, lift=0.1))
        self.write("c.xyz", points(3, n=170))

    def run_all(self, commands):
        def one(words):
            done = subprocess.run([BIN, *words], cwd=self.folder, capture_output=True, text=True, timeout=60)
            return words, done.returncode, done.stderr

        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            return list(pool.map(one, commands))

    def last_line(self, words, stderr):
        lines = [line for line in stderr.split("\n") if line.startswith("isopach: ")]
        self.assertEqual(len(lines), 1, (words, stderr))
        return lines[0]

    def test_exit_2_names_the_option(self):
        commands, option_of = [], {}
        for verb, inputs in INPUTS.items():
            options = with_argument(self.run_cli(verb, "--help").stdout)
            self.assertGreater(len(options), 1, verb)
            for option in options:
                for value in WRONG:
                    own = (*SMALL[verb], "-o", f"out{len(commands)}") if verb in SMALL else ()
                    words = (verb, *inputs, *own, option, value)
                    commands.append(words)
                    option_of[words] = option
        used = set()
        for words, code, stderr in self.run_all(commands):
            self.assertIn(code, (0, 2, 3, 4, 5, 6), (words, stderr))
            if code not in (2, 3, 4):
                continue
            line, verb, option, value = self.last_line(words, stderr), words[0], option_of[words], words[-1]
            names = [option] + ([value] if value else [])  # a file that an option names is as good
            if code != 2:
                names += [word for word in INPUTS[verb] if "." in word]
            self.assertTrue(any(name in line for name in names), (words, line))
            if code == 2 and option in line:
                used.add((verb, option))
        self.assertGreater(len(used), 120)

    def test_exit_3_and_4_name_the_file(self):
        self.path("empty.xyz").write_text("")
        self.path("words.xyz").write_text("these are no numbers\nat all\n")
        self.path("nan.xyz").write_text("nan nan nan\n" * 5)
        self.path("point.xyz").write_text("1 2 3\n")
        self.path("line.xyz").write_text("".join(f"{k} {k} {k}\n" for k in range(90)))
        self.path("far.xyz").write_text("".join(f"{x + 1e5} {y} {z}\n" for x, y, z in points(4, n=80)))
        self.path("short.ply").write_bytes(b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty double x\nproperty double y\n"
                                           b"property double z\nend_header\n1234")
        self.path("bytes.las").write_bytes(bytes(range(256)) * 4)
        self.path("folder.xyz").mkdir()
        bad = ["missing.xyz", "empty.xyz", "words.xyz", "nan.xyz", "point.xyz", "line.xyz", "far.xyz", "short.ply", "bytes.las", "folder.xyz"]
        commands, names = [], {}
        for verb, inputs in INPUTS.items():
            for k in SCANS[verb]:
                for name in bad:
                    words = (verb, *inputs[:k], name, *inputs[k + 1:])
                    commands.append(words)
                    names[words] = name
        refused = 0
        for words, code, stderr in self.run_all(commands):
            self.assertIn(code, (0, 3, 4, 5), (words, stderr))
            if code not in (3, 4):
                continue
            refused += 1
            line = self.last_line(words, stderr)
            # Of several frames those that are no scans are left out; what is said then is said of all.
            self.assertTrue(names[words] in line or words[0] == "combine" and "a.xyz" in line, (words, line))
        self.assertGreater(refused, 150)


if __name__ == "__main__":
    unittest.main()
