"""Flat faces of rigid bodies: the torque of friction is that of an even pressure."""

from __future__ import annotations

import numpy as np
import pytest

import stark

_MU, _MASS, _G, _SIDE, _RADIUS = 0.3, 0.2, 9.81, 0.1, 0.05


def lever(mesh: stark.TriangleMesh) -> float:
    """Torque of friction on what spins on a floor, over mu m g: the mean distance from the axis [m]."""
    scene = stark.Scene()
    scene.default_friction = _MU
    scene.add_floor(2.0)
    body = scene.add_rigid(mesh, mass=_MASS, position=(0, 0, 0.0056), angular_velocity=(0.0, 0.0, 20.0))
    sim = stark.Simulation(scene, time_step=0.005, contact_distance=3e-4)
    sim.run_until(0.025)
    start = body.angular_velocity[2]
    sim.run_until(0.125)
    slowing = (start - body.angular_velocity[2]) / 0.1
    return float(slowing * np.asarray(body.inertia)[2, 2] / (_MU * _MASS * _G))


# Mean distance from the centre of a square over its side: (sqrt(2) + ln(1 + sqrt(2))) / 6.
_SQUARE = (np.sqrt(2.0) + np.arcsinh(1.0)) / 6.0


@pytest.mark.parametrize(("cells", "error"), [(4, 0.04), (8, 0.012), (16, 0.004)])
def test_a_spinning_plate_meets_the_torque_of_an_even_pressure(cells: int, error: float) -> None:
    found = lever(stark.mesh.box((_SIDE, _SIDE, 0.01), cells)) / (_SQUARE * _SIDE)
    assert 1.0 <= found < 1.0 + error


@pytest.mark.parametrize("cells", [2, 3])
def test_a_few_vertices_inside_a_face_do_not_change_its_torque(cells: int) -> None:
    """They are left out. Carrying their part of the pressure, one in the middle made it 11 % too large."""
    assert lever(stark.mesh.box((_SIDE, _SIDE, 0.01), cells)) == pytest.approx(_SQUARE * _SIDE, rel=2e-3)


def test_so_does_a_disc() -> None:
    found = lever(stark.mesh.cylinder(_RADIUS, 0.01, 64))
    assert found == pytest.approx(2.0 / 3.0 * _RADIUS, rel=5e-3)


def test_a_disc_that_spins_and_slides_comes_to_the_end_of_both_together() -> None:
    """Of an even pressure it slides on with 0.26 m/s after 0.3 s; with a vertex in the middle of its ends,
    which does not turn, it did with 0.14 m/s and spun on when it had stopped."""
    scene = stark.Scene()
    scene.default_friction = 0.3
    scene.add_floor()
    disc = scene.add_cylinder(
        0.1, 0.02, mass=1.0, position=(0, 0, 0.0102), velocity=(0.5, 0, 0), angular_velocity=(0, 0, 20)
    )
    sim = stark.Simulation(scene, time_step=0.002)
    sim.run_until(0.3)
    assert 0.26 < disc.velocity[0] < 0.31
    sim.run_until(0.53)
    speed = np.array([disc.velocity[0], 0.1 * disc.angular_velocity[2]])
    assert (speed < 0.12).all()
    sim.run_until(0.6)
    assert abs(disc.velocity[0]) < 1e-3 and abs(disc.angular_velocity[2]) < 1e-2


@pytest.mark.parametrize("size", [(_SIDE, _SIDE, 0.01), (0.12, 0.06, 0.01)])
def test_corners_have_the_lever_of_the_pressure_that_they_carry(size: tuple[float, float, float]) -> None:
    """A plain box, as docs/friction.md says: without it, the square met 1.85 times the torque."""
    x, y = (np.arange(400) + 0.5)[:, None] / 400 - 0.5, (np.arange(400) + 0.5) / 400 - 0.5
    even = float(np.hypot(size[0] * x, size[1] * y).mean())
    assert lever(stark.mesh.box(size)) == pytest.approx(even, rel=0.02)


def test_a_prism_on_its_end_has_it_too() -> None:
    """Six corners: in polar coordinates the mean distance is 2 (1/3 + ln(3)/4) / sqrt(3) times that of the
    sides."""
    angles = np.arange(6) * np.pi / 3
    ring = _RADIUS * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    low, high = (np.column_stack([ring, np.full(6, z)]) for z in (-0.005, 0.005))
    ends = [(0, k, k + 1) for k in range(1, 5)]
    sides = [t for k in range(6) for t in ((k, (k + 1) % 6, 6 + k), ((k + 1) % 6, 6 + (k + 1) % 6, 6 + k))]
    triangles = [(a, c, b) for a, b, c in ends] + [(a + 6, b + 6, c + 6) for a, b, c in ends] + sides
    even = np.sqrt(0.75) * _RADIUS * 2.0 / np.sqrt(3.0) * (1.0 / 3.0 + 0.25 * np.log(3.0))
    found = lever(stark.mesh.TriangleMesh(np.vstack([low, high]), np.array(triangles)))
    assert found == pytest.approx(even, rel=0.02)


def test_a_box_that_is_pushed_beside_its_middle_turns_as_one_of_even_pressure() -> None:
    """Slowly, by a ball without friction 30 mm beside the middle: 22.0 rad per metre of the centre, by the
    balance of forces and torques about the centre of rotation. Corners alone turn it by 8.6."""
    scene = stark.Scene()
    scene.add_floor(2.0, name="floor")
    box = scene.add_box((_SIDE, _SIDE, 0.01), mass=_MASS, position=(0, 0, 0.0055), name="box")
    ball = scene.add_sphere(
        0.004, subdivisions=3, motion="scripted", position=(0.03, -0.0548, 0.0055), name="ball"
    )
    scene.friction["box", "floor"] = _MU
    scene.friction["box", "ball"] = 0.0
    ball.follow(position=lambda t: (0.03, -0.0548 + 0.02 * t, 0.0055))
    sim = stark.Simulation(scene, time_step=0.005, contact_distance=3e-4)
    sim.run_until(0.1)
    start, turned = box.position[1], np.arctan2(box.rotation[1, 0], box.rotation[0, 0])
    sim.run_until(0.2)
    way = box.position[1] - start
    found = (np.arctan2(box.rotation[1, 0], box.rotation[0, 0]) - turned) / way
    assert found == pytest.approx(22.0, rel=0.06)


def test_corners_slide_at_the_corners_where_nothing_is_below_the_face() -> None:
    """A plate on a frame: its corners lie on two rails, and the middle of its face is over the gap."""
    scene = stark.Scene()
    scene.default_friction = _MU
    for side in (-1, 1):
        scene.add_box((0.02, 0.4, 0.02), motion="fixed", position=(side * 0.05, 0, -0.01))
    mesh = stark.mesh.box((_SIDE, _SIDE, 0.01))
    body = scene.add_rigid(mesh, mass=_MASS, position=(0, 0, 0.0056), angular_velocity=(0.0, 0.0, 1.0))
    sim = stark.Simulation(scene, time_step=0.001, contact_distance=3e-4)
    reports = [sim.step() for _ in range(20)]
    assert not any(report.failed for report in reports)
    contacts = body.contacts()
    arms = np.hypot(*contacts.friction_points[contacts.first_counts == 1, :2].T)  # edges cross there, too
    # On their way to the middle of the face the rails end at 40 mm.
    assert len(arms) == 4 and arms == pytest.approx(np.sqrt(2.0) * 0.04, rel=0.03)


def test_faces_that_are_flat_to_a_nanometre_are_as_flat_ones() -> None:
    mesh = stark.mesh.box((_SIDE, _SIDE, 0.01), 4)
    moved = np.asarray(mesh.vertices) + 1e-9 * np.random.default_rng(0).uniform(
        -1, 1, (len(mesh.vertices), 3)
    )
    assert lever(stark.mesh.TriangleMesh(moved, mesh.triangles)) == pytest.approx(lever(mesh), rel=0.01)


def holds(scene: stark.Scene, body: stark.RigidBody, axis: int, torque: float, time_step: float) -> bool:
    """Whether a body stays where it is under a torque about an axis, of what has come to rest before."""
    load = scene.add_torque(body, (0.0, 0.0, 0.0))
    sim = stark.Simulation(scene, time_step=time_step, contact_distance=3e-4)
    sim.run_until(0.1)
    load.torque = torque * np.eye(3)[axis]
    sim.run_until(0.2)
    start = body.rotation.copy()
    sim.run_until(0.3)
    return bool(abs(body.rotation - start).max() < 1e-5)


@pytest.mark.parametrize(
    ("shift", "turn", "area"),
    [(0.0, 0.0, 1.0), (0.02, 0.0, 0.8), (0.003, 0.0, 0.97), (0.0, 0.4, 1.0), (0.0, 0.02, 1.0)],
)
def test_a_box_on_an_equal_one_meets_the_torque_of_what_both_share(
    shift: float, turn: float, area: float
) -> None:
    """Aligned, over the edge, and turned: corners over corners and edges that cross. Corners alone held 1.8
    times as much."""
    n = 300
    x, y = np.meshgrid(*2 * [((np.arange(n) + 0.5) / n - 0.5) * _SIDE])
    across = stark.rotation(axis="z", angle=turn)[:2, :2].T @ np.stack([x.ravel() - shift, y.ravel()])
    shared = np.stack([x.ravel(), y.ravel()])[:, (abs(across) < _SIDE / 2).all(axis=0)]
    middle = shared.mean(axis=1, keepdims=True)
    even = float(np.hypot(*(shared - middle)).mean()) * _MU * _MASS * _G
    for part in (0.9, 1.1):
        scene = stark.Scene()
        scene.default_friction = _MU
        scene.add_box(_SIDE, motion="fixed", position=(0, 0, -_SIDE / 2))
        box = scene.add_box(
            (_SIDE, _SIDE, 0.02),
            mass=_MASS,
            position=(shift, 0, 0.0106),
            rotation=stark.rotation(axis="z", angle=turn),
        )
        assert holds(scene, box, 2, part * even, 0.005) == (part < 1.0)


def test_fingers_as_wide_as_a_bar_hold_the_torsion_of_their_pads() -> None:
    """Their edges lie along those of the bar: it turned in the grip beyond 1.6 times the torque."""
    side, grip = 0.02, 10.0
    even = 2.0 * _SQUARE * side * 0.5 * grip
    for part in (0.85, 1.15):
        scene = stark.Scene()
        scene.default_friction = 0.5
        bar = scene.add_box((0.2, side, side), mass=0.3)
        for y in (-0.0155, 0.0155):
            finger = scene.add_box((side, 0.01, side), mass=0.05, position=(0.0, y, 0.0))
            scene.add_slider(None, finger, anchor=(0.0, y, 0.0), axis=(0.0, -y, 0.0)).add_effort(grip)
            scene.add_force(finger, (0.0, 0.0, 0.05 * _G))
        scene.add_force(bar, (0.0, 0.0, 0.3 * _G))
        assert holds(scene, bar, 1, part * even, 0.002) == (part < 1.0)


@pytest.mark.parametrize(("width", "largest"), [(0.05, 0.08), (0.03, 0.16)])
def test_edges_that_pass_each_other_are_a_narrow_bump(width: float, largest: float) -> None:
    """Two fingers press a part without friction; its upper edge moves down past theirs (docs/friction.md)."""
    pressing, overhang, d = 9.81, 0.005, 1e-3
    scene = stark.Scene()
    part = scene.add_box((0.05, width, 0.05), motion="scripted", name="part")
    for name, side in (("left", -1.0), ("right", 1.0)):
        place = (0.0362 * side, 0.0, 0.0)
        finger = scene.add_box((0.02, 0.04, 0.04), mass=0.1, position=place, name=name)
        scene.add_slider(None, finger, anchor=place, axis=(-side, 0.0, 0.0)).add_effort(pressing)
        scene.friction["part", name] = 0.0
    sim = stark.Simulation(scene, time_step=0.005, gravity=(0, 0, 0))
    sim.run_until(0.3)
    ways, along = np.arange(0.002, 0.009, 5e-5), []
    for way in ways:
        part.position = (0.0, 0.0, -way)
        sim.step()
        along.append(part.holding_force[2] / (2.0 * pressing))
    acting = ways[np.abs(along) > 1e-3]
    assert 0.05 < np.max(np.abs(along)) < largest and np.min(along) < 0.0 < np.max(along)
    assert np.max(np.abs(acting - overhang)) < 0.8 * d


def rings(radius: float, height: float, count: int) -> stark.TriangleMesh:
    """A cylinder whose ends have rings of 64 vertices."""
    angles = 2 * np.pi * np.arange(64) / 64
    circle = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(64)))
    end = np.vstack([[0, 0, 0], *(radius * k / count * circle for k in range(1, count + 1))])
    half = np.array([0.0, 0.0, height / 2])
    nodes = np.vstack([end + half, end - half])
    at = 1 + np.arange(count * 64).reshape(count, 64)
    after = np.roll(at, -1, axis=1)
    top = [np.column_stack((np.zeros(64, int), at[0], after[0]))]
    for k in range(count - 1):
        top.append(np.column_stack((at[k], at[k + 1], after[k + 1])))
        top.append(np.column_stack((at[k], after[k + 1], after[k])))
    face, n = np.vstack(top), len(end)
    side = [(at[-1], n + at[-1], n + after[-1]), (at[-1], n + after[-1], after[-1])]
    return stark.TriangleMesh(
        nodes, np.vstack([face, face[:, ::-1] + n, *(np.column_stack(part) for part in side)])
    )


def even_disc(speed: float, spin: float, radius: float, until: float) -> tuple[float, float]:
    """Speed and spin of a disc of even pressure, by the midpoint rule in time and over its area."""
    r, angle = np.meshgrid((np.arange(60) + 0.5) / 60 * radius, (np.arange(60) + 0.5) / 60 * 2 * np.pi)
    weight = _MU * _G * r / r.sum()

    def rates(v: float, w: float) -> tuple[float, float]:
        x, y = v - w * r * np.sin(angle), w * r * np.cos(angle)
        size = np.hypot(x, y)
        turning = (y * np.cos(angle) - x * np.sin(angle)) * r
        return -float((weight * x / size).sum()), -float((weight * turning / size).sum() / (radius**2 / 2))

    h = until / 300
    for _ in range(300):
        a, b = rates(speed, spin)
        a, b = rates(speed + h / 2 * a, spin + h / 2 * b)
        speed, spin = speed + h * a, spin + h * b
    return speed, spin


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_disc_with_rings_spins_and_slides_as_one_of_even_pressure(integrator: str) -> None:
    scene = stark.Scene()
    scene.default_friction = _MU
    scene.add_floor(2.0)
    moving = {"velocity": (0.3, -0.4, 0.0), "angular_velocity": (0.0, 0.0, 20.0)}
    disc = scene.add_rigid(rings(0.1, 0.002, 4), mass=1.0, position=(0, 0, 0.0016), **moving)
    sim = stark.Simulation(scene, time_step=0.002, contact_distance=3e-4, **{"time.integrator": integrator})
    sim.run_until(0.3)
    speed, spin = even_disc(0.5, 20.0, 0.1, 0.3)
    assert np.hypot(*disc.velocity[:2]) == pytest.approx(speed, rel=0.05)
    assert disc.angular_velocity[2] == pytest.approx(spin, rel=0.01)
    assert disc.velocity[0] / disc.velocity[1] == pytest.approx(-0.75, rel=0.02)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize("time_step", [0.01, 0.005])
@pytest.mark.parametrize("degrees", [20.0, -63.4])
def test_a_box_that_is_kicked_askew_slides_without_turning(
    degrees: float, time_step: float, integrator: str
) -> None:
    """Its corners lift off on the way to the solution of the first step. Two of them lost their levers there,
    and the box turned by 1 degree."""
    scene = stark.Scene()
    scene.default_friction = _MU
    scene.add_floor(2.0)
    box = scene.add_box(_SIDE, mass=1.0, position=(0, 0, _SIDE / 2 + 1.9e-4))
    sim = stark.Simulation(
        scene, time_step=time_step, contact_distance=1e-4, **{"time.integrator": integrator}
    )
    sim.run_until(0.2)
    direction = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
    box.velocity = direction
    sim.run_until(0.7)
    assert np.degrees(np.arctan2(box.rotation[1, 0], box.rotation[0, 0])) == pytest.approx(0.0, abs=0.01)
    way = 1.0 / (2.0 * _MU * _G)
    assert box.position @ direction == pytest.approx(way, abs=0.55 * time_step)  # half a step of 1 m/s
    assert abs(np.cross(direction, box.position)[2]) < 1e-5


def clutch(below: stark.TriangleMesh, above: stark.TriangleMesh, motion: str) -> float:
    """Torque over mu N R that a disc meets which is pressed on another one and turns against it."""
    pressing, rate, angle = 100.0, 4.0, {"coordinate": "angle"}
    scene = stark.Scene()
    scene.default_friction = _MU
    lower = scene.add_rigid(below, mass=None if motion == "fixed" else 1.0, motion=motion)
    upper = scene.add_rigid(above, mass=1.0, position=(0, 0, 0.0203))
    if motion != "fixed":
        scene.add_fixed(None, lower, anchor=(0, 0, 0))
    axle = scene.add_cylindrical(None, upper, anchor=(0, 0, 0.0203), axis="z")
    axle.add_effort(-pressing, coordinate="displacement")
    axle.add_spring(0.0, damping=300.0, coordinate="displacement")
    drive = axle.add_servo(
        lambda t: rate * t, stiffness=1e5, damping=100.0, cap=1e4, target_rate=rate, **angle
    )
    sim = stark.Simulation(scene, time_step=0.005, contact_distance=2e-4, gravity=(0, 0, 0))
    sim.run_until(0.2)
    torques = []
    for report in sim.run(until=0.4):
        assert not report.failed, report.message
        torques.append(drive.torque)
    return float(np.mean(torques)) / (_MU * pressing * 0.1)


def with_middles(cylinder: stark.TriangleMesh) -> stark.TriangleMesh:
    """The same body, its ends as fans about a vertex in their middle, as in files of others."""
    x, triangles = cylinder.vertices, cylinder.triangles
    n, ends = len(x), (x[:, 2].min(), x[:, 2].max())
    fans = []
    for k, z in enumerate(ends):
        of_end = (x[triangles][:, :, 2] == z).all(axis=1)
        edges = triangles[of_end][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        border = [e for e in edges.tolist() if e[::-1] not in edges.tolist()]
        fans += [(a, b, n + k) for a, b in border]
        triangles = triangles[~of_end]
    return stark.TriangleMesh(np.vstack([x, [(0, 0, z) for z in ends]]), np.vstack([triangles, fans]))


@pytest.mark.parametrize(
    ("radius", "motion"),
    [
        (0.1, "dynamic"),
        (0.1, "fixed"),
        (0.1005, "dynamic"),
        (0.12, "dynamic"),
        (0.15, "dynamic"),
        (0.15, "fixed"),
    ],
)
@pytest.mark.parametrize("segments", [32, 64])
def test_discs_on_discs_meet_the_torque_of_an_even_pressure(
    radius: float, motion: str, segments: int
) -> None:
    """Two thirds. With vertices in the middle of their ends they met 0.50 to 0.91."""
    discs = [stark.mesh.cylinder(r, 0.02, segments) for r in (radius, 0.1)]
    assert clutch(*discs, motion) == pytest.approx(2.0 / 3.0, rel=0.0125)
    assert clutch(*map(with_middles, discs), motion) == pytest.approx(2.0 / 3.0, rel=0.0125)
