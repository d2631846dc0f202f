"""Values that are assigned to handles and that no simulation can take."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

HUGE = (1e200, 0.0, 0.0)


@pytest.fixture
def sim() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.2, 0.2, 2), name="sheet", pins=[0, 1])
    scene.add_box(0.1, name="tool", motion="scripted", position=(0, 0, -1))
    return stark.Simulation(scene)


@pytest.mark.parametrize(
    "pose",
    [None, 3, "ab", ((0, 0, 0),), ((0, 0, 0), None, 1), (0, 0, 0), np.zeros((2, 3)), {0: (0, 0, 0), 1: None}],
)
def test_a_pose_is_two_values(sim: stark.Simulation, pose: Any) -> None:
    before = sim["tool"].pose
    with pytest.raises(
        stark.InvalidArgument, match=r"(?s)'tool': pose = .*must be \(position \[m\], rotation"
    ):
        sim["tool"].pose = pose
    assert sim["tool"].pose[0].tolist() == before[0].tolist()


@pytest.mark.parametrize("what", ["position", "velocity", "angular_velocity"])
def test_huge_values_are_refused_when_assigned(sim: stark.Simulation, what: str) -> None:
    with pytest.raises(stark.InvalidArgument, match=rf"'tool': {what} = \(1e\+200.*beyond 1e150"):
        setattr(sim["tool"], what, HUGE)
    assert not sim.step().failed


def test_huge_targets_are_refused(sim: stark.Simulation) -> None:
    sheet, tool = sim["sheet"], sim["tool"]
    with pytest.raises(stark.InvalidArgument, match=r"'tool': position = .*beyond 1e150"):
        tool.pose = HUGE, None
    with pytest.raises(stark.InvalidArgument, match=r"'sheet': pin_targets\[1\] = \[1e\+200.* m: .*1e150"):
        sheet.pin_targets = [(0, 0, 0), HUGE]
    with pytest.raises(stark.InvalidArgument, match=r"'tool': position at 0 s = .*beyond 1e150"):
        tool.follow(position=lambda t: HUGE)
    with pytest.raises(stark.InvalidArgument, match=r"'sheet': displacement at 0 s = .*beyond 1e150"):
        sheet.follow(displacement=lambda t: HUGE)
    with pytest.raises(stark.InvalidArgument, match=r"'sheet': targets at 0 s\[0\] = .*beyond 1e150"):
        sheet.follow(lambda t: [HUGE, HUGE])
    with pytest.raises(
        stark.InvalidArgument, match=r"has the shape \(2, 3\): must be three .*follow targets"
    ):
        sheet.follow(displacement=lambda t: [(0, 0, 0), (0, 0, 1)])
    tool.follow(position=lambda t: HUGE if t > 0.0 else (0, 0, -1))
    with pytest.raises(stark.InvalidArgument, match=r"'tool': position at .* s = .*beyond 1e150"):
        sim.step()


@pytest.mark.parametrize("value", [True, np.True_, (True, 0.5), [0.5, False], np.array([True, False])])
def test_friction_is_no_flag(sim: stark.Simulation, value: Any) -> None:
    before = sim.scene.friction["sheet", "tool"]
    with pytest.raises(stark.InvalidArgument, match=r"(?s)friction of \('sheet', 'tool'\) = .*a number >= 0"):
        sim.scene.friction["sheet", "tool"] = value
    assert sim.scene.friction["sheet", "tool"] == before


def test_huge_coordinates_are_refused() -> None:
    """1e300 made positions NaN."""
    scene = stark.Scene()
    slide = scene.add_slider(None, scene.add_box(0.1, mass=1.0), anchor=(0, 0, 0), axis="x")
    sim = stark.Simulation(scene)
    sim.step()
    before = sim.state
    for value in (1e150, -1e300, np.inf, np.nan):
        with pytest.raises(stark.InvalidArgument, match="joint 'slider'"):
            slide.displacement = value
    assert sim.state == before


def test_what_ends_a_run_is_a_function(sim: stark.Simulation) -> None:
    with pytest.raises(stark.InvalidArgument, match=r"run_until: stop = 0\.1: must be a function"):
        sim.run_until(0.02, 0.1)  # type: ignore[arg-type]
    with pytest.raises(
        stark.InvalidArgument, match=r"run_until: until = inf s without stop=: would never end"
    ):
        sim.run_until(np.inf)
    assert sim.time == 0.0
    assert sim.run_until(np.inf, lambda: sim.time > 0.0) is not None


def test_messages_about_velocities_of_vertices_have_their_unit(sim: stark.Simulation) -> None:
    wrong = np.full_like(sim["sheet"].velocities, np.nan)
    with pytest.raises(
        stark.InvalidArgument, match=r"velocities\[0\] = \[nan, nan, nan\] m/s: must be finite"
    ):
        sim["sheet"].velocities = wrong
