"""What materials remember: recorded, updated by accepted steps, rewound, saved, the same bits everywhere."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from formulas._laws import maxwell

import stark

QUIET: dict[str, Any] = {"contact.enabled": False, "newton.acceleration_tolerance": 1e-8}
STEP = 0.01


def held_block(element: str = "tet4", cells: int = 2, **settings: Any) -> tuple[stark.Simulation, Any]:
    """A block whose surface is prescribed; with two cells and more, vertices inside are free."""
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, position=(1, 0, 0))
    mesh: Any = stark.mesh.tet_box(0.1, cells) if element == "tet4" else stark.mesh.box_hexahedra(0.1, cells)
    law = maxwell(modulus=1e4, branch=3e4, relaxation=0.05, density=1000.0)
    inside = np.abs(mesh.vertices).max(axis=1) < 0.049
    body = scene.add_solid(mesh, law, pins=np.flatnonzero(~inside))
    sim = stark.Simulation(scene, time_step=STEP, gravity=(0, 0, 0), **{**QUIET, **settings})
    return sim, body


def shear(body: Any, amount: float) -> None:
    rest = np.asarray(body.mesh.vertices)[body.pins]
    body.pin_targets = rest + amount * np.outer(rest[:, 2], [1.0, 0.0, 0.0])


def internal(sim: stark.Simulation) -> np.ndarray:
    return np.array(sim.state.arrays()["internal_variable"])


@pytest.mark.parametrize("element", ["tet4", "hex8"])
def test_the_update_is_that_of_the_formula(element: str) -> None:
    sim, body = held_block(element, cells=1)
    g, ratio = 0.1, STEP / 0.05
    flow = np.zeros((3, 3))
    E = 0.5 * np.array([[0, 0, g], [0, 0, 0], [g, 0, g * g]])
    shear(body, g)
    for _ in range(5):
        assert not sim.step().failed
        flow += ratio / (1 + ratio) * (E - flow)
        values = internal(sim).reshape(-1, 3, 3)
        np.testing.assert_allclose(values, np.broadcast_to(flow, values.shape), atol=1e-8)


def test_states_rewind_and_go_on_with_the_same_bits() -> None:
    sim, body = held_block()
    shear(body, 0.1)
    for _ in range(3):
        sim.step()
    middle = pickle.loads(pickle.dumps(sim.state))
    assert np.abs(internal(sim)).max() > 1e-3
    ends = []
    for _ in range(2):
        sim.state = middle
        shear(body, -0.05)
        for _ in range(3):
            sim.step()
        ends.append(sim.state)
    assert ends[0] == ends[1]
    sim.reset()
    assert not internal(sim).any()


@pytest.mark.parametrize("settings", [{"execution.threads": 2}, {"execution.backend": "interpreter"}])
def test_threads_and_interpreter_give_the_same_bits(settings: dict[str, Any]) -> None:
    states = []
    for other in ({}, settings):
        sim, body = held_block(**other)
        shear(body, 0.1)
        for _ in range(2):
            sim.step()
        states.append(sim.state)
    assert states[0] == states[1]


def test_scenes_without_memory_have_none() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    assert internal(stark.Simulation(scene)).size == 0


def test_what_a_law_returns_is_checked() -> None:
    def record(result: Any) -> None:
        @stark.material
        def law(F: stark.DeformationGradient, memory: stark.Vec3 = stark.internal(0.0)):
            return result(stark.squared_norm(F), memory)

        _ = law.formula

    with pytest.raises(stark.TraceError, match="must return the energy and a dict"):
        record(lambda psi, memory: psi)
    with pytest.raises(stark.TraceError, match="must be all its internal variables"):
        record(lambda psi, memory: (psi, {"other": memory}))
    with pytest.raises(stark.TraceError, match="must have the shape"):
        record(lambda psi, memory: (psi, {"memory": psi}))
    with pytest.raises(stark.TraceError, match="must be finite"):
        stark.internal(np.nan)


@pytest.mark.parametrize(
    ("words", "update"),
    [
        ("a division by zero", lambda s, psi: s / 0.0),
        ("the square root of -1", lambda s, psi: stark.sqrt(s - 1.0)),
        ("the logarithm of 0", lambda s, psi: s + stark.log(psi)),
    ],
)
def test_a_law_that_remembers_what_is_not_finite_at_rest_is_refused(words: str, update: Any) -> None:
    @stark.material
    def forgetful(
        F: stark.DeformationGradient, mu: float = 1e5, seen: stark.Vec2 = stark.internal(0.0)
    ) -> Any:
        psi = 0.5 * mu * stark.squared_norm(F.T @ F - stark.identity(3))
        first, second = seen
        return psi * (1 + first), {"seen": stark.vec(first, update(second, psi))}  # seen line

    with pytest.raises(stark.InvalidArgument) as raised:
        forgetful(density=1000.0)
    text = str(raised.value)
    assert "forgetful: internal variable 'seen' is not finite after a first step at rest" in text
    assert f"it comes from {words}" in text and __file__ in text, text


def test_damage_dissipates_what_the_guide_says() -> None:
    """limit (1 - exp(-W/limit)) - W exp(-W/limit) per volume, in a cycle to the energy W."""

    @stark.material
    def damage(
        F: stark.DeformationGradient,
        mu: float = 1e5,
        bulk: float = 1e6,
        limit: float = 5e4,
        peak: float = stark.internal(0.0),
    ) -> Any:
        J = stark.determinant(F)
        W = 0.5 * mu * (stark.trace(F.T @ F) * J ** (-2 / 3) - 3)
        at_peak = stark.exp(-peak / limit)
        loading = at_peak * peak + limit * (at_peak - stark.exp(-W / limit))
        psi = stark.where(peak < W, loading, at_peak * W)
        return psi + 0.5 * bulk * (J - 1) ** 2, {"peak": stark.maximum(W, peak)}

    scene = stark.Scene()
    mesh = stark.mesh.box_hexahedra(0.1, 1)
    block = scene.add_solid(mesh, damage(density=1000.0), pins=range(8))
    sim = stark.Simulation(scene, {"time.integrator": "quasistatic"}, time_step=STEP, gravity=(0, 0, 0))
    lost = 0.0
    for stretch in (1.1, 1.25, 1.5, 1.2, 1.0):
        block.pin_targets = mesh.vertices[block.pins] * (stretch, 1, 1)
        report = sim.step()
        lost += report.energy["damping"]
    W, limit = 0.5e5 * ((1.5**2 + 2) * 1.5 ** (-2 / 3) - 3), 5e4
    exact = limit * (1 - np.exp(-W / limit)) - W * np.exp(-W / limit)
    assert lost == pytest.approx(exact * 1e-3, rel=1e-9)
    assert report.energy["elastic"] == pytest.approx(0.0, abs=1e-9)


def test_a_start_that_leaves_nothing_to_remember_is_refused() -> None:
    """At rest all is well, but the body starts in another shape."""

    @stark.material
    def forgetful(F: stark.DeformationGradient, mu: float = 1e5, left: float = stark.internal(0.0)) -> Any:
        E = 0.5 * (F.T @ F - stark.identity(3))
        return mu * (stark.squared_norm(E) + 1e-9 * left), {"left": stark.sqrt(0.3 - E[2, 2])}

    for mesh in (stark.mesh.tet_box(0.1, 1), stark.mesh.box_hexahedra(0.1, 1)):
        scene = stark.Scene()
        scene.add_solid(
            mesh, forgetful(density=1e3), name="block", initial_positions=mesh.vertices * (1, 1, 1.5)
        )
        with pytest.raises(stark.InvalidArgument) as raised:
            stark.Simulation(scene)
        assert "internal variable 'left' of law 'forgetful' is not finite" in str(raised.value)
        assert "solid 'block' (vertices" in str(raised.value)


def test_laws_of_rods_remember() -> None:
    """A rod that is pulled: the dashpot follows the stretch within the step, segment by segment."""

    @stark.material
    def dashpot_rod(
        stretch: float,
        curvature: stark.Vec2,
        h: stark.TimeStep,
        stiffness: float = stark.parameter(unit="N", above=0.0),
        flow: float = stark.internal(0.0, doc="stretch of the dashpot"),
    ):
        ratio = h / 0.05
        trial = stretch - 1 - flow
        bending = 1e-3 * (curvature[0] ** 2 + curvature[1] ** 2)
        return 0.5 * stiffness / (1 + ratio) * trial**2 + bending, {
            "flow": flow + ratio / (1 + ratio) * trial
        }

    scene = stark.Scene()
    points = np.linspace([0, 0, 0], [0.4, 0, 0], 5)
    rod = scene.add_rod(points, dashpot_rod(stiffness=100.0, density=1000.0), pins=range(5))
    sim = stark.Simulation(scene, time_step=STEP, gravity=(0, 0, 0), **QUIET)
    sim[rod].pin_targets = points * 1.1
    flow, ratio = 0.0, STEP / 0.05
    for _ in range(5):
        report = sim.step()
        assert not report.failed
        flow += ratio / (1 + ratio) * (0.1 - flow)
        np.testing.assert_allclose(internal(sim), np.full(4, flow), atol=1e-9)
        assert report.energy["damping"] > 0.0


def test_energies_have_no_internal_variables() -> None:
    with pytest.raises(stark.TraceError, match=r"'seen': stark.internal is for laws of materials"):

        @stark.energy
        def memory(p: stark.Point, seen: stark.Vec3 = stark.internal(0.0)):
            return stark.squared_norm(p.x - seen), {"seen": p.x}
