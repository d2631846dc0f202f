"""Cloth: its hinges against the edges of the mesh and closed forms, its mass, motion as a whole."""

from __future__ import annotations

import numpy as np
import pytest

import stark

AREA_DENSITY = 0.2  # [kg/m^2]


@stark.energy
def bending(h: stark.Hinge, k: float = 1.0):
    return 0.5 * k * h.angle**2


def inner_edges(triangles: np.ndarray) -> dict[frozenset[int], set[int]]:
    """Edges that two triangles share, with the two vertices opposite to them."""
    found: dict[frozenset[int], set[int]] = {}
    for triangle in triangles.tolist():
        for corner in triangle:
            found.setdefault(frozenset(triangle) - {corner}, set()).add(corner)
    return {edge: opposite for edge, opposite in found.items() if len(opposite) == 2}


def test_hinges_are_the_inner_edges_with_what_is_opposite() -> None:
    cloth = stark.Scene().add_cloth(stark.mesh.grid(1.0, 1.0, (3, 4)))
    expected = inner_edges(cloth.triangles)
    hinges = stark._core.find_hinges(cloth.triangles)
    assert len(cloth.hinges) == len(hinges) == len(expected) == 3 * 4 + 2 * 4 + 3 * 3
    for hinge in hinges.tolist():
        assert expected[frozenset(hinge[:2])] == set(hinge[2:])


def test_a_folded_pair_has_the_angle_of_the_fold() -> None:
    """Energies of hinges are half of the squared angle; the second triangle is turned about the edge."""
    fold = 0.7
    vertices = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [-np.cos(fold), 0, np.sin(fold)]])
    scene = stark.Scene()
    cloth = scene.add_cloth((vertices, [[0, 2, 1], [0, 1, 3]]))
    scene.add(bending(cloth.hinges, k=3.0))
    sim = stark.Simulation(scene)
    assert sim.energies[0].energies == pytest.approx([0.5 * 3.0 * fold**2], rel=1e-12)


def test_a_sheet_falls_freely_as_a_whole() -> None:
    scene = stark.Scene()
    material = stark.ShellMaterial(density=AREA_DENSITY, thickness=1e-3, youngs_modulus=1e5, mass_damping=0.0)
    cloth = scene.add_cloth(stark.mesh.grid(0.4, 0.3, 4), material, position=(0, 0, 1))
    start = cloth.positions.copy()
    sim = stark.Simulation(scene, time_step=0.01)
    for _ in range(5):
        assert not sim.step().failed
    # Implicit Euler: n (n + 1) / 2 steps of g h^2.
    assert np.abs(cloth.positions - start - (0, 0, -9.81 * 1e-4 * 15)).max() < 1e-9
    assert np.abs(cloth.velocities - (0, 0, -9.81 * 0.05)).max() < 1e-7


def test_wrong_sheets_are_refused_with_the_name() -> None:
    scene = stark.Scene()
    with pytest.raises(stark.InvalidMesh, match="'curtain'"):
        scene.add_cloth(([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]), name="curtain")
    with pytest.raises(stark.InvalidArgument, match="SolidMaterial"):
        scene.add_cloth(stark.mesh.grid(1, 1, 2), stark.materials.soft_rubber)
    assert len(scene) == 0


def test_a_mask_of_another_length_is_told_by_its_length() -> None:
    """The message showed the first values, which look right."""
    sheet = stark.mesh.grid(0.4, 0.4, cells=4)
    wrong = r"pins = an array of shape \(24,\) and type bool: must be indices .* a mask of \(25,\)"
    with pytest.raises(stark.InvalidArgument, match=wrong):
        stark.Scene().add_cloth(sheet, pins=np.ones(24, dtype=bool))
    cloth = stark.Scene().add_cloth(sheet, pins=[0])
    with pytest.raises(stark.InvalidArgument, match=r"vertices = an array of shape \(24,\) and type bool"):
        cloth.follow(displacement=lambda t: (0, 0, t), vertices=np.ones(24, dtype=bool))
