"""Certificates: numbers against those of the solver, digests, JSON, what the guide says of them."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
from _recorded_runs import mechanism, record, sheet_on_box

import stark
from stark.cli import main
from stark.joints.definition import built_in
from stark.verify import verify
from stark.verify.inertia import InertiaCheck
from stark.verify.joint_kinds import KINDS
from stark.verify.joints import JointCheck
from stark.verify.reading import read

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def sheet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sheet") / "run"
    return record(folder, sheet_on_box(), 40, time_step=0.01, contact_distance=0.001)


def test_the_measured_distance_is_the_reported_one(sheet: Path) -> None:
    """Two programs, the same number to the last digits."""
    claim = verify(sheet)["reported_distance"]
    assert claim.status == "verified"
    assert claim.worst < 1e-8  # [m]; the solver's is that before its last Newton iteration
    reported = [row["min_distance"] for row in read(sheet).rows if row["min_distance"] is not None]
    assert len(reported) > 10


def test_joints_are_recomputed_as_the_solver_has_them(tmp_path: Path) -> None:
    sim = stark.Simulation(mechanism(), time_step=0.01, contact_distance=0.0005)
    folder = record(tmp_path / "run", mechanism(), 12, time_step=0.01, contact_distance=0.0005)
    for _ in range(12):
        sim.step()
    run = read(folder)
    check = JointCheck(run)
    check.start, last = run.state(0), run.state(12)
    for joint, recorded in zip(sim.joints, run.scene["joints"], strict=True):
        frames = [*check._frame(last, recorded["a"]), *check._frame(last, recorded["b"])]
        lengths, angles = KINDS[joint.kind].held(*frames, recorded["values"])
        own = np.concatenate([np.zeros(0), *lengths, *angles])
        # Poses have gone through a rotation matrix once more.
        assert np.abs(own) == pytest.approx(np.abs(joint.residuals), abs=1e-14), joint.name


def test_every_built_in_joint_is_known() -> None:
    assert set(KINDS) == set(stark._core.joint_names())
    for name in KINDS:
        assert built_in(name).residuals is None


def test_masses_of_the_recording_are_those_of_the_solver(tmp_path: Path) -> None:
    """Kinetic energy and momentum come out the same only with the same masses, of sheets, solids, rods,
    bodies."""
    scene = stark.Scene()
    spin = {"velocity": (0.3, -0.2, 0.1), "angular_velocity": (3.0, 2.0, -4.0)}
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=3), stark.materials.cotton, **spin)
    scene.add_solid(stark.mesh.tet_box((0.1, 0.05, 0.02), 2), mass=0.3, position=(1.0, 0.0, 0.0), **spin)
    scene.add_box((0.1, 0.2, 0.3), density=300.0, position=(2.0, 0.0, 0.0), **spin)
    flat = stark.materials.rubber_cord.replace(width=0.01, height=0.002)
    for k, material in enumerate((stark.materials.rubber_cord, flat)):
        line = stark.mesh.polyline((0, 0, 0), (0.1, 0.02, 0.0), 5)
        scene.add_rod(
            line, material, position=(3.0 + k, 0.0, 0.0), pins=[2] if k else None, **({} if k else spin)
        )
    run = read(record(tmp_path / "run", scene, 3, time_step=1e-3))
    check = InertiaCheck(run)
    for k in range(3):
        check.add(run.state(k), run.state(k + 1), run.rows[k])
    assert set(check.worst) == {"kinetic", "gravity", "momentum", "angular_momentum", "turning", "velocities"}
    for name, (share, where) in check.worst.items():
        assert share < 1.0, (name, where)


def test_without_certify_little_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = str(tmp_path / "run")
    assert main(["run", "hello_cloth", "--until", "0.1", "--out", run, "--no-replay", "--no-picture"]) == 0
    capsys.readouterr()
    assert main(["verify", run]) == 3
    text = capsys.readouterr().out
    assert "hello_cloth: inconclusive" in text
    assert "stark run --certify" in text
    certificate = verify(run)
    assert certificate["paths"].status == "not recorded"
    assert certificate["residual"].status == "verified"


def test_digests_are_those_of_the_files(sheet: Path) -> None:
    recording = verify(sheet).recording
    for name, value in recording["files"].items():
        assert hashlib.sha256((sheet / name).read_bytes()).hexdigest() == value
    lines = "".join(f"{value}  {name}\n" for name, value in sorted(recording["files"].items()))
    assert hashlib.sha256(lines.encode()).hexdigest() == recording["digest"]
    stored = {str(p.relative_to(sheet)) for p in sheet.rglob("*") if p.is_file()}
    assert stored - {"certificate.json"} == set(recording["files"])


def test_the_certificate_can_be_printed_as_json(sheet: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(sheet), "--json", "--out", str(sheet.parent / "other.json")]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((sheet.parent / "other.json").read_text())
    assert (printed["format"], printed["version"]) == ("stark-certificate", 1)
    assert printed["tools"]["numpy"] == np.__version__
    for claim in printed["claims"]:
        assert claim.keys() >= {"name", "statement", "status", "basis", "worst", "tolerance", "unit", "where"}


@pytest.mark.parametrize(("pins", "expected"), [([0], 24), ([], 48)])
def test_states_take_24_bytes_a_vertex_those_of_free_sheets_48(
    tmp_path: Path, pins: list[int], expected: int
) -> None:
    """The cost that docs/verify.md states."""
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(1.0, 1.0, cells=40), stark.materials.cotton, pins=pins)
    folder = record(tmp_path / "run", scene, 10, time_step=0.01)
    size = (folder / "states/chunk_000000.npz").stat().st_size
    assert size == pytest.approx(expected * 41 * 41 * 11, rel=0.01)


def test_loads_are_not_taken_for_formulas_of_the_user(tmp_path: Path) -> None:
    scene = stark.Scene()
    for k in range(10):
        scene.add_force(scene.add_box(0.1, mass=1.0, position=(k, 0, 0)), (0, 0, 1), name=f"wind {k}")
    limits = verify(record(tmp_path / "run", scene, 1, time_step=0.01)).limits
    (limit,) = [text for text in limits if "taken as reported" in text]
    assert limit.startswith("energies of loads, of seams and of the user are taken as reported: 'wind 0', ")
    assert limit.endswith("'wind 7' and 2 more")


def test_attachments_share_a_limit(tmp_path: Path) -> None:
    """A net has one for each of its knots."""
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.2, 0.1, cells=(10, 2)), name="sheet")
    scene.attach(sheet.vertices[[11]], None, name="to the world, which has no surface")
    for k in range(10):
        plate = scene.add_box(0.01, mass=0.01, position=sheet.positions[k] + (0, -0.005, 0))
        scene.attach(sheet.vertices[[k]], plate, name=f"knot {k}")
    limits = verify(record(tmp_path / "run", scene, 1, time_step=0.01)).limits
    (limit,) = [text for text in limits if text.startswith("attachment")]
    assert limit.startswith("attachments 'knot 0', 'knot 1', ")
    assert limit.endswith("'knot 7' and 2 more: 10 points not looked at against what carries them")


def test_the_guide_names_every_claim(sheet: Path) -> None:
    guide = (ROOT / "docs/verify.md").read_text(encoding="utf-8")
    for claim in verify(sheet).claims:
        assert f"`{claim.name}`" in guide
        assert not claim.required or f"| `{claim.name}` | " in guide
