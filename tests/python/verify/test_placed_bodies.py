"""Recordings in which the user has placed bodies: jumps are named, not taken for tunnelling, and nothing else
is excused by them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import stark
from stark.verify import Certificate, verify

pytestmark = pytest.mark.filterwarnings("error")


def simulated(**settings: Any) -> stark.Simulation:
    """A box on a floor, behind a plate that stands on it, and a wheel with a stop at three turns."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    scene.add_box((0.02, 0.5, 0.3), motion="fixed", position=(0.2, 0, 0.16), name="plate")
    scene.add_box(0.1, mass=0.5, position=(0, 0, 0.0505), name="box")
    wheel = scene.add_box(0.1, mass=0.2, position=(0, 1, 0.5), name="wheel")
    hinge = scene.add_hinge(None, wheel, anchor=(0, 1, 0.5), axis=(1, 0, 0), name="hinge")
    hinge.add_limit(-20.0, 20.0)
    return stark.Simulation(scene, time_step=0.01, contact_distance=1e-3, **settings)


def jump(sim: stark.Simulation) -> None:
    """Through the plate, and two turns on."""
    with sim.placing():
        sim["box"].position = (0.4, 0, 0.1)
        sim["box"].velocity = (0, 0, 0.5)
        sim.joints[0].angle = sim.joints[0].angle + 15.0


def recorded(folder: Path, sim: stark.Simulation, *, states: bool = True, jumps: int = 1) -> Path:
    with stark.recording.Recorder(folder, sim, certify=True) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        for n in range(12):
            if n in (4, 8)[:jumps]:
                jump(sim) if n == 4 else setattr(sim["box"], "position", (0, 0, 0.2))
                if states:
                    recorder.record_state(sim)
                    recorder.record(sim)
            report = sim.step()
            assert not report.failed
            recorder.report(report)
            recorder.record_state(sim)
        recorder.record(sim)
    return folder


def claim(certificate: Certificate, name: str) -> Any:
    return next(c for c in certificate.claims if c.name == name)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_jump_is_named_and_the_rest_is_certified(tmp_path: Path, integrator: str) -> None:
    sim = simulated(**{"time.integrator": integrator})
    certificate = verify(recorded(tmp_path / "run", sim, jumps=2))
    assert certificate.verdict == "certified", [c for c in certificate.claims if c.status != "verified"]
    paths = claim(certificate, "paths")
    assert paths.status == "verified"
    assert "has placed bodies 2 times, a jump that is no path: 'box', 'wheel' at 0.04 s; 'box' at 0.08" in (
        paths.detail
    )
    assert any("jumps and not motion: 'box' 2 times, 'wheel' once" in limit for limit in certificate.limits)
    assert claim(certificate, "energy_ledger").status == "verified"
    assert claim(certificate, "stops").status == "verified"
    assert claim(certificate, "display").status == "verified"


def test_a_jump_without_its_state_is_no_proof(tmp_path: Path) -> None:
    certificate = verify(recorded(tmp_path / "run", simulated(), states=False))
    paths = claim(certificate, "paths")
    assert certificate.verdict == "inconclusive" and paths.status == "inconclusive"
    assert "call record_state(sim) after placing" in paths.detail


def test_what_is_placed_before_the_first_state_is_where_all_begins(tmp_path: Path) -> None:
    """It is no jump, and no step less than there are states."""
    sim = simulated()
    sim["box"].velocity = (0.1, 0, 0.5)
    sim.joints[0].angle = 15.0  # two turns on, from where the stop counts
    certificate = verify(recorded(tmp_path / "run", sim, jumps=0))
    assert certificate.verdict == "certified", [c for c in certificate.claims if c.status != "verified"]
    assert claim(certificate, "steps").status == claim(certificate, "stops").status == "verified"
    assert "placed" not in claim(certificate, "paths").detail and not certificate.limits


Change = Callable[[dict[str, Any]], None]


def edited(folder: Path, change: Change) -> Certificate:
    """Verdict on telemetry of which every row was changed."""
    path = folder / "telemetry.jsonl"
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    for row in rows:
        change(row)
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return verify(folder)


def test_a_jump_that_no_step_reports_is_violated(tmp_path: Path) -> None:
    certificate = edited(recorded(tmp_path / "run", simulated()), lambda row: row.pop("placed", None))
    steps = claim(certificate, "steps")
    assert certificate.verdict == "violated" and steps.status == "violated"
    assert "bodies are placed, but the step after it reports none" in steps.detail


def test_energy_that_placing_did_not_give_is_missed(tmp_path: Path) -> None:
    def forge(row: dict[str, Any]) -> None:
        if row.get("placed"):
            row["energy"]["placed"] += 0.1

    certificate = edited(recorded(tmp_path / "run", simulated()), forge)
    assert claim(certificate, "energy_ledger").status == "violated"


def test_a_run_of_a_scene_file_places_bodies_and_is_resumed_with_the_same_states(tmp_path: Path) -> None:
    file = tmp_path / "lift.py"
    file.write_text(
        "import stark\n"
        "until = 0.08\n"
        "def build():\n"
        "    scene = stark.Scene()\n"
        "    scene.add_floor(1.0)\n"
        "    scene.add_box(0.1, mass=0.5, position=(0, 0, 0.0505), name='box')\n"
        "    return scene, {'time.step': 0.01}\n"
        "def drive(sim):\n"
        "    if abs(sim.time - 0.05) < 1e-6:\n"
        "        sim['box'].position = (0, 0, 0.3)\n"
    )
    options: dict[str, Any] = {"picture": False, "replay": False, "certify": True}
    whole = stark.scenes.runner.run(str(file), out=tmp_path / "whole", **options)
    assert whole.status == "complete" and verify(tmp_path / "whole").verdict == "certified"
    stark.scenes.runner.run(str(file), out=tmp_path / "parts", until=0.05, **options)
    from stark.scenes.resuming import resume

    resume(tmp_path / "parts", until=0.08, picture=False, replay=False)
    assert verify(tmp_path / "parts").verdict == "certified"
    chunks = [(tmp_path / run / "states/chunk_000000.npz").read_bytes() for run in ("whole", "parts")]
    assert chunks[0] == chunks[1]


def test_measurements_place_nothing(tmp_path: Path) -> None:
    sim = simulated()
    with sim._held_still("measure(sim) of the scene", "read only"):
        with pytest.raises(stark.InvalidArgument, match=r"measure\(sim\) of the scene uses .*position"):
            sim["box"].position = (0, 0, 1)
        with pytest.raises(stark.InvalidArgument, match="placing"), sim.placing():
            pass
