"""Nothing passes through: fast balls and plates against thin sheets, taut crossing strips, contained
bodies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _helpers import Judge

import stark

pytest.importorskip("ipctk")

_HALF = 0.1  # half the width of the sheets [m]


def shoot(kind: str, sheet: str, *, cells: int, position: Any = (0.003, 0.002, 0.5)) -> stark.Scene:
    """A 5 mm steel ball at 100 m/s or a 1 mm aluminium plate at 200 m/s, aimed at a sheet that is pinned all
    around."""
    scene = stark.Scene()
    if sheet == "cloth":
        mesh, add, material = (
            stark.mesh.grid(2 * _HALF, 2 * _HALF, cells),
            scene.add_cloth,
            stark.materials.cotton,
        )
    else:
        mesh = stark.mesh.tet_box((2 * _HALF, 2 * _HALF, 0.004), (cells, cells, 1))
        add, material = scene.add_solid, stark.materials.soft_rubber
    add(mesh, material, name="sheet", pins=np.abs(mesh.vertices[:, :2]).max(axis=1) > _HALF - 1e-6)
    if kind == "ball":
        scene.add_sphere(
            0.0025, subdivisions=2, density=7800.0, position=position, velocity=(0, 0, -100.0), name="missile"
        )
    else:
        scene.add_box(
            (0.05, 0.05, 0.001), density=2700.0, position=position, velocity=(0, 0, -200.0), name="missile"
        )
    return scene


def is_above(missile: Any, sheet: Any) -> bool:
    """Whether the missile is still on the side of the sheet that it came from: a ray straight up from it
    crosses the sheet, of a solid its upper face, an even number of times. (Past its border at rest the sheet
    cannot be drawn.)"""
    centre = missile.position
    rest = sheet.mesh.vertices[:, 2]
    upper = (rest[sheet.triangles] > rest.max() - 1e-9).all(axis=1)
    x = sheet.positions[sheet.triangles[upper]]
    a, b, c = (x[:, i, :2] - centre[:2] for i in range(3))

    def cross(p: np.ndarray, q: np.ndarray) -> np.ndarray:
        return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]

    weights = np.stack([cross(b, c), cross(c, a), cross(a, b)], axis=1)
    hit = (weights > 0).all(axis=1) | (weights < 0).all(axis=1)
    heights = (weights[hit] * x[hit][:, :, 2]).sum(axis=1) / weights[hit].sum(axis=1)
    return int((heights > centre[2]).sum()) % 2 == 0


def stop_missile(scene: stark.Scene, step: float, count: int) -> None:
    """Steps and judges each of them. A step may fail, but must then leave the state as it was."""
    sim = stark.Simulation(scene, time_step=step, contact_distance=5e-4)
    judge = Judge(sim)
    missile, sheet = sim["missile"], sim["sheet"]
    speed = np.linalg.norm(missile.velocity)
    touched = False
    for _ in range(count):
        before = sim.state
        report = sim.step()
        if report.failed:
            assert report.message
            assert sim.state.hash == before.hash
            break
        touched |= report.contact_count > 0
        assert not judge.intersects()
        assert is_above(missile, sheet)
    # Had the sheet not been there, it would be metres below.
    assert touched
    assert np.linalg.norm(missile.velocity) < 0.9 * speed


@pytest.mark.parametrize("step", [1 / 30, 0.01])
@pytest.mark.parametrize("kind", ["ball", "plate"])
def test_cloth_stops_missiles(kind: str, step: float) -> None:
    stop_missile(shoot(kind, "cloth", cells=12), step, 4 if step > 0.02 else 6)


@pytest.mark.slow
@pytest.mark.parametrize("step", [1 / 30, 0.01])
@pytest.mark.parametrize("kind", ["ball", "plate"])
def test_thin_solid_stops_missiles(kind: str, step: float) -> None:
    start = 0.15 if kind == "plate" else 0.05
    scene = shoot(kind, "solid", cells=10, position=(0.003, 0.002, start))
    stop_missile(scene, step, 2)


def test_missile_without_contact_flies_on() -> None:
    """The same test bench without contact: free flight through the sheet, which the bench notices."""
    scene = shoot("ball", "cloth", cells=4, position=(0.003, 0.002, 0.5))
    scene.disable_contact("missile", "sheet")
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=5e-4)
    assert is_above(sim["missile"], sim["sheet"])
    for _ in range(3):
        assert not sim.step().failed
    assert not is_above(sim["missile"], sim["sheet"])
    assert sim["missile"].position[2] == pytest.approx(0.5 - 3.0 - 9.81 * 1e-4 * 6, abs=1e-9)


@pytest.mark.parametrize("kind", ["cloth", "solid"])
def test_taut_crossing_strips_hold_each_other(kind: str) -> None:
    """Two taut strips cross at a right angle; the ends of the upper one are pulled down below the lower one.
    They must press, bend each other and never swap sides."""
    scene = stark.Scene()
    if kind == "cloth":
        mesh = stark.mesh.grid(0.2, 0.01, (16, 1))
        material: Any = stark.ShellMaterial(youngs_modulus=1e5, mass_damping=5.0)
        add: Any = scene.add_cloth
    else:
        mesh = stark.mesh.tet_box((0.2, 0.01, 0.004), (12, 1, 1))
        material = stark.SolidMaterial(youngs_modulus=1e5, mass_damping=5.0)
        add = scene.add_solid
    quarter = stark.rotation(axis="z", angle=90 * stark.deg)
    ends = np.flatnonzero(np.abs(mesh.vertices[:, 0]) > 0.0999)
    add(mesh, material, name="lower", pins=ends)
    upper = add(mesh, material, name="upper", pins=ends, rotation=quarter, position=(0, 0, 0.01))
    sim = stark.Simulation(scene, time_step=1 / 60, contact_distance=5e-4, gravity=(0, 0, 0))
    judge = Judge(sim)
    targets = upper.pin_targets
    contacts = 0
    for k in range(40):
        moved = targets.copy()
        moved[:, 2] -= 0.002 * min(k + 1, 20)  # 40 mm in all, through the rest plane of the lower one
        sim["upper"].pin_targets = moved
        report = sim.step()
        assert not report.failed, report.message
        assert not judge.intersects()
        contacts = report.contact_count
    middle = np.abs(mesh.vertices[:, 0]) < 1e-6
    low, up = (sim[name].positions[middle].mean(axis=0) for name in ("lower", "upper"))
    assert contacts > 0
    assert up[2] > low[2]
    # Two equal springs share what their middles were moved by, the 30 mm that the ends passed each other and
    # the distance of the middles. What is left of the vibration: 1 %.
    assert low[2] == pytest.approx(-0.5 * (0.03 + up[2] - low[2]), rel=0.01)


@pytest.mark.parametrize("inner", ["rigid", "solid"])
@pytest.mark.parametrize("outer", ["rigid", "solid"])
def test_contained_body_is_refused(inner: str, outer: str) -> None:
    def scene_of(offset: float) -> stark.Scene:
        scene = stark.Scene()
        for name, kind, size, x in (("shell", outer, 0.2, 0.0), ("pearl", inner, 0.02, offset)):
            if kind == "rigid":
                scene.add_box(size, mass=1.0, name=name, position=(x, 0.01, 0.03))
            else:
                scene.add_solid(stark.mesh.tet_box(size, 2), name=name, position=(x, 0.01, 0.03))
        return scene

    with pytest.raises(stark.InitialIntersection, match="'pearl' is inside 'shell'"):
        stark.Simulation(scene_of(0.03))
    with pytest.raises(stark.InitialIntersection, match="intersect"):
        stark.Simulation(scene_of(0.1))
    stark.Simulation(scene_of(0.2))  # beside it is fine
    loose = scene_of(0.03)
    loose.disable_contact("shell", "pearl")
    stark.Simulation(loose)
