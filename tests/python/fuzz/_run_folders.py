"""Run folders that others made: damaged, forged, with pipes and links in the place of files. Every verb that
reads one gives what it should or one line that says what is wrong; nothing outside of the folder is touched,
and nothing that a terminal obeys is printed."""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import sys
import tempfile
import warnings
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from _draw import Draw

from stark import cli
from stark.cli import main

sys.path.append(str(Path(__file__).parent.parent / "verify"))
from _recorded_runs import reseal

_SCENE = '''
"""A box on a hinge, a sheet and a rod."""

import stark


until = 0.03  # [s]
steps = []


def settings():
    return {"time_step": 0.01, "threads": 1}


def build():
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, name="box")
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), position=(0.0, 1.0, 0.0), name="sheet", pins=[0])
    line = stark.mesh.polyline((0, 0, 0), (0.1, 0.02, 0.0), 3)
    scene.add_rod(line, stark.materials.rubber_cord, name="rod", position=(0.0, 2.0, 0.0))
    scene.add_hinge(None, box, anchor=(0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    return scene


def drive(sim):
    steps.append(sim.time)
    if len(steps) > 20:
        raise RuntimeError("a forged run is long enough")
'''

_VERBS = (
    ("info",),
    ("verify",),
    ("export", "--format", "obj", "--csv"),
    ("still", "--size", "16x16", "--quality", "draft"),
    ("still", "--size", "16x16", "--quality", "draft", "--field", "stress", "--contacts"),
    ("replay", "--stride", "1"),
    ("run", "--no-replay", "--no-picture", "--until", "0.04", "--resume"),
)
_ODD_VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 1, 7, 2**31, 10**18, 10**400, 0.5, 1e308, -1e308, float("nan"), "", "../../x",
    "x" * 300, "\x1b[31m\u202e\x9b", "a\0b", "\ud800", [], {}, [[]], [None], {"a": []}, [1e308, 1, 2],
    "running", "rigid",
)  # fmt: skip
_TYPES = ("f8", "f4", "i4", "i8", "u1", "?", "c16", "U4", "f2", "M8[s]", "S2", ">f8", "O")


#: Of each verb once: making them takes a fifth of the time of a folder.
_parser = cache(cli._parser)


@cache
def _good() -> Path:
    """A complete run for certification, and the folder that it is in, which is never written again."""
    keep = tempfile.TemporaryDirectory()
    _good.keep = keep  # type: ignore[attr-defined]
    folder = Path(keep.name)
    (folder / "fall.py").write_text(_SCENE)
    words = ["run", str(folder / "fall.py"), "--certify", "--checkpoint-every", "0", "--fields", "stress"]
    assert main([*words, "--quiet", "--no-replay", "--no-picture", "--out", str(folder / "run")]) == 0
    return folder / "run"


def run_folders(draw: Draw) -> None:
    """One to three damages, then every verb."""
    good = _good()
    with (
        tempfile.TemporaryDirectory(dir=draw.memory) as name,
        mock.patch("os.fsync", lambda file: None),
        mock.patch("stark.cli._parser", _parser),
    ):
        folder = Path(shutil.copytree(good, Path(name) / "run"))
        outside = Path(name) / "outside"
        outside.mkdir()
        (outside / "mine").write_text("mine")
        damages = [_DAMAGES[draw.integer(len(_DAMAGES))] for _ in range(1 + draw.integer(3))]
        for damage in damages:
            draw.trace.append(damage.__name__)
            with contextlib.suppress(Exception):  # nothing that can be damaged so is left
                damage(draw, folder)
        plain = all(p.is_dir() or _is_plain(p) for p in folder.rglob("*") if not p.is_symlink())
        linked = any(p.is_symlink() for p in folder.rglob("*"))
        if damages != [_nothing] * len(damages) and plain and not linked and draw.byte() % 2:
            draw.trace.append("reseal")
            with contextlib.suppress(Exception):  # of what is no recording any more
                reseal(folder)
        for words in _VERBS:
            _say(draw, folder, words, whole=damages == [_nothing] * len(damages))
        assert sorted(p.name for p in Path(name).iterdir()) == ["outside", "run"]
        assert [(p.name, p.read_text()) for p in outside.iterdir()] == [("mine", "mine")]


def _say(draw: Draw, folder: Path, words: tuple[str, ...], whole: bool) -> None:
    """Runs a verb and looks at what it says."""
    draw.trace.append(words[0])
    out, err = io.StringIO(), io.StringIO()
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = main([words[0], *words[1:], str(folder)])
            except RuntimeError as error:
                assert "long enough" in str(error)
                return
    if code:
        draw.trace[-1] += f" -> {code} {err.getvalue()[:160].rstrip()}"
    assert code in ((0, 1, 3) if words[0] == "verify" else (0, 1)) or (code == 2 and err.getvalue())
    assert code == 0 or not whole
    assert err.getvalue().count("\n") <= 1 and len(err.getvalue()) < 4000
    for text in (out.getvalue(), err.getvalue()):
        assert all(c.isprintable() or c == "\n" for c in text), ascii(text)


# --- damages ---


def _nothing(draw: Draw, folder: Path) -> None:
    pass


def _file(draw: Draw, folder: Path) -> Path:
    return draw.pick(sorted(p for p in folder.rglob("*") if _is_plain(p)))


def _is_plain(path: Path) -> bool:
    """What this program itself can read, too: no pipe, link or hole."""
    return path.is_file() and not path.is_symlink() and path.stat().st_size < 1 << 20


def _bytes(draw: Draw, folder: Path) -> None:
    """Flipped, cut off, removed or inserted bytes."""
    path = _file(draw, folder)
    data = bytearray(path.read_bytes())
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
            data[at:at] = bytes([draw.byte()]) * draw.byte()
    path.write_bytes(data)


def _json(draw: Draw, folder: Path) -> None:
    """A node of a JSON file, of a line of telemetry or of the header of the checkpoint is another one."""
    name = draw.pick(("manifest.json", "states/scene.json", "telemetry.jsonl", "checkpoint.stark"))
    path = folder / name
    if not _is_plain(path):
        return
    if name == "telemetry.jsonl":
        lines = path.read_text().splitlines()
        number = draw.integer(len(lines))
        lines[number] = json.dumps(_strange(draw, json.loads(lines[number])))
        path.write_text("\n".join(lines) + "\n")
    elif name == "checkpoint.stark":
        with np.load(path) as stored:
            arrays = {key: stored[key] for key in stored.files}
        header = _strange(draw, json.loads(arrays.pop("header").tobytes()))
        text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
        np.savez(path.open("wb"), header=text, **arrays)
    else:
        path.write_text(json.dumps(_strange(draw, json.loads(path.read_text()))))


def _strange(draw: Draw, value: Any) -> Any:
    place = value
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if not keys:
            return value
        key = draw.pick(keys)
        if isinstance(place[key], (dict, list)) and place[key] and draw.byte() % 8 < 6:
            place = place[key]
            continue
        action = draw.integer(8)
        if action == 0:
            del place[key]
        elif action == 1 and isinstance(place, list):
            place.append(place[key])
        else:
            place[key] = draw.pick(_ODD_VALUES)
        return value


def _array(draw: Draw, folder: Path) -> None:
    """An array of another type, shape or value, in an archive that is sound."""
    path = draw.pick(sorted(p for p in folder.rglob("*.npz") if _is_plain(p)))
    with np.load(path) as stored:
        arrays = {key: stored[key].copy() for key in stored.files}
    name = draw.pick(list(arrays))
    array, kind = arrays[name], draw.integer(8)
    if kind == 0:
        del arrays[name]
    elif kind == 1:
        arrays[name] = array.astype(draw.pick(_TYPES))
    elif kind == 2:
        arrays[name] = array.reshape(-1)[:-1]
    elif kind == 3:
        arrays[name] = array[None]
    elif kind == 4:
        arrays[name] = np.concatenate([array, array])
    elif kind == 5:
        arrays[name] = array[:0]
    elif array.size:
        value = draw.pick((np.nan, np.inf, -1.0, 0.0, 1e300, 1e-300, 17.0, 2.0**31))
        with np.errstate(all="ignore"):
            array.reshape(-1)[draw.integer(array.size)] = np.array(value).astype(array.dtype)
    np.savez(path.open("wb"), **arrays)


def _another_thing(draw: Draw, folder: Path) -> None:
    """A pipe, a folder, a link, another file or nothing in the place of a file, or of a folder."""
    path, other = _file(draw, folder), _file(draw, folder)
    kind = draw.integer(8)
    if kind == 7:
        path = draw.pick((folder / "frames", folder / "states", folder / "obj", folder / "failure"))
        shutil.rmtree(path, ignore_errors=True)
        path.symlink_to(folder.parent / "outside")
        return
    if kind == 6:
        path = folder / draw.pick(
            ("certificate.json", "replay.html", "still.png", "run.lock", "obj", "failure")
        )
    data = other.read_bytes()
    path.unlink(missing_ok=True)
    if kind == 0:
        os.mkfifo(path)
    elif kind == 1:
        path.mkdir()
    elif kind == 2:
        path.symlink_to("/dev/zero")
    elif kind == 3:
        path.write_bytes(data)
    elif kind == 4:
        with path.open("wb") as file:  # a hole of 1 GB
            file.truncate(1 << 30)
    elif kind == 6:
        path.symlink_to(folder.parent / "outside/mine")


_DAMAGES = (_nothing, _json, _bytes, _json, _array, _another_thing, _json, _array)
