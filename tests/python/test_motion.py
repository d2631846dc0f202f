"""Motions through knots, and bodies and pins that follow them."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import stark
from stark import motion

TIMES = np.array([0.0, 0.3, 0.5, 1.1])
VALUES = np.array([[0.0, 0.0, 0.0], [0.1, -0.2, 0.3], [0.2, 0.1, 0.0], [0.0, 0.4, 0.1]])


def derivatives(m: motion.Motion, time: float, side: float) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivative from one side, of cubics exactly up to rounding."""
    h = side * 1e-3
    x = [m(time + k * h) for k in range(4)]
    first = (-11.0 * x[0] + 18.0 * x[1] - 9.0 * x[2] + 2.0 * x[3]) / (6.0 * h)
    second = (2.0 * x[0] - 5.0 * x[1] + 4.0 * x[2] - x[3]) / h**2
    return first, second


@pytest.mark.parametrize("make", [motion.linear, motion.spline])
def test_knots_are_met_exactly_and_the_ends_are_held(make: Callable[..., motion.Motion]) -> None:
    m = make(TIMES, VALUES)
    for time, value in zip(TIMES, VALUES, strict=True):
        np.testing.assert_array_equal(m(time), value)
    np.testing.assert_array_equal(m(-1.0), VALUES[0])
    np.testing.assert_array_equal(m(7.0), VALUES[-1])
    assert m.duration == 1.1 and "4 knots" in repr(m)


@pytest.mark.parametrize("rest", [True, False])
def test_splines_have_continuous_velocity_and_acceleration(rest: bool) -> None:
    m = motion.spline(TIMES, VALUES, rest=rest)
    for time in TIMES[1:-1]:
        before, after = derivatives(m, time, -1.0), derivatives(m, time, 1.0)
        np.testing.assert_allclose(before[0], after[0], atol=1e-10)
        np.testing.assert_allclose(before[1], after[1], atol=1e-7)
    start, end = derivatives(m, TIMES[0], 1.0), derivatives(m, TIMES[-1], -1.0)
    which = 0 if rest else 1
    np.testing.assert_allclose(np.array([start[which], end[which]]), 0.0, atol=1e-7)
    assert np.abs(start[1 - which]).max() > 0.1


def test_a_spline_at_rest_at_both_ends_between_two_knots() -> None:
    m = motion.spline([1.0, 3.0], [0.0, 4.0])
    for s in (0.0, 0.25, 0.5, 0.8, 1.0):
        np.testing.assert_allclose(m(1.0 + 2.0 * s), 4.0 * s * s * (3.0 - 2.0 * s), atol=1e-15)


def test_linear_is_straight() -> None:
    m = motion.linear(TIMES, VALUES)
    np.testing.assert_allclose(m(0.4), 0.5 * (VALUES[1] + VALUES[2]), atol=1e-15)


def test_rotations_turn_at_constant_rate_or_smoothly() -> None:
    knots = [stark.rotation(axis="z", angle=a) for a in (0.0, 1.0, 3.5, 5.0)]
    straight = motion.rotations(TIMES, knots, smooth=False)
    np.testing.assert_allclose(straight(0.4), stark.rotation(axis="z", angle=2.25), atol=1e-12)
    smooth = motion.rotations(TIMES, [stark.to_quaternion(k) for k in knots])
    for time, knot in zip(TIMES, knots, strict=True):
        np.testing.assert_allclose(smooth(time), knot, atol=1e-12)
        np.testing.assert_allclose(straight(time), knot, atol=1e-12)
    for time in np.linspace(0.0, 1.1, 23):
        np.testing.assert_allclose(smooth(time).T @ smooth(time), np.eye(3), atol=1e-12)
    for time in TIMES[1:-1]:
        before, after = derivatives(smooth, time, -1.0), derivatives(smooth, time, 1.0)
        # One-sided differences of a function that is not a cubic: off by h^3 and h^2.
        np.testing.assert_allclose(before[0], after[0], atol=1e-4)
        np.testing.assert_allclose(before[1], after[1], atol=0.05)
    np.testing.assert_allclose(derivatives(smooth, 0.0, 1.0)[0], 0.0, atol=1e-4)


def scripted() -> tuple[stark.Scene, stark.RigidBody]:
    scene = stark.Scene()
    return scene, scene.add_box(0.1, motion="scripted", name="finger")


def test_bodies_are_where_the_motion_is_at_the_end_of_steps_of_any_length() -> None:
    scene, box = scripted()
    path = motion.spline(TIMES, VALUES)
    turn = motion.rotations([0.0, 1.1], [np.eye(3), stark.rotation(axis="x", angle=2.0)])
    box.follow(position=path, rotation=turn)
    sim = stark.Simulation(scene, time_step=0.03)
    for limit in (None, 0.011, None, 0.002, 0.03, None, 0.5):
        assert not sim.step(max_time_step=limit).failed
        np.testing.assert_allclose(box.position, path(sim.time), atol=1e-15)
        np.testing.assert_allclose(box.rotation, turn(sim.time), atol=1e-12)
    for _ in sim.run(until=1.5):
        pass
    np.testing.assert_allclose(box.position, VALUES[-1], atol=1e-15)
    assert np.abs(box.velocity).max() == 0.0


def test_rewinding_and_stopping() -> None:
    scene, box = scripted()
    box.follow(position=lambda t: (np.sin(t), 0.0, 0.0))
    sim = stark.Simulation(scene, time_step=0.05)
    sim.step()
    state = sim.state
    sim.step()
    end = sim.state
    sim.state = state
    sim.step()
    assert sim.state == end
    box.follow()
    sim.step()
    np.testing.assert_array_equal(box.position, [np.sin(0.1), 0.0, 0.0])
    assert np.abs(box.velocity).max() == 0.0


def test_halved_steps_arrive_as_well() -> None:
    """Where the solver halves a step, the next one ends on the motion again."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=4), stark.materials.cotton, pins=[0, 4])
    path = motion.spline([0.0, 0.2], [(0.0, 0.0, 0.0), (0.0, 0.05, 0.1)])
    cloth.follow(displacement=path)
    start = cloth.positions[[0, 4]]
    sim = stark.Simulation(scene, time_step=0.02, **{"newton.max_iterations": 3, "time.min_step": 1e-5})
    halved = 0
    while sim.time < 0.199:
        report = sim.step()
        assert not report.failed
        halved += report.rejected_steps
        if report.rejected_steps == 0:
            np.testing.assert_allclose(cloth.positions[[0, 4]], start + path(sim.time), atol=1e-14)
    assert halved > 0


def test_pins_move_together_or_each_on_its_own() -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=4), stark.materials.cotton, pins=[0, 4, 20, 24])
    start = cloth.positions
    turn = motion.rotations([0.0, 0.1], [np.eye(3), stark.rotation(axis="y", angle=1.0)])
    cloth.follow(rotation=turn, center=(0.1, -0.1, 0.0), vertices=[4, 0])
    lifted = start[[20, 24]] + np.array([0.0, 0.0, 0.02])
    cloth.follow(motion.linear([0.0, 0.1], [start[[20, 24]], lifted]), vertices=[20, 24])
    sim = stark.Simulation(scene, time_step=0.01)
    for _ in sim.run(until=0.1):
        pass
    center = np.array([0.1, -0.1, 0.0])
    expected = center + (start[[0, 4]] - center) @ stark.rotation(axis="y", angle=1.0).T
    np.testing.assert_allclose(cloth.positions[[0, 4]], expected, atol=1e-14)
    np.testing.assert_allclose(cloth.positions[[20, 24]], lifted, atol=1e-14)


def test_clamped_ends_of_rods_turn_along() -> None:
    scene = stark.Scene()
    rod = scene.add_rod(
        stark.mesh.polyline((0.0, 0.0, 0.0), (0.3, 0.0, 0.0), segments=6),
        stark.RodMaterial(radius=2e-3, youngs_modulus=1e7),
    )
    rod.clamp([0])
    frame = rod.frames[0]
    turn = motion.rotations([0.0, 0.1], [np.eye(3), stark.rotation(axis="x", angle=0.5)])
    rod.follow(rotation=turn, displacement=motion.linear([0.0, 0.1], [(0, 0, 0), (0, 0, 0.01)]))
    sim = stark.Simulation(scene, time_step=0.01)
    for _ in sim.run(until=0.1):
        pass
    np.testing.assert_allclose(rod.frames[0], turn(0.1) @ frame, atol=1e-12)
    np.testing.assert_allclose(rod.positions[0], [0.0, 0.0, 0.01], atol=1e-15)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: motion.spline([0.0], [1.0]), "with n >= 2"),
        (lambda: motion.linear([0.0, 1.0], [1.0]), "times of shape \\(2,\\) and values of shape \\(1,\\)"),
        (lambda: motion.linear([0.0, 0.0], [1.0, 2.0]), "times\\[0\\] = 0 s, times\\[1\\] = 0 s: must rise"),
        (lambda: motion.spline([0.0, np.nan], [1.0, 2.0]), "must be finite"),
        (lambda: motion.spline("ab", [1.0, 2.0]), "must be numbers"),
        (
            lambda: motion.rotations([0, 1], [np.eye(3), stark.rotation(axis="x", angle=np.pi)]),
            "values 0 and 1 are half a turn apart",
        ),
        (lambda: motion.rotations([0, 1], 3.0), "values = 3.0: must be matrices or quaternions"),
        (lambda: motion.function(3.0), "must be a function of the time"),  # type: ignore[arg-type]
    ],
)
def test_knots_that_are_none(make: Callable[[], object], message: str) -> None:
    with pytest.raises(stark.InvalidArgument, match=message):
        make()


def test_followers_that_cannot() -> None:
    scene, box = scripted()
    free = scene.add_box(0.1, mass=1.0, position=(1, 0, 0), name="free")
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=2), name="sheet", position=(0, 0, 1))
    pinned = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=2), name="flag", position=(0, 0, 2), pins=[0, 2])
    for call, message in [
        (lambda: free.follow(position=lambda t: (t, 0, 0)), "'free' is dynamic: it cannot follow"),
        (lambda: box.follow(position=(1, 0, 0)), "'finger': position = \\(1, 0, 0\\): must be a motion"),
        (lambda: box.follow(position=lambda t: t), "'finger': position at 0 s"),
        (lambda: box.follow(rotation=lambda t: 2.0 * np.eye(3)), "'finger': rotation at 0 s"),
        (lambda: cloth.follow(displacement=lambda t: (0, 0, t)), "'sheet' has no pinned vertices"),
        (lambda: pinned.follow(lambda t: np.zeros((3, 3))), "have the shape \\(3, 3\\): must be \\(2, 3\\)"),
        (
            lambda: pinned.follow(displacement=lambda t: (0, 0, t), vertices=[1]),
            "vertex 1 is not pinned",
        ),
        (
            lambda: pinned.follow(lambda t: np.zeros((2, 3)), displacement=lambda t: (0, 0, t)),
            "targets and displacement or rotation are given",
        ),
        (lambda: pinned.follow(vertices=[0]), "vertices is given without a motion: .* of all pins, leave it"),
        (lambda: pinned.follow(center=(0, 0, 0)), "center is given without a motion: must come with"),
        (
            lambda: pinned.follow(displacement=(0, 0, 1), center=(0, 0, 0)),
            "center is given without a rotation",
        ),
        (
            lambda: pinned.follow(lambda t: np.zeros((1, 3)), center=(0, 0, 0)),
            "center is given without a rotat",
        ),
        (
            lambda: box.follow(displacement=lambda t: (t, 0, 0)),  # type: ignore[arg-type]
            "'finger': follow: displacement is of pins, .* must be position= of a rigid body in the world",
        ),
        (
            lambda: pinned.follow(position=lambda t: (t, 0, 0)),  # type: ignore[arg-type]
            "'flag': follow: position is of rigid bodies: must be targets, .* or displacement=",
        ),
        (
            lambda: box.follow(position=lambda: (0, 0, 0)),
            "'finger': follow: must be a motion, or .*at 0 s it",
        ),
        (
            lambda: pinned.follow(rotation=lambda: 0),
            "'flag': follow: must be a motion, or .*at 0 s it raises",
        ),
        *(
            (
                lambda vertices=vertices: pinned.follow(displacement=lambda t: (0, 0, t), vertices=vertices),
                r"'flag': follow: vertices = .*: must be indices of pinned vertices, or a mask of",
            )
            for vertices in ([True, False], [[0]], {"a": 1}, "a")
        ),
    ]:
        with pytest.raises(stark.InvalidArgument, match=message):
            call()
    box.follow(position=lambda t: (np.inf if t > 0.01 else 0.0, 0.0, 0.0))
    sim = stark.Simulation(scene, time_step=0.02)
    with pytest.raises(stark.InvalidArgument, match=r"'finger': position at 0\.02 s.*must be finite"):
        sim.step()


def test_pins_that_follow_may_be_a_mask() -> None:
    """True and False were taken for the vertices 1 and 0."""
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=2), pins=[0, 1, 2])
    start = sheet.mesh.vertices[:3]
    mask = np.zeros(9, bool)
    mask[2] = True
    sheet.follow(displacement=lambda t: (0.0, 0.0, t), vertices=mask)
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.02)
    np.testing.assert_allclose(sheet.positions[:3] - start, [[0, 0, 0], [0, 0, 0], [0, 0, 0.02]], atol=1e-12)
    with pytest.raises(stark.InvalidArgument, match="vertex 8 is not pinned"):
        sheet.follow(displacement=lambda t: (0, 0, t), vertices=np.arange(9) == 8)


def test_a_motion_that_starts_elsewhere_warns_before_the_first_step() -> None:
    scene = stark.Scene()
    far = scene.add_box(0.1, name="far", motion="scripted", position=(0.0, 0.0, 1.0))
    far.follow(position=lambda t: (0.0, 0.0, 0.1 * t))  # meant as a displacement
    turned = scene.add_box(
        0.1,
        name="turned",
        motion="scripted",
        position=(1.0, 0.0, 0.0),
        rotation=stark.rotation(axis="z", angle=0.5),
    )
    turned.follow(rotation=lambda t: stark.rotation(axis="z", angle=t))
    sheet = scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), name="sheet", position=(3.0, 0.0, 0.0), pins=[0, 2])
    sheet.follow(motion.linear([0.0, 1.0], [[(0.0, 0.0, 0.0)], [(0.0, 0.0, 1.0)]]), vertices=[2])
    rod = scene.add_rod(
        stark.mesh.polyline((0.0, 8.0, 0.0), (0.3, 8.0, 0.0), segments=3),
        stark.RodMaterial(radius=2e-3, youngs_modulus=1e7),
        name="wire",
        clamps=[0],
    )
    rod.follow(rotation=lambda t: stark.rotation(axis="x", angle=0.4 + t))  # meant as its turn in the world
    same = scene.add_box(0.1, name="same", motion="scripted", position=(0.0, 5.0, 0.0))
    same.follow(position=lambda t: (0.0, 5.0, t), rotation=lambda t: stark.rotation(axis="z", angle=t))
    sim = stark.Simulation(scene)
    with pytest.warns(stark.StarkWarning) as seen:
        sim.step()
    texts = sorted(str(warning.message) for warning in seen)
    assert len(texts) == 4
    assert texts[0].startswith("'far': at 0 s its motion is 1 m from it, and the first step takes it there")
    assert texts[1].startswith("'sheet': at 0 s its motion is 3.05 m from it")
    assert texts[2].startswith("'turned': at 0 s its motion is turned by 0.5 rad from it")
    assert texts[3].startswith("'wire': at 0 s its motion has turned its pins by 0.4 rad")
    assert not sim.step().failed


def test_what_was_exported_as_usd_moves_another_scene(tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    scene = stark.Scene()
    flag = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 4), name="flag", pins=[0, 4])
    scene.add_box(0.1, mass=1.0, position=(1, 0, 0), name="box")
    sim = stark.Simulation(scene, time_step=0.01)
    with stark.exports.Exporter(tmp_path / "fall.usdc", sim) as export:
        export.record(sim)
        for _ in sim.run(until=0.05):
            export.record(sim)
    skin, fall = motion.usd_mesh(tmp_path / "fall.usdc", "/World/flag")
    stage = stark.Scene()
    actor = stage.add_cloth(skin, pins=range(len(skin.vertices)))
    actor.follow(fall)
    played = stark.Simulation(stage, time_step=0.05)
    played.step()
    assert fall.duration == pytest.approx(0.05)
    assert actor.positions == pytest.approx(flag.positions, abs=1e-7)  # single precision
    both, smooth = motion.usd_mesh(tmp_path / "fall.usdc", smooth=True)
    assert len(both.vertices) == len(skin.vertices) + 8 and "spline" in repr(smooth)
    with pytest.raises(stark.InvalidArgument, match="prim = 3: must be the path"):
        motion.usd_mesh(tmp_path / "fall.usdc", 3)  # type: ignore[arg-type]


def rising(time: float) -> list[float]:
    return [0.0, 0.0, time]


@pytest.mark.parametrize(
    "given",
    [
        motion.linear(TIMES, VALUES),
        motion.spline(TIMES, VALUES, rest=False),
        motion.rotations([0, 1, 2], [stark.rotation(axis="z", angle=a) for a in (0.0, 1.0, 2.5)]),
        motion.rotations([0, 1], [stark.rotation(axis="x", angle=a) for a in (0.0, 1.0)], smooth=False),
        motion.function(rising),
    ],
)
def test_motions_may_be_pickled_and_copied(given: motion.Motion) -> None:
    for same in (pickle.loads(pickle.dumps(given)), copy.deepcopy(given)):
        assert repr(same) == repr(given) and same.duration == given.duration
        assert all(np.array_equal(same(t), given(t)) for t in (0.0, 0.21, 0.7, 3.0))


def test_a_function_that_forgets_to_return_is_named() -> None:
    """None became NaN, and the message spoke of a shape."""
    scene = stark.Scene()
    box = scene.add_box(0.1, motion="scripted")
    with pytest.raises(stark.InvalidArgument, match=r"at 0 s = None: must be of real numbers"):
        box.follow(position=lambda t: None)  # type: ignore[arg-type,return-value]
    axle = scene.add_hinge(None, scene.add_box(0.1, mass=1.0, position=(1, 0, 0)), anchor=(1, 0, 0), axis="z")
    with pytest.raises(stark.InvalidArgument, match=r"at 0 s = None: must be of real numbers"):
        axle.add_effort(lambda t: None)  # type: ignore[arg-type,return-value]


def test_following_no_pin_is_refused() -> None:
    """It moved nothing, with a warning of NumPy about an empty mean."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), pins=[0, 2])
    for nothing in ([], np.zeros(9, dtype=bool), np.zeros(0, dtype=int)):
        with pytest.raises(
            stark.InvalidArgument, match=r"'cloth': follow: vertices = .*: must be at least one"
        ):
            cloth.follow(displacement=lambda t: (0.0, 0.0, t), vertices=nothing)


def test_steps_are_shorter_where_a_body_follows_a_fast_rotation(tmp_path: Path) -> None:
    """As they are where it has a velocity: a disc on a turntable, which turns by 2.5 rad in a step, had a
    sixth of its speed, as friction saw the chord; one that turned by 5 rad turned backwards."""

    def turntable(rate: float) -> tuple[stark.Simulation, stark.RigidBody, stark.RigidBody]:
        scene = stark.Scene()
        scene.default_friction = 0.5
        table = scene.add_cylinder(0.3, 0.02, motion="scripted", position=(0, 0, -0.01))
        table.follow(rotation=lambda t: stark.rotation(axis="z", angle=rate * t))
        disc = scene.add_cylinder(0.05, 0.05, mass=0.1, position=(0, 0, 0.0269), name="disc")
        return stark.Simulation(scene, time_step=0.05, contact_distance=1e-3), table, disc

    sim, table, disc = turntable(50.0)
    sim.run_until(0.3)
    assert table.angular_velocity[2] == pytest.approx(50.0) and sim.step().time_step < 0.05 * np.pi / 20.0
    assert disc.angular_velocity[2] == pytest.approx(130.8 * sim.time, rel=0.1)  # 4 mu g t / 3 r
    sim.save(tmp_path / "half.stark")
    sim.run_until(0.5)
    assert disc.angular_velocity[2] == pytest.approx(50.0, rel=1e-4)
    other, *_ = turntable(50.0)
    other.load(tmp_path / "half.stark")
    other.run_until(0.5)
    assert other.state == sim.state
    sim, table, _ = turntable(100.0)
    sim.run_until(0.1)
    assert sim.time == 0.1 and table.angular_velocity[2] == pytest.approx(100.0)


def test_a_rotation_that_jumps_or_turns_slowly_shortens_no_step() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, motion="scripted")
    scene.add_box(0.1, mass=1.0, position=(1, 0, 0))
    quarter = stark.rotation(axis="z", angle=0.5 * np.pi)
    box.follow(rotation=lambda t: quarter if t >= 0.05 else np.eye(3))
    sim = stark.Simulation(scene, time_step=0.01)
    assert [step.time_step for step in sim.run(until=0.1)] == pytest.approx([0.01] * 10)
    box.follow(rotation=lambda t: stark.rotation(axis="x", angle=39.0 * t) @ quarter)
    assert sim.step().time_step == 0.01


def test_steps_are_shorter_where_pins_follow_a_fast_rotation() -> None:
    """A clamp that turned by 3.5 rad in a step twisted its rod the other way."""
    twist, length, material = 14.0, 0.3, stark.RodMaterial(youngs_modulus=1e6, radius=0.003)
    for integrator, most in (("implicit_euler", np.pi / 8.0), ("quasistatic", 0.75 * np.pi)):
        scene = stark.Scene()
        rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (length, 0, 0), 30), material, clamps=[0, 30])
        rod.follow(rotation=lambda t: stark.rotation(axis="x", angle=twist * t / 0.2), vertices=[30])
        sim = stark.Simulation(scene, time_step=0.05, time={"integrator": integrator}, gravity=(0, 0, 0))
        steps = [step.time_step for step in sim.run(until=0.2)]
        assert sim.time == 0.2 and 0.5 * most < max(steps) * twist / 0.2 <= 1.0001 * most
        stiffness = 1e6 / 2.6 * np.pi / 2.0 * 0.003**4 / length  # G J / L
        assert rod.clamp_torques[1][0] == pytest.approx(stiffness * twist, rel=0.05)
