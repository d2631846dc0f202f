"""Checkpoints that others made: damaged bytes, headers that say strange things, arrays of other types, shapes
and values under hashes that fit. Each is refused by `stark info` and by `Simulation.load`, which leaves the
state as it was, or is something to step from."""

from __future__ import annotations

import contextlib
import io
import json
import sys
import tempfile
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from _draw import Draw

import stark
from stark.array_file import read_arrays
from stark.checkpoint import CheckpointError
from stark.cli import main

sys.path.append(str(Path(__file__).parent.parent / "checkpoint"))
from _damage import damaged, strange_arrays, strange_json
from _zoo import CASES, advance

_NAMES = ("energies", "mechanism", "scripted", "peel", "rods")


@cache
def _good(name: str) -> tuple[stark.Simulation, bytes, dict[str, Any], dict[str, np.ndarray]]:
    """A simulation, the bytes of its checkpoint, the header and the arrays in it."""
    case = CASES[name]
    sim = case.simulate(threads=1)
    advance(case, sim, {}, 2)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "good.stark"
        sim.save(path, memory={"n": 3, "list": [1.5, (2, None)], "array": np.arange(3)})
        arrays = dict(read_arrays(path))
        data = path.read_bytes()
    return sim, data, json.loads(arrays.pop("header").tobytes()), arrays


def checkpoints(draw: Draw) -> None:
    """One damage, then the file is looked at, loaded and stepped from."""
    sim, data, header, arrays = _good(draw.pick(_NAMES))
    rng = np.random.default_rng([draw.byte() for _ in range(8)])
    kind = draw.integer(4)
    draw.trace.append(("nothing", "bytes", "header", "array")[kind])
    with tempfile.TemporaryDirectory(dir=draw.memory) as folder:
        path = Path(folder) / "bad.stark"
        if kind < 2:
            path.write_bytes(data if kind == 0 else damaged(data, rng))
        else:
            if kind == 2:
                header = strange_json(header, rng)
            else:
                header, arrays = strange_arrays(header, arrays, rng)
            text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
            with path.open("wb") as file:
                np.savez(file, header=text, **arrays)
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            _look(draw, path, whole=kind == 0)
            _load(draw, sim, path, whole=kind == 0)
        assert [p.name for p in Path(folder).iterdir()] == ["bad.stark"]


def _look(draw: Draw, path: Path, whole: bool) -> None:
    draw.trace.append("info")
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(["info", str(path)])
    if code:
        draw.trace[-1] += f" -> {code} {err.getvalue()[:160].rstrip()}"
    assert code == 0 or (code == 2 and err.getvalue() and not whole), f"{code} {err.getvalue()}"
    assert err.getvalue().count("\n") <= 1 and len(err.getvalue()) < 4000
    for text in (out.getvalue(), err.getvalue()):
        assert all(c.isprintable() or c == "\n" for c in text), ascii(text)


def _load(draw: Draw, sim: stark.Simulation, path: Path, whole: bool) -> None:
    draw.trace.append("load")
    before = sim.state
    try:
        sim.load(path)
    except CheckpointError as error:
        draw.trace[-1] += f" -> {str(error)[:160]}"
        assert not whole
        assert str(path) in str(error)
        assert sim.state == before
        return
    draw.trace.append("step")
    try:
        report = sim.step()
        if report.failed:
            draw.trace[-1] += f" -> {report.message[:160]}"
            assert report.message
        else:
            # Infinity switches caps of actuators off.
            arrays = {k: a for k, a in sim.state.arrays().items() if not k.startswith("actuator_")}
            floats = (a for a in arrays.values() if a.dtype.kind == "f")
            assert all(np.isfinite(a).all() for a in floats)
    except stark.InvalidArgument as error:  # a time at which steps or functions of time have no sense
        draw.trace[-1] += f" -> {str(error)[:160]}"
        assert not whole and sim.time > 1e6
    finally:
        sim.state = before
