"""Every file of the shared collection of formats, whole and cut short: read, or refused with exit 3 and one line that
names it; never a crash, a hang, or memory without bound."""

import resource
import subprocess
import unittest

from support import BIN, SHARED, CliTest

FORMATS = SHARED / "data" / "formats"
MEMORY = 4 << 30  # address space; threads reserve much of it without using it
SECONDS = 20

# Files without one usable point, or that lie about their size: never to be taken for a scan.
BROKEN = ["assimp/empty.ply", "pdal-las/1.2-no-points.las", "lazperf/no-points-1.3.laz", "trimesh/empty.stl",
          "trimesh/obj_empty.obj", "trimesh/ply_empty_ascii.ply", "trimesh/ply_empty_bin.ply",
          "trimesh/stl_empty_ascii.stl", "SOURCE.txt"]


@unittest.skipUnless(FORMATS.is_dir(), "the shared data is not there")
class Formats(CliTest):
    def look_at(self, path, name):
        """Exit code of info; checks what holds for every file."""
        run = subprocess.run([BIN, "info", path, "--json", "-"], cwd=self.folder, capture_output=True, text=True,
                             timeout=SECONDS,
                             preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)))
        self.assertIn(run.returncode, (0, 3), f"{name}: {run.stderr}")
        if run.returncode == 3:
            self.assertEqual(run.stderr.count("\n"), 1, f"{name}: {run.stderr}")
            self.assertIn(str(path), run.stderr)
            self.assertEqual(run.stdout, "", name)
        return run.returncode

    def test_whole(self):
        files = sorted(p for p in FORMATS.rglob("*") if p.is_file())
        self.assertGreater(len(files), 50)
        codes = {}
        for path in files:
            name = str(path.relative_to(FORMATS))
            with self.subTest(file=name):
                codes[name] = self.look_at(path, name)
        for name in BROKEN:
            if name in codes:
                with self.subTest(broken=name):
                    self.assertEqual(codes[name], 3)

    def test_cut_short(self):
        for path in sorted(p for p in FORMATS.rglob("*") if p.suffix in {".ply", ".las", ".laz", ".pcd", ".stl"}):
            data = path.read_bytes()
            short = self.path("cut" + path.suffix)
            short.write_bytes(data[:len(data) * 2 // 3])
            with self.subTest(file=str(path.relative_to(FORMATS))):
                self.look_at(short, path.name)


if __name__ == "__main__":
    unittest.main()
