"""Sensors of bodies: columns of contacts and what is made of them, resting weights, inertial units."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import stark
from stark.bodies.sensors import Contacts, _surrounded

G = 9.81


def pair() -> Contacts:
    """A vertex of the first body on an edge of the second one, and two vertices on one another."""
    return Contacts(
        names=("a", "b", "c"),
        bodies=np.array([[0, 1], [1, 2]], dtype=np.int32),
        vertices=np.array([[4, 7, 8, -1], [5, 6, -1, -1]], dtype=np.int32),
        weights=np.array([[1.0, -0.25, -0.75, 0.0], [1.0, -1.0, 0.0, 0.0]]),
        first_counts=np.array([1, 1], dtype=np.int32),
        distances=np.array([0.5, 0.25]),
        points_a=np.array([[0.0, 0.0, 0.5], [1.0, 0.0, 0.25]]),
        points_b=np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        normal_forces=np.array([[0.0, 0.0, 8.0], [0.0, 0.0, 2.0]]),
        frictions=np.array([[1.0, 0.0, 0.0], [0.0, -0.5, 0.0]]),
        slips=np.array([[-0.1, 0.0, 0.0], [0.0, 0.2, 0.0]]),
        friction_points=np.array([[0.0, 0.25, 0.5], [1.0, 0.0, 0.25]]),
        friction_points_b=np.array([[0.0, 0.25, 0.5], [1.0, 0.0, 0.0]]),
    )


def test_normals_and_forces_are_those_of_the_columns() -> None:
    contacts = pair()
    assert contacts.normals.tolist() == [[0, 0, 1], [0, 0, 1]]
    assert contacts.forces.tolist() == [[1, 0, 8], [0, -0.5, 2]]


def test_contacts_of_the_second_body_are_turned() -> None:
    turned = pair().of("b", "a")
    assert len(turned) == 1 and turned.bodies.tolist() == [[1, 0]]
    assert turned.vertices.tolist() == [[7, 8, 4, -1]] and turned.first_counts.tolist() == [2]
    assert turned.weights.tolist() == [[0.25, 0.75, -1.0, 0.0]]
    assert turned.forces.tolist() == [[-1, 0, -8]] and turned.normals.tolist() == [[0, 0, -1]]
    # Friction of two edges that deform acts on each at its own place.
    assert pair().of("c").friction_points.tolist() == [[1, 0, 0]]
    # Shares of the force on the edge, and nothing elsewhere.
    spread = turned.vertex_forces(9)
    assert spread[7].tolist() == [-0.25, 0, -2] and spread[8].tolist() == [-0.75, 0, -6]
    assert np.abs(np.delete(spread, [7, 8], axis=0)).max() == 0.0


def test_contacts_of_a_body_are_those_of_both_sides() -> None:
    assert pair().of("b").bodies.tolist() == [[1, 2], [1, 0]]
    assert len(pair().of("a", "c")) == 0
    with pytest.raises(stark.InvalidArgument, match="no body is named 'd'; there are a, b, c"):
        pair().of("d")
    with pytest.raises(stark.InvalidArgument, match="no body is named 3; there are a, b, c"):
        pair().of(3)  # type: ignore[arg-type]


def test_points_are_surrounded_by_a_hull_and_not_by_a_line() -> None:
    corners = np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
    points = np.array([[0.0, 0, 0], [0.9, 0.9, 0], [1.5, 0, 0]])
    up = np.array([0.0, 0, 1])
    assert _surrounded(points, corners, up).tolist() == [True, True, False]
    assert _surrounded(points, corners[:2], up).tolist() == [False, False, False]


@pytest.fixture(scope="module")
def resting() -> stark.Simulation:
    """A box of 2 kg that lies on a floor."""
    scene = stark.Scene()
    scene.add_box((1.0, 1.0, 0.1), motion="fixed", name="floor")
    scene.add_box(0.1, mass=2.0, position=(0, 0, 0.1005), name="box")
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=0.001)
    sim.run_until(0.5)
    return sim


def test_a_resting_box_is_carried_with_its_weight(resting: stark.Simulation) -> None:
    box, floor = resting["box"], resting["floor"]
    assert box.contact_force == pytest.approx([0, 0, 2.0 * G], abs=0.02)
    # Action and reaction are the same numbers.
    assert floor.contact_force.tolist() == (-box.contact_force).tolist()
    assert box.contact_forces.sum(axis=0) == pytest.approx(box.contact_force, abs=1e-10)
    assert box.contact_area("floor") == pytest.approx(0.01, rel=1e-12)
    assert len(box.contacts("floor")) == len(box.contacts()) > 0
    # A quarter of the weight on each corner, over a third of its one or two triangles [Pa].
    pressure = np.sort(box.contact_pressure()[box.contact_pressure() > 0])
    quarter, triangle = 0.5 * G, 0.5 * 0.01
    expected = [quarter / (2 * triangle / 3)] * 2 + [quarter / (triangle / 3)] * 2
    assert pressure == pytest.approx(expected, rel=0.01)


def test_an_inertial_unit_at_rest_points_up(resting: stark.Simulation) -> None:
    reading = resting["box"].imu()
    assert reading.specific_force == pytest.approx([0, 0, G], abs=0.01)
    assert np.abs(reading.angular_velocity).max() < 1e-3
    turned = resting["box"].imu(rotation=stark.rotation(axis="x", angle=90 * stark.deg))
    assert turned.specific_force == pytest.approx([0, G, 0], abs=0.01)


def test_a_falling_unit_feels_nothing_and_one_off_centre_feels_the_spin() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, angular_velocity=(0, 0, 2.0), name="box")
    sim = stark.Simulation(scene, time_step=1e-3)
    sim.step()
    assert np.abs(sim["box"].imu().specific_force).max() < 1e-6
    # Towards the centre with w^2 r, but for the turn of 2e-3 rad within the step.
    off_centre = sim["box"].imu((0.05, 0, 0))
    assert off_centre.specific_force == pytest.approx([-4.0 * 0.05, 0, 0], abs=1e-3)
    assert off_centre.angular_velocity == pytest.approx([0, 0, 2.0], abs=1e-6)


def test_before_the_first_step_nothing_touches() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    with pytest.raises(stark.InvalidArgument, match="contacts"):
        box.contacts()
    sim = stark.Simulation(scene)
    assert len(sim["box"].contacts()) == 0 and sim["box"].contact_force.tolist() == [0, 0, 0]


def test_contacts_with_a_body_of_another_scene_are_refused() -> None:
    """Its name stood for the body of this scene that has the same one, or for none."""
    scene, other = stark.Scene(), stark.Scene()
    for each in (scene, other):
        each.add_floor()
        each.add_box(0.1, mass=1.0, position=(0, 0, 0.0505), name="box")
    sim = stark.Simulation(scene)
    sim.run_until(0.1)
    assert scene["box"].contact_area(scene["floor"]) == pytest.approx(0.01)
    assert len(pickle.loads(pickle.dumps(sim.contacts)).of("box", "floor")) == len(sim.contacts)
    for read in (
        lambda: sim.contacts.of(other["box"]),
        lambda: sim.contacts.of("box", other["floor"]),
        lambda: scene["box"].contact_area(other["floor"]),
        lambda: scene["box"].contacts().of("box", other["floor"]),
    ):
        with pytest.raises(stark.InvalidArgument, match="belongs to another scene: must be a body of this"):
            read()


def test_contacts_from_either_side_and_names_found_once() -> None:
    scene = stark.Scene()
    scene.add_floor(2.0, name="floor")
    for k in range(3):
        scene.add_box(0.1, mass=0.5, position=(0.3 * k, 0, 0.0502), name=f"box {k}")
    sim = stark.Simulation(scene)
    sim.step()
    contacts = sim.contacts
    assert sim.contacts.names is contacts.names == ("floor", "box 0", "box 1", "box 2")
    for k in range(3):
        above, below = contacts.of(f"box {k}", "floor"), contacts.of("floor", f"box {k}")
        assert len(above) == len(below) == 4 == len(contacts.of(f"box {k}"))
        assert (above.bodies == (k + 1, 0)).all() and (below.bodies == (0, k + 1)).all()
        assert np.array_equal(above.forces, -below.forces) and (above.forces[:, 2] > 0.0).all()
        assert np.array_equal(above.points_a, below.points_b)
    assert len(contacts.of("box 0", "box 1")) == 0 and len(contacts.of("floor")) == 12
