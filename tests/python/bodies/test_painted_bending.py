"""Bending stiffness with a value for each triangle: strips that are soft in one half, stiff in the other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark

LENGTH, WIDTH, CELLS = 0.2, 0.02, 40
SOFT, STIFF = 2e-3, 8e-3  # [N m]
DENSITY, GRAVITY = 0.02, 5.0  # [kg/m^2], [m/s^2]


def _strip(name: str, values: object, **options: float) -> stark.Scene:
    mesh = stark.mesh.grid(LENGTH, WIDTH, cells=(CELLS, 4))
    material = stark.ShellMaterial(
        density=DENSITY,
        thickness=1e-3,
        youngs_modulus=1e6,
        poissons_ratio=0.0,
        **{"bending_stiffness": 0.0, "flexural_rigidity": 0.0, name: values, **options},
    )
    root = mesh.vertices[:, 0] < -LENGTH / 2 + 1.01 * LENGTH / CELLS
    scene = stark.Scene()
    scene.add_cloth(mesh, material, pins=root, self_contact=False)
    return scene


def _sag(scene: stark.Scene) -> float:
    """Of the free end after one static step [m]."""
    settings = {"time.integrator": "quasistatic", "newton.acceleration_tolerance": 1e-5}
    sim = stark.Simulation(scene, settings, time_step=1.0, gravity=(0, 0, -GRAVITY))
    sim.step()
    cloth = sim.bodies[0]
    return float(-cloth.positions[cloth.mesh.vertices[:, 0] > LENGTH / 2 - 1e-9, 2].mean())


def _halves(cloth_mesh: stark.mesh.TriangleMesh, root: float, end: float) -> np.ndarray:
    middle = cloth_mesh.vertices[cloth_mesh.triangles][:, :, 0].mean(axis=1)
    return np.where(middle < 0.0, root, end)


def _beam(root: float, end: float) -> float:
    """Small deflection of the end of a clamped strip of two rigidities under its weight [m], by sums."""
    free = LENGTH * (1.0 - 0.5 / CELLS)  # half of the width of the first hinge bends within the clamped cell
    x = (np.arange(20_000) + 0.5) * free / 20_000
    load = DENSITY * GRAVITY
    rigidity = np.where(x < free - LENGTH / 2, root, end)
    moment = 0.5 * load * (free - x) ** 2
    return float(np.sum(moment / rigidity * (free - x)) * free / 20_000)


@pytest.mark.parametrize("name", ["bending_stiffness", "flexural_rigidity"])
def test_strips_of_two_halves_sag_as_beams(name: str) -> None:
    """Over the strip that is soft all along: how much of the clamped cell bends with the rest, and that
    hinges are stiffer than a plate by a factor of the mesh, is the same for all."""
    mesh = stark.mesh.grid(LENGTH, WIDTH, cells=(CELLS, 4))
    soft = _sag(_strip(name, _halves(mesh, SOFT, SOFT)))
    if name == "flexural_rigidity":
        assert soft == pytest.approx(_beam(SOFT, SOFT), rel=0.05)  # (1 - 0.5/40)^4 = 0.951, had it no part
    for root, end in ((SOFT, STIFF), (STIFF, SOFT), (STIFF, STIFF)):
        sag = _sag(_strip(name, _halves(mesh, root, end)))
        # 40 cells, slopes up to 0.07: 0.5 %.
        assert sag / soft == pytest.approx(_beam(root, end) / _beam(SOFT, SOFT), rel=0.01)


@pytest.mark.parametrize("name", ["bending_stiffness", "flexural_rigidity"])
def test_even_values_are_one_value(name: str) -> None:
    count = 2 * CELLS * 4
    even = _sag(_strip(name, np.full(count, SOFT)))
    assert even == pytest.approx(_sag(_strip(name, SOFT)), rel=1e-9)


def test_what_yields_has_its_own_stiffness_below() -> None:
    mesh = stark.mesh.grid(LENGTH, WIDTH, cells=(CELLS, 4))
    for name in ("bending_stiffness", "flexural_rigidity"):
        values = _halves(mesh, SOFT, STIFF)
        hard = _sag(_strip(name, values, bending_yield_moment=1.0))  # never reached
        assert hard == pytest.approx(_sag(_strip(name, values)), rel=1e-4)


def test_documents_keep_them(tmp_path: Path) -> None:
    mesh = stark.mesh.grid(LENGTH, WIDTH, cells=(CELLS, 4))
    scene = _strip("flexural_rigidity", _halves(mesh, SOFT, STIFF))
    scene.save(tmp_path / "strip.json")
    assert _sag(stark.load_scene(tmp_path / "strip.json")) == _sag(scene)


def test_wrong_values_are_refused() -> None:
    for values, text in ((np.ones(7), "must be 1 for each of the 320 elements"), (-np.ones(320), ">= 0")):
        with pytest.raises(stark.InvalidArgument, match=text):
            _strip("bending_stiffness", values)
