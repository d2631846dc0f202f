"""A plate pushed over 25 balls (V27): the rolling test of SimBenchmark (leggedrobotics) by its parameters.

A ball of mass m between plate and ground is driven by the force f of the plate above and g of the ground
below, m a = f + g and 2/5 m r alpha = f - g. While it rolls on both, alpha r = a, so f = 0.7 m a, g = 0.3 m
a, the plate has 2 a, and F = (2 M + 0.7 n m) a. That takes f <= mu M g / n, F <= mu M g (1 + 20 M / (7 n m)).
Beyond, the plate slips with f = mu M g / n, and the ball rolls on the ground, a = 10 f / (7 m).

How far a wheel comes for the angle that it turns by, and where balls go between plates that turn."""

from __future__ import annotations

import numpy as np
import pytest
from _helpers import G, advance
from _validation import validate

import stark

PLATE, BALL, SIDE = 10.0, 1.0, 5  # [kg], [kg], balls along a side
RADIUS, GAP, STEP = 0.1, 1e-3, 5e-3  # [m], [m], [s]
MU_PLATE, MU_GROUND = 0.8, 0.4


@stark.energy
def push(f: stark.Frame, force: stark.Vec3):
    """A force on the origin of a body [N]."""
    return -(force @ f.origin)


def accelerations(
    force: float, direction: float, subdivisions: int, duration: float, *, turned: bool = False
) -> list[float]:
    """Mean accelerations [m/s^2] of plate and balls along the force, which acts after 0.5 s of rest.

    The balls have the inertia of true ones. Their surfaces are triangles: they carry the plate together if
    all have the same orientation, unlike when each is turned at random."""
    scene = stark.Scene()
    scene.default_friction = MU_PLATE
    floor = scene.add_floor(6.0)
    plate = scene.add_box((2.4, 2.4, 0.02), mass=PLATE, position=(0, 0.5, 2 * RADIUS + 3.9 * GAP + 0.01))
    scene.disable_contact(plate, floor)
    inertia = (BALL, (0.0, 0.0, 0.0), 0.4 * BALL * RADIUS**2 * np.eye(3))
    mesh = stark.mesh.sphere(RADIUS, subdivisions)
    balls: list[stark.RigidBody] = []
    random = np.random.default_rng(1)
    for i, j in np.ndindex(SIDE, SIDE):
        # Beside the middle, where the diagonal of the floor runs.
        position = (0.4 * (i - 2) + 0.013, 0.4 * (j - 2) + 0.5, RADIUS + 1.95 * GAP)
        axes = random_rotation(random) if turned else np.eye(3)
        ball = scene.add_rigid(mesh, inertia=inertia, position=position, rotation=axes)
        scene.friction[ball, floor] = MU_GROUND
        for other in balls:
            scene.disable_contact(ball, other)
        balls.append(ball)
    hand = scene.add(push(plate, force=(0, 0, 0)))
    sim = stark.Simulation(scene, time_step=STEP, contact_distance=GAP)
    advance(sim, 0.5)
    ahead = np.array([np.cos(direction * stark.deg), np.sin(direction * stark.deg), 0.0])
    hand.force = force * ahead

    def velocities() -> np.ndarray:
        return np.array([plate.velocity @ ahead, np.mean([ball.velocity @ ahead for ball in balls])])

    start, before = sim.time, velocities()
    advance(sim, start + duration)
    return list((velocities() - before) / (sim.time - start))


def random_rotation(random: np.random.Generator) -> np.ndarray:
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    return axes * np.sign(np.linalg.det(axes))


@pytest.mark.slow
@pytest.mark.parametrize("direction", [0, 45])
def test_plate_rolls_on_25_balls(direction: int) -> None:
    validate(f"V27.rolls_{direction}", accelerations(75.0, direction, 4, 0.3))


def test_plate_rolls_on_coarse_balls() -> None:
    for subdivisions in (2, 3):
        validate(f"V27.facets_{subdivisions}", accelerations(75.0, 0.0, subdivisions, 0.3))


@pytest.mark.slow
@pytest.mark.parametrize("subdivisions", [3, 4])
def test_plate_on_balls_of_different_heights(subdivisions: int) -> None:
    validate(f"V27.turned_{subdivisions}", accelerations(75.0, 0.0, subdivisions, 0.3, turned=True))


@pytest.mark.slow
def test_plate_rolls_and_slips_as_hard_as_friction_allows() -> None:
    validate("V27.limit", accelerations(150.0, 0.0, 4, 0.2))
    # Before the first edges of facets come down: from then on the plate hops, and its mean load is another.
    validate("V27.slips", accelerations(200.0, 0.0, 4, 0.015))
    limit = MU_PLATE * PLATE * G * (1 + 20 * PLATE / (7 * SIDE**2 * BALL))
    assert 150.0 < limit < 200.0


def short_by(speed: float, step: float, integrator: str, **contact: float) -> tuple[float, float]:
    """Part of its way that a rolling wheel lacks, and the angle by which it turns in a step [rad]."""
    radius, gap = 0.05, 0.5e-3
    scene = stark.Scene()
    scene.default_friction = 0.8
    scene.add_floor(10.0)
    wheel = scene.add_cylinder(
        radius,
        0.04,
        mass=1.0,
        segments=128,
        rotation=stark.rotation(axis="x", angle=90 * stark.deg),
        position=(0.003, 0.0007, radius + 1.84 * gap),
        velocity=(speed, 0, 0),
        angular_velocity=(0, speed / radius, 0),
    )
    settings = {"time": {"integrator": integrator}, "contact": {"distance": gap, **contact}}
    sim = stark.Simulation(scene, settings, time_step=step)
    advance(sim, 0.1)
    start, turned = wheel.position[0], 0.0
    for report in sim.run(0.5):
        assert not report.failed
        turned += wheel.angular_velocity[1] * step
    return 1.0 - (wheel.position[0] - start) / (radius * turned), speed / radius * step


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_wheels_roll_short_by_what_the_guide_says(integrator: str) -> None:
    """The chord of a step is the most of it; bristles and the layer of contact take 0.05 to 0.2 %
    (docs/friction.md)."""
    for speed in (1.0, 2.0):
        short, turn = short_by(speed, 0.01, integrator)
        assert abs(short - turn**2 / 6) < 1.5e-3
    for step in (1e-2, 5e-3):
        short, turn = short_by(0.5, step, integrator, stick_velocity=1e-4)
        assert 0.0 < short - turn**2 / 6 < 8e-4


def thrown(speed: float, spin: float, step: float, integrator: str) -> tuple[float, float]:
    """Speed at which a ball of 7 kg rolls in the end, and how long it slides, mu 0.2."""
    radius, mass = 0.1085, 7.0
    scene = stark.Scene()
    scene.default_friction = 0.2
    scene.add_floor(60.0)
    ball = scene.add_rigid(
        stark.mesh.sphere(radius, 4),
        inertia=(mass, (0, 0, 0), 0.4 * mass * radius**2 * np.eye(3)),
        position=(-10.3, 0.1, radius + 1e-3),
        velocity=(speed, 0, 0),
        angular_velocity=(0, spin, 0),
    )
    sim = stark.Simulation(scene, time_step=step, time={"integrator": integrator})
    slip = speed - radius * spin
    slides = 2.0 * slip / (7.0 * 0.2 * G)
    times, slips = [0.0], [1.0]
    for report in sim.run(1.5 * slides):
        assert not report.failed
        times.append(report.time)
        slips.append((ball.velocity[0] - radius * ball.angular_velocity[1]) / slip)
    half = np.interp(-0.5, -np.array(slips), times)  # it falls evenly
    return float(ball.velocity[0]), float(2.0 * half)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_ball_that_slides_comes_to_roll(integrator: str) -> None:
    """With (5 v + 2 r w)/7, after 2 (v - r w)/(7 mu g): a bowling ball, and one with so much draw that it
    comes back."""
    bowled = thrown(8.0, 0.0, 0.002, integrator)
    validate(f"sliding_ball.bowled_{integrator}", bowled)
    validate(f"sliding_ball.draw_{integrator}", thrown(2.0, -60.0, 0.002, integrator))


def feed(radius: float, distance: float) -> float:
    """Speed [m/s] of a cloth between two rollers that turn by 2 rad/s, pressed to 0.8 of the sum of the
    contact distances [m]."""
    scene = stark.Scene()
    scene.default_friction = 0.6
    along = stark.rotation(axis="x", angle=90 * stark.deg)
    for sign in (1.0, -1.0):
        start, end = (0, 0, sign * (radius + 1.05 * distance)), (0, 0, sign * (radius + 0.8 * distance))
        roller = scene.add_cylinder(
            radius, 0.06, segments=128, motion="scripted", rotation=along, position=start
        )
        roller.follow(
            position=stark.motion.linear([0.0, 0.1], [start, end]),
            rotation=lambda t, s=sign: stark.rotation(axis="y", angle=2.0 * s * t) @ along,
        )
    web = stark.mesh.grid(0.12, 0.04, cells=(64, 4))
    cloth = scene.add_cloth(web, stark.materials.cotton, contact_distance=distance / 2, self_contact=False)
    settings = {"contact.distance": distance / 2, "contact.stiffness": 1e4}
    sim = stark.Simulation(scene, time_step=5e-3, gravity=(0, 0, 0), **settings)
    sim.run_until(0.2)
    before = cloth.positions[:, 0].mean()
    sim.run_until(0.3)
    return abs(cloth.positions[:, 0].mean() - before) / 0.1


def test_cloth_between_rollers_goes_faster_by_the_contact_distance_over_the_radius() -> None:
    """docs/friction.md: v/(w R) - 1 is between g/R and (2 d - g)/R; rollers whose mesh is smaller by the
    contact distance feed as the true ones."""
    for distance in (1e-3, 0.2e-3):
        excess = feed(0.03, distance) / (2.0 * 0.03) - 1.0
        assert 0.8 * distance / 0.03 < excess < 1.2 * distance / 0.03 + 5e-4
    assert feed(0.029, 1e-3) == pytest.approx(2.0 * 0.03, rel=2e-3)


@pytest.mark.parametrize(
    ("radius", "fineness", "distance"), [(0.05, 5, 1e-3), (0.02, 4, 1e-3), (0.05, 5, 2e-4)]
)
def test_a_spinning_ball_is_braked_as_by_a_disc(radius: float, fineness: int, distance: float) -> None:
    """A point would not brake it. The arm is what docs/friction.md says, 0.4 times the root of the radius
    times the sum of contact distances."""
    mu, mass, gravity = 0.3, 0.2, 9.81
    scene = stark.Scene()
    scene.default_friction = mu
    scene.add_floor(1.0)
    place = (0, 0, radius + 1.6 * distance)
    ball = scene.add_sphere(
        radius, subdivisions=fineness, mass=mass, position=place, angular_velocity=(0, 0, 30.0)
    )
    sim = stark.Simulation(scene, time_step=0.002, contact_distance=distance)
    sim.run_until(0.1)
    start = ball.angular_velocity[2]
    sim.run_until(0.3)
    slowing = (start - ball.angular_velocity[2]) / 0.2
    arm = slowing * np.asarray(ball.inertia)[2, 2] / (mu * mass * gravity)
    assert arm == pytest.approx(0.4 * np.sqrt(radius * 2.0 * distance), rel=0.15)


def orbit(step: float, integrator: str, rate: float) -> tuple[float, float]:
    """Angle by which balls go round between a fixed plate and one that turns, over that of the plate, and by
    which factor their distance from the axis grows in 1 s, the mean of three."""
    distance, ball_radius, start = 2e-5, 6e-3, 0.05
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_cylinder(0.09, 0.01, motion="fixed", position=(0, 0, -0.005))
    above = (0, 0, 2 * ball_radius + 0.005 + 3.6 * distance)
    top = scene.add_cylinder(0.09, 0.01, mass=2.0, position=above, angular_velocity=(0, 0, rate))
    axle = scene.add_cylindrical(None, top, anchor=(0, 0, 0), axis="z")
    axle.add_motor(target=rate, cap=5.0, delta=0.01, coordinate="angle")
    speed, balls = 0.5 * rate * start, []
    for angle in (0.0, 2.1, 4.2):
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        balls.append(
            scene.add_sphere(
                ball_radius,
                density=7800.0,
                position=start * out + (0, 0, ball_radius + 1.8 * distance),
                velocity=speed * np.cross((0, 0, 1), out),
                angular_velocity=-speed / ball_radius * out,
            )
        )
    settings = {"time": {"integrator": integrator}, "contact": {"distance": distance}}
    sim = stark.Simulation(scene, settings, time_step=step)
    before, turned = np.array([0.0, 2.1, 4.2]), np.zeros(3)
    for _ in sim.run(until=1.0):
        now = np.array([np.arctan2(*ball.position[1::-1]) for ball in balls])
        turned += (now - before + np.pi) % (2 * np.pi) - np.pi
        before = now
    radii = [np.hypot(*ball.position[:2]) for ball in balls]
    return float(np.mean(turned)) / axle.coordinates["angle"], float(np.mean(radii)) / start


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_balls_of_a_bearing_drift_outward_as_the_guide_says(integrator: str) -> None:
    """They go round at half the rate of the plate. Friction takes the point of the plate that touches at the
    end of a step, so that each step leads outward by (rate step)^2/8 of the distance (docs/friction.md); the
    spin of the balls about the normal adds to it."""
    for rate, step in ((3.0, 1 / 60), (6.0, 5e-3)):
        turned, grown = orbit(step, integrator, rate)
        assert turned == pytest.approx(0.5, abs=5e-4)
        assert 0.8 < np.log(grown) / (rate**2 * step / 8) < 1.3


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize(
    ("degrees", "distance", "less"), [(90, 2e-4, 0.06), (60, 2e-4, 0.17), (60, 5e-5, 0.06)]
)
def test_a_ball_in_a_groove_is_braked_by_its_spin(
    degrees: int, distance: float, less: float, integrator: str
) -> None:
    """docs/friction.md: without it, it gains g sin(slope) / (1 + 0.4 / sin(half of the angle)^2)."""
    radius, slope, half = 0.03, 0.2, np.radians(degrees) / 2
    tilt = stark.rotation(axis="y", angle=slope)
    scene = stark.Scene()
    scene.default_friction = 0.3
    for side in (1, -1):
        normal = np.array([0, -side * np.cos(half), np.sin(half)])
        up = np.array([0, side * np.sin(half), np.cos(half)])
        axes = np.column_stack([[1, 0, 0], np.cross(normal, [1, 0, 0]), normal])
        place = tilt @ (0.06 * up - 0.01 * normal)
        scene.add_box((4, 0.118, 0.02), motion="fixed", position=place, rotation=tilt @ axes)
    place = tilt @ [0, 0, (radius + 0.95 * distance) / np.sin(half)]
    ball = scene.add_sphere(radius, subdivisions=5, mass=0.1, position=place)
    sim = stark.Simulation(
        scene, time_step=0.002, contact_distance=distance / 2, **{"time.integrator": integrator}
    )
    sim.run_until(0.2)
    start = np.linalg.norm(ball.velocity)
    sim.run_until(0.7)
    gained = (np.linalg.norm(ball.velocity) - start) / 0.5
    free = 9.81 * np.sin(slope) / (1.0 + 0.4 / np.sin(half) ** 2)
    assert gained / free == pytest.approx(1.0 - less, abs=0.015)
    if distance > 1e-4:  # finer than that, facets count
        resistance = 0.4 * 0.3 * 9.81 * np.sqrt(radius * distance) / np.tan(half) / (radius * np.sin(half))
        expected = 1.0 - resistance * np.cos(slope) / (9.81 * np.sin(slope))
        assert gained / free == pytest.approx(expected, abs=0.02)
