"""Seams between cloths of different cells: which side is attached to which, docs/attachments.md."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import stark

_MATERIAL = stark.ShellMaterial(
    density=0.2, thickness=1e-3, youngs_modulus=1e5, poissons_ratio=0.0, bending_stiffness=1e-6
)


def sewn(na: int, nb: int) -> tuple[stark.Scene, stark.Cloth, stark.Cloth, stark.Attachment]:
    """Two panels of 0.2 m side by side; the border of the left one is attached to the right one."""
    scene = stark.Scene()
    meshes = [stark.mesh.grid(0.2, 0.2, cells=n) for n in (na, nb)]
    left, right = (
        scene.add_cloth(
            mesh,
            _MATERIAL,
            pins=np.flatnonzero(mesh.vertices[:, 0] * side > 0.0999),
            position=(0.1 * side, 0.0, 0.0),
            name=name,
        )
        for mesh, side, name in zip(meshes, (-1.0, 1.0), ("left", "right"), strict=True)
    )
    border = np.flatnonzero(meshes[0].vertices[:, 0] > 0.0999)
    return scene, left, right, scene.attach(left.vertices[border], right, name="seam")


def gape(na: int, nb: int) -> float:
    """How far [m] the border of the right panel is from straight, stretched by 5 %."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene, _, right, _ = sewn(na, nb)
    right.follow(displacement=lambda t: (0.02 * min(t, 1.0), 0.0, 0.0))
    sim = stark.Simulation(scene, time_step=0.1, gravity=(0, 0, 0), **{"contact.enabled": False})
    for report in sim.run(until=3.0):
        assert not report.failed, report.message
    border = right.mesh.vertices[:, 0] < -0.0999
    return float(np.ptp(right.positions[border, 0]))


def test_a_fine_border_on_a_coarse_one_is_closed_and_the_other_way_gapes() -> None:
    assert gape(12, 6) < 1e-6
    assert 0.9e-3 < gape(6, 12) < 1.2e-3


@pytest.mark.parametrize(("na", "nb"), [(6, 12), (7, 12), (4, 30)])
def test_coarse_borders_on_fine_ones_warn(na: int, nb: int) -> None:
    with pytest.warns(
        stark.StarkWarning, match="'seam': .* vertices of the border of 'right' lie between the"
    ):
        sewn(na, nb)


@pytest.mark.parametrize(("na", "nb"), [(6, 6), (12, 6), (12, 5), (8, 9), (9, 8), (8, 11)])
def test_other_seams_do_not(na: int, nb: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sewn(na, nb)


def test_buttons_patches_and_tubes_do_not_warn() -> None:
    scene = stark.Scene()
    fine, coarse = stark.mesh.grid(0.2, 0.2, cells=20), stark.mesh.grid(0.1, 0.1, cells=4)
    sheet = scene.add_cloth(fine, name="sheet")
    pocket = scene.add_cloth(coarse, position=(0.0, 0.0, 0.003), name="pocket")
    strip = scene.add_cloth(
        stark.mesh.grid(0.2, 0.05, cells=(4, 1)), position=(0.0, -0.125, 0.0), name="strip"
    )
    width = 0.2 * np.pi
    x, y = stark.mesh.grid(width, 0.2, cells=(24, 8)).vertices[:, :2].T
    wound = np.column_stack((0.1 * np.sin(x / 0.1), -0.1 * np.cos(x / 0.1), y + 1.0))
    tube = scene.add_cloth(stark.mesh.grid(width, 0.2, cells=(24, 8)), initial_positions=wound, name="tube")
    ends = [np.flatnonzero(abs(x - side * width / 2) < 1e-9) for side in (-1, 1)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.attach(pocket.vertices, sheet)
        scene.attach(strip.vertices[[5, 7, 9]], sheet)  # every other one: buttons
        scene.attach(tube.vertices[ends[0]], tube.vertices[ends[1]])
        scene.attach(sheet.vertices[::3], None)
