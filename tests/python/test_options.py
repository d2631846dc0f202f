"""Options of scene files: what becomes of texts and values, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stark.cli import main
from stark.scenes import SceneFileError, load
from stark.scenes.options import converted_options, option_text

DEFAULTS: dict[str, Any] = {
    "mass": 1.0,
    "n": 3,
    "flag": True,
    "label": "a",
    "offset": [0.1, 0.2],
    "place": (0.0, 0.0, 1.0),
    "counts": [1, 2],
    "mixed": [1, 2.5],
    "names": ["a", "b"],
    "nothing": None,
    "table": {"a": 1},
    "odd": {1},
    "bytes": b"x",
    "complex": 1j,
    "empty": [],
    "array": np.zeros(2),
    "nested": [[1.0]],
}


@pytest.mark.parametrize(
    ("name", "given", "expected"),
    [
        ("mass", "2.5", 2.5),
        ("mass", 2, 2.0),
        ("mass", np.float32(2.0), 2.0),
        ("n", "4", 4),
        ("n", 4.0, 4),
        ("n", np.int64(4), 4),
        ("flag", "False", False),
        ("flag", np.bool_(False), False),
        ("label", "b", "b"),
        ("label", Path("a/b"), "a/b"),
        ("offset", "0.3,0.4", [0.3, 0.4]),
        ("offset", "[0.3, 4, 5e-1]", [0.3, 4.0, 0.5]),
        ("offset", (1, 2), [1.0, 2.0]),
        ("offset", np.array([1.0, 2.0]), [1.0, 2.0]),
        ("offset", "", []),
        ("offset", "12", [12.0]),
        ("offset", "0.3,", [0.3]),
        ("place", "1,2,3", (1.0, 2.0, 3.0)),
        ("place", "(1, 2, 3,)", (1.0, 2.0, 3.0)),
        ("counts", "7", [7]),
        ("mixed", "1, 2", [1.0, 2.0]),
        ("names", "x, y", ["x", "y"]),
        ("names", "['x', \"y\"]", ["x", "y"]),
    ],
)
def test_values_become_what_the_default_is(name: str, given: Any, expected: Any) -> None:
    found = converted_options("s", DEFAULTS, {name: given})[name]
    assert found == expected and type(found) is type(expected)
    if isinstance(found, list):
        assert [type(item) for item in found] == [type(item) for item in expected]
    assert converted_options("s", DEFAULTS, {name: option_text(found)})[name] == found  # as a checkpoint does


@pytest.mark.parametrize(
    ("name", "given", "rule"),
    [
        ("mass", True, "must be a float"),
        ("mass", "heavy", "must be a float"),
        ("mass", [1.0], "must be a float"),
        ("mass", None, "must be a float"),
        ("n", True, "must be an int"),
        ("n", 1.5, "must be an int"),
        ("n", float("inf"), "must be an int"),
        ("n", "1.5", "must be an int"),
        ("flag", 1, "must be true or false"),
        ("flag", "yes", "must be true or false"),
        ("label", 3, "must be a str"),
        ("offset", "0.3;0.4", "must be floats, 0.1, 0.2 for example"),
        ("offset", 0.3, "must be floats"),
        ("offset", "0.3,,0.4", "must be floats"),
        ("counts", "1.5", "must be ints"),
        ("counts", [True], "must be ints"),
        ("place", "1,2", "must be 3 floats"),
        ("names", ["a,b"], "must be texts"),
        *((name, "1", "can be chosen") for name in ("nothing", "table", "odd", "bytes", "complex")),
        *((name, "1", "can be chosen") for name in ("empty", "array", "nested")),
    ],
)
def test_other_values_are_refused(name: str, given: Any, rule: str) -> None:
    with pytest.raises(SceneFileError, match=f"scene 's': option {name} = .*{rule}"):
        converted_options("s", DEFAULTS, {name: given})


FILE = """
import numpy as np
import stark

until = 0.02
options = {"offset": [0.1, 0.2], "array": np.zeros(2), "none": None}


def build():
    options["offset"].append(1.0)  # does not reach the defaults
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, position=options["offset"], name="box")
    return scene
"""


def test_lists_are_chosen_on_the_command_line_and_kept_by_checkpoints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.py").write_text(FILE)
    assert main(["run", "s.py", "--option", "offset=0.3,0.4", "--quiet"]) == 0
    assert (tmp_path / "out/s_0.3-0.4").is_dir()
    assert main(["run", "--resume", "out/s_0.3-0.4", "--until", "0.03", "--quiet"]) == 0
    assert main(["run", "s.py", "--option", "none=1"]) == 2
    assert "its default is a NoneType" in capsys.readouterr().err


def test_what_a_scene_does_to_its_lists_does_not_stay(tmp_path: Path) -> None:
    (tmp_path / "s.py").write_text(FILE)
    file = load(tmp_path / "s.py", {"offset": (0.3, 0.4)})
    assert file.name == "s_0.3-0.4" and file.options == {"offset": "0.3, 0.4"}
    file.build()
    assert file.default_options["offset"] == [0.1, 0.2]
