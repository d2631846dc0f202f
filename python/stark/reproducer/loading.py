"""Reads a reproducer and makes the simulation again, right before the step."""

from __future__ import annotations

import json
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from stark._core import InvalidArgument
from stark.arguments import given_path
from stark.array_file import DamageError, check_format, read_arrays
from stark.caller import warn
from stark.scene import Scene
from stark.simulation import Simulation

from .errors import ReproducerError
from .rebuilding import simulation_of
from .writing import DATA, FORMAT_NAME, FORMAT_VERSION


def load(path: str | PathLike[str]) -> Simulation:
    """The simulation of a reproducer, a folder or its ``step.npz``, right before the step that it holds. Its
    scene has handles of the bodies; other parts act, but have none.

    Energies that could not be written are left out, with a StarkWarning. Raises ReproducerError for files
    that are missing, damaged or of another version, and where other parts could not be written."""
    path = given_path(path, "reproducer: path")
    path = path / DATA if path.is_dir() else path
    owner = f"reproducer '{path}'"
    header, arrays = _read(path, owner)
    try:
        sim: Simulation = simulation_of(header, arrays, owner, (Scene, Simulation))
    except ReproducerError:
        raise
    except (InvalidArgument, KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise ReproducerError(f"{owner} is damaged ({error}); write it again") from error
    if header["missing"]:
        lost = ", ".join(row["what"] for row in header["missing"])
        warn(f"{owner}: without {lost}: formulas that could not be written")
    return sim


def _read(path: Path, owner: str) -> tuple[dict[str, Any], dict[str, Any]]:
    try:
        arrays: dict[str, Any] = dict(read_arrays(path))
        header = json.loads(arrays.pop("header").astype(np.uint8).tobytes())
    except FileNotFoundError:
        raise ReproducerError(f"{owner}: there is no such file; check the path") from None
    except (DamageError, KeyError, ValueError, RecursionError) as error:
        raise ReproducerError(f"{owner} is damaged or no reproducer ({error}); write it again") from error
    try:
        return check_format(header, "reproducer", FORMAT_NAME, FORMAT_VERSION), arrays
    except DamageError as error:
        raise ReproducerError(f"{owner}: {error}") from None
