"""Converts archives of queries of continuous collision detection to the binary file that
narrow_phase/test_exact_continuous.cpp reads.

For each query, an archive (npz) contains 24 coordinates Q, the kind (0 vertex-face, 1 edge-edge),
the exact verdict gt, and the bounds toi_lo and toi_hi on the first contact time.

python3 tests/collision/convert_queries.py out.bin queries/*.npz
"""

import array
import ast
import struct
import sys
import zipfile

CODES = {
    "f8": "d",
    "f4": "f",
    "i8": "q",
    "i4": "i",
    "i2": "h",
    "i1": "b",
    "u8": "Q",
    "u4": "I",
    "u2": "H",
    "u1": "B",
    "b1": "b",
}


def read_array(archive, name):
    """Returns the array `name` of the archive, flattened. Exits if it is in Fortran order."""
    raw = archive.read(name + ".npy")
    size, start = struct.unpack("<H", raw[8:10])[0], 10
    if raw[6] > 1:
        size, start = struct.unpack("<I", raw[8:12])[0], 12
    header = ast.literal_eval(raw[start : start + size].decode())
    if header["fortran_order"]:
        raise SystemExit(f"{name} must be in C order; save it again with numpy.ascontiguousarray")
    values = array.array(CODES[header["descr"][1:]])
    values.frombytes(raw[start + size :])
    return values


def main(out, *paths):
    rows = array.array("d")
    for path in paths:
        with zipfile.ZipFile(path) as archive:
            q, kind, verdict, low, high = (
                read_array(archive, k) for k in ("Q", "kind", "gt", "toi_lo", "toi_hi")
            )
        for i in range(len(kind)):
            rows.extend(q[24 * i : 24 * i + 24])
            rows.extend((kind[i], verdict[i], low[i], high[i]))
    with open(out, "wb") as file:
        rows.tofile(file)


if __name__ == "__main__":
    main(*sys.argv[1:])
