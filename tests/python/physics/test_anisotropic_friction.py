"""Friction that depends on the direction: slides deviate, limits form an ellipse, directions go with bodies.

The law is written down here a second time: sliding with velocity v under the normal force N meets the force
-N M^2 v / |M v| with M = diag(along, across) in the axes of the direction."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _helpers import G, advance, inclined_floor

import stark

STEP, GAP = 1 / 60, 1e-3  # defaults of time.step [s] and contact.distance [m]
ALONG, ACROSS = 0.15, 0.45
SIZE, MASS = (0.1, 0.1, 0.04), 1.0  # [m], [kg]
START = (0.0, 1.0, SIZE[2] / 2 + 1.9 * GAP)  # beside the diagonal of the floor


def turned(angle: float) -> np.ndarray:
    """Rotation in the plane by an angle [deg]."""
    c, s = np.cos(angle * stark.deg), np.sin(angle * stark.deg)
    return np.array([[c, -s], [s, c]])


def slide(velocity: np.ndarray, slope: float, direction: float, time: float) -> np.ndarray:
    """Velocity in the plane (downhill, across) after a time [s] on a slope [deg] with a direction [deg]
    against downhill: the equation of motion in steps of 0.1 ms."""
    axes = turned(direction)
    squares = axes @ np.diag([ALONG**2, ACROSS**2]) @ axes.T
    steps = round(time / 1e-4)
    v = np.array(velocity)
    for _ in range(steps):
        friction = squares @ v / np.sqrt(v @ squares @ v)
        v += 1e-4 * G * (np.array([np.sin(slope * stark.deg), 0.0]) - np.cos(slope * stark.deg) * friction)
    return v


def on_incline(
    slope: float,
    friction: Any,
    *,
    turn: float = 0.0,
    of_floor: Any = None,
    of_box: Any = None,
    cells: int = 1,
    place: tuple[float, float, float] = START,
    **settings: Any,
) -> tuple[stark.Simulation, Any, np.ndarray]:
    """A box, turned about the normal by ``turn`` [deg]; directions in the frames of the bodies."""
    scene = stark.Scene()
    axes = inclined_floor(scene, slope, cells=cells)
    rotation = axes @ stark.rotation(axis="z", angle=turn * stark.deg)
    box = scene.add_box(SIZE, mass=MASS, name="box", rotation=rotation, position=axes @ place)
    scene["floor"].surface_direction = of_floor
    box.surface_direction = of_box
    scene.friction["box", "floor"] = friction
    return stark.Simulation(scene, **settings), box, axes


def in_plane(angle: float) -> np.ndarray:
    return np.append(turned(angle)[:, 0], 0.0)


@pytest.mark.parametrize(("direction", "cells"), [(0, 1), (30, 1), (60, 1), (60, 40), (90, 1), (135, 1)])
@pytest.mark.parametrize("owner", ["floor", "box", "turned box"])
def test_slides_deviate_towards_the_direction(direction: float, cells: int, owner: str) -> None:
    slope = 30.0
    where: dict[str, dict[str, Any]] = {
        "floor": {"of_floor": in_plane(direction)},
        "box": {"of_box": in_plane(direction)},
        "turned box": {"of_box": (1, 0, 0), "turn": direction},
    }
    # Steps that see the bumps at the edges of a fine floor (docs/friction.md).
    step = STEP if cells == 1 else STEP / 4
    friction = stark.Anisotropic(ALONG, ACROSS)
    sim, box, axes = on_incline(slope, friction, cells=cells, time_step=step, **where[owner])
    advance(sim, 0.3)
    start, time = (axes.T @ box.velocity)[:2], sim.time
    advance(sim, 0.8)
    gain = (axes.T @ box.velocity)[:2] - start
    expected = slide(start, slope, direction, sim.time - time) - start
    assert np.linalg.norm(gain - expected) < 0.01 * np.linalg.norm(expected)
    if direction in (30, 60):
        assert gain[1] > 0.1 * gain[0]  # towards the direction, by a lot


def test_bdf2_follows_the_same_path() -> None:
    settings = {"time.integrator": "bdf2"}
    friction = stark.Anisotropic(ALONG, ACROSS)
    sim, box, axes = on_incline(30.0, friction, of_floor=in_plane(40.0), **settings)
    advance(sim, 0.3)
    start, time = (axes.T @ box.velocity)[:2], sim.time
    advance(sim, 0.8)
    expected = slide(start, 30.0, 40.0, sim.time - time)
    # Second order: a tenth of what implicit Euler is allowed.
    assert np.linalg.norm((axes.T @ box.velocity)[:2] - expected) < 0.001 * np.linalg.norm(expected)


@stark.energy
def push(f: stark.Frame, force: stark.Vec3):
    """A force on the origin of a body [N]."""
    return -(force @ f.origin)


@pytest.mark.parametrize("angle", [0.0, 20.0, 55.0, 90.0])
@pytest.mark.parametrize("share", [0.97, 1.03])
def test_limits_of_sticking_form_an_ellipse(angle: float, share: float) -> None:
    scene = stark.Scene()
    scene.add_floor(20.0, name="floor", position=(0.0, 1.3, 0.0))
    box = scene.add_box(SIZE, mass=MASS, name="box", position=START)
    box.surface_direction = in_plane(25.0)
    scene.friction[box, "floor"] = stark.Anisotropic(ALONG, ACROSS, kinetic=0.8)
    hand = scene.add(push(box, force=(0, 0, 0)))
    sim = stark.Simulation(scene)
    advance(sim, 0.4)
    start = box.position
    c, s = np.cos(angle * stark.deg), np.sin(angle * stark.deg)
    limit = MASS * G / np.hypot(c / ALONG, s / ACROSS)
    for part in np.linspace(0.0, share, 60):  # at once, inertia would carry the bristles beyond the limit
        hand.force = part * limit * in_plane(25.0 + angle)
        assert not sim.step().failed
    advance(sim, 2.4)
    moved = np.linalg.norm(box.position - start)
    if share < 1.0:
        settled = box.position
        # At most the deflection of the bristles, in the direction of the smaller coefficient.
        assert moved < 1e-3 * STEP * ACROSS / ALONG + 1e-6
        advance(sim, 7.4)
        assert np.linalg.norm(box.position - settled) < 1e-7
    else:
        # Once it slides, 0.8 of the ellipse is left: far enough away after a second.
        assert moved > 0.1


def test_sliding_has_the_kinetic_part_of_both() -> None:
    for direction, mu in ((0.0, ALONG), (90.0, ACROSS)):
        sim, box, axes = on_incline(
            35.0, stark.Anisotropic(ALONG, ACROSS, kinetic=0.6), of_floor=in_plane(direction)
        )
        advance(sim, 0.3)
        start, time = box.velocity @ axes[:, 0], sim.time
        advance(sim, 0.6)
        gain = (box.velocity @ axes[:, 0] - start) / (sim.time - time)
        a = 35.0 * stark.deg
        assert gain == pytest.approx(G * (np.sin(a) - 0.6 * mu * np.cos(a)), rel=0.01)


def test_a_skate_runs_along_and_holds_across() -> None:
    """No friction along: a slope of 20 degrees in both ways moves it along its blade alone."""
    sim, box, axes = on_incline(
        20.0, stark.Anisotropic(0.0, 0.5), of_box=in_plane(40.0), place=(0.0, -1.0, START[2])
    )
    advance(sim, 0.3)
    start, time = axes.T @ box.velocity, sim.time
    advance(sim, 0.8)
    gain = (axes.T @ box.velocity - start) / (sim.time - time)
    blade = in_plane(40.0)
    along = G * np.sin(20.0 * stark.deg) * np.cos(40.0 * stark.deg)
    assert gain @ blade == pytest.approx(along, rel=0.01)
    assert np.linalg.norm(gain - blade * (gain @ blade)) < 0.01 * along


def test_rotated_scenes_move_alike() -> None:
    def track(rotation: np.ndarray) -> np.ndarray:
        scene = stark.Scene()
        grid = stark.mesh.grid(3.0, 3.0, 1)
        floor = scene.add_rigid(grid, motion="fixed", name="floor", rotation=rotation)
        floor.surface_direction = in_plane(50.0)
        sheet = stark.mesh.grid(0.3, 0.3, 6)
        cloth = scene.add_cloth(
            sheet,
            stark.ShellMaterial(density=0.3, youngs_modulus=1e5, bending_stiffness=1e-5),
            name="cloth",
            rotation=rotation,
            position=rotation @ (0.0, 1.0, 1.9 * GAP),
        )
        scene.friction["cloth", "floor"] = stark.Anisotropic(ALONG, ACROSS)
        gravity = rotation @ (5.0, 1.0, -8.0)
        sim = stark.Simulation(scene, gravity=gravity, **{"newton.acceleration_tolerance": 1e-8})
        advance(sim, 0.5)
        return cloth.positions @ rotation

    level = track(np.eye(3))
    tilted = track(stark.rotation(axis=(1, 2, 3), angle=1.1))
    assert np.abs(level - track(np.eye(3))).max() == 0.0
    assert np.linalg.norm(level[0] - (-0.15, 0.85, 1.9 * GAP)) > 0.1
    assert np.abs(tilted - level).max() < 1e-6


def test_a_turning_floor_takes_its_direction_along() -> None:
    """A scripted floor turned by 90 degrees in between: what was the weak axis holds afterwards."""
    scene = stark.Scene()
    slope = stark.rotation(axis="y", angle=15.0 * stark.deg)
    disc = scene.add_rigid(stark.mesh.grid(12.0, 12.0, 1), motion="scripted", name="disc", rotation=slope)
    disc.surface_direction = (1, 0, 0)
    box = scene.add_box(SIZE, mass=MASS, name="box", rotation=slope, position=slope @ (0.0, 0.02, START[2]))
    scene.friction[box, disc] = stark.Anisotropic(ALONG, ACROSS)
    sim = stark.Simulation(scene)
    advance(sim, 0.3)
    assert box.velocity @ slope[:, 0] > 0.2
    for k in range(1, 31):
        disc.rotation = slope @ stark.rotation(axis="z", angle=k * 3.0 * stark.deg)
        assert not sim.step().failed
    advance(sim, 3.0)
    assert np.linalg.norm(box.velocity) < 1e-6


def test_equal_coefficients_are_isotropic_bit_for_bit() -> None:
    tracks = []
    for friction in (stark.Anisotropic(0.3, 0.3, kinetic=0.5), (0.3, 0.15)):
        sim, box, _ = on_incline(20.0, friction)
        advance(sim, 0.5)
        tracks.append(box.position)
    assert np.array_equal(*tracks)


def test_the_body_named_first_rules() -> None:
    along_x, along_y = (1, 0, 0), (0, 1, 0)
    for pair, speed in ((("box", "floor"), "fast"), (("floor", "box"), "slow")):
        scene = stark.Scene()
        axes = inclined_floor(scene, 20.0)
        box = scene.add_box(SIZE, mass=MASS, name="box", rotation=axes, position=axes @ START)
        box.surface_direction = along_x
        scene["floor"].surface_direction = along_y
        scene.friction[pair] = stark.Anisotropic(ALONG, ACROSS)
        sim = stark.Simulation(scene)
        advance(sim, 0.8)
        assert (box.velocity @ axes[:, 0] > 0.5) == (speed == "fast")


def test_where_the_surface_is_normal_to_its_direction_the_mean_holds() -> None:
    sim, box, axes = on_incline(30.0, stark.Anisotropic(0.1, 0.4), of_box=(0, 0, 1))
    advance(sim, 0.3)
    start, time = box.velocity @ axes[:, 0], sim.time
    advance(sim, 0.8)
    a = 30.0 * stark.deg
    gain = (box.velocity @ axes[:, 0] - start) / (sim.time - time)
    assert gain == pytest.approx(G * (np.sin(a) - 0.2 * np.cos(a)), rel=0.01)


def test_what_was_set_can_be_read() -> None:
    scene = stark.Scene()
    floor = scene.add_floor(name="floor")
    box = scene.add_box(0.1, mass=1.0, name="box", position=(0, 0, 1))
    assert box.surface_direction is None
    box.surface_direction = 2, 0, 0
    assert list(box.surface_direction) == [2, 0, 0]
    box.surface_direction = np.tile((0.0, 1.0, 0.0), (12, 1))
    assert box.surface_direction.shape == (12, 3)
    box.surface_direction = None
    assert box.surface_direction is None
    scene.friction[box, floor] = stark.Anisotropic(0.5, 0.25, kinetic=0.5)
    assert scene.friction[floor, box] == stark.Anisotropic(0.5, 0.25, 0.5)
    assert scene.friction.kinetic(floor, box) == stark.Anisotropic(0.25, 0.125)
    scene.friction[box, floor] = 0.3
    assert scene.friction[box, floor] == 0.3


def test_nonsense_is_refused() -> None:
    scene = stark.Scene()
    scene.add_floor(name="floor")
    box = scene.add_box(0.1, mass=1.0, name="box", position=(0, 0, 1))
    rod = scene.add_rod([(0, 0, 2), (0.1, 0, 2), (0.2, 0, 2)], name="rod")
    with pytest.raises(stark.InvalidArgument, match="'rod': surface_direction: a rod has no triangles"):
        rod.surface_direction = (1, 0, 0)
    with pytest.raises(stark.InvalidArgument, match="has 5 vectors: must be one, or one for each of the 12"):
        box.surface_direction = np.ones((5, 3))
    with pytest.raises(stark.InvalidArgument, match=r"surface_direction = \(0, 0, 0\): must not be zero"):
        box.surface_direction = (0, 0, 0)
    for nonsense in (1.0, (1, 2), "x"):
        with pytest.raises(stark.InvalidArgument, match="surface_direction"):
            box.surface_direction = nonsense
    for friction, message in (
        (stark.Anisotropic(-0.1, 0.5), "coefficient along the surface direction = -0.1"),
        (stark.Anisotropic(0.1, np.inf), "coefficient across the surface direction"),
        (stark.Anisotropic(0.1, 0.2, kinetic=1.5), "kinetic = 1.5"),
        (stark.Anisotropic("ice", 0.2), "must be a number"),  # type: ignore[arg-type]
    ):
        with pytest.raises(stark.InvalidArgument, match=message):
            scene.friction[box, "floor"] = friction
    scene.friction[box, "floor"] = stark.Anisotropic(0.1, 0.2)
    with pytest.raises(stark.InvalidArgument, match="neither body has a direction: set surface_direction"):
        stark.Simulation(scene)


def test_a_checkpoint_of_another_direction_is_refused(tmp_path: Any) -> None:
    sim, _, _ = on_incline(20.0, stark.Anisotropic(0.1, 0.5), of_floor=(1, 0, 0))
    advance(sim, 0.1)
    sim.save(tmp_path / "state.stark")
    same, box, _ = on_incline(20.0, stark.Anisotropic(0.1, 0.5), of_floor=(1, 0, 0))
    other, _, _ = on_incline(20.0, stark.Anisotropic(0.1, 0.5), of_floor=(0, 1, 0))
    same.load(tmp_path / "state.stark")
    advance(sim, 0.3)
    advance(same, 0.3)
    assert np.array_equal(box.position, sim["box"].position)
    with pytest.raises(stark.Error, match="surface directions"):
        other.load(tmp_path / "state.stark")


def test_the_example_checks_itself(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(Path(__file__).parents[3] / "examples/grooved_ramp.py"))["main"]()
    assert capsys.readouterr().out.endswith("check: passed\n")
