"""What comes back from a document, and what is said of one that is none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _everything import everything

import stark
from stark import document, scenes
from stark.cli import main


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return everything().save(tmp_path / "scene.json", settings={"time_step": 0.01}, until=0.02)


def changed(path: Path, **fields: Any) -> Path:
    given = json.loads(path.read_text())
    path.write_text(json.dumps({**given, **fields}))
    return path


def test_all_handles_are_there(path: Path) -> None:
    before, after = everything(), stark.load_scene(path)
    for part in ("bodies", "layers", "joints", "actuators", "attachments", "energies"):
        mine, theirs = getattr(after, part), getattr(before, part)
        assert [handle.name for handle in mine] == [handle.name for handle in theirs]
        assert [type(handle) for handle in mine] == [type(handle) for handle in theirs]
    assert after.friction["arm", "floor"] == 0.3 and after.friction.kinetic("arm", "floor") == 0.2
    assert not after.contact_enabled("cloth", "arm") and after.contact_enabled("cloth", "tip")
    assert np.array_equal(after["cloth"].surface_direction, [1.0, 0.0, 0.0])
    assert after["cloth"].mesh.vertices.tobytes() == before["cloth"].mesh.vertices.tobytes()


def test_formulas_can_be_looked_into(path: Path) -> None:
    scene = stark.load_scene(path)
    tethers = scene.energies[0]
    assert "sqrt" not in str(tethers.formula.graph()) and tethers.check().ok
    with pytest.raises(document.DocumentError, match="no function to call; check\\(\\) of its handle"):
        tethers.formula(scene["cloth"].vertices)
    with pytest.raises(stark.InvalidArgument, match=r"not finite|must be finite"):
        tethers.stiffness = np.nan


def test_a_document_runs(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_sphere(0.1, subdivisions=1, mass=1.0)
    path = scene.save(tmp_path / "ball.json", settings={"time_step": 0.01}, until=0.02)
    assert (
        main(["run", str(path), "--out", str(tmp_path / "out"), "--quiet", "--no-replay", "--no-picture"])
        == 0
    )
    recording = stark.recording.Recording(tmp_path / "out")
    assert recording.times[-1] == pytest.approx(0.02)
    assert scenes.load(path).until == 0.02
    with pytest.raises(scenes.SceneFileError, match="has no option 'x'"):
        scenes.load(path, {"x": 1})


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"version": 2}, "version 2 .* reads up to 1: use a newer Stark"),
        ({"version": "1"}, "scene.version = '1': must be an integer"),
        ({"format": "other"}, "no scene document"),
        ({"units": "mm"}, "scene.units = 'mm': must be 'SI'"),
        ({"untl": 1.0}, "unknown field 'untl'; did you mean 'until'"),
        ({"until": -1.0}, "until = -1.0 s: must be > 0"),
        ({"settings": {"time.stp": 0.1}}, "time.stp"),
        ({"name": ""}, "name = ''"),
        ({"pairs": [{"rule": "disable_contact", "a": 0, "b": 99}]}, r"pairs\[0\]: body 99: must be below"),
        ({"courses": [{"of": "energy", "number": 0, "value": "x", "motion": {
            "kind": "linear", "times": [0.0, 1.0], "values": [[0.0], [1.0]]}}]}, "has no value 'x'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(path: Path, fields: dict[str, Any], text: str) -> None:
    with pytest.raises(document.DocumentError, match=text) as caught:
        stark.load_scene(changed(path, **fields))
    assert "scene.json" in str(caught.value)


def test_json_says_what_python_would_guess(path: Path) -> None:
    text = path.read_text()
    for twisted, found in (
        (text.replace('"until": 0.02', '"until": NaN'), "NaN is no number"),
        (text.replace('"until": 0.02', '"until": 1, "until": 2'), "occurs twice"),
        ("[" * 100_000, "no JSON"),
        ("[]", "must be an object"),
    ):
        path.write_text(twisted)
        with pytest.raises(document.DocumentError, match=found):
            stark.load_scene(path)
