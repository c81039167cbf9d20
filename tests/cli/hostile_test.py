"""Inputs that were made, or have happened, to break a reader: each is refused in one line, or read for what it is."""

import struct
import subprocess
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


if __name__ == "__main__":
    unittest.main()
