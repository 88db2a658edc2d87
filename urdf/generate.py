#!/usr/bin/env python3
"""Writes mobile_baxter.urdf and meshes/*.stl beside this file from the figures in generator/figures.py.

A mesh that no link uses any more is removed.

--check   writes nothing; exit code 1 and a line for every file that is out of step
--count   prints the triangles of every mesh
"""

import argparse
import pathlib
import struct
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from generator.description import urdf  # noqa: E402
from generator.looks import meshes  # noqa: E402
from generator.solids import stl_bytes  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
TOLERANCE_M = 3e-6  # another machine's sine may round a coordinate the other way


def wanted():
    """Content by path, relative to this folder."""
    files = {f"meshes/{name}": stl_bytes(solid) for name, solid in meshes().items()}
    files["mobile_baxter.urdf"] = urdf().encode()
    return files


def coordinates(stl):
    """Corner points of a binary STL file as one flat list."""
    return [c for triangle in struct.iter_unpack("<12fH", stl[84:]) for c in triangle[3:12]]


def same(name, old, new):
    if old == new or not name.endswith(".stl") or len(old) != len(new):
        return old == new
    return all(abs(a - b) <= TOLERANCE_M for a, b in zip(coordinates(old), coordinates(new)))


def problems(files):
    lines = []
    for name, content in files.items():
        path = HERE / name
        if not path.is_file():
            lines.append(f"{name} is missing")
        elif not same(name, path.read_bytes(), content):
            lines.append(f"{name} is out of step with urdf/generator")
    stray = {f"meshes/{path.name}" for path in (HERE / "meshes").glob("*")} - set(files)
    return lines + [f"{name} belongs to no link" for name in sorted(stray)]


def write(files):
    (HERE / "meshes").mkdir(exist_ok=True)
    for path in (HERE / "meshes").glob("*.stl"):
        if f"meshes/{path.name}" not in files:
            path.unlink()
    for name, content in files.items():
        (HERE / name).write_bytes(content)


def count(files):
    total = 0
    for name, content in files.items():
        if name.endswith(".stl"):
            triangles = struct.unpack_from("<I", content, 80)[0]
            uses = files["mobile_baxter.urdf"].count(f"{name}\"".encode())
            total += uses * triangles
            print(f"{triangles:6d} x {uses}  {name}")
    print(f"{total:6d} triangles on the robot")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare only")
    parser.add_argument("--count", action="store_true", help="print the triangles of every mesh")
    options = parser.parse_args()
    files = wanted()
    if options.count:
        count(files)
    elif options.check:
        lines = problems(files)
        print("\n".join(lines + ["run urdf/generate.py"] if lines else ["urdf/ is in step"]))
        return 1 if lines else 0
    else:
        write(files)
    return 0


if __name__ == "__main__":
    sys.exit(main())
