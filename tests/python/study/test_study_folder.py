"""Study folders of others: nothing is executed, no link is written through, nothing huge is read."""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from _studies import FALL, grid, write_study

import stark
from stark.array_file import WriteError
from stark.recording import RecordingError
from stark.recording.lock import FolderLock
from stark.study import Plan, Study, StudyError
from stark.study.folder import LARGEST_RESULT


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    stark.study.run(write_study(folder, grid(height="[1.0, 2.0]")), folder / "out", processes=1)
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made / "out", tmp_path / "out", symlinks=True))


def edit(folder: Path, change: Callable[[dict[str, Any]], object]) -> None:
    manifest = json.loads((folder / "study.json").read_text())
    change(manifest)
    (folder / "study.json").write_text(json.dumps(manifest))


def result_of(folder: Path) -> Path:
    return sorted((folder / "results").iterdir())[0]


def test_folders_that_are_no_studies(tmp_path: Path, made: Path) -> None:
    with pytest.raises(StudyError, match=r"is not a study folder: it has no study.json"):
        Study(tmp_path)
    (tmp_path / "mine.txt").write_text("x")
    with pytest.raises(StudyError, match="is not empty and holds no study; choose another folder"):
        stark.study.run(made / "plan.toml", tmp_path)
    with pytest.raises(StudyError, match="is a file; choose a folder"):
        stark.study.run(made / "plan.toml", tmp_path / "mine.txt")
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize(
    "change",
    [
        lambda m: m.update(format="other"),
        lambda m: m.update(version=2),
        lambda m: m.pop("plan"),
        lambda m: m["plan"].update(scene=3),
        lambda m: m["plan"].update(samples=[{"a": []}]),
        lambda m: m["plan"].update(fps="fast"),
        lambda m: m["plan"].update(repetitions=1e9),
        lambda m: m["plan"].update(extra=1),
        lambda m: m["plan"]["limits"].update(retries="many"),
        lambda m: m.update(runs=3),
        lambda m: m["runs"][0].update(key="../../etc"),
        lambda m: m["runs"][0].update(options={"a": {}}),
    ],
)
def test_damaged_plans_are_refused(folder: Path, change: Callable[[dict[str, Any]], object]) -> None:
    edit(folder, change)
    with pytest.raises(StudyError, match=r"is damaged .*; run the plan anew"):
        Study(folder)


def test_a_scene_that_came_with_the_folder_is_not_executed(folder: Path, made: Path) -> None:
    (folder / "evil.py").write_text("raise SystemExit('executed')")
    for scene in (str(folder / "evil.py"), "evil.py", "./evil.py"):
        edit(folder, lambda m, scene=scene: m["plan"].update(scene=scene))
        study = Study(folder)
        assert study.counts() == {"complete": 2}  # needs no scene
        with pytest.raises(StudyError, match="must be an absolute path outside of the study folder"):
            study.resume()
    moved = stark.study.resume(folder, scene=made / "fall.py", processes=1)
    assert [row["cost.attempts"] for row in moved.rows()] == [1, 1]


@pytest.mark.parametrize("name", ["results", "runs", "attempts"])
def test_links_are_not_written_through(folder: Path, tmp_path: Path, name: str) -> None:
    shutil.rmtree(folder / "results")
    shutil.rmtree(folder / name, ignore_errors=True)
    outside = tmp_path / "outside"
    outside.mkdir()
    (folder / name).symlink_to(outside)
    with pytest.raises(WriteError, match="it is a link that leads out of its folder"):
        stark.study.resume(folder, processes=1)
    assert not list(outside.iterdir())


def test_links_of_runs_and_tables_are_not_written_through(folder: Path, tmp_path: Path) -> None:
    victim, outside = tmp_path / "victim", tmp_path / "outside"
    victim.write_text("mine")
    outside.mkdir()
    key = result_of(folder).stem
    shutil.rmtree(folder / "runs" / key)
    (folder / "runs" / key).symlink_to(outside)
    result_of(folder).unlink()
    (folder / "table.csv").unlink()
    (folder / "table.csv").symlink_to(victim)
    with pytest.raises(WriteError, match="it is a link"):
        stark.study.resume(folder, processes=1)
    (folder / "runs" / key).unlink()
    (folder / "attempts" / key).unlink()
    (folder / "attempts" / key).symlink_to(victim)
    with pytest.raises(WriteError, match="cannot be written"):
        stark.study.resume(folder, processes=1)
    (folder / "attempts" / key).unlink()
    assert stark.study.resume(folder, processes=1).counts() == {"complete": 2}
    assert victim.read_text() == "mine" and not (folder / "table.csv").is_symlink()
    assert not list(outside.iterdir())


def _fifo(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda path: path.write_text("{"),
        lambda path: path.write_text("[" * 100000),
        lambda path: path.write_text("3"),
        lambda path: path.write_text("x" * (LARGEST_RESULT + 1)),
        lambda path: path.write_text(path.read_text().replace('"complete"', '"good"')),
        lambda path: path.write_text(path.read_text().replace('"steps": 5', '"steps": "5"')),
        lambda path: path.write_text(path.read_text().replace(path.stem, "0" * 20)),
        _fifo,
    ],
)
def test_a_damaged_result_is_made_again(folder: Path, spoil: Callable[[Path], object]) -> None:
    first = Study(folder).rows()
    spoil(result_of(folder))
    study = Study(folder)
    assert study.counts() == {"complete": 1, "begun": 1}
    if result_of(folder).is_fifo():
        result_of(folder).unlink()
    again = study.resume(processes=1).rows()
    assert [row["state_hash"] for row in again] == [row["state_hash"] for row in first]


def test_a_study_has_one_writer(folder: Path, made: Path) -> None:
    lock = FolderLock(folder)
    with pytest.raises(RecordingError, match="is in use"):
        stark.study.resume(folder)
    before = (folder / "study.json").read_bytes()
    with pytest.raises(RecordingError, match="is in use"):
        stark.study.run(made / "plan.toml", folder)
    assert (folder / "study.json").read_bytes() == before
    lock.release()
    assert stark.study.resume(folder).counts() == {"complete": 2}


def test_results_are_standard_json_and_nan_comes_back(tmp_path: Path) -> None:
    def refuse(word: str) -> float:
        raise AssertionError(word)

    (tmp_path / "fall.py").write_text(FALL.replace('{"fallen": ', '{"none": float("nan"), "fallen": '))
    plan = Plan(str(tmp_path / "fall.py"), [{}])
    study = stark.study.run(plan, tmp_path / "study", processes=1)
    text = next((tmp_path / "study/results").iterdir()).read_text()
    assert json.loads(text, parse_constant=refuse)["observables"]["none"] is None
    assert math.isnan(study.rows()[0]["observables.none"])
