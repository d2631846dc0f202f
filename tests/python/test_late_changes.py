"""Changes of a scene after a simulation of it was made: they hold in later ones, and the first goes on."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stark


def _scene() -> tuple[stark.Scene, Any, Any]:
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 4), name="sheet", pins=[3, 1])
    cord = scene.add_rod([(0, 0, 2), (0.1, 0, 2), (0.2, 0, 2)], name="cord", clamps=[0])
    return scene, sheet, cord


def test_late_pins_hold_in_later_simulations() -> None:
    scene, sheet, cord = _scene()
    sim = stark.Simulation(scene)
    with pytest.warns(stark.StarkWarning, match="'sheet': pin does not affect the existing simulation"):
        sheet.pin([5])
    with pytest.warns(stark.StarkWarning, match="'cord': clamp does not affect the existing simulation"):
        cord.clamp([2])
    start = sheet.positions
    for body in (sheet, cord):
        body.follow(displacement=lambda t: (0, 0, t), rotation=lambda t: stark.rotation(axis="z", angle=t))
    assert not sim.step().failed
    assert sim[sheet].pins.tolist() == [3, 1] and sheet.pins.tolist() == [3, 1, 5]
    assert sim[cord].clamped.tolist() == [0] and cord.clamped.tolist() == [0, 2]
    assert (sheet.positions[[3, 1], 2] == start[[3, 1], 2] + sim.time).all()
    assert sheet.positions[5, 2] < start[5, 2]
    sheet.pin_targets = sheet.pin_targets
    cord.clamp_targets = cord.clamp_targets
    with pytest.raises(stark.InvalidArgument, match=r"\(3, 3\): must be \(2, 3\).*when the simulation was"):
        sheet.pin_targets = np.zeros((3, 3))

    later = stark.Simulation(scene)
    assert not later.step().failed
    assert later[sheet].pin_targets.shape == (3, 3) and later[cord].clamp_targets.shape == (2, 3, 3)
    assert later[sheet].positions[5, 2] == start[5, 2] + later.time
    assert sim[sheet].pin_targets.shape == (2, 3)


def test_targets_of_late_pins_are_left_out() -> None:
    scene, sheet, _ = _scene()
    sim = stark.Simulation(scene)
    with pytest.warns(stark.StarkWarning):
        sheet.pin([5])
    places = sheet.positions[[3, 1, 5]] + (0.0, 0.0, 0.01)
    sheet.follow(lambda t: places)
    with pytest.warns(stark.StarkWarning, match="its motion is 0.01 m from it"):
        assert not sim.step().failed
    assert (sheet.positions[[3, 1]] == places[:2]).all()


@pytest.mark.parametrize("change", ["pin", "clamp", "surface_direction"])
def test_bodies_of_a_simulation_refuse_changes_of_the_scene(change: str) -> None:
    scene, _, _ = _scene()
    sim = stark.Simulation(scene)
    body = sim["cord" if change == "clamp" else "sheet"]
    with pytest.raises(
        stark.InvalidArgument, match=rf"{change} changes the scene, not the simulation.*sim\.scene"
    ):
        if change == "surface_direction":
            body.surface_direction = (1, 0, 0)
        else:
            getattr(body, change)([2])
    assert scene["sheet"].pins.tolist() == [3, 1] and scene["cord"].clamped.tolist() == [0]


@pytest.mark.parametrize(
    "read",
    [
        lambda sim, late: late.contact_force,
        lambda sim, late: late.velocity,
        lambda sim, late: sim["late"],
        lambda sim, late: sim[late].position,
        lambda sim, late: sim.contact_distance(late),
        lambda sim, late: setattr(late, "position", (0, 0, 1)),
    ],
)
def test_a_late_body_says_so(read: Callable[[Any, Any], Any]) -> None:
    scene, _, _ = _scene()
    sim = stark.Simulation(scene)
    late = scene.add_box(0.1, motion="scripted", name="late", position=(0, 0, 9))
    with pytest.raises(
        stark.InvalidArgument, match=r"'late' was added after.*create a new stark\.Simulation"
    ):
        read(sim, late)
    assert "late" not in sim.contacts.names
    again = stark.Simulation(scene)
    read(again, late)


def test_late_bodies_are_told_by_the_simulation_that_goes_on() -> None:
    scene = stark.Scene("yard")
    scene.add_box(0.1, mass=1.0, name="box")
    sim = stark.Simulation(scene)
    sim.step()
    late = [scene.add_box(0.1, mass=1.0, position=(x, 0, 0), name=f"late_{x}") for x in (1, 2)]
    newer = stark.Simulation(scene)
    newer.step()
    assert late[0].position[2] < 0.0
    with pytest.warns(stark.StarkWarning, match="'yard': 'late_1', 'late_2' was added after the simulation"):
        sim.step()
    sim.step()  # once is enough


def test_a_late_actuator_says_so() -> None:
    scene = stark.Scene()
    wheel = scene.add_box(0.1, mass=1.0, name="wheel")
    axle = scene.add_hinge(wheel, None, anchor=(0, 0, 0), axis=(0, 0, 1))
    sim = stark.Simulation(scene)
    with pytest.warns(stark.StarkWarning, match="actuator 'late' was added after the simulation"):
        late = axle.add_motor(1.0, cap=1.0, delta=0.1, name="late")
    with pytest.raises(stark.InvalidArgument, match=r"actuator 'late' was added after the simulation"):
        _ = late.effort
    del sim


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (lambda scene: scene.friction.__setitem__(("box", "floor"), 0.1), "friction"),
        (lambda scene: scene.friction.__setitem__(("box", "floor"), stark.Anisotropic(0.1, 0.2)), "friction"),
        (lambda scene: scene.restitution.__setitem__(("box", "floor"), 0.5), "restitution"),
        (lambda scene: setattr(scene, "default_friction", 0.1), "default_friction"),
        (lambda scene: scene.disable_contact("box", "floor"), "disable_contact"),
        (lambda scene: scene.enable_contact(["box"], ["floor"]), "enable_contact"),
    ],
)
def test_late_changes_of_pairs_are_told_by_the_simulation_that_goes_on(
    change: Callable[[stark.Scene], None], name: str
) -> None:
    scene = stark.Scene()
    scene.add_floor(1.0)
    scene.add_box(0.1, mass=1.0, position=(0, 0, 0.06), name="box").surface_direction = (1, 0, 0)
    sim = stark.Simulation(scene)
    sim.step()
    change(scene)
    with pytest.warns(stark.StarkWarning, match=f"{name} was changed after .* does not affect it") as told:
        sim.step()
    assert told[0].filename == __file__
    later = stark.Simulation(scene)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.step()  # once is enough
        later.step()  # has it
        scene.add_box(0.1, mass=1.0, position=(1, 0, 0.06), name="late")
        scene.disable_contact("late", "box")  # of a body that no simulation has
    with pytest.warns(stark.StarkWarning, match="'late' was added after") as told:
        later.step()
    assert len(told) == 1  # of the body alone
