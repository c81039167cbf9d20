#!/usr/bin/env python3
"""Folders of src/isopach, and rooms of a folder, include only those before them, in the order of the data; the core does not
know io, nor what io and report are linked with."""

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
             "cairo": "report", "png": "report", "zlib": "report"}

# Rooms of a folder include rooms before them alone. What lies in the folder itself is common to them, or the page above.
ROOMS = {"measure": ["volume", "uncertainty", "changes", "currents", "texture"],
         "match": ["verdict", "surface", "pairs", "currents", "coarse"],
         "report": ["page", "draw", "view"]}

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
    room = parts[3] if len(parts) > 4 else None
    if room is not None and room not in ROOMS.get(folder, ()):
        found.append((name, 1, f"room '{room}' is none of {folder}: {' '.join(ROOMS.get(folder, ())) or 'it has none'}"))
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
        inner = re.match(r'\s*#\s*include\s*"isopach/([^/"]+)/([^/"]+)/', line)
        if inner and room is not None and inner.group(1) == folder:
            rooms = ROOMS[folder]
            if inner.group(2) in rooms and rooms.index(inner.group(2)) > rooms.index(room):
                found.append((name, number, f"'{folder}/{room}' includes '{inner.group(2)}', which comes later"))
        if other not in ORDER:
            found.append((name, number, f"includes unknown folder '{other}'"))
        elif ORDER.index(other) > ORDER.index(folder):
            found.append((name, number, f"'{folder}' includes '{other}', which comes later"))
        elif other in FORBIDDEN.get(folder, ()):
            found.append((name, number, f"'{folder}' must not know '{other}'"))
finish("layering", found)
