"""Messages that read badly to a user who had read no source, one by one."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import FakeSimulation

import stark
from stark.recording import Recorder


@stark.energy
def spring(p: stark.Point, k: float = 1.0, n: int = 1) -> Any:
    return 0.5 * k * n * stark.squared_norm(p.x)


@pytest.fixture
def scene() -> stark.Scene:
    scene = stark.Scene("s")
    scene.add_box(0.1, mass=1.0, name="box")
    scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=3), position=(0, 0, 0.3), name="cloth")
    scene.add_force(scene["box"], (0, 0, 1), name="force")
    return scene


def test_stencils_are_of_one_body(scene: stark.Scene) -> None:
    for wrong in ([(0, 0, 0), scene["box"].points((0, 0, 0))], scene["cloth"].vertices, "cloth", None):
        with pytest.raises(
            stark.InvalidArgument, match=r"stark\.stencils\(body, indices\): body = .*: must be a"
        ):
            stark.stencils(wrong, [[0, 1]])  # type: ignore[arg-type]


@pytest.mark.parametrize("nothing", [[], (), np.array([]), np.zeros(16, dtype=bool), slice(5, 5)])
def test_an_empty_selection_is_empty(scene: stark.Scene, nothing: Any) -> None:
    assert len(scene["cloth"].vertices[nothing]) == 0
    with pytest.raises(stark.InvalidArgument, match="must have at least one; check the selection"):
        scene.add(spring(scene["cloth"].vertices[nothing]))


@pytest.mark.parametrize(
    ("read", "message"),
    [
        (lambda s: s.energies["force"].forces, "force': forces need a simulation"),
        (lambda s: s.energies["force"].energies, "force': energies need a simulation"),
        (lambda s: s["cloth"].velocities, "cloth': velocities need a simulation"),
        (lambda s: s["box"].velocity, "box': velocity needs a simulation"),
    ],
)
def test_what_needs_a_simulation_says_so(
    scene: stark.Scene, read: Callable[[stark.Scene], Any], message: str
) -> None:
    with pytest.raises(stark.InvalidArgument, match=message):
        read(scene)


def test_parameters_that_are_integers_take_whole_numbers(scene: stark.Scene) -> None:
    points = scene["cloth"].vertices
    with pytest.raises(stark.InvalidArgument, match=r"n = 3\.5: must be a whole number, as its annotation"):
        scene.add(spring(points, n=3.5))
    with pytest.raises(stark.InvalidArgument, match=r"n\[2\] of element 2 = 0\.5: must be a whole number"):
        scene.add(spring(points, n=np.where(np.arange(16) == 2, 0.5, 1.0)))
    energy = scene.add(spring(points, n=3.0, k=0.5))
    with pytest.raises(stark.InvalidArgument, match="must be a whole number"):
        energy.n = 2.5
    energy.n = 2
    assert energy.n == 2.0
    sim = stark.Simulation(scene, time_step=0.01)
    energy.n = lambda t: 1.0 + t
    with pytest.raises(stark.InvalidArgument, match="must be a whole number"):
        sim.step()


def test_units_of_numbers_without_one_are_left_out(scene: stark.Scene) -> None:
    with pytest.raises(stark.InvalidArgument, match="'k' = '3': must be a number"):
        scene.add(spring(scene["cloth"].vertices, k="3"))
    with pytest.raises(stark.InvalidArgument, match=r"'force' \[N\] = '3': must be"):
        scene.energies["force"].force = "3"


MASKED = np.ma.array([0.0, 0.0, 1.0], mask=[0, 0, 1])


@pytest.mark.parametrize(
    "give",
    [
        lambda sim: setattr(sim["box"], "position", MASKED),
        lambda sim: setattr(sim["box"], "velocity", [0.0, 0.0, MASKED[2]]),
        lambda sim: setattr(sim.energies["force"], "force", MASKED),
        lambda sim: setattr(sim["cloth"], "velocities", np.ma.masked_all((16, 3))),
        lambda sim: setattr(sim["cloth"], "velocities", [MASKED] * 16),
        lambda sim: sim["cloth"].vertices[np.ma.array([0, 1], mask=[0, 1])],
        lambda sim: stark.mesh.TriangleMesh([MASKED] * 3, [[0, 1, 2]]),
        lambda sim: stark.mesh.TriangleMesh(np.eye(3), np.ma.array([[0, 1, 2]], mask=[[0, 0, 1]])),
        lambda sim: stark.mesh.box(np.ma.array([1.0, 1.0, 1.0], mask=[0, 0, 1])),
        lambda sim: stark.mesh.box(np.ma.masked),
        lambda sim: stark.SolidMaterial(density=np.ma.array([1.0, 2.0], mask=[0, 1])),
        lambda sim: stark.motion.linear([0.0, 1.0, 2.0], MASKED),
        lambda sim: stark.Scene().add_box(0.1, mass=1.0, linear_damping=np.ma.masked),
        lambda sim: stark.Scene().add_cloth(stark.mesh.grid(1, 1, 2), friction=MASKED[2]),
        lambda sim: stark.Settings().update({"contact.friction": np.ma.array(0.5, mask=True)}),
    ],
)
def test_masked_values_are_refused(scene: stark.Scene, give: Callable[[Any], Any]) -> None:
    sim = stark.Simulation(scene, time_step=0.01)
    with pytest.raises(stark.InvalidArgument, match="masked"):
        give(sim)


def test_masked_arrays_without_masked_values_are_arrays(scene: stark.Scene) -> None:
    sim = stark.Simulation(scene, time_step=0.01)
    sim["box"].position = np.ma.array([0.0, 0.0, 1.0])
    assert sim["box"].position[2] == 1.0


def test_byte_order_marks_are_no_part_of_a_text(scene: stark.Scene, tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text('\ufeffscene = "drape"\n')
    assert stark.study.Plan.read(tmp_path / "plan.toml").scene == "drape"
    assert stark.study.Plan.parse('\ufeffscene = "drape"\n').scene == "drape"
    path = scene.save(tmp_path / "scene.json")
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert len(stark.load_scene(path).bodies) == 2
    assert "name" in json.loads(path.read_text("utf-8-sig"))


def test_a_certificate_of_a_recording_without_a_name_has_a_subject(tmp_path: Path) -> None:
    sim = FakeSimulation()
    with Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
    assert stark.verify.verify(tmp_path / "run").text().startswith("recording: ")
