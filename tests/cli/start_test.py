"""GDAL and the hundred libraries behind it are loaded by what needs them, and by nothing else.

The system's loader says what it loads (LD_DEBUG, of glibc); elsewhere nothing is tested here."""

import json
import os
import re
import subprocess
import unittest

from support import BIN, CliTest, points

SQUARE = {"type": "Polygon", "coordinates": [[[2, 2], [20, 2], [20, 16], [2, 16], [2, 2]]]}
GRID = ["ncols 20", "nrows 20", "xllcorner 0", "yllcorner 0", "cellsize 1"]


class StartTest(CliTest):
    def setUp(self):
        super().setUp()
        if not any(name.startswith("libc.") for name in self.loaded("--version")):
            self.skipTest("the loader does not say what it loads")

    def loaded(self, *words):
        """Names of the shared libraries that a run loads."""
        run = subprocess.run([BIN, *words], cwd=self.folder, capture_output=True, text=True, timeout=60,
                             env={**os.environ, "LD_DEBUG": "files"})
        self.assertEqual(run.returncode, 0, run.stderr[-2000:])
        return {path.rsplit("/", 1)[-1] for path in re.findall(r"calling init: (\S+)", run.stderr)}

    def gdal(self, *words):
        """Name of the GDAL that a run loads; None if it loads none."""
        return next((name for name in self.loaded(*words) if name.startswith("libgdal.")), None)

    def ply(self, name, cloud):
        header = ["ply", "format ascii 1.0", f"element vertex {len(cloud)}", "property double x", "property double y",
                  "property double z", "end_header"]
        return self.write(name, header + cloud)

    def test_start_loads_neither_gdal_nor_what_is_behind_it(self):
        for words in (["--version"], ["--help"], ["compare", "--help"]):
            names = self.loaded(*words)
            for library in ("libgdal.", "libproj.", "libcurl", "libgeos", "libsqlite3."):
                self.assertFalse([name for name in names if name.startswith(library)], (words, library))
            self.assertLess(len(names), 60)

    def test_points_and_meshes_load_no_gdal(self):
        a, b = self.scans()
        self.assertIsNone(self.gdal("compare", a, b, "-o", "out"))
        self.ply("a.ply", points(1))
        self.ply("b.ply", points(2, lift=0.5))
        self.assertIsNone(self.gdal("compare", "a.ply", "b.ply", "--json", "-"))
        self.assertIsNone(self.gdal("convert", "a.ply", "a.las"))
        self.assertIsNone(self.gdal("compare", "a.las", "b.ply", "--json", "-"))
        self.write("g.asc", GRID + [" ".join(["1.5"] * 20)] * 20)
        self.assertIsNone(self.gdal("info", "g.asc"))

    def test_polygons_rasters_and_crs_load_gdal(self):
        a, b = self.scans()
        self.path("field.geojson").write_text(json.dumps(SQUARE))
        self.assertIsNotNone(self.gdal("compare", a, b, "--include", "field.geojson", "--json", "-"))
        self.write("g.asc", GRID + [" ".join(["1.5"] * 20)] * 20)
        self.assertIsNotNone(self.gdal("convert", "g.asc", "g.tif"))
        self.assertIsNotNone(self.gdal("info", "g.tif"))
        self.path("g.prj").write_text('PROJCS["local",GEOGCS["GCS",DATUM["D",SPHEROID["S",6378137.0,298.25]],'
                                      'PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],'
                                      'PROJECTION["Transverse_Mercator"],UNIT["Meter",1.0]]')
        self.assertIsNotNone(self.gdal("info", "g.asc"))

    def test_libraries_beside_the_data_are_not_loaded(self):
        self.write("g.asc", GRID + [" ".join(["1.5"] * 20)] * 20)
        library = self.gdal("convert", "g.asc", "g.tif")
        for name in self.loaded("--version") | {library}:
            self.path(name).write_bytes(b"")
        self.assertEqual(self.gdal("info", "g.tif"), library)

    def test_a_gdal_that_cannot_be_loaded_is_named(self):
        a, b = self.scans()
        self.path("field.geojson").write_text(json.dumps(SQUARE))
        self.write("g.asc", GRID + [" ".join(["1.5"] * 20)] * 20)
        library = self.gdal("convert", "g.asc", "g.tif")
        self.path("empty").mkdir()
        (self.path("empty") / library).write_bytes(b"")
        env = {**os.environ, "LD_LIBRARY_PATH": str(self.path("empty"))}
        if self.run_cli("info", "g.tif", code=None, env=env).returncode == 0:
            self.skipTest("GDAL lies where the loader does not look by itself, so it is known by its whole path")
        for words in (["info", "g.tif"], ["convert", "g.asc", "out.tif"], ["compare", a, b, "--mask", "g.tif"],
                      ["compare", a, b, "--include", "field.geojson"], ["compare", a, b, "--weight", "g.tif"]):
            run = self.run_cli(*words, code=3, env=env)
            self.assertEqual(run.stdout, "")
            self.assertRegex(run.stderr, r"^isopach: \S+: (reading|writing) (a raster|polygons) needs GDAL, which cannot be "
                                         r"loaded \(.*" + re.escape(library) + r".*\): install it \(package libgdal.*\)\n$")
            self.assertFalse(self.path("out.tif").exists())
        self.run_cli("compare", a, b, env=env)


if __name__ == "__main__":
    unittest.main()
