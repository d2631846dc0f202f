"""Formulas as data and back: the same operations, the same bits; what is no formula is refused."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _everything import everything, tether

import stark
from stark.document import DocumentError, recorded
from stark.formulas.listing import OPERATIONS, listed, replayed
from stark.formulas.parameters import UNBOUNDED


@stark.energy
def all_operations(p: stark.Point, t: stark.Time, k: float = stark.parameter(unit="J")):
    """Every operation that there is."""
    x, y, z = p.x
    near = (x < 0.3) & ~(y <= -2.0) | (z < -5.0)
    some = stark.sin(x) + stark.cos(y) + stark.tan(0.1 * z) + stark.exp(-(x**2)) + stark.log(2.0 + y**2)
    more = stark.asin(0.1 * x) + stark.acos(0.1 * y) + stark.atan(z) + stark.tanh(x) + stark.sqrt(1.0 + z**2)
    rest = stark.minimum(x, y) * stark.maximum(y, z) + stark.atan2(y, 2.0 + x**2) + stark.fma(x, y, z)
    rest += y * stark.held(x + y)
    return k * stark.where(near, some + more, rest / (1.0 + t)) + stark.abs(x) ** 1.5 - abs(-y)


def test_every_operation_comes_back() -> None:
    trace = all_operations.trace()
    nodes, outputs = listed(trace.graph, trace.sources)
    names = {node[0] for node in nodes} - {"input", "constant"}
    assert names == OPERATIONS.keys()
    assert "unknown" not in {node[1] for node in nodes if node[0] == "input"}
    formula, _, _ = replayed(1, [("k", 1, "J", "k", UNBOUNDED, False)], nodes, outputs)
    rng = np.random.default_rng(7)
    x = rng.uniform(-1.0, 1.0, (64, 3))
    inputs = {
        "x": x,
        "x_prev": x,
        "X": x,
        "x_initial": x,
        "values": {"k": np.full(64, 2.0)},
        "time_step": 0.1,
        "time": 0.3,
    }
    before, after = (f.sample(inputs).evaluate(2) for f in (trace.formula, formula))
    assert np.isfinite(before).all() and before.tobytes() == after.tobytes()


def _row(tmp_path: Path, name: str) -> dict[str, Any]:
    given = json.loads(everything().save(tmp_path / "a.json").read_text())
    found: dict[str, Any] = next(row for row in given["formulas"] if row["name"] == name)
    for node in found["nodes"]:  # as the reader hands them on
        node[1:] = [float(entry) if isinstance(entry, int) else entry for entry in node[1:]]
    for entry in found["inputs"]:
        entry["range"] = [-np.inf, np.inf]
    return found


@pytest.mark.parametrize("name", ["tether", "saint_venant", "membrane", "kirchhoff", "on_line", "counting"])
def test_kinds_of_formulas_come_back(name: str, tmp_path: Path) -> None:
    made = recorded.made(_row(tmp_path, name), "formulas[0]")
    assert getattr(made, "name", None) == name or made.core.name == name


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda row: row.update(outputs=[]), "outputs"),
        (lambda row: row.update(outputs=[10**6]), "outputs"),
        (lambda row: row.update(stages=[10**6]), "stages"),
        (lambda row: row.update(points=1), "point 1"),
        (lambda row: row["nodes"].append(["exec", 0.0]), "unknown operation 'exec'"),
        (lambda row: row["nodes"].append(["+", 0.0]), "must have 2 operands"),
        (lambda row: row["nodes"].append(["neg", 10000.0]), "numbers of nodes before it"),
        (lambda row: row["nodes"].append(["input", "x", 99.0, 0.0]), "point 99"),
        (lambda row: row["nodes"].append(["input", "nothing", 0.0, 0.0]), "no input 'nothing'"),
        (lambda row: row["nodes"].append(["constant", "1"]), "constant"),
        (lambda row: row["nodes"].append([]), "unknown operation"),
    ],
)
def test_what_is_no_formula_is_refused(change: Any, text: str, tmp_path: Path) -> None:
    row = copy.deepcopy(_row(tmp_path, "tether"))
    change(row)
    with pytest.raises(DocumentError, match=text):
        recorded.made(row, "formulas[0]")


def test_formulas_that_are_used_twice_are_written_once(tmp_path: Path) -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2))
    for k in range(3):
        scene.add(tether(cloth.vertices[k], stark.world_frame(), stiffness=float(k)))
    assert len(json.loads(scene.save(tmp_path / "a.json").read_text())["formulas"]) == 1


def test_laws_that_remember_come_back_with_their_bits(tmp_path: Path) -> None:
    scene = stark.Scene()
    metal = stark.j2_plasticity(
        shear_modulus=1e6, bulk_modulus=2e6, yield_stress=2e3, kinematic_modulus=1e5, density=1000.0
    )
    scene.add_solid(stark.mesh.tet_box(0.1, 1), metal, pins=[0, 1, 2, 3])
    cord = stark.generalized_maxwell_rod(stark.RodMaterial(), moduli=[1e6], times=[0.01])
    scene.add_rod(stark.mesh.polyline((0.2, 0, 0), (0.3, 0, 0), 4), cord, clamps=[0])
    path = scene.save(tmp_path / "scene.json")
    ends = []
    for one in (
        scene,
        stark.load_scene(path),
        stark.load_scene(stark.load_scene(path).save(tmp_path / "b.json")),
    ):
        sim = stark.Simulation(one, time_step=0.005, **{"contact.enabled": False})
        sim.run_until(0.05)
        ends.append(sim.state)
    assert np.abs(ends[0].arrays()["internal_variable"]).max() > 1e-4
    assert ends[0] == ends[1]
    assert ends[0].hash == ends[2].hash


@stark.material
def maxwell(
    F: stark.DeformationGradient,
    h: stark.TimeStep,
    mu: float = stark.parameter(1e4, unit="Pa", above=0.0),
    unused: stark.Vec3 = stark.internal((1.0, 2.0, 3.0)),
    flow: stark.Mat3 = stark.internal(0.0),
    tau: float = stark.parameter(0.1, unit="s", above=0.0),
):
    E = 0.5 * (F.T @ F - stark.identity(3))
    rest, r = E - flow, h / tau
    psi = mu * stark.squared_norm(rest) / (1.0 + r) + 1e5 * (stark.determinant(F) - 1.0) ** 2
    return psi, {"unused": stark.vec(1.0, 2.0, 1.0), "flow": flow + r / (1.0 + r) * rest}


def remembering() -> stark.Scene:
    """Laws whose inputs come in another order than they are used in."""
    scene = stark.Scene("remembering")
    mesh = stark.mesh.tet_box(0.1, 1)
    metal = stark.j2_plasticity(shear_modulus=1e6, bulk_modulus=2e6, yield_stress=2e3, density=1000.0)
    scene.add_solid(mesh, metal, pins=[0, 1, 2, 3], name="metal")
    times = np.linspace(0.05, 0.5, len(mesh.tets))
    scene.add_solid(mesh, maxwell(tau=times, density=500.0), position=(0.3, 0, 0), pins=[0], name="gel")
    foam = stark.generalized_maxwell(
        shear_modulus=1e4, bulk_modulus=1e5, moduli=[1e4, 1e4], times=[0.1, 1.0], density=500.0
    )
    scene.add_solid(mesh, foam, position=(0.6, 0, 0), pins=[0], name="foam")
    return scene


def test_checkpoints_go_into_the_scene_of_the_document(tmp_path: Path) -> None:
    scene = remembering()
    sim = stark.Simulation(scene, time_step=0.005)
    sim.run_until(0.02)
    sim.save(tmp_path / "sim.stark")
    one = stark.load_scene(scene.save(tmp_path / "one.json"))
    two = stark.load_scene(one.save(tmp_path / "two.json"))
    for again in (one, two):
        copy_of_it = stark.Simulation(again, time_step=0.005)
        copy_of_it.load(tmp_path / "sim.stark")
        assert copy_of_it._parts == sim._parts
        copy_of_it.run_until(0.03)
        assert copy_of_it.time > sim.time


@pytest.mark.parametrize("build", [remembering, everything])
def test_a_document_of_a_document_is_the_same(build: Any, tmp_path: Path) -> None:
    """In every number; from the second on, in every byte: a user's 1 comes back as 1.0."""
    files = [build().save(tmp_path / "a.json")]
    for name in ("b", "c"):
        (tmp_path / name).mkdir()
        files.append(stark.load_scene(files[-1]).save(tmp_path / name / "a.json"))
    one, two, three = (file.read_text() for file in files)
    assert json.loads(one) == json.loads(two)
    assert two == three
    assert files[0].with_suffix(".npz").read_bytes() == files[2].with_suffix(".npz").read_bytes()


def test_internal_variables_of_other_sizes_are_refused(tmp_path: Path) -> None:
    scene = stark.Scene()
    metal = stark.j2_plasticity(shear_modulus=1e6, bulk_modulus=2e6, yield_stress=2e3, density=1000.0)
    scene.add_solid(stark.mesh.tet_box(0.1, 1), metal)
    path = scene.save(tmp_path / "scene.json")
    given = json.loads(path.read_text())
    given["formulas"][0]["internals"][0]["initial"] = [1.0]
    path.write_text(json.dumps(given))
    with pytest.raises(DocumentError, match="has 1 initial numbers: must be 9"):
        stark.load_scene(path)
