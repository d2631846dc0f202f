"""Reads scene documents."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from stark._core import Error
from stark.arguments import given_name, given_path
from stark.files import printable
from stark.scene import Scene

from .errors import DocumentError, told
from .files import read as read_files
from .rebuilding import Rebuilding, settings_of


@dataclass(frozen=True)
class SceneDocument:
    """What a document holds."""

    scene: Scene
    settings: dict[str, Any]
    """Settings by dotted name: ``stark.Simulation(document.scene, **document.settings)``."""
    until: float | None
    """End of a run [s]."""
    description: str


def read(path: str | PathLike[str]) -> SceneDocument:
    """The scene of a document, with what else is in it. Raises ``stark.DocumentError`` for files that are
    missing, damaged, of a newer version, or that describe what there cannot be. Nothing in the files is
    executed, and no file outside the folder of the document is read."""
    place = given_path(path, "load_scene: path")
    document = read_files(place)
    owner = f"scene document '{printable(str(place))}'"
    try:
        scene = Scene(given_name(document["name"]))
        with np.errstate(all="ignore"):  # numbers out of all range are refused in words
            Rebuilding(document, scene).run()
        settings = settings_of(document)
    except DocumentError as error:
        raise DocumentError(f"{owner}: {told(error)}") from None
    except Error as error:
        raise DocumentError(f"{owner}: {told(error)}") from error
    until = document["until"]
    if until is not None and not until > 0.0:
        raise DocumentError(f"{owner}: until = {until} s: must be > 0")
    return SceneDocument(scene, settings, until, document["description"])


def load_scene(path: str | PathLike[str]) -> Scene:
    """The scene of a document that ``scene.save`` wrote; ``stark.document.read`` gives its settings, too.
    Bodies, joints, actuators, attachments and energies have their handles again. Raises
    ``stark.DocumentError``."""
    return read(path).scene
