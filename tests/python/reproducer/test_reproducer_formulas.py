"""Steps with formulas of the user in files: energies, laws, joints and actuators come along, with the values
that the step took."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import reproducer
from stark.reproducer.formulas import ReadFormulas, WrittenFormulas


@stark.energy
def spring(
    a: stark.Point,
    b: stark.Point,
    t: stark.Time,
    k: float = stark.parameter(50.0, unit="N/m", min=0.0),
    rest: float = 0.1,
):
    d = a.x - b.x
    return 0.5 * k * (stark.sqrt(d @ d + 1e-12) - rest * (1.0 + 0.1 * t)) ** 2


@stark.energy
def upright(f: stark.Frame, k: float = 0.01):
    return k * (1.0 - f.z[2])


@stark.material
def saint_venant(
    F: stark.DeformationGradient,
    h: stark.TimeStep,
    mu: float = stark.parameter(1e4, unit="Pa", above=0.0),
    bulk: float = stark.parameter(1e5, unit="Pa", above=0.0),
    flow: stark.Mat3 = stark.internal(0.0),
):
    E = 0.5 * (F.T @ F - stark.identity(3))
    rest = E - flow
    psi = mu * stark.squared_norm(rest) + 0.5 * bulk * (stark.determinant(F) - 1.0) ** 2
    return psi, {"flow": flow + h / (h + 0.1) * rest}


@stark.joint
def on_line(a: stark.Frame, b: stark.Frame, rest: float = stark.parameter(0.0, unit="m")):
    d = b.origin - a.origin
    return stark.hold(length=[a.x @ d - rest, a.y @ d], displacement={"height": a.z @ d})


@stark.actuator
def hardening(c: stark.Coordinate, stiffness: float = stark.parameter(unit="N/m^3", min=0.0)):
    return 0.25 * stiffness * c.q**4


def everything() -> stark.Scene:
    scene = stark.Scene("formulas")
    mesh = stark.mesh.tet_box(0.1, 1)
    moduli = np.linspace(1e4, 2e4, len(mesh.tets))
    jelly = scene.add_solid(mesh, saint_venant(mu=moduli, density=500.0), position=(0, 0, 0.3), name="jelly")
    box = scene.add_box(0.05, mass=0.1, position=(-0.3, 0, 0.3), name="box")
    scene.add(spring(jelly.vertices[:3], box.points((0.02, 0, 0)), k=[5.0, 6.0, 7.0], rest=0.2), name="rope")
    scene.add(upright(box), name="gyro")
    bead = scene.add_box(0.02, mass=0.01, position=(0.5, 0, 0.3), name="bead")
    wire = scene.add_joint(on_line, None, bead, anchor=(0.5, 0, 0.3), name="wire")
    wire.add_actuator(hardening, stiffness=1e5, name="stop")
    return scene


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_formulas_of_users_come_along_with_their_bits(tmp_path: Path, integrator: str) -> None:
    scene = everything()
    sim = stark.Simulation(scene, {"time.integrator": integrator}, time_step=0.005)
    for _ in range(3):
        assert not sim.step().failed
    rope: Any = scene.energies["rope"]
    rope.k[1] = 30.0  # the step takes values as they are then
    sim.step()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.write_reproducer(tmp_path)
        rope.k = 0.0  # of a later step
        again = reproducer.load(tmp_path)
    assert again.state.step_count == 3
    assert not again.step().failed
    assert again.state == sim.state
    assert again.state.hash == sim.state.hash


def test_formulas_are_written_once() -> None:
    scene = stark.Scene()
    mesh = stark.mesh.tet_box(0.1, 1)
    law = saint_venant(density=500.0)
    solids = [scene.add_solid(mesh, law, position=(0.2 * k, 0, 0)) for k in range(3)]
    for solid in solids:
        scene.add(spring(solid.vertices[0], solid.vertices[1]))
    written = WrittenFormulas(scene)
    numbers = {written.number(solid._shared["material"].law) for solid in solids}
    numbers |= {written.number(energy._binding.trace.formula) for energy in scene.energies}
    assert numbers == {0, 1} and len(written.rows) == 2
    assert written.number(object()) is None
    again = ReadFormulas(json.loads(json.dumps(written.rows)))
    assert again.core(0) is again.core(0)
    assert type(again.core(0)) is type(law.law)


def test_damaged_formulas_are_named(tmp_path: Path) -> None:
    sim = stark.Simulation(everything(), time_step=0.005)
    sim.step()
    sim.write_reproducer(tmp_path)
    data = dict(np.load(tmp_path / "step.npz"))
    header = json.loads(data["header"].tobytes())
    header["formulas"][0]["nodes"][-1] = ["exec", 0.0]
    data["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    np.savez(tmp_path / "step.npz", **data)
    with pytest.raises(stark.ReproducerError, match=r"damaged.*exec"):
        reproducer.load(tmp_path)
