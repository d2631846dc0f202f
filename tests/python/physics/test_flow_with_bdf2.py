"""Internal variables that flow at a rate, and rates in formulas of users, with bdf2: order of convergence,
exact relaxation, dissipation, the same bits everywhere, certificates."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _mechanisms import observed_order
from formulas._laws import maxwell

import stark
from stark.recording import Recorder
from stark.verify import verify

EXACT: dict[str, Any] = {
    "contact.enabled": False,
    "newton.acceleration_tolerance": 1e-8,
    "newton.step_tolerance": 1e-11,
}
STEPS = (0.008, 0.004, 0.002)  # [s]
ORDERS = [("implicit_euler", 1), ("bdf2", 2)]


@stark.material
def maxwell_and_dashpot(
    F: stark.DeformationGradient,
    F_prev: stark.DeformationGradient,
    h: stark.TimeStep,
    modulus: float = stark.parameter(unit="Pa", above=0.0),
    viscosity: float = stark.parameter(unit="Pa s", above=0.0),
    flow: stark.Mat3 = stark.internal(0.0, doc="strain of the dashpot of the branch"),
) -> Any:
    """The same with a dashpot beside it: rates of what the step knows, and of what is remembered."""
    E, E_prev = (0.5 * (A.T @ A - stark.identity(3)) for A in (F, F_prev))
    ratio, trial = h / 0.1, E - flow
    psi = modulus * stark.squared_norm(E) + modulus / (1 + ratio) * stark.squared_norm(trial)
    psi = psi + 0.5 * viscosity / h * stark.squared_norm(E - E_prev)
    return psi, {"flow": flow + ratio / (1 + ratio) * trial}


PRONY = stark.generalized_maxwell(
    shear_modulus=3e3, bulk_modulus=1e4, moduli=[5e3, 2e3], times=[0.02, 0.2], density=200.0
)
RUBBER = stark.RodMaterial(density=200.0, youngs_modulus=1e3, radius=0.2)
FILM = stark.ShellMaterial(
    density=200.0, thickness=1.0, youngs_modulus=2e3, poissons_ratio=0.3, bending_stiffness=0.0
)
SOLIDS: dict[str, Any] = {
    "solid": PRONY,
    "solid_and_damping": PRONY.replace(strain_damping=100.0),
    "perzyna": stark.j2_viscoplasticity(
        shear_modulus=4e3,
        bulk_modulus=1e4,
        yield_stress=50.0,
        viscosity=400.0,
        hardening_modulus=300.0,
        density=200.0,
    ),
    "implicit_euler_of_users": maxwell(modulus=3e3, branch=5e3, relaxation=0.05, density=200.0),
    "rates_and_memory_of_users": maxwell_and_dashpot(modulus=3e3, viscosity=100.0, density=200.0),
}


def block(scene: stark.Scene, material: Any) -> Any:
    """A cube of 1 m whose upper face slides and twists away from the held lower one."""
    mesh = stark.mesh.box_hexahedra(1.0, 1)
    X = np.asarray(mesh.vertices)
    v = np.where(X[:, 2:] > 0.0, np.column_stack([0.5 - X[:, 1], 0.4 * X[:, 0], 0.2 + 0.0 * X[:, 0]]), 0.0)
    body = scene.add_solid(mesh, material, pins=np.flatnonzero(X[:, 2] < 0.0), self_contact=False)
    return body, v


def final(kind: str, integrator: str, step: float, until: float = 0.16) -> np.ndarray:
    """Positions at the end, and the internal variables."""
    scene = stark.Scene()
    if kind in SOLIDS:
        body, velocities = block(scene, SOLIDS[kind])
    elif kind == "rod":
        material = stark.generalized_maxwell_rod(RUBBER, moduli=[2e3], times=[0.05])
        line = stark.mesh.polyline((0, 0, 0), (1, 0, 0), 3)
        body = scene.add_rod(line, material, clamps=[0], velocity=(0.2, 0.6, 0.4), self_contact=False)
        velocities = None
    else:
        mesh = stark.mesh.grid(1.0, 1.0, 2)
        X = np.asarray(mesh.vertices)
        film = stark.generalized_maxwell_shell(FILM, moduli=[3e3], times=[0.05])
        body = scene.add_cloth(mesh, film, pins=np.flatnonzero(X[:, 0] < -0.49), self_contact=False)
        velocities = np.column_stack([0.3 + 0.2 * X[:, 1], 0.4 * X[:, 0], 0.0 * X[:, 0]])
        velocities[body.pins] = 0.0
    settings = {**EXACT, "time.integrator": integrator}
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **settings)
    if velocities is not None:
        sim[body].velocities = velocities
    for report in sim.run(until):
        assert report.status == "accepted", report.message
        assert report.energy["damping"] >= -1e-11, report.energy
    arrays = sim.state.arrays()
    assert np.abs(arrays["internal_variable"]).max() > 1e-3
    return np.concatenate([np.asarray(body.positions).ravel(), 0.1 * arrays["internal_variable"]])


@pytest.mark.parametrize(("integrator", "order"), ORDERS)
@pytest.mark.parametrize("kind", [*SOLIDS, "rod", "shell"])
def test_flow_is_of_the_order_of_the_integrator(kind: str, integrator: str, order: int) -> None:
    found = observed_order(*(final(kind, integrator, h) for h in STEPS))
    assert found == pytest.approx(order, abs=0.2)


def held(step: float, strain: float, material: Any = None, **settings: Any) -> stark.Simulation:
    """A cube of one hexahedron, sheared by its pins within the first step and then held."""
    scene = stark.Scene()
    mesh = stark.mesh.box_hexahedra(0.1, 1)
    material = material or stark.generalized_maxwell(
        shear_modulus=1e5, bulk_modulus=1e6, moduli=[2e5, 5e4], times=[0.1, 1.0], density=1.0
    )
    scene.add_solid(mesh, material, pins=range(8), name="block")
    settings = {**EXACT, "time.integrator": "bdf2", **settings}
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **settings)
    shear(sim, strain)
    return sim


def shear(sim: stark.Simulation, strain: float) -> None:
    X = np.asarray(sim["block"].mesh.vertices)
    sim["block"].pin_targets = X @ np.array([[1, 0, strain], [0, 1, 0], [0, 0, 1.0]]).T


@pytest.mark.parametrize("step", [0.03, 0.3])
def test_relaxation_at_constant_strain_is_exact(step: float) -> None:
    """Dashpots reach E (1 - exp(-t / tau)), also in steps of three times tau."""
    sim, strain = held(step, 2e-3), 2e-3
    for _ in range(8):
        report = sim.step()
        assert not report.failed
        flows = sim.state.arrays()["internal_variable"].reshape(-1, 2, 3, 3)
        for k, time in enumerate((0.1, 1.0)):
            expected = 0.5 * strain * (1.0 - np.exp(-sim.time / time))
            assert flows[:, k, 0, 2] == pytest.approx(expected, rel=1e-4)
        assert report.energy["damping"] > 0.0
    assert report.integrator == "bdf2"


@pytest.mark.parametrize("step", [1e-3, 0.03, 1.0, 100.0])
@pytest.mark.parametrize("law", ["prony", "implicit_euler_of_users", "perzyna"])
def test_dissipation_is_never_negative(law: str, step: float) -> None:
    """Strains that jump to and fro, in steps of any length over the relaxation times."""
    material = None if law == "prony" else SOLIDS[law]
    sim = held(step, 0.0, material)
    lost = 0.0
    for strain in (0.05, -0.1, 0.02, 0.02, 0.15, 0.0, -0.05, -0.05):
        shear(sim, strain)
        report = sim.step()
        assert not report.failed, report.message
        size = sum(abs(value) for value in report.energy.values())
        assert report.energy["damping"] >= -1e-12 * size
        lost += report.energy["damping"]
    assert lost > 0.0


def bits(law: str, path: Path | None = None, **settings: Any) -> str:
    """Hash after twelve steps, the last six after a rewind, or from a checkpoint at `path`."""
    scene = stark.Scene()
    body, velocities = block(scene, SOLIDS[law])
    settings = {"time.integrator": "bdf2", "contact.enabled": False, **settings}
    sim = stark.Simulation(scene, time_step=5e-3, **settings)
    sim[body].velocities = velocities
    sim.run_until(0.03)
    middle = sim.state
    if path is not None:
        sim.save(path)
        sim = stark.Simulation(scene, time_step=5e-3, **settings)
        sim.load(path)
    else:
        sim.run_until(0.06)
        sim.state = middle
    sim.run_until(0.06)
    return str(sim.state.hash)


@pytest.mark.parametrize("law", ["solid_and_damping", "perzyna"])
def test_the_same_bits_everywhere(law: str, tmp_path: Path) -> None:
    hashes = {
        bits(law),
        bits(law, tmp_path / "saved.stark"),
        bits(law, None, **{"execution.threads": 3, "execution.oversubscribe": True}),
        bits(law, None, **{"execution.backend": "interpreter"}),
    }
    assert len(hashes) == 1


def lengths(p: stark.Point) -> tuple[Any, Any]:
    """Of the line from the origin, at the end and at the start of the step."""
    return stark.norm(p.x), stark.norm(p.x_prev)


@stark.energy
def damper(p: stark.Point, h: stark.TimeStep, viscosity: float) -> Any:
    now, before = lengths(p)
    return 0.5 * viscosity / h * (now - before) ** 2


@stark.energy
def cubic_damper(p: stark.Point, h: stark.TimeStep, viscosity: float) -> Any:
    """Force: the square of the rate of the logarithm of the length."""
    now, before = lengths(p)
    rate = (stark.log(now) - stark.log(before)) / h
    return viscosity / 3 * h * abs(rate) ** 3


@pytest.mark.parametrize(("integrator", "order"), ORDERS)
@pytest.mark.parametrize("law", [damper, cubic_damper])
def test_rates_in_formulas_are_of_the_order_of_the_integrator(law: Any, integrator: str, order: int) -> None:
    """A weight that flies past the origin, on a line that damps."""

    def end(step: float) -> np.ndarray:
        scene = stark.Scene()
        box = scene.add_box(0.1, mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.5, 2.0, 0.0))
        scene.add(law(box.points([[0, 0, 0]]), viscosity=5.0))
        settings = {**EXACT, "time.integrator": integrator}
        sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **settings)
        sim.run_until(0.4)
        return np.asarray(box.position)

    assert observed_order(*(end(h) for h in (0.02, 0.01, 0.005))) == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_ledgers_close_with_steps_of_any_length(integrator: str, tmp_path: Path) -> None:
    """What branches store is the same at the end of a step and at the start of the next, shorter one."""
    scene = stark.Scene("relaxing")
    mesh = stark.mesh.tet_box(1.0, 1)
    lower = np.flatnonzero(np.asarray(mesh.vertices)[:, 2] < 0.0)
    scene.add_solid(mesh, PRONY, pins=lower, velocity=(0.5, 0.0, 0.2), self_contact=False)
    sim = stark.Simulation(scene, time_step=0.01, **{**EXACT, "time.integrator": integrator})
    with Recorder(tmp_path / "run", sim, scene=scene.name, certify=True) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        for longest in (1.0, 1.0, 0.004, 0.002, 1.0, 0.005, 1.0):
            recorder.report(sim.step(max_time_step=longest))
            recorder.record_state(sim)
        recorder.record(sim)
    certificate = verify(tmp_path / "run")
    assert certificate["energy_ledger"].status == "verified", certificate.text()
    for name in ("reported_energies", "reported_momentum"):
        assert certificate[name].status == "verified", certificate.text()
        assert certificate[name].detail == ""
