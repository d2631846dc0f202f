"""The chain of digests: whatever is changed, left out or exchanged shows, and is named; what a forger who
computes all digests anew achieves is found from the content, or is a limit that the certificate names."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _recorded_runs import edit_json, record, reseal, sheet_on_box

import stark
from stark.cli import main
from stark.recording import Recorder
from stark.verify import Certificate, verify

_BOX, _SHEET, _PLATE, _CUBE = range(4)


def _lines(run: Path, change: Callable[[list[str]], None]) -> None:
    path = run / "telemetry.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    change(lines)
    path.write_text("".join(lines))


def _arrays(run: Path, name: str, change: Callable[[dict[str, np.ndarray]], None]) -> None:
    with np.load(run / name) as stored:
        arrays = {key: stored[key].copy() for key in stored.files}
    change(arrays)
    np.savez(run / name, **arrays)


def _exchange(arrays: dict[str, np.ndarray]) -> None:
    """Two rows, times apart."""
    for name, rows in arrays.items():
        if name != "times" and len(rows) > 1:
            rows[[3, 9]] = rows[[9, 3]]


def _move_frames(arrays: dict[str, np.ndarray]) -> None:
    arrays[f"positions_{_SHEET:04d}"][:, :, 2] += 0.5


def _all_pairs(scene: dict[str, Any]) -> None:
    scene["pairs_without_contact"] = [[a, b] for a in range(4) for b in range(a, 4)]


def _contact_off(run: Path) -> None:
    edit_json(run, "states/scene.json", lambda scene: scene.update(contact_enabled=False))
    edit_json(run, "manifest.json", lambda m: m["settings"].update({"contact.enabled": False}))


def _cut(run: Path) -> None:
    """To the first ten steps of twenty, all files alike."""

    def first(count: int) -> Callable[[dict[str, np.ndarray]], None]:
        return lambda arrays: arrays.update({name: rows[:count] for name, rows in arrays.items()})

    _lines(run, lambda lines: lines.__delitem__(slice(10, None)))
    _arrays(run, "states/chunk_000000.npz", first(11))
    _arrays(run, "frames/chunk_000000.npz", first(1))

    def count(manifest: dict[str, Any]) -> None:
        manifest["states"]["count"], manifest["frame_count"] = 11, 1

    edit_json(run, "manifest.json", count)


def _swap_streams(run: Path) -> None:
    """Frames of another run of the same scene, with its own good digests."""
    other = run.parent / "other"
    record(other, sheet_on_box(), 20, time_step=0.005, contact_distance=0.001)
    shutil.copy(other / "frames/chunk_000000.npz", run / "frames/chunk_000000.npz")


def _rows(run: Path, change: Callable[[int, dict[str, Any]], None]) -> None:
    """Changes rows of telemetry by their number."""

    def each(lines: list[str]) -> None:
        rows = [json.loads(line) for line in lines]
        for k, row in enumerate(rows):
            change(k, row)
        lines[:] = [json.dumps(row) + "\n" for row in rows]

    _lines(run, each)


def _zero_residual(_k: int, row: dict[str, Any]) -> None:
    row.update(acceleration=0.0, residual=0.0, last_motion=0.0)


def _shift_elastic(_k: int, row: dict[str, Any]) -> None:
    row["energy"]["elastic"] += 5.0


def _supply_elastic(k: int, row: dict[str, Any]) -> None:
    row["energy"]["elastic"] += k + 1.0
    row["energy"]["external"] += 1.0


def _double_friction(_k: int, row: dict[str, Any]) -> None:
    row["energy"]["numerical"] -= row["energy"]["friction"]
    row["energy"]["friction"] *= 2.0


def _unchained(run: Path) -> None:
    """As an older version of Stark wrote it."""
    edit_json(run, "manifest.json", lambda manifest: manifest.pop("chain"))
    for name in ("frames/chunk_000000.npz", "states/chunk_000000.npz"):
        _arrays(run, name, lambda arrays: arrays.pop("chain"))

    def strip(lines: list[str]) -> None:
        rows = [json.loads(line) for line in lines]
        lines[:] = [json.dumps({k: row[k] for k in row if k != "chain"}) + "\n" for row in rows]

    _lines(run, strip)


_EDITS: dict[str, tuple[Callable[[Path], None], str]] = {
    "setting": (
        lambda run: edit_json(run, "manifest.json", lambda m: m["settings"].update({"newton.armijo": 0.1})),
        "the manifest was changed",
    ),
    "name": (
        lambda run: edit_json(run, "manifest.json", lambda m: m.update(scene="another")),
        "the manifest was changed",
    ),
    "pairs": (
        lambda run: edit_json(run, "states/scene.json", _all_pairs),
        "meshes or the description of the scene are not those of the recording",
    ),
    "number": (
        lambda run: _lines(run, lambda lines: lines.__setitem__(4, lines[4].replace('"time":', '"time":1'))),
        "line 5 of telemetry is not the one that was recorded there",
    ),
    "line left out": (
        lambda run: _lines(run, lambda lines: lines.pop(7)),
        "line 8 of telemetry is not the one that was recorded there",
    ),
    "last line left out": (
        lambda run: _lines(run, lambda lines: lines.pop()),
        "telemetry has 19 lines, recorded were 20",
    ),
    "line more": (
        lambda run: _lines(run, lambda lines: lines.append(lines[-1])),
        "line 21 of telemetry is not the one that was recorded there",
    ),
    "states": (
        lambda run: _arrays(run, "states/chunk_000000.npz", _exchange),
        "state 3 is not the one that was recorded there",
    ),
    "frames": (
        lambda run: _arrays(run, "frames/chunk_000000.npz", _move_frames),
        "frame 0 is not the one that was recorded there",
    ),
    "frames of another run": (_swap_streams, "frames do not end as they did when they were recorded"),
    "end": (_cut, "states do not end as they did when they were recorded"),
    "chain of the manifest": (
        lambda run: edit_json(run, "manifest.json", lambda m: m.pop("chain")),
        "states have digests, the manifest has none",
    ),
    "digests of states": (
        lambda run: _arrays(run, "states/chunk_000000.npz", lambda arrays: arrays.pop("chain")),
        "state 0 lacks its digest",
    ),
}


@pytest.mark.parametrize("name", _EDITS)
def test_what_was_changed_is_named(run: Path, name: str) -> None:
    edit, message = _EDITS[name]
    edit(run)
    certificate = verify(run)
    assert (certificate.verdict, certificate["chain"].status) == ("violated", "violated")
    assert message in certificate["chain"].detail, certificate["chain"].detail


def test_a_good_recording_has_no_limits(good: Path) -> None:
    certificate = verify(good)
    assert certificate["chain"].status == certificate["display"].status == "verified"
    assert certificate.limits == ()
    assert certificate.taken_as_reported == ("residual", "energy_ledger", "friction_dissipates")


# --- forgers, who compute all digests anew ---


def _limited(certificate: Certificate, text: str) -> bool:
    return certificate.verdict == "certified" and any(text in limit for limit in certificate.limits)


def _as_reported(certificate: Certificate, *claims: str) -> bool:
    printed = certificate.text().splitlines()[-1]
    return (
        certificate.verdict == "certified"
        and set(claims) <= set(certificate.taken_as_reported)
        and all(claim in printed for claim in claims)
    )


def _violated(certificate: Certificate, claim: str) -> bool:
    return certificate.verdict == "violated" and certificate[claim].status == "violated"


_FORGERIES: dict[str, tuple[Callable[[Path], None], Callable[[Certificate], bool]]] = {
    "pairs": (
        lambda run: edit_json(run, "states/scene.json", _all_pairs),
        lambda c: _limited(c, "'box' and 'sheet'") and c["no_intersection"].status == "not applicable",
    ),
    "a pair": (
        lambda run: edit_json(
            run, "states/scene.json", lambda s: s["pairs_without_contact"].append([_SHEET, _CUBE])
        ),
        lambda c: (
            _limited(c, "1 pair not looked at, excluded by the scene: 'sheet' and 'cube'")
            and "(without 1 pair of bodies, see limits)" in c["no_intersection"].statement
        ),
    ),
    "contact off": (_contact_off, lambda c: _limited(c, "contact is off")),
    "tolerances": (
        lambda run: edit_json(
            run, "manifest.json", lambda m: m["settings"].update({"newton.acceleration_tolerance": 1e30})
        ),
        lambda c: _limited(c, "newton.acceleration_tolerance = 1e+30 m/s^2 is looser than the default"),
    ),
    "separation": (
        lambda run: edit_json(
            run, "manifest.json", lambda m: m["settings"].update({"contact.min_separation_factor": 0.0})
        ),
        lambda c: any("asks for less distance" in limit for limit in c.limits),
    ),
    "frames": (
        lambda run: _arrays(run, "frames/chunk_000000.npz", _move_frames),
        lambda c: _violated(c, "display") and "'sheet': is off by 0.5 m" in c["display"].detail,
    ),
    "times of frames": (
        lambda run: _arrays(run, "frames/chunk_000000.npz", lambda a: a["times"].__iadd__(1e-6)),
        lambda c: _limited(c, "2 are at times without a state"),
    ),
    "mesh of frames": (
        lambda run: _arrays(
            run, "frames/topology.npz", lambda a: a.update({k: v[::-1] for k, v in a.items()})
        ),
        lambda c: _violated(c, "display") and "another mesh is displayed" in c["display"].detail,
    ),
    "end": (
        lambda run: (_cut(run), edit_json(run, "manifest.json", lambda m: m.update(status="running"))),
        lambda c: _limited(c, "ends at step 10, 0.1 s: its end is not recorded"),
    ),
    "residual": (
        lambda run: _rows(run, _zero_residual),
        lambda c: _as_reported(c, "residual"),
    ),
    "elastic energy": (
        lambda run: _rows(run, _shift_elastic),
        lambda c: _as_reported(c, "energy_ledger"),
    ),
    "elastic energy and work": (
        lambda run: _rows(run, _supply_elastic),
        lambda c: _as_reported(c, "energy_ledger"),
    ),
    "friction": (
        lambda run: _rows(run, _double_friction),
        lambda c: _as_reported(c, "energy_ledger", "friction_dissipates"),
    ),
    "no chain": (None, lambda c: _limited(c, "no chain: nothing shows")),
}  # type: ignore[dict-item]


@pytest.mark.parametrize("name", _FORGERIES)
def test_what_a_forger_achieves_is_found_or_named(run: Path, name: str) -> None:
    forge, expected = _FORGERIES[name]
    if forge is None:
        _unchained(run)
    else:
        forge(run)
        reseal(run)
        assert verify(run)["chain"].status == "verified"
    certificate = verify(run)
    assert expected(certificate), certificate.text()


# --- limits ---


def test_limits_know_the_defaults() -> None:
    """The checker has them written down once more."""
    from stark.verify.limits import _SEPARATION, _TOLERANCES

    defaults = stark.Settings().to_dict()
    for name, (_, value) in _TOLERANCES.items():
        assert defaults[name] == value, name
    assert defaults[_SEPARATION[0]] == _SEPARATION[1]


def test_what_a_scene_leaves_out_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = sheet_on_box()
    ghost = scene.add_box(0.05, name="ghost", motion="scripted", position=(0.0, 2.0, 0.0))
    other = scene.add_box(0.05, name="other", motion="scripted", position=(0.0, 3.0, 0.0))
    assert ghost and other
    scene.disable_contact("ghost", "sheet")
    run = record(
        tmp_path / "run", scene, 2, time_step=0.01, contact_distance=0.001, **{"contact.friction": False}
    )
    certificate = verify(run)
    assert certificate.recording["excluded_pairs"] == [
        {"bodies": ["box", "ghost"], "reason": "the scene moves both"},
        {"bodies": ["box", "other"], "reason": "the scene moves both"},
        {"bodies": ["sheet", "ghost"], "reason": "excluded by the scene"},
        {"bodies": ["plate", "ghost"], "reason": "the scene moves both"},
        {"bodies": ["plate", "other"], "reason": "the scene moves both"},
        {"bodies": ["ghost", "other"], "reason": "the scene moves both"},
    ]
    text = "\n".join(certificate.limits)
    assert "1 pair not looked at, excluded by the scene: 'sheet' and 'ghost'" in text
    assert "5 pairs not looked at, the scene moves both: 'box' and 'ghost'" in text
    assert "friction is off" in text
    assert main(["verify", str(run)]) == 0
    printed = capsys.readouterr().out
    assert "sheet_on_box: certified, with 3 limits (2 steps)" in printed
    assert main(["verify", str(run), "--strict", "--quiet"]) == 3


def test_a_killed_run_has_no_end(tmp_path: Path) -> None:
    sim = stark.Simulation(sheet_on_box(), time_step=0.01, contact_distance=0.001)
    recorder = Recorder(tmp_path / "run", sim, certify=True, chunk_frames=4)
    for k in range(6):
        if k:
            recorder.report(sim.step())
        recorder.record(sim)
        recorder.record_state(sim)
    certificate = verify(tmp_path / "run")
    assert certificate["chain"].status == "verified", certificate["chain"].detail
    assert any("its end is not recorded" in limit for limit in certificate.limits)
    _lines(tmp_path / "run", lambda lines: lines.__setitem__(0, lines[0].replace("0.01", "0.02")))
    assert verify(tmp_path / "run")["chain"].status == "violated"
    recorder.close()


def test_all_kinds_of_bodies_are_displayed_where_they_are(tmp_path: Path, joined: Path) -> None:
    """Solids by their surface, rods as tubes around their nodes, rigid bodies by what they show."""
    scene = stark.Scene("all")
    scene.add_solid(stark.mesh.tet_box((0.1, 0.05, 0.05), 2), mass=0.3, name="solid")
    cord = stark.materials.rubber_cord
    for k, material in enumerate((cord, cord.replace(width=0.01, height=0.002))):
        line = stark.mesh.polyline((0, 0, 0), (0.1, 0.02, 0.0), 5)
        scene.add_rod(line, material, name=f"rod_{k}", position=(1.0 + k, 0.0, 0.0))
    ball = stark.mesh.sphere(0.08, 2).translated((0.01, 0.0, 0.0))
    tumbling: dict[str, Any] = {"position": (0.0, 1.0, 0.0), "angular_velocity": (3.0, 1.0, -2.0)}
    scene.add_box(0.1, mass=0.3, name="ball", shown=ball, **tumbling)
    run = record(tmp_path / "run", scene, 3, time_step=0.01)
    for folder in (run, joined):
        assert verify(folder)["display"].status == "verified", verify(folder)["display"].detail
    for body in range(4):
        copy = Path(shutil.copytree(run, tmp_path / f"copy_{body}"))

        def move(arrays: dict[str, np.ndarray], body: int = body) -> None:
            arrays[f"positions_{body:04d}"][1] += np.float32(1e-4)

        _arrays(copy, "frames/chunk_000000.npz", move)
        reseal(copy)
        assert verify(copy)["display"].status == "violated"


def test_minus_zero_is_another_number(tmp_path: Path) -> None:
    """Equal numbers of other bytes are not stored as one: the chain is about bytes."""
    scene = stark.Scene("zero")
    scene.add_box(0.1, name="still", motion="scripted")
    sim = stark.Simulation(scene, time_step=0.01)
    with Recorder(tmp_path / "run", sim, certify=True) as recorder:
        for k in range(4):
            recorder.record(sim)
            recorder.record_state(sim)
            if k < 3:
                sim["still"].position = (0.0, -0.0 if k % 2 else 0.0, 0.0)
                recorder.report(sim.step())
    certificate = verify(tmp_path / "run")
    assert certificate["chain"].status == "verified", certificate["chain"].detail
