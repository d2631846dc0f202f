"""Coefficients of friction as bodies and scenes have them."""

from __future__ import annotations

import warnings

import pytest

import stark
from stark import mesh


def make_scene() -> stark.Scene:
    scene = stark.Scene("kitchen")
    scene.add_cloth(mesh.grid(0.4, 0.4, 4), name="napkin", position=(0, 0, 0.5), friction=0.9)
    scene.add_solid(mesh.tet_box(0.1, 2), name="cheese", position=(0, 0, 0.2), friction=0.4)
    scene.add_box((0.1, 0.2, 0.3), density=500.0, position=(1, 0, 0.2))
    scene.add_floor()
    return scene


def test_friction_rule() -> None:
    scene = make_scene()
    assert scene.friction["box", "floor"] == scene.default_friction == 0.5  # no silent zero
    assert scene.friction["napkin", "cheese"] == pytest.approx(0.6, rel=1e-15)
    scene.default_friction = 0.1
    assert scene.friction["napkin", "floor"] == pytest.approx(0.3, rel=1e-15)
    assert scene.friction["napkin", "napkin"] == 0.9
    scene.friction["floor", scene["napkin"]] = 0
    assert scene.friction["napkin", "floor"] == 0.0


def test_friction_of_a_body_without_self_contact_with_itself_is_told_to_do_nothing() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, name="box")
    cloth = scene.add_cloth(stark.mesh.grid(1.0, 1.0, 2), position=(0, 0, 1), name="cloth")
    sheet = scene.add_cloth(
        stark.mesh.grid(1.0, 1.0, 2), position=(0, 0, 2), self_contact=False, name="sheet"
    )
    rod = scene.add_rod([(k, 0, 3) for k in range(5)], name="rod")
    for body, other in ((box, cloth), (sheet, box), (cloth, cloth), (rod, rod)):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            scene.friction[body, other] = 0.3
    for body in (box, sheet):
        with pytest.warns(stark.StarkWarning, match=f"friction of '{body.name}' with itself has no effect"):
            scene.friction[body, body] = 0.3
