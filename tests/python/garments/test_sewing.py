"""Boundary loops of meshes, including loops that touch at a vertex."""

import loomstone as ls
import numpy as np
import pytest
from loomstone.garments.sewing import boundary_loops


def grid_without(*cells):
    """Triangles of a grid of 6 x 6 cells, without the given cells (column, row)."""
    mesh = ls.grid(size=(6, 6), cells=(6, 6))
    triangles = np.asarray(mesh.triangles)
    cell = np.floor(mesh.vertices[triangles].mean(1)[:, :2] + 3).astype(int)
    return triangles[[tuple(each) not in cells for each in cell.tolist()]]


@pytest.mark.parametrize(
    ("triangles", "lengths"),
    [
        (grid_without(), [24]),
        (grid_without((1, 1)), [24, 4]),
        (grid_without((1, 1), (2, 2)), [24, 8]),
        (grid_without((1, 1), (2, 2), (3, 3)), [24, 12]),
        (grid_without((1, 0), (0, 1)), [4, 24]),
        (np.array([[0, 1, 2], [0, 3, 4]]), [3, 3]),
        (np.array([[0, 1, 2], [0, 2, 1]]), []),
    ],
)
def test_loops_contain_each_boundary_edge_once(triangles, lengths):
    loops = boundary_loops(triangles)
    assert [len(loop) for loop in loops] == lengths
    edges = {
        tuple(e)
        for e in np.c_[triangles, np.roll(triangles, -1, 1)][:, [0, 3, 1, 4, 2, 5]]
        .reshape(-1, 2)
        .tolist()
    }
    found = [(a, b) for loop in loops for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]
    assert len(found) == len(set(found))
    assert set(found) == {(a, b) for a, b in edges if (b, a) not in edges}
