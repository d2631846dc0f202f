"""Coulomb friction on an inclined plane: sticking without creep, sliding at g (sin - mu cos), for rigid and
soft bodies on coarse, fine and turned floor meshes; which coefficient holds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _helpers import G, advance, inclined_floor, mean_velocity

import stark

_GAP = 1e-3  # contact distance of each body [m]
_STICK = 1e-3  # stick velocity [m/s]


def box_on_incline(
    angle: float, mu: float | tuple[float, float] | None, *, cells: int = 1, turn: float = 0.0, **options: Any
) -> tuple[stark.Simulation, Any, np.ndarray]:
    scene = stark.Scene()
    axes = inclined_floor(scene, angle, cells=cells, turn=turn)
    # Beside the middle, where the diagonal of the coarse floor runs.
    position = axes @ (0.0, 0.4, 0.05 + 1.9 * _GAP)
    box = scene.add_box(0.1, mass=1.0, name="box", rotation=axes, position=position, **options)
    if mu is not None:
        scene.friction["box", "floor"] = mu
    # Where the box crosses an edge of the floor, the contact with it presses obliquely over a few d^. That is
    # a small bump, which averages out if the step is short enough to resolve it.
    step = 1 / 60 if cells == 1 and turn == 0.0 else 1 / 240
    options = {"contact.stick_velocity": _STICK}
    sim = stark.Simulation(scene, time_step=step, contact_distance=_GAP, **options)
    return sim, box, axes


def acceleration_downhill(sim: stark.Simulation, box: Any, axes: np.ndarray) -> float:
    """Of implicit Euler under a constant force: velocities grow by a h in every step, so two of them tell it.
    The first 0.3 s let the box settle on the barrier."""
    advance(sim, 0.3)
    start, v0 = sim.time, box.velocity @ axes[:, 0]
    advance(sim, 0.8)
    return float((box.velocity @ axes[:, 0] - v0) / (sim.time - start))


# The floors: two triangles, cells smaller than the box, and those turned, so that edges cross in all
# directions.
FLOORS = [(1, 0.0), (40, 0.0), (40, 31.0)]


@pytest.mark.parametrize(("cells", "turn"), FLOORS)
@pytest.mark.parametrize(("angle", "mu"), [(20.0, 0.3), (30.0, 0.2)])
def test_rigid_box_slides_with_coulombs_acceleration(
    angle: float, mu: float, cells: int, turn: float
) -> None:
    sim, box, axes = box_on_incline(angle, mu, cells=cells, turn=turn)
    a = angle * stark.deg
    # 1 % of the difference of gravity and friction is 0.2 % of the friction itself at 20 degrees.
    assert acceleration_downhill(sim, box, axes) == pytest.approx(G * (np.sin(a) - mu * np.cos(a)), rel=0.01)
    # It neither drifts sideways nor turns: the floor is isotropic, whatever its edges. 1 % of the slide.
    slid = box.position @ axes - (0.0, 0.4, 0.0)
    assert abs(slid[1]) < 0.01 * slid[0]
    assert box.rotation == pytest.approx(axes, abs=0.01)


@pytest.mark.parametrize(("cells", "turn"), FLOORS)
def test_rigid_box_sticks_below_the_limit_and_does_not_creep(cells: int, turn: float) -> None:
    angle, mu = 20.0, 0.5
    sim, box, axes = box_on_incline(angle, mu, cells=cells, turn=turn)
    start = box.position @ axes[:, 0]
    advance(sim, 0.5)
    settled = box.position @ axes[:, 0]
    # It gives way by the deflection at which the law carries the load, mu N (2 - y) y = m g sin with
    # N = m g cos, and by what it slides while it settles on the barrier.
    assert settled - start < 0.5e-3
    advance(sim, 10.5)
    # Ten seconds: rounding and the residual that the solver leaves, a thousandth of 0.1 mm.
    assert abs(box.position @ axes[:, 0] - settled) < 1e-7


@stark.energy
def push(f: stark.Frame, force: stark.Vec3):
    """A force on the origin of a body [N]."""
    return -(force @ f.origin)


@pytest.mark.parametrize(("share", "moves"), [(0.48, False), (0.52, True)])
def test_static_and_kinetic_coefficients(share: float, moves: bool) -> None:
    """A push of a share of the weight: held up to mu_s = 0.5, sliding by mu_k = 0.3 once it goes."""
    scene = stark.Scene()
    scene.add_floor(20.0, name="floor", position=(0.0, 1.3, 0.0))
    box = scene.add_box(0.1, mass=1.0, name="box", position=(0.0, 0.4, 0.05 + 1.9 * _GAP))
    scene.friction[box, "floor"] = 0.5, 0.3
    assert (scene.friction[box, "floor"], scene.friction.kinetic(box, "floor")) == (0.5, 0.3)
    hand = scene.add(push(box, force=(0, 0, 0)))
    sim = stark.Simulation(scene, time_step=1 / 60, contact_distance=_GAP)
    advance(sim, 0.4)
    start = box.position
    hand.force = (share * G, 0.0, 0.0)
    advance(sim, 0.5)
    if not moves:
        assert box.position == pytest.approx(start, abs=1e-4)
        return
    velocity, time = box.velocity[0], sim.time
    advance(sim, 1.0)
    assert (box.velocity[0] - velocity) / (sim.time - time) == pytest.approx(G * (share - 0.3), rel=0.01)


@pytest.mark.parametrize("pair", [(0.3, 0.5), (0.3, -0.1), "ice", (0.3, 0.2, 0.1)])
def test_coefficients_that_make_no_sense_are_refused(pair: Any) -> None:
    scene = stark.Scene()
    scene.add_floor(name="floor")
    with pytest.raises(stark.InvalidArgument, match="friction of"):
        scene.friction["floor", "floor"] = pair


def test_a_sliding_box_stops_by_its_kinetic_coefficient_and_stays() -> None:
    """On a slope that only the static coefficient holds, a box that comes uphill stops and stays there."""
    sim, box, axes = box_on_incline(
        20.0, (0.5, 0.3), velocity=(-0.5 * np.cos(20 * stark.deg), 0, 0.5 * np.sin(20 * stark.deg))
    )
    a = 20.0 * stark.deg
    brake = G * (np.sin(a) + 0.3 * np.cos(a))
    start = box.position @ axes[:, 0]
    advance(sim, 0.5)
    # v^2 / 2 a, less v h / 2 of implicit Euler.
    assert start - box.position @ axes[:, 0] == pytest.approx(0.5**2 / (2 * brake) - 0.25 / 60, rel=0.05)
    stopped = box.position
    advance(sim, 2.0)
    assert box.position == pytest.approx(stopped, abs=1e-7)


def test_limit_angle_of_sticking() -> None:
    """mu 0.5 holds up to 26.565 degrees."""
    sim, box, axes = box_on_incline(26.0, 0.5)
    advance(sim, 0.5)
    assert box.velocity @ axes[:, 0] < _STICK
    sim, box, axes = box_on_incline(27.0, 0.5)
    a = 27.0 * stark.deg
    # What is left of gravity is 0.08 m/s^2 here, a small difference of large forces: 1 % of these.
    assert acceleration_downhill(sim, box, axes) == pytest.approx(
        G * (np.sin(a) - 0.5 * np.cos(a)), abs=0.01 * 0.5 * G
    )


@pytest.mark.parametrize(("cells", "turn"), [(1, 0.0), (20, 31.0)])
def test_soft_box_slides_like_a_rigid_one_less_its_damping(cells: int, turn: float) -> None:
    angle, mu, damping, density = 20.0 * stark.deg, 0.3, 0.4, 1000.0
    material = stark.SolidMaterial(
        density=density, youngs_modulus=2e5, poissons_ratio=0.3, mass_damping=damping
    )
    scene = stark.Scene()
    axes = inclined_floor(scene, 20.0, cells=cells, turn=turn)
    box = scene.add_solid(
        stark.mesh.tet_box(0.1, 2),
        material,
        name="box",
        rotation=axes,
        position=axes[:, 2] * (0.05 + 1.9 * _GAP),
    )
    scene.friction["box", "floor"] = mu
    h = 1 / 60
    sim = stark.Simulation(scene, time_step=h, contact_distance=_GAP)
    advance(sim, 0.3)
    v0 = float(mean_velocity(box, density) @ axes[:, 0])
    steps = 30
    advance(sim, 0.3 + steps * h)
    v1 = float(mean_velocity(box, density) @ axes[:, 0])
    expected = v0
    for _ in range(steps):  # implicit Euler of dv/dt = g (sin - mu cos) - damping v
        expected = (expected + h * G * (np.sin(angle) - mu * np.cos(angle))) / (1.0 + h * damping)
    # 2 %: also the shear of the box swings.
    assert v1 - v0 == pytest.approx(expected - v0, rel=0.02)


def test_zero_friction_of_a_pair_is_zero() -> None:
    sim, box, axes = box_on_incline(20.0, 0.0, friction=0.9)
    # No tangential force at all: to the accuracy of the solver (acceleration tolerance 0.01 m/s^2).
    assert acceleration_downhill(sim, box, axes) == pytest.approx(G * np.sin(20.0 * stark.deg), abs=0.01)


def test_unlisted_pairs_take_the_geometric_mean() -> None:
    scene = stark.Scene()
    axes = inclined_floor(scene, 20.0)
    floor = scene["floor"]
    boxes = {}
    for name, mu, y in (("slips", 0.05, -0.5), ("slides", 0.2, 0.0), ("sticks", None, 0.5)):
        boxes[name] = scene.add_box(
            0.1, mass=1.0, name=name, rotation=axes, position=axes @ (0, y, 0.05 + 1.9 * _GAP), friction=mu
        )
    scene.default_friction = 0.45  # of the floor and of the third box
    assert scene.friction["slips", floor] == pytest.approx(0.15)
    assert scene.friction["slides", floor] == pytest.approx(0.3)
    assert scene.friction["sticks", floor] == pytest.approx(0.45)
    sim = stark.Simulation(scene, time_step=1 / 60, contact_distance=_GAP)
    advance(sim, 0.3)
    start = {name: box.velocity @ axes[:, 0] for name, box in boxes.items()}
    advance(sim, 0.8)
    sin, cos = np.sin(20.0 * stark.deg), np.cos(20.0 * stark.deg)
    for name, mu in (("slips", 0.15), ("slides", 0.3)):
        a = (boxes[name].velocity @ axes[:, 0] - start[name]) / 0.5
        assert a == pytest.approx(G * (sin - mu * cos), rel=0.01)
    assert boxes["sticks"].velocity @ axes[:, 0] < _STICK


def test_without_friction_none_is_behind() -> None:
    scene = stark.Scene()
    scene.add_floor(1.0)
    box = scene.add_box(0.1, mass=1.0, position=(0.0, 0.0, 0.0505), velocity=(1.0, 0.0, 0.0))
    sim = stark.Simulation(scene, {"contact.friction": False}, time_step=0.01)
    for report in sim.run(until=0.05):
        assert report.friction_residual == 0.0
        assert not report.caveats
    assert box.velocity[0] == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize(
    ("integrator", "step", "distance", "speed"),
    [
        ("bdf2", 1e-3, 1e-3, 0.02),
        ("implicit_euler", 1e-4, 1e-3, 0.02),
        ("bdf2", 2e-3, 1e-3, 0.0),
        ("bdf2", 1e-3, 1e-4, 0.0),
        ("implicit_euler", 1e-3, 1e-3, 0.0),
    ],
)
def test_a_box_that_trembles_walks_down_a_slope(
    integrator: str, step: float, distance: float, speed: float
) -> None:
    """docs/friction.md: where steps resolve how it rocks on the undamped layer of contact."""
    scene = stark.Scene()
    scene.default_friction = 0.4
    slope = np.asarray(stark.rotation(axis="y", angle=20 * stark.deg))
    scene.add_box((2, 2, 0.1), motion="fixed", rotation=slope, position=slope @ [0, 0, -0.05])
    place = slope @ [0, 0, 0.05 + (1.8 if distance == 1e-3 else 1.0) * distance]
    box = scene.add_box(0.1, mass=1.0, rotation=slope, position=place)
    sim = stark.Simulation(scene, time_step=step, contact_distance=distance, time={"integrator": integrator})
    sim.run_until(1.0)
    start, forces = box.position, []
    for _ in sim.run(until=1.5):
        forces.append(box.contact_force @ slope[:, 2])
    assert (box.position - start) @ slope[:, 0] / 0.5 == pytest.approx(speed, abs=1e-3)
    mean = G * np.cos(20 * stark.deg)
    assert np.mean(forces) == pytest.approx(mean, rel=0.02)
    assert (min(forces) < 0.4 * mean and max(forces) > 2.0 * mean) == (speed > 0.0)


@pytest.mark.parametrize(("width", "most"), [(0.1, 0.02), (0.099, 2e-4)])
def test_a_box_pulled_out_of_a_stack(width: float, most: float) -> None:
    """The third of five boxes, which carries two, rubs on both faces, as docs/friction.md says."""
    mu, step = 0.3, 5e-3
    scene = stark.Scene()
    scene.default_friction = mu
    scene.add_floor(1.0)
    heights = 0.0502 + 0.1003 * np.arange(5)
    boxes = [
        scene.add_box((0.1, width if k == 2 else 0.1, 0.1), mass=1.0, position=(0, 0, z))
        for k, z in enumerate(heights)
    ]
    for k in (0, 1, 3, 4):
        scene.add_slider(None, boxes[k], anchor=boxes[k].position, axis="z")
    friction = mu * 5.0 * G  # of two boxes above it and three below
    pull = 1.04 * friction
    string = scene.add_span(None, boxes[2], (1.0, 0.0, heights[2]), boxes[2].position)
    string.add_effort(lambda t: -pull * min(1.0, max(0.0, t - 0.3) / 0.3))
    sim = stark.Simulation(scene, time_step=step, contact_distance=5e-4)
    sim.run_until(0.7)
    before = boxes[2].velocity[0]
    sim.run_until(0.8)
    measured = pull - 1.0 * (boxes[2].velocity[0] - before) / 0.1
    assert -2e-4 < measured / friction - 1.0 < most
