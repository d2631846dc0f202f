"""Contacts, pressures and inertial measurement units against statics and kinematics."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import stark

GRAVITY = 9.81


def _tight(**options: object) -> dict[str, object]:
    tolerances = {"newton.residual_tolerance": 1e-8, "newton.termination": "all"}
    return {"time_step": 0.01, **tolerances, **options}


def _resting_box(cells: int = 1) -> stark.Simulation:
    scene = stark.Scene()
    scene.add_rigid(stark.mesh.box((1, 1, 0.1)), name="floor", motion="fixed", position=(0, 0, -0.05))
    box = stark.mesh.box((0.2, 0.1, 0.05), cells)
    scene.add_rigid(box, name="box", mass=2.0, position=(0.01, 0.02, 0.0269))
    sim = stark.Simulation(scene, **_tight())
    sim.run_until(0.5)
    return sim


def test_forces_balance_the_weight() -> None:
    sim = _resting_box()
    weight = 2.0 * GRAVITY
    # What is left of the settling motion is below 1e-4 m/s over a step of 10 ms: 2e-2 N of 19.6 N.
    assert sim["box"].contact_force == pytest.approx([0, 0, weight], abs=2e-2)
    assert sim["floor"].contact_force == pytest.approx(-sim["box"].contact_force, abs=1e-12)
    # Newton's second law holds to the tolerance of the solver.
    assert sim["box"].contact_force[2] == pytest.approx(
        2.0 * (GRAVITY + sim["box"].acceleration(sim["box"].center_of_mass)[2]), abs=1e-7
    )
    assert repr(sim.contacts) == f"<stark.Contacts: {len(sim.contacts)} of floor with box>"
    torque = np.cross(sim["box"].positions - sim["box"].position, sim["box"].contact_forces).sum(axis=0)
    assert torque == pytest.approx([0, 0, 0], abs=1e-2 * weight * 0.1)


def test_torque_of_contact_is_that_of_a_box_pushed_at_its_side() -> None:
    """Newton and Euler: what contact does to a box that slides and turns changes its momenta."""
    scene = stark.Scene()
    scene.default_friction = 0.4
    scene.add_rigid(stark.mesh.box((2, 2, 0.1)), name="floor", motion="fixed", position=(0, 0, -0.05))
    box = scene.add_rigid(
        stark.mesh.box((0.2, 0.1, 0.02)),
        name="box",
        inertia=(2.0, (0.03, 0.0, 0.0), np.diag([2e-3, 7e-3, 8e-3])),
        position=(0, 0, 0.01198),
        angular_velocity=(0, 0, 20.0),
    )
    sim = stark.Simulation(scene, **_tight(time_step=0.002))
    sim.run_until(0.1)
    before, h = box.angular_velocity[2], 0.002
    sim.step()
    assert box.angular_velocity[2] > 1.0
    assert box.contact_torque[2] == pytest.approx(8e-3 * (box.angular_velocity[2] - before) / h, rel=1e-4)
    center = box.position + box.rotation @ box.center_of_mass
    point = np.array([0.3, -0.2, 0.1])
    moved = box.contact_torque + np.cross(center - point, box.contact_force)
    assert box.contact_torque_about(point) == pytest.approx(moved, abs=1e-12)
    # The floor gets the opposite: friction acts on both at one place, not on both sides of the gap.
    assert sim["floor"].contact_torque_about(point) == pytest.approx(-moved, abs=1e-9)
    contacts = box.contacts("floor")
    # Normal forces act at the corners, friction inside the face.
    assert contacts.torque_about(point) == pytest.approx(moved, abs=1e-9)
    arms, inside = contacts.points_a - point, contacts.friction_points - point
    torques = np.cross(arms, contacts.normal_forces) + np.cross(inside, contacts.frictions)
    assert torques.sum(axis=0) == pytest.approx(moved, abs=1e-9)
    with pytest.raises(stark.InvalidArgument, match="contact_torque_about: point"):
        box.contact_torque_about((0, 0))


def _soft(scene: stark.Scene) -> None:
    scene.add_solid(stark.mesh.tet_box(0.1, 2), position=(0, 0, 0.052))


def _sheet(scene: stark.Scene) -> None:
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, 6), pins=[0, 6, 42, 48], position=(0, 0, 0.1))


def _box(scene: stark.Scene) -> None:
    scene.add_box(0.1, mass=1.0, position=(0, 0, 0.051))


@pytest.mark.parametrize("below", [_soft, _sheet, _box])
@pytest.mark.parametrize("speed", [(0.0, 0.0, 0.0), (0.3, 0.2, 0.0)])
def test_torque_of_contact_is_what_turns_a_plate(
    below: Callable[[stark.Scene], None], speed: tuple[float, float, float]
) -> None:
    """A plate that spins comes down on what is soft: h times the torque is the change of its momentum, by
    both readings. Friction between both sides of the gap, 2 mm beside its half height of 10 mm, would be off
    by a fifth. What is left follows from the last refresh of friction, settled to a thousandth."""
    scene = stark.Scene()
    scene.default_friction = 0.6
    scene.add_floor(5.0)
    below(scene)
    plate = scene.add_box(
        (0.08, 0.08, 0.02), mass=0.05, position=(0, 0, 0.125), velocity=speed, angular_velocity=(0, 0, 20)
    )
    sim = stark.Simulation(scene, **_tight(time_step=0.01))
    scale = 0.0
    for _ in range(25):
        before, h = _angular_momentum(plate), 0.01
        report = sim.step()
        torque = (_angular_momentum(plate) - before) / h
        scale = max(scale, float(abs(torque).max()))
        if "old_friction" in report.caveats:
            continue
        assert plate.contact_torque == pytest.approx(torque, abs=2e-3 * scale + 1e-9)
        center = plate.position + plate.rotation @ plate.center_of_mass
        assert plate.contacts().torque_about(center) == pytest.approx(torque, abs=1e-2 * scale + 1e-9)
    assert scale > 0.01


def _angular_momentum(body: stark.RigidBody) -> NDArray[np.float64]:
    local = body.rotation.T @ body.angular_velocity
    found: NDArray[np.float64] = body.rotation @ (body.inertia @ local)
    return found


def test_normals_are_unit_vectors_where_an_impact_gives_back() -> None:
    scene = stark.Scene()
    floor = scene.add_floor(2.0)
    box = scene.add_box(0.1, mass=0.5, position=(0, 0, 0.2), velocity=(0.5, 0, 0), angular_velocity=(0, 2, 1))
    scene.restitution[box, floor] = 0.7
    sim = stark.Simulation(scene, time_step=0.01)
    gave_back = 0
    for report in sim.run(until=0.3):
        gave_back += report.energy["restitution"] > 0.0 and len(sim.contacts) > 0
        assert np.linalg.norm(sim.contacts.normals, axis=1) == pytest.approx(1.0, abs=1e-9)
    assert gave_back > 0


@pytest.mark.parametrize("cells", [1, 4])
def test_pressure_and_area_of_a_flat_face(cells: int) -> None:
    box = _resting_box(cells)["box"]
    assert box.contact_area("floor") == pytest.approx(0.02, rel=1e-9)
    pressure, area = box.contact_pressure(), 0.02
    bottom = box.positions[:, 2] < box.position[2] - 0.02
    assert np.all(pressure[~bottom] == 0.0)
    assert pressure.max() > 0.5 * 2.0 * GRAVITY / area
    forces = np.linalg.norm(box.contact_forces, axis=1)
    assert forces[bottom].sum() == pytest.approx(2.0 * GRAVITY, rel=2e-3)


def test_pressure_inside_a_flat_face_that_hangs_over() -> None:
    """Vertices inside a rigid face carry what is over them; pressures balance the weight about the edge."""
    scene = stark.Scene()
    scene.add_rigid(stark.mesh.box((1, 1, 0.1)), name="table", motion="fixed", position=(-0.5, 0, -0.05))
    mesh = stark.mesh.box((0.2, 0.1, 0.05), 8)
    scene.add_rigid(mesh, name="box", mass=2.0, position=(-0.025 - 1e-6, 0.02, 0.0269))
    sim = stark.Simulation(scene, **_tight())
    sim.run_until(1.5)
    box = sim["box"]
    pressure, x = box.contact_pressure("table"), box.positions
    bottom = x[:, 2] < box.position[2] - 0.02
    over = bottom & (x[:, 0] < 0.0)
    assert np.all(pressure[over] > 0.0)
    assert np.all(
        pressure[bottom & (x[:, 0] > 0.026)] == 0.0
    )  # the edge of the table may press on the column beside it
    # Columns of 25 mm: five of eight lie on the table, the edge of the table a micrometre beside the last.
    assert box.contact_area("table") == pytest.approx(0.02 * 5 / 8, rel=1e-9)
    # The weight is nearer to the edge of the table than the middle of what is over it: more pressure there.
    at = x[:, 0].round(4)
    columns = [pressure[bottom & (at == place)].mean() for place in np.unique(at[over])]
    assert np.all(np.diff(columns) > 0.0) and columns[-1] > 5.0 * columns[0]
    # Between vertices whose neighbours all touch, the edge of the table carries the rest.
    assert box.contact_force[2] == pytest.approx(2.0 * GRAVITY, rel=1e-4)
    torque = np.cross(x - box.position, box.contact_forces).sum(axis=0)
    assert abs(torque).max() < 1e-3 * 2.0 * GRAVITY * 0.1  # friction acts a gap below the vertices


@pytest.mark.parametrize("cells", [(3, 7), (7, 3), (5, 6)])
def test_pressure_between_soft_blocks_whose_meshes_do_not_match(cells: tuple[int, int]) -> None:
    """A plate presses one block on another, uniformly, as Poisson's ratio is zero."""
    rubber = stark.materials.soft_rubber.replace(youngs_modulus=1e5, poissons_ratio=0.0)
    scene = stark.Scene()
    scene.add_rigid(stark.mesh.box((1, 1, 0.1)), name="floor", motion="fixed", position=(0, 0, -0.0501))
    for name, count, z in (("lower", cells[0], 0.0270), ("upper", cells[1], 0.0791)):
        block = stark.mesh.tet_box((0.2, 0.2, 0.05), cells=(count, count, 2))
        scene.add_solid(block, rubber, name=name, position=(0, 0, z))
    scene.add_rigid(stark.mesh.box((0.2, 0.2, 0.02)), name="plate", mass=10.0, position=(0, 0, 0.1162))
    sim = stark.Simulation(scene, time_step=0.01, **{"newton.residual_tolerance": 1e-6})
    sim.run_until(1.2)
    upper, lower = sim["upper"], sim["lower"]
    load = (10.0 + upper.mass) * GRAVITY
    # Friction shares in it where the surfaces between are bent.
    contacts = upper.contacts("lower")
    force = (contacts.normal_forces + contacts.frictions).sum(axis=0)
    assert force == pytest.approx([0, 0, load], abs=1e-4 * load)
    # At each vertex: a vertex and the triangles of the other mesh around it share a force in other parts than
    # the areas around them, by 8 % at most here; meshes that match by 2 %.
    x = upper.positions
    bottom, top = x[:, 2] < x[:, 2].min() + 5e-3, lower.positions[:, 2] > lower.positions[:, 2].max() - 5e-3
    inner = bottom & (np.abs(x[:, :2]).max(axis=1) < 0.085)
    assert upper.contact_pressure("lower")[inner] == pytest.approx(load / 0.04, rel=0.1)
    # The gap is that of the law under this pressure within 3 % of the contact distance, of which their
    # meshes bend by a tenth: their stiffness is a hundred times their weight over half of their surface.
    gap = x[bottom, 2].mean() - lower.positions[top, 2].mean()
    distance = sim.contact_distance("upper") + sim.contact_distance("lower")
    relative = load / 0.04 / (100.0 * upper.mass * 9.80665 / 0.06)
    assert stark.surfaces.relative_pressure(gap / distance - 0.03) > relative
    assert stark.surfaces.relative_pressure(gap / distance + 0.03) < relative


def test_sliding_friction_and_slip() -> None:
    scene = stark.Scene()
    scene.default_friction = 0.3
    scene.add_rigid(stark.mesh.box((4, 1, 0.1)), name="floor", motion="fixed", position=(0, 0, -0.05))
    scene.add_rigid(
        stark.mesh.box((0.1, 0.1, 0.02)), name="block", mass=0.5, position=(0, 0, 0.01198), velocity=(1, 0, 0)
    )
    sim = stark.Simulation(scene, **_tight(time_step=0.002))
    sim.run_until(0.1)
    contacts = sim["block"].contacts("floor")
    normal, friction = contacts.normal_forces.sum(axis=0), contacts.frictions.sum(axis=0)
    assert normal[2] == pytest.approx(0.5 * GRAVITY, rel=1e-3)
    assert friction == pytest.approx([-0.3 * normal[2], 0, 0], abs=1e-3 * normal[2])
    assert contacts.slips[:, 0] == pytest.approx(sim["block"].velocity[0], abs=1e-3)
    assert contacts.normals[:, 2] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_cloth_on_a_sphere_and_a_soft_block(mu: float) -> None:
    scene = stark.Scene()
    scene.default_friction = mu
    scene.add_rigid(stark.mesh.sphere(0.1, 2), name="ball", motion="fixed", position=(0, 0, -0.102))
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, cells=12), stark.materials.cotton, name="cloth")
    soft = stark.mesh.tet_box((0.05, 0.05, 0.05), cells=2)
    scene.add_solid(soft, stark.materials.soft_rubber, name="soft", position=(0, 0, 0.03))
    sim = stark.Simulation(scene, **_tight(contact_distance=1e-3))
    sim.run_until(0.3)
    every = sim.contacts
    assert len(every.of("cloth", "ball")) > 10
    for body in sim.bodies:
        vertex_forces = body.contact_forces
        assert vertex_forces.shape == body.positions.shape
        assert vertex_forces.sum(axis=0) == pytest.approx(body.contact_force, abs=1e-10)
        spread = body.contacts().vertex_forces(len(body.positions))
        if mu == 0.0:
            np.testing.assert_allclose(vertex_forces, spread, atol=1e-12)
        else:
            # Vertices bear the couple, too, that moves friction from both sides of the gap to one place.
            torque = np.cross(body.positions, vertex_forces).sum(axis=0)
            apart = np.cross(body.positions, spread).sum(axis=0)
            told = body.contacts().torque_about((0, 0, 0))
            assert abs(told - torque).max() < 1e-9 < 1e-5 < abs(told - apart).max()
        from_pairs = sum(every.of(body, other).forces.sum(axis=0) for other in sim.bodies if other != body)
        own = every.of(body, body).forces.sum(axis=0)
        assert own == pytest.approx([0, 0, 0], abs=1e-9)
        assert from_pairs == pytest.approx(body.contact_force, abs=1e-9)
    total = sum(body.contact_force for body in sim.bodies)
    assert total == pytest.approx([0, 0, 0], abs=1e-9)
    # Side A and side B of every pair are what the closest points say, whichever way it is read.
    pair = every.of("ball", "cloth")
    for contacts, name in ((pair, "ball"), (every.of("cloth", "ball"), "cloth")):
        x = sim[name].positions
        for k in range(len(contacts)):
            n = contacts.first_counts[k]
            point = contacts.weights[k, :n] @ x[contacts.vertices[k, :n]]
            assert point == pytest.approx(contacts.points_a[k], abs=1e-12)


def test_imu_at_rest_in_free_fall_and_spinning() -> None:
    sim = _resting_box()
    assert sim["box"].imu().specific_force == pytest.approx([0, 0, GRAVITY], abs=1e-2)
    turned = sim["box"].imu(rotation=stark.rotation(axis="x", angle=90 * stark.deg))
    assert turned.specific_force == pytest.approx([0, GRAVITY, 0], abs=1e-2)

    scene = stark.Scene()
    scene.add_rigid(
        stark.mesh.box((0.2, 0.2, 0.05)),
        name="top",
        mass=1.0,
        angular_velocity=(0, 0, 3.0),
        velocity=(1, 2, 0),
    )
    sim = stark.Simulation(scene, time_step=1e-4, **{"time.integrator": "bdf2"})
    sim.run_until(0.05)
    reading = sim["top"].imu((0.1, 0.0, 0.0))
    assert reading.specific_force == pytest.approx([-0.9, 0, 0], abs=1e-3)  # centripetal: w^2 r
    assert reading.angular_velocity == pytest.approx([0, 0, 3.0], abs=1e-6)


def test_nothing_is_known_before_the_first_step_and_names_are_checked() -> None:
    scene = stark.Scene()
    scene.add_rigid(stark.mesh.box((0.1, 0.1, 0.1)), name="box", mass=1.0)
    sim = stark.Simulation(scene)
    assert len(sim.contacts) == 0
    assert np.all(sim["box"].contact_force == 0.0)
    assert np.all(sim["box"].acceleration() == 0.0)
    with pytest.raises(stark.InvalidArgument, match="no body is named 'cup'; there are box"):
        sim.contacts.of("cup")
    sim.step()
    sim.state = sim.state
    assert len(sim.contacts) == 0


def test_a_step_that_failed_shows_no_contact() -> None:
    """docs/sensors.md: the state is that before it, but what acts there was not found."""
    scene = stark.Scene()
    table = scene.add_box((1.0, 1.0, 0.1), motion="fixed")
    block = scene.add_box(0.1, mass=0.1, position=(0, 0, 0.1019))
    press = scene.add_box((0.2, 0.2, 0.1), motion="scripted", position=(0, 0, 0.21))
    sim = stark.Simulation(scene, time_step=0.01, time={"min_step": 0.004})
    sim.run_until(0.3)
    before = sim.state
    assert block.contact_force[2] == pytest.approx(0.1 * 9.81, rel=1e-3)
    press.pose = (0, 0, 0.1), np.eye(3)
    assert sim.step().failed
    assert sim.state.arrays()["body_position"].tolist() == before.arrays()["body_position"].tolist()
    for force in (block.contact_force, table.holding_force, block.acceleration(), sim.contacts.distances):
        assert not np.any(force)


def test_how_far_a_body_can_go() -> None:
    """A box between two plates, 0.2 m and 0.4 m away, and a rod across the way of a sheet."""
    scene = stark.Scene()
    scene.add_box(0.1, name="box", mass=1.0)
    scene.add_box((1.0, 1.0, 0.1), name="below", motion="fixed", position=(0, 0, -0.3))
    scene.add_box((1.0, 1.0, 0.1), name="above", motion="fixed", position=(0, 0, 0.5))
    scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=2), name="cloth", position=(0, 2, 0))
    scene.add_rod(stark.mesh.polyline((-1, 2, 0.5), (1, 2.01, 0.5), 3), name="rod")
    scene.disable_contact("cloth", "rod")
    sim = stark.Simulation(scene, time_step=0.01)
    before = sim.state
    for target, blocking, gap in ((-1.0, "below", 0.2), (1.0, "above", 0.4)):
        path = sim.free_path("box", (0.0, 0.0, target))
        assert path.blocking == blocking
        assert gap - 1e-6 < path.fraction <= gap  # of 1 m
        assert sim.free_path("box", (0.0, 0.0, 0.9 * target * path.fraction)) == (1.0, None)
    path = sim.free_path(sim["cloth"], (0.0, 0.0, 2.0))
    assert path.blocking == "rod" and 0.25 - 1e-6 < path.fraction <= 0.25
    assert sim.free_path("box", (1.0, 0.0, 0.0)) == (1.0, None)
    assert sim.state == before
    with pytest.raises(stark.InvalidArgument, match="free_path: displacement = 1: must be three numbers"):
        sim.free_path("box", 1)


@pytest.mark.parametrize(
    ("integrator", "parts"),
    [("implicit_euler", [0.5, 1.0, 1.0, 1.0, 1.0]), ("bdf2", [0.5, 2.19, 0.5, 1.06, 1.0])],
)
def test_readings_on_a_curve_are_right_after_the_first_steps(integrator: str, parts: list[float]) -> None:
    """A box that starts on a circle: the force of its hinge over m w^2 r, as docs/sensors.md says."""
    scene = stark.Scene()
    box = scene.add_box(
        (0.2, 0.05, 0.05), mass=1.0, position=(0.5, 0, 0), velocity=(0, 2, 0), angular_velocity=(0, 0, 4)
    )
    hinge = scene.add_hinge(None, box, anchor=(0, 0, 0), axis="z")
    sim = stark.Simulation(scene, time_step=1e-3, gravity=(0, 0, 0), time={"integrator": integrator})
    for part in parts:
        sim.step()
        assert -hinge.reaction.force[0] / 8.0 == pytest.approx(part, abs=5e-3)
        assert -box.imu().specific_force[0] / 8.0 == pytest.approx(part, abs=5e-3)
