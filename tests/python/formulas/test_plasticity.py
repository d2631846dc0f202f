"""J2 plasticity against its closed form: loading, unloading and reversal, stored and dissipated energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

MU, BULK, YIELD, HARDENING = 1e6, 2e6, 2e4, 5e4  # [Pa]
EXACT: dict[str, Any] = {
    "contact.enabled": False,
    "time.integrator": "quasistatic",
    "newton.acceleration_tolerance": 0.0,
    "newton.residual_tolerance": 1e-10,
}
VOLUME = 1e-3  # [m^3]
TINY = 1e-8 * YIELD  # [J/m^3]


def block(element: str = "tet4", hardening: float = HARDENING) -> tuple[stark.Simulation, Any]:
    """A block whose surface is prescribed, with free vertices inside."""
    scene = stark.Scene()
    mesh: Any = stark.mesh.tet_box(0.1, 2) if element == "tet4" else stark.mesh.box_hexahedra(0.1, 2)
    law = stark.j2_plasticity(
        shear_modulus=MU, bulk_modulus=BULK, yield_stress=YIELD, hardening_modulus=hardening, density=1000.0
    )
    inside = np.abs(mesh.vertices).max(axis=1) < 0.049
    body = scene.add_solid(mesh, law, pins=np.flatnonzero(~inside))
    return stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), **EXACT), body


def deform(body: Any, F: np.ndarray) -> None:
    body.pin_targets = np.asarray(body.mesh.vertices)[body.pins] @ F.T


class OneDimension:
    """The same law of an equivalent strain: spring 3 mu, slider, linear hardening."""

    def __init__(self) -> None:
        self.flow = self.slip = 0.0

    def step(self, strain: float) -> tuple[float, float]:
        """Stored energy and dissipation of the step per volume [J/m^3]."""
        trial = 3 * MU * (strain - self.flow)
        excess = max(abs(trial) - YIELD - HARDENING * self.slip, 0.0) / (3 * MU + HARDENING)
        self.flow += np.copysign(excess, trial)
        self.slip += excess
        stored = 1.5 * MU * (strain - self.flow) ** 2 + 0.5 * HARDENING * self.slip**2
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
        shear_modulus=MU, bulk_modulus=BULK, yield_stress=YIELD, hardening_modulus=HARDENING
    )
    assert {f.name: f.status for f in report.findings}["stress"] == "ok", str(report)


def test_ranges_are_checked() -> None:
    with pytest.raises(stark.InvalidArgument, match="yield_stress"):
        stark.j2_plasticity(shear_modulus=MU, bulk_modulus=BULK, yield_stress=-1.0, density=1000.0)
