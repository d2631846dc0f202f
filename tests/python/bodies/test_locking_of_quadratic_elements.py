"""A thick ring of nearly incompressible rubber under pressure inside, in plane strain, against the closed
form of Lamé: hexahedra of 27 nodes lock from a ratio of 0.499 on, and are warned about."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import stark

AROUND, ACROSS = 16, 2
INNER, OUTER, HEIGHT = 0.05, 0.1, 0.02  # [m]


def ring() -> stark.SolidMesh:
    """Bent from a box, whose ends meet."""
    box = stark.mesh.box_hexahedra((1.0, OUTER - INNER, HEIGHT), (AROUND, ACROSS, 1))
    x, y, z = (box.vertices - box.vertices.min(axis=0)).T
    angle, radius = -2.0 * np.pi * x, INNER + y
    places = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])
    _, first, same = np.unique(places.round(9), axis=0, return_index=True, return_inverse=True)
    return stark.mesh.to_quadratic(stark.SolidMesh(places[first], same.ravel()[box.elements]))


def widening(ratio: float, formulation: str) -> tuple[float, str]:
    """Of the inner side, over that of Lamé; and what is warned about."""
    pressure, young = 1.0, 1e4
    mesh = ring()
    x, z = mesh.vertices, mesh.vertices[:, 2]
    rubber = stark.SolidMaterial(density=1000, youngs_modulus=young, poissons_ratio=ratio, law="neo_hookean")
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        scene = stark.Scene()
        body = scene.add_solid(mesh, rubber, formulation=formulation, self_contact=False)
        for level in (0.0, HEIGHT):
            scene.add_rollers(body.vertices[abs(z - level) < 1e-9], "z")
        radius = np.hypot(x[:, 0], x[:, 1])
        inside = radius < INNER + 1e-4
        scene.add_face_pressure(body.faces[inside[body.triangles].all(axis=1)], pressure)
        sim = stark.Simulation(scene, time={"integrator": "quasistatic"}, gravity=(0, 0, 0))
    assert not sim.step().failed
    corners = abs(radius - INNER) < 1e-9
    grown = np.hypot(*body.positions[corners, :2].T).mean() - INNER
    share = INNER**2 / (OUTER**2 - INNER**2)
    exact = (1 + ratio) * pressure * INNER / young * ((1 - 2 * ratio) + (OUTER / INNER) ** 2) * share
    return grown / exact, " ".join(str(w.message) for w in said)


@pytest.mark.parametrize(
    ("ratio", "expected"), [(0.3, 0.977), (0.49, 0.974), (0.499, 0.875), (0.4999, 0.431)]
)
def test_hexahedra_of_27_nodes_lock(ratio: float, expected: float) -> None:
    found, said = widening(ratio, "displacement")
    assert found == pytest.approx(expected, abs=2e-3)  # as docs/solids.md has it
    assert ("hexahedra of 27 nodes as they are" in said) == (ratio >= 0.499)


@pytest.mark.parametrize("ratio", [0.3, 0.4999])
def test_with_their_own_volume_ratio_they_do_not(ratio: float) -> None:
    found, said = widening(ratio, "mean_dilatation")
    assert found == pytest.approx(0.975, abs=0.01)
    assert "lock" not in said
