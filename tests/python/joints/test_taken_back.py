"""What is added in several calls, of which one is refused, leaves the scene as it was, and adding it takes as
long however large the scene is."""

from __future__ import annotations

import pytest

import stark
from stark.scene_record import RecordedScene


def full_scene(*, with_refusals: bool) -> stark.Scene:
    """Of all kinds of bodies and loads, with calls in between that are refused."""
    scene = stark.Scene()
    scene.default_friction = 0.35
    floor = scene.add_floor(1.0)
    box = scene.add_box(0.1, mass=0.5, position=(0, 0, 0.06), friction=0.2, name="box")
    arm = scene.add_box((0.2, 0.02, 0.02), mass=0.1, position=(0.2, 0, 0.3), name="arm")
    cloth = scene.add_cloth(
        stark.mesh.grid(0.3, 0.3, cells=6), stark.materials.cotton, position=(0, 0, 0.2), pins=[0, 6]
    )
    jelly = stark.SolidMaterial(density=300.0, youngs_modulus=3e4)
    solid = scene.add_solid(stark.mesh.tet_box(0.1, cells=2), jelly, position=(0.4, 0, 0.06))
    solid.growth = 1.01
    rod = scene.add_rod(stark.mesh.polyline((-0.4, 0, 0.3), (-0.4, 0.3, 0.3), 6), clamps=[0])
    scene.friction[box, floor] = 0.5, 0.4
    scene.restitution[box, floor] = 0.3
    scene.disable_contact(box, cloth)
    scene.add_force(box, (0.1, 0, 0))
    scene.attach(solid.vertices[[0]], None)

    def refused() -> None:
        if not with_refusals:
            return
        with pytest.raises(stark.InvalidArgument):
            scene.add_spring(box, arm, (0, 0, 0.1), (0.2, 0, 0.3), stiffness=-1.0, name="lost")
        with pytest.raises(stark.InvalidArgument):
            scene.add_hinge(None, arm, anchor=(0.1, 0, 0.3), axis="y", limits=(1.0, -1.0))
        with pytest.raises(stark.InvalidArgument):
            scene.add_tilt(None, arm, anchor=(0.1, 0, 0.3), axis="y", limit=-1.0)

    refused()
    hinge = scene.add_hinge(None, arm, anchor=(0.1, 0, 0.3), axis="y", limits=(-0.2, 1.0), name="hinge")
    refused()
    motor = hinge.add_motor(1.0, cap=0.1, delta=0.1)
    motor.enabled = False
    motor.target = 2.0
    refused()
    scene.add_spring(box, rod.frame(-1), (0, 0, 0.1), (-0.4, 0.3, 0.3), stiffness=5.0, name="spring")
    refused()
    return scene


def test_refused_calls_leave_the_scene_as_it_was() -> None:
    scene, twin = full_scene(with_refusals=True), full_scene(with_refusals=False)
    assert scene.warnings == twin.warnings
    assert [joint.name for joint in scene.joints] == [joint.name for joint in twin.joints]
    assert [actuator.name for actuator in scene.actuators] == [actuator.name for actuator in twin.actuators]
    assert len(scene._core.calls) == len(twin._core.calls)
    states = []
    for each in (scene, twin):
        simulation = stark.Simulation(each, time_step=0.01)
        simulation.run_until(0.1)
        states.append(simulation.state)
    assert states[0] == states[1]


def test_a_spring_does_not_copy_the_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: RecordedScene) -> None:
        raise AssertionError("the scene was copied")

    monkeypatch.setattr(RecordedScene, "copy", refuse)
    scene = stark.Scene()
    boxes = [scene.add_box(0.1, mass=1.0, position=(0.2 * k, 0, 0)) for k in range(3)]
    scene.add_spring(boxes[0], boxes[1], (0, 0, 0), (0.2, 0, 0), stiffness=1.0)
    scene.add_hinge(None, boxes[2], anchor=(0.4, 0, 0), axis="z", limits=(-1.0, 1.0))
    assert len(scene.joints) == 2
