#!/usr/bin/env python3
"""Folders of src/isopach include only folders before them, in the order of the data; the core does not know io, nor what
io and report are linked with."""

import re

from common import code_of, finish, tracked

CORE = ["base", "geom", "cloud", "field", "delaunay", "overlay", "measure", "compare", "distance", "match", "tiles", "apps",
        "simulate"]
ORDER = ["base", "geom", "cloud", "io", *CORE[CORE.index("field"):], "report"]
FORBIDDEN = {folder: {"io"} for folder in CORE}
# delaunay knows points in the plane and nothing else: it can be lifted out alone.
FORBIDDEN["delaunay"] |= {"cloud", "field"}
# Libraries that not every part of isopach is linked with: the first letters of their headers, and where they may stand.
LIBRARIES = {"gdal": "io", "ogr": "io", "cpl_": "io", "proj": "io", "laszip": "io", "muParser": "io", "fast_float": "io",
             "cairo": "report", "png": "report"}

found = []
for name in tracked("src/isopach"):
    if not name.endswith((".hpp", ".cpp", ".hpp.in")):
        continue
    parts = name.split("/")
    if len(parts) < 4:  # version.hpp.in: below everything
        continue
    folder = parts[2]
    if folder not in ORDER:
        found.append((name, 1, f"folder '{folder}' has no place in the order {' '.join(ORDER)}"))
        continue
    for number, line in enumerate(code_of(name).split("\n"), 1):
        match = re.match(r'\s*#\s*include\s*<([^>]+)>', line)
        for library, home in LIBRARIES.items() if match else ():
            if match.group(1).startswith(library) and folder != home:
                found.append((name, number, f"<{match.group(1)}> belongs to the part {home}"))
        match = re.match(r'\s*#\s*include\s*["<]isopach/([^/">]+)/', line)
        if not match:
            if re.match(r'\s*#\s*include\s*"(?!isopach/)', line):
                found.append((name, number, 'write the whole path: #include "isopach/..."'))
            continue
        other = match.group(1)
        if other not in ORDER:
            found.append((name, number, f"includes unknown folder '{other}'"))
        elif ORDER.index(other) > ORDER.index(folder):
            found.append((name, number, f"'{folder}' includes '{other}', which comes later"))
        elif other in FORBIDDEN.get(folder, ()):
            found.append((name, number, f"'{folder}' must not know '{other}'"))
finish("layering", found)
