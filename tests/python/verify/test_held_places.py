"""What holds what it finds, as the checker sees it."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from _recorded_runs import edit_states

import stark
from stark.recording import Recorder
from stark.verify import verify
from stark.verify.certificate import VERIFIED, VIOLATED
from stark.verify.files import UnreadableRecording

STEP, GRIPPED, RELEASED, LAST = 0.01, 12, 20, 25


@pytest.fixture(scope="module")
def gripped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A tool welds itself to a box and a picker to vertices of a cloth as they move; later they let go."""
    scene = stark.Scene("gripped")
    box = scene.add_box(0.1, mass=0.5, position=(0.01, 0.0, 0.0), angular_velocity=(0, 0, 1.0))
    cloth = scene.add_cloth(
        stark.mesh.grid(0.1, 0.1, cells=4), stark.materials.cotton, position=(0.4, 0.0, 0.0)
    )
    tool = scene.add_box(0.04, motion="scripted", position=(0, 0, 0.2), velocity=(0, 0, -0.1))
    picker = scene.add_sphere(0.01, motion="scripted", position=(0.4, 0.0, 0.1), velocity=(0, 0, 0.1))
    weld = scene.add_fixed(tool, box, anchor=(0, 0, 0.2), enabled=False, name="weld")
    pin = scene.add_ball(cloth.frame((0, 1, 5)), None, anchor=(0.35, -0.05, 0.0), enabled=False, name="pin")
    grip = scene.attach(cloth.vertices, picker, enabled=False, contact=False, name="grip")
    sim = stark.Simulation(scene, time_step=STEP, gravity=(0, 0, -1.0))
    folder = tmp_path_factory.mktemp("gripped") / "run"
    with Recorder(folder, sim, settings=sim.settings.to_dict(), scene=scene.name, certify=True) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        for k in range(LAST):
            if k == GRIPPED:
                weld.hold_here()
                pin.hold_here()
                grip.hold_here([12, 13])
            if k == RELEASED:
                weld.enabled = False
                grip.release()
            report = sim.step()
            assert not report.failed, report.message
            recorder.report(report)
            recorder.record_state(sim)
        recorder.record(sim)
    return folder


def claims(folder: Path) -> dict[str, stark.verify.Claim]:
    return {claim.name: claim for claim in verify(folder).claims}


@pytest.fixture
def copy(gripped: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(gripped, tmp_path / "copy"))


def test_what_is_held_where_it_was_found_is_verified(gripped: Path) -> None:
    found = claims(gripped)
    for name in ("joints", "attachments"):
        assert found[name].status == VERIFIED, found[name]
        assert found[name].worst > 0.0


@pytest.mark.parametrize(("number", "claim"), [(0, "joints"), (12, "joints"), (-1, "attachments")])
def test_places_that_hide_a_slip_are_found(copy: Path, number: int, claim: str) -> None:
    """A forger moves a body in a state and the place that it is held at along with it."""

    def move(places: np.ndarray, times: np.ndarray) -> None:
        column = number if number >= 0 else 12 + 3 + 3 * 12
        places[GRIPPED + 4 :, column] += 1e-4

    edit_states(copy, "held_places", move)
    assert claims(copy)[claim].status == VIOLATED


def test_places_taken_elsewhere_are_found(copy: Path) -> None:
    """The place that is held from the start of the grip on is not the one that was there."""

    def move(places: np.ndarray, times: np.ndarray) -> None:
        places[GRIPPED + 1 :, :3] += 1e-4

    edit_states(copy, "held_places", move)
    assert claims(copy)["joints"].status == VIOLATED


def test_missing_places_are_damage(copy: Path) -> None:
    path = copy / "states/chunk_000000.npz"
    with np.load(path) as stored:
        arrays = {key: stored[key] for key in stored.files if key != "held_places"}
    np.savez(path, **arrays)
    with pytest.raises(UnreadableRecording, match="held_places are missing or have a wrong shape"):
        verify(copy)
