#!/usr/bin/env python3
"""Folders of src/isopach include only folders above them, in the order of the data. io sees no triangulation."""

import re

from common import code_of, finish, tracked

ORDER = ["base", "geom", "cloud", "io", "field", "delaunay", "overlay", "measure", "compare", "distance", "match", "tiles",
         "apps", "simulate", "report"]
# delaunay knows points in the plane and nothing else: it can be lifted out alone.
FORBIDDEN = {"delaunay": {"cloud", "io", "field"}}

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
