"""Comparisons in tiles: the bytes of compare, whatever the tiles, whoever runs them, and however often they are killed."""

import json
import math
import os
import random
import re
import shutil
import signal
import subprocess
import time
import unittest

from support import BIN, CliTest


def told(text):
    """A result without what counts the work of one way of doing it."""
    result = json.loads(text)
    result.pop("timing_s"), result.pop("outputs")
    result["localisation"] = {}
    return result


class Tiles(CliTest):
    def setUp(self):
        super().setUp()
        self.run_cli("simulate", "terrain", "--points", "6000", "-o", "scans")
        self.a, self.b = "scans/a.ply", "scans/b.ply"

    def whole(self, *words):
        return told(self.run_cli("compare", self.a, self.b, "--json", "-", *words).stdout)

    def plan(self, *words, job="job", code=0):
        return self.run_cli("tile", "plan", self.a, self.b, "-o", job, *words, code=code)

    def reduced(self, *words, job="job"):
        return told(self.run_cli("tile", "reduce", job, "--json", "-", *words).stdout)

    def test_any_tiling_gives_the_whole(self):
        whole = self.whole()
        for points in ["100000", "4000", "700", "30"]:
            with self.subTest(points):
                self.plan("--tile-points", points, job=f"job{points}")
                self.run_cli("tile", "run", f"job{points}")
                self.assertEqual(self.reduced(job=f"job{points}"), whole)

    def test_options_keep_their_meaning(self):
        for words in [["--border", "hull"], ["--max-edge", "30"], ["--no-layer-check"], ["--duplicates", "max"],
                      ["--crop", "412100,5236100,412800,5236900"], ["--measure", "dV"], ["--unit", "ft"],
                      ["--direction=0,0,-1"], ["--folds", "keep"]]:
            with self.subTest(words):
                whole = self.whole(*words)
                self.plan("--tile-points", "2500", *words)
                self.run_cli("tile", "run", "job")
                self.assertEqual(self.reduced(), whole)
                shutil.rmtree(self.path("job"))

    def test_options_of_a_file_go_along(self):
        """What --config gives is known to run and reduce, wherever they are called, and whatever becomes of the file."""
        self.path("pose.txt").write_text("1 0 0 2\n0 1 0 1\n0 0 1 0.5\n0 0 0 1\n")
        self.path("options.toml").write_text('border = "hull"\nmax-edge = 80\nno-layer-check = true\npose = "pose.txt"\n')
        whole = self.whole("--config", "options.toml")
        self.assertEqual(whole["border"]["rule"], "hull")
        self.plan("--tile-points", "2500", "--config", "options.toml")
        self.path("options.toml").unlink(), self.path("pose.txt").unlink()
        os.mkdir(self.path("elsewhere"))
        for step in (["run"], ["reduce", "--json", "../found.json"]):
            subprocess.run([BIN, "tile", step[0], "../job", "--quiet", *step[1:]], cwd=self.path("elsewhere"), check=True)
        self.assertEqual(told(self.path("found.json").read_text()), whole)

    def test_a_pose_and_limits_go_along(self):
        self.path("pose.txt").write_text("0 -1 0 5000\n1 0 0 7\n0 0 1 3\n0 0 0 1\n")
        self.run_cli("convert", self.b, "turned.ply", "--pose", "pose.txt")
        self.path("back.txt").write_text("0 1 0 -7\n-1 0 0 5000\n0 0 1 -3\n0 0 0 1\n")
        self.b = "turned.ply"
        whole = self.whole("--pose", "back.txt")
        self.plan("--tile-points", "2500", "--pose", "back.txt", "--fail-above", "rms=0.001")
        self.run_cli("tile", "run", "job")
        done = self.run_cli("tile", "reduce", "job", "--json", "-", code=6)
        self.assertEqual(told(done.stdout), whole)
        self.assertIn("rms", done.stderr)

    def test_a_raster_seen_from_the_side_is_no_raster(self):
        """Along z a raster has one height a cell; from the side, or posed, its folds are looked for."""
        rows = [" ".join(f"{80 + 20 * math.sin(x / 9) * math.cos(y / 7) + (5 if x > 40 else 0):.3f}" for x in range(60))
                for y in range(60)]
        for name, lift in (("a", 0), ("b", 1)):
            rows[30 + lift] = " ".join(["70"] * 60)
            self.path(f"{name}.asc").write_text("ncols 60\nnrows 60\nxllcorner 0\nyllcorner 0\ncellsize 1\n" + "\n".join(rows) + "\n")
        self.path("pose.txt").write_text("1 0 0 0\n0 1 0 0\n0 0 1 0.25\n0 0 0 1\n")
        self.a, self.b = "a.asc", "b.asc"
        found = {}
        for name, words in (("above", []), ("side", ["--direction=x"]), ("posed", ["--pose", "pose.txt"])):
            with self.subTest(name):
                whole = self.whole(*words)
                self.plan("--tile-points", "900", *words, job=name)
                self.run_cli("tile", "run", name)
                self.assertEqual(self.reduced(job=name), whole)
                found[name] = whole["folds"]["area"]
        self.assertGreater(found["side"], 0)

    def test_what_lies_beyond_the_other_scan_stays_in_its_tile(self):
        """A scan that reaches far beyond the other one: the join holds little of it."""
        self.run_cli("simulate", "terrain", "--points", "60000", "-o", "large")
        self.run_cli("convert", "large/b.ply", "part.xyz")
        rows = [row for row in self.path("part.xyz").read_text().splitlines(keepends=True) if row[0] in "-0123456789"]
        low_x, low_y = (min(float(row.split()[k]) for row in rows) for k in (0, 1))
        near = [row for row in rows if float(row.split()[0]) < low_x + 300 and float(row.split()[1]) < low_y + 300]
        self.path("part.xyz").write_text("".join(near))
        self.a, self.b = "large/a.ply", "part.xyz"
        whole = self.whole("--unit", "m")
        passed_up = {}
        for name in ("knowing", "ignorant"):
            self.plan("--tile-points", "8000", "--unit", "m", job=name)
            if name == "ignorant":
                manifest = json.loads(self.path("ignorant/manifest.json").read_text())
                for scan in manifest["inputs"]:
                    scan["hull"] = []
                self.path("ignorant/manifest.json").write_text(json.dumps(manifest))
            self.run_cli("tile", "run", name)
            self.assertEqual(self.reduced(job=name), whole)
            passed_up[name] = sum(file.stat().st_size for file in self.path(f"{name}/tiles").glob("*.part"))
        self.assertLess(passed_up["knowing"], passed_up["ignorant"] / 2)

    def test_sets_of_files(self):
        """A scan in four files, in any order, is the scan."""
        whole = self.whole()
        lines = self.run_cli("convert", self.a, "a.xyz")
        rows = self.path("a.xyz").read_text().splitlines(keepends=True)
        rows = [row for row in rows if row[0] in "-0123456789"]
        os.mkdir(self.path("parts"))
        for k in range(4):
            self.path(f"parts/{k}.xyz").write_text("".join(rows[k::4]))
        self.a = "parts"
        self.plan("--tile-points", "3000", "--unit", "m")
        self.run_cli("tile", "run", "job")
        found = self.reduced()
        for key in ("domain", "measure", "volume", "difference", "border", "folds", "triangulations"):
            self.assertEqual(found[key], whole[key], key)
        self.assertEqual(lines.returncode, 0)

    def test_max_memory_takes_tiles_where_they_are_needed(self):
        whole = self.whole()
        self.run_cli("simulate", "terrain", "--points", "1200000", "-o", "large")
        large = [f"large/{name}.ply" for name in "ab"]
        expected = told(self.run_cli("compare", *large, "--json", "-").stdout)
        temporary = self.path("temporary")
        temporary.mkdir()
        done = subprocess.run([BIN, "compare", *large, "--json", "-", "--max-memory", "310M"], cwd=self.folder,
                              env={**os.environ, "TMPDIR": str(temporary)}, capture_output=True, text=True, check=True)
        self.assertEqual(told(done.stdout), expected)
        self.assertEqual(os.listdir(temporary), [])
        small = told(self.run_cli("compare", self.a, self.b, "--json", "-", "--max-memory", "400M").stdout)
        self.assertEqual(small, whole)

    def test_killed_at_any_time_and_run_again(self):
        whole = self.whole()
        self.plan("--tile-points", "60")
        chance = random.Random(1)
        for _ in range(12):
            runs = [subprocess.Popen([BIN, "tile", "run", "job", "--quiet", "--threads", "1"], cwd=self.folder)
                    for _ in range(2)]
            time.sleep(chance.uniform(0.02, 0.15))
            for run in runs:
                run.send_signal(signal.SIGKILL)
                run.wait()
        self.run_cli("tile", "run", "job", "--missing")
        self.assertEqual(self.reduced(), whole)

    def test_several_runs_share_a_job(self):
        self.plan("--tile-points", "300")
        n = json.loads(self.run_cli("tile", "status", "job", "--json", "-").stdout)["tiles"]
        order = list(range(n))
        random.Random(2).shuffle(order)
        runs = [subprocess.Popen([BIN, "tile", "run", "job", "--quiet", "--threads", "1", "--index",
                                  ",".join(map(str, order[k::3]))], cwd=self.folder) for k in range(3)]
        self.assertEqual([run.wait() for run in runs], [0, 0, 0])
        self.assertEqual(self.reduced(), self.whole())

    def test_missing_tiles_are_refused_unless_told(self):
        self.plan("--tile-points", "2000")
        self.run_cli("tile", "run", "job")
        self.path("job/tiles/000003.part").unlink()
        self.fails(3, "tile", "reduce", "job", "--json", "-", says=["--missing", "--allow-missing", "is 3"])
        found = self.reduced("--allow-missing")
        self.assertTrue(any("1 of" in warning and "missing" in warning for warning in found["warnings"]))
        self.assertLess(found["inputs"][0]["nodes"], 6000)
        self.run_cli("tile", "run", "job", "--missing")
        self.assertEqual(self.reduced(), self.whole())

    def test_what_changed_or_is_damaged_is_refused(self):
        self.plan("--tile-points", "2000")
        self.run_cli("tile", "run", "job")
        part = self.path("job/tiles/000001.part")
        good = part.read_bytes()
        flipped = good[:500] + bytes([good[500] ^ 64]) + good[501:]
        for number, bad in enumerate([good[:-8], good[:100], b"", flipped, good + b"\0" * 8]):
            with self.subTest(number):
                part.write_bytes(bad)
                self.fails(3, "tile", "reduce", "job", says=["000001.part"])
        part.write_bytes(good)
        cells = self.path("job/tiles/000001.cells")
        kept = cells.read_bytes()
        cells.write_bytes(kept[: len(kept) // 2])
        self.fails(3, "tile", "reduce", "job", says=["000001.cells"])
        cells.write_bytes(kept)
        os.utime(self.path(self.a))
        for words in [["run", "job"], ["reduce", "job"]]:
            self.fails(3, "tile", *words, says=["a.ply", "changed"])
        self.path("job/manifest.json").write_text("{}")
        self.fails(3, "tile", "status", "job", says=["manifest.json"])

    def test_parts_of_another_job_are_not_taken(self):
        self.plan("--tile-points", "2000")
        self.run_cli("tile", "run", "job")
        self.plan("--tile-points", "2000", "--border", "hull", job="other")
        self.run_cli("tile", "run", "other")
        shutil.copy(self.path("job/tiles/000001.part"), self.path("other/tiles/000001.part"))
        self.fails(3, "tile", "reduce", "other", says=["another job"])

    def test_help(self):
        overview = self.run_cli("tile", "--help").stdout
        own = set()
        for step in ["plan", "run", "status", "reduce", "script"]:
            self.assertIn(f"\n  {step} ", overview)
            text = self.run_cli("tile", step, "--help").stdout
            for word in [f"Usage: isopach tile {step}", "--threads", "--config"]:
                self.assertIn(word, text)
            self.assertLessEqual(max(map(len, text.splitlines())), 120)
            own |= set(re.findall(r"^ +(?:-\w )?(--[a-z-]+)", text, re.M))
        compare = set(re.findall(r"^ +(?:-\w )?(--[a-z-]+)", self.run_cli("compare", "--help").stdout, re.M))
        listed = set(re.findall(r"^ +(?:-\w )?(--[a-z-]+)", overview, re.M))
        self.assertEqual(own - compare, listed - compare)

    def test_refusals(self):
        self.fails(2, "tile", says=["plan, run, status"])
        self.fails(2, "tile", "plam", says=["did you mean 'plan'"])
        self.fails(2, "tile", "run", "nowhere", says=["no job"])
        for words in [["--noise-floor"], ["--surface", "overlay"], ["--domain", "hull"],
                      ["--sigma1", "0.1", "--sigma2", "0.1", "--uncertainty-model", "independent"], ["--interpolation", "cubic"]]:
            self.fails(2, "tile", "plan", self.a, self.b, "-o", "job", *words, says=["tiles"])
        self.fails(2, "tile", "plan", self.a, self.b, "-o", "job", "--match", says=["--match"])
        self.fails(2, "tile", "plan", self.a, self.b, "-o", "job", "--direction", "fit", says=["--direction"])
        self.fails(2, "tile", "plan", self.a, self.b, "-o", "job", "--max-memory", "1M", says=["--max-memory"])
        self.fails(3, "tile", "plan", self.a, "nothing.ply", "-o", "job", says=["nothing.ply"])
        self.assertFalse(self.path("job/manifest.json").exists())
        self.plan("--tile-points", "2000", job="fine")
        self.fails(2, "tile", "plan", self.a, self.b, "-o", "fine", says=["not empty"])
        for index in ["99999", "x", "3-", "-1", "5-2x"]:
            self.fails(2, "tile", "run", "fine", f"--index={index}", says=["--index"])

    def test_a_failure_is_told_by_status(self):
        self.plan("--tile-points", "2000")
        points = self.path("job/points")
        whole = points.read_bytes()
        points.write_bytes(whole[: len(whole) // 2])
        self.assertIn("tiles failed", self.run_cli("tile", "run", "job", code=3).stderr)
        said = self.run_cli("tile", "status", "job").stdout
        self.assertIn("failed", said)
        state = json.loads(self.run_cli("tile", "status", "job", "--json", "-").stdout)
        self.assertGreater(state["done"], 0)
        self.assertIn("failed", {tile["state"] for tile in state["each"]})
        points.write_bytes(whole)
        self.run_cli("tile", "run", "job", "--missing")
        self.assertEqual(self.reduced(), self.whole())

    def test_a_plan_that_fails_or_is_killed_leaves_nothing_in_the_way(self):
        self.run_cli("tile", "plan", self.a, "nowhere.ply", "-o", "job", code=3)
        self.assertFalse(self.path("job").exists())
        os.mkfifo(self.path("slow.xyz"))
        plan = subprocess.Popen([BIN, "tile", "plan", self.a, "slow.xyz", "-o", "job"], cwd=self.folder,
                                stderr=subprocess.PIPE)
        time.sleep(0.3)
        plan.send_signal(signal.SIGINT)
        plan.communicate(timeout=60)
        self.assertEqual(plan.returncode, 130)
        self.assertFalse(self.path("job").exists())
        os.makedirs(self.path("job/tiles"))
        self.path("job/points").write_bytes(b"\0" * 240)  # of a plan that was killed
        self.plan("--tile-points", "3000")
        self.run_cli("tile", "run", "job")
        self.assertEqual(self.reduced(), self.whole())
        os.makedirs(self.path("mine/tiles"))
        self.path("mine/tiles/photo.jpg").write_text("mine")
        self.fails(2, "tile", "plan", self.a, self.b, "-o", "mine", says=["not empty"])
        self.assertTrue(self.path("mine/tiles/photo.jpg").exists())

    def test_scripts(self):
        self.plan("--tile-points", "2000")
        n = json.loads(self.run_cli("tile", "status", "job", "--json", "-").stdout)["tiles"]
        slurm = self.run_cli("tile", "script", "job", "--tiles-each", "3", "--program", str(BIN)).stdout
        self.assertIn(f"--array=0-{(n + 2) // 3 - 1}", slurm)
        for task in range((n + 2) // 3):
            subprocess.run(["sh"], input=slurm, text=True, check=True, cwd=self.folder, stdout=subprocess.DEVNULL,
                           env={**os.environ, "SLURM_ARRAY_TASK_ID": str(task)})
        self.assertEqual(self.reduced(), self.whole())
        parallel = self.run_cli("tile", "script", "job", "--engine", "parallel").stdout
        self.assertIn(f"seq 0 {n - 1} ", parallel)
        self.assertIn(f"range({n})", self.run_cli("tile", "script", "job", "--engine", "snakemake").stdout)

    def test_words_of_scripts(self):
        """A folder whose name a shell would take apart, tiles beyond the largest array, and the memory of a tile."""
        name = "it's $HOME `x` \\ \"q\" {}"
        self.plan("--tile-points", "8", job=name)
        n = json.loads(self.run_cli("tile", "status", name, "--json", "-").stdout)["tiles"]
        self.assertGreater(n, 1000)
        slurm = self.run_cli("tile", "script", name, "--program", str(BIN), "--at-once", "7").stdout
        each = -(-n // 1000)
        self.assertIn(f"--array=0-{-(-n // each) - 1}%7\n", slurm)
        megabytes = int(re.search(r"--mem=(\d+)M\n", slurm)[1])
        self.assertTrue(150 < megabytes < 200, megabytes)
        done = subprocess.run(["sh"], input=slurm, text=True, cwd=self.folder, capture_output=True,
                              env={**os.environ, "SLURM_ARRAY_TASK_ID": "0"})
        self.assertEqual((done.returncode, done.stdout), (0, f"{each} tiles done\n"), done.stderr)
        wrap = re.search(r"^# sbatch .*--wrap=(.*)$", slurm, re.M)[1]
        reduce = subprocess.run(["sh", "-c", f"sh -c {wrap}"], cwd=self.folder, capture_output=True, text=True)
        self.assertIn("tiles are not done", reduce.stderr)
        self.fails(2, "tile", "script", name, "--engine", "snakemake", says=["braces", "rename"])
        self.plan("--tile-points", "2000")
        for option in ("--tiles-each", "--at-once"):
            self.fails(2, "tile", "script", "job", "--engine", "snakemake", option, "2", says=[option, "snakemake"])
        self.fails(2, "tile", "script", "job", "--program", "two\nlines", says=["line break"])


if __name__ == "__main__":
    unittest.main()
