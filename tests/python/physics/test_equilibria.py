"""Quasistatic steps: they go on where iterations run out; what they find is at rest in any integrator."""

import numpy as np
import pytest

import stark

STATIC = {"time.integrator": "quasistatic", "newton.residual_tolerance": 1e-9}
SPAN, BAR, BARS, MASS, GRAVITY = 1.0, 0.25, 6, 0.02, 9.81


def hanging_chain() -> tuple[stark.Scene, list[stark.RigidBody]]:
    """Bars of 0.25 m, joined by balls and hung up at both ends, 1 m apart; they start as a V."""
    scene = stark.Scene()
    slope = np.arccos(SPAN / (BARS * BAR))
    ends, bars = [np.zeros(3)], []
    for i in range(BARS):
        down = -1.0 if i < BARS // 2 else 1.0
        along = np.array([np.cos(slope), 0.0, down * np.sin(slope)])
        ends.append(ends[-1] + BAR * along)
        turn = stark.rotation(axis="y", angle=-down * slope)
        middle = 0.5 * (ends[-1] + ends[-2])
        bars.append(scene.add_box((0.8 * BAR, 0.005, 0.005), mass=MASS, position=middle, rotation=turn))
    for i, end in enumerate(ends):
        scene.add_ball(bars[i - 1] if i else None, bars[i] if i < BARS else None, anchor=end)
    return scene, bars


def catenary_of_bars() -> np.ndarray:
    """Heights [m] of the middles. Moments about one end of a bar: tan(slope) = force across / H, where the
    force across changes by the weight of a bar from middle to middle."""
    across = MASS * GRAVITY * (np.arange(BARS) - 0.5 * (BARS - 1))
    low, high = 1e-6, 1e3
    for _ in range(200):
        pull = np.sqrt(low * high)
        low, high = (pull, high) if np.sum(BAR * np.cos(np.arctan(across / pull))) < SPAN else (low, pull)
    rise = BAR * np.sin(np.arctan(across / pull))
    return np.cumsum(rise) - 0.5 * rise


def test_iterations_go_on_where_halving_would_repeat_them() -> None:
    scene, bars = hanging_chain()
    settings = {**STATIC, "newton.max_iterations": 200, "contact.enabled": False}
    sim = stark.Simulation(scene, time_step=1 / 60, gravity=(0, 0, -GRAVITY), **settings)
    report = sim.step()
    assert not report.failed and report.rejected_steps == 0
    assert report.newton_iterations > 200, "the case must need more than one budget"
    heights = [bar.position[2] for bar in bars]
    assert heights == pytest.approx(catenary_of_bars(), abs=1e-6 * SPAN)


def test_a_budget_that_is_too_small_is_named_with_a_remedy_that_fits() -> None:
    scene, _ = hanging_chain()
    settings = {**STATIC, "newton.max_iterations": 2, "contact.enabled": False}
    report = stark.Simulation(scene, time_step=1 / 60, **settings).step()
    assert report.failed and report.diagnosis.cause == "iteration_budget"
    assert "smaller parts" in report.message and "time.step" not in report.message
    assert report.rejected_steps == 1, "a shorter step poses the same problem"


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_an_equilibrium_stays_where_it_is(integrator: str) -> None:
    scene = stark.Scene()
    rubber = stark.RodMaterial(density=1000, youngs_modulus=1e7, poissons_ratio=0.3, width=0.01, height=0.01)
    line = stark.mesh.polyline((0, 0, 0), (1, 0, 0), 20)
    rod = scene.add_rod(line, rubber, clamps=[0], normal=(0, 1, 0), self_contact=False)
    arm = scene.add_box((0.2, 0.02, 0.02), mass=0.1, position=(0.1, 1.0, 0.0))
    hinge = scene.add_hinge(None, arm, anchor=(0, 1, 0), axis=(0, 1, 0))
    static = stark.Simulation(scene, {"contact.enabled": False, **STATIC})
    assert not static.step().failed
    sag = rod.positions[-1, 2]
    assert sag < -0.5 and hinge.angle == pytest.approx(np.pi / 2, abs=1e-6)
    assert not rod.velocities.any() and not arm.angular_velocity.any()

    dynamic = stark.Simulation(
        scene, {"contact.enabled": False, "time.integrator": integrator, "newton.residual_tolerance": 1e-9}
    )
    dynamic.state = static.state
    reports = [dynamic.step() for _ in range(30)]
    assert reports[-1].integrator == integrator and not reports[-1].failed
    # Tolerances of 1e-9 N move a rod of 0.1 kg by next to nothing.
    assert rod.positions[-1, 2] == pytest.approx(sag, abs=1e-7)


def test_states_go_to_simulations_without_history_and_back() -> None:
    scene = stark.Scene()
    ball = scene.add_sphere(0.05, mass=0.1, velocity=(1.0, 0.0, 0.0))
    bdf2 = stark.Simulation(scene, time_step=0.01, **{"time.integrator": "bdf2"})
    bdf2.run_until(0.1)
    there = ball.position.copy()
    euler = stark.Simulation(scene, time_step=0.01)
    euler.state = bdf2.state
    assert ball.position.tolist() == there.tolist()
    euler.run_until(0.2)
    bdf2.state = euler.state
    assert [bdf2.step().integrator for _ in range(2)] == ["implicit_euler", "bdf2"]


@pytest.mark.parametrize("motion", [-0.2, -0.01, -1e-6, 1e-6, 0.01])
def test_a_slack_sheet_follows_its_pins_from_a_flat_start(motion: float) -> None:
    """Nothing resists where an unstressed sheet goes, and energies along a step do not tell while pins move.
    The sheet hangs the same whether its pins move in the first step or in the second."""

    def sag(settles: bool) -> float:
        scene = stark.Scene()
        mesh = stark.mesh.grid(1.0, 0.1, cells=(20, 2))
        left, right = (np.flatnonzero(side * mesh.vertices[:, 0] > 0.499) for side in (-1, 1))
        cloth = scene.add_cloth(mesh, stark.materials.cotton, pins=np.concatenate([left, right]))
        sim = stark.Simulation(
            scene, time_step=0.01, **{"contact.enabled": False, "time.integrator": "quasistatic"}
        )
        if settles:
            assert not sim.step().failed
        targets = cloth.pin_targets.copy()
        targets[np.isin(cloth.pins, right), 0] += motion
        cloth.pin_targets = targets
        report = sim.step()
        assert not report.failed, report.message
        return float(cloth.positions[:, 2].min())

    assert sag(False) == pytest.approx(sag(True), abs=1e-6)
    assert sag(False) < -0.1
