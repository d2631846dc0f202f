"""Numbers that none can be, bounds that bound nothing, settings that lack: never a certificate, never a
traceback."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _recorded_runs import edit_rows, edit_states, record, reseal, sheet_on_box

import stark
from stark.cli import main
from stark.recording import Recorder
from stark.verify import UnreadableRecording, verify
from stark.verify.telemetry import _STORED, _TURNED_OVER, _impossible_energy

_NAN, _INFINITE = float("nan"), float("inf")


def _edit_json(run: Path, name: str, change: Callable[[Any], Any]) -> None:
    value = json.loads((run / name).read_text())
    change(value)
    (run / name).write_text(json.dumps(value))


def _settings(run: Path, **changes: Any) -> None:
    _edit_json(run, "manifest.json", lambda manifest: manifest["settings"].update(changes))


def _forget(run: Path, *names: str) -> None:
    _edit_json(run, "manifest.json", lambda manifest: [manifest["settings"].pop(name) for name in names])


@pytest.mark.parametrize("row", [0, 5, 19])
@pytest.mark.parametrize(
    ("keys", "value", "claim", "named"),
    [
        (("min_distance",), -1.0, "reported_distance", "min_distance = -1.0 m"),
        (("min_distance",), _NAN, "reported_distance", "min_distance = nan m"),
        (("min_distance",), 10**400, "reported_distance", "min_distance = 1000"),
        (("min_distance",), 0.0, "reported_distance", ""),
        (("acceleration",), -1.0, "residual", "acceleration = -1.0"),
        (("acceleration",), _NAN, "residual", "acceleration = nan"),
        (("residual",), -1.0, "residual", "residual = -1.0"),
        (("residual",), _NAN, "residual", "residual = nan"),
        (("last_motion",), -1e-9, "residual", "last_motion = -1e-09"),
        (("last_motion",), _NAN, "residual", "last_motion = nan"),
        (("time_step",), _INFINITE, "steps", "no valid time and time_step"),
        (("time",), "late", "steps", "no valid time and time_step"),
        (("energy", "external"), _INFINITE, "energy_ledger", "energy external = inf J"),
        (("energy", "contact"), _NAN, "energy_ledger", "energy contact = nan J"),
        (("energy", "contact"), -1.0, "energy_ledger", "energy contact = -1.0 J"),
        (("energy", "friction"), _INFINITE, "friction_dissipates", "not so in 1 steps"),
        (("energy", "gravity"), _NAN, "reported_energies", "gravity differs"),
        (("momentum", "z"), _NAN, "reported_momentum", "momentum differs"),
    ],
)
def test_impossible_telemetry(
    run: Path, row: int, keys: tuple[str, ...], value: Any, claim: str, named: str
) -> None:
    def change(rows: list[dict[str, Any]]) -> None:
        place = rows[row]
        for key in keys[:-1]:
            place = place[key]
        place[keys[-1]] = value

    edit_rows(run, change)
    certificate = verify(run)
    assert (certificate[claim].status, certificate.verdict) == ("violated", "violated"), certificate.text()
    assert named in certificate[claim].detail
    json.dumps(certificate.to_json(), allow_nan=False)
    assert main(["verify", str(run), "--quiet"]) == 1


def test_an_impossible_number_counts_where_any_tolerance_ends_a_step(run: Path) -> None:
    _settings(run, **{"newton.termination": "any"})
    assert verify(run)["residual"].status == "verified"
    edit_rows(run, lambda rows: rows[3].update(acceleration=-1.0))
    assert verify(run)["residual"].status == "violated"


def test_surfaces_that_meet_have_the_distance_nothing(run: Path) -> None:
    """The cube straddles the plate in the states; the telemetry says so, and says something else."""

    def lower(array: np.ndarray, times: np.ndarray) -> None:
        array[10:, ..., 2] -= 0.02

    def lower_pose(array: np.ndarray, times: np.ndarray) -> None:
        array[10:, 0, 2] -= 0.02

    edit_states(run, "positions_0003", lower)
    edit_states(run, "poses_0003", lower_pose)
    for reported in (0.0, 1e-4, None):

        def change(rows: list[dict[str, Any]], reported: float | None = reported) -> None:
            for row in rows:
                row["min_distance"] = reported

        edit_rows(run, change)
        certificate = verify(run)
        assert certificate.verdict == certificate["no_intersection"].status == "violated"
        assert main(["verify", str(run), "--quiet"]) == 1


@pytest.mark.parametrize("value", [None, 0, 1, "yes", [], False])
def test_contact_that_is_switched_off_by_damage(run: Path, value: Any) -> None:
    _edit_json(run, "states/scene.json", lambda scene: scene.update(contact_enabled=value))
    with pytest.raises(UnreadableRecording, match=rf"contact_enabled = {re.escape(repr(value))} must be"):
        verify(run)


def test_contact_that_is_switched_off_by_the_settings(tmp_path: Path) -> None:
    run = record(tmp_path / "run", sheet_on_box(), 3, **{"time_step": 0.01, "contact.enabled": False})
    assert verify(run)["no_intersection"].status == "not applicable"


@pytest.mark.parametrize("value", [-1.0, _NAN, _INFINITE, None, True, "0.1"])
@pytest.mark.parametrize(
    "name",
    [
        "contact.min_separation_factor",
        "joints.length_tolerance",
        "joints.angle_tolerance",
        "newton.acceleration_tolerance",
        "newton.step_tolerance",
    ],
)
def test_bounds_that_bound_nothing(run: Path, name: str, value: Any) -> None:
    _settings(run, **{name: value})
    with pytest.raises(UnreadableRecording, match=rf"{name} = .* must be a finite number >= 0"):
        verify(run)


@pytest.mark.parametrize("value", [-0.001, _NAN, _INFINITE])
def test_contact_distances_that_are_none(run: Path, value: float) -> None:
    def change(scene: dict[str, Any]) -> None:
        scene["bodies"][1]["contact_distance"] = value

    _edit_json(run, "states/scene.json", change)
    with pytest.raises(UnreadableRecording, match=r"body 'sheet': contact_distance = .* must be finite"):
        verify(run)


def test_tolerances_of_nothing(joined: Path, tmp_path: Path) -> None:
    """Joints are never held to the last bit: violated, not a division by zero."""
    run = Path(shutil.copytree(joined, tmp_path / "run"))
    _settings(run, **{"joints.length_tolerance": 0.0, "joints.angle_tolerance": 0.0})
    assert verify(run)["attachments"].status in ("verified", "violated")
    assert verify(run)["joints"].status in ("verified", "violated")


def test_a_joint_that_has_no_value_in_one_state(joined: Path, tmp_path: Path) -> None:
    """A patch without area has no axes: later states do not make up for it."""
    run = Path(shutil.copytree(joined, tmp_path / "run"))
    scene = json.loads((run / "states/scene.json").read_text())
    cloth = [body["name"] for body in scene["bodies"]].index("cloth")

    def flatten(array: np.ndarray, times: np.ndarray) -> None:
        array[1] = array[1, :1]

    edit_states(run, f"positions_{cloth:04d}", flatten)
    assert verify(run)["joints"].status == "violated"


@pytest.mark.parametrize(
    ("lacking", "claims"),
    [
        ("contact.min_separation_factor", ("minimum_distance",)),
        ("gravity", ("reported_energies", "reported_momentum")),
        ("time.integrator", ("reported_energies", "friction_dissipates")),
        ("joints.length_tolerance", ("joints", "attachments")),
        ("joints.angle_tolerance", ("joints", "attachments")),
        ("newton.acceleration_tolerance", ("residual",)),
    ],
)
def test_settings_that_lack(joined: Path, tmp_path: Path, lacking: str, claims: tuple[str, ...]) -> None:
    """Nothing is called wrong, or right, for want of what it is to be compared with."""
    run = Path(shutil.copytree(joined, tmp_path / "run"))
    _forget(run, lacking)
    reseal(run)
    certificate = verify(run)
    for name in claims:
        assert certificate[name].status == "inconclusive", certificate.text()
        assert f"lacks the setting {lacking}" in certificate[name].detail
    assert certificate.verdict != "violated", certificate.text()


@pytest.mark.parametrize("given", [None, {}])
def test_the_recorder_takes_the_settings_of_the_simulation(
    tmp_path: Path, given: dict[str, Any] | None
) -> None:
    """Settings that are said to be none are none: inconclusive."""
    sim = stark.Simulation(sheet_on_box(), time_step=0.01, contact_distance=0.001)
    recorder = Recorder(tmp_path / "run", sim, settings=given, certify=True)
    recorder.record(sim)
    recorder.record_state(sim)
    for _ in range(3):
        recorder.report(sim.step())
        recorder.record_state(sim)
    recorder.close()
    assert verify(tmp_path / "run").verdict == ("certified" if given is None else "inconclusive")


def test_the_recording_of_the_guide_is_certified(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    guide = Path(__file__).parents[3] / "docs/verify.md"
    (code,) = re.findall(r"```python\n(.*?)```", guide.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(code, str(guide), "exec"), {})


def test_contact_may_round_below_nothing() -> None:
    """Of 1 J elsewhere 2^-52 J; a campaign had -6e-46 J."""
    energy = dict.fromkeys((*_STORED, *_TURNED_OVER), 0.0) | {"kinetic": 1.0}
    for contact, named in ((-6e-46, False), (-(2.0**-52), False), (-1e-12, True)):
        rows = [{"step": 4, "energy": energy | {"contact": contact}}]
        assert bool(_impossible_energy(rows)) is named
