"""Every option that --help of compare and distance lists: it acts, and an error names it when it is wrong.

An option that is not in the tables below must be in another file of this folder, in a run and in a `says`.
"""

import json
import pathlib
import re
import unittest

from support import CliTest, points, without_timing

FREE_TEXT = {"--title", "--author"}  # no text is wrong
NOT_OURS = {"--help", "--version"}


def listed(help_text):
    return re.findall(r"^ +(?:-\w,? )?(--[a-z0-9][a-z0-9-]*)", help_text, re.MULTILINE)


class OptionsTest(CliTest):
    def setUp(self):
        super().setUp()
        rows = ["x,y,z,noise,classification"]
        single = points(2, n=600, lift=0.01)
        layered = single + [(x, y, z + 4) for x, y, z in single if x < 4 and y < 6]
        for name, scan in [("a.csv", points(1, n=600)), ("b.csv", layered)]:
            self.write(name, rows + ["%r,%r,%r,%r,%d" % (x, y, z, 0.05 if x < 12 else 0.1, 2 + i % 5 // 4)
                                     for i, (x, y, z) in enumerate(scan)])
        self.write("pose.txt", ["1 0 0 0.5", "0 1 0 0", "0 0 1 -0.5", "0 0 0 1"])
        self.write("cores.xyz", points(1)[:7])
        self.write("options.txt", ["crop = [2, 2, 20, 15]"])
        self.write("lid.obj", ["v 0 0 9", "v 24 0 9", "v 24 18 9", "v 0 18 9", "v 12 9 99", "f 1 2 3", "f 1 3 4"])

    def seen(self, verb, way, words):
        """What a run shows: its numbers, its text, its messages, its files or its exit code."""
        pair = ("a.csv", "lid.obj" if "--mesh" in words or way == "mesh" else "b.csv")
        if way in ("numbers", "mesh"):
            result = json.loads(self.run_cli(verb, *pair, *words, "--json", "-").stdout)
            for key in ["parameters", "timing_s", "tool", "inputs"]:
                result.pop(key)
            return json.dumps(result)
        if way == "stdout":
            return self.run_cli(verb, *pair, *words).stdout
        if way == "stderr":
            return self.run_cli(verb, *pair, *words).stderr
        if way == "files":
            self.run_cli(verb, *pair, *words)
            found = {str(p.relative_to(self.folder)): p.read_bytes() for p in self.path("out").rglob("*")} if self.path("out").exists() else {}
            return {name: data for name, data in found.items() if not name.endswith((".json", ".html"))}
        raise AssertionError(way)

    def check(self, verb, acts, wrong):
        """acts: option -> (way, words without it, words with it); wrong: option -> words that are refused."""
        known = {}
        for option, (way, without, words) in acts.items():
            with self.subTest(verb=verb, acts=option):
                self.assertIn(option, words)
                key = (way, *without)
                if key not in known:
                    known[key] = self.seen(verb, way, without)
                self.assertNotEqual(known[key], self.seen(verb, way, words))
        for option, words in wrong.items():
            with self.subTest(verb=verb, wrong=option):
                before = sorted(self.folder.rglob("*"))
                run = self.run_cli(verb, "a.csv", "b.csv", *words, code=None)
                self.assertIn(run.returncode, (2, 3))
                self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
                self.assertTrue(option in run.stderr or words[-1] in run.stderr, run.stderr)
                self.assertEqual(sorted(self.folder.rglob("*")), before)

    def check_all_are_here(self, verb, acts, wrong):
        elsewhere = "".join(p.read_text() for p in pathlib.Path(__file__).parent.glob("*_test.py")
                            if p.name != pathlib.Path(__file__).name)
        options = listed(self.run_cli(verb, "--help").stdout)
        self.assertGreater(len(options), 20)
        for option in options:
            if option in NOT_OURS:
                continue
            with self.subTest(verb=verb, option=option):
                quoted = re.escape('"' + option)
                self.assertTrue(option in acts or re.search(rf"(run_cli|result)\([^)]*{quoted}|\({quoted}", elsewhere))
                self.assertTrue(option in wrong or option in FREE_TEXT or re.search(rf"says=\[[^]]*{quoted}", elsewhere)
                                or re.search(rf'\({quoted}", "', elsewhere))


SIGMAS = ["--sigma1", "0.05", "--sigma2", "0.05"]
CORRELATED = [*SIGMAS, "--uncertainty-model", "correlated", "--correlation-range", "4"]
SHIFT = ["--uncertainty-model", "registration", "--registration-error", "0.1"]
CURRENTS = ["--measure", "currents", "--sigma", "3"]
OUT = ["-o", "out"]

# What compare and distance have in common.
ACTS = {
    "--output": ("files", [], ["--output", "out"]),
    "--json": ("stdout", [], ["--json", "-"]),
    "--direction": ("numbers", [], ["--direction", "0.1,0,1"]),
    "--duplicates": ("numbers", [], ["--duplicates", "max"]),
    "--class": ("numbers", [], ["--class", "2"]),
    "--crop": ("numbers", [], ["--crop", "2,2,20,15"]),
    "--unit": ("stdout", [], ["--unit", "mm"]),
    "--pose": ("numbers", [], ["--pose", "pose.txt"]),
    "--quiet": ("stdout", [], ["--quiet"]),
    "--verbose": ("stderr", [], ["--verbose"]),
    "--progress": ("stderr", [], ["--progress", "json"]),
    "--config": ("numbers", [], ["--config", "options.txt"]),
}
WRONG = {
    "--output": ["--output="], "--json": ["--json="], "--direction": ["--direction", "up"],
    "--duplicates": ["--duplicates", "some"], "--class": ["--class", "300"], "--pose": ["--pose", "nowhere.txt"],
    "--threads": ["--threads", "x"], "--progress": ["--progress", "loud"], "--config": ["--config", "nowhere.txt"],
    "--allow-crs": ["--allow-crs=maybe"], "--quiet": ["--quiet=maybe"], "--verbose": ["--verbose=maybe"],
}


class Compare(OptionsTest):
    ACTS = {
        **ACTS,
        "--palette": ("files", OUT, [*OUT, "--palette", "purple-orange"]),
        "--flip-palette": ("files", OUT, [*OUT, "--flip-palette"]),
        "--title": ("files", OUT, [*OUT, "--title", "Other"]),
        "--author": ("files", OUT, [*OUT, "--author", "A. Surveyor"]),
        "--range": ("files", OUT, [*OUT, "--range", "9"]),
        "--extent": ("files", OUT, [*OUT, "--extent", "-5,-5,30,30"]),
        "--svg": ("files", OUT, [*OUT, "--svg"]),
        "--pdf": ("files", OUT, [*OUT, "--pdf", "out/two.pdf"]),
        "--map-width": ("files", OUT, [*OUT, "--map-width", "800"]),
        "--surface": ("numbers", [], ["--surface", "overlay"]),
        "--measure": ("numbers", [], CURRENTS),
        "--sigma": ("numbers", ["--measure", "currents"], CURRENTS),
        "--currents-error": ("numbers", CURRENTS, [*CURRENTS, "--currents-error", "0.01"]),
        "--weight": ("numbers", [], ["--weight", "x"]),
        "--interpolation": ("numbers", [], ["--interpolation", "cubic"]),
        "--domain": ("numbers", [], ["--domain", "hull"]),
        "--border": ("numbers", [], ["--border", "hull"]),
        "--max-edge": ("numbers", [], ["--max-edge", "1.5"]),
        "--folds": ("numbers", [], ["--folds", "keep"]),
        "--locate": ("numbers", [], ["--locate", "tree"]),
        "--sigma1": ("numbers", SIGMAS, ["--sigma1", "@noise", "--sigma2", "0.05"]),
        "--sigma2": ("numbers", SIGMAS, ["--sigma1", "0.05", "--sigma2", "@noise"]),
        "--lod": ("numbers", [], ["--lod", "0.1"]),
        "--confidence": ("numbers", SIGMAS, [*SIGMAS, "--confidence", "0.9"]),
        "--uncertainty-model": ("numbers", SIGMAS, [*SIGMAS, "--uncertainty-model", "independent"]),
        "--correlation-range": ("numbers", CORRELATED, [*CORRELATED[:-1], "5"]),
        "--correlation": ("numbers", CORRELATED, [*CORRELATED, "--correlation", "gaussian"]),
        "--registration-error": ("numbers", SHIFT, [*SHIFT[:-1], "0.2"]),
        "--noise-floor": ("numbers", [], ["--noise-floor"]),
        "--match": ("numbers", [], ["--match"]),
        "--objective": ("numbers", ["--match"], ["--match", "--objective", "icp-plane"]),
        "--overlap": ("numbers", ["--match"], ["--match", "--overlap", "0.5"]),
        "--freedom": ("numbers", ["--match"], ["--match", "--freedom", "z"]),
    }
    WRONG = {
        **WRONG,
        "--palette": ["--palette", "mud"], "--report-vertices": ["--report-vertices", "-1"], "--map-width": ["--map-width", "3"],
        "--crop": ["--crop", "9,0,1,1"], "--unit": ["--unit", "furlong"],
        "--surface": ["--surface", "round"], "--measure": ["--measure", "W"], "--sigma": ["--sigma", "3"],
        "--currents-error": ["--currents-error", "0.01"], "--weight": ["--weight", "x +"],
        "--interpolation": ["--interpolation", "quintic"], "--domain": ["--domain", "all"], "--border": ["--border", "soft"],
        "--max-edge": ["--max-edge", "-1"], "--locate": ["--locate", "luck"], "--min-coverage": ["--min-coverage", "2"],
        "--fail-above": ["--fail-above", "p0=1"], "--sigma1": ["--sigma1", "-1", "--sigma2", "1"],
        "--sigma2": ["--sigma1", "1", "--sigma2", "@nothing"], "--lod": ["--lod", "0"],
        "--confidence": [*SIGMAS, "--confidence", "95"], "--uncertainty-model": ["--uncertainty-model", "vague"],
        "--correlation-range": ["--correlation-range", "3"], "--correlation": ["--correlation", "square"],
        "--registration-error": ["--registration-error", "0.1"], "--noise-floor": ["--noise-floor", "--surface", "overlay"],
        "--objective": ["--match", "--objective", "luck"], "--coarse": ["--coarse"], "--overlap": ["--match", "--overlap", "2"],
        "--freedom": ["--match", "--freedom", "up"], "--max-iterations": ["--match", "--max-iterations", "0"],
        "--tolerance": ["--match", "--tolerance", "0"], "--accept-doubt": ["--accept-doubt"],
        "--folds": ["--folds", "cut"], "--visible": ["--visible"],
        "--no-layer-check": ["--no-layer-check=maybe"], "--no-map": ["--no-map=maybe"],
        "--no-cells": ["--no-cells=maybe"], "--no-points": ["--no-points=maybe"], "--flip-palette": ["--flip-palette=maybe"],
        "--match": ["--match=maybe"], "--range": ["--range", "0"], "--extent": ["--extent", "1,1,0,2"], "--svg": ["--svg"],
        "--pdf": ["--pdf", ""], "--report": [*OUT, "--report", "long"], "--logo": [*OUT, "--logo", "nowhere.png"],
    }

    def test_acts_and_wrong(self):
        self.check("compare", self.ACTS, self.WRONG)

    def test_all_are_here(self):
        self.check_all_are_here("compare", self.ACTS, self.WRONG)

    def test_layers(self):
        """A box: above its floor lies its lid."""
        box = [(x / 3, y / 3, z) for x in range(60) for y in range(60) for z in (0, 5)]
        self.write("box.xyz", box)
        self.assertIn("several layers", self.run_cli("compare", "box.xyz", "box.xyz", "--duplicates", "min").stdout
                      + self.run_cli("compare", "box.xyz", "box.xyz", "--duplicates", "min").stderr)
        run = self.run_cli("compare", "box.xyz", "box.xyz", "--duplicates", "min", "--no-layer-check")
        self.assertNotIn("several layers", run.stdout + run.stderr)

    def test_allow_crs(self):
        for verb in ["compare", "distance"]:
            self.write("a.asc", ["ncols 9", "nrows 9", "xllcorner 10", "yllcorner 50", "cellsize 0.01"] + ["1 2 3 1 2 3 1 2 3"] * 9)
            self.path("a.prj").write_text('GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],'
                                          'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]')
            self.fails(3, verb, "a.asc", "a.asc", says=["a.asc", "--allow-crs"])
            self.run_cli(verb, "a.asc", "a.asc", "--allow-crs")

    def test_options_are_checked_before_the_matching(self):
        """What is wrong is said at once, and the files, which are not there, are never looked for."""
        for words, says in [(["--sigma1", "0.1"], "--sigma2"), (["--sigma2", "0.1"], "--sigma1"),
                            (["--uncertainty-model", "independent"], "--uncertainty-model"),
                            (["--surface", "overlay", "--interpolation", "cubic"], "--interpolation"),
                            (["--sigma", "3"], "--sigma"), (["--weight", "x +"], "--weight"),
                            (["--noise-floor", "--interpolation", "cubic"], "--noise-floor")]:
            for more in [["--match"], []]:
                with self.subTest(words=words):
                    self.fails(2, "compare", "no-a.xyz", "no-b.xyz", *more, *words, says=[says])
        # What the matching itself will bring is not missed.
        self.fails(3, "compare", "no-a.xyz", "no-b.xyz", "--match", *SIGMAS, says=["no-a.xyz"])
        self.fails(3, "compare", "no-a.xyz", "no-b.xyz", "--match", "--objective", "currents", "--sigma", "3", says=["no-a.xyz"])
        self.fails(2, "compare", "no-a.xyz", "no-b.xyz", *SIGMAS, "--uncertainty-model", "registration",
                   says=["--registration-error"])


M3C2 = ["--measure", "m3c2", "--normal-scale", "4", "--projection-scale", "3", "--max-depth", "2"]
HAUSDORFF = ["--measure", "hausdorff", "--tolerance", "1"]


class Distance(OptionsTest):
    ACTS = {
        **ACTS,
        "--format": ("files", OUT, ["-o", "out", "--format", "csv"]),
        "--mesh": ("mesh", [], ["--mesh", "delaunay"]),
        "--measure": ("numbers", [], ["--measure", "c2s"]),
        "--tolerance": ("numbers", ["--measure", "hausdorff"], HAUSDORFF),
        "--samples": ("numbers", ["--measure", "surface"], ["--measure", "surface", "--samples", "50"]),
        "--normal-scale": ("numbers", M3C2, [*M3C2[:3], "6", *M3C2[4:]]),
        "--projection-scale": ("numbers", M3C2, [*M3C2[:5], "5", *M3C2[6:]]),
        "--max-depth": ("numbers", M3C2, [*M3C2[:7], "0.05"]),
        "--registration-error": ("numbers", M3C2, [*M3C2, "--registration-error", "0.25"]),
        "--core-points": ("numbers", M3C2, [*M3C2, "--core-points", "cores.xyz"]),
    }
    WRONG = {
        **WRONG,
        "--format": ["--format", "doc"],
        "--crop": ["--crop", "1,2"],
        "--unit": ["--unit", "mile"], "--mesh": ["--mesh", "voxels"],
        "--measure": ["--measure", "c2x"], "--tolerance": ["--tolerance", "0"], "--samples": ["--samples", "0"],
        "--normal-scale": ["--normal-scale", "-1"], "--projection-scale": ["--projection-scale", "0"],
        "--max-depth": ["--max-depth", "deep"], "--registration-error": ["--registration-error", "-1"],
        "--core-points": [*M3C2, "--core-points", "nowhere.xyz"],
    }

    def test_acts_and_wrong(self):
        self.check("distance", self.ACTS, self.WRONG)

    def test_all_are_here(self):
        self.check_all_are_here("distance", self.ACTS, self.WRONG)

    def test_options_are_checked_before_the_files(self):
        for words, says in [(["--measure", "m3c2"], "--normal-scale"), (M3C2[:4], "--projection-scale"), (M3C2[:6], "--max-depth"),
                            (["--samples", "5"], "--samples")]:
            self.fails(2, "distance", "no-a.xyz", "no-b.xyz", *words, says=[says])

    def test_threads_give_the_same(self):
        texts = {without_timing(self.run_cli("distance", "a.csv", "b.csv", "--threads", n, "--json", "-").stdout) for n in [1, 3]}
        self.assertEqual(len(texts), 1)


if __name__ == "__main__":
    unittest.main()
