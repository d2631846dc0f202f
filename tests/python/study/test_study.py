"""Studies on local processes: tables, resuming, deaths, time-outs, failures."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _studies import grid, write_study

import stark
from stark.recording import Recording
from stark.study import Study, StudyError, local
from stark.study.sampling import latin_hypercube
from stark.study.table import COST
from stark.verify import verify

STUBBORN = """
def drive(sim):
    while options["height"] == 1.0:
        try:
            time.sleep(60)
        except KeyboardInterrupt:
            pass
"""
EXAMPLES = Path(__file__).parents[3] / "examples"
SOURCE = Path(stark.__file__).parents[1]  # of the package that is tested: installed or in the tree


def without_cost(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{name: value for name, value in row.items() if name not in COST} for row in rows]


def rows_of_csv(folder: Path) -> list[dict[str, str]]:
    with (folder / "table.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_rows_have_the_values_of_options_that_only_other_runs_are_given(tmp_path: Path) -> None:
    """A base of a study of one option at a time has the default of the option that varies."""
    sampling = (
        '[sampling]\nkind = "one_at_a_time"\n[sampling.options]\nlabel = ["a", "b"]\n'
        "[sampling.variations]\nheight = [2.0]\nsteps = [3]"
    )
    study = stark.study.run(write_study(tmp_path, sampling), tmp_path / "out", processes=1)
    found = [(row["option.label"], row["option.height"], row["option.steps"]) for row in study.rows()]
    assert found == [(label, *rest) for label in "ab" for rest in ((1.0, 1), (2.0, 1), (1.0, 3))]
    assert [row["option.height"] for row in rows_of_csv(study.folder)] == ["1.0", "2.0", "1.0"] * 2
    again = stark.study.resume(study.folder)
    assert (again.made, again.kept) == (0, 6)


def test_a_study_has_a_row_for_each_run(tmp_path: Path) -> None:
    plan = write_study(tmp_path, grid(height=[1.0, 2.0, 3.0], label='["a", "b"]'))
    told: list[tuple[int, int, float]] = []
    study = stark.study.run(
        plan,
        tmp_path / "out",
        processes=2,
        on_progress=lambda over, total, done: told.append((over, total, done)),
    )
    assert study.counts() == {"complete": 6}
    assert told[-1] == (6, 6, 6.0) and [over for over, *_ in told] == sorted(over for over, *_ in told)
    for row in study.rows():
        # Implicit Euler falls by g h^2 n (n + 1) / 2.
        assert row["observables.fallen"] == pytest.approx(9.81e-4 * 15, rel=1e-9)
        assert row["measured.height"] == pytest.approx(row["option.height"] - 9.81e-4 * 15, rel=1e-12)
        series = Recording(study.run_folder(np.int64(row["run"]))).telemetry
        assert series["measured.height"][-1] == row["measured.height"]
        assert study.run_folder(row["key"]) == study.run_folder(row["run"])
    for unknown in (6, -1, True, 0.5, None, "nokey", "../.."):
        with pytest.raises(StudyError, match=r"must be a number in \[0, 6\) or a key"):
            study.run_folder(unknown)  # type: ignore[arg-type]
        assert Recording(study.run_folder(row["key"])).status == "complete"
    table = rows_of_csv(tmp_path / "out")
    assert [float(row["observables.fallen"]) for row in table] == [
        row["observables.fallen"] for row in study.rows()
    ]
    again = stark.study.run(plan, tmp_path / "one", processes=1)
    assert without_cost(again.rows()) == without_cost(study.rows())


def test_runs_can_be_certified(tmp_path: Path) -> None:
    """Another study than the same without: other keys."""
    plan = write_study(tmp_path, grid(height="[1.0]"), "certify = true")
    study = stark.study.run(plan, tmp_path / "out", processes=1)
    (row,) = study.rows()
    certificate = verify(study.run_folder(row["key"]))
    assert certificate.verdict == "certified"
    write_study(tmp_path, grid(height="[1.0]"))
    (other,) = stark.study.run(plan, tmp_path / "plain", processes=1).rows()
    assert other["state_hash"] == row["state_hash"] and other["key"] != row["key"]
    assert verify(tmp_path / "plain/runs" / other["key"]).verdict == "inconclusive"


def test_resuming_repeats_nothing_and_a_plan_may_grow(tmp_path: Path) -> None:
    plan = write_study(tmp_path, grid(height="[1.0, 2.0]"))
    first = stark.study.run(plan, tmp_path / "out", processes=1).rows()
    assert stark.study.resume(tmp_path / "out", processes=1).rows() == first
    write_study(tmp_path, grid(height="[1.0, 1.5, 2.0]"))
    grown = stark.study.run(plan, tmp_path / "out", processes=1).rows()
    assert [row["cost.attempts"] for row in grown] == [1, 1, 1]
    assert grown[0] == first[0] and grown[2] == {**first[1], "run": 2}
    (tmp_path / "out/results" / f"{grown[1]['key']}.json").unlink()
    assert Study(tmp_path / "out").counts() == {"complete": 2, "begun": 1}
    assert without_cost(stark.study.resume(tmp_path / "out").rows()) == without_cost(grown)


def test_a_changed_scene_is_not_mixed_with_the_old_one(tmp_path: Path) -> None:
    plan = write_study(tmp_path, grid(height="[1.0]"))
    study = stark.study.run(plan, tmp_path / "out", processes=1)
    with (tmp_path / "fall.py").open("a") as file:
        file.write("# changed\n")
    with pytest.raises(StudyError, match=r"has changed since.*run the plan again"):
        study.resume()
    assert stark.study.run(plan, tmp_path / "out", processes=1).runs[0].key != study.runs[0].key


def test_a_killed_worker_is_retried_from_the_checkpoint(tmp_path: Path) -> None:
    plan = write_study(tmp_path, grid(height="[1.0, 2.0]", die=f'["{tmp_path}/died"]'))
    study = stark.study.run(plan, tmp_path / "out", processes=1)
    died, other = study.rows()
    assert (died["status"], died["cost.attempts"], other["cost.attempts"]) == ("complete", 2, 1)
    assert died["observables.fallen"] == pytest.approx(other["observables.fallen"], rel=1e-12)
    assert died["steps"] == 5 and len(Recording(study.run_folder(died["key"])).telemetry) == 5


def test_failures_are_rows(tmp_path: Path) -> None:
    runs = [
        "height = 1.0",
        "bad = true",
        f'die = "{tmp_path}/no/such/folder"',  # open() raises
        "wait = 60.0",
    ]
    sampling = '[limits]\ntime_out = 3.0\nretries = 0\n[sampling]\nkind = "list"\n'
    plan = write_study(tmp_path, sampling + "".join(f"[[sampling.runs]]\n{run}\n" for run in runs))
    study = stark.study.run(plan, tmp_path / "out", processes=4)
    good, bad, raised, late = study.rows()
    assert good["status"] == "complete"
    assert bad["status"] == "error"
    assert bad["message"].startswith("ValueError: a bad scene (fall.py, line ")
    assert raised["status"] == "error" and raised["message"].startswith("FileNotFoundError")
    assert late["status"] == "timed_out" and "limits.time_out = 3 s" in late["message"]
    assert len(rows_of_csv(tmp_path / "out")) == 4
    assert study.resume(retry_failed=False).rows()[1]["cost.attempts"] == 1
    assert study.resume(retry_failed=True).rows()[1]["cost.attempts"] == 2


def test_a_run_that_always_dies_is_a_row(tmp_path: Path) -> None:
    plan = write_study(tmp_path, "[limits]\nretries = 1\n" + grid(label='["a"]'))
    scene = (tmp_path / "fall.py").read_text()
    (tmp_path / "fall.py").write_text(scene + "\ndef drive(sim):\n    os.kill(os.getpid(), 11)\n")
    (row,) = stark.study.run(plan, tmp_path / "out", processes=1).rows()
    assert (row["status"], row["cost.attempts"]) == ("crashed", 2)
    assert row["message"].startswith("its process was killed by signal 11, 2 times; raise limits.retries")


def test_a_dead_worker_is_noticed_though_a_process_of_its_scene_lives(tmp_path: Path) -> None:
    """A fork has the pipe of the worker, which is then not closed by the death of the worker."""
    plan = write_study(tmp_path, "[limits]\nretries = 1\n" + grid(label='["a", "b"]'))
    scene = (tmp_path / "fall.py").read_text()
    forks = """
def drive(sim):
    if options["label"] == "b":
        if os.fork() == 0:
            time.sleep(30)
            os._exit(0)
        os.kill(os.getpid(), 9)
"""
    (tmp_path / "fall.py").write_text(scene + forks)
    began = time.monotonic()
    good, dead = stark.study.run(plan, tmp_path / "out", processes=2).rows()
    assert time.monotonic() - began < 20.0
    assert (good["status"], dead["status"]) == ("complete", "crashed")
    assert "was killed by signal 9, 2 times" in dead["message"]


def test_a_scene_that_exits_is_an_error_and_not_tried_again(tmp_path: Path) -> None:
    plan = write_study(tmp_path, grid(label='["a"]'))
    scene = (tmp_path / "fall.py").read_text()
    (tmp_path / "fall.py").write_text(scene + '\ndef drive(sim):\n    raise SystemExit("too steep")\n')
    (row,) = stark.study.run(plan, tmp_path / "out", processes=1).rows()
    assert (row["status"], row["cost.attempts"]) == ("error", 1)
    assert row["message"].startswith("SystemExit: too steep (fall.py, line ")


def test_a_run_that_does_not_heed_its_time_out_is_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(local, "_GRACE", 0.2)
    plan = write_study(tmp_path, "[limits]\ntime_out = 3.0\n" + grid(height="[1.0, 2.0]"))
    with (tmp_path / "fall.py").open("a") as file:
        file.write(STUBBORN)
    late, good = stark.study.run(plan, tmp_path / "out", processes=1).rows()
    assert (late["status"], good["status"]) == ("timed_out", "complete")


def test_scenes_may_print_and_read(tmp_path: Path) -> None:
    plan = write_study(tmp_path, grid(height="[1.0, 2.0, 3.0]"))
    with (tmp_path / "fall.py").open("a") as file:
        file.write("\nimport sys\nprint(sys.stdin.read())\nos.write(1, b'{}')\n")
    # This process executes the scene, too, to know its options; pytest lets nobody read its input.
    words = [
        sys.executable,
        "-m",
        "stark",
        "study",
        "run",
        str(plan),
        "--out",
        str(tmp_path / "out"),
        "--quiet",
    ]
    environment = {**os.environ, "PYTHONPATH": str(SOURCE)}
    subprocess.run(
        words, stdin=subprocess.DEVNULL, env=environment, check=True, timeout=60, capture_output=True
    )
    assert Study(tmp_path / "out").counts() == {"complete": 3}


def test_processes_that_do_not_start_are_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = write_study(tmp_path, grid(height="[1.0]"))
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(StudyError, match="a process ended with exit code 1 before it had work; see why"):
        stark.study.run(plan, tmp_path / "out", processes=1)


def test_the_example_is_twenty_short_runs(tmp_path: Path) -> None:
    study = stark.study.run(EXAMPLES / "slope.toml", tmp_path / "out", processes=2)
    assert study.counts() == {"complete": 20}
    # 0.04 s each on a free machine.
    assert sum(row["cost.cpu"] for row in study.rows()) < 10.0
    slid = {
        (row["option.angle"], row["option.friction"]): row["observables.distance"] for row in study.rows()
    }
    assert slid[10.0, 0.2] < 1e-4 < slid[30.0, 0.4] < slid[30.0, 0.1]


def _children(of: int) -> list[int]:
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = entry.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == of and fields[0] != "Z":
            found.append(int(entry.parent.name))
    return found


@pytest.mark.alone
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_nothing_is_left_behind_and_resuming_gives_the_same(tmp_path: Path, number: int) -> None:
    plan = write_study(tmp_path, grid(height="[1.0, 2.0, 3.0, 4.0]", wait="[0.1]"))
    words = [sys.executable, "-m", "stark", "study", "run", str(plan), "--out", str(tmp_path / "out")]
    process = subprocess.Popen(
        [*words, "--processes", "2"], stderr=subprocess.PIPE, env={**os.environ, "PYTHONPATH": str(SOURCE)}
    )
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline and len(list(tmp_path.glob("out/results/*.json"))) < 2:
        time.sleep(0.01)
    time.sleep(0.3)  # the next two are under way
    workers = _children(process.pid)
    assert len(workers) == 2
    sent = time.monotonic()
    process.send_signal(number)
    error = process.communicate(timeout=20)[1].decode()
    # A second is the aim on a free machine.
    assert time.monotonic() - sent < 3.0
    while any(Path(f"/proc/{pid}/cmdline").exists() for pid in workers) and time.monotonic() - sent < 10.0:
        time.sleep(0.01)
    assert not any(Path(f"/proc/{pid}/cmdline").exists() for pid in workers)
    if number == signal.SIGINT:
        assert process.returncode == 130
        assert error == f"stark: interrupted; go on with: stark study resume {tmp_path / 'out'}\n"
    study = Study(tmp_path / "out")
    assert study.counts() == {"complete": 2, "begun": 2}
    rows = study.resume(processes=2).rows()
    assert [row["status"] for row in rows] == ["complete"] * 4
    assert [row["cost.attempts"] for row in rows] == [1, 1, 2, 2]
    straight = stark.study.run(plan, tmp_path / "straight", processes=4).rows()
    assert without_cost(rows) == without_cost(straight)


@pytest.mark.parametrize(
    ("module", "call"),
    [
        ("ray", lambda study: study.resume(ray="local")),
        ("pyarrow", lambda study: study.write_parquet()),
        ("scipy.stats", lambda study: latin_hypercube({"x": [1, 2]}, 2, 0)),
    ],
)
def test_a_missing_extra_names_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, call: Callable[[Study], object]
) -> None:
    plan = write_study(tmp_path, grid(height="[1.0]"))
    study = stark.study.run(plan, tmp_path / "out", processes=1)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=r"needs .*: pip install 'stark-sim\[sweep\]'"):
        call(study)


def test_arguments_are_checked(tmp_path: Path) -> None:
    plan = write_study(tmp_path, grid(height="[1.0]"))
    with pytest.raises(stark.InvalidArgument, match="processes = 0; must be an integer from 1 to 1024"):
        stark.study.run(plan, tmp_path / "out", processes=0)
    with pytest.raises(stark.InvalidArgument, match="give one of them"):
        stark.study.run(plan, tmp_path / "out", processes=1, ray="auto")
    for bad, told in (({"ray": 3}, "ray = 3; must be the address"), ({"on_progress": 3}, "on_progress = 3")):
        with pytest.raises(stark.InvalidArgument, match=told):
            stark.study.run(plan, tmp_path / "out", **bad)
    assert not (tmp_path / "out").exists()


def test_a_run_that_raises_says_how_far_it_got(tmp_path: Path) -> None:
    """And so does one whose process dies."""
    plan = write_study(tmp_path, grid(label='["raise", "die"]'), "[limits]\nretries = 0\n")
    text = (tmp_path / "fall.py").read_text()
    bad = """
    if sim.time > 0.035 and options["label"] == "raise":
        raise ValueError("enough")
    if sim.time > 0.035 and options["label"] == "die":
        os.kill(os.getpid(), 9)
"""
    (tmp_path / "fall.py").write_text(text.replace("def drive(sim):", "def drive(sim):" + bad))
    raised, died = stark.study.run(plan, tmp_path / "out", processes=1).rows()
    assert (raised["status"], died["status"]) == ("error", "crashed")
    for row in (raised, died):
        assert row["steps"] == 4 and row["simulated"] == pytest.approx(0.04)
        assert row["newton_iterations"] > 0 and row["measured.height"] < 1.0
