"""Inertias of shapes against those of their meshes."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark.robots.description import Geometry
from stark.robots.inertias import inertia_of
from stark.robots.meshes import mesh_of


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "capsule"])
def test_inertias_of_shapes_are_those_of_their_meshes(kind: str) -> None:
    size = {"box": (0.1, 0.2, 0.3), "sphere": (0.2,)}.get(kind, (0.1, 0.4))
    turn = stark.rotation(axis=(1, 2, 3), angle=0.7)
    shape = Geometry(kind, size, position=np.array([0.1, 0.2, 0.3]), rotation=turn)
    surface = mesh_of(shape, "file", "part")
    as_mesh = Geometry("mesh", vertices=surface.vertices, triangles=surface.triangles)
    exact, meshed = (inertia_of(row, 700.0, "file", "part") for row in (shape, as_mesh))
    assert exact is not None and meshed is not None
    # Facets cut a part of what is round off.
    assert meshed.mass == pytest.approx(exact.mass, rel=1e-9 if kind == "box" else 0.05)
    np.testing.assert_allclose(exact.center, meshed.center, atol=1e-9)
    np.testing.assert_allclose(exact.tensor / exact.mass, meshed.tensor / meshed.mass, atol=5e-4)


def test_open_meshes_have_none() -> None:
    sheet = stark.mesh.grid(1.0, 1.0, 2)
    shape = Geometry("mesh", vertices=sheet.vertices, triangles=sheet.triangles)
    assert inertia_of(shape, 1.0, "file", "part") is None
