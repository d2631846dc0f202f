"""Arguments of meshes: arrays of points and indices in the forms users have them, sizes and counts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark
from stark.mesh.arguments import (
    cells_of,
    corners_of,
    count_of,
    counts_around,
    indices_of,
    points_of,
    sizes_of,
)


@pytest.mark.parametrize(
    "given",
    [
        [(0, 1, 2), (3, 4, 5)],
        np.arange(6, dtype=np.float32).reshape(2, 3),
        np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        np.arange(12.0).reshape(2, 6)[:, ::2] / 2 + [[0, 0, 0], [0, 0, 0]],
    ],
)
def test_points_become_rows_of_three_doubles(given: Any) -> None:
    points = points_of(given, "vertices")
    assert points.dtype == np.float64 and points.shape == (2, 3) and points.flags.c_contiguous
    assert points.tolist() == np.asarray(given, dtype=float).tolist()


@pytest.mark.parametrize(
    "given", [[1.0, 2, 3], [[1, 2]], "points", [[1j, 0, 0]], [[1, 2, 3], [4]], [[True] * 3]]
)
def test_what_are_no_points_is_refused_with_the_shape_that_is_needed(given: Any) -> None:
    with pytest.raises(stark.InvalidMesh, match=r"vertices: .*must be .*\(n, 3\)"):
        points_of(given, "vertices")


def test_indices_become_rows_of_32_bits() -> None:
    indices = indices_of(np.array([[0, 1, 2]], dtype=np.uint64), 3, "triangles")
    assert indices.dtype == np.int32 and indices.tolist() == [[0, 1, 2]]
    assert indices_of([], 4, "tets").shape == (0, 4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ([[0, 1]], r"shape \(1, 2\): must be \(m, 3\)"),
        ([[0.0, 1.0, 2.0]], "must be integers"),
        ([[0, 1, 2**31]], "fit 32 bits"),
        ([0, 1, 2], "one row of vertex indices each"),
    ],
)
def test_what_are_no_indices_is_refused(given: Any, message: str) -> None:
    with pytest.raises(stark.InvalidMesh, match=f"triangles: .*{message}"):
        indices_of(given, 3, "triangles")


def test_corners_are_the_positions_of_the_columns() -> None:
    vertices = np.arange(12.0).reshape(4, 3)
    first, second = corners_of(vertices, np.array([[0, 3], [2, 1]], dtype=np.int32), "edges")
    assert first.tolist() == vertices[[0, 2]].tolist() and second.tolist() == vertices[[3, 1]].tolist()
    for wrong in (4, -1):
        with pytest.raises(stark.InvalidMesh, match=rf"refers to vertex {wrong}: must be in \[0, 4\)"):
            corners_of(vertices, np.array([[0, wrong]], dtype=np.int32), "edges")


def test_sizes_are_one_number_or_three() -> None:
    assert sizes_of(2, "box: size").tolist() == [2, 2, 2]
    assert sizes_of((1, 2, 3), "box: size").tolist() == [1, 2, 3]
    for wrong in (0, -1.0, (1, 2), (1, 2, np.inf), float("nan"), "large"):
        with pytest.raises(stark.InvalidArgument, match=r"box: size = .*one positive number or three"):
            sizes_of(wrong, "box: size")


def test_counts_are_whole_numbers_within_their_range() -> None:
    assert count_of(np.int64(7), "cells") == 7
    for wrong in (0, 2.0, True, 100_001, "many"):
        with pytest.raises(stark.InvalidArgument, match=r"cells = .*whole number in \[1, 100000\]"):
            count_of(wrong, "cells")


def test_cells_and_counts_that_make_too_many_vertices_are_refused_before_any_work() -> None:
    assert cells_of(3, 2, "cells") == [3, 3] and cells_of((1, 2, 3), 3, "cells") == [1, 2, 3]
    with pytest.raises(stark.InvalidArgument, match="one whole number, or 3"):
        cells_of((1, 2), 3, "cells")
    with pytest.raises(stark.InvalidArgument, match=f"makes {1001**3} vertices"):
        cells_of(1000, 3, "cells")
    assert counts_around("torus", rings=(8, 3), sides=(5, 3)) == [8, 5]
    with pytest.raises(stark.InvalidArgument, match=r"torus: sides = 2: .*\[3, 100000\]"):
        counts_around("torus", rings=(8, 3), sides=(2, 3))
