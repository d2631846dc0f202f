"""The check of a whole run: what is certified, what is not claimed, without the code that ran it."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from _recorded_runs import edit_states, mechanism, record, reseal, rods, sheet_on_box

import stark
from stark.cli import main
from stark.verify import verify

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def sheet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sheet") / "run"
    return record(folder, sheet_on_box(), 40, time_step=0.01, contact_distance=0.001)


@pytest.mark.parametrize(
    ("name", "until"),
    [("hello_cloth", 0.5), ("stack", 0.2), pytest.param("soft_column_6", 0.1, marks=pytest.mark.slow)],
)
def test_packaged_scenes_are_certified(tmp_path: Path, name: str, until: float) -> None:
    words = ["run", name, "--until", str(until), "--out", str(tmp_path / "run"), "--certify", "--quiet"]
    assert main([*words, "--no-replay", "--no-picture"]) == 0
    assert main(["verify", str(tmp_path / "run"), "--quiet"]) == 0
    certificate = json.loads((tmp_path / "run/certificate.json").read_text())
    statuses = {claim["name"]: claim["status"] for claim in certificate["claims"]}
    assert certificate["verdict"] == "certified"
    assert set(statuses.values()) <= {"verified", "not applicable"}
    for claim in ("no_intersection", "minimum_distance", "paths", "reported_distance", "reported_energies"):
        assert statuses[claim] == "verified"


def test_sheet_rods_and_mechanism_are_certified(tmp_path: Path, sheet: Path) -> None:
    crossed = record(tmp_path / "rods", rods(), 30, time_step=0.01)
    joined = record(tmp_path / "joints", mechanism(), 20, time_step=0.01, contact_distance=0.0005)
    for folder in (sheet, crossed, joined):
        certificate = verify(folder)
        assert certificate.verdict == "certified", certificate.text()
        assert certificate["reported_momentum"].status == "verified"
    certificate = verify(joined)
    assert certificate["joints"].status == certificate["attachments"].status == "verified"
    # Things did touch, or nothing would have been shown about contact.
    assert verify(sheet)["minimum_distance"].worst < 0.002
    assert verify(crossed)["minimum_distance"].worst < 0.01


def test_switched_off_contact_is_not_claimed(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_box(0.1, name="a", density=100.0)
    scene.add_box(0.1, name="b", density=100.0, position=(0.05, 0.0, 0.0))
    scene.disable_contact("a", "b")
    certificate = verify(record(tmp_path / "run", scene, 3, time_step=0.01))
    assert certificate["no_intersection"].status == "not applicable"
    assert certificate.verdict == "certified"


def test_pairs_without_contact_may_overlap(tmp_path: Path) -> None:
    scene = sheet_on_box()
    scene.add_box(0.05, name="ghost", motion="fixed")
    scene.disable_contact("ghost", "sheet")
    certificate = verify(record(tmp_path / "run", scene, 3, time_step=0.01, contact_distance=0.001))
    assert certificate.verdict == "certified"


def test_bodies_that_start_within_their_contact_distance_are_certified(tmp_path: Path) -> None:
    """They have no contacts, but a least distance."""
    scene = stark.Scene()
    scene.add_box(0.1, motion="fixed", name="base")
    scene.add_box(0.1, mass=1.0, position=(0, 0, 0.1015), name="box")
    settings = {"time_step": 0.01, "contact_distance": 0.001, "gravity": (0, 0, 0)}
    certificate = verify(record(tmp_path / "run", scene, 5, **settings))
    assert certificate.verdict == "certified", certificate.text()
    assert certificate["minimum_distance"].worst == pytest.approx(0.0015, rel=1e-6)


def test_bdf2_steps_are_certified(tmp_path: Path) -> None:
    settings = {"time_step": 0.01, "contact_distance": 0.001, "time.integrator": "bdf2"}
    certificate = verify(record(tmp_path / "run", sheet_on_box(), 25, **settings))
    assert certificate.verdict == "certified", certificate.text()
    for name in ("reported_energies", "reported_momentum"):
        assert certificate[name].status == "verified", certificate.text()
        assert certificate[name].detail == ""


def test_recordings_of_bdf2_without_velocities_say_less(tmp_path: Path) -> None:
    """Those of older versions."""
    settings = {"time_step": 0.01, "contact_distance": 0.001, "time.integrator": "bdf2"}
    run = record(tmp_path / "run", sheet_on_box(), 3, **settings)
    path = run / "states/chunk_000000.npz"
    with np.load(path) as stored:
        names = [name for name in stored.files if not name.startswith(("velocities", "lags", "spins"))]
        arrays = {name: stored[name] for name in names}
    np.savez(path, **arrays)
    reseal(run)
    certificate = verify(run)
    assert certificate.verdict == "certified", certificate.text()
    assert certificate["reported_energies"].detail.startswith("gravitational energy only")
    assert certificate["reported_momentum"].status == "not recorded"


def test_the_checker_runs_without_stark(sheet: Path, tmp_path: Path) -> None:
    """A copy of the folder is all it needs; anything named stark would be an error."""
    shutil.copytree(ROOT / "python/stark/verify", tmp_path / "verify")
    (tmp_path / "stark.py").write_text("raise ImportError('the checker must not import Stark')")
    command = [sys.executable, "-P", "-s", str(tmp_path / "verify"), str(sheet)]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env={"PYTHONPATH": str(tmp_path)}
    )
    assert done.returncode == 0, done.stderr
    assert "sheet_on_box: certified" in done.stdout


def test_the_checker_imports_numpy_and_itself_only() -> None:
    code = (
        "import sys; import numpy; before = set(sys.modules); sys.path.insert(0, sys.argv[1]); "
        "import verify.check; print(*sorted({m.split('.')[0] for m in set(sys.modules) - before}))"
    )
    command = [sys.executable, "-c", code, str(ROOT / "python/stark")]
    loaded = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    allowed = set(sys.stdlib_module_names) | {"numpy", "verify"}
    assert set(loaded) <= allowed, set(loaded) - allowed


def test_what_is_left_of_torques_is_no_torque(tmp_path: Path) -> None:
    """A box lands flat. What its last iteration leaves unbalanced is below the tolerance, but 4 times as
    much as the report, which has that of the iterate before: the box does not turn by it."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    scene.add_box(0.1, mass=0.5, position=(0, 0, 0.2))
    certificate = verify(record(tmp_path / "run", scene, 40, time_step=0.005))
    assert certificate.verdict == "certified", certificate.text()


def test_a_needle_that_is_held_far_from_its_free_motion_is_certified(tmp_path: Path) -> None:
    """It lands on a tip at 5 m/s while it spins at 1000 rad/s: it keeps the rate of its turn, not its
    momentum. Another rate is violated still."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    place = {"position": (0, 0, 2.5e-3), "rotation": stark.rotation(axis="y", angle=0.9)}
    motion = {"velocity": (0, 0, -5.0), "angular_velocity": (30.0, 1000.0, 10.0)}
    scene.add_box((5e-3, 3e-5, 2.9e-5), density=1000.0, name="needle", **place, **motion)
    run = record(tmp_path / "run", scene, 4, time_step=1e-3, contact_distance=1e-4)
    certificate = verify(run)
    assert certificate.verdict == "certified", certificate.text()
    edit_states(run, "angular_velocities_0001", lambda array, times: array.__imul__(1.0 + 1e-3))
    assert verify(run)["reported_momentum"].status == "violated"


def test_frames_that_are_held_far_from_their_free_motion_are_certified(tmp_path: Path) -> None:
    """A rod that bends for good spins at 4,200 rad/s: its frames keep the rate of their turn, as needles do.
    Another rate is violated still."""
    rod = stark.RodMaterial(density=4700.0, youngs_modulus=5e4, radius=1e-3)
    scene = stark.Scene()
    scene.add_rod(
        stark.mesh.polyline((-0.05, 0, 0), (0.05, 0, 0), 3),
        rod.replace(yield_stress=15.0, hardening_modulus=500.0),
        angular_velocity=(0.0, 3000.0, 3000.0),
    )
    run = record(tmp_path / "run", scene, 10, time_step=1e-3, contact_distance=2e-4)
    certificate = verify(run)
    assert certificate.verdict == "certified", certificate.text()
    assert certificate["reported_momentum"].status == "verified"
    edit_states(run, "angular_velocities_0000", lambda array, times: array.__imul__(1.0 + 1e-3))
    assert verify(run)["reported_momentum"].status == "violated"
