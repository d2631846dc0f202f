"""Frames of rigid bodies, patches and the world: axes, rotations, momentum, what is left out."""

from __future__ import annotations

import numpy as np
import pytest
from _scenes import NO_GRAVITY, sheet, sheet_and_box

import stark
from stark import InvalidArgument

H = 0.01


@stark.energy
def weld(a: stark.Frame, b: stark.Frame, k: float = 10.0, kr: float = 0.01):
    """Holds two frames together."""
    d = a.origin - b.origin
    return 0.5 * k * (d @ d) + 0.5 * kr * stark.squared_norm(a.axes - b.axes)


@stark.energy
def ball(a: stark.Frame, b: stark.Frame, k: float = 10.0):
    d = a.origin - b.origin
    return 0.5 * k * (d @ d)


def test_axes_that_do_not_occur_are_left_out() -> None:
    scene, _, box = sheet_and_box()
    free = ball(box.frame((0.0, 0.0, 0.04)), stark.world_frame((0.0, 0.0, -0.2)))
    assert free.trace.labels == ("a.origin", "b.origin")
    assert len(weld(box, stark.world_frame()).columns) == 8
    scene.add(free)


def test_a_frame_moves_with_its_rigid_body() -> None:
    @stark.energy
    def probe(f: stark.Frame, gain: stark.Vec3):
        return gain[0] * f.origin[0] + gain[1] * f.y[2] + gain[2] * f.point((0.1, 0.2, 0.3))[1]

    scene = stark.Scene()
    turn = stark.rotation(axis=(1.0, 2.0, 0.5), angle=0.7)
    box = scene.add_box(size=0.1, position=(0.1, 0.2, 0.3), rotation=turn, motion="scripted")
    scene.add_box(size=0.1, position=(3.0, 0.0, 0.0), mass=1.0)
    local = stark.rotation(axis="z", angle=0.3)
    frame = box.frame((0.01, 0.02, 0.03), rotation=local)
    probes = [scene.add(probe(frame, gain=g)) for g in np.eye(3)]
    sim = stark.Simulation(scene, time_step=H, **NO_GRAVITY)
    box.angular_velocity = (0.0, 3.0, 1.0)
    sim.step()
    axes = box.rotation @ local
    origin = box.position + box.rotation @ [0.01, 0.02, 0.03]
    expected = origin[0], axes[2, 1], (origin + axes @ [0.1, 0.2, 0.3])[1]
    np.testing.assert_allclose([p.energy for p in probes], expected, rtol=1e-13)


def test_angular_velocity_of_a_frame() -> None:
    @stark.energy
    def component(f: stark.Frame, axis: stark.Vec3):
        return f.angular_velocity @ axis

    scene = stark.Scene()
    box = scene.add_box(size=0.1, motion="scripted")
    scene.add_box(size=0.1, position=(3.0, 0.0, 0.0), mass=1.0)
    parts = [scene.add(component(box, axis=axis)) for axis in np.eye(3)]
    sim = stark.Simulation(scene, time_step=H, **NO_GRAVITY)
    omega = np.array([1.0, -2.0, 0.5])
    box.angular_velocity = omega
    sim.step()
    # The sine of the angle of a step, 0.023: off by its third power.
    angle = np.linalg.norm(omega) * H
    np.testing.assert_allclose([p.energy for p in parts], omega * np.sin(angle) / angle, rtol=1e-10)


@pytest.mark.parametrize("position", [None, (0.05, 0.02, 0.01)])
def test_a_patch_frame_starts_where_it_was_placed(position: object) -> None:
    @stark.energy
    def entry(f: stark.Frame, gain: stark.Vec3, axis: stark.Vec3):
        return gain @ f.origin + axis @ (f.axes @ stark.vec(1.0, 2.0, 3.0))

    _, cloth = sheet(4, rotation=stark.rotation(axis="x", angle=0.4))
    corners = cloth.triangles[9]
    turn = stark.rotation(axis=(0.3, 1.0, -0.2), angle=1.1)
    frame = cloth.frame(corners, position=position, rotation=turn)
    origin = cloth.positions[corners].mean(axis=0) if position is None else np.array(position)
    for gain, axis, expected in zip(
        [*np.eye(3), *np.zeros((3, 3))],
        [*np.zeros((3, 3)), *np.eye(3)],
        [*origin, *(turn @ [1.0, 2.0, 3.0])],
        strict=True,
    ):
        binding = entry(frame, gain=gain, axis=axis)
        assert _start_energy(binding) == pytest.approx(expected, abs=1e-14)


def _start_energy(binding: object) -> float:
    from stark.formulas.inspection import sample_inputs, stacked

    rows = np.arange(1)
    x = stacked(binding, "positions", rows)
    return float(binding.trace.formula.sample(sample_inputs(binding, x, x, rows)).evaluate(0)[0])


def test_a_weld_of_a_box_to_a_patch_of_cloth_keeps_them_together() -> None:
    scene, cloth, box = sheet_and_box(4)
    corners = cloth.triangles[9]
    place = box.position + np.array([0.0, 0.0, 0.04])
    glue = weld(box.frame((0.0, 0.0, 0.04)), cloth.frame(corners, position=place, rotation=np.eye(3)), k=1e4)
    report = glue.check()
    assert report.ok, report
    assert report["translation"].status == "ok"  # origins move alike, axes do not move
    assert report["rotation"].status == "ok"
    e = scene.add(glue)
    sim = stark.Simulation(scene, time_step=H, **NO_GRAVITY)
    sim.run_until(0.1)
    assert e.energy < 1e-4  # nothing pulls on it
    free = scene.add_box(size=0.05, position=(1.0, 0.0, 0.0), mass=0.1)
    assert weld(free, stark.world_frame()).check().ok


def test_a_torsion_spring_turns_a_box_as_a_pendulum() -> None:
    # The energy k (1 - cos(angle)) about z has the implicit step J w / h = -k sin(angle).
    @stark.energy
    def torsion(a: stark.Frame, b: stark.Frame, k: float):
        return -k * (a.x @ b.x)

    scene = stark.Scene()
    angle = 0.3
    box = scene.add_box(size=0.1, mass=0.6, rotation=stark.rotation(axis="z", angle=angle))
    e = scene.add(torsion(box, stark.world_frame(), k=0.02))
    sim = stark.Simulation(scene, time_step=H, **NO_GRAVITY)
    sim.step()
    turned = np.arctan2(box.rotation[1, 0], box.rotation[0, 0])
    inertia = 0.6 * 0.1**2 / 6.0
    # First order in the angle of the step, 2e-3: the discrete inertia of a rotation is sin-like.
    assert (turned - angle) / H**2 == pytest.approx(-0.02 * np.sin(turned) / inertia, rel=1e-4)
    assert e.energy == pytest.approx(-0.02 * np.cos(turned), rel=1e-12)


def test_refused_frames() -> None:
    scene, cloth, box = sheet_and_box()
    cases = [
        (lambda: weld(box, cloth), "argument 'b' = .* must be a frame, such as box.frame"),
        (lambda: cloth.frame([0, 1]), "must be three different vertex indices"),
        (lambda: cloth.frame([0, 1, 1]), "must be three different vertex indices"),
        (lambda: cloth.frame([0, 1, 2]), "are on one line"),
        (lambda: cloth.frame([0, 1, 99]), r"vertex 99: must be in \[0, 25\)"),
        (lambda: box.frame((0.0, 0.0)), "must be three numbers"),
        (lambda: box.frame(rotation=2.0 * np.eye(3)), "must be a rotation"),
    ]
    for refused, words in cases:
        with pytest.raises(InvalidArgument, match=words):
            refused()
    assert len(scene.energies) == 0


@pytest.mark.parametrize(("angle", "tolerance"), [(0.023, 1e-13), (0.6, 1e-9), (1.0, 1e-6)])
def test_the_turn_of_a_frame_is_the_rotation_vector_of_the_step(angle: float, tolerance: float) -> None:
    @stark.energy
    def component(f: stark.Frame, axis: stark.Vec3):
        return f.turn @ axis

    scene = stark.Scene()
    axis = np.array([2.0, -2.0, 1.0]) / 3.0
    start = stark.rotation(axis=(1.0, 2.0, 0.5), angle=0.7)
    box = scene.add_box(size=0.1, mass=1e6, rotation=start, angular_velocity=angle / H * axis)
    parts = [scene.add(component(box, axis=axis)) for axis in np.eye(3)]
    sim = stark.Simulation(scene, time_step=H, **NO_GRAVITY)
    assert not sim.step().failed
    turn = box.rotation @ start.T  # (I + turn)^-1 (turn - I) has tan(angle / 2) about the axis
    cayley = np.linalg.solve(np.eye(3) + turn, turn - np.eye(3))
    tangent = np.array([cayley[2, 1], cayley[0, 2], cayley[1, 0]])
    size = np.linalg.norm(tangent)
    assert 2.0 * np.arctan(size) == pytest.approx(angle, rel=0.2)
    expected = 2.0 * np.arctan(size) / size * tangent
    np.testing.assert_allclose([p.energy for p in parts], expected, rtol=tolerance)
