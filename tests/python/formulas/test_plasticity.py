"""J2 plasticity against its closed form: loading, unloading and reversal, stored and dissipated energy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from formulas._laws import EQUILIBRIA

import stark

MU, BULK, YIELD, HARDENING = 1e6, 2e6, 2e4, 5e4  # [Pa]
VOLUME = 1e-3  # [m^3]
TINY = 1e-8 * YIELD  # [J/m^3]


def block(
    element: str = "tet4", hardening: float = HARDENING, step: float = 0.01, **more: float
) -> tuple[stark.Simulation, Any]:
    """A block whose surface is prescribed, with free vertices inside."""
    scene = stark.Scene()
    mesh: Any = stark.mesh.tet_box(0.1, 2) if element == "tet4" else stark.mesh.box_hexahedra(0.1, 2)
    viscous = "viscosity" in more  # which a quasistatic step, of any length, has nothing of
    made = stark.j2_viscoplasticity if viscous else stark.j2_plasticity
    law = made(
        shear_modulus=MU, bulk_modulus=BULK, yield_stress=YIELD, hardening_modulus=hardening,
        density=1e-3 if viscous else 1000.0, **more,
    )  # fmt: skip
    settings = {**EQUILIBRIA, "time.integrator": "implicit_euler"} if viscous else EQUILIBRIA
    inside = np.abs(mesh.vertices).max(axis=1) < 0.049
    body = scene.add_solid(mesh, law, pins=np.flatnonzero(~inside))
    return stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **settings), body


def deform(body: Any, F: np.ndarray) -> None:
    body.pin_targets = np.asarray(body.mesh.vertices)[body.pins] @ F.T


class OneDimension:
    """The same law of an equivalent strain: spring 3 mu, slider, linear hardening."""

    def __init__(self, back: float = 0.0) -> None:
        self.flow = self.slip = 0.0
        self.back = back

    def step(self, strain: float) -> tuple[float, float]:
        """Stored energy and dissipation of the step per volume [J/m^3]."""
        trial = 3 * MU * (strain - self.flow) - self.back * self.flow
        excess = max(abs(trial) - YIELD - HARDENING * self.slip, 0.0) / (3 * MU + self.back + HARDENING)
        self.flow += np.copysign(excess, trial)
        self.slip += excess
        stored = 1.5 * MU * (strain - self.flow) ** 2 + 0.5 * HARDENING * self.slip**2
        stored += 0.5 * self.back * self.flow**2
        return stored, YIELD * excess


@pytest.mark.parametrize("element", ["tet4", "hex8"])
def test_isochoric_tension_unloading_and_reversal(element: str) -> None:
    sim, body = block(element)
    closed = OneDimension()
    path = np.concatenate([np.linspace(0.0, 0.05, 6)[1:], np.linspace(0.05, -0.05, 11)[1:]])
    for strain in path:
        stretch = np.exp(strain)
        deform(body, np.diag([stretch, stretch**-0.5, stretch**-0.5]))
        report = sim.step()
        assert not report.failed
        stored, dissipated = closed.step(strain)
        assert report.energy["elastic"] / VOLUME == pytest.approx(stored, rel=1e-6, abs=TINY)
        assert report.energy["damping"] / VOLUME == pytest.approx(
            dissipated, rel=1e-6, abs=1e-6 * YIELD * 0.01
        )
        assert report.energy["damping"] > -1e-9 * VOLUME * YIELD
    slip = sim.state.arrays()["internal_variable"].reshape(-1, 10)[:, 9]
    np.testing.assert_allclose(slip, closed.slip, rtol=1e-6)


def stretched(body: Any, strain: float) -> None:
    """Isochoric tension of a logarithmic strain."""
    deform(body, np.diag([np.exp(strain), np.exp(-0.5 * strain), np.exp(-0.5 * strain)]))


def slip_of(sim: stark.Simulation) -> float:
    slips = sim.state.arrays()["internal_variable"].reshape(-1, 10)[:, 9]
    np.testing.assert_allclose(slips, slips[0], rtol=1e-6, atol=1e-12)
    return float(slips[0])


def test_kinematic_hardening_is_that_of_prager_at_small_strains() -> None:
    """Loading, unloading and reversal: it yields again after twice the yield stress, not twice the stress
    reached. Strains of a thousandth leave that part of the difference to a neo-Hookean spring."""
    back, scale = 4e5, 0.05
    sim, body = block(kinematic_modulus=back)
    closed = OneDimension(back)
    for strain in 0.05 * scale * np.concatenate([np.linspace(0, 8, 9)[1:], np.linspace(8, -8, 17)[1:]]):
        stretched(body, strain)
        report = sim.step()
        stored, lost = closed.step(strain)
        tiny = 1e-3 * YIELD * 0.02
        assert report.energy["elastic"] / VOLUME == pytest.approx(stored, rel=5e-3, abs=tiny)
        assert report.energy["damping"] / VOLUME == pytest.approx(lost, rel=5e-3, abs=tiny)
        assert slip_of(sim) == pytest.approx(closed.slip, rel=5e-3, abs=1e-9)
    assert closed.slip > 0.03


def test_kinematic_hardening_at_finite_strain() -> None:
    """The part r = 3 mu/(3 mu + H_k) yields, beside a neo-Hookean spring of the rest, within 1e-6."""
    back = 4e5
    r = 3 * MU / (3 * MU + back)
    sim, body = block(kinematic_modulus=back)
    flow = slip = 0.0
    for strain in np.concatenate([np.linspace(0.0, 0.2, 11)[1:], np.linspace(0.2, -0.1, 16)[1:]]):
        stretched(body, strain)
        report = sim.step()
        trial = 3 * MU * (strain - flow)
        step = max(abs(trial) - YIELD - HARDENING * slip, 0.0) / (3 * MU + r * HARDENING)
        flow, slip = flow + np.copysign(step, trial), slip + r * step
        spring = 0.5 * MU * (1 - r) * (np.exp(2 * strain) + 2 * np.exp(-strain) - 3)
        stored = spring + 1.5 * MU * r * (strain - flow) ** 2 + 0.5 * HARDENING * slip**2
        assert report.energy["elastic"] / VOLUME == pytest.approx(stored, rel=1e-6)
        assert slip_of(sim) == pytest.approx(slip, rel=1e-6, abs=1e-12)


def test_at_a_constant_rate_the_overstress_is_the_viscosity_times_the_rate() -> None:
    viscosity, rate, step = 2e3, 2.0, 1e-3
    sim, body = block(hardening=0.0, step=step, viscosity=viscosity)
    for k in range(1, 31):
        stretched(body, rate * step * k)
        report = sim.step()
        assert not report.failed
        assert report.energy["damping"] >= -1e-12
    stress = 3 * MU * (rate * sim.time - slip_of(sim))
    assert stress == pytest.approx(YIELD + viscosity * rate, rel=1e-6)


def test_overstress_relaxes_exponentially_and_with_order_one() -> None:
    """At constant strain exp(-3 mu t / viscosity), of implicit Euler in each step 1/(1 + 3 mu h /
    viscosity)."""
    viscosity, until = 6e4, 0.02  # a relaxation time of 20 ms

    def error(step: float) -> float:
        sim, body = block(hardening=0.0, step=step, viscosity=viscosity)
        stretched(body, 0.02)
        over = 3 * MU * 0.02 - YIELD
        for _ in range(round(until / step)):
            assert not sim.step().failed
            over /= 1 + 3 * MU * step / viscosity
        found = 3 * MU * (0.02 - slip_of(sim)) - YIELD
        assert found == pytest.approx(over, rel=1e-6)
        return abs(found / (3 * MU * 0.02 - YIELD) - np.exp(-3 * MU * until / viscosity))

    assert error(2e-3) / error(1e-3) == pytest.approx(2.0, rel=0.1)


def test_slow_flow_is_that_without_viscosity() -> None:
    paths = []
    for more, step in (({}, 0.01), ({"viscosity": 1.0}, 1e3)):
        sim, body = block(step=step, **more)
        stretched(body, 0.03)
        sim.step()
        paths.append(slip_of(sim))
    assert paths[0] == pytest.approx(paths[1], rel=1e-6)


INCREASE, RATE = 3e4, 40.0  # [Pa], 1


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a falling function is 0, by bisection."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return low


@pytest.mark.parametrize(
    ("increase", "rate", "back", "viscosity"),
    [(INCREASE, RATE, 0.0, 0.0), (INCREASE, RATE, 4e5, 0.0), (2e5, 100.0, 0.0, 0.0), (3e4, 40.0, 0.0, 2e3)],
)
def test_hardening_that_saturates(increase: float, rate: float, back: float, viscosity: float) -> None:
    """Loading, unloading and reversal against Y(p) = Y0 + H p + Q (1 - exp(-b p)), whose slips are found by
    bisection; Q b is 7 times 3 mu in the third case. Stored energy and dissipation, too."""
    more = {"kinematic_modulus": back, "saturation_increase": increase, "saturation_rate": rate}
    step = 1e-2
    sim, body = block(step=step, **more, **({"viscosity": viscosity} if viscosity else {}))
    r = 3 * MU / (3 * MU + back)
    over = viscosity / step
    flow = p = 0.0

    def growth(p: float) -> float:
        return HARDENING * p + increase * (1 - np.exp(-rate * p))

    path = np.concatenate([np.linspace(0.0, 0.1, 9)[1:], np.linspace(0.1, -0.1, 9)[1:]])
    for strain in path:
        stretched(body, strain)
        report = sim.step()
        assert not report.failed
        trial = 3 * MU * (strain - flow)
        before = p
        if abs(trial) > YIELD + growth(p):
            slip = root(
                lambda s, trial=trial, p=p: (
                    abs(trial) - 3 * MU * s - YIELD - growth(p + r * s) - over * r * s
                ),
                0.0,
                abs(trial) / (3 * MU),
            )
            flow, p = flow + np.copysign(slip, trial), p + r * slip
        assert slip_of(sim) == pytest.approx(p, rel=1e-6, abs=1e-12)
        hardening = 0.5 * HARDENING * p**2 + increase * (p + (np.exp(-rate * p) - 1) / rate)
        spring = 0.5 * MU * (1 - r) * (np.exp(2 * strain) + 2 * np.exp(-strain) - 3)
        stored = spring + 1.5 * MU * r * (strain - flow) ** 2 + hardening
        assert report.energy["elastic"] / VOLUME == pytest.approx(stored, rel=1e-6)
        lost = (YIELD + over * (p - before)) * (p - before)
        if p > before or not viscosity:  # overstress that is left also relaxes while nothing flows [10c]
            tiny = 1e-5 * YIELD * 0.01
            assert report.energy["damping"] / VOLUME == pytest.approx(lost, rel=1e-5, abs=tiny)
    assert p > 0.08


def test_plastic_flow_keeps_the_volume_and_rotations_store_nothing() -> None:
    sim, body = block()
    deform(body, np.array([[1.0, 0.0, 0.08], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    sim.step()
    metric = sim.state.arrays()["internal_variable"].reshape(-1, 10)[:, :9].reshape(-1, 3, 3)
    assert np.abs(metric - np.eye(3)).max() > 0.01
    np.testing.assert_allclose(np.linalg.det(metric), 1.0, atol=1e-12)
    np.testing.assert_allclose(metric, np.swapaxes(metric, 1, 2), atol=1e-12)
    slip = sim.state.arrays()["internal_variable"].reshape(-1, 10)[:, 9].copy()
    angle = 0.1
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
    deform(body, turn @ np.array([[1.0, 0.0, 0.08], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    sim.step()
    after = sim.state.arrays()["internal_variable"].reshape(-1, 10)
    np.testing.assert_allclose(after[:, 9], slip, atol=1e-9)
    np.testing.assert_allclose(after[:, :9].reshape(-1, 3, 3), metric, atol=1e-8)


def test_derivatives_are_those_of_the_energy() -> None:
    report = stark.j2_plasticity.check(
        shear_modulus=MU, bulk_modulus=BULK, yield_stress=YIELD, hardening_modulus=HARDENING,
        saturation_increase=INCREASE, saturation_rate=RATE,
    )  # fmt: skip
    assert {f.name: f.status for f in report.findings}["stress"] == "ok", str(report)


def test_ranges_are_checked() -> None:
    with pytest.raises(stark.InvalidArgument, match="yield_stress"):
        stark.j2_plasticity(shear_modulus=MU, bulk_modulus=BULK, yield_stress=-1.0, density=1000.0)
