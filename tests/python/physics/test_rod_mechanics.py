"""Rods against closed forms: large deflections, catenary, torsion, buckling, vibration; contact judged by
ipctk."""

from __future__ import annotations

import numpy as np
import pytest
from _helpers import Judge, advance

import stark

STATIC = {
    "time.integrator": "quasistatic",
    "contact.enabled": False,
    "newton.step_tolerance": 1e-10,
    "newton.acceleration_tolerance": 1e-8,
}
RUBBER = stark.RodMaterial(density=1000.0, youngs_modulus=1e7, radius=0.01)


@stark.energy
def dead_load(p: stark.Point, force: stark.Vec3):
    """A force that keeps its direction [N]."""
    return -stark.dot(force, p.x)


@pytest.mark.parametrize(
    ("load", "drop", "pull_in"),
    [(1, 0.30172, 0.05643), (2, 0.49346, 0.16064), (5, 0.71379, 0.38763), (10, 0.81061, 0.55500)],
)
def test_a_cantilever_deflects_as_the_elastica(load: float, drop: float, pull_in: float) -> None:
    """Tip force load * EI / L^2 [Bisshopp, Drucker 1945]: order 2, and so thin that stretch is nothing."""
    wire = RUBBER.replace(youngs_modulus=1e9, radius=0.005)

    def tip(segments: int) -> np.ndarray:
        scene = stark.Scene()
        rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (1, 0, 0), segments), wire, clamps=[0])
        force = load * wire.section["bending_stiffness_1"]
        scene.add(dead_load(rod.vertices[segments], force=(0.0, 0.0, -force)))
        simulation = stark.Simulation(scene, gravity=(0.0, 0.0, 0.0), **STATIC)
        assert not simulation.step().failed
        return np.array([-rod.positions[-1, 2], 1.0 - rod.positions[-1, 0]])

    exact = np.array([drop, pull_in])
    assert tip(40) == pytest.approx(exact, rel=1e-3)
    coarse, fine = np.abs(tip(5) - exact), np.abs(tip(10) - exact)
    assert (coarse / fine > 3.4).all(), (coarse, fine)


@pytest.mark.parametrize("sideways", [0.0, 0.01, 0.3])
def test_a_cord_that_carries_a_load_in_its_middle_is_a_string(sideways: float) -> None:
    """2 EA (s - 1) sqrt(1 - 1/s^2) = F for the stretch s: 1.0515 for EA = 314 N and 10 N."""
    cord = stark.RodMaterial(density=1000.0, youngs_modulus=1e8, radius=1e-3, mass_damping=5.0)
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((-0.1, 0, 0), (0.1, 0, 0), 4), cord, pins=[0, 4])
    scene.add(dead_load(rod.vertices[2], force=(0.0, 10.0 * sideways, -10.0)))
    simulation = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), **{"contact.enabled": False})
    for _ in range(30):
        report = simulation.step()
        assert report.status == "accepted"
        assert report.newton_iterations <= 15
        assert np.linalg.norm(np.diff(rod.positions, axis=0), axis=1).max() < 0.05 * 1.2
    length = np.linalg.norm(np.diff(rod.positions, axis=0), axis=1).sum()
    exact = {0.0: 0.0515, 0.01: 0.0515, 0.3: 0.0530}[sideways]  # of 10, 10 and 10.44 N
    assert length / 0.2 - 1.0 == pytest.approx(exact, rel=0.02)


def test_a_cord_that_is_pulled_to_twice_its_length_stays_straight() -> None:
    """Frames follow the edges, and all segments are stretched alike but for the weight."""
    cord = stark.RodMaterial(density=1000.0, youngs_modulus=1e6, radius=1e-3, mass_damping=5.0)
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.2, 0, 0), 8), cord, pins=[0, 8])
    simulation = stark.Simulation(scene, time_step=0.01, **{"contact.enabled": False})
    for k in range(1, 41):
        rod.pin_targets = [(0.0, 0.0, 0.0), (0.2 + 0.005 * k, 0.0, 0.0)]
        report = simulation.step()
        assert report.status == "accepted"
        assert report.newton_iterations <= 10
    edges = np.diff(rod.positions, axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    assert lengths / 0.025 == pytest.approx(2.0, rel=1e-3)
    assert np.einsum("ij,ij->i", rod.frames[:-1, :, 2], edges) == pytest.approx(lengths, rel=1e-3)


def arc(length: float, segments: int) -> np.ndarray:
    """Points of equal distance on a parabola of this length [m] over a span of 1 m."""
    x = np.linspace(0.0, 1.0, 4001)

    def along(sag: float) -> np.ndarray:
        return np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), sag * np.diff(4.0 * x * (1.0 - x))))])

    low, high = 0.0, 1.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if along(middle)[-1] < length else (low, middle)
    at = np.interp(np.linspace(0.0, length, segments + 1), along(low), x)
    return np.column_stack([at, 0.0 * at, -4.0 * low * at * (1.0 - at)])


@pytest.mark.parametrize(("stiffness", "sag", "tension"), [(1e4, 0.29262, 3.7355), (200.0, 0.30568, 3.6695)])
def test_a_cable_hangs_as_the_elastic_catenary(stiffness: float, sag: float, tension: float) -> None:
    """Span 1 m, length 1.2 m, 0.5 kg/m, from an arc of a parabola; hardly any bending stiffness."""
    segments, weight = 100, 0.5 * 9.81
    bending = dict.fromkeys(("bending_stiffness_1", "bending_stiffness_2", "torsional_stiffness"), 1e-7)
    cable = stark.RodMaterial(
        density=0.5 / (np.pi * 1e-6),
        radius=1e-3,
        axial_stiffness=stiffness,
        shear_stiffness=stiffness,
        **bending,
    )
    assert cable.section["mass"] == pytest.approx(0.5)
    points = arc(1.2, segments)
    scene = stark.Scene()
    rod = scene.add_rod(points, cable, pins=[0, segments], rest_shape="straight")
    simulation = stark.Simulation(scene, **STATIC)
    assert not simulation.step().failed
    rest = np.linalg.norm(np.diff(points, axis=0), axis=1)
    stretch = np.linalg.norm(np.diff(rod.positions, axis=0), axis=1) / rest
    first = stiffness * (stretch[0] - 1.0)  # half a segment from the end
    slope = np.diff(rod.positions[:2, 2])[0] / np.linalg.norm(np.diff(rod.positions[:2], axis=0))
    end = first - 0.5 * weight * rest[0] * slope
    assert -rod.positions[:, 2].min() == pytest.approx(sag, rel=0.002)
    assert end == pytest.approx(tension, rel=0.002)


def turned_wheel(segments: int) -> tuple[float, np.ndarray]:
    """Torque of a rod of 1 m whose end a wheel turns by 3.2 rad in steps, and the frames of its nodes."""
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (1, 0, 0), segments), RUBBER, clamps=[0])
    wheel = scene.add_box(0.1, position=(1.05, 0.0, 0.0), motion="scripted")
    joint = scene.add_fixed(wheel, rod.frame(-1))
    simulation = stark.Simulation(scene, gravity=(0.0, 0.0, 0.0), **STATIC)
    for k in range(1, 9):
        wheel.rotation = stark.rotation(axis="x", angle=0.4 * k)
        assert not simulation.step().failed
    assert np.abs(joint.reaction.torque[1:]).max() < 1e-9
    assert np.abs(rod.positions[:, 1:]).max() < 1e-9
    return float(joint.reaction.torque[0]), rod.frames


def test_torque_is_the_torsional_stiffness_times_the_twist() -> None:
    exact = 3.2 * RUBBER.section["torsional_stiffness"]
    coarse, _ = turned_wheel(10)
    fine, frames = turned_wheel(20)
    assert fine == pytest.approx(exact, rel=3e-3)
    assert (coarse - exact) / (fine - exact) == pytest.approx(4.0, rel=0.05)
    middle = frames[0].T @ frames[10]  # uniform twist
    assert np.arctan2(middle[1, 0], middle[0, 0]) == pytest.approx(1.6, abs=1e-4)


def test_the_work_of_a_turned_clamp_is_stored() -> None:
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (1, 0, 0), 16), RUBBER, clamps=[0, 16])
    simulation = stark.Simulation(scene, gravity=(0.0, 0.0, 0.0), **STATIC)
    start = rod.clamp_targets
    for k in range(1, 11):
        targets = start.copy()
        targets[1] = stark.rotation(axis="x", angle=0.1 * k) @ start[1]
        rod.clamp_targets = targets
        report = simulation.step()
        assert not report.failed
    exact = 0.5 * RUBBER.section["torsional_stiffness"]
    assert report.energy["elastic"] == pytest.approx(exact, rel=1e-3)


def largest_swing(torque_ratio: float) -> float:
    """How far a twisted straight rod goes aside from a small kick, its end turned to a share of Greenhill's
    critical angle."""
    length, segments = 1.0, 24
    section = RUBBER.section
    # Clamped ends that may not turn aside: M = 8.9868 EI / L [Greenhill 1883; Timoshenko, Gere 1961].
    critical = 8.9868 * section["bending_stiffness_1"] / section["torsional_stiffness"] / length
    points = stark.mesh.polyline((0, 0, 0), (length, 0, 0), segments).vertices.copy()
    points[1:-1, 2] += 1e-5 * np.sin(np.pi * points[1:-1, 0])
    scene = stark.Scene()
    rod = scene.add_rod(points, RUBBER, clamps=[0, segments], rest_shape="straight")
    simulation = stark.Simulation(scene, gravity=(0.0, 0.0, 0.0), **STATIC)
    start = rod.clamp_targets
    for k in range(1, 21):
        targets = start.copy()
        targets[1] = stark.rotation(axis="x", angle=torque_ratio * critical * length * k / 20) @ start[1]
        rod.clamp_targets = targets
        assert not simulation.step().failed
    return float(np.abs(rod.positions[:, 1:]).max())


def test_a_twisted_rod_buckles_at_greenhills_torque() -> None:
    # Below it the deviation of 1e-5 m grows a little; above it the rod leaves its axis.
    assert largest_swing(0.95) < 5e-5
    assert largest_swing(1.05) > 5e-4


def test_a_cantilever_rings_with_the_frequency_of_bernoulli() -> None:
    """First bending frequency 1.8751^2/(2 pi) sqrt(EI/(rho A L^4))."""
    section = RUBBER.section
    frequency = 1.8751**2 / (2.0 * np.pi) * np.sqrt(section["bending_stiffness_1"] / section["mass"])
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (1, 0, 0), 16), RUBBER, clamps=[0])
    simulation = stark.Simulation(
        scene,
        gravity=(0.0, 0.0, -0.02),
        time_step=1e-3,
        **{"time.integrator": "bdf2", "contact.enabled": False},
    )
    tip = np.array([rod.positions[-1, 2] for report in simulation.run(2.5 / frequency) if not report.failed])
    lowest = [k for k in range(1, len(tip) - 1) if tip[k - 1] > tip[k] <= tip[k + 1]]
    period = 1e-3 * (lowest[1] - lowest[0])
    assert period == pytest.approx(1.0 / frequency, rel=0.02)  # lumped masses and a time step of period/600


def test_rods_that_fall_over_a_box_and_each_other_never_intersect() -> None:
    hose = stark.RodMaterial(
        density=1100.0, youngs_modulus=2e6, radius=0.005, mass_damping=0.5, strain_damping=0.01
    )
    scene = stark.Scene()
    scene.add_rigid(stark.mesh.grid(2.0, 2.0, 2), motion="fixed")
    scene.add_box((0.1, 0.3, 0.1), motion="fixed", position=(0.0, 0.0, 0.1))
    under = scene.add_rod(stark.mesh.polyline((-0.4, 0.01, 0.25), (0.4, -0.02, 0.25), 40), hose, friction=0.5)
    over = scene.add_rod(stark.mesh.polyline((-0.05, -0.4, 0.3), (0.02, 0.4, 0.32), 40), hose, friction=0.5)
    simulation = stark.Simulation(scene, time_step=0.01)
    judge = Judge(simulation)
    for report in simulation.run(1.5):
        assert not report.failed, report.message
        assert not judge.intersects()
        assert not judge.crossed()
    # Both are bent over the box, the second one above the first where they cross, at about their thickness.
    crossing_under = under.positions[np.argmin(np.abs(under.positions[:, 0]))]
    crossing_over = over.positions[
        np.argmin(np.linalg.norm(over.positions[:, :2] - crossing_under[:2], axis=1))
    ]
    assert crossing_over[2] - crossing_under[2] > 0.8 * 2 * 0.005
    assert 0.15 < crossing_under[2] < 0.17
    for rod in (under, over):
        assert rod.positions[:, 2].min() > 0.005
        assert np.abs(rod.velocities).max() < 0.02
        assert np.abs(np.swapaxes(rod.frames, 1, 2) @ rod.frames - np.eye(3)).max() < 1e-12


def test_a_ribbon_bends_about_its_thin_axis() -> None:
    """Width along d1 and height along d2: the weight bends it w/h times as easily about d1."""
    ribbon = RUBBER.replace(width=0.04, height=0.01)

    def drop(normal: tuple[float, float, float]) -> float:
        scene = stark.Scene()
        rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (1, 0, 0), 16), ribbon, clamps=[0], normal=normal)
        simulation = stark.Simulation(scene, gravity=(0.0, 0.0, -0.01), **STATIC)
        assert not simulation.step().failed
        return -float(rod.positions[-1, 2])

    flat, upright = drop((0.0, 1.0, 0.0)), drop((0.0, 0.0, 1.0))
    exact = ribbon.section["mass"] * 0.01 / (8.0 * ribbon.section["bending_stiffness_1"])
    assert flat == pytest.approx(exact, rel=0.01)
    assert flat / upright == pytest.approx(16.0, rel=0.01)


def test_a_helix_under_no_load_keeps_its_shape_and_a_pulled_one_is_a_spring() -> None:
    """k = G d^4/(8 D^3 n) of a closely wound spring, pulled by little."""
    radius, turns, wire = 0.02, 5, 1e-3
    mesh = stark.mesh.helix(radius, 0.004, turns, 40 * turns)
    steel = stark.materials.steel_wire.replace(radius=wire)
    scene = stark.Scene()
    spring = scene.add_rod(mesh, steel, clamps=[0, len(mesh.vertices) - 1], self_contact=False)
    # Rounding of 1e-16 EA over the mass of a node is 1e-6 m/s^2.
    options = STATIC | {"newton.acceleration_tolerance": 1e-3}
    simulation = stark.Simulation(scene, gravity=(0.0, 0.0, 0.0), **options)
    assert not simulation.step().failed
    assert np.abs(spring.positions - mesh.vertices).max() < 1e-9
    assert simulation.step().energy["elastic"] < 1e-12
    targets = spring.pin_targets.copy()
    stroke = 1e-3
    targets[1, 2] += stroke
    spring.pin_targets = targets
    report = simulation.step()
    assert not report.failed
    modulus = 206e9 / 2.0 / (1.0 + steel.poissons_ratio)
    rate = modulus * (2 * wire) ** 4 / (8.0 * (2 * radius) ** 3 * turns)
    # Clamped ends do not turn, which stiffens a short spring by a few percent.
    assert 2.0 * report.energy["elastic"] / stroke**2 == pytest.approx(rate, rel=0.06)


def test_a_box_hangs_from_a_rod_at_position_and_orientation() -> None:
    scene = stark.Scene()
    rod = scene.add_rod(
        stark.mesh.polyline((0, 0, 0), (1, 0, 0), 12), RUBBER.replace(mass_damping=5.0), clamps=[0]
    )
    box = scene.add_box(0.1, mass=0.02, position=(1.05, 0.0, 0.0))
    joint = scene.add_fixed(rod.frame(-1), box)
    simulation = stark.Simulation(scene, time_step=0.02)
    advance(simulation, 4.0)
    # The box turns with the end of the rod; the joint carries its weight.
    turned = rod.frames[-1] @ np.linalg.inv(scene._core.initial_frames(rod._index).reshape(-1, 3, 3)[-1])
    assert np.abs(turned - box.rotation).max() < 1e-4
    offset = box.position - rod.positions[-1]
    assert np.linalg.norm(offset) == pytest.approx(0.05, abs=1e-6)
    assert joint.reaction.force == pytest.approx([0.0, 0.0, 0.02 * 9.81], abs=2e-3)


@pytest.mark.parametrize("segments", [20, 44, 120])
def test_a_rod_with_segments_shorter_than_its_diameter_does_not_touch_itself(segments: int) -> None:
    """Of 2, 0.9 and 0.3 diameters: bent far, but nowhere as tightly as it is thick."""
    rubber = stark.RodMaterial(density=1100.0, youngs_modulus=2e6, radius=0.005)

    def tip(self_contact: bool) -> np.ndarray:
        scene = stark.Scene()
        path = stark.mesh.polyline((0, 0, 0), (0.4, 0, 0), segments)
        rod = scene.add_rod(path, rubber, clamps=[0], self_contact=self_contact)
        load = 2.0 * rubber.section["bending_stiffness_1"] / 0.4**2
        scene.add_force(rod.vertices[[segments]], (0.0, 0.0, load))
        sim = stark.Simulation(scene, {"time.integrator": "quasistatic"}, gravity=(0.0, 0.0, 0.0))
        assert not sim.step().failed
        return rod.positions[-1]

    np.testing.assert_allclose(tip(True), tip(False), rtol=0.0, atol=1e-12)


def test_a_thick_rope_hangs_and_its_knot_holds() -> None:
    """A trefoil in a rod whose segments are shorter than its thickness, pulled until it is stretched: it
    opens nowhere, though nearby parts do not touch."""
    s = np.linspace(-2.25, 2.25, 4001)
    knot = 0.02 * np.stack([s**3 - 3 * s, s**4 - 4 * s**2, (s**5 - 10 * s) / 5], 1)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knot, axis=0), axis=1))])
    at = np.linspace(0.0, length[-1], 134)
    path = np.stack([np.interp(at, length, knot[:, k]) for k in range(3)], 1)
    rubber = stark.RodMaterial(
        density=1100.0, youngs_modulus=2e6, radius=0.005, mass_damping=5.0, strain_damping=0.002
    )
    scene = stark.Scene()
    rod = scene.add_rod(path, rubber, rest_shape="straight", pins=[0, 133])
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0.0, 0.0, 0.0))
    along = (path[-1] - path[0]) / np.linalg.norm(path[-1] - path[0])
    for report in sim.run(until=1.2):
        pulled = 0.175 * min(report.time + 0.01, 1.2) * along
        rod.pin_targets = np.stack([path[0] - pulled, path[-1] + pulled])
    stretch = np.linalg.norm(np.diff(rod.positions, axis=0), axis=1).sum() / length[-1]
    straight = np.linalg.norm(rod.positions[-1] - rod.positions[0]) / length[-1]
    assert stretch > 1.03 > 1.0 > straight  # untied, it would be as long as its ends are apart, 0.945
