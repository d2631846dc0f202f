"""The checker looks at what was released from when contact came back on, and at scripted bodies."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from _recorded_runs import record, reseal

import stark
from stark.array_file import read_arrays, write_arrays
from stark.verify import verify


def _sheet_on_box() -> stark.Scene:
    scene = stark.Scene()
    box = scene.add_box(0.2, motion="fixed", name="box")
    sheet = scene.add_cloth(stark.mesh.grid(0.15, 0.15, 6), position=(0, 0, 0.102), name="sheet")
    scene.attach(sheet.vertices[[16, 17, 23, 24, 25, 31, 32]], box, break_force=1e-3)
    scene.add_hinge(sheet.frame((0, 1, 7)), box, anchor=None, enabled=False)
    return scene


@pytest.fixture(scope="module")
def released(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("released") / "run", _sheet_on_box(), 30, contact_distance=1e-3)


def _edit(folder: Path, change: object) -> None:
    for path in sorted((folder / "states").glob("chunk_*.npz")):
        arrays = dict(read_arrays(path))
        change(arrays)  # type: ignore[operator]
        write_arrays(path, arrays)


def _copied(released: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(released, tmp_path / "run"))


def test_released_pairs_are_certified_from_then_on(released: Path) -> None:
    certificate = verify(released)
    assert certificate.verdict == "certified", certificate.text()
    assert certificate["minimum_distance"].worst is not None


def test_what_sinks_in_after_its_release_is_found(released: Path, tmp_path: Path) -> None:
    """Vertices around the middle, which were attached, 7 mm in the box at the end."""
    run = _copied(released, tmp_path)

    def sink(arrays: dict[str, np.ndarray]) -> None:
        arrays["positions_0001"] = arrays["positions_0001"].copy()
        arrays["positions_0001"][-1, 24, 2] = 0.093

    _edit(run, sink)
    assert verify(run)["no_intersection"].status == "violated"

    def hide(arrays: dict[str, np.ndarray]) -> None:
        arrays["contact_regained"] = np.zeros_like(arrays["contact_regained"])

    _edit(run, hide)  # excluded again, it is nobody's business
    assert verify(run)["no_intersection"].status == "verified"


def test_contact_that_comes_back_may_store_energy(released: Path, tmp_path: Path) -> None:
    """As between bodies that push each other elsewhere; in other steps it would come from nowhere."""
    regained = np.concatenate(
        [
            np.broadcast_to(rows, (len(arrays["times"]), rows.shape[1]))
            for path in sorted((released / "states").glob("chunk_*.npz"))
            for arrays in [dict(read_arrays(path))]
            for rows in [arrays["contact_regained"]]
        ]
    )
    comes_back = (np.diff(regained, axis=0) > 0).any(axis=1)  # by row: the step that leads there
    back, later = int(np.flatnonzero(comes_back)[-1]), len(comes_back) - 1
    assert 0 < back < later

    def claim_with_more(row: int) -> str:
        run = Path(shutil.copytree(released, tmp_path / f"run_{row}"))
        lines = [json.loads(line) for line in (run / "telemetry.jsonl").read_text().splitlines()]
        lines[row]["contact_energy_at_start"] += 1.0
        lines[row]["energy"]["numerical"] += 1.0
        (run / "telemetry.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
        reseal(run)
        return verify(run)["energy_ledger"].status

    assert claim_with_more(back) == "verified"
    assert claim_with_more(later) == "violated"


def test_lists_of_exclusions_that_do_not_fit_are_damage(released: Path, tmp_path: Path) -> None:
    run = _copied(released, tmp_path)
    _edit(run, lambda arrays: arrays.update(contact_regained=arrays["contact_regained"][:, 1:]))
    with pytest.raises(stark.verify.UnreadableRecording, match="contact_regained"):
        verify(run)


@pytest.mark.parametrize("end", [0.02, 0.3])
def test_scripted_bodies_that_meet_are_not_certified(tmp_path: Path, end: float) -> None:
    """Into a wall of 2 mm, and through it in one step."""
    scene = stark.Scene()
    scene.add_box((0.002, 0.4, 0.4), position=(0.061, 0, 0), motion="fixed", name="wall")
    ram = scene.add_box(0.1, motion="scripted", name="ram")
    scene.add_box(0.1, position=(0.061, 0, 0.3), motion="fixed", name="pillar")
    scene.add_box(0.1, mass=1.0, position=(0, 3, 0))
    apart = verify(record(tmp_path / "apart", scene, 3, time_step=0.01))
    assert apart["prescribed_motion"].status == "verified" and apart.verdict == "certified"
    ram.follow(lambda t: (end if t > 0.015 else 0.0, 0, 0))
    claim = verify(record(tmp_path / "run", scene, 4, time_step=0.01))["prescribed_motion"]
    assert claim.status == "violated"
    assert ("ram" in claim.detail) == (end == 0.02)
    scene.disable_contact("wall", "ram")
    off = verify(record(tmp_path / "off", scene, 4, time_step=0.01))
    assert off["prescribed_motion"].status == "verified"  # of the ram and the pillar


def test_scripted_bodies_may_touch(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_floor(1.0)
    scene.add_box(0.1, motion="scripted", position=(0, 0, 0.05), velocity=(0.1, 0, 0))
    certificate = verify(record(tmp_path / "run", scene, 3, time_step=0.01))
    assert certificate["prescribed_motion"].status == "verified"
