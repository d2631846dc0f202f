"""Values seen by a camera, against rays and triangles by hand."""

from __future__ import annotations

import numpy as np
import pytest

from stark.render import Camera
from stark.render.item_buffer import values_seen

SIZE = (64, 48)
CAMERA = Camera(eye=(0.2, -2.0, 0.7), target=(0.0, 0.0, 0.0), vertical_fov=0.7)


def by_rays(data: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Nearest hit of the ray of each pixel [Moeller, Trumbore 1997]; the value there."""
    right, up, forward = CAMERA.axes()
    half = np.tan(0.5 * CAMERA.vertical_fov)
    width, height = SIZE
    seen = np.full((height, width), np.nan)
    for row in range(height):
        for column in range(width):
            x, y = (
                (2 * (column + 0.5) / width - 1) * half * width / height,
                (1 - 2 * (row + 0.5) / height) * half,
            )
            ray, nearest = forward + x * right + y * up, np.inf
            for t in triangles:
                a, b, c = data[t, :3]
                system = np.column_stack([b - a, c - a, -ray])
                if abs(np.linalg.det(system)) < 1e-14:
                    continue
                u, v, depth = np.linalg.solve(system, CAMERA.eye - a)
                if min(u, v, 1 - u - v) >= 0 and 0.1 < depth < nearest:
                    nearest = depth
                    seen[row, column] = data[t, 3] @ [1 - u - v, u, v]
    return seen


def test_random_triangles() -> None:
    random = np.random.default_rng(5)
    data = np.column_stack([random.uniform(-0.9, 0.9, (24, 3)), random.uniform(0.0, 5.0, 24)])
    triangles = np.arange(24).reshape(8, 3)
    seen, expected = values_seen(data, triangles, CAMERA, SIZE, 0.1), by_rays(data, triangles)
    assert np.isfinite(expected).mean() > 0.3
    same = np.isfinite(seen) == np.isfinite(expected)
    assert same.mean() > 0.998  # rays through edges may go either way
    bands = [values_seen(data, triangles, CAMERA, SIZE, 0.1, rows) for rows in ((0, 17), (17, 18), (18, 48))]
    assert np.array_equal(np.concatenate(bands), seen, equal_nan=True)
    both = np.isfinite(seen) & np.isfinite(expected)
    assert np.abs(seen - expected)[both] == pytest.approx(0.0, abs=1e-9)


def test_a_floor_that_reaches_behind_the_camera() -> None:
    data = np.array([[-50.0, -50, -0.5, 0], [50, -50, -0.5, 0], [0, 80, -0.5, 13]])
    triangles = np.array([[0, 1, 2]])
    seen, expected = values_seen(data, triangles, CAMERA, SIZE, 0.1), by_rays(data, triangles)
    assert np.nan_to_num(seen) == pytest.approx(np.nan_to_num(expected), abs=1e-9)
    assert np.isfinite(seen).any()


def test_nothing_to_see() -> None:
    nothing = values_seen(np.zeros((0, 4)), np.zeros((0, 3), dtype=int), CAMERA, SIZE, 0.1)
    assert nothing.shape == SIZE[::-1] and np.isnan(nothing).all()
