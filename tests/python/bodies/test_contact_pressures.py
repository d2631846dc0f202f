"""Contact pressure of solids of all elements that stand on a floor under their weight, and of one that lies
on a smaller block: the weight over the area that touches."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

SIDE, DENSITY = 0.2, 1000.0
MESHES = {
    "tet4": stark.mesh.tet_box(SIDE, 4),
    "tet10": stark.mesh.to_quadratic(stark.mesh.tet_box(SIDE, 2)),
    "hex8": stark.mesh.box_hexahedra(SIDE, 4),
    "hex27": stark.mesh.to_quadratic(stark.mesh.box_hexahedra(SIDE, 2)),
}


def settled(mesh: Any, support: stark.TriangleMesh | None = None) -> Any:
    """A block of rubber in balance on the floor, or on a fixed body with its top at zero."""
    scene = stark.Scene()
    if support is None:
        scene.add_floor()
    else:
        scene.add_rigid(support, name="support", position=(0, 0, -0.05), motion="fixed")
    rubber = stark.SolidMaterial(density=DENSITY, youngs_modulus=1e5, poissons_ratio=0.0)
    block = scene.add_solid(mesh, rubber, position=(0, 0, SIDE / 2 + 0.0005))
    sim = stark.Simulation(scene, **{"time.integrator": "quasistatic"})
    for report in sim.run(0.02):
        assert not report.failed, report.message
    return sim, sim[block]


@pytest.mark.parametrize("element", MESHES)
def test_a_block_presses_a_floor_evenly(element: str) -> None:
    _sim, block = settled(MESHES[element])
    x = np.asarray(block.positions)
    pressure = block.contact_pressure()
    bottom = x[:, 2] < x[:, 2].min() + SIDE / 40
    # Weight over area is 1962 Pa. Linear tetrahedra are stiffer along their diagonals.
    np.testing.assert_allclose(pressure[bottom], DENSITY * 9.81 * SIDE, rtol=0.03)
    assert not pressure[~bottom].any()


@pytest.mark.parametrize("element", MESHES)
def test_faces_that_touch_in_part_carry_all_of_the_force(element: str) -> None:
    _sim, block = settled(MESHES[element], stark.mesh.box(0.1))
    contacts = block.contacts()
    weight = np.abs(contacts.forces[:, 2].sum())
    assert weight == pytest.approx(DENSITY * 9.81 * SIDE**3, rel=1e-4)
    pressure = block.contact_pressure()
    assert np.isfinite(pressure).all() and (pressure >= 0.0).all()
    touched = pressure > 1e-3 * pressure.max()
    assert np.abs(np.asarray(block.positions)[touched, :2]).max() < 0.11


def test_rods_have_no_area_to_spread_their_force_over() -> None:
    """The area was 0 without a word, the pressure an error of NumPy about shapes."""
    scene = stark.Scene()
    floor = scene.add_floor()
    cord = scene.add_rod(stark.mesh.polyline((0, 0, 0.002), (0.2, 0, 0.002), 8), stark.materials.rubber_cord)
    sim = stark.Simulation(scene)
    sim.step()
    for read in (lambda: cord.contact_area(floor), lambda: cord.contact_pressure(floor)):
        with pytest.raises(stark.InvalidArgument, match=r"'rod': contact_.*a rod has no triangles"):
            read()
    assert floor.contact_pressure(cord).shape == (4,)
