"""Systems of examples/: the vacuum robot and the gripper against statics, the law of motors and friction."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _validation import rows, validate

from stark import scenes
from stark.recording import Recording

EXAMPLES = Path(__file__).parents[3] / "examples"


def run(example: str, folder: Path, **options: Any) -> tuple[Any, Recording]:
    """The module of an example and a recording of its run, after its own check."""
    scene = scenes.load(EXAMPLES / f"{example}.py", options)
    result = scenes.run(scene, out=folder, replay=False, picture=False)
    assert (result.status, result.rejected_steps) == ("complete", 0), result.message
    return scene.module, Recording(folder)


@pytest.mark.parametrize("floor", ["carpet", "polished"])
def test_the_vacuum_robot(floor: str, tmp_path: Path) -> None:
    robot, recording = run("vacuum_robot", tmp_path / "run", floor=floor)
    for name, value in robot.results(recording).items():
        validate(f"robot_{floor}.{name}", value)
        _same_expectation(f"robot_{floor}.{name}", *robot.expected()[name])
    validate(f"robot_{floor}.iterations", recording.telemetry["newton_iterations"].mean())
    assert robot.plot(recording, tmp_path / "curves.svg").read_text().count("<polyline") == 8


@pytest.mark.parametrize("kind", ["rigid", "heavy", pytest.param("soft", marks=pytest.mark.slow)])
def test_the_gripper(kind: str, tmp_path: Path) -> None:
    gripper, recording = run("gripper", tmp_path / "run", object=kind)
    for name, value in gripper.results(recording).items():
        validate(f"gripper_{kind}.{name}", value)
        _same_expectation(f"gripper_{kind}.{name}", *gripper.expected()[name])
    validate(f"gripper_{kind}.iterations", recording.telemetry["newton_iterations"].mean())
    assert gripper.plot(recording, tmp_path / "curves.svg").read_text().count("<polyline") == 6


def _same_expectation(name: str, reference: float, tolerance: float) -> None:
    """The page must ask for what the check of the example asks for, to the digits that it shows."""
    row = rows()[name]
    assert row.reference == pytest.approx(reference, rel=1e-4, abs=1e-12)
    assert row.tolerance == pytest.approx(tolerance, rel=0.01)


def test_the_robot_needs_its_friction(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The check can fail: wheels slip where friction carries less than the motors push."""
    scene = scenes.load(EXAMPLES / "vacuum_robot.py", {"floor": "polished"})
    monkeypatch.setitem(scene.module.FRICTION, "polished", 0.1)
    result = scenes.run(scene, out=tmp_path / "run", replay=False, picture=False)
    assert result.status == "wrong"
    # While they slip, friction accelerates the robot: two wheels, and casters that roll along.
    recording = Recording(tmp_path / "run")
    time, speed = recording.telemetry["time"], recording.telemetry["measured.speed"]
    slipping = (time > 0.35) & (time < 0.5)
    load = sum(recording.telemetry[f"measured.load_{name}"] for name in ("left", "right"))[slipping].mean()
    mass = scene.module.TOTAL_MASS + scene.module.PART_MASS  # half of the mass of two casters rolls too
    assert np.polyfit(time[slipping], speed[slipping], 1)[0] == pytest.approx(0.1 * load / mass, rel=0.01)


def test_unknown_options_are_refused() -> None:
    with pytest.raises(ValueError, match=r"option floor = 'ice': must be one of carpet, polished"):
        scenes.load(EXAMPLES / "vacuum_robot.py", {"floor": "ice"}).build()
    with pytest.raises(ValueError, match=r"option object = 'egg': must be one of"):
        scenes.load(EXAMPLES / "gripper.py", {"object": "egg"}).build()


def test_meshes_are_closed_and_face_outwards() -> None:
    robot, gripper = (scenes.load(EXAMPLES / f"{name}.py").module for name in ("vacuum_robot", "gripper"))
    parts = robot.robot_parts
    surfaces = [parts.lathed(robot.PROFILE, 96), parts.wheel(0.035, 0.02, 128)]
    surfaces += [gripper.finger_mesh(side) for side in (-1.0, 1.0)]
    assert all(mesh.is_closed and mesh.volume > 0.0 for mesh in surfaces)
    # Frustums of the profile, and a cylinder; polygons of 96 and 128 corners enclose up to 0.1 % less.
    frustums = sum(
        np.pi / 3 * (top - low) * (a * a + a * b + b * b)
        for (a, low), (b, top) in zip(robot.PROFILE, robot.PROFILE[1:], strict=False)
    )
    assert surfaces[0].volume == pytest.approx(frustums, rel=1e-3)
    assert surfaces[1].volume == pytest.approx(np.pi * 0.035**2 * 0.02, rel=1e-3)
    assert surfaces[2].volume == pytest.approx(surfaces[3].volume, rel=1e-12)
    solid = gripper.soft_mesh()
    assert solid.volumes.min() > 0.0
    # 32 corners around: 0.6 % less than the cylinder.
    assert solid.volume == pytest.approx(np.pi * gripper.RADIUS**2 * gripper.HEIGHT, rel=0.01)
    assert solid.surface().is_closed
