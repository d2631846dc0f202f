"""Bodies that are placed between steps: through handles of bodies, of deformable ones and of joints."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import stark


def on_the_floor(**settings: object) -> tuple[stark.Simulation, stark.RigidBody, stark.RigidBody]:
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_floor(1.0)
    a = scene.add_box(0.1, mass=0.5, position=(0, 0, 0.0505), name="a")
    b = scene.add_box(0.1, mass=0.5, position=(0.3, 0, 0.0505), name="b")
    sim = stark.Simulation(scene, time_step=0.01, threads=1, **settings)
    advance(sim, 5)
    return sim, a, b


def advance(sim: stark.Simulation, steps: int) -> None:
    for _ in range(steps):
        report = sim.step()
        assert not report.failed, report.message


def test_a_body_is_where_it_is_placed_and_as_fast_as_it_is_pushed() -> None:
    sim, a, _ = on_the_floor()
    turned = stark.rotation(axis="x", angle=0.4)
    a.position = (0.0, 0.2, 0.5)
    a.rotation = turned
    a.velocity = (0.0, 0.0, 1.0)
    a.angular_velocity = (0.0, 3.0, 0.0)
    np.testing.assert_array_equal(a.position, (0.0, 0.2, 0.5))
    np.testing.assert_allclose(a.rotation, turned, atol=1e-15)
    np.testing.assert_array_equal(a.velocity, (0.0, 0.0, 1.0))
    np.testing.assert_array_equal(a.angular_velocity, (0.0, 3.0, 0.0))
    report = sim.step()
    assert report.placed == [1] and report.to_dict()["placed"] == [1]
    assert report.energy["placed"] == pytest.approx(0.5 * 9.81 * 0.45 + 0.25, rel=0.01)
    assert a.velocity[2] == pytest.approx(1.0 - 9.81 * 0.01, rel=1e-9)
    assert sim.step().placed == []


def test_scripted_bodies_head_for_what_dynamic_ones_have_at_once() -> None:
    scene = stark.Scene()
    plate = scene.add_box(0.1, motion="scripted", name="plate")
    sim = stark.Simulation(scene, time_step=0.01)
    plate.position = (0.0, 0.0, 0.01)
    assert plate.position[2] == 0.0 and len(sim.step().placed) == 0
    assert plate.position[2] == 0.01


Assignment = Callable[[stark.Simulation, stark.RigidBody], None]


def assign(name: str, value: object) -> Assignment:
    return lambda sim, body: setattr(body, name, value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (assign("position", (0.31, 0, 0.08)), "'a' and 'b' intersect as placed"),
        (assign("position", (0.0, 0, 0.0)), "'a'.* intersect as placed"),
        (assign("position", (0, 0)), "must be three numbers"),
        (assign("velocity", (0, 0, np.inf)), "must be finite"),
        (assign("rotation", np.zeros((3, 3))), "rotation"),
        (lambda sim, body: setattr(sim["floor"], "position", (0, 0, 1)), "'floor' is fixed"),
    ],
)
def test_what_is_refused_changes_nothing(change: Assignment, message: str) -> None:
    sim, a, _ = on_the_floor()
    before, force = sim.state, a.contact_force
    with pytest.raises(stark.InvalidArgument, match=message):
        change(sim, a)
    assert sim.state == before
    np.testing.assert_array_equal(a.contact_force, force)
    assert len(sim.step().placed) == 0


def test_bodies_are_placed_together() -> None:
    sim, a, b = on_the_floor()
    first, second = a.pose, b.pose
    with sim.placing():
        a.pose, b.pose = second, first
        np.testing.assert_array_equal(a.position, second[0])
    np.testing.assert_array_equal(b.position, first[0])
    before = sim.state
    with pytest.raises(stark.InitialIntersection, match="'a' and 'b'"), sim.placing():
        a.position, b.velocity = b.position + 0.02, (1, 0, 0)
    assert sim.state == before
    with pytest.raises(ZeroDivisionError), sim.placing():
        a.position = (5, 5, 5)
        _ = 1 / 0
    assert sim.state == before
    with pytest.raises(stark.InvalidArgument, match="while bodies are placed together"), sim.placing():
        sim.step()
    with pytest.raises(stark.CheckpointError, match="after the block of sim"), sim.placing():
        sim.save("nowhere.stark")
    assert sim.state == before


def test_sensors_read_nothing_of_a_step_before_the_placing() -> None:
    sim, a, _ = on_the_floor()
    assert a.contact_force[2] > 1.0
    a.position = a.position + np.array([0, 0, 0.2])
    assert not a.contact_force.any() and len(sim.contacts) == 0 and not a.acceleration().any()


def test_a_body_placed_within_its_contact_distance_is_not_thrown_apart() -> None:
    sim, a, _ = on_the_floor()
    a.position = (0.0, 0.3, 0.0501)
    advance(sim, 20)
    assert abs(a.position[2] - 0.0501) < 1e-4 and np.abs(a.velocity).max() < 1e-3


def test_vertices_of_a_cloth_are_placed_pins_too() -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 4), name="cloth")
    cloth.pin([0, 4])
    sim = stark.Simulation(scene, time_step=0.01)
    start, up = cloth.positions, np.array([0, 0, 1])
    advance(sim, 10)
    cloth.positions = start + up
    cloth.velocities = (0, 0, 0)
    np.testing.assert_array_equal(cloth.positions, start + up)
    assert not cloth.velocities.any()
    report = sim.step()
    np.testing.assert_array_equal(cloth.positions[[0, 4]], start[[0, 4]] + up)
    assert report.energy["placed"] > 9.81 * cloth.mass * 0.7  # what was not pinned was lifted by a metre
    with pytest.raises(stark.InvalidArgument, match=r"must be \(25, 3\)"):
        cloth.positions = start[:3]
    folded = start.copy()
    folded[:, 0] = np.abs(folded[:, 0])
    with pytest.raises(stark.InitialIntersection, match="'cloth' intersects itself as placed at "):
        cloth.positions = folded


def test_the_shape_of_a_rod_is_not_placed() -> None:
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (1, 0, 0), 5), name="rod")
    sim = stark.Simulation(scene, time_step=0.01)
    with pytest.raises(stark.InvalidArgument, match="'rod': positions of a rod cannot be placed"):
        rod.positions = rod.positions + 1.0
    rod.velocities = (0, 0, 1)
    np.testing.assert_array_equal(rod.velocities, np.tile((0.0, 0.0, 1.0), (6, 1)))
    advance(sim, 1)


def an_arm(**settings: object) -> tuple[stark.Simulation, list[stark.Joint], list[stark.RigidBody]]:
    """An upper arm on a turning, tilting shoulder, a forearm that slides out, and a scarf tied to it."""
    scene = stark.Scene()
    upper = scene.add_box((0.2, 0.02, 0.02), mass=0.2, position=(0.1, 0, 1), name="upper")
    fore = scene.add_box((0.2, 0.02, 0.02), mass=0.1, position=(0.32, 0, 1), name="fore")
    scarf = scene.add_cloth(stark.mesh.grid(0.05, 0.05, 2), position=(0.45, 0, 1.0), name="scarf")
    shoulder = scene.add_joint("universal", None, upper, anchor=(0, 0, 1), name="shoulder")
    slide = scene.add_slider(upper, fore, anchor=(0.2, 0, 1), axis=(1, 0, 0), name="slide")
    scene.attach(scarf.vertices[[0, 1, 2]], fore.points(scarf.positions[[0, 1, 2]] - (0.32, 0, 1)))
    sim = stark.Simulation(scene, time_step=0.005, **settings)
    return sim, [shoulder, slide], [upper, fore]


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_coordinates_of_joints_are_placed(integrator: str) -> None:
    sim, (shoulder, slide), (_, fore) = an_arm(**{"time.integrator": integrator})
    advance(sim, 10)
    rates, first = {**shoulder.rates}, next(iter(shoulder.coordinates))
    reach = np.linalg.norm(fore.position - (0, 0, 1))
    shoulder.coordinates = {first: 0.6}
    assert shoulder.coordinates[first] == pytest.approx(0.6, abs=1e-9)
    for name, rate in rates.items():
        assert shoulder.rates[name] == pytest.approx(rate, abs=1e-6)
    assert np.linalg.norm(fore.position - (0, 0, 1)) == pytest.approx(reach, rel=1e-6)
    slide.displacement = 0.05
    slide.rates = {"displacement": -0.2}
    assert slide.displacement == pytest.approx(0.05) and slide.rates["displacement"] == pytest.approx(-0.2)
    for joint in (shoulder, slide):
        assert np.abs(joint.residuals).max() < 1e-6
    before = slide.displacement
    report = sim.step()
    assert not report.failed and {sim.bodies[k].name for k in report.placed} == {"upper", "fore", "scarf"}
    assert slide.displacement == pytest.approx(before - 0.2 * 0.005, abs=5e-4)


def test_what_is_no_coordinate_is_refused() -> None:
    sim, (_, slide), (_, fore) = an_arm()
    before = sim.state
    for wrong, message in (
        (lambda: setattr(slide, "coordinates", {"angle": 1.0}), "must be one of displacement"),
        (lambda: setattr(slide, "coordinates", 3.0), "must be numbers by name: displacement"),
        (lambda: setattr(slide, "displacement", "far"), "must be a number"),
        (lambda: setattr(slide, "displacement", np.nan), "must be finite"),
        (lambda: setattr(fore, "position", (0, 0, 5)), "is apart by .* where bodies are placed"),
    ):
        with pytest.raises(stark.InvalidArgument, match=message):
            wrong()
    with pytest.raises(AttributeError, match="displacement, coordinates, rates and enabled"):
        slide.angle = 1.0  # type: ignore[attr-defined]
    assert sim.state == before


def test_a_refused_placing_leaves_sensors_and_the_steps_after_it_as_they_were() -> None:
    found = []
    for refused in (False, True):
        sim, (shoulder, slide), (upper, fore) = an_arm(**{"time.integrator": "bdf2"})
        advance(sim, 10)
        if refused:
            for body in (fore, upper):
                with pytest.raises(stark.InvalidArgument, match="is apart by"):
                    body.position = (0, 0, 5)
        readings = [fore.acceleration(), fore.imu()[0], *slide.reaction, *shoulder.reaction]
        advance(sim, 3)
        found.append((sim.state.hash, np.concatenate(readings).tobytes()))
    assert found[0] == found[1]


def test_limits_and_gears_hold_where_joints_are_placed() -> None:
    scene = stark.Scene()
    wheels = [scene.add_box(0.1, mass=0.1, position=(x, 0, 0), name=f"wheel{x}") for x in (0, 1)]
    first, second = (scene.add_hinge(None, wheel, anchor=wheel.position, axis=(0, 0, 1)) for wheel in wheels)
    first.add_limit(-1.0, 1.0, name="stop")
    first.add_gear(second, 2.0, name="gear")
    sim = stark.Simulation(scene, time_step=0.01)
    with pytest.raises(stark.InvalidArgument, match=r"actuator 'gear' is off by 0\.5 rad where bodies"):
        first.angle = 0.5
    with pytest.raises(stark.InvalidArgument, match=r"actuator 'stop' is off by 0\.5 rad"), sim.placing():
        first.angle, second.angle = 1.5, 0.75
    with sim.placing():
        first.angle, second.angle = 0.5, 0.25
    advance(sim, 2)
    assert first.angle == pytest.approx(0.5, abs=1e-4)


def loop(seed: int, resets: int, threads: int = 1) -> list[str]:
    """Hashes of a loop that starts somewhere else each time, as learning from a simulation does."""
    scene = stark.Scene()
    scene.default_friction = 0.3
    scene.add_floor(1.0)
    box = scene.add_box(0.1, mass=0.5, position=(0, 0, 0.0505), name="box")
    arm = scene.add_box((0.2, 0.02, 0.02), mass=0.1, position=(0, 0.6, 0.3), name="arm")
    hinge = scene.add_hinge(None, arm, anchor=(0, 0.6, 0.3), axis=(0, 0, 1))
    settings = {"execution.threads": threads, "execution.oversubscribe": True}
    sim = stark.Simulation(scene, time_step=0.01, **settings)
    random, found = np.random.default_rng(seed), []
    for _ in range(resets):
        sim.reset()
        with sim.placing():
            box.position = (*random.uniform(-0.3, 0.3, 2), random.uniform(0.06, 0.2))
            box.rotation = stark.rotation(axis="z", angle=random.uniform(-3, 3))
            box.velocity = random.normal(size=3)
            hinge.angle = random.uniform(-3, 3)
            hinge.rates = {"angle": random.normal()}
        advance(sim, 2)
        found.append(sim.state.hash)
    return found


def test_two_hundred_random_starts_have_the_same_bits() -> None:
    found = loop(3, 200)
    assert len(set(found)) == 200
    assert loop(3, 200, threads=2) == found
    assert loop(4, 5) != found[:5]


def test_the_pole_of_the_example_is_balanced(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(Path(__file__).parents[3] / "examples/random_starts.py"))["main"]()
    assert "trial 19" in capsys.readouterr().out


def test_a_saved_start_goes_on_with_the_same_bits(tmp_path: object) -> None:
    sim, a, _ = on_the_floor(**{"time.integrator": "bdf2"})
    a.position, a.velocity = (0, 0.2, 0.3), (0, 0, 1)
    sim.save(f"{tmp_path}/placed.stark")
    placed = sim.state
    advance(sim, 3)
    end = sim.state.hash
    sim.load(f"{tmp_path}/placed.stark")
    assert sim.state == placed
    advance(sim, 3)
    assert sim.state.hash == end


def test_what_is_set_to_what_it_is_goes_on_as_it_was() -> None:
    """A box that stands still by friction alone, and is put where it stands, does not begin to creep anew."""
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_floor(2.0)
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.0505), velocity=(0.5, 0, 0))
    sheet = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 3), position=(0.5, 0, 0.05))
    door = scene.add_box(0.1, mass=1.0, position=(0, -0.5, 0.5), angular_velocity=(0, 0, 1))
    hinge = scene.add_hinge(None, door, anchor=(0, -0.5, 0.5), axis=(0, 0, 1))
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.1)
    before, contacts = sim.state, len(sim.contacts)
    assert contacts > 0
    box.position, box.rotation, box.velocity = box.position, box.rotation, box.velocity
    box.pose, box.angular_velocity = box.pose, box.angular_velocity
    sheet.positions, sheet.velocities = sheet.positions, sheet.velocities
    hinge.angle, hinge.rates = hinge.angle, hinge.rates
    with sim.placing():
        box.pose = box.pose
    assert sim.state == before and len(sim.contacts) == contacts
    report = sim.step()
    assert report.placed == [] and report.energy["placed"] == 0.0
    box.position += np.array([0, 0, 1e-9])
    assert sim.step().placed == [1]
