"""Handles of bodies and the life of their simulation."""

from __future__ import annotations

import gc
import re
import warnings
from typing import Any

import pytest

import stark


def test_a_handle_that_outlives_its_simulation_says_so() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, name="crate")
    start = box.positions
    simulation = stark.Simulation(scene)
    simulation.step()
    assert not (box.positions == start).all()
    del simulation
    gc.collect()
    with pytest.raises(stark.InvalidArgument, match=r"'crate'.*simulation is gone.*keep"):
        _ = box.positions
    with pytest.raises(stark.InvalidArgument, match="gone"):
        _ = box.velocity


def test_a_second_simulation_leaves_the_handles_of_the_first_working() -> None:
    """They read the newest one that lives: after a temporary one, the first again."""
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 1), name="crate")
    hinge = scene.add_fixed(box, None, anchor=(0, 0, 1), enabled=False)
    glue = scene.attach(box.points((0, 0, 0)), None, enabled=False)
    pull = scene.add(weight(box.points((0, 0, 0))))
    first = stark.Simulation(scene)
    first.step()
    fallen = box.position[2]
    assert fallen < 1.0

    def try_something() -> None:
        second = stark.Simulation(scene)
        assert box.position[2] == second["crate"].position[2] == 1.0
        hinge.enabled = True
        assert second.joints[0].enabled and not first.joints[0].enabled

    try_something()
    gc.collect()
    assert box.position[2] == first[box].position[2] == fallen
    assert box.velocity[2] < 0.0
    assert not hinge.enabled and not glue.enabled and pull.energy == pytest.approx(-0.1 * fallen)
    first.step()
    assert box.position[2] < fallen


@stark.energy
def weight(p: stark.Point):
    return -0.1 * p.x[2]


@pytest.mark.parametrize(
    ("assign", "said"),
    [
        (
            lambda s: setattr(s.scene, "gravity", (0, 0, 0)),
            r"no attribute 'gravity': it is a setting of the simulation",
        ),
        (lambda s: setattr(s.scene, "time_step", 0.1), r"stark.Simulation\(scene, time_step=...\)"),
        (lambda s: setattr(s.scene, "firction", 0.1), "no attribute 'firction'; did you mean 'friction'"),
        (lambda s: setattr(s["crate"], "positon", (0, 0, 1)), "'crate'.*'positon'; did you mean 'position'"),
        (lambda s: setattr(s["crate"], "densty", 3.0), "'crate'.*no attribute 'densty'"),
        (lambda s: setattr(s, "tme", 3.0), "no attribute 'tme'; did you mean 'time'"),
        (lambda s: setattr(s["sheet"], "pinz", [1]), "'sheet'.*'pinz'; did you mean 'pin'"),
        (lambda s: setattr(s.attachments[0], "enable", True), "'enable'; did you mean 'enabled'"),
        (lambda s: setattr(s.layers[0], "colour", (1, 0, 0)), "'colour'; did you mean 'color'"),
        (lambda s: setattr(s["crate"], "mass", 3.0), "mass can be read, not assigned: write mass= where the"),
        (lambda s: setattr(s["sheet"], "pins", [1]), r"pins can be read, .* or body\.pin\(vertices\)"),
        (
            lambda s: s["sheet"].unpin(),
            r"write scene\.attach\(.*None\) in place of pins, which hold for good",
        ),
        (lambda s: setattr(s, "time_step", 0.1), r"write stark\.Simulation\(scene, time_step=\.\.\.\)"),
        (lambda s: setattr(s, "dt", 0.1), "no attribute 'dt': write sim.time_step"),
    ],
)
def test_assignments_to_unknown_attributes_are_refused(assign: Any, said: str) -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, name="crate")
    sheet = scene.add_cloth(stark.mesh.grid(0.1, 0.1, 1), position=(0, 0, 1), name="sheet")
    sheet.add_skin(stark.materials.cotton)
    scene.attach(box.points((0, 0, 0)), None)
    with pytest.raises(AttributeError, match=said):
        assign(stark.Simulation(scene))


@pytest.mark.parametrize(
    "assign",
    [
        lambda settings: setattr(settings, "gravity", (0, 0, 0)),
        lambda settings: setattr(settings.newton, "max_iterations", 3),
        lambda settings: settings.update({"time_step": 0.1}),
        lambda settings: settings.set_text("time_step=0.1"),
        lambda settings: settings.__setitem__("time_step", 0.1),
    ],
)
def test_the_settings_of_a_simulation_stay_as_they_are(assign: Any) -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    sim = stark.Simulation(scene, time_step=0.01)
    expected = r"settings of a simulation cannot be changed; create a new one"
    with pytest.raises(stark.InvalidSetting, match=expected):
        assign(sim.settings)
    copy = sim.settings.copy()
    assign(copy)
    assert copy != sim.settings and stark.Simulation(scene, sim.settings).settings == sim.settings


def test_what_is_added_too_late_to_act_is_warned_about() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    early = scene.add(weight(box.points((0, 0, 0))))
    sim = stark.Simulation(scene)
    with pytest.warns(
        stark.StarkWarning, match="'weight_2' was added after the simulation was created and does"
    ):
        late = scene.add(weight(box.points((0, 0, 0))))
    with pytest.warns(stark.StarkWarning, match="joint 'ball' was added after"):
        scene.add_ball(box, None, anchor=(0, 0, 0))
    with pytest.warns(stark.StarkWarning, match="attachment 'attachment' was added after"):
        scene.attach(box.points((0, 0, 0)), None)
    assert len(sim.energies) == 1
    assert early.name != late.name
    del sim
    gc.collect()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.add(weight(box.points((0, 0, 0))))


@pytest.mark.parametrize(
    ("read", "said"),
    [
        (lambda s: s.set_friction, r"'set_friction': write scene\.friction\[a, b\] = 0\.5"),
        (lambda s: s.add_ground, r"write scene\.add_floor\(\)"),
        (lambda s: s.add_hinges, "has no attribute 'add_hinges'; did you mean 'add_hinge'"),
        (
            lambda s: setattr(s["crate"], "force", 1.0),
            r"'crate'.*write scene\.add_force\(body, \(0, 0, 1\.0\)\) \[N\]",
        ),
        (lambda s: s._private, "_private"),
        (lambda s: s["crate"].pos, "'crate'.*no attribute 'pos': write position of rigid bodies"),
        (lambda s: s["crate"].material, "'crate'.*write mass= or density= where it is added"),
        (lambda s: s["crate"].friction, r"write scene\.friction\[a, b\]"),
        (lambda s: stark.Simulation(s).render, r"write sim\.picture\('now\.png'\)"),
        (lambda s: stark.Simulation(s).gravity, r"write sim\.settings\.gravity"),
    ],
)
def test_unknown_attributes_say_what_was_meant(read: Any, said: str) -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="crate")
    with pytest.raises(AttributeError, match=said):
        read(scene)


def test_properties_that_fail_keep_their_own_error() -> None:
    class Broken(stark.Scene):
        @property
        def speed(self) -> float:
            return float(None.speed)  # type: ignore[attr-defined]

    with pytest.raises(AttributeError, match="'NoneType' object has no attribute 'speed'"):
        _ = Broken().speed
    assert not hasattr(stark.Scene(), "speed")


def test_what_is_advised_exists() -> None:
    """Names in advice are names of the scene, of joints and of bodies."""
    words = " ".join([*stark.Scene._elsewhere.values(), *stark.Body._elsewhere.values()])
    advised = set(re.findall(r"scene\.(\w+)", words)) | set(re.findall(r"add_\w+", words))
    assert {"friction", "add_force", "add_hinge"} <= advised
    known = {*dir(stark.Scene), *dir(stark.Joint)}
    assert advised <= known, advised - known
    assert not {*stark.Scene._elsewhere} & {*dir(stark.Scene)}
    for kind in (stark.RigidBody, stark.Cloth, stark.Solid, stark.Rod):
        assert not {*kind._elsewhere} & {*dir(kind)} and {*kind._given_by} <= {*dir(kind), "pins", "inertia"}
    assert not {*stark.Simulation._elsewhere} & {*dir(stark.Simulation)}
    assert {*stark.Simulation._given_by} <= {*dir(stark.Simulation)}
