"""The generalised Maxwell model against its closed forms: relaxation, creep, storage and loss; its ledger."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

SHEAR, BULK = 1e5, 1e6  # [Pa]
EXACT: dict[str, Any] = {
    "contact.enabled": False,
    "newton.acceleration_tolerance": 0.0,
    "newton.residual_tolerance": 1e-12,
    "newton.step_tolerance": 0.0,
}
SIDE = 0.1  # [m]


def law(moduli: tuple[float, ...], times: tuple[float, ...], density: float = 1e-3) -> stark.SolidMaterial:
    return stark.generalized_maxwell(
        shear_modulus=SHEAR, bulk_modulus=BULK, moduli=moduli, times=times, density=density
    )


def block(material: stark.SolidMaterial, step: float, pins: Any, mesh: Any = None) -> stark.Simulation:
    scene = stark.Scene()
    scene.add_solid(mesh or stark.mesh.tet_box(SIDE, 1), material, pins=pins, name="block")
    return stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **EXACT)


def sheared(mesh: Any, strain: float) -> np.ndarray:
    return np.asarray(mesh.vertices) @ np.array([[1, 0, strain], [0, 1, 0], [0, 0, 1.0]]).T


@pytest.mark.parametrize("mesh", [stark.mesh.tet_box(SIDE, 1), stark.mesh.box_hexahedra(SIDE, 1)])
def test_stress_relaxes_as_the_prony_series(mesh: Any) -> None:
    """At constant strain, for steps of any length: dashpots reach E (1 - exp(-t / tau))."""
    moduli, times, strain = (2e5, 5e4), (0.1, 1.0), 2e-3
    sim = block(law(moduli, times), 0.03, range(len(mesh.vertices)), mesh)
    sim["block"].pin_targets = sheared(mesh, strain)[sim["block"].pins]
    for _ in range(20):
        report = sim.step()
        assert not report.failed
        flows = sim.state.arrays()["internal_variable"].reshape(-1, 2, 3, 3)
        for k, time in enumerate(times):
            expected = 0.5 * strain * (1.0 - np.exp(-sim.time / time))
            assert flows[:, k, 0, 2] == pytest.approx(expected, rel=1e-4)
            assert flows[:, k, 0, 2] == pytest.approx(flows[:, k, 2, 0])
        assert report.energy["damping"] > 0.0


def test_a_wire_relaxes_as_the_prony_series() -> None:
    """Pulled to a stretch and held: dashpots of all segments reach e (1 - exp(-t / tau)), for steps of any
    length; the first work, force over the way, has the modulus after the step."""
    wire = stark.RodMaterial(density=1e-3, youngs_modulus=1e8, radius=1e-3)
    moduli, times, stretch = (2e8, 5e7), (0.1, 1.0), 1e-3
    made = stark.generalized_maxwell_rod(wire, moduli=moduli, times=times)
    scene = stark.Scene()
    points = stark.mesh.polyline((0, 0, 0), (0.2, 0, 0), 4).vertices
    rod = scene.add_rod(points, made, pins=range(5))
    sim = stark.Simulation(scene, time_step=0.03, gravity=(0, 0, 0), **EXACT)
    sim[rod].pin_targets = np.asarray(points) * (1 + stretch)
    for step in range(20):
        report = sim.step()
        assert not report.failed
        flows = sim.state.arrays()["internal_variable"].reshape(4, 2, 4)
        for k, time in enumerate(times):
            expected = stretch * (1.0 - np.exp(-sim.time / time))
            assert flows[:, k, 0] == pytest.approx(expected, rel=1e-4)
        assert report.energy["damping"] > 0.0
        if step == 0:
            felt = 1e8 + sum(m * np.exp(-0.03 / t) for m, t in zip(moduli, times, strict=True))
            exact = felt * np.pi * 1e-6 * stretch**2 * 0.2
            assert report.energy["external"] == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("kind", ["solid", "hexahedra", "sheet", "wire"])
@pytest.mark.parametrize("step", [0.03, 0.5])
def test_what_relaxes_is_dissipated(kind: str, step: float) -> None:
    """Held at a strain, no work is done: the stored energy falls as E + sum E_k exp(-2 t/tau_k) over E + sum
    E_k, each step dissipates what it falls by, and nothing is left for the integrator, whatever the step."""
    moduli, times = (2.0, 0.5), (0.1, 1.0)  # over the modulus that stays
    scene = stark.Scene()
    stretch = 1e-3 * np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0.0]])
    if kind == "wire":
        wire = stark.RodMaterial(density=1e-3, youngs_modulus=1e8, radius=1e-3)
        made: Any = stark.generalized_maxwell_rod(wire, moduli=[1e8 * m for m in moduli], times=times)
        X = np.asarray(stark.mesh.polyline((0, 0, 0), (0.2, 0, 0), 4).vertices)
        body: Any = scene.add_rod(X, made, pins=range(5))
        stretch = np.diag([1e-3, 0, 0])
    elif kind == "sheet":
        film = stark.ShellMaterial(density=1e-3, thickness=1e-3, youngs_modulus=1e5, poissons_ratio=0.3)
        made = stark.generalized_maxwell_shell(film, moduli=[1e5 * m for m in moduli], times=times)
        mesh: Any = stark.mesh.grid(SIDE, SIDE, cells=2)
        X = np.asarray(mesh.vertices)
        body = scene.add_cloth(mesh, made, pins=range(len(X)))
    else:
        solids = {"solid": stark.mesh.tet_box, "hexahedra": stark.mesh.box_hexahedra}
        mesh = solids[kind](SIDE, 1)
        X = np.asarray(mesh.vertices)
        made = law(tuple(SHEAR * m for m in moduli), times)
        body = scene.add_solid(mesh, made, pins=range(len(X)))
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **EXACT)
    sim[body].pin_targets = X @ (np.eye(3) + stretch)

    def held(time: float) -> float:
        return 1.0 + sum(m * np.exp(-2 * time / t) for m, t in zip(moduli, times, strict=True))

    stored, dissipated = sim.step().energy["elastic"], 0.0
    for _ in range(10):
        report = sim.step()
        assert not report.failed
        energy = report.energy
        dissipated += energy["damping"]
        # Solids and sheets are not quite linear at strains of a thousandth.
        assert energy["elastic"] / stored == pytest.approx(held(sim.time) / held(step), rel=1e-5)
        assert dissipated == pytest.approx(stored * (1 - held(sim.time) / held(step)), rel=1e-4)
        assert abs(energy["numerical"]) < 1e-9 * stored and abs(energy["external"]) < 1e-9 * stored


def test_steady_flow_dissipates_the_power_of_the_dashpot() -> None:
    """At a constant rate of strain the branch carries G tau rate, and nothing more is stored in it: the work
    is dissipated, of first order in the step."""
    time, rate = 0.02, 0.01  # [s], of shear [1/s]

    def error(step: float) -> float:
        mesh = stark.mesh.tet_box(SIDE, 1)
        sim = block(law((2e5,), (time,)), step, range(len(mesh.vertices)), mesh)
        while sim.time < 8 * time:
            sim["block"].pin_targets = sheared(mesh, rate * (sim.time + step))[sim["block"].pins]
            report = sim.step()
        return report.energy["damping"] / (2e5 * time * rate**2 * SIDE**3 * step) - 1.0

    errors = [error(step) for step in (4e-3, 2e-3)]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert abs(errors[1]) < 0.05


def test_a_bent_wire_creeps() -> None:
    """A couple at the end of a clamped wire: its curvature is M/B (1 - E1/(E + E1) exp(-t E/(tau (E + E1))))
    and of first order in the step."""
    wire = stark.RodMaterial(density=1e-3, youngs_modulus=1e8, radius=1e-3)
    made = stark.generalized_maxwell_rod(wire, moduli=[1e8], times=[0.2])

    @stark.energy
    def couple(node: stark.Frame, moment: float):
        return -moment * stark.atan2(-node.z.z, node.z.x)

    def angles(step: float) -> np.ndarray:
        scene = stark.Scene()
        rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.1, 0, 0), 5), made, clamps=[0])
        scene.add(couple(rod.frame(5), moment=1e-3 * wire.section["bending_stiffness_1"]))
        sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **EXACT)
        rows = []
        while sim.time < 0.4 - 0.5 * step:
            assert not sim.step().failed
            z = sim[rod].frames[5, :, 2]
            rows.append((sim.time, np.arctan2(-z[2], z[0])))
        return np.array(rows)

    def error(step: float) -> float:
        rows = angles(step)
        exact = 1e-4 * (1.0 - 0.5 * np.exp(-rows[:, 0] * 0.5 / 0.2))
        late = rows[:, 0] > 0.1
        return float(np.abs(rows[late, 1] / exact[late] - 1.0).max())

    errors = [error(step) for step in (8e-3, 4e-3)]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert errors[1] < 5e-3


def test_a_membrane_relaxes_as_the_prony_series() -> None:
    film = stark.ShellMaterial(density=1e-3, thickness=1e-3, youngs_modulus=1e5, poissons_ratio=0.3)
    moduli, times, strain = (2e5, 5e4), (0.1, 1.0), 1e-3
    made = stark.generalized_maxwell_shell(film, moduli=moduli, times=times)
    scene = stark.Scene()
    mesh = stark.mesh.grid(SIDE, SIDE, cells=2)
    X = np.asarray(mesh.vertices)
    sheet = scene.add_cloth(mesh, made, pins=range(len(X)))
    sim = stark.Simulation(scene, time_step=0.03, gravity=(0, 0, 0), **EXACT)
    sim[sheet].pin_targets = X @ np.array([[1, strain, 0], [0, 1, 0], [0, 0, 1.0]]).T
    for step in range(20):
        report = sim.step()
        assert not report.failed
        flows = sim.state.arrays()["internal_variable"].reshape(-1, 2, 2, 2)
        for k, time in enumerate(times):
            size = np.linalg.norm(flows[:, k], axis=(1, 2))
            expected = strain * np.sqrt(0.5) * (1.0 - np.exp(-sim.time / time))
            assert size == pytest.approx(expected, rel=1e-3)
        assert report.energy["damping"] > 0.0
        if step == 0:
            felt = 1e5 + sum(m * np.exp(-0.03 / t) for m, t in zip(moduli, times, strict=True))
            exact = felt / 2.6 * strain**2 * SIDE**2 * 1e-3
            assert report.energy["external"] == pytest.approx(exact, rel=1e-3)


def creep(step: float, until: float, modulus: float, time: float) -> list[tuple[float, float]]:
    """Times and shear strains of a block under a constant shear stress of 100 Pa."""
    mesh = stark.mesh.tet_box(SIDE, 1)
    X, tets = np.asarray(mesh.vertices), np.asarray(mesh.tets)
    stress, forces = np.zeros((3, 3)), np.zeros_like(X)
    stress[0, 2] = stress[2, 0] = 100.0
    for tet in tets:  # nodal forces of a uniform stress: V sigma grad N
        edges = (X[tet[1:]] - X[tet[0]]).T
        gradients = np.linalg.inv(edges)
        gradients = np.vstack([-gradients.sum(axis=0), gradients])
        forces[tet] += abs(np.linalg.det(edges)) / 6.0 * gradients @ stress
    bottom = np.flatnonzero(X[:, 2] < -0.049)
    scene = stark.Scene()
    body = scene.add_solid(mesh, law((modulus,), (time,)), pins=bottom, name="block")
    for k in np.flatnonzero(X[:, 2] > -0.049):
        scene.add_force(body.vertices[[int(k)]], tuple(forces[k]))
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **EXACT)
    top, found = X[:, 2] > 0.049, []
    while sim.time < until - 0.5 * step:
        assert not sim.step().failed
        moved = sim["block"].positions[top, 0] - X[top, 0]
        found.append((sim.time, float(moved.mean()) / SIDE))
    return found


def test_creep_under_a_constant_load() -> None:
    """s/G (1 - G1/(G + G1) exp(-t G / (tau (G + G1)))): within 1e-4, of first order in the step."""
    modulus, time = 1e5, 0.2

    def error(step: float) -> float:
        rows = np.array(creep(step, 0.4, modulus, time))
        ratio = modulus / (SHEAR + modulus)
        exact = 100.0 / SHEAR * (1.0 - ratio * np.exp(-rows[:, 0] * (1.0 - ratio) / time))
        late = rows[:, 0] > 0.1
        return float(np.abs(rows[late, 1] / exact[late] - 1.0).max())

    errors = [error(step) for step in (4e-3, 2e-3, 1e-4)]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert errors[2] < 1e-4


def test_slow_is_soft_and_fast_is_stiff() -> None:
    """Energy of a shear within one step: that of the instantaneous and of the long-term modulus."""
    mesh, strain = stark.mesh.tet_box(SIDE, 1), 1e-3
    for step, modulus in ((1e-6, SHEAR + 3e5), (1e3, SHEAR)):
        sim = block(law((3e5,), (0.1,)), step, range(len(mesh.vertices)), mesh)
        sim["block"].pin_targets = sheared(mesh, strain)[sim["block"].pins]
        report = sim.step()
        energy = report.energy["elastic"] + report.energy["damping"]
        assert energy == pytest.approx(0.5 * modulus * strain**2 * SIDE**3, rel=1e-3)


def test_damping_is_never_negative_and_grows_with_the_branch() -> None:
    """A block that is set swinging; what the dashpots take is a part of its energy at the start."""
    mesh = stark.mesh.tet_box(SIDE, 3)
    bottom = np.flatnonzero(np.asarray(mesh.vertices)[:, 2] < -0.049)

    def lost(modulus: float) -> float:
        scene = stark.Scene()
        material = law((modulus,), (0.05,), 1000.0)
        scene.add_solid(mesh, material, pins=bottom, velocity=(0.3, 0.0, 0.0), name="block")
        sim = stark.Simulation(scene, time_step=2e-3, gravity=(0, 0, 0))
        reports = [sim.step() for _ in range(50)]
        assert all(not r.failed and r.energy["damping"] >= -1e-12 for r in reports)
        return sum(r.energy["damping"] for r in reports)

    moving = 0.5 * 0.3**2 * 1000.0 * SIDE**3
    weak, strong = lost(1e3), lost(5e4)
    assert 1e-4 * moving < weak < 0.2 * strong < 0.2 * moving


def test_same_bits_with_threads_and_after_a_rewind() -> None:
    hashes = []
    for threads in (1, 3):
        mesh = stark.mesh.tet_box(SIDE, 4)
        scene = stark.Scene()
        scene.add_solid(mesh, law((5e4, 2e4), (0.05, 0.5), 1000.0), pins=[0, 1, 2], name="block")
        options = {"execution.threads": threads, "execution.oversubscribe": True}
        sim = stark.Simulation(scene, time_step=5e-3, **options)
        sim.run_until(0.05)
        kept = sim.state
        sim.run_until(0.1)
        hashes.append(sim.state.hash)
        sim.state = kept
        sim.run_until(0.1)
        hashes.append(sim.state.hash)
    assert len(set(hashes)) == 1


def test_bases_of_shells_and_rods_are_elastic() -> None:
    series: dict[str, Any] = {"moduli": [1e6], "times": [0.1]}
    with pytest.raises(stark.InvalidArgument, match=r"must be a stark\.RodMaterial"):
        stark.generalized_maxwell_rod(stark.ShellMaterial(), **series)
    with pytest.raises(stark.InvalidArgument, match="what relaxes does not yield"):
        stark.generalized_maxwell_rod(stark.RodMaterial(yield_stress=1e6), **series)
    with pytest.raises(stark.InvalidArgument, match="must have none"):
        stark.generalized_maxwell_shell(
            stark.generalized_maxwell_shell(stark.ShellMaterial(), **series), **series
        )
    with pytest.raises(stark.InvalidArgument, match="1 moduli and 2 times"):
        stark.generalized_maxwell_rod(stark.RodMaterial(), moduli=[1e6], times=[0.1, 1.0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"moduli": [1e4, 2e4]}, "2 moduli and 1 times: must be as many"),
        ({"moduli": 1e4}, "moduli = 10000.0: must be a sequence"),
        ({"moduli": [], "times": []}, "0 moduli: must be 1 to 20"),
        ({"times": [0.0]}, r"times\[0\] = 0 s: must be > 0"),
        ({"moduli": [-1.0]}, r"moduli\[0\] = -1 Pa: must be > 0"),
        ({"shear_modulus": -1.0}, "shear_modulus"),
    ],
)
def test_wrong_arguments_are_named(change: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"shear_modulus": 1e5, "bulk_modulus": 1e6, "moduli": [1e4], "times": [0.1]}
    with pytest.raises(stark.InvalidArgument, match=message):
        stark.generalized_maxwell(**{**given, **change}, density=1000.0)
