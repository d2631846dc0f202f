"""Energies of totals: the same as energies of one large stencil, any solver; files; what is refused."""

from __future__ import annotations

import json
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import stark

REST = 0.7
STILL = (0.0, 0.0, 0.0)


@stark.energy
def cable(e: stark.Edge, rest: float = REST, stiffness: float = 200.0):
    """Length of all edges together."""
    return 0.5 * stiffness * (stark.total(e.length, "length") - rest) ** 2


@stark.energy
def one_cable(p: stark.Stencil[4], rest: float = REST, stiffness: float = 200.0):
    """The same of three edges at once."""
    length = sum(stark.norm(p[i + 1].x - p[i].x) for i in range(3))
    return 0.5 * stiffness * (length - rest) ** 2


def cloth(scene: stark.Scene, cells: int = 3, **options: Any) -> stark.Cloth:
    limp = stark.materials.cotton.replace(bending_stiffness=0.0, flexural_rigidity=0.0)
    return scene.add_cloth(stark.mesh.grid(0.6, 0.2, cells=(cells, 1)), limp, **options)


def lower_row(body: Any) -> list[int]:
    x = body.mesh.vertices
    row = np.flatnonzero(x[:, 1] < x[:, 1].min() + 1e-9)
    return [int(k) for k in row[np.argsort(x[row, 0])]]


def run(bind: Any, steps: int = 20, **settings: Any) -> tuple[stark.Simulation, Any, list[int]]:
    scene = stark.Scene()
    body = cloth(scene, pins=[0])
    handle = scene.add(bind(body, lower_row(body)))
    sim = stark.Simulation(scene, time_step=0.01, **settings)
    iterations = []
    for _ in range(steps):
        report = sim.step()
        assert not report.failed, report.message
        iterations.append(report.newton_iterations)
    return sim, handle, iterations


def by_edges(body: Any, row: list[int]) -> Any:
    return cable(stark.stencils(body, list(pairwise(row))), rest=0.5)


def at_once(body: Any, row: list[int]) -> Any:
    return one_cable(stark.stencils(body, [row]), rest=0.5)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_total_is_the_same_as_one_large_element(integrator: str) -> None:
    """With the exact Hessian of both, Newton's method takes the same steps: iterations are equal."""
    first, of_total, iterations = run(by_edges, **{"time.integrator": integrator})
    second, _, others = run(at_once, **{"time.integrator": integrator})
    assert iterations == others
    np.testing.assert_allclose(first.state.point_positions, second.state.point_positions, rtol=0, atol=1e-10)
    handle, other = first.energies[0], second.energies[0]
    assert handle.energy == pytest.approx(other.energy, rel=1e-7)
    assert handle.energies.shape == (1,)
    forces = np.zeros_like(first.state.point_positions)
    ends = [column._columns["vertices"] for column in of_total._binding.columns]
    np.add.at(forces, np.stack(ends, axis=1), handle.forces)
    row = lower_row(first.bodies[0])
    np.testing.assert_allclose(forces[row], other.forces[0], rtol=1e-6, atol=1e-9)


def test_the_handle_has_the_totals_and_the_slopes_by_them() -> None:
    sim, _, _ = run(by_edges)
    row = lower_row(sim.bodies[0])
    length = np.linalg.norm(np.diff(sim.bodies[0].positions[row], axis=0), axis=1).sum()
    bound = sim.energies[0]
    assert bound.length == pytest.approx(length, rel=1e-14)
    assert bound.totals == {"length": bound.length}
    assert bound.total_slopes == {"length": pytest.approx(200.0 * (length - 0.5), rel=1e-9)}
    assert bound.energy == pytest.approx(100.0 * (length - 0.5) ** 2, rel=1e-9)
    assert "length" in dir(bound)
    bound.rest = 0.4
    assert not sim.step().failed
    assert bound.energy == pytest.approx(100.0 * (bound.length - 0.4) ** 2, rel=1e-9)


@pytest.mark.parametrize("solver", ["cholesky", "cholesky_float", "pcg"])
def test_any_linear_solver_takes_it(solver: str) -> None:
    base, _, _ = run(by_edges)
    sim, _, _ = run(by_edges, **{"linear.solver": solver})
    np.testing.assert_allclose(sim.state.point_positions, base.state.point_positions, rtol=0, atol=1e-6)


def test_threads_and_checkpoints_change_no_bits(tmp_path: Any) -> None:
    one, _, _ = run(by_edges, **{"execution.threads": 1})
    two, _, _ = run(by_edges, **{"execution.threads": 2})
    assert one.state.hash == two.state.hash
    half, _, _ = run(by_edges, steps=10)
    half.save(tmp_path / "half.stark")
    scene = stark.Scene()
    body = cloth(scene, pins=[0])
    scene.add(by_edges(body, lower_row(body)))
    rest = stark.Simulation(scene, time_step=0.01)
    rest.load(tmp_path / "half.stark")
    for _ in range(10):
        assert not rest.step().failed
    assert rest.state.hash == one.state.hash


def test_documents_keep_it_bit_for_bit(tmp_path: Any) -> None:
    scene = stark.Scene()
    body = cloth(scene, pins=[0])
    scene.add(by_edges(body, lower_row(body)))
    scene.save(tmp_path / "scene.json")
    rows = json.loads((tmp_path / "scene.json").read_text())["formulas"]
    assert [row["totals"] for row in rows] == [["length"]]
    again = stark.load_scene(tmp_path / "scene.json")
    sims = [stark.Simulation(s, time_step=0.01) for s in (scene, again)]
    for _ in range(5):
        for sim in sims:
            assert not sim.step().failed
    assert sims[0].state.hash == sims[1].state.hash
    assert again.energies[0].length == scene.energies[0].length


def test_driven_points_are_anticipated() -> None:
    """Both ends of the row are scripted: the cable feels their motion in the Newton iteration."""
    results = []
    for bind in (by_edges, at_once):
        scene = stark.Scene()
        body = cloth(scene)
        row = lower_row(body)
        ends = [row[0], row[-1]]
        body.pin(ends)
        scene.add(bind(body, row))
        sim = stark.Simulation(scene, time_step=0.02, gravity=STILL)
        start = body.mesh.vertices[ends]
        iterations = 0
        for k in range(1, 6):
            body.pin_targets = start + 0.01 * k * np.array([[-1.0, 0, 0], [1.0, 0.5, 0]])
            report = sim.step()
            assert not report.failed, report.message
            iterations += report.newton_iterations
        results.append((sim.state.point_positions, iterations))
    np.testing.assert_allclose(results[0][0], results[1][0], rtol=0, atol=1e-9)
    assert results[0][1] == results[1][1]


def test_energy_and_momentum_are_balanced() -> None:
    """A free sheet with a stretched cable swings: what the cable loses, cloth and motion gain."""
    scene = stark.Scene()
    body = cloth(scene)
    scene.add(by_edges(body, lower_row(body)))
    sim = stark.Simulation(scene, time_step=1e-3, gravity=STILL, **{"time.integrator": "bdf2"})
    start = None
    for report in sim.run(until=0.1):
        assert not report.failed
        ledger = report.energy
        stored = ledger["kinetic"] + ledger["elastic"]
        start = start if start is not None else stored
        assert report.momentum == pytest.approx([0, 0, 0], abs=1e-9)
    assert abs(ledger["numerical"]) < 0.02 * start


@stark.energy
def drifting(p: stark.Point, q: stark.Point, stiffness: float = 50.0):
    """Two totals: a weighted centre that is held, and the spread about it that is limited."""
    spread = stark.total((p.x - q.x) @ (p.x - q.x), "spread")
    middle = stark.total(p.x)
    return stiffness * (middle @ middle) + 0.5 * stiffness * stark.maximum(spread - 0.2, 0.0) ** 2


def test_several_totals() -> None:
    scene = stark.Scene()
    body = cloth(scene)
    handle = scene.add(drifting(body.vertices[:4], body.vertices[4:8]))
    sim = stark.Simulation(scene, time_step=0.01)
    for _ in range(30):
        report = sim.step()
        assert not report.failed, report.message
    assert report.newton_iterations <= 4
    x = body.positions
    assert handle.spread == pytest.approx(((x[:4] - x[4:8]) ** 2).sum(), rel=1e-12)
    assert list(handle.totals) == ["spread", "total 1", "total 2", "total 3"] or len(handle.totals) == 4


def test_check_takes_all_elements_as_one() -> None:
    scene = stark.Scene()
    body = cloth(scene)
    report = cable(body.edges, rest=0.5).check()
    assert report.ok, str(report)
    assert report["gradient"].status == "ok"
    assert report["translation"].status == "ok"
    assert report["rotation"].status == "ok"

    @stark.energy
    def jumps(e: stark.Edge, at: float = 0.0):
        length = stark.total(e.length)
        return stark.where(length > at, length, length + 1.0)

    ends = [column.positions for column in body.edges.columns]
    length = np.linalg.norm(ends[1] - ends[0], axis=1).sum()
    wrong = jumps(body.edges, at=float(length)).check()
    assert not wrong.ok
    assert wrong["continuous energy"].status == "wrong"

    @stark.energy
    def kinked(e: stark.Edge, rest: float = 0.0):
        return stark.abs(stark.total(e.length) - rest)

    kink = kinked(body.edges, rest=float(length)).check()
    assert kink.ok and kink["continuous energy"].status == "ok"
    assert kink["continuous forces"].status == "note" and "the energy has a kink" in str(kink)
    assert report["continuous forces"].status == "ok"


@stark.energy
def outside(e: stark.Edge):
    return stark.total(e.length) * e.length


@stark.energy
def nested(e: stark.Edge):
    return stark.total(stark.total(e.length) * e.length)


@stark.energy
def twice(e: stark.Edge):
    return stark.total(e.length, "a") * stark.total(e.rest_length, "a")


@stark.energy
def hidden_reading(e: stark.Edge):
    return stark.total(e.length, "forces") ** 2


@stark.energy
def hidden_parameter(e: stark.Edge, rest: float = 0.1):
    return (stark.total(e.length, "rest") - rest) ** 2


@stark.energy
def numbered(e: stark.Edge):
    return stark.total(e.length, 3) ** 2


@pytest.mark.parametrize(
    ("formula", "message"),
    [
        (hidden_reading, "a total must not be called 'forces', a name that is taken"),
        (hidden_parameter, "a total must not be called 'rest', a name that is taken"),
        (numbered, "total: the name 3: must be one that an attribute can have"),
        (outside, r"e\[.\].x\[.\] occurs outside of stark.total"),
        (nested, "a total is within another"),
        (twice, "two totals have the name 'a'"),
    ],
)
def test_what_has_no_meaning_is_refused_where_it_is_written(formula: Any, message: str) -> None:
    body = cloth(stark.Scene())
    with pytest.raises(stark.Error, match=message):
        formula(body.edges)


def test_values_outside_of_totals_are_shared() -> None:
    body = cloth(stark.Scene())
    with pytest.raises(
        stark.InvalidArgument, match=r"'stiffness' has a value for each of .* must be one value"
    ):
        cable(body.edges, stiffness=np.ones(len(body.edges)))


def test_totals_are_for_energies_alone() -> None:
    @stark.material
    def law(F: stark.DeformationGradient):
        return stark.total(stark.trace(F.T @ F))

    with pytest.raises(stark.Error, match=r"the sum over all elements of an energy"):
        stark.Scene().add_solid(stark.mesh.tet_box(0.1, 1), law(density=1000.0))
    with pytest.raises(stark.Error, match=r"total\(2.0"):
        stark.total(2.0)

    @stark.symbolic.function
    def plain(x: float):
        return stark.total(x * x)

    with pytest.raises(stark.Error, match="sum over all elements"):
        plain(np.ones(3))
