"""Writes the small files from which the fuzz targets start.

    python tests/fuzz/seeds.py DIRECTORY

The files of each reader are in a directory of their own in DIRECTORY/seeds.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import loomstone as ls

PLY_TEXT = b"""ply
format ascii 1.0
element vertex 3
property double x
property double y
property double z
property double u
property double v
element face 1
property list uchar int vertex_indices
end_header
0 0 0 0 0
1 0 0 1 0
0 1 0 0 1
3 0 1 2
"""


def main() -> None:
    root = Path(sys.argv[1]) / "seeds"
    mesh = ls.grid(size=(0.1, 0.1), cells=(2, 2))
    with TemporaryDirectory() as name:
        made = Path(name)
        ls.meshes.write(made / "a.obj", mesh)
        ls.meshes.write(made / "a.ply", mesh)
        sim = ls.Simulation(ls.Scene(cloths=[ls.Cloth(mesh=mesh, pins=[0])]), threads=1)
        sim.run(out=made / "run", duration=0.04)
        checkpoint = max((made / "run").glob("checkpoint-*")).read_bytes()
        seeds = {
            "obj": [(made / "a.obj").read_bytes()],
            "ply": [(made / "a.ply").read_bytes(), PLY_TEXT],
            "checkpoint": [checkpoint[:-24]],  # the target appends mark, length and checksum
            "run": [(made / "run" / "run.vtkhdf").read_bytes()],
        }
    for reader, contents in seeds.items():
        (root / reader).mkdir(parents=True, exist_ok=True)
        for number, content in enumerate(contents):
            (root / reader / f"seed-{number}").write_bytes(content)


if __name__ == "__main__":
    main()
