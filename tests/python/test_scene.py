"""Scenes: bodies by name, contact of pairs, names, the record of what was done."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import stark
from stark import _core, mesh
from stark.scene_record import RecordedScene

FRAME: dict[str, Any] = {"carrier": "world", "position": np.zeros(3), "rotation": np.eye(3).reshape(-1)}


def make_scene() -> stark.Scene:
    scene = stark.Scene("kitchen")
    scene.add_cloth(mesh.grid(0.4, 0.4, 4), name="napkin", position=(0, 0, 0.5), friction=0.9)
    scene.add_solid(mesh.tet_box(0.1, 2), name="cheese", position=(0, 0, 0.2), friction=0.4)
    scene.add_box((0.1, 0.2, 0.3), density=500.0, position=(1, 0, 0.2))
    scene.add_floor()
    return scene


def test_bodies_by_name_order_and_kind() -> None:
    scene = make_scene()
    assert [body.name for body in scene] == ["napkin", "cheese", "box", "floor"]
    assert [body.kind for body in scene.bodies] == ["cloth", "solid", "rigid", "rigid"]
    assert [body.motion for body in scene.bodies] == ["dynamic", "dynamic", "dynamic", "fixed"]
    assert "box" in scene and scene["box"] in scene and "wall" not in scene
    assert scene.add_box(0.1, mass=1.0).name == "box_2"
    assert isinstance(scene["napkin"], stark.Cloth) and isinstance(scene["floor"], stark.RigidBody)
    assert "napkin (cloth)" in repr(scene)


def test_contact_of_pairs() -> None:
    scene = make_scene()
    assert scene.contact_enabled("napkin", "napkin") and not scene.contact_enabled("box", "box")
    scene.disable_contact("napkin", scene["box"])
    assert not scene.contact_enabled("box", "napkin")
    scene.enable_contact("box", "napkin")
    assert scene.contact_enabled("box", "napkin")


def test_suspicious_input_is_warned_about_once() -> None:
    scene = stark.Scene()
    with pytest.warns(stark.StarkWarning, match=r"extent of 400 m; if it is not in metres, scale"):
        scene.add_cloth(mesh.grid(400, 400, 2))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.add_floor()
    with pytest.warns(stark.StarkWarning, match="open"):
        scene.add_rigid(mesh.grid(1, 1, 1), mass=1.0)
    three = mesh.TriangleMesh(
        [[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]]
    )
    with pytest.warns(stark.StarkWarning) as caught:
        scene.add_cloth(three)
    messages = [str(warning.message) for warning in caught]
    assert any("1 edge shared by more than two triangles (first: 0-1)" in message for message in messages)
    assert any("oriented differently" in message for message in messages)
    assert len(scene.warnings) == 4


def test_names_are_the_first_free_ones_and_many_take_no_time() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, motion="fixed", name="box_2")
    names = [scene.add_box(0.1, motion="fixed").name for _ in range(1000)]
    assert names[:3] == ["box", "box_3", "box_4"] and names[-1] == "box_1001"
    assert "box_2" in scene and "box_1002" not in scene and scene.bodies[0] in scene


def test_every_change_of_a_scene_is_recorded() -> None:
    """What a reproducer of a failed step is written from."""
    changing = ("add_", "set_", "pin", "clamp", "disable_", "enable_")
    names = {name for name in dir(_core.Scene) if name.startswith(changing)} - {"pins", "clamped"}
    assert names == {name for name in vars(RecordedScene) if name.startswith(changing)}


def group_scene(count: int) -> tuple[stark.Scene, list[stark.RigidBody]]:
    scene = stark.Scene()
    scene.add_floor(1.0)
    boxes = [scene.add_box(0.1, mass=1.0, position=(0.2 * k, 0, 1), name=f"box{k}") for k in range(count)]
    return scene, boxes


def test_contact_of_groups_is_disabled_with_one_call() -> None:
    scene, boxes = group_scene(5)
    calls = len(scene._core.calls)
    scene.disable_contact(boxes[:3])
    scene.disable_contact([boxes[3], "box4"], ["floor"])
    scene.disable_contact(boxes[0], (boxes[4],))
    assert len(scene._core.calls) == calls + 3
    off = {(a, b) for a in range(6) for b in range(a, 6) if a != b and not scene._core.contact_enabled(a, b)}
    assert off == {(1, 2), (1, 3), (2, 3), (0, 4), (0, 5), (1, 5)}
    scene.enable_contact(boxes)
    assert scene.contact_enabled("box0", "box1") and not scene.contact_enabled("box4", "floor")
    again = group_scene(5)[0]
    for name, arguments in scene._core.calls[calls:]:
        getattr(again._core, name)(*arguments)
    assert again.contact_enabled("box0", "box1") and not again.contact_enabled("box4", "floor")


def test_groups_pass_through_each_other() -> None:
    scene, boxes = group_scene(3)
    scene.disable_contact(boxes, "floor")
    sim = stark.Simulation(scene, time_step=0.05)
    sim.run_until(1.0)
    assert all(box.position[2] < -1.0 for box in boxes)


def test_self_contact_is_no_matter_of_groups() -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(1.0, 1.0, 2), name="cloth")
    scene.disable_contact([cloth, cloth])
    assert scene.contact_enabled(cloth, cloth)
    scene.disable_contact(cloth, cloth)
    assert not scene.contact_enabled(cloth, cloth)


def test_wrong_groups_are_refused() -> None:
    scene, boxes = group_scene(2)
    calls = len(scene._core.calls)
    for wrong, message in (
        (lambda: scene.disable_contact(boxes[0]), "must be several bodies, or give another one as b"),
        (lambda: scene.disable_contact([]), "a group has no bodies"),
        (lambda: scene.disable_contact(boxes, ["box7"]), "box7"),
        (lambda: scene.enable_contact([boxes[0], 3]), "must be a body of the scene or its name"),  # type: ignore[list-item]
    ):
        with pytest.raises(stark.InvalidArgument, match=message):
            wrong()
    assert len(scene._core.calls) == calls


@pytest.mark.parametrize(
    ("what", "given", "missing"),
    [
        ("joint", {"definition": _core.find_joint("hinge"), "a": FRAME}, "b"),
        (
            "joint",
            {"definition": _core.find_joint("hinge"), "a": {**FRAME, "carrier": "patch"}, "b": FRAME},
            "vertices",
        ),
        ("attachment", {"a": {"kind": "world"}, "b": []}, "local"),
        ("actuator", {"definition": _core.find_actuator(_core.actuator_names()[0])}, "on"),
    ],
)
def test_the_core_wants_whole_descriptions(what: str, given: dict[str, Any], missing: str) -> None:
    """As files that are damaged do not have them."""
    with pytest.raises(KeyError, match=missing):
        getattr(_core.Scene(), f"add_{what}")(given)


def test_the_core_knows_its_kinds_of_points_and_frames() -> None:
    with pytest.raises(
        stark.InvalidArgument, match=r"points: kind = 'vertex': must be one of 'vertices', 'point'"
    ):
        _core.Scene().add_attachment({"a": {"kind": "vertex", "local": np.zeros((1, 3))}, "b": []})
    with pytest.raises(
        stark.InvalidArgument, match="frame: carrier = 'bodi': must be one of 'world', 'body'"
    ):
        _core.Scene().add_joint({"a": {**FRAME, "carrier": "bodi"}, "b": FRAME})


@pytest.mark.parametrize("counts", [[3], [1, 2], [-1], [2**30]])
def test_paths_of_fibres_have_the_vertices_that_are_given(counts: list[int]) -> None:
    """The core read on behind them, as of files of steps that were written by hand."""
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2))
    given = {"name": "warp", "body": 0, "vertices": [0, 1], "counts": counts}
    with pytest.raises(stark.InvalidArgument, match=r"'warp': counts: got -?\d+ vertices where \d+ are left"):
        scene._core.add_fibres(given, stark.materials.steel_wire._core)
