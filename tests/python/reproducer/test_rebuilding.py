"""Scenes that are built again from the record of their calls."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import stark
from stark import reproducer
from stark.reproducer import rebuilding
from stark.scene_record import RecordedScene


def everything() -> stark.Scene:
    """One of each kind of body and of what connects them."""
    scene = stark.Scene("everything")
    scene.default_friction = 0.3
    table = scene.add_box((2.0, 2.0, 0.1), motion="fixed", name="table", color=(0.5, 0.5, 0.5))
    sheet = scene.add_cloth(
        stark.mesh.grid(0.3, 0.3, 4),
        stark.materials.membrane_st_venant_kirchhoff(
            density=0.2, thickness=1e-3, youngs_modulus=np.linspace(4e3, 6e3, 32), poissons_ratio=0.3
        ),
        position=(0, 0, 0.06),
        name="sheet",
        pins=[0],
        friction=0.7,
    )
    cube = scene.add_solid(
        stark.mesh.tet_box(0.1, 2), position=(0.5, 0, 0.11), name="cube", velocity=(0, 0, -1)
    )
    quadratic = stark.mesh.to_quadratic(stark.mesh.tet_box(0.1, 1))
    scene.add_solid(
        quadratic,
        stark.materials.neo_hookean(density=900.0, youngs_modulus=1e5, poissons_ratio=0.3),
        position=(0.8, 0, 0.11),
        name="block",
    )
    cord = scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.3, 0, 0), 6), position=(-0.5, 0, 0.2), name="cord")
    cord.clamp([0])
    box = scene.add_box(0.1, mass=1.0, position=(0, 0.5, 0.12), name="box")
    hand = scene.add_box(0.1, motion="scripted", position=(0, 0.7, 0.12), name="hand")
    hinge = scene.add_hinge(hand, box, anchor=(0, 0.6, 0.12), axis=(1, 0, 0), name="elbow")
    motor = hinge.add_motor(target=1.0, cap=0.1, delta=1.0)
    motor.target = 2.0
    cube.add_skin(stark.materials.pet, name="film")
    cube.add_fibres(stark.materials.rubber_cord, paths=[[0, 1, 2]], name="threads")
    scene.attach(
        sheet.vertices[[24]], scene.add_box(0.02, mass=0.01, position=(0.15, 0.15, 0.08), name="weight")
    )
    scene.friction[box, table] = 0.5, 0.4
    scene.disable_contact(hand, table)
    return scene


def test_scenes_of_all_kinds_of_parts_go_on_with_the_same_bits(tmp_path: Path) -> None:
    sim = stark.Simulation(everything(), time_step=0.005, contact_distance=1e-3)
    for _ in range(3):
        assert not sim.step().failed
    sim.step()
    sim.write_reproducer(tmp_path)
    after = sim.state
    again = reproducer.load(tmp_path)
    assert again.state.step_count == 3
    assert not again.step().failed
    assert again.state == after
    assert [body.name for body in again.bodies] == [body.name for body in sim.bodies]
    for ours, theirs in zip(sim.bodies, again.bodies, strict=True):
        np.testing.assert_array_equal(ours.positions, theirs.positions)
    assert again._parts == sim._parts


def test_every_recorded_call_can_be_repeated() -> None:
    recorded = {
        call
        for call in vars(RecordedScene)
        if call.startswith(("add_", "set_", "pin", "clamp", "disable_", "enable_"))
    }
    assert recorded | {"default_friction"} == rebuilding._CALLS
