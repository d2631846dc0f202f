"""What follows a motion takes no other places: the coming step would replace them without a word."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest

import stark


def scene_of(kind: str) -> tuple[stark.Simulation, stark.RigidBody | stark.Cloth | stark.Rod]:
    """A body that follows a motion along z: a box, a sheet by one of its two pins, a rod with its clamp."""
    scene = stark.Scene()
    if kind == "box":
        body = scene.add_box(0.1, motion="scripted", name="mover")
        body.follow(position=lambda t: (0.0, 0.0, t))
    elif kind == "sheet":
        body = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=2), name="mover", pins=[0, 2])
        body.follow(displacement=lambda t: (0.0, 0.0, 0.1 * t), vertices=[2])
    else:
        line = stark.mesh.polyline((0, 0, 0), (0.2, 0, 0), 4)
        body = scene.add_rod(line, stark.materials.rubber_cord, name="mover", clamps=[0])
        body.follow(rotation=lambda t: stark.rotation(axis="x", angle=t))
    return stark.Simulation(scene, time_step=0.01), body


ASSIGNED: dict[str, Callable[[stark.RigidBody], None]] = {
    "position": lambda box: setattr(box, "position", (0.0, 0.0, 1.0)),
    "rotation": lambda box: setattr(box, "rotation", stark.rotation(axis="z", angle=0.1)),
    "pose": lambda box: setattr(box, "pose", ((0.0, 0.0, 1.0), np.eye(3))),
    "velocity": lambda box: setattr(box, "velocity", (1.0, 0.0, 0.0)),
    "angular_velocity": lambda box: setattr(box, "angular_velocity", (1.0, 0.0, 0.0)),
}


@pytest.mark.parametrize("what", ASSIGNED)
def test_a_body_on_a_motion_takes_no_place_or_velocity(what: str) -> None:
    sim, box = scene_of("box")
    for _ in range(2):
        with pytest.raises(
            stark.InvalidArgument, match=f"'mover': {what} is assigned, but the body follows a"
        ):
            ASSIGNED[what](box)
        assert not sim.step().failed and box.position[2] == pytest.approx(sim.time, rel=1e-12)
    box.position, box.rotation, box.velocity = box.position, box.rotation, box.velocity  # change nothing
    box.follow()
    ASSIGNED[what](box)
    assert not sim.step().failed


def test_pins_on_a_motion_take_no_targets_and_others_do() -> None:
    sim, sheet = scene_of("sheet")
    sim.step()
    targets = sheet.pin_targets.copy()
    targets[0] += (0.0, 0.0, 1e-3)
    sheet.pin_targets = targets
    sim.step()
    assert sheet.positions[0, 2] == pytest.approx(1e-3) and sheet.positions[2, 2] == pytest.approx(2e-3)
    targets = sheet.pin_targets.copy()
    targets[1] += (0.0, 0.0, 1e-3)
    with pytest.raises(
        stark.InvalidArgument, match=r"'mover': pin_targets\[1\] is assigned, but vertex 2 follows"
    ):
        sheet.pin_targets = targets
    sheet.follow()
    sheet.pin_targets = targets
    sim.step()
    assert sheet.positions[2, 2] == pytest.approx(3e-3)


def test_no_pins_take_no_targets() -> None:
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), name="sheet")
    sim = stark.Simulation(scene)
    sim["sheet"].pin_targets = np.empty((0, 3))
    assert sim["sheet"].pin_targets.shape == (0, 3)


def test_clamps_on_a_motion_take_no_targets() -> None:
    sim, rod = scene_of("rod")
    sim.step()
    turned = rod.clamp_targets @ stark.rotation(axis="z", angle=0.1)
    with pytest.raises(stark.InvalidArgument, match=r"'mover': clamp_targets\[0\] is assigned, but vertex 0"):
        rod.clamp_targets = turned
    rod.follow()
    rod.clamp_targets = turned
    assert not sim.step().failed and np.allclose(rod.frames[0], turned[0], atol=1e-12)


def test_a_motion_that_replaces_half_of_another_warns() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, motion="scripted", name="mover")
    box.follow(position=lambda t: (t, 0.0, 0.0))
    with pytest.warns(stark.StarkWarning, match="'mover': follow: its position follows no motion any more"):
        box.follow(rotation=lambda t: stark.rotation(axis="z", angle=t))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        box.follow(position=lambda t: (t, 0.0, 0.0), rotation=lambda t: stark.rotation(axis="z", angle=t))
        box.follow()
        box.follow(position=lambda t: (t, 0.0, 0.0))


def test_a_velocity_that_a_motion_ends_warns() -> None:
    """That of what the motion does not prescribe; the velocity of the motion itself may be given."""
    scene = stark.Scene()
    spinner = scene.add_box(0.1, motion="scripted", name="spinner", angular_velocity=(0.0, 0.0, 2.0))
    slider = scene.add_box(
        0.1, motion="scripted", name="slider", position=(1, 0, 0), velocity=(1.0, 0.0, 0.0)
    )
    spinner.follow(position=lambda t: (0.0, t, 0.0))
    slider.follow(position=lambda t: (1.0 + t, 0.0, 0.0))
    sim = stark.Simulation(scene, time_step=0.01)
    with pytest.warns(stark.StarkWarning, match=r"'spinner': angular_velocity = .*2.* rad/s ends") as told:
        sim.step()
    assert len(told) == 1
    assert spinner.rotation[0, 0] == 1.0 and slider.position[0] == pytest.approx(1.01, rel=1e-12)
