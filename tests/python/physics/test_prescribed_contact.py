"""Contact with what is prescribed: pins beside walls, tables that turn fast, steps without inertia."""

from __future__ import annotations

import numpy as np
import pytest
from _helpers import G, advance

import stark

MASS = 0.1  # [kg]


@pytest.mark.parametrize("gap", [1e-3, 1.5e-3])
def test_pins_beside_fixed_bodies_do_not_concern_others(gap: float) -> None:
    """Nothing moves a pin and a floor, so there is no barrier between them. One that is stiff beyond all
    measure would drown the energies of everything else in rounding."""

    def slide(with_cloth: bool) -> tuple[np.ndarray, float]:
        scene = stark.Scene()
        scene.add_floor(2.0)
        box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.0519), velocity=(0.5, 0, 0))
        if with_cloth:
            grid = stark.mesh.grid(0.2, 0.2, 3)
            scene.add_cloth(grid, position=(0.5, 0, gap), pins=[0, 1])
        sim = stark.Simulation(scene, time_step=0.01)
        energy = 0.0
        for report in sim.run(0.2):
            assert report.status == "accepted" and not report.caveats
            energy = max(energy, report.energy["contact"])
        return np.array(box.position), energy

    alone, _ = slide(with_cloth=False)
    beside, energy = slide(with_cloth=True)
    assert energy < 0.1
    assert beside == pytest.approx(alone, abs=1e-5)


def test_pins_beside_walls_still_stop() -> None:
    """Without a barrier, continuous collision detection alone keeps them apart."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 3), position=(0, 0, 5e-3), pins=[0])
    sim = stark.Simulation(scene, time_step=0.01)
    cloth.pin_targets = cloth.pin_targets - (0.0, 0.0, 0.02)
    for _ in range(20):
        report = sim.step()
        assert cloth.positions[:, 2].min() > 0.0
        if report.failed:
            break
    assert report.diagnosis.cause == "blocked_motion"


@pytest.mark.parametrize("rpm", [600, 3000, 3600, 9000])
def test_fast_tables_drag_along(rpm: float) -> None:
    """However many turns they would make in a time step: the box is dragged with mu g, along the way of the
    table at its place but for half of the turn of a step, a sixteenth of a turn at most."""
    scene = stark.Scene()
    speed = rpm * 2.0 * np.pi / 60.0
    scene.add_cylinder(0.5, 0.05, motion="scripted", position=(0, 0, -0.025), angular_velocity=(0, 0, speed))
    box = scene.add_box(0.05, mass=MASS, position=(0.2, 0, 0.0265), friction=0.5)
    sim = stark.Simulation(scene)
    for report in sim.run(0.05):
        assert report.time_step * speed < 1.001 * np.pi / 8.0
    along = np.arctan2(-box.velocity[0], box.velocity[1])
    assert np.linalg.norm(box.velocity[:2]) == pytest.approx(0.5 * G * 0.05, rel=0.1)  # it settles, too
    assert abs(along) < np.pi / 16.0 + 0.06  # and what its own way of 6 mm at 0.2 m adds, twice


def test_paddles_turn_in_their_own_sense() -> None:
    """At 314 rad/s and 60 steps a second, a paddle of five turns a step would stand still."""
    scene = stark.Scene()
    speed = 100.0 * np.pi
    scene.add_box(
        (0.5, 0.02, 0.1), motion="scripted", angular_velocity=(0, 0, speed), position=(0, 0, 0), name="paddle"
    )
    ball = scene.add_sphere(0.03, mass=0.05, position=(0.2, 0.08, 0.0))
    sim = stark.Simulation(scene, gravity=(0, 0, 0))
    sim.run_until(0.05)
    assert np.cross(ball.position, ball.velocity)[2] > 0.0
    assert ball.velocity @ ball.velocity > 20.0**2


def test_rigid_bodies_rest_without_inertia() -> None:
    """On a floor, and on something soft: quasistatic steps find where contact carries the weight."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    block = scene.add_solid(
        stark.mesh.tet_box((0.2, 0.2, 0.1), (4, 4, 2)), stark.materials.silicone, position=(0, 0, 0.0515)
    )
    on_block = scene.add_box(0.05, mass=MASS, position=(0, 0, 0.128))
    on_floor = scene.add_box(0.05, mass=MASS, position=(0.3, 0, 0.0265))
    sim = stark.Simulation(
        scene,
        **{
            "time.integrator": "quasistatic",
            "newton.acceleration_tolerance": 0.0,
            "newton.residual_tolerance": 1e-6,
        },
    )
    advance(sim, 0.1)
    for box in (on_block, on_floor):
        assert box.contact_force == pytest.approx((0.0, 0.0, MASS * G), abs=1e-5)
    assert block.contact_force[2] == pytest.approx(float(block.mass) * G, rel=1e-4)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize("count", [1, 3])
def test_forces_at_a_given_gap_do_not_grow_by_themselves(count: int, integrator: str) -> None:
    """Boxes between a table and a press that leaves a twentieth of the contact distance at each. Contact that
    got stiffer with the force made it grow e-fold in a tenth of a second."""
    scene = stark.Scene()
    scene.add_box((0.3, 0.3, 0.1), motion="fixed", position=(0, 0, -0.05))
    for k in range(count):
        scene.add_box(0.1, mass=0.1 * (k + 1), position=(0, 0, 0.0519 + 0.1019 * k))
    start = 0.05 + 0.1 * count + 0.0019 * (count + 1)
    end = 0.05 + 0.1 * count + 1e-4 * (count + 1)
    press = scene.add_box((0.3, 0.3, 0.1), motion="scripted", position=(0, 0, start))
    press.follow(lambda t: (0, 0, start + (end - start) * min(t / 0.5, 1.0)))
    sim = stark.Simulation(scene, time_step=0.01, time={"integrator": integrator})
    sim.run_until(0.6)
    early = press.holding_force[2]
    sim.run_until(2.0)
    assert early < -1e3
    assert 0.99 < press.holding_force[2] / early < 1.4  # two or three trials of 10 %


@pytest.mark.parametrize("time_step", [0.01, 0.002])
def test_contact_gets_as_stiff_as_a_load_asks_for_that_grows(time_step: float) -> None:
    """2 kN, within a second, on a box of 20 g: both of its gaps end at a tenth of the contact distance."""
    scene = stark.Scene()
    scene.add_box((0.3, 0.3, 0.1), motion="fixed", position=(0, 0, -0.05))
    box = scene.add_box((0.05, 0.05, 0.02), mass=0.02, position=(0, 0, 0.0119))
    block = scene.add_box((0.04, 0.04, 0.1), mass=10.0, position=(0, 0, 0.0738))
    scene.add_force(block, lambda t: (0, 0, -2000.0 * min(t, 1.0)))
    sim = stark.Simulation(scene, time_step=time_step)
    sim.run_until(3.0)
    for other in (scene.bodies[0], block):
        distance = box.contact_distance + other.contact_distance
        assert sim.distance(box, other) == pytest.approx(0.1 * distance, rel=0.05)
