"""What is written for the checker: pairs of bodies without contact, against asking for each pair."""

from __future__ import annotations

import json

import numpy as np
import pytest

import stark
from stark.recording.states import _description_text, describe


def crowded() -> stark.Scene:
    """Fixed, scripted and dynamic bodies, a cloth and a rod; pairs and groups without contact, some of them
    with contact again; joints and attachments that keep bodies apart."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    boxes = []
    for k in range(18):
        motion = ("dynamic", "scripted", "fixed")[k % 3]
        boxes.append(
            scene.add_box(0.05, density=500.0, position=(0.1 * k, 0, 1), name=f"b{k}", motion=motion)
        )
    cloth = scene.add_cloth(
        stark.mesh.grid(0.1, 0.1, 2), stark.materials.cotton, position=(0, 1, 1), name="c"
    )
    line = stark.mesh.polyline((0, 2, 1), (0.1, 2, 1), 4)
    scene.add_rod(line, stark.materials.rubber_cord, name="r")
    scene.disable_contact(boxes[0], cloth)
    scene.disable_contact(boxes[9], boxes[3])
    scene.disable_contact(boxes[3:8])
    scene.disable_contact(boxes[10:12], boxes[14:16])
    scene.enable_contact(boxes[3], boxes[6])
    scene.enable_contact(boxes[10], boxes[14])
    scene.add_hinge(boxes[1], boxes[2], anchor=(0.1, 0, 1), axis=(0, 1, 0), contact=False, name="h")
    scene.add_hinge(boxes[12], boxes[13], anchor=(1.2, 0, 1), axis=(0, 1, 0), contact=False, name="i")
    return scene


@pytest.mark.parametrize("self_contact", [True, False])
def test_pairs_are_those_that_the_scene_says(self_contact: bool) -> None:
    scene = crowded()
    sim = stark.Simulation(scene, **{"contact.self_contact": self_contact})
    core, count = scene._core, len(scene.bodies)
    found = json.loads(_description_text(sim))
    without = [
        [a, b]
        for a in range(count)
        for b in range(a, count)
        if not core.contact_possible(a, b) or (a == b and not self_contact)
    ]
    prescribed = [[a, b] for a in range(count) for b in range(a + 1, count) if core.meeting_matters(a, b)]
    assert found["pairs_without_contact"] == without
    assert found["pairs_prescribed"] == prescribed
    cloth = scene["c"]._index
    assert ([cloth, cloth] in without) == (not self_contact)  # and some of all kinds are there
    assert [1, cloth] in without and [2, 2] in without and len(prescribed) > 20


def test_pairs_are_none_where_all_bodies_meet() -> None:
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), stark.materials.cotton)
    found = json.loads(_description_text(stark.Simulation(scene)))
    assert found["pairs_without_contact"] == [] == found["pairs_prescribed"]


def test_bodies_that_were_added_later_are_not_described() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="a")
    sim = stark.Simulation(scene)
    scene.add_box(0.1, mass=1.0, position=(1, 0, 0), name="b")
    scene.disable_contact("a", "b")
    assert json.loads(_description_text(sim))["pairs_without_contact"] == [[0, 0]]


def test_thousands_of_bodies_are_described_without_asking_for_all_pairs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = stark.Scene()
    for k in range(200):
        scene.add_box(0.05, mass=1.0, position=(0.1 * k, 0, 0), name=f"b{k}")
    sim = stark.Simulation(scene)
    asked: list[tuple[int, int]] = []

    def possible(a: int, b: int) -> bool:
        asked.append((a, b))
        return a != b

    monkeypatch.setattr(scene._core, "contact_possible", possible)
    monkeypatch.setattr(scene._core, "meeting_matters", possible)
    assert np.array(describe(sim)["pairs_without_contact"]).tolist() == [[k, k] for k in range(200)]
    assert len(asked) == 200
