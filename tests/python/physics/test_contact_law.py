"""The law of contact: pressure against gap is what was given, at every time step and on every mesh; bodies
that start close are not thrown."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from _helpers import G

import stark

_D = 2e-3  # sum of the contact distances of two bodies [m]


def gap_at(relative: float, d: float = _D) -> float:
    """Gap [m] at a pressure over the contact stiffness, by bisection of the curve as it is documented."""
    low, high = 1e-9, 1.0 - 1e-12
    for _ in range(200):
        middle = 0.5 * (low + high)
        slope = 2.0 * (middle - 1.0) * math.log(middle) + (1.0 - middle) ** 2 / middle
        low, high = (middle, high) if slope / (math.log(2.0) + 0.5) > relative else (low, middle)
    return low * d


def last(sim: Any, until: float) -> Any:
    report = None
    for report in sim.run(until=until):  # noqa: B007
        pass
    return report


@pytest.mark.parametrize("mass", [0.1, 1.0, 20.0, 1000.0])
def test_pressure_follows_the_curve_that_was_given(mass: float) -> None:
    scene = stark.Scene()
    scene.default_friction = 0.0
    scene.add_floor(1.0, contact_stiffness=5e3)
    box = scene.add_box(0.1, mass=mass, position=(0, 0, 0.05 + _D), contact_stiffness=5e3)
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=0.5 * _D)
    last(sim, 0.5)
    gap = float(box.positions[:, 2].min())
    assert gap == pytest.approx(gap_at(mass * G / 0.01 / 5e3), rel=2e-4)


def test_the_curve_in_python_is_that_of_the_solver() -> None:
    surface = stark.Surface("foam", 1e-3, 4e3, "a test")
    assert surface.pressure(1e-3) == pytest.approx(4e3)
    assert surface.pressure(gap_at(3.0)) == pytest.approx(3.0 * 4e3)
    assert surface.pressure(2e-3) == 0.0


FELT = stark.Surface("felt", 1e-3, 1e3, "a test", core=0.4e-3)


@pytest.mark.parametrize("mass", [0.5, 10.0, 1e3, 1e4])
def test_no_pressure_takes_the_core(mass: float) -> None:
    """From 0.5 kPa to 10 MPa, the box is where the documented curve says."""
    scene = stark.Scene()
    scene.default_friction = 0.0
    scene.add_floor(1.0, surface=FELT)
    box = scene.add_box(0.1, mass=mass, position=(0, 0, 0.05 + 1.01 * _D), surface=FELT)
    sim = stark.Simulation(scene, time_step=0.01)
    report = last(sim, 1.5)
    gap = float(box.positions[:, 2].min())
    assert FELT.pressure(gap) == pytest.approx(mass * G / 0.01, rel=0.02)
    assert report.min_distance > 2.0 * FELT.core * (1.0 - 1e-9)


@pytest.mark.parametrize("turn", [0.0, 31.0])
def test_layers_of_cloth_keep_their_cores_under_a_press(turn: float) -> None:
    """Sheets with edges that cross: they push before collision detection stops them at the core."""
    scene = stark.Scene()
    scene.add_floor(1.0, surface=FELT)
    for k in range(3):
        scene.add_cloth(
            stark.mesh.grid(0.1, 0.1, 5 + k), mass=0.004, position=(0, 0, (k + 1) * 1.01 * _D), surface=FELT,
            rotation=stark.rotation(axis="z", angle=k * turn * stark.deg), name=f"sheet_{k}",
        )  # fmt: skip
    box = scene.add_box((0.15, 0.15, 0.02), mass=200.0, position=(0, 0, 0.01 + 4.05 * _D), surface=FELT)
    sim = stark.Simulation(scene, time_step=0.01)
    for report in sim.run(until=0.6):
        assert not report.failed, report.message
        assert not report.caveats
        assert report.min_distance > 2.0 * FELT.core * (1.0 - 1e-9)
    height = box.position[2] - 0.01  # four gaps of 0.8 mm; without a core 0.2 mm in sum
    assert 4 * 0.8e-3 < height < 4 * 1.2e-3


def test_a_hinge_on_a_wheel_that_is_pressed_to_a_core_is_held() -> None:
    """1 kg on a corner of a wheel, on a layer of 10 Pa: more than its barrier carries at the core itself. It
    was blocked there, thrown off with 4 kN once contact was raised, and its joints came apart."""
    scene = stark.Scene()
    scene.default_friction = 0.5
    layer = stark.surfaces.terry_towel.replace(stiffness=10.0)
    scene.add_box((0.6, 0.3, 0.02), motion="fixed", position=(0, 0, -0.01), surface=layer, name="layer")
    z = 0.013
    arm = scene.add_box((0.2, 0.01, 0.01), mass=2.0, position=(-0.1, 0, z + 0.02))
    turned = stark.rotation(axis=(1, 0.3, 0.2), angle=0.4)
    wheel = scene.add_sphere(
        0.01, subdivisions=1, mass=0.02, position=(0, 0, z), rotation=turned, name="wheel"
    )
    scene.disable_contact(arm, wheel)
    scene.add_hinge(None, arm, anchor=(-0.2, 0, z), axis=(0, 1, 0))
    axle = scene.add_hinge(arm, wheel, anchor=(0, 0, z), axis=(0, 1, 0))
    axle.add_motor(20.0, cap=0.02, delta=1.0)
    sim = stark.Simulation(scene, time_step=5e-3, contact_distance=5e-4)
    for report in sim.run(until=0.4):
        assert report.status == "accepted", report.message
        assert report.min_distance > 0.9999 * layer.core
    load = float(sim.contacts.of("wheel", "layer").forces.sum(axis=0)[2])
    sideways = float(sim.contacts.of("wheel", "layer").forces.sum(axis=0)[0])
    # Moments about the bearing, at the height of the axle; the wheel is below it.
    assert 0.2 * (load - 0.02 * G) + 0.01 * sideways == pytest.approx(0.1 * 2.0 * G, rel=0.02)


def test_a_core_has_room_in_the_thickness() -> None:
    with pytest.raises(stark.InvalidArgument, match=r"core = 0\.0006 m: must be between 0 and half"):
        FELT.replace(core=0.6e-3)
    scene = stark.Scene()
    with pytest.raises(stark.InvalidArgument, match=r"contact_core.*at least twice the core"):
        scene.add_box(0.1, mass=1.0, surface=FELT, contact_distance=0.5e-3)
    assert scene.add_box(0.1, mass=1.0, surface=FELT).contact_core == 0.4e-3


def test_bodies_that_start_within_their_cores_are_not_thrown() -> None:
    scene = stark.Scene()
    scene.add_floor(1.0, surface=FELT, name="floor")
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.05 + 0.5e-3), surface=FELT, name="box")
    sim = stark.Simulation(scene, time_step=0.01)
    heights = []
    for _ in sim.run(until=0.5):
        heights.append(box.position[2] - 0.05)
    assert max(heights) < 0.6e-3
    assert min(heights) > 0.2e-3


def test_a_sheet_that_starts_folded_keeps_its_thickness() -> None:
    """In the crease the halves are nearer than the contact distance. That made the sheet half as thick
    everywhere."""
    surface = FELT.replace(core=0.0)
    mesh = stark.mesh.grid(0.1, 0.1, 8)
    x, y, _ = mesh.vertices.T
    layer = np.sign(np.round(y / 0.0125))
    scene = stark.Scene()
    scene.add_floor(1.0, surface=surface)
    start = np.column_stack([x, np.abs(y), 1.01 * _D * (1.5 + 0.5 * layer)])
    cloth = scene.add_cloth(mesh, mass=0.004, initial_positions=start, surface=surface, name="sheet")
    sim = stark.Simulation(scene, time_step=0.01)
    assert not sim.close_bodies
    last(sim, 0.6)
    height = [cloth.positions[(layer == k) & (np.abs(y) > 0.03), 2].mean() for k in (-1.0, 1.0)]
    assert height[1] - height[0] > 0.85 * _D


def test_a_side_without_a_stiffness_is_rigid_where_the_other_has_one() -> None:
    scene = stark.Scene()
    scene.add_box(
        (0.3, 0.3, 0.05), mass=3.0, position=(0, 0, 0.025 + 0.003), name="base", contact_stiffness=1e5
    )
    scene.add_floor(1.0)
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.1061), surface=stark.surfaces.terry_towel)
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=1e-3)
    last(sim, 0.5)
    base = scene["base"]
    gap = float(box.positions[:, 2].min() - base.positions[:, 2].max())
    d = 1e-3 + 1.625e-3
    stiffness = d / (1e-3 / 1e5 + 1.625e-3 / 1e3)
    assert gap == pytest.approx(gap_at(G / 0.01 / stiffness, d), rel=2e-3)


@pytest.mark.parametrize("load", [0.0, 1000.0])
def test_gap_does_not_depend_on_the_time_step(load: float) -> None:
    gaps = []
    for step in (0.01, 0.005, 0.001):
        scene = stark.Scene()
        scene.add_floor(1.0)
        box = scene.add_box(0.1, mass=0.01, position=(0, 0, 0.05 + _D))
        if load > 0.0:
            # Damped, so that it comes to rest: the law dissipates nothing.
            scene.add_box(0.1, mass=load, position=(0, 0, 0.15 + 2.0 * _D), linear_damping=20.0)
        sim = stark.Simulation(scene, time_step=step, contact_distance=0.5 * _D)
        last(sim, 2.0)
        gaps.append(float(box.positions[:, 2].min()))
    assert max(gaps) < 1.02 * min(gaps)
    if load > 0.0:
        assert gaps[0] == pytest.approx(0.1 * _D, rel=0.03)


def plate_on_block(cells: int, step: float) -> tuple[float, float]:
    """Mean gap of a plate on a soft block that it covers [m], and the gap of the curve."""
    scene = stark.Scene()
    block = scene.add_solid(
        stark.mesh.tet_box((0.1, 0.1, 0.04), (cells, cells, max(1, cells // 2))),
        stark.materials.soft_rubber.replace(youngs_modulus=1e6),
        contact_stiffness=2e3,
    )
    z = block.mesh.vertices[:, 2]
    block.pin(np.flatnonzero(z < z.min() + 1e-9))
    top = np.flatnonzero(z > z.max() - 1e-9)
    plate = scene.add_box(
        (0.2, 0.2, 0.02),
        mass=2.0,
        position=(0, 0, z.max() + 0.01 + _D),
        linear_damping=40.0,
        angular_damping=40.0,
    )
    sim = stark.Simulation(scene, time_step=step, contact_distance=0.5 * _D)
    last(sim, 0.6)
    gaps = plate.positions[:, 2].min() - block.positions[top, 2]
    # Of a pair of which one was given: d over the part of the block.
    return float(gaps.mean()), gap_at(2.0 * G / 0.01 / (2.0 * 2e3))


@pytest.mark.parametrize("step", [0.01, 0.005, pytest.param(0.001, marks=pytest.mark.slow)])
@pytest.mark.parametrize("cells", [2, 4, 8])
def test_gap_of_a_plate_on_a_soft_block_on_any_mesh(cells: int, step: float) -> None:
    gap, expected = plate_on_block(cells, step)
    assert gap == pytest.approx(expected, rel=0.02)


def sheets(lower: int, upper: int, turn: float, width: float = 0.1) -> tuple[Any, Any]:
    """A sheet of 1 kg/m^2 of `width` on a pinned one of 0.2 m, after it came to rest; cells of each."""
    scene = stark.Scene()
    scene.default_friction = 0.0
    below = scene.add_cloth(stark.mesh.grid(0.2, 0.2, lower), mass=0.04, contact_stiffness=50.0)
    below.pin(np.arange((lower + 1) ** 2))
    above = scene.add_cloth(
        stark.mesh.grid(width, width, upper),
        mass=width**2,
        contact_stiffness=50.0,
        position=(0, 0, 1.01 * _D),
        rotation=stark.rotation(axis="z", angle=turn * stark.deg),
    )
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=0.5 * _D)
    last(sim, 0.5)
    return sim, above


@pytest.mark.parametrize(
    ("lower", "upper", "turn"), [(10, 10, 0.0), (40, 20, 0.0), (10, 10, 17.0), (40, 20, 45.0), (10, 30, 30.0)]
)
def test_gap_of_cloth_on_cloth_on_any_mesh(lower: int, upper: int, turn: float) -> None:
    _, above = sheets(lower, upper, turn)
    assert float(above.positions[:, 2].mean()) == pytest.approx(gap_at(G / 50.0), rel=0.02)


@pytest.mark.parametrize("shift", [0.0, 0.003])
def test_aligned_sheets_have_one_contact_at_each_place(shift: float) -> None:
    scene = stark.Scene()
    scene.default_friction = 0.0
    below = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 20), mass=0.04, contact_stiffness=50.0)
    below.pin(np.arange(21**2))
    above = scene.add_cloth(
        stark.mesh.grid(0.2, 0.2, 20),
        mass=0.04,
        contact_stiffness=50.0,
        position=(shift, 0.7 * shift, 1.001 * _D),
        velocity=(0, 0, -0.1),
    )
    # In its first step on it stays flat, so that there are no valleys.
    sim = stark.Simulation(scene, time_step=1e-3, contact_distance=0.5 * _D, gravity=(0, 0, 0))
    sim.step()
    force = np.abs(sim.contacts.normal_forces[:, 2])
    # Vertices above or below the other sheet: all of the aligned ones, a row and a column less where they are
    # shifted. Corners of one triangle have a sixth of the area of an inner vertex, which is about what pairs
    # of border edges have, too; pairs of inner edges have next to nothing.
    count = np.count_nonzero(force > 0.2 * force.max())
    assert count == pytest.approx(2 * (21**2 if shift == 0.0 else 20**2), abs=4)
    assert above.positions[:, 2].min() > 0.0


@pytest.mark.parametrize("step", [1 / 60, 2e-3, 1e-3, 5e-4])
def test_bodies_that_start_within_their_contact_distance_are_not_thrown(step: float) -> None:
    scene = stark.Scene()
    scene.add_floor(1.0, name="floor")
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.05 + 0.5 * _D), name="box")
    sim = stark.Simulation(scene, time_step=step, contact_distance=0.5 * _D)
    assert sim.close_bodies == {("floor", "box"): pytest.approx(0.5 * _D)}
    highest = max(float(box.position[2]) for _ in sim.run(until=0.2))
    assert highest < 0.05 + 0.5 * _D + 1e-4
    assert float(box.velocity[2]) == pytest.approx(0.0, abs=1e-4)


def test_contact_distance_comes_back_when_bodies_part() -> None:
    scene = stark.Scene()
    scene.add_floor(1.0)
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.05 + 0.5 * _D), velocity=(0, 0, 0.3))
    sim = stark.Simulation(scene, time_step=1e-3, contact_distance=0.5 * _D)
    state = sim.state
    last(sim, 0.02)
    assert sim.close_bodies == {}
    last(sim, 0.5)
    resting = float(box.position[2])
    assert resting > 0.05 + 0.8 * _D
    sim.state = state
    assert len(sim.close_bodies) == 1


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize("factor", [1.0, 10.0, 100.0])
def test_a_bounce_meets_the_same_law_on_its_way_out(integrator: str, factor: float) -> None:
    scene = stark.Scene()
    scene.default_friction = 0.0
    scene.add_floor(1.0)
    scene.add_box(0.1, mass=1.0, position=(0, 0, 0.15))
    settings = {"time.integrator": integrator, "contact.stiffness_factor": factor}
    sim = stark.Simulation(scene, time_step=1e-3, contact_distance=5e-3, **settings)
    injected, stored, start, most = 0.0, 0.0, 0.0, 0.0
    for report in sim.run(until=0.35):
        energy = report.energy
        injected += report.contact_energy_at_start - stored
        stored = energy["contact"]
        total = energy["kinetic"] + energy["gravity"] + energy["contact"]
        start = start or total
        most = max(most, total)
    assert abs(injected) < 1e-6  # of 0.98 J
    assert most < start + 1e-6
