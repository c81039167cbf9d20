"""Broken input files: cut short, bits turned over, counts off by one, pieces repeated or zeroed; of every format, for every verb."""

import os
import random
import re
import resource
import signal
import struct
import subprocess

MOST_S, MOST_BYTES = 30, 3_000_000_000

#: a file, and the commands that read it (FILE stands for its mutant)
READERS = {
    "a.xyz": ["info FILE", "compare FILE in/b.xyz", "distance FILE in/b.xyz", "convert FILE x.ply"],
    "a.ply": ["info FILE", "compare FILE in/b.xyz", "distance FILE in/b.xyz"],
    "a.las": ["info FILE", "compare FILE in/b.las", "convert FILE x.xyz"],
    "a.laz": ["info FILE", "compare FILE in/b.las", "convert FILE x.las"],
    "a.pcd": ["info FILE", "compare FILE in/b.xyz"],
    "cube.obj": ["info FILE", "distance FILE in/cube.stl"],
    "cube.stl": ["info FILE", "distance FILE in/cube.obj"],
    "grid.asc": ["info FILE"],
    "grid.tif": ["info FILE"],
    "field.geojson": ["compare in/a.xyz in/b.xyz --budget FILE", "compare in/a.xyz in/b.xyz --include FILE"],
    "pose.txt": ["compare in/a.xyz in/b.xyz --pose FILE", "convert in/a.xyz x.ply --pose FILE"],
    "options.cfg": ["compare in/a.xyz in/b.xyz --config FILE"],
    "hill_a.xyz": ["roughness FILE", "match FILE in/hill_b.xyz --pose-only"],
    "reconstruction.ply": ["accuracy FILE in/reference.ply"],
    "scan_a.ply": ["scanners FILE in/scan_b.ply in/scan_reference.ply"],
    "face.ply": ["asymmetry FILE --direction z"],
    "frame.ply": ["sequence in/frames/frame_000.ply FILE in/frames/frame_006.ply"],
    "jaw.ply": ["combine in/combine/face.ply FILE --reference in/combine/reference.ply"],
}
SLOW = ("accuracy", "scanners", "asymmetry", "sequence", "combine", "match", "roughness")
GDAL = ("grid.tif",)


def mutated(data, rng):
    """The name of a mutation and what it makes of the bytes."""
    data = bytearray(data)
    kind = rng.choice(["cut short", "bits", "bits in the head", "count off by one", "count off by one", "bytes zeroed", "piece repeated",
                       "piece left out", "number of extremes"])
    at = rng.randrange(len(data))
    if kind == "cut short":
        return kind, bytes(data[:at])
    if kind == "bits":
        for _ in range(rng.choice([1, 1, 2, 8, 64])):
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    elif kind == "bits in the head":
        for _ in range(rng.choice([1, 2, 4])):
            data[rng.randrange(min(400, len(data)))] ^= 1 << rng.randrange(8)
    elif kind == "count off by one":
        off_by_one(data, rng)
    elif kind == "bytes zeroed":
        data[at:at + rng.choice([1, 4, 16, 256])] = bytes(min(len(data) - at, rng.choice([1, 4, 16, 256])))
    elif kind == "piece repeated":
        data[at:at] = data[at:at + rng.choice([1, 7, 64, 1000])]
    elif kind == "piece left out":
        del data[at:at + rng.choice([1, 7, 64, 1000])]
    else:
        extreme(data, rng)
    return kind, bytes(data)


def off_by_one(data, rng):
    """A whole number in the text, or in the first bytes of a binary file, is one more or one less."""
    numbers = [m for m in re.finditer(rb"(?<![\d.e-])\d+(?![\d.e])", bytes(data[:3000]))]
    step = rng.choice([-1, 1])
    if data[:4] not in (b"LASF", b"II*\0", b"MM\0*") and numbers:
        match = rng.choice(numbers)
        data[match.start():match.end()] = str(max(0, int(match.group()) + step)).encode()
        return
    at = rng.randrange(min(375, max(1, len(data) - 4)))
    value = struct.unpack_from("<I", data, at)[0]
    struct.pack_into("<I", data, at, (value + step) % (1 << 32))


def extreme(data, rng):
    """A number becomes one that is hardly a number, or four or eight bytes become all ones."""
    numbers = [m for m in re.finditer(rb"-?\d+(?:\.\d+)?(?:e-?\d+)?", bytes(data[:20000]))]
    if data[:4] not in (b"LASF", b"II*\0", b"MM\0*") and numbers:
        match = rng.choice(numbers)
        word = rng.choice([b"nan", b"inf", b"-inf", b"1e308", b"1e-320", b"-1", b"4294967296", b"18446744073709551615", b"0x7", b"", b"1e400"])
        data[match.start():match.end()] = word
        return
    at, size = rng.randrange(len(data)), rng.choice([4, 8])
    data[at:at + size] = b"\xff" * min(size, len(data) - at)


def try_mutant(sandbox, tally, name, line, number):
    rng = random.Random(f"{name} {line} {number}")
    kind, data = mutated((sandbox.root / "in" / name).read_bytes(), rng)
    sandbox.clear()
    (sandbox.root / name).write_bytes(data)
    words = [name if w == "FILE" else w for w in line.split()] + ["--quiet"]

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
        resource.setrlimit(resource.RLIMIT_CPU, (MOST_S, MOST_S))

    offence, code = "", None
    try:
        done = sandbox.run(words, timeout=20 * MOST_S, preexec_fn=limit)
        code = done.returncode
    except subprocess.TimeoutExpired:
        offence = "no end"
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        code, offence = None, f"no end within {MOST_S} s of work"
    if code is not None and code not in (0, 2, 3, 4, 5):
        offence = f"exit {code}: {done.stderr}"
    elif code is not None and code != 0 and (done.stderr.count("\n") != 1 or not done.stderr.startswith("isopach: ")):
        offence = f"exit {code}, not one line: {done.stderr!r}"
    elif sandbox.leftovers():
        offence = f"left {sandbox.leftovers()}"
    outcome = {0: "read for what it is", None: "hung"}.get(code, "refused in one line")
    if offence and os.environ.get("ISOPACH_KEEP_MUTANTS"):
        kept = os.path.join(os.environ["ISOPACH_KEEP_MUTANTS"], f"{number}-{name}")
        with open(kept, "wb") as file:
            file.write(data)
    tally.add("broken files", kind, name.rpartition(".")[2], outcome, f"{' '.join(words)} (mutant {number} of {name})", offence)


def plan(count):
    """(file, command, number): `count` mutants of each cheap command, fewer of those that take long."""
    return [(name, line, number) for name, lines in READERS.items() for line in lines
            for number in range(max(2, round(count * (0.08 if line.split()[0] in SLOW or name in GDAL else 1))))]


def make_inputs(folder):
    (folder / "pose.txt").write_text("1 0 0 0.5\n0 1 0 -0.25\n0 0 1 0.125\n0 0 0 1\n")
    (folder / "options.cfg").write_text('surface = "both"\nmax-edge = 30\nmin-coverage = 0.25\nborder = "hull"\n')
    (folder / "frame.ply").write_bytes((folder / "frames" / "frame_003.ply").read_bytes())
    (folder / "jaw.ply").write_bytes((folder / "combine" / "jaw.ply").read_bytes())
