"""One run of a study: its options, and the hash that names it."""

from __future__ import annotations

import ast
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import __version__
from ..scenes import SceneFileError, load
from ..scenes.runner import end_time
from ..scenes.scene_file import SceneFile, converted_options
from .plan import Plan
from .sampling import Value

#: Digits of the hash that names folders and files.
KEY_DIGITS = 20

#: Most files beside a scene file that are followed by its imports.
_MOST_MODULES = 1000


@dataclass(frozen=True)
class Task:
    """What a worker needs to make a run; all of it can be written as JSON. ``options`` are those of the plan,
    ``folder`` is that of the study."""

    key: str
    index: int
    options: dict[str, Value]
    repetition: int
    scene: str
    until: float
    settings: dict[str, Any]
    fps: float
    checkpoint_every: float
    certify: bool
    time_out: float | None
    folder: str

    def label(self) -> str:
        """What it is called in messages."""
        return ", ".join(f"{name}={value}" for name, value in self.options.items()) or f"run {self.index}"


def tasks(plan: Plan, folder: Path) -> list[Task]:
    """The runs of a plan in order. Raises SceneFileError or PlanError for options that the scene does not
    have."""
    scene_file = load(plan.scene)
    until = end_time(scene_file, plan.until)
    source = scene_hash(scene_file)
    made: list[Task] = []
    for sample in plan.samples:
        for repetition in range(plan.repetitions):
            chosen = dict(sample)
            if plan.repetition_option:
                chosen[plan.repetition_option] = repetition
            options = _options(scene_file, chosen)
            what = {
                "scene": source,
                "options": {**_defaults(scene_file), **options},
                "settings": plan.settings,
                "until": until,
                "fps": plan.fps,
                "repetition": repetition,
                "stark": __version__,
            }
            if plan.certify:
                what["certify"] = True
            made.append(
                Task(
                    key=_digest(what),
                    index=len(made),
                    options=options,
                    repetition=repetition,
                    scene=scene_file.source,
                    until=until,
                    settings=plan.settings,
                    fps=plan.fps,
                    checkpoint_every=plan.checkpoint_every,
                    certify=plan.certify,
                    time_out=plan.limits.time_out,
                    folder=str(folder),
                )
            )
    _refuse_twins(made)
    return made


def _digest(what: Mapping[str, Any]) -> str:
    text = json.dumps(what, sort_keys=True, default=repr)
    return hashlib.sha256(text.encode()).hexdigest()[:KEY_DIGITS]


def _refuse_twins(made: list[Task]) -> None:
    seen: dict[str, Task] = {}
    for task in made:
        if task.key in seen:
            raise SceneFileError(
                f"plan: runs {seen[task.key].index} and {task.index} are the same ({task.label()}); remove "
                f"one, or give repetitions"
            )
        seen[task.key] = task


def _defaults(scene_file: SceneFile) -> dict[str, Any]:
    return dict(scene_file.module.__dict__.get("_default_options", {}))


def _options(scene_file: SceneFile, chosen: Mapping[str, Value]) -> dict[str, Value]:
    """As the scene's types; a number that an integer option would cut is an error."""
    converted = converted_options(scene_file.name, _defaults(scene_file), chosen)
    for name, value in chosen.items():
        is_number = isinstance(value, (int, float)) and isinstance(converted[name], (int, float))
        if is_number and converted[name] != value:
            kind = type(converted[name]).__name__
            raise SceneFileError(
                f"scene '{scene_file.name}': option {name} = {value!r}; must be a {kind}, as its default"
            )
    return converted


def scene_hash(scene_file: SceneFile) -> str:
    """SHA-256 of a scene file and of the modules beside it that it imports, directly or by way of others."""
    path = Path(str(scene_file.module.__file__))
    digest, done, waiting = hashlib.sha256(), set[Path](), [path]
    while waiting and len(done) < _MOST_MODULES:
        file = waiting.pop(0)
        if file in done:
            continue
        done.add(file)
        source = file.read_bytes()
        digest.update(f"{file.relative_to(path.parent)}:{len(source)}:".encode())
        digest.update(source)
        waiting += _beside(source, path.parent)
    return digest.hexdigest()


def _beside(source: bytes, folder: Path) -> list[Path]:
    """Files in the folder that a module imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            names.update([module, *(f"{module}.{alias.name}".lstrip(".") for alias in node.names)])
    found = []
    for name in sorted(names - {""}):
        place = folder.joinpath(*name.split("."))
        found += [file for file in (place.with_suffix(".py"), place / "__init__.py") if file.is_file()]
    return found
