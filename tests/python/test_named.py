"""Parts of scenes and simulations by number and by name."""

from __future__ import annotations

import copy

import pytest

import stark
from stark.named import NamedList, NamedTuple


def machine() -> tuple[stark.Scene, stark.Simulation]:
    scene = stark.Scene()
    wheel = scene.add_cylinder(0.05, 0.02, mass=1.0, name="wheel")
    axle = scene.add_hinge(None, wheel, anchor=(0, 0, 0), axis=(0, 0, 1), name="axle")
    axle.add_motor(target=1.0, cap=1.0, delta=0.1, name="drive")
    weight = scene.add_box(0.1, mass=1.0, position=(1, 0, 0), name="weight")
    scene.attach(weight.points((0, 0, 0)), None, name="glue")
    scene.attach(weight.points((0, 0, 0.05)), None, name="tape", enabled=False)
    scene.add_force(weight, (0, 0, 1))
    sheet = scene.add_solid(stark.mesh.tet_box(0.1, 1), stark.materials.soft_rubber, position=(2, 0, 0))
    sheet.add_skin(stark.materials.cotton, name="skin")
    return scene, stark.Simulation(scene, time_step=0.01)


def test_every_kind_of_part_is_found_by_its_name() -> None:
    scene, sim = machine()
    sim.step()
    for of in (scene, sim):
        names = {
            "bodies": "weight",
            "layers": "skin",
            "joints": "axle",
            "actuators": "drive",
            "attachments": "tape",
            "energies": "force",
        }
        for kind, name in names.items():
            parts = getattr(of, kind)
            assert parts[name].name == name
            assert name in parts
            assert "nothing" not in parts
            assert parts[0].name == next(iter(parts)).name
            assert [part.name for part in parts[:1]] == [parts[0].name]
    assert sim.joints["axle"].angle > 0.0
    assert sim.attachments["glue"].force[2] == pytest.approx(9.81 - 1.0, rel=1e-3)
    assert not sim.attachments["tape"].enabled


def test_handles_are_those_of_the_simulation() -> None:
    scene, first = machine()
    second = stark.Simulation(scene, time_step=0.01)
    first.step()
    assert first.joints["axle"].angle > 0.0
    assert second.joints["axle"].angle == 0.0
    assert isinstance(first.joints, list)
    assert isinstance(scene.joints, tuple)


def test_unknown_names_say_what_there_is() -> None:
    scene, sim = machine()
    with pytest.raises(
        stark.InvalidArgument, match=r"unknown joint 'axl' \(did you mean 'axle'\?\).*there is 1: 'axle'"
    ):
        sim.joints["axl"]
    with pytest.raises(stark.InvalidArgument, match=r"attachment 'rope'.*there are 2: 'glue', 'tape'"):
        scene.attachments["rope"]
    with pytest.raises(stark.InvalidArgument, match=r"unknown robot 'arm'.*there are none"):
        sim.robots["arm"]
    with pytest.raises(IndexError):
        sim.joints[1]


def test_lists_and_tuples_are_those_of_python_otherwise() -> None:
    class Part:
        def __init__(self, name: str) -> None:
            self.name = name

    a, b = Part("a"), Part("b")
    assert [*NamedList("part", [a, b]), a] == [a, b, a]
    assert NamedTuple("part", [a, b]) == (a, b)
    assert b in NamedTuple("part", [a, b])
    assert b not in NamedList("part", [a])


def test_copies_are_of_the_same_parts() -> None:
    scene, sim = machine()
    for parts in (scene.bodies, sim.bodies, scene.joints):
        same = copy.copy(parts)
        assert type(same) is type(parts) and list(same) == list(parts)
        assert same[0] is parts[0] and same[parts[0].name] is parts[0]


def test_attributes_are_not_deleted() -> None:
    scene, sim = machine()
    for owner, name in ((scene.bodies["wheel"], "name"), (sim, "state"), (scene.bodies["wheel"], "position")):
        with pytest.raises(AttributeError, match=f"{name} cannot be deleted: assign another value"):
            delattr(owner, name)
