#!/usr/bin/env python3
"""Writes seeds/TARGET/*: small inputs that the fuzz targets start from, and that the test fuzz.replay runs.

    tests/fuzz/make_seeds.py

A seed whose name begins with "valid" must be read, or run, to the end; the others are damaged in a way that readers
have to count for: every count in a header once one more and once one less than what is there. Inputs of verbs are what
decode.cpp makes clouds and options of: a list of bytes in the order in which it asks for them; zeros are the defaults.
"""

import json
import pathlib
import struct

SEEDS = pathlib.Path(__file__).resolve().parent / "seeds"
LARGEST, LARGEST_OF_ALL = 2000, 60000
POINTS = [(0, 0, 0), (1, 0, 0.5), (0, 1, 0.25), (1, 1, -0.5)]


def counts(name, make, *numbers):
    """The file with the right counts, and with each of them one more and one less."""
    yield f"valid-{name}", make(*numbers)
    for i in range(len(numbers)):
        for by, word in ((1, "more"), (-1, "less")):
            changed = [n + by * (k == i) for k, n in enumerate(numbers)]
            yield f"{name}-{i + 1}-one-{word}", make(*changed)


def text(*lines):
    return ("\n".join(lines) + "\n").encode()


def rows(separator=" "):
    return [separator.join(str(v) for v in p) for p in POINTS]


# --- formats of clouds ---


def ply():
    def ascii_file(vertices, faces, corners):
        return text("ply", "format ascii 1.0", "comment unit: mm", f"element vertex {vertices}", "property float x", "property float y",
                    "property float z", f"element face {faces}", "property list uchar int vertex_indices", "end_header",
                    *rows(), f"{corners} 0 1 2 3")

    def binary_file(vertices, faces, corners):
        head = text("ply", "format binary_little_endian 1.0", f"element vertex {vertices}", "property double x", "property double y",
                    "property double z", "property uchar classification", f"element face {faces}",
                    "property list uchar uint vertex_indices", "end_header")
        return head + b"".join(struct.pack("<dddB", *p, 2) for p in POINTS) + struct.pack("<BIII", corners, 0, 1, 2)

    yield from counts("ascii", ascii_file, 4, 1, 4)
    yield from counts("binary", binary_file, 4, 1, 3)
    yield "big-endian", text("ply", "format binary_big_endian 1.0", "element vertex 1", "property float x", "property list uchar short n",
                             "property float y", "property float z", "end_header") + struct.pack(">fBhhff", 1, 2, 7, 8, 2, 3)


def pcd():
    def file(kind, width, height, points, data):
        return text("# .PCD v0.7", "VERSION 0.7", "FIELDS x y z n", "SIZE 4 4 4 2", "TYPE F F F U", "COUNT 1 1 1 2", f"WIDTH {width}",
                    f"HEIGHT {height}", "VIEWPOINT 0 0 0 1 0 0 0", f"POINTS {points}", f"DATA {kind}") + data

    plain = b"".join(struct.pack("<fffHH", *p, 7, 8) for p in POINTS)
    yield from counts("ascii", lambda w, h, n: file("ascii", w, h, n, text(*(row + " 7 8" for row in rows()))), 4, 1, 4)
    yield from counts("binary", lambda w, h, n: file("binary", w, h, n, plain), 2, 2, 4)
    # One point of three doubles 1.0 in LZF: eight literals, then a reference eight back of sixteen.
    head = text("VERSION 0.7", "FIELDS x y z", "SIZE 8 8 8", "TYPE F F F", "COUNT 1 1 1", "WIDTH 1", "HEIGHT 1", "POINTS 1",
                "DATA binary_compressed")
    packed = b"\x07\0\0\0\0\0\0\xF0\x3F\xE0\x07\x07"
    yield from counts("compressed", lambda size, of: head + struct.pack("<II", size, of) + packed, 12, 24)


def stl():
    facets = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0) + struct.pack("<12fH", 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0)
    yield from counts("binary", lambda n: b"\0" * 80 + struct.pack("<I", n) + facets, 2)
    facet = ["facet normal 0 0 1", "outer loop", "vertex 0 0 0", "vertex 1 0 0", "vertex 0 1 0", "endloop", "endfacet"]
    yield "valid-ascii", text("solid a", *facet, "endsolid a")
    yield "two-corners", text("solid a", *facet[:4], *facet[5:], "endsolid a")


def obj():
    vertices = [f"v {row}" for row in rows()]
    yield from counts("last", lambda last: text(*vertices, f"f 1 2 {last}"), 4)
    yield from counts("back", lambda back: text(*vertices, f"f -1 -2 {back}"), -4)
    yield "valid-all", text("# a mesh", "mtllib a.mtl", "v 0 0 0 1 0 0", "v 1 0 0\\", "", "v 0 1 0", "vn 0 0 1", "f 1/1/1 2//1 3/2")


def text_files():
    yield "valid-xyz", text(*rows())
    yield "valid-csv", text("x,y,z,intensity", *(row + ",3" for row in rows(",")))
    yield "valid-comma", text("1,5;2;3", "4;5,25;6", "7;8;9")
    yield from counts("pts", lambda n: text(str(n), *(row + " 10 255 0 0" for row in rows())), 4)
    pose = ["0 0 0", "1 0 0", "0 1 0", "0 0 1", "1 0 0 0", "0 1 0 0", "0 0 1 0", "5 6 7 1"]
    yield from counts("ptx", lambda columns, lines: text(str(columns), str(lines), *pose, *(row + " 0.5" for row in rows())), 2, 2)
    yield "header-alone", text("//X Y Z")


def las_file(fmt, count=3, records=1, at=None, length=None, legacy=None):
    size = {0: 20, 1: 28, 6: 30}[fmt]
    header = bytearray(375 if fmt >= 6 else 227)
    header[0:4], header[24], header[25] = b"LASF", 1, 4 if fmt >= 6 else 2
    record = struct.pack("<H16sHH32s", 0, b"LASF_Spec", 4, 192, b"extra") + struct.pack("<HBB32s", 0, 9, 0, b"height").ljust(192, b"\0")
    struct.pack_into("<HII", header, 94, len(header), at if at is not None else len(header) + len(record), records)
    header[104] = fmt
    struct.pack_into("<H", header, 105, length if length is not None else size + 4)
    struct.pack_into("<I", header, 107, legacy if legacy is not None else (0 if fmt >= 6 else count))
    struct.pack_into("<6d", header, 131, 0.01, 0.01, 0.01, 0, 0, 0)
    if fmt >= 6:
        struct.pack_into("<Q", header, 247, count)
    points = b"".join(struct.pack("<iii", 100 * i, 7 * i * i, 5 * i).ljust(size, bytes([i])) + struct.pack("<f", i) for i in range(3))
    return bytes(header) + record + points


def las():
    for fmt in (0, 1, 6):
        yield from counts(f"format-{fmt}", lambda n, vlrs, at, length, fmt=fmt: las_file(fmt, n, vlrs, at, length), 3, 1,
                          (375 if fmt >= 6 else 227) + 54 + 192, {0: 24, 1: 32, 6: 34}[fmt])


# --- rasters and polygons ---


def tiff(columns=3, heights=3, strip=36, tags=13):
    directory = 8
    georeference = directory + 2 + 12 * 13 + 4
    nodata = georeference + 9 * 8
    cells = nodata + 8
    entries = [(256, 3, 1, columns), (257, 3, 1, heights), (258, 3, 1, 32), (259, 3, 1, 1), (262, 3, 1, 1), (273, 4, 1, cells), (277, 3, 1, 1),
               (278, 3, 1, 3), (279, 4, 1, strip), (339, 3, 1, 3), (33550, 12, 3, georeference), (33922, 12, 6, georeference + 24),
               (42113, 2, 6, nodata)]
    return (b"II*\0" + struct.pack("<IH", directory, tags) + b"".join(struct.pack("<HHII", *e) for e in entries) + struct.pack("<I", 0) +
            struct.pack("<9d", 0.5, 0.5, 0, 0, 0, 0, 100, 200, 0) + b"-9999\0\0\0" + struct.pack("<9f", 1, 2, 3, 4, 5, -9999, 7, 8, 9))


def raster():
    yield from counts("tiff", tiff, 3, 3, 36, 13)
    grid = ["1 2 3", "4 -9999 6"]
    yield from counts("asc", lambda c, r: text(f"ncols {c}", f"nrows {r}", "xllcorner 10", "yllcorner 20", "cellsize 2", "NODATA_value -9999",
                                               *grid), 3, 2)
    yield from counts("surfer-text", lambda c, r: text("DSAA", f"{c} {r}", "0 2", "0 1", "1 6", "1 2 3", "4 5 6"), 3, 2)
    yield from counts("surfer-6", lambda c, r: b"DSBB" + struct.pack("<hh6d", c, r, 0, 2, 0, 1, 1, 6) + struct.pack("<6f", *range(1, 7)), 3, 2)


def geojson(*polygons, crs=None):
    features = [{"type": "Feature", "properties": {"name": f"p{i}"}, "geometry": {"type": "Polygon", "coordinates": p}}
                for i, p in enumerate(polygons)]
    return json.dumps({"type": "FeatureCollection", **({"crs": crs} if crs else {}), "features": features}).encode()


def polygons():
    square = [[1, 1], [6, 1], [6, 6], [1, 6], [1, 1]]
    hole = [[2, 2], [3, 2], [3, 3], [2, 2]]
    ends = {"geojson": 0, "kml": 1, "csv": 2, "fgb": 3, "mif": 4, "none": 7}

    def file(end, data):
        return bytes([ends[end]]) + data

    yield "valid-geojson", file("geojson", geojson([square, hole]))
    yield "valid-crossing", file("none", geojson([[[0, 0], [5, 5], [5, 0], [0, 5], [0, 0]]], [[[1, 1], [7, 1], [1, 7]]]))
    yield "valid-crs", file("geojson", geojson([square], crs={"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}}))
    yield "empty-ring", file("geojson", geojson([[]]))
    yield "two-points", file("geojson", geojson([[[0, 0], [1, 1], [0, 0]]]))
    yield "huge", file("geojson", geojson([[[1e308, 0], [-1e308, 5], [0, 1e308], [1e308, 0]]]))
    yield "valid-csv", file("csv", b'id,WKT\n1,"POLYGON ((1 1,6 1,6 6,1 1))"\n2,"CURVEPOLYGON (CIRCULARSTRING (1 1,3 3,5 1,3 0,1 1))"\n')
    kml = ('<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><name>p</name><Polygon><outerBoundaryIs><LinearRing>'
           "<coordinates>1,1 6,1 6,6 1,1</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></Document></kml>")
    yield "valid-kml", file("kml", kml.encode())
    yield from ((name.removeprefix("valid-"), data) for name, data in counts("mif", lambda regions, corners: file("mif", text(
        "Version 300", "Delimiter ','", "Columns 1", "  id Integer", "Data", f"Region {regions}", f"  {corners}", "1 1", "6 1", "6 6", "1 1")), 1, 4))


# --- options ---


def weights():
    for name, formula in {"valid-polynomial": "1 + x*y - z1^2", "valid-choice": "abs(z2-z1) > 0.5 && x < 3 ? 2 : sin(x)/slope1",
                          "valid-functions": "max(x, y, rint(z1), sqrt(z2), avg(slope1, slope2))", "assignment": "x = 3",
                          "several": "x, y", "open": "((x+1", "unknown": "foo(x)", "deep": "(" * 200 + "x" + ")" * 200, "empty": ""}.items():
        yield name, formula.encode()


def pose():
    yield from counts("matrix", lambda x: text(f"1 0 0 {x}", "0 1 0 -2.5e-3", "0 0 1 1e6", "0 0 0 1"), 3)
    yield "fifteen", text("1 0 0 3", "0 1 0 2", "0 0 1 1", "0 0 0")
    yield "seventeen", text("1 0 0 3", "0 1 0 2", "0 0 1 1", "0 0 0 1", "1")
    yield "flat", text("1 0 0 0", "0 1 0 0", "0 0 0 0", "0 0 0 1")
    for name, size in (("valid-covariance", 6), ("covariance-of-five", 5)):
        rows_of = [[1e-6 if i == j else 0 for j in range(size)] for i in range(size)]
        yield name, json.dumps({"covariance": rows_of, "centre": [1, 2, 3]}).encode()
    yield "undetermined", json.dumps({"covariance": [[None] * 6] * 6, "centre": [1, 2, 3]}).encode()


def config():
    yield "valid-some", text("# options", "direction = fit", "duplicates = 'median'", "class = [2, 8]", "crop = -1,-1,1e3,1000", "lod = 0.05",
                             "quiet", "fail-above = p95=0.05", 'weight = "x*x + 1"')
    yield "valid-numbers", text("confidence=0.9", "max-edge = 2.5", "threads = 1", "max-input = 2G", "sigma1 = @sigma", "unit = us-ft")
    yield "unknown", text("dirction = z")
    yield "twice", text("lod = 1", "lod = 2")
    yield "quotes", text("unit = \"mm", "pose = 'a#b' # c")
    yield "out-of-range", text("confidence = 1.5")


# --- verbs: bytes for decode.cpp ---


def hills(seed=1, slope=0, height=32, width=64, noise=0, points=200, factor=0, offset=0, damage=(0,), attributes=(0,)):
    return [5, slope, height, width, noise, seed, points, factor, offset, 0, *damage, *attributes]


def grid(columns, rows_of, heights=None, faces=0):
    return [0, columns - 2, rows_of - 2, 0 if heights else 1, *(heights or []), faces, 0, 0, 0, 0, 0]


def scans(direction=0, duplicates=0, pose_bytes=(0,), border=0, folds=0):
    return [direction, duplicates, 0, 0, *pose_bytes, border, folds, 0, 0, 0, 0]


def comparison(scan_bytes=None, surface=0, measure=(0,), interpolation=0, domain=0, keep=0, locate=0, area=(0,), weight=(0,), uncertainty=(0,) * 7,
               percentiles=(0,), floor=0):
    return [*(scan_bytes or scans()), surface, *measure, interpolation, domain, keep, locate, *area, *weight, *uncertainty, *percentiles, floor, 0]


def matching(scan_bytes=None, objective=0, iterations=15, judge=1, check=1, icp=(0, 0, 0, 0, 0, 0), start=(0,), coarse=0):
    rest = [0] if objective in (0, 3) else []  # no weight; no width of the kernel
    return [*(scan_bytes or scans()), *start, objective, coarse, 0, 0, 0, iterations, 0, judge, check, 1, *icp, *rest]


def compare():
    a, b = hills(1), hills(2, height=40, noise=20)
    two = [*a, 0, *b]
    square = [0, 0, 65, 65, 0, 1, *(v for x, y in ((8, 8), (96, 8), (96, 96), (8, 96)) for v in (1, x, y))]
    yield "valid-plain", two
    yield "valid-overlay", [*two, *comparison(surface=2, keep=1)]
    yield "valid-cubic", [*two, *comparison(interpolation=1)]
    yield "valid-floor", [*two, *comparison(floor=1)]
    yield "valid-currents", [*two, *comparison(measure=(2, 0, 0), locate=1)]
    yield "valid-polygon", [*two, *comparison(area=(32, *square), locate=2)]
    yield "valid-noise", [*two, *comparison(uncertainty=(2, 1, 1, 3, 1, 1, 3, 0, 0, 31, 0))]
    yield "valid-weight", [*two, *comparison(weight=(2, 15, 1))]
    yield "valid-fit", [*two, *comparison(scans(direction=5, duplicates=3, pose_bytes=(2, 3), border=1, folds=1))]
    yield "valid-hull", [*two, *comparison(domain=1)]
    yield "valid-same", [*grid(5, 5), 7]
    yield "valid-grids", [*grid(6, 6), 0, *grid(8, 4, list(range(32)))]
    yield "valid-tiny-heights", [*hills(1)[:9], 7, 0, 0, 0, *hills(2)[:9], 7, 0, 0]
    yield "tiny", [*hills(1, factor=6), 0, *hills(2, factor=6)]
    yield "denormal", [*hills(1, factor=7), 0, *hills(2, factor=7)]
    yield "huge", [*hills(1, factor=9), 0, *hills(2, factor=9)]
    yield "overflow", [*hills(1, factor=11), 0, *hills(2, factor=11)]
    yield "nan", [*hills(1, damage=(3, 10, 0, 98, 40, 1, 99, 90, 2, 100)), 0, *hills(2)]
    yield "line", [3, 1, 1, 40, *(range(80))]


def distance():
    a, b = hills(1, points=60), hills(2, points=60, height=36)
    scan = [0, 0, 0, 0, 0]
    yield "valid-points", [*a, *b, *scan, 1, 1, 1, 1, 0, 0, 0]
    yield "valid-hausdorff", [*a, *b, *scan, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0]
    yield "valid-m3c2", [*a, *b, *scan, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 63, 31, 63, 0]
    yield "valid-faces", [*grid(4, 4, None, 1), *grid(4, 4, list(range(16)), 1), *scan, 1, 1, 1, 1, 1, 0, 0, 2, 0, 0, 0, 0]
    yield "face-one-too-far", [*grid(4, 4, None, 1)[:-2], 1, 0, 5, 0, 0, *grid(4, 4, None, 1), *scan, 0, 1, 0, 0, 0, 0, 0, 2]


def match():
    a, b = hills(1), hills(2)
    for number, name in enumerate(("measure", "icp-point", "icp-plane", "currents", "icp-gicp")):
        yield f"{'valid-' if name != 'icp-point' else ''}{name}", [*matching(objective=number, check=0), *a, *b]
    yield "valid-checked", [*matching(check=1), *a, *b]
    yield "moved", [*matching(start=(1, 16, 8, 40)), *a, *b]
    yield "coarse", [*matching(objective=2, coarse=7, judge=0), *a, *b]
    yield "planes", [*matching(), *grid(8, 8), *grid(9, 9)]
    yield "one-point", [*matching(objective=1), 2, 1, 5, 5, 5, 0, 0, 0, 0, 0, *a]


def accuracy():
    a, b = hills(1), hills(2, noise=10)
    yield "valid-in-place", [0, *matching(), 1, 0, 0, *a, *b]
    yield "aligned", [0, *matching(check=0), 1, 2, 0, *a, *b]
    yield "valid-scanners", [1, *matching(), 1, 0, 0, *a, *b, *hills(3, points=255)]


def roughness():
    a = hills(1, noise=40, points=223)
    yield "valid-plane", [*scans(), 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, *a, 0, 0]
    yield "valid-filtered", [*scans(), 2, 1, 0, 1, 63, 1, 1, 1, 0, 0, 0, 0, 0, *a, 0, 0]
    yield "valid-after", [*scans(), 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, *a, 1, 0, *hills(2, noise=10)]
    yield "valid-reference", [*scans(), 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, *a, 0, 1, *hills(3)]


def asymmetry():
    given = [*scans(), 0, 0, 0, 0, 0, 0, 0, 0, 7, 1]
    yield "valid-face", [*given, 0, 255, 0, 0]
    yield "valid-halves", [*scans(), 0, 0, 0, 0, 0, 1, 0, 1, 255, 7, 1, 0, 255, 0, 0]
    yield "hills", [*given, 1, *hills(1)]
    yield "found", [*scans(), 2, 0, 0, 0, 0, 0, 0, 0, 0, 7, 0, 0, 255, 0, 0]


def sequence():
    plain = [0, 0, 0, 0, 0, 0]
    yield "valid-chewing", [*plain, 5, 0, 255, 0, 119]
    yield "damaged", [*plain, 5, 0, 255, 5, 119, 0, 2, 90, 2, 98, 120, 1, 99]
    yield "hills", [*plain, 3, 1, *hills(1), *hills(2), *hills(3)]
    yield "no-frames", [*plain, 0, 0]


def combine():
    yield "valid-plate", [0, 0, 0, 0, 0, 255, 0, 0]
    yield "forgotten", [0, 0, 0, 0, 0, 255, 0, 7]
    yield "hills", [0, 0, 0, 0, 1, *hills(1), 1, 1]
    yield "started", [1, 10, 3, 0, 3, 0, 0, 1, *hills(1), 0, *hills(2), 1]


def laz():
    for fmt in range(11):
        yield f"valid-format-{fmt}", [fmt, 0, 1, 1, 0]
        yield f"one-point-more-{fmt}", [fmt, 2, 0, 0, 0]
        yield f"one-point-less-{fmt}", [fmt, 0, 0, 0, 0]


def blocks():
    for make in (ply, text_files, las):
        for name, data in make():
            if make is not las or "6" in name:
                yield f"{name}-{make.__name__.split('_')[0]}", data


def stac():
    def item(**assets):
        return {"type": "Feature", "stac_version": "1.0.0", "id": "tile", "properties": {"pc:count": 4, "proj:bbox": [0, 0, 0, 1, 1, 1]},
                "assets": assets}

    tile = item(data={"href": "./a%20b.laz", "roles": ["data"]}, overview={"href": "o.laz", "roles": ["overview"]})
    links = [{"rel": "self", "href": "c.json"}, {"rel": "item", "href": "i.json"}, {"rel": "child", "href": "file:///d/c.json"}]
    files = {"valid-collection": {"type": "FeatureCollection", "features": [tile, item(cloud={"href": "b.laz"})]}, "valid-item": tile,
             "valid-links": {"type": "Catalog", "stac_version": "1.0.0", "links": links}, "no-scan": item(thumbnail={"href": "t.png"}),
             "no-object": [tile], "features-a-number": {"type": "FeatureCollection", "features": 1}}
    for name, value in files.items():
        yield name, json.dumps(value).encode()
    yield "cut", json.dumps(tile).encode()[:-3]
    yield "deep", b"[" * 200


TARGETS = {"ply": ply, "pcd": pcd, "stl": stl, "obj": obj, "text": text_files, "las": las, "laz": laz, "raster": raster, "polygons": polygons,
           "weights": weights, "pose": pose, "config": config, "compare": compare, "distance": distance, "match": match,
           "accuracy": accuracy, "roughness": roughness, "asymmetry": asymmetry, "sequence": sequence, "combine": combine,
           "stac": stac, "blocks": blocks}


def main():
    total = 0
    for target, make in TARGETS.items():
        folder = SEEDS / target
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.iterdir():
            old.unlink()
        for name, data in make():
            data = bytes(data if isinstance(data, bytes) else [v % 256 for v in data])
            assert len(data) <= LARGEST, f"{target}/{name} has {len(data)} bytes"
            (folder / name).write_bytes(data)
            total += len(data)
    assert total <= LARGEST_OF_ALL, f"all seeds have {total} bytes"
    print(f"{total} bytes in {sum(1 for p in SEEDS.rglob('*') if p.is_file())} files")


if __name__ == "__main__":
    main()
