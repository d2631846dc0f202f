"""Loads on what forces do not move: a warning names the load, the reason and the remedy."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

import stark


@pytest.mark.parametrize("motion", ["fixed", "scripted"])
def test_forces_and_torques_on_prescribed_bodies(motion: str) -> None:
    """They did nothing, without a word."""
    scene = stark.Scene()
    body = scene.add_box(0.1, mass=1.0, motion=motion, name="anvil")
    scene.add_force(body, (0.0, 0.0, 1.0), name="push")
    scene.add_torque(body, (0.0, 0.0, 1.0), name="twist")
    with pytest.warns(stark.StarkWarning) as said:
        stark.Simulation(scene, time_step=0.01)
    texts = [str(warning.message) for warning in said]
    for kind, name in (("force", "push"), ("torque", "twist")):
        start = f"{kind} '{name}' moves nothing: 'anvil' is {motion}: must act on what moves freely"
        assert any(text.startswith(start) for text in texts)


def test_forces_on_pinned_points_alone() -> None:
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=2), pins=[0, 1], name="sheet")
    scene.add_force(sheet.vertices[[0, 1]], (0.0, 0.0, 0.1), name="corners")
    scene.add_force(sheet.vertices[[1, 2]], (0.0, 0.0, 0.1), name="edge")
    with pytest.warns(
        stark.StarkWarning, match="'corners' moves nothing: all of its points of 'sheet' are"
    ) as said:
        stark.Simulation(scene, time_step=0.01)
    assert not any("'edge'" in str(warning.message) for warning in said)


@pytest.mark.parametrize("motion", ["fixed", "scripted"])
def test_actuators_between_prescribed_bodies(motion: str) -> None:
    scene = stark.Scene()
    anvil = scene.add_box(0.1, motion="fixed", name="anvil")
    wheel = scene.add_box(0.1, motion=motion, position=(1, 0, 0), name="wheel")
    free = scene.add_box(0.1, mass=1.0, position=(2, 0, 0), name="free")
    hinge = scene.add_hinge(anvil, wheel, anchor=(0.5, 0, 0), axis=(0, 0, 1))
    hinge.add_motor(target=1.0, cap=1.0, delta=0.1, name="idle motor")
    scene.add_hinge(None, free, anchor=(2, 0, 0), axis=(0, 0, 1)).add_motor(
        target=1.0, cap=1.0, delta=0.1, name="motor"
    )
    rule = rf"actuator 'idle motor' moves nothing: 'anvil' is fixed, 'wheel' is {motion}: must act between"
    with pytest.warns(stark.StarkWarning, match=rule) as said:
        stark.Simulation(scene, time_step=0.01)
    assert not any("'motor'" in str(warning.message) for warning in said)


@pytest.mark.parametrize("motion", ["fixed", "scripted"])
def test_joints_between_prescribed_bodies(motion: str) -> None:
    """They held nothing, without a word, or failed steps as forces that are too strong."""
    scene = stark.Scene()
    anvil = scene.add_box(0.1, motion="fixed", name="anvil")
    wheel = scene.add_box(0.1, motion=motion, position=(1, 0, 0), name="wheel")
    free = scene.add_box(0.1, mass=1.0, position=(2, 0, 0), name="free")
    scene.add_hinge(anvil, wheel, anchor=(0.5, 0, 0), axis="z", name="idle")
    scene.add_fixed(None, wheel, name="weld")
    scene.add_fixed(None, anvil, name="off", enabled=False)
    scene.add_hinge(wheel, free, anchor=(2, 0, 0), axis="z", name="useful")
    scene.add_span(anvil, wheel, (0, 0, 0), (1, 0, 0), name="ruler")
    with pytest.warns(stark.StarkWarning) as said:
        stark.Simulation(scene, time_step=0.01)
    texts = [str(warning.message) for warning in said]
    for start in (
        f"joint 'idle' holds nothing: 'anvil' is fixed, 'wheel' is {motion}: at least one",
        f"joint 'weld' holds nothing: 'wheel' is {motion}: at least",
    ):
        assert any(text.startswith(start) for text in texts)
    assert not any(name in text for text in texts for name in ("'useful'", "'ruler'", "'off'"))


def test_loads_on_what_moves_are_silent() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    rod = scene.add_rod(stark.mesh.polyline((1, 0, 0), (1.2, 0, 0), 4), stark.materials.steel_wire)
    solid = scene.add_solid(stark.mesh.tet_box(0.1, 1), stark.materials.soft_rubber, position=(2, 0, 0))
    scene.add_force(box, (0.0, 0.0, 1.0))
    scene.add_torque(box, (0.0, 0.0, 1.0))
    scene.add_force(rod.points(-1, (0.0, 0.0, 0.0)), (0.0, 0.0, 1e-3))
    scene.add_traction(solid.faces[[0]], (0.0, 0.0, 10.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stark.Simulation(scene, time_step=0.01)


def test_scenes_of_documents_are_simulated(tmp_path: Path) -> None:
    """Their formulas have no function of Python."""
    scene = stark.Scene()
    scene.add_force(scene.add_box(0.1, mass=1.0), (0.0, 0.0, 1.0))
    scene.save(tmp_path / "scene.json")
    again = stark.load_scene(tmp_path / "scene.json")
    assert not stark.Simulation(again, time_step=0.01).step().failed


def test_loads_of_documents(tmp_path: Path) -> None:
    """They were silent: a document holds what a load computes, not which function of Stark it was."""
    scene = stark.Scene()
    body = scene.add_box(0.1, mass=1.0, motion="fixed", name="anvil")
    sheet = scene.add_cloth(
        stark.mesh.grid(0.2, 0.2, cells=1), pins=[0, 1, 2, 3], name="sheet", position=(1, 0, 0)
    )
    scene.add_force(body, (0.0, 0.0, 1.0))
    scene.add_torque(body, (0.0, 0.0, 1.0))
    scene.add_traction(sheet, (0.0, 0.0, 10.0))
    scene.add_face_pressure(sheet, 10.0)
    scene.add_force(scene.add_box(0.1, mass=1.0, position=(2, 0, 0)), (0.0, 0.0, 1.0), name="useful")

    @stark.energy(translation_invariant=False)
    def force(p: stark.Point, force: stark.Vec3):
        return -2.0 * stark.dot(force, p.x)

    scene.add(force(body.points((0.0, 0.0, 0.0)), force=(0.0, 0.0, 1.0)), name="of the user")
    scene.save(tmp_path / "scene.json")
    again = stark.load_scene(tmp_path / "scene.json")
    with pytest.warns(stark.StarkWarning) as said:
        stark.Simulation(again, time_step=0.01)
    texts = [str(warning.message) for warning in said]
    for load in ("force 'force'", "torque 'torque'", "traction 'traction'", "face pressure 'face_pressure'"):
        assert any(text.startswith(f"{load} moves nothing: ") for text in texts), load
    assert not any("'useful'" in text or "'of the user'" in text for text in texts)


def test_formulas_of_users_are_their_own_business() -> None:
    @stark.energy
    def force(p: stark.Point, pull: float = stark.parameter(unit="N")):
        return -pull * p.x[2]

    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, motion="fixed")
    scene.add(force(box.points((0.0, 0.0, 0.0)), pull=1.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stark.Simulation(scene, time_step=0.01)
