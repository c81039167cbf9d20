"""The styles beside layers, loaded by QGIS without a screen: every layer is valid, takes its style by its name, and each of
its features is drawn by one rule. Skipped with a message where QGIS for Python is not installed (python3-qgis)."""

import json
import os
import shutil
import subprocess
import sys
import unittest

from support import CliTest

LOAD = """
import json, os, sys
from qgis.core import QgsApplication, QgsRasterLayer, QgsVectorLayer
app = QgsApplication([], False)
app.initQgis()
found = {}
for name in sys.argv[1:]:
    layer = QgsRasterLayer(name, name) if name.endswith(".tif") else QgsVectorLayer(name, name, "ogr")
    one = found[name] = {"valid": layer.isValid(), "styled": layer.loadDefaultStyle()[1], "renderer": layer.renderer().type()}
    if one["renderer"] == "RuleRenderer":
        rules = layer.renderer().rootRule().children()
        counts = {rule.label(): sum(1 for f in layer.getFeatures(rule.filterExpression())) for rule in rules}
        one.update(features=layer.featureCount(), counts=counts)
print(json.dumps(found), flush=True)
os._exit(0)  # what QGIS tears down at its end crashes without a screen
"""


def python_of_qgis():
    for python in (sys.executable, shutil.which("python3", path="/usr/bin:/usr/local/bin")):
        if python and subprocess.run([python, "-c", "import qgis.core"], capture_output=True).returncode == 0:
            return python
    return None


class Qgis(CliTest):
    def test_every_layer_has_its_style(self):
        python = python_of_qgis()
        if python is None:
            self.skipTest("QGIS for Python is not installed (python3-qgis): styles are not loaded")
        self.scans()
        self.run_cli("tile", "plan", "a.xyz", "b.xyz", "-o", "job", "--tile-points", "150")
        self.run_cli("tile", "run", "job", "--index", "0,2")
        self.path("job/tiles/000001.failed").write_text("no memory\n")
        for kind in ("geojson", "gpkg", "fgb"):
            with self.subTest(kind=kind):
                self.run_cli("compare", "a.xyz", "b.xyz", "-o", "out", "--no-map", "--lod", "0.3", "--changes", "--contours", "0.25",
                             "--outlines", "--raster", "1", "--vectors", kind)
                self.run_cli("tile", "status", "job", "--tiles", f"out/tiles.{kind}")
                names = [f"{name}.{kind}" for name in ("contours", "changes", "outlines", "tiles")] + ["difference.tif"]
                run = subprocess.run([python, "-c", LOAD, *names], cwd=self.path("out"), capture_output=True, text=True, timeout=120,
                                     env={**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(self.folder)})
                self.assertEqual(run.returncode, 0, run.stderr)
                for name, layer in json.loads(run.stdout.strip().splitlines()[-1]).items():
                    self.assertTrue(layer["valid"], name)
                    self.assertTrue(layer["styled"], name)
                    if name.endswith(".tif"):
                        self.assertEqual(layer["renderer"], "singlebandpseudocolor")
                        continue
                    self.assertGreater(layer["features"], 0, name)
                    self.assertEqual(sum(layer["counts"].values()), layer["features"], (name, layer))


if __name__ == "__main__":
    unittest.main()
