"""What handles hand out cannot be written into, as that would change nothing; the message says what can be
done, and doing that works. Elsewhere readings are plain arrays and dictionaries."""

from __future__ import annotations

import copy
import json
import pickle
from typing import Any

import numpy as np
import pytest

import stark
from stark.readings import Reading, reading


@pytest.fixture
def sim() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_floor(1.0, name="floor")
    scene.add_box(0.1, mass=0.5, position=(0, 0, 0.1), name="crate")
    scene.add_cloth(stark.mesh.grid(0.2, 0.2, 2), position=(1, 0, 0.5), pins=[0, 1], name="sheet")
    scene.add_rod(stark.mesh.polyline((2, 0, 1), (2.2, 0, 1), 4), clamps=[0, 1], name="wire")
    arm = scene.add_box((0.2, 0.02, 0.02), mass=0.2, position=(0.1, 0.5, 0.5), name="arm")
    elbow = scene.add_hinge(None, arm, anchor=(0, 0.5, 0.5), axis=(0, 1, 0), name="elbow")
    elbow.add_motor(1.0, cap=0.1, delta=0.1, name="motor")
    scene.attach(scene["wire"].vertices[[4]], None, name="glue")
    scene.add_force(scene["crate"], (0, 0, 1.0), name="push")
    sim = stark.Simulation(scene, time_step=0.01)
    sim.step()
    return sim


READ = {
    "crate": ["position", "rotation", "velocity", "angular_velocity", "center_of_mass", "inertia"],
    "floor": ["contact_force", "contact_forces", "positions", "surface_positions"],
    "sheet": ["positions", "velocities", "pins", "pin_targets", "contact_force"],
    "wire": ["positions", "velocities", "frames", "clamped", "clamp_targets"],
}


@pytest.mark.parametrize(("body", "what"), [(body, what) for body, names in READ.items() for what in names])
def test_readings_of_bodies_cannot_be_written_into(sim: stark.Simulation, body: str, what: str) -> None:
    before = sim.state
    with pytest.raises(stark.InvalidArgument, match=f"'{body}': ({what}|positions) is a copy"):
        getattr(sim[body], what)[0] = 3
    with pytest.raises(ValueError, match="read-only"):
        getattr(sim[body], what).fill(3)
    assert sim.state == before


def test_other_readings_cannot_be_written_into(sim: stark.Simulation) -> None:
    joint, motor, glue, push = sim.joints[0], sim.actuators[0], sim.attachments[0], sim.energies[0]
    arrays = [joint.reaction.force, joint.reaction.torque, joint.residuals, glue.forces, glue.force]
    for array in [*arrays, push.energies, push.forces, sim["crate"].pose[0], sim["crate"].pose[1]]:
        with pytest.raises(
            stark.InvalidArgument, match="is a copy, and writing into it would change nothing"
        ):
            array[...] = 1.0
    for readings, remedy in (
        (joint.coordinates, r"write x.coordinates = \{'angle': \.\.\.\}"),
        (joint.rates, r"write x.rates = \{'angle': \.\.\.\}"),
    ):
        with pytest.raises(stark.InvalidArgument, match=f"joint 'elbow': .*{remedy}"):
            readings["angle"] = 1.0
    with pytest.raises(stark.InvalidArgument, match=r"actuator 'motor': parameters .* write x\.target = "):
        motor.parameters["target"] = 3.0


def test_names_that_are_not_there(sim: stark.Simulation) -> None:
    with pytest.raises(KeyError, match=r"joint 'elbow': rates has no 'angel': there is angle"):
        sim.joints[0].rates["angel"]
    with pytest.raises(KeyError, match=r"actuator 'motor': parameters has no 'goal': there is target, "):
        sim.actuators[0].parameters["goal"]
    assert sim.joints[0].rates.get("angel") is None


def test_what_the_message_says_works(sim: stark.Simulation) -> None:
    x = sim["crate"]
    remedy = r"write new = x\.velocity\.copy\(\); new\[2\] = \.\.\.; x\.velocity = new"
    with pytest.raises(stark.InvalidArgument, match=remedy):
        x.velocity[2] = 5.0
    new = x.velocity.copy()
    new[2] = 5.0
    x.velocity = new
    assert x.velocity == pytest.approx([0, 0, 5.0])
    sheet = sim["sheet"]
    with pytest.raises(stark.InvalidArgument, match=r"'sheet': positions .* new\[\.\.\.\] = "):
        sheet.positions[:, 2] += 0.1
    with pytest.raises(stark.InvalidArgument, match="part of a copy"):
        sheet.positions[3][2] = 0.1
    with pytest.raises(stark.InvalidArgument, match=r"scene\.add_force\(body"):
        x.contact_force[2] = 1.0


def test_changes_of_whole_values_are_assigned(sim: stark.Simulation) -> None:
    crate, sheet = sim["crate"], sim["sheet"]
    place, velocity, places = crate.position, crate.velocity, sheet.positions
    crate.position += (0, 0, 0.2)
    crate.velocity -= (0, 0, 1.0)
    crate.velocity *= 2.0
    crate.velocity /= 4.0
    sheet.positions += (0, 0, 0.1)
    sim.joints[0].angle += 0.2
    assert crate.position == pytest.approx(place + np.array((0, 0, 0.2)))
    assert crate.velocity == pytest.approx(0.5 * (velocity - (0, 0, 1.0)))
    assert np.abs(sheet.positions - places - (0, 0, 0.1)).max() < 1e-12
    assert place is not crate.position and place[2] != crate.position[2]  # what was read stays


def test_results_copies_and_files_are_plain(sim: stark.Simulation) -> None:
    velocity = sim["crate"].velocity
    plain = [velocity + 1.0, 2.0 * velocity, velocity @ np.eye(3), np.sqrt(velocity**2), velocity.copy()]
    plain += [np.array(velocity), copy.copy(velocity), copy.deepcopy(velocity), np.stack([velocity] * 2)]
    plain.append(pickle.loads(pickle.dumps(velocity)))
    for array in plain:
        assert type(array) is np.ndarray and array.flags.writeable
    assert type(velocity.sum()) is np.float64 and type(velocity[2]) is np.float64
    assert repr(velocity).startswith("array(") and isinstance(velocity, Reading)
    chosen = velocity[[0, 2]]  # a copy, which nobody else has
    chosen[0] = 7.0
    chosen += 1.0
    assert chosen[0] == 8.0
    angle = sim.joints[0].coordinates
    assert json.loads(json.dumps(angle)) == angle and type(copy.copy(angle)) is dict
    assert type(pickle.loads(pickle.dumps(angle))) is dict


def test_a_reading_says_whose_it_is() -> None:
    class Owner:
        _title = "thing 'a'"

    with pytest.raises(stark.InvalidArgument, match=r"^thing 'a': size is a copy.*: it cannot be set$"):
        reading(np.zeros(3), Owner(), "size")[1] = 2.0
    with pytest.raises(stark.InvalidArgument, match=r"do that instead$"):
        reading(np.zeros(3), Owner(), "size", assign="do that instead")[1] = 2.0


def test_the_mesh_of_a_body_is_its_own() -> None:
    """Writing into the mesh that a body was made from would change what formulas take for its rest shape."""
    scene, mesh = stark.Scene(), stark.mesh.grid(1.0, 1.0, 2)
    sheet = scene.add_cloth(mesh, name="sheet")
    rest: Any = sheet.vertices.rest_positions
    mesh.vertices[:, 2] += 1.0
    assert np.array_equal(sheet.vertices.rest_positions, rest) and sheet.mesh.vertices[:, 2].max() == 0.0
    with pytest.raises(ValueError, match="read-only"):
        sheet.mesh.vertices[0] = 1.0
    assert scene.add_cloth(mesh).mesh.vertices[:, 2].min() == 1.0


def test_readings_of_contact_before_a_step() -> None:
    """docs/sensors.md: zero before the first step and after a reset; none, of any body, after placing."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    box, other = (scene.add_box(0.1, mass=1.0, position=(x, 0, 0.0518)) for x in (0.0, 0.3))
    arm = scene.add_box(0.1, mass=1.0, position=(0, 0.3, 1))
    hinge = scene.add_hinge(None, arm, anchor=(0, 0.2, 1), axis="x")
    motor = hinge.add_motor(1.0, cap=1.0, delta=0.1)
    sim = stark.Simulation(scene, time_step=0.01)

    def is_zero() -> bool:
        forces = [box.contact_force, other.contact_force, hinge.reaction.force, hinge.reaction.torque]
        return not np.any(np.concatenate(forces)) and motor.effort == 0.0 and not len(sim.contacts)

    assert is_zero()
    sim.run_until(0.3)
    assert abs(box.contact_force[2] - 9.81) < 0.1 and np.any(hinge.reaction.force)
    for placing in ({"position": (0, 0, 0.3)}, {"velocity": (0, 0, 1)}):
        sim.step()
        assert len(sim.contacts)
        for name, value in placing.items():
            setattr(box, name, value)
        assert not len(sim.contacts) and not other.contact_force.any() and other.contact_area() == 0.0
    sim.reset()
    assert is_zero()
