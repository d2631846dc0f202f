"""Checkpoint files, format version 1: an NPZ file, readable by ``numpy.load``.

header                 JSON as bytes: format, version, scene, settings, hashes of parts, memory
state/<field>          every field of the state
before/<field>         the state that the last step started from, where there was one
values/<k>/<name>      values of energy k, and last_values/<k>/<name> those of the last step
memory/<k>             arrays of what a controller remembers"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark import _core
from stark._core import InvalidArgument, State
from stark.array_file import DamageError, check_format, read_arrays, write_arrays
from stark.steps import LastStep

from . import memory
from .differences import Part
from .errors import CheckpointError

FORMAT_NAME = "stark-checkpoint"
FORMAT_VERSION = 3

Arrays = dict[str, NDArray[Any]]

#: Values of the parameters of one energy by name.
Values = dict[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Content:
    """What a checkpoint holds."""

    scene: str  #: name of the scene
    stark_version: str  #: that wrote it
    state: State
    settings: dict[str, Any] = field(repr=False)
    parts: list[Part] = field(repr=False)
    energies: list[str] = field(repr=False)  #: names
    values: list[Values] = field(repr=False)  #: live values, by energy
    last: LastStep | None = field(repr=False)
    memory: dict[str, Any] = field(default_factory=dict)  #: what a controller remembers
    run: dict[str, Any] | None = None  #: of ``stark run``: how to go on

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.state.time


def write(checkpoint: Content, path: Path) -> None:
    arrays: Arrays = {}
    _put_state(arrays, "state", checkpoint.state)
    _put_values(arrays, "values", checkpoint.values)
    last = checkpoint.last
    if last is not None:
        _put_state(arrays, "before", last.before)
        _put_values(arrays, "last_values", last.values)
    header = {
        "format": FORMAT_NAME,
        "version": FORMAT_VERSION,
        "stark_version": checkpoint.stark_version,
        "scene": checkpoint.scene,
        "time": checkpoint.time,
        "state_hash": checkpoint.state.hash,
        "before_hash": last.before.hash if last else None,
        "limit": last.limit if last else None,
        "placed": last.placed if last else None,
        "settings": checkpoint.settings,
        "energies": checkpoint.energies,
        "parts": checkpoint.parts,
        "memory": memory.encode(checkpoint.memory, arrays),
        "run": checkpoint.run,
    }
    text = np.frombuffer(json.dumps(header, default=_plain).encode(), dtype=np.uint8)
    try:
        write_arrays(path, {"header": text, **arrays})
    except OSError as error:
        raise CheckpointError(f"checkpoint {error}") from error


def _plain(value: Any) -> Any:
    """NumPy's numbers in settings."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(f"{value!r} is not a number")


def read(path: Path) -> Content:
    owner = f"checkpoint '{path}'"
    try:
        arrays = read_arrays(path)
    except FileNotFoundError:
        raise CheckpointError(f"{owner}: there is no such file; check the path") from None
    except DamageError as error:
        raise CheckpointError(f"{owner} is damaged or no checkpoint ({error}); use another one") from error
    header = _header(arrays, owner)
    try:
        return _checkpoint(header, arrays)
    except (InvalidArgument, KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        what = f"'{error.args[0]}' is missing" if isinstance(error, KeyError) else str(error)
        written = header.get("stark_version")
        also = f"; it was written by Stark {written}" if written != _core.__version__ else ""
        raise CheckpointError(f"{owner} is damaged ({what}){also}; use another one") from error


def _header(arrays: Arrays, owner: str) -> dict[str, Any]:
    """The header, of this format and version."""
    text = arrays.pop("header", None)
    try:
        header = json.loads(text.astype(np.uint8).tobytes()) if text is not None else None
    except (ValueError, RecursionError) as error:
        raise CheckpointError(f"{owner} is damaged (header: {error}); use another one") from error
    try:
        return check_format(header, "checkpoint", FORMAT_NAME, FORMAT_VERSION)
    except DamageError as error:
        raise CheckpointError(f"{owner}: {error}") from None


def _checkpoint(header: dict[str, Any], arrays: Arrays) -> Content:
    energies = _texts(header["energies"], "energies")
    last = None
    if header["before_hash"] is not None:
        limit = header["limit"]
        if limit is not None and not (isinstance(limit, float) and limit > 0.0):
            raise ValueError(f"limit = {limit!r} s: must be > 0")
        placed = header["placed"]
        if not (isinstance(placed, float) and math.isfinite(placed)):
            raise ValueError(f"placed = {placed!r} J: must be finite")
        before = _state(arrays, "before", header["before_hash"])
        last = LastStep(before, limit, _values(arrays, "last_values", len(energies)), placed)
    for name in ("settings", "memory"):
        if not isinstance(header[name], dict):
            raise TypeError(f"{name} must be an object")
    if not isinstance(header["run"], (dict, type(None))):
        raise TypeError("run must be an object")
    return Content(
        scene=str(header["scene"]),
        stark_version=str(header["stark_version"]),
        state=_state(arrays, "state", header["state_hash"]),
        settings=header["settings"],
        parts=[(str(name), bool(structure), str(digest)) for name, structure, digest in header["parts"]],
        energies=energies,
        values=_values(arrays, "values", len(energies)),
        last=last,
        memory=memory.decode(header["memory"], arrays),
        run=header["run"],
    )


def _texts(value: Any, name: str) -> list[str]:
    if not isinstance(value, list) or not all(isinstance(text, str) for text in value):
        raise TypeError(f"{name} must be a list of texts")
    return value


def _put_state(arrays: Arrays, folder: str, state: State) -> None:
    arrays.update({f"{folder}/{name}": array for name, array in state.arrays().items()})


def _state(arrays: Arrays, folder: str, expected_hash: str) -> State:
    start = f"{folder}/"
    state = _core.State.of_arrays({n[len(start) :]: a for n, a in arrays.items() if n.startswith(start)})
    if state.hash != expected_hash:
        raise ValueError(
            f"the hash of '{folder}' is {state.hash}, not {expected_hash} as when it was written"
        )
    return state


def _put_values(arrays: Arrays, folder: str, values: list[Values]) -> None:
    arrays.update({f"{folder}/{k}/{name}": a for k, of in enumerate(values) for name, a in of.items()})


def _values(arrays: Arrays, folder: str, energy_count: int) -> list[Values]:
    values: list[Values] = [{} for _ in range(energy_count)]
    for name, array in arrays.items():
        where, _, rest = name.partition("/")
        if where != folder:
            continue
        number, _, parameter = rest.partition("/")
        if array.dtype != np.float64 or not number.isdecimal() or int(number) >= energy_count:
            raise ValueError(f"'{name}' is no value of an energy")
        values[int(number)][parameter] = array
    return values
