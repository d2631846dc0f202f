"""Writes the document of a scene: JSON, and its arrays beside it."""

from __future__ import annotations

import hashlib
import io
import json
import math
import zipfile
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from stark.arguments import given_flag, given_path, real_number
from stark.array_file import naming, refuse_special, write_atomically

from .describing import described
from .errors import DocumentError
from .format import DOCUMENT
from .kinds import INLINE, Arrays

ENDING = ".json"


def write(
    scene: Any,
    path: str | PathLike[str],
    *,
    settings: Any = None,
    until: float | None = None,
    description: str = "",
    sample_functions: bool = False,
) -> Path:
    """``Scene.save``. Everything is described and checked before anything is written."""
    place = given_path(path, "scene.save: path")
    if place.suffix != ENDING:
        raise DocumentError(f"scene.save: path = '{place}': must end in {ENDING}")
    if until is not None:
        until = real_number(until, "scene.save: until")
        if not 0.0 < until < math.inf:
            raise DocumentError(f"scene.save: until = {until} s: must be > 0 and finite")
    if not isinstance(description, str):
        raise DocumentError(f"scene.save: description = {description!r}: must be a text")
    sampled = given_flag(sample_functions, "scene.save: sample_functions")
    if not scene.bodies:
        raise DocumentError(f"scene '{scene.name}' has no bodies: must have at least one; add one first")
    document = described(scene, settings, until, description, sampled)
    arrays: dict[str, Any] = {}
    document = _plain(document, "", arrays)
    DOCUMENT.read(document, "scene", arrays)  # what is written can be read
    beside = place.with_suffix(".npz")
    packed = _packed(arrays)
    document["arrays"] = None
    if arrays:
        document["arrays"] = {"file": beside.name, "sha256": hashlib.sha256(packed).hexdigest()}
    text = (_lines(document) + "\n").encode()
    for file in (place, beside):
        with naming(file):
            refuse_special(file)
    if arrays:
        _refuse_others(beside, place)
        write_atomically(beside, lambda file: file.write(packed))
    write_atomically(place, lambda file: file.write(text))
    return place


def _plain(value: Any, place: str, arrays: dict[str, Any]) -> Any:
    """As JSON; larger arrays move into ``arrays``, named by their place."""
    if isinstance(value, dict):
        return {key: _plain(item, f"{place}/{key}" if place else key, arrays) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        if value.size <= INLINE:
            return _plain(value.tolist(), place, arrays)
        kept = np.int32 if value.dtype.kind in "iub" else np.float64
        arrays[place] = np.ascontiguousarray(value, dtype=kept)
        return {"array": place}
    if isinstance(value, (list, tuple)):
        return [_plain(item, f"{place}/{k}", arrays) for k, item in enumerate(value)]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and math.isinf(value):
        return "inf" if value > 0.0 else "-inf"
    return value


def _refuse_others(beside: Path, place: Path) -> None:
    """Raises DocumentError where the file for the arrays is something else, as a checkpoint or a mesh. Arrays
    of a document, whose names are places in it, are replaced."""
    if not beside.exists():
        return
    names: list[str] = []
    with suppress(OSError, zipfile.BadZipFile), zipfile.ZipFile(beside) as file:
        names = file.namelist()
    if not names or not all("/" in name for name in names):
        raise DocumentError(
            f"scene.save: path = '{place}': its arrays go into '{beside.name}', which is there already and "
            f"has none of a document: it would be lost; choose another name for one of them"
        )


def _packed(arrays: Arrays) -> bytes:
    """An NPZ file; equal arrays make equal files."""
    file = io.BytesIO()
    np.savez(file, **arrays)  # type: ignore[arg-type]
    return file.getvalue()


def _lines(value: Any, indent: str = "") -> str:
    """JSON with a line for each field and each row of numbers."""
    if isinstance(value, (dict, list)) and any(isinstance(item, (dict, list)) for item in _items(value)):
        deeper = indent + " "
        names = [f"{json.dumps(name)}: " for name in value] if isinstance(value, dict) else [""] * len(value)
        rows = [deeper + n + _lines(item, deeper) for n, item in zip(names, _items(value), strict=True)]
        opening, closing = "{}" if isinstance(value, dict) else "[]"
        return f"{opening}\n" + ",\n".join(rows) + f"\n{indent}{closing}"
    return json.dumps(value, allow_nan=False, ensure_ascii=False)


def _items(value: Any) -> list[Any]:
    return list(value.values()) if isinstance(value, dict) else value
