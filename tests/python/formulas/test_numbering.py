"""Energies of triangles with directions: the axes of F, and what is said where they differ by triangle."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import stark

K, SHEAR = 1e3, 1e2  # [N/m]


def directional(F: Any, area: Any) -> Any:
    """Stretch of warp and weft and shear apart [Baraff, Witkin 1998]."""
    warp, weft = F[:, 0], F[:, 1]
    stretch = (stark.norm(warp) - 1) ** 2 + (stark.norm(weft) - 1) ** 2
    return area * (K / 2 * stretch + SHEAR / 2 * (warp @ weft) ** 2)


@stark.energy
def by_first_edge(t: stark.Triangle) -> Any:
    return directional(t.F, t.rest_area)


@stark.energy
def by_direction(t: stark.Triangle, warp: stark.Vec3) -> Any:
    return directional(t.F_along(warp), t.rest_area)


@stark.energy
def isotropic(t: stark.Triangle, h: stark.TimeStep) -> Any:
    rate = (t.F - t.F_prev) / h
    return t.rest_area * (stark.squared_norm(t.F.T @ t.F - stark.identity(2)) + h * stark.squared_norm(rate))


@stark.energy
def rate_by_direction(t: stark.Triangle, h: stark.TimeStep, warp: stark.Vec3) -> Any:
    rate = stark.norm(t.F_along(warp)[:, 0]) - stark.norm(t.F_prev_along(warp)[:, 0])
    return t.rest_area * rate * rate / h


@stark.energy
def told_apart(t: stark.Triangle, own: stark.Vec2) -> Any:
    return t.rest_area * stark.norm(t.F @ own)


def sheet() -> tuple[stark.Scene, stark.Cloth]:
    limp = stark.ShellMaterial(density=1.0, thickness=1e-3, youngs_modulus=1e-2, bending_stiffness=0.0)
    scene = stark.Scene()
    return scene, scene.add_cloth(stark.mesh.grid(0.4, 0.2, cells=(4, 2)), limp, self_contact=False)


def pulled(angle: float) -> float:
    """Force [N] of a sheet with the warp at an angle to its length, stretched by a quarter at one width."""
    scene, cloth = sheet()
    energy = scene.add(by_direction(cloth.faces, warp=(np.cos(angle), np.sin(angle), 0.0)))
    places = cloth.positions
    cloth.pin(range(len(places)))
    cloth.follow(lambda t: places * (1.0 + 0.25 * t, 1.0, 1.0))
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), time={"integrator": "quasistatic"})
    sim.step()
    forces = np.zeros_like(places)
    np.add.at(forces, cloth.mesh.triangles, energy.forces)
    return float(forces[places[:, 0] < -0.199, 0].sum())


def test_strain_along_a_direction_is_that_of_the_closed_form() -> None:
    """Of the stretch s along x at an angle a to the warp: W = k/2 ((|F a1| - 1)^2 + (|F a2| - 1)^2) +
    shear/2 (a1 F^T F a2)^2 with the warp a1 and the weft a2; its derivative by s is the force per width."""

    def density(s: float, angle: float) -> float:
        F, a, b = (
            np.diag([s, 1.0]),
            np.array([np.cos(angle), np.sin(angle)]),
            np.array([-np.sin(angle), np.cos(angle)]),
        )
        stretch = sum((np.linalg.norm(F @ axis) - 1) ** 2 for axis in (a, b))
        return float(K / 2 * stretch + SHEAR / 2 * ((F @ a) @ (F @ b)) ** 2)

    for angle in (0.0, 0.3, 1.2):
        expected = 0.2 * (density(1.25 + 1e-6, angle) - density(1.25 - 1e-6, angle)) / 2e-6
        assert pulled(angle) == pytest.approx(expected, rel=1e-8)


def test_strain_along_first_edges_is_said_where_it_matters() -> None:
    scene, cloth = sheet()
    wanted = r"depends on which of its corners comes first, as t\.F .* write t\.F_along\(direction\)"
    with pytest.warns(stark.StarkWarning, match=f"energy 'by_first_edge': .*{wanted}") as told:
        scene.add(by_first_edge(cloth.faces))
    assert told[0].filename == __file__
    report = by_first_edge.check(cloth.faces)
    assert not report.ok and report["numbering"].value > 0.01
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.add(by_direction(cloth.faces, warp=(1, 0, 0)))
        scene.add(isotropic(cloth.faces))
        scene.add(rate_by_direction(cloth.faces, warp=(1, 0, 0)))
        scene.add(told_apart(cloth.faces, own=np.ones((len(cloth.mesh.triangles), 2))))
    assert by_direction.check(cloth.faces, warp=(1, 0, 0)).ok


def test_a_direction_normal_to_a_triangle_is_refused() -> None:
    scene, cloth = sheet()
    with pytest.raises(stark.InvalidArgument, match="by_direction: the energy of element 0 is nan"):
        scene.add(by_direction(cloth.faces, warp=(0, 0, 1)))
