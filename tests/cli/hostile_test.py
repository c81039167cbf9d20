"""Inputs that were made, or have happened, to break a reader: each is refused in one line, or read for what it is."""

import json
import os
import resource
import signal
import socket
import struct
import subprocess
import threading
import time
import unittest

from support import BIN, CliTest, points


def pcd(count, cut=0):
    """A binary PCD of `count` points whose last `cut` bytes are missing."""
    header = ("# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
              f"WIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA binary\n").encode()
    body = b"".join(struct.pack("<3f", i % 10, i // 10, 1) for i in range(count))
    return header + body[: len(body) - cut]


class Hostile(CliTest):
    def test_a_raster_whose_geometry_overflows_is_refused(self):
        self.write("a.xyz", points(1))
        self.write("b.xyz", points(2))
        self.write("w.asc", ["ncols 3", "nrows 3", "xllcorner 0", "yllcorner 0", "cellsize 1e308",
                             "1 2 3", "4 5 6", "7 8 9"])
        self.assertIn("w.asc", self.fails(3, "compare", "a.xyz", "b.xyz", "--weight", "w.asc"))
        self.assertIn("w.asc", self.fails(3, "compare", "a.xyz", "b.xyz", "--sigma1", "w.asc", "--sigma2", "0"))

    def test_cells_smaller_than_doubles_resolve_are_refused(self):
        self.write("w.asc", ["ncols 3", "nrows 1", "xllcorner 1e17", "yllcorner 0", "cellsize 0.5", "1 2 3"])
        self.assertIn("double precision", self.fails(3, "info", "w.asc"))

    def test_a_binary_pcd_one_byte_short_is_refused(self):
        self.path("whole.pcd").write_bytes(pcd(100))
        self.path("short.pcd").write_bytes(pcd(100, cut=1))
        self.run_cli("info", "whole.pcd")
        self.assertIn("short.pcd", self.fails(3, "info", "short.pcd"))

    def test_exit_codes_hold_where_standard_error_cannot_be_written(self):
        self.write("a.xyz", points(1))
        with open("/dev/full", "wb") as full:
            done = subprocess.run([BIN, "info", "missing.ply"], cwd=self.folder, stderr=full, stdout=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 3)
        closed = subprocess.run(["sh", "-c", f'"{BIN}" convert a.xyz x.ply --verbose 2>&-'], cwd=self.folder)
        self.assertEqual(closed.returncode, 0)
        self.assertTrue(self.path("x.ply").exists())

    def test_names_that_are_not_utf8_do_not_stop_info(self):
        self.path("a.csv").write_bytes(b"x,y,z,h\xf6he\n0,0,0,1\n1,0,0,1\n0,1,0,1\n")
        done = subprocess.run([BIN, "info", "a.csv", "--json", "-"], cwd=self.folder, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        done.stdout.decode("utf-8")

    def test_escape_sequences_of_a_file_do_not_reach_the_terminal(self):
        ply = ("ply\nformat ascii 1.0\ncomment crs \x1b]0;title\x07\x1b[31m\nelement vertex 3\nproperty float x\n"
               "property float y\nproperty float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n")
        self.path("a.ply").write_text(ply)
        done = self.run_cli("info", "a.ply")
        self.assertFalse([c for c in done.stdout if ord(c) < 32 and c not in "\n\t"], done.stdout)
        self.assertNotIn("\x1b", self.fails(3, "info", "no\x1b[31mfile.ply"))

    def test_a_line_of_many_columns_is_read(self):
        columns = 60000  # one look through all names for each of them would take minutes
        self.write("wide.txt", [" ".join(str((i * k) % 7) for i in range(columns)) for k in (1, 2, 3)])
        self.run_cli("info", "wide.txt")


class Pipes(CliTest):
    """What comes through a pipe or changes while it is read."""

    GRID = ["ncols 3", "nrows 2", "xllcorner 0", "yllcorner 0", "cellsize 1", "1 2 3", "4 5 6"]

    def info(self, name, **options):
        return self.result_of([BIN, "info", name, "--json", "-"], **options)

    def result_of(self, words, **options):
        done = subprocess.run(words, cwd=self.folder, capture_output=True, timeout=60, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        file = json.loads(done.stdout)["files"][0]
        del file["path"]
        return file

    def test_every_format_comes_through_a_pipe_and_a_fifo(self):
        self.write("a.xyz", points(1))
        self.write("a.asc", self.GRID)
        os.mkfifo(self.path("fifo"))
        for name in ["a.ply", "a.las", "a.laz", "a.obj", "a.pcd"]:
            self.run_cli("convert", "a.xyz", name)
        self.run_cli("convert", "a.asc", "a.tif")
        for name in ["a.xyz", "a.ply", "a.las", "a.laz", "a.obj", "a.pcd", "a.asc", "a.tif"]:
            with self.subTest(name=name):
                plain, bytes_ = self.info(name), self.path(name).read_bytes()
                self.assertEqual(self.info("/dev/stdin", input=bytes_), plain)
                writer = threading.Thread(target=self.path("fifo").write_bytes, args=(bytes_,))
                writer.start()
                self.assertEqual(self.info("fifo"), plain)
                writer.join()

    def test_a_las_file_through_a_pipe_is_not_copied(self):
        self.write("a.xyz", points(1))
        self.run_cli("convert", "a.xyz", "a.laz")
        done = subprocess.run(["sh", "-c", f'cat a.laz | "{BIN}" compare /dev/stdin a.laz -o out --no-map --quiet'],
                              cwd=self.folder, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        # The records of B can be copied, those of A came through a pipe.
        self.assertEqual({p.name for p in self.path("out").glob("points*")}, {"points_a.ply", "points_b.ply", "points_b.laz"})

    def test_polygons_come_through_a_pipe(self):
        a, b = self.scans()
        square = {"type": "Polygon", "coordinates": [[[2, 2], [20, 2], [20, 16], [2, 16], [2, 2]]]}
        self.path("field.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"name": "field"}, "geometry": square}]}))
        plain = self.result("compare", a, b, "--budget", "field.geojson")["budget"]
        piped = subprocess.run([BIN, "compare", a, b, "--budget", "/dev/stdin", "--json", "-"], cwd=self.folder,
                               input=self.path("field.geojson").read_bytes(), capture_output=True, timeout=60)
        self.assertEqual(piped.returncode, 0, piped.stderr)
        self.assertEqual([p["net"] for p in json.loads(piped.stdout)["budget"]], [p["net"] for p in plain])

    def test_endless_input_is_refused(self):
        line = self.fails(3, "info", "/dev/zero", "--max-input", "20M", says=["/dev/zero", "20 MB", "--max-input"])
        self.assertIn("raise the limit", line)
        self.write("a.xyz", points(1))
        self.fails(3, "info", "a.xyz", "--max-input", "5k", says=["a.xyz", "5000 bytes"])
        self.run_cli("info", "a.xyz", "--max-input", "1G")
        for size in ["0", "-1", "x", "5q", "k", "nan", "1e30"]:
            self.fails(2, "info", "a.xyz", f"--max-input={size}", says=["--max-input"])

    def test_endless_input_is_refused_by_a_limit_of_memory(self):
        run = self.run_cli("info", "/dev/zero", code=3,
                           preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (600_000_000, 600_000_000)))
        self.assertIn("300 MB", run.stderr)

    def test_ctrl_c_ends_the_wait_for_a_writer(self):
        os.mkfifo(self.path("fifo"))
        for words, opened in [(["info", "fifo"], False), (["info", "fifo"], True)]:
            run = subprocess.Popen([BIN, *words], cwd=self.folder, stderr=subprocess.PIPE, text=True)
            writer = os.open(self.path("fifo"), os.O_RDWR) if opened else None
            time.sleep(0.5)
            self.assertIsNone(run.poll())
            run.send_signal(signal.SIGINT)
            _, err = run.communicate(timeout=20)
            self.assertEqual(run.returncode, 130, err)
            self.assertEqual(err.count("\n"), 1, err)
            if writer is not None:
                os.close(writer)

    def test_a_file_that_is_cut_while_it_is_read(self):
        self.write("whole.xyz", ["%d %d %d" % (i % 1000, i // 1000, i % 7) for i in range(200000)])
        bytes_ = self.path("whole.xyz").read_bytes()
        for wait in [0.001, 0.004, 0.01, 0.02, 0.04]:
            self.path("cut.xyz").write_bytes(bytes_)
            run = subprocess.Popen([BIN, "info", "cut.xyz"], cwd=self.folder, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True)
            time.sleep(wait)
            os.truncate(self.path("cut.xyz"), 100)
            _, err = run.communicate(timeout=60)
            self.assertIn(run.returncode, [0, 3], err)
            self.assertLessEqual(err.count("\n"), 1, err)


class Budgets(CliTest):
    def limited(self, bytes_):
        return lambda: resource.setrlimit(resource.RLIMIT_AS, (bytes_, bytes_))

    def test_a_small_raster_of_many_cells_is_refused(self):
        # A TIFF whose tiles are all left out: 30 000 by 30 000 cells in a few kilobytes.
        side, tile = 30000, 30000 + 16 - 30000 % 16
        tags = [(256, 4, side), (257, 4, side), (258, 3, 32), (259, 3, 1), (262, 3, 1), (277, 3, 1), (322, 4, tile),
                (323, 4, tile), (324, 4, 0), (325, 4, 0), (339, 3, 3)]
        data = struct.pack("<2sHIH", b"II", 42, 8, len(tags))
        for tag, kind, value in tags:
            data += struct.pack("<HHII", tag, kind, 1, value)
        self.path("bomb.tif").write_bytes(data + struct.pack("<I", 0))
        run = self.run_cli("info", "bomb.tif", code=3, preexec_fn=self.limited(1_000_000_000))
        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        self.assertIn("30000 by 30000 cells", run.stderr)

    def test_more_threads_than_can_be_started_are_refused(self):
        a, b = self.scans()
        run = self.run_cli("compare", a, b, "--threads", "4096", code=1, preexec_fn=self.limited(2_000_000_000))
        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        self.assertIn("--threads 4096", run.stderr)
        self.run_cli("compare", a, b, preexec_fn=self.limited(2_000_000_000))

    def test_vector_files_that_name_other_files_are_refused(self):
        a, b = self.scans()
        square = {"type": "Polygon", "coordinates": [[[2, 2], [20, 2], [20, 16], [2, 16], [2, 2]]]}
        self.path("field.geojson").write_text(json.dumps(square))
        self.path("v.vrt").write_text('<OGRVRTDataSource><OGRVRTLayer name="field"><SrcDataSource relativeToVRT="1">'
                                      "field.geojson</SrcDataSource></OGRVRTLayer></OGRVRTDataSource>")
        self.run_cli("compare", a, b, "--budget", "field.geojson")
        self.assertIn("v.vrt", self.fails(3, "compare", a, b, "--budget", "v.vrt"))

    def test_a_crs_that_is_an_address_is_not_looked_up(self):
        a, b = self.scans()
        with socket.create_server(("127.0.0.1", 0)) as server:
            server.settimeout(0.2)
            link = f"http://127.0.0.1:{server.getsockname()[1]}/crs"
            square = {"type": "Polygon", "coordinates": [[[2, 2], [20, 2], [20, 16], [2, 16], [2, 2]]]}
            self.path("field.geojson").write_text(json.dumps(
                {"type": "FeatureCollection", "crs": {"type": "link", "properties": {"href": link, "type": "ogcwkt"}},
                 "features": [{"type": "Feature", "properties": {}, "geometry": square}]}))
            self.run_cli("compare", a, b, "--budget", "field.geojson", code=None)
            with self.assertRaises(OSError):
                server.accept()
            self.write("c.ply", ["ply", "format ascii 1.0", f"comment crs: {link}", "element vertex 3", "property double x",
                                 "property double y", "property double z", "end_header", "0 0 0", "1 0 0", "0 1 1"])
            self.run_cli("convert", "c.ply", "c.las")
            with self.assertRaises(OSError):
                server.accept()

    def test_coordinates_too_small_to_have_areas_are_refused(self):
        self.write("a.xyz", [(x * 1e-160, y * 1e-160, z * 1e-160) for x, y, z in points(1)])
        self.assertIn("a.xyz", self.fails(3, "roughness", "a.xyz", says=["1e-60"]))
        self.fails(3, "compare", "a.xyz", "a.xyz", says=["1e-60"])


class Slivers(CliTest):
    """Long thin triangles. What a query and an overlay look at is counted in tests/distance/surface_tree_test.cpp and
    tests/overlay/overlay_test.cpp; here they would take minutes if they looked at all pairs."""

    def parabola(self, name, count, lift):
        self.write(name, ["%.9f %.9f %g" % (20 * i / count, (20 * i / count) ** 2, lift) for i in range(count)])

    def fan(self, name, count, hub, rim):
        self.write(name, [f"{hub} 0.5 0"] + ["%g %.6f 1" % (rim, i / count) for i in range(count)])

    def test_a_parabola_is_measured(self):
        self.parabola("a.xyz", 20000, 0)
        self.parabola("b.xyz", 20000, 1)
        found = self.result("distance", "a.xyz", "b.xyz", "--measure", "c2s")
        self.assertAlmostEqual(found["c2s"]["a_to_b"]["max"], 1, 9)
        found = self.result("compare", "a.xyz", "b.xyz", "--surface", "overlay")
        self.assertAlmostEqual(found["difference"]["mean"], 1, 9)

    def test_an_overlay_out_of_proportion_is_announced_and_one_beyond_memory_refused(self):
        self.fan("a.xyz", 4000, 0, 8)
        self.fan("b.xyz", 4000, 8, 0)
        words = ["compare", "a.xyz", "b.xyz", "--surface", "overlay", "--border", "hull"]
        run = self.run_cli(*words, "--progress", "json")
        self.assertRegex(run.stdout, r"warning: the overlay of the two scans has about \d+ million cells")
        self.assertRegex(run.stderr, r'"stage":"overlay of about \d+ million cells"')
        # Its cells would fill the memory: refused before that.
        limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (600_000_000, 600_000_000))
        run = self.run_cli(*words, "-o", "out", "--threads", "2", code=3, preexec_fn=limit)
        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        self.assertIn("--no-cells", run.stderr)


if __name__ == "__main__":
    unittest.main()
