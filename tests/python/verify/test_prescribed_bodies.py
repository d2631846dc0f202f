"""Bodies that turn, follow poses or motions, and pins that are moved: certified like the rest, and tampering
is found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from _recorded_runs import edit_states

import stark
from stark.recording import Recorder
from stark.verify import verify

_TABLE, _RIDER, _FAN, _PUSHER, _FLAG, _TOP = range(6)
_STEPS = 25


def moved() -> tuple[stark.Scene, dict[str, stark.Body]]:
    """A box on a turntable that is given poses, a fan that turns by itself and hits a ball, a pusher on a
    path, a flag whose pins are turned, a free top."""
    scene = stark.Scene("moved")
    table = scene.add_cylinder(0.2, 0.02, segments=24, name="table", motion="scripted")
    scene.add_box(0.04, name="rider", density=500.0, position=(0.12, 0.0, 0.0312))
    scene.add_box(
        (0.3, 0.02, 0.02),
        name="fan",
        motion="scripted",
        position=(1.0, 0.0, 0.0),
        angular_velocity=(0.0, 0.0, 12.0),
    )
    pusher = scene.add_box(0.05, name="pusher", motion="scripted", position=(2.0, 0.0, 0.0))
    pusher.follow(position=stark.motion.spline([0.0, 0.2], [(2.0, 0.0, 0.0), (2.1, 0.05, 0.0)]))
    flag = scene.add_cloth(
        stark.mesh.grid(0.1, 0.1, cells=4),
        stark.materials.cotton,
        name="flag",
        position=(3.0, 0.0, 0.0),
        pins=[0, 4],
    )
    flag.follow(rotation=lambda t: stark.rotation(axis="z", angle=2.0 * t))
    scene.add_box(
        (0.1, 0.06, 0.03),
        name="top",
        density=500.0,
        position=(4.0, 0.0, 0.0),
        angular_velocity=(2.0, 9.0, 20.0),
    )
    scene.add_sphere(0.03, subdivisions=1, name="ball", density=300.0, position=(1.0, 0.14, 0.0))
    return scene, {"table": table}


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("moved") / "run"
    scene, bodies = moved()
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=0.001)
    with Recorder(folder, sim, settings=sim.settings.to_dict(), certify=True) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        for k in range(_STEPS):
            bodies["table"].rotation = stark.rotation(axis="z", angle=0.03 * (k + 1))
            report = sim.step()
            assert not report.failed, report.message
            recorder.report(report)
            recorder.record_state(sim)
    return folder


def test_prescribed_motion_is_certified(good: Path) -> None:
    certificate = verify(good)
    assert certificate.verdict == "certified", certificate.text()
    for name in ("paths", "rigid_shapes", "reported_energies", "reported_momentum", "energy_ledger"):
        assert certificate[name].status == "verified"
    # The fan went round and hit the ball on its way.
    assert certificate["minimum_distance"].worst < 0.002


@pytest.mark.parametrize("body", [_TABLE, _FAN, _PUSHER, _TOP])
def test_bodies_that_do_not_follow_their_poses(run: Path, body: int) -> None:
    def turn(array: np.ndarray, times: np.ndarray) -> None:
        array[10, 1:] = stark.rotation(axis="z", angle=1e-6) @ array[10, 1:]

    edit_states(run, f"poses_{body:04d}", turn)
    claim = verify(run)["rigid_shapes"]
    assert claim.status == "violated"
    assert claim.where is not None
    assert claim.where["time"] == pytest.approx(0.1)


@pytest.mark.parametrize("mirrored", [False, True])
def test_poses_that_are_no_rotations(run: Path, mirrored: bool) -> None:
    """A stretched or mirrored body agrees with its pose, but has another shape."""

    matrix = np.diag([1.0, 1.0, -1.0]) if mirrored else np.diag([1.0, 1.0 + 1e-6, 1.0])
    with np.load(run / "states/chunk_000000.npz") as stored:
        place = stored[f"poses_{_TOP:04d}"][10, 0].copy()

    def poses(array: np.ndarray, times: np.ndarray) -> None:
        array[10, 1:] = matrix @ array[10, 1:]

    def positions(array: np.ndarray, times: np.ndarray) -> None:
        array[10] = place + (array[10] - place) @ matrix.T

    edit_states(run, f"poses_{_TOP:04d}", poses)
    edit_states(run, f"positions_{_TOP:04d}", positions)
    assert verify(run)["rigid_shapes"].status == "violated"


def test_a_blade_that_passes_through_a_ball_in_one_step_is_not_certified(run: Path) -> None:
    """The fan is turned on by a right angle from one state to the next: its arc meets what is in the way."""
    angle, centre = 1.2, np.array([1.0, 0.0, 0.0])

    def turned(array: np.ndarray) -> np.ndarray:
        return array @ stark.rotation(axis="z", angle=angle).T

    def positions(array: np.ndarray, times: np.ndarray) -> None:
        array[3:] = turned(array[3:] - centre) + centre

    def poses(array: np.ndarray, times: np.ndarray) -> None:
        array[3:, 1:] = stark.rotation(axis="z", angle=angle) @ array[3:, 1:]

    edit_states(run, f"positions_{_FAN:04d}", positions)
    edit_states(run, f"poses_{_FAN:04d}", poses)
    certificate = verify(run)
    assert certificate["rigid_shapes"].status == "verified"
    assert certificate.verdict != "certified"
    assert (
        certificate["paths"].status == "inconclusive" or certificate["no_intersection"].status == "violated"
    )
