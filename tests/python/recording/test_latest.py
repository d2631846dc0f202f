"""The newest recording of a simulation: frames that are not written yet, folders that others took."""

from __future__ import annotations

import gc
import json
import shutil
import weakref
from pathlib import Path
from types import SimpleNamespace

from fake_simulation import FakeSimulation, record

from stark.recording import Recorder
from stark.recording.latest import latest_recording


def test_a_recording_under_way_has_all_frames(tmp_path: Path) -> None:
    sim = FakeSimulation()
    assert latest_recording(sim) is None
    with Recorder(tmp_path / "run", sim) as recorder:
        assert latest_recording(sim) is None  # no frames
        for count in (1, 2, 3):
            recorder.record(sim, time=0.1 * count)
            assert len(latest_recording(sim)) == count
    assert len(latest_recording(sim)) == 3
    with Recorder(tmp_path / "other", sim) as recorder:
        recorder.record(sim)
    assert latest_recording(sim).folder == tmp_path / "other"


def test_asking_does_not_change_what_is_written(tmp_path: Path) -> None:
    for name, asks in (("asked", True), ("plain", False)):
        sim = FakeSimulation()
        with Recorder(tmp_path / name, sim, chunk_frames=2) as recorder:
            for k in range(5):
                recorder.record(sim, time=0.1 * k)
                assert not asks or latest_recording(sim) is not None
    files = [sorted(p.name for p in (tmp_path / name / "frames").iterdir()) for name in ("asked", "plain")]
    assert files[0] == files[1]
    for file in files[0]:
        assert (tmp_path / "asked/frames" / file).read_bytes() == (
            tmp_path / "plain/frames" / file
        ).read_bytes()


def test_folders_that_are_gone_or_of_others(tmp_path: Path) -> None:
    sim = FakeSimulation(cells=4)
    with Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
    shutil.rmtree(tmp_path / "run")
    assert latest_recording(sim) is None
    later = record(tmp_path / "run", 1, cells=4)  # another simulation, a second later
    manifest = json.loads((tmp_path / "run/manifest.json").read_text()) | {"created": "2100-01-01T00:00:00Z"}
    (tmp_path / "run/manifest.json").write_text(json.dumps(manifest))
    assert len(later) == 2 and latest_recording(sim) is None


def test_neither_simulations_nor_recorders_are_kept_alive(tmp_path: Path) -> None:
    sim = FakeSimulation()
    recorder = Recorder(tmp_path / "run", sim)
    recorder.record(sim)
    recorder.sync()
    alive = [weakref.ref(sim), weakref.ref(recorder)]
    del recorder
    assert alive[1]() is None
    assert len(latest_recording(sim)) == 1  # what it has written
    del sim
    gc.collect()
    assert alive[0]() is None
    Recorder(tmp_path / "plain", SimpleNamespace(bodies=[], time=0.0)).close()  # cannot be referred to weakly
