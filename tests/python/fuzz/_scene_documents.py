"""Scene documents that others made: damaged, forged, with pipes and links in the place of files. Each gives a
scene or a DocumentError within a second; nothing is executed, and no file outside the folder is opened."""

from __future__ import annotations

import contextlib
import copy
import json
import os
import sys
import tempfile
import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from _draw import Draw

import stark
from stark import document

sys.path.append(str(Path(__file__).parent.parent / "document"))
from _everything import everything

_ODD: tuple[Any, ...] = (
    None, True, False, -1, 0, 1, 7, 2**31, 2**53, 10**18, 10**400, 0.5, 1e308, -1e308, 5e-324, float("nan"),
    float("inf"), "", "inf", "nan", "../../x", "x" * 300, "\x1b[31m\u202e\x9b", "a\0b", "\ud800", "mm", "kg",
    [], {}, [[]], [None], [1, [2]], {"a": []}, {"array": "no"}, {"array": 7}, {"formula": 0}, {"formula": 99},
    [1e308, 1, 2], [0, 0, 0], [[0] * 3] * 40, "world", "rigid", "cloth", "__class__", "eval", "inertia",
)  # fmt: skip
_TYPES = ("f8", "f4", "i4", "i8", "u1", "?", "c16", "U4", "f2", "M8[s]", "S2", ">f8", "O")
_PATHS = (
    "../outside.npz", "/etc/passwd", "./x.npz", "sub/../../outside.npz", "link.npz", "pipe.npz", "", ".",
    "C:\\x.npz", "a\0b", "x" * 5000, "folder", "hard.npz", "way/outside.npz", "scene.json",
)  # fmt: skip

#: Longest time of a document [s of this process].
LONGEST = 1.0

_seen: list[str] = []
_watching: list[str] = []  # the folder that files may be of


def _watch(event: str, arguments: tuple[Any, ...]) -> None:
    if not _watching:
        return
    if event in (
        "compile",
        "exec",
        "pickle.find_class",
        "os.system",
        "subprocess.Popen",
        "import",
        "ctypes.dlopen",
    ) or (
        event == "open"
        and not isinstance(arguments[0], int)
        and not os.path.realpath(str(arguments[0])).startswith(_watching[0])
    ):
        _seen.append(f"{event} {arguments[:1]}")


@cache
def _good() -> tuple[dict[str, Any], dict[str, Any]]:
    """The document of everything, as JSON, and its arrays."""
    sys.addaudithook(_watch)
    with tempfile.TemporaryDirectory() as name:
        path = everything().save(Path(name) / "scene.json", settings={"time_step": 0.01}, until=1.0)
        document.read(path)
        "\x1b".encode("unicode_escape")
        with contextlib.suppress(stark.Error):
            document.read(Path(name) / "none.json")  # imports what errors need
        with np.load(path.with_suffix(".npz")) as stored:
            arrays = {key: stored[key] for key in stored.files}
        return json.loads(path.read_text()), arrays


def scene_documents(draw: Draw) -> None:
    """Up to three damages, then the document is read."""
    given, arrays = _good()
    given, arrays = copy.deepcopy(given), dict(arrays)
    if draw.byte() % 4:
        given["arrays"]["sha256"] = None  # else most damages of arrays are found by it
    with tempfile.TemporaryDirectory(dir=draw.memory) as name:
        folder = Path(os.path.realpath(name)) / "here"
        folder.mkdir()
        damages = [_DAMAGES[draw.integer(len(_DAMAGES))] for _ in range(draw.pick((1, 1, 1, 2, 3)))]
        for damage in damages:
            draw.trace.append(damage.__name__)
            with contextlib.suppress(
                KeyError, IndexError, TypeError, ValueError, AttributeError
            ):  # nothing left
                damage(draw, given, arrays)
        _write(draw, folder, given, arrays)
        _read(draw, folder, whole=damages == [_nothing] * len(damages))


def _write(draw: Draw, folder: Path, given: dict[str, Any], arrays: dict[str, Any]) -> None:
    with open(folder / "scene.npz", "wb") as file:
        np.savez(file, **arrays)
    (folder.parent / "outside.npz").write_bytes((folder / "scene.npz").read_bytes())
    if isinstance(given.get("arrays"), dict) and given["arrays"].get("file") != "scene.npz":
        (folder / "link.npz").symlink_to(folder.parent / "outside.npz")
        (folder / "way").symlink_to(folder.parent)
        os.mkfifo(folder / "pipe.npz")
        (folder / "folder").mkdir()
    text = json.dumps(given).encode("utf-8", "surrogatepass")
    for path, data in ((folder / "scene.json", text), (folder / "scene.npz", None)):
        kind = draw.integer(24)
        if kind in (1, 2):
            path.write_bytes(_bytes(draw, path.read_bytes() if data is None else data))
        elif data is not None:
            path.write_bytes(data)
    if draw.integer(64) == 1:
        (folder / "scene.json").unlink()
        os.mkfifo(folder / "scene.json")
        draw.trace.append("pipe")


def _bytes(draw: Draw, given: bytes) -> bytes:
    """Flipped, cut off, removed or inserted bytes."""
    draw.trace.append("bytes")
    data = bytearray(given)
    for _ in range(1 + draw.integer(4)):
        at = (draw.byte() << 16 | draw.byte() << 8 | draw.byte()) % max(1, len(data))
        kind = draw.integer(4)
        if kind == 0 and data:
            data[at] ^= 1 << draw.integer(8)
        elif kind == 1:
            del data[at:]
        elif kind == 2:
            del data[at : at + draw.byte()]
        else:
            data[at:at] = draw.pick((b"[", b"{", b"NaN", b"1e999", b"-Infinity", b"9" * 5000)) * draw.byte()
    return bytes(data)


def _read(draw: Draw, folder: Path, whole: bool) -> None:
    _seen.clear()
    _watching[:] = [str(folder)]
    begin, error = time.process_time(), None
    try:
        found = document.read(folder / "scene.json")
        assert found.scene.bodies or not whole
    except document.DocumentError as refused:
        error = str(refused)
    finally:
        seconds = time.process_time() - begin
        _watching.clear()
    if error is not None:
        draw.trace[-1] += f" -> {error[:160]}"
        assert len(error) < 4000, error
        assert all(c.isprintable() or c == "\n" for c in error), ascii(error)
        assert "scene.json" in error
    assert seconds < LONGEST, f"{seconds:.2f} s"
    assert not _seen, _seen


# --- damages ---


def _nothing(draw: Draw, given: dict[str, Any], arrays: dict[str, Any]) -> None:
    pass


def _node(draw: Draw, given: dict[str, Any], arrays: dict[str, Any]) -> None:
    """A value somewhere is another one, gone, there twice or has another name."""
    place: Any = given
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        key = draw.pick(keys)
        if isinstance(place[key], (dict, list)) and place[key] and draw.byte() % 8 < 7:
            place = place[key]
            continue
        break
    action = draw.integer(8)
    draw.trace[-1] += f" {key}"
    if action == 0:
        del place[key]
    elif action == 1 and isinstance(place, list):
        place.append(copy.deepcopy(place[key]))
    elif action == 2 and isinstance(place, dict):
        place[draw.pick(("", "nmae", key + "s", "\x1b", "__init__", *place))] = place.pop(key)
    elif action == 3 and isinstance(place[key], (int, float)):
        # Integers that are damaged twice may have no float.
        larger = place[key] * (1e3 if abs(place[key]) < 1e300 else 1000)
        place[key] = draw.pick((-place[key], larger, place[key] + 1, str(place[key]), [place[key]]))
    else:
        place[key] = copy.deepcopy(draw.pick(_ODD))


def _number(draw: Draw, given: dict[str, Any], arrays: dict[str, Any]) -> None:
    """A number that names a part names another one."""
    kind = draw.pick(
        ("layers", "energies", "joints", "actuators", "attachments", "pairs", "motions", "courses", "robots")
    )
    text = json.dumps(given[kind])
    for word in ('"body": ', '"joint": ', '"formula": ', '"number": ', '"a": ', '"b": ', '"node": '):
        if word in text and draw.byte() % 2:
            head, _, tail = text.partition(word)
            if tail[0].isdigit():
                text = (
                    head
                    + word
                    + str(draw.pick((0, 1, 3, 5, 9, 12, 1000, -1, 2**31)))
                    + tail.lstrip("0123456789")
                )
    given[kind] = json.loads(text)


def _formula(draw: Draw, given: dict[str, Any], arrays: dict[str, Any]) -> None:
    """An operation, an operand or an output of a formula is another one."""
    row = draw.pick(given["formulas"])
    k = draw.integer(len(row["nodes"]))
    node = row["nodes"][k]
    action = draw.integer(6)
    if action == 0:
        node[0] = draw.pick(
            ("+", "sqrt", "log", "select", "<", "&&", "not", "pow", "exec", "", "input", "constant")
        )
    elif action == 1:
        node[draw.integer(len(node))] = draw.pick(
            (0, k, k - 1, -1, 10**9, 0.5, "x", "X", "time", None, "inf")
        )
    elif action == 2:
        row["outputs"] = draw.pick(([], [0], [k], [k, k], [10**6], [-1]))
    elif action == 3:
        del row["nodes"][k]
    elif action == 4:
        row["nodes"] = row["nodes"] * draw.pick((2, 10, 200))
    else:
        row[draw.pick(("points", "kind", "coordinates", "inputs", "memories"))] = copy.deepcopy(
            draw.pick(_ODD)
        )


def _array(draw: Draw, given: dict[str, Any], arrays: dict[str, Any]) -> None:
    """An array has another type, shape or value, or is gone."""
    name = draw.pick(sorted(arrays))
    array, action = np.array(arrays[name]), draw.integer(8)
    draw.trace[-1] += f" {name}"
    if action == 0:
        del arrays[name]
    elif action == 1:
        arrays[name] = array.astype(draw.pick(_TYPES))
    elif action == 2:
        arrays[name] = array[: draw.integer(len(array))]
    elif action == 3:
        arrays[name] = array.reshape(-1) if array.ndim > 1 else array.reshape(-1, 1)
    elif action == 4:
        arrays[name] = np.concatenate([array] * draw.pick((2, 3, 50)))
    else:
        odd = (
            (0, -1, 7, 2**31 - 1, -(2**31), 1)
            if array.dtype.kind == "i"
            else (np.nan, np.inf, 1e308, 1e160, 0, -1e-300)
        )
        array.reshape(-1)[draw.integer(array.size)] = draw.pick(odd)
        arrays[name] = array


def _path(draw: Draw, given: dict[str, Any], arrays: dict[str, Any]) -> None:
    given["arrays"]["file"] = draw.pick(_PATHS)


def _head(draw: Draw, given: dict[str, Any], arrays: dict[str, Any]) -> None:
    """Another format, version or system of units."""
    key = draw.pick(("format", "version", "units", "settings", "until", "name"))
    given[key] = draw.pick(
        (*_ODD, 2, 10**30, "CGS", "mm", {"time.step": -1.0}, {"nope": 1}, {"gravity": [1, 2]})
    )


_DAMAGES = (_nothing, _node, _node, _node, _number, _formula, _array, _array, _path, _head)
