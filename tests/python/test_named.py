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


def test_single_handles_are_made_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading one joint of thousands made the handles of all."""
    scene = stark.Scene()
    for k in range(20):
        box = scene.add_box(0.1, mass=1.0, position=(k, 0, 0), name=f"box {k}")
        scene.add_hinge(None, box, anchor=(k, 0, 0), axis=(0, 0, 1), name=f"hinge {k}")
    sim = stark.Simulation(scene, time_step=0.01)
    made = []
    plain = stark.Joint._bound_to

    def counted(self: stark.Joint, simulation: stark.Simulation) -> stark.Joint:
        made.append(self._index)
        return plain(self, simulation)

    monkeypatch.setattr(stark.Joint, "_bound_to", counted)
    assert sim.joints[7].name == "hinge 7" and sim.joints["hinge 9"].name == "hinge 9"
    assert sim.joints[-1].name == "hinge 19" and "hinge 3" in sim.joints and len(sim.joints) == 20
    assert made == [7, 9, 19]
    joints = sim.joints
    assert joints[2] is joints["hinge 2"] is joints[2]
    for parts in (
        joints,
        list(joints),
        [*joints],
        joints + joints[:0],
        sorted(joints, key=lambda j: j.name),
        joints[:],
    ):
        assert len(parts) == 20 and all(joint._of is sim for joint in parts)
    assert next(reversed(joints)) is joints[-1] and joints.index(joints[3]) == 3
    assert joints == list(joints) and joints[:0] + joints == joints and joints != [] and joints[5] in joints
    joints.pop()
    assert len(joints) == 19 and len(sim.joints) == 20


def test_handles_joined_to_a_plain_list_are_those_of_the_simulation() -> None:
    _, sim = machine()
    ball, first = object(), sim.bodies[0]
    joined = [ball] + sim.bodies  # noqa: RUF005
    assert type(joined) is list and joined[0] is ball and len(joined) == 1 + len(sim.bodies)
    assert all(body._of is sim for body in joined[1:])
    joined = [*[ball], *sim.bodies]
    joined += sim.bodies
    assert all(body._of is sim for body in joined[1:])
    assert joined[1] == first


def test_names_of_what_was_taken_out_again() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, name="box")
    with pytest.raises(RuntimeError, match="on purpose"), scene._all_or_nothing():
        scene.add_hinge(None, box, anchor=(0, 0, 0), axis=(0, 0, 1), name="first")
        scene.add_hinge(None, box, anchor=(0, 0, 0), axis=(0, 0, 1), name="second")
        assert scene.joints["second"].name == "second"
        raise RuntimeError("on purpose")
    with pytest.raises(stark.InvalidArgument, match="unknown joint 'second'"):
        scene.joints["second"]
    scene.add_hinge(None, box, anchor=(0, 0, 0), axis=(0, 0, 1), name="second")
    assert scene.joints["second"]._index == 0 and stark.Simulation(scene).joints["second"]._index == 0


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
