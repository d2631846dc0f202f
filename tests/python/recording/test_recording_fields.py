"""Fields and contacts in recordings: what handles told at that time, also after a resumed run; damage is
named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import FakeSimulation

import stark
from stark.array_file import read_arrays, write_arrays
from stark.recording import Recorder, Recording, RecordingError
from stark.recording.fields import MOST_CONTACTS
from stark.render import field_values

SCENE = """
import stark

def build():
    scene = stark.Scene()
    scene.add_box((0.6, 0.6, 0.05), name="table", motion="fixed", position=(0, 0, -0.025))
    scene.add_solid(stark.mesh.tet_box((0.2, 0.2, 0.15), (2, 2, 2)), name="jelly", position=(0, 0, 0.0755))
    scene.add_sphere(0.05, name="ball", subdivisions=1, mass=0.6, position=(0.03, 0, 0.205))
    return scene

def settings():
    return {"time_step": 0.01}
"""


def jelly() -> stark.Simulation:
    names: dict[str, Any] = {}
    exec(SCENE, names)
    return stark.Simulation(names["build"](), **names["settings"]())


def height(sim: Any) -> dict[Any, np.ndarray]:
    return {sim["jelly"]: sim["jelly"].positions[:, 2]}


def record(folder: Path, steps: int = 6, **options: Any) -> tuple[Recording, list[dict[str, Any]]]:
    """A recording in chunks of 4 frames, and what handles told at each frame."""
    sim, told = jelly(), []
    options = {
        "fields": ("stress", "pressure"),
        "contacts": True,
        "arrays": {"height [m]": height},
        **options,
    }
    with Recorder(folder, sim, chunk_frames=4, **options) as recorder:
        for k in range(steps + 1):
            if k > 0:
                recorder.report(sim.step())
            recorder.record(sim)
            told.append(
                {
                    "stress": field_values(sim, "stress")["jelly"],
                    "pressure": field_values(sim, "pressure"),
                    "height": sim["jelly"].positions[:, 2],
                    "force": [body.contact_forces.sum(axis=0) for body in sim.bodies],
                }
            )
    return Recording(folder), told


def drawn(sim: stark.Simulation, values: np.ndarray) -> np.ndarray:
    """Of the vertices of the surface of the jelly."""
    return values[np.unique(sim["jelly"].triangles)]


def test_a_recording_has_what_handles_told(tmp_path: Path) -> None:
    run, told = record(tmp_path / "run")
    sim = jelly()
    assert [entry.name for entry in run.fields] == ["stress", "pressure", "height [m]"]
    assert [entry.unit for entry in run.fields] == ["Pa", "Pa", "m"]
    assert run.fields[0].bodies == (1,) and run.fields[1].bodies == (1, 2)  # the table is fixed
    for k in (0, 3, 4, 6):
        stress = run.field("stress", k)
        assert list(stress) == ["jelly"]
        np.testing.assert_array_equal(stress["jelly"], drawn(sim, told[k]["stress"]).astype(np.float32))
        ball = run.field("pressure", k)["ball"]
        np.testing.assert_array_equal(ball, told[k]["pressure"]["ball"].astype(np.float32))
        np.testing.assert_array_equal(
            run.field("height [m]", k)["jelly"], drawn(sim, told[k]["height"]).astype(np.float32)
        )
    assert run.field("stress", -1)["jelly"].max() > 100.0  # [Pa] the ball and its own weight press


def test_contacts_add_up_to_the_forces_on_bodies(tmp_path: Path) -> None:
    run, told = record(tmp_path / "run")
    found = run.contacts(-1)
    assert 0 < len(found.points) < MOST_CONTACTS
    np.testing.assert_allclose(found.body_forces, told[-1]["force"], rtol=1e-5, atol=1e-6)  # float32
    sums = np.zeros((3, 3))
    np.add.at(sums, found.bodies[:, 0], found.forces)
    np.subtract.at(sums, found.bodies[:, 1], found.forces)
    np.testing.assert_allclose(sums, found.body_forces, rtol=1e-4, atol=1e-5)
    low, high = run.positions("table", 0).min(axis=0), run.positions("ball", -1).max(axis=0)
    assert (found.points[:, 2] > low[2]).all() and (found.points[:, 2] < high[2]).all()


def test_frames_draw_and_export_recorded_fields(tmp_path: Path) -> None:
    from stark.exports import export_recording

    run, _ = record(tmp_path / "run")
    options: dict[str, Any] = {"width": 160, "height": 90, "quality": "draft", "hide": "ball"}
    plain = run.still(0.06, **options)
    colored = run.still(0.06, field="stress", **options)
    assert (np.abs(colored.astype(int) - plain.astype(int)).max(axis=2) > 40).mean() > 0.02
    marked = run.still(0.06, contacts=True, **options)
    assert (np.abs(marked.astype(int) - plain.astype(int)).max(axis=2) > 40).any()
    on_ball = run.still(0.06, contacts="ball", width=160, height=90, quality="draft")
    assert on_ball.shape == (90, 160, 3)
    files = export_recording(run, tmp_path / "vtu", "vtu", frames=[6])
    text = files[0].read_bytes()
    for name in (b"displacement", b"velocity", b"stress", b"pressure", b"height_m"):
        assert b'Name="' + name + b'"' in text
    with pytest.raises(stark.InvalidArgument, match="stark run --fields speed"):
        run.field("speed", 0)
    with pytest.raises(stark.InvalidArgument, match="needs a simulation"):
        run.still(0.06, field="speed", **options)


def test_a_resumed_run_has_the_same_fields(tmp_path: Path) -> None:
    scene = tmp_path / "jelly.py"
    scene.write_text(SCENE)
    options: dict[str, Any] = {"fields": ("stress",), "contacts": True}
    common: dict[str, Any] = {"replay": False, "picture": False}
    run = stark.scenes.run(scene, out=tmp_path / "once", until=0.08, fps=100, **options, **common)
    stark.scenes.run(scene, out=tmp_path / "twice", until=0.04, fps=100, **options, **common)
    stark.scenes.resume(tmp_path / "twice", until=0.08, **common)
    first, second = (read_arrays(tmp_path / name / "fields/chunk_000000.npz") for name in ("once", "twice"))
    assert run.status == "complete" and first.keys() == second.keys()
    assert len(first["values_00_0001"]) == 9
    for name, values in first.items():
        assert values.tobytes() == second[name].tobytes(), name


def test_a_certified_run_may_have_fields(tmp_path: Path) -> None:
    sim = jelly()
    with Recorder(tmp_path / "run", sim, certify=True, fields=("stress",)) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        recorder.report(sim.step())
        recorder.record(sim)
        recorder.record_state(sim)
    certificate = stark.verify.verify(tmp_path / "run")
    claims = {claim.name: claim.status for claim in certificate.claims}
    assert claims["chain"] == "verified"


def test_recordings_without_fields_have_none(tmp_path: Path) -> None:
    sim = FakeSimulation()
    with Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
    run = Recording(tmp_path / "run")
    assert run.fields == [] and not run.has_contacts and not (tmp_path / "run/fields").exists()
    with pytest.raises(RecordingError, match="it has: none"):
        run.field("stress", 0)
    with pytest.raises(RecordingError, match="has no contacts"):
        run.contacts(0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fields": ("strees",)}, "field 'strees' is unknown; choose of stress"),
        ({"fields": "stress"}, "must be several names"),
        ({"arrays": {"stress": height}}, "field 'stress' is given twice"),
        ({"arrays": {"T [K]": lambda sim: {"jelly": [1.0]}}}, r"has the shape \(1,\)"),
        ({"arrays": {"T [K]": lambda sim: {"jelly": height(sim)[sim["jelly"]] * np.nan}}}, "must be finite"),
    ],
)
def test_bad_fields_are_refused(tmp_path: Path, options: dict[str, Any], message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        record(tmp_path / "run", 0, **options)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("values_00_0001", lambda a: a[:, 1:]),
        ("values_00_0001", lambda a: a * np.float32(np.nan)),
        ("contact_counts", lambda a: a + 1),
        ("contact_counts", lambda a: a - 1000),
        ("contact_bodies", lambda a: a + 7),
        ("contact_forces", lambda a: a.astype(np.int32)),
        ("body_forces", lambda a: a[0]),
    ],
)
def test_damage_is_named(tmp_path: Path, name: str, change: Any) -> None:
    run, _ = record(tmp_path / "run", 3)
    path = tmp_path / "run/fields/chunk_000000.npz"
    arrays = read_arrays(path)
    write_arrays(path, {**arrays, name: change(arrays[name])})
    with pytest.raises(RecordingError, match=f"chunk_000000.npz' is missing or damaged.*{name[:8]}"):
        run.field_row(0)
    path.unlink()
    with pytest.raises(RecordingError, match="is missing or damaged"):
        run.field_row(0)


def test_a_recorder_of_many_bodies_asks_for_all_contacts_a_few_times(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = stark.Scene()
    scene.add_floor(10.0)
    for k in range(12):
        scene.add_box(0.1, mass=0.1, position=(0.2 * k, 0, 0.0502))
    sim = stark.Simulation(scene)
    sim.step()
    calls: list[Any] = []
    contacts = stark._core.contacts
    monkeypatch.setattr(stark._core, "contacts", lambda core: calls.append(core) or contacts(core))
    names = (name for name in ("stress", "pressure"))  # which can be gone through once
    with Recorder(tmp_path, sim, fields=names, contacts=True) as recorder:  # type: ignore[arg-type]
        recorder.record(sim)
    assert 1 <= len(calls) <= 3
    pressed = [values.max() for values in Recording(tmp_path).field("pressure", 0).values()]
    assert len(pressed) == 12 and min(pressed) > 0.0
