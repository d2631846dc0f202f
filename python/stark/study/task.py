"""One run of a study: its options, and the hash that names it."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from .. import __version__
from ..scenes import SceneFileError, load
from ..scenes.options import converted_options, option_text, rule_of
from ..scenes.runner import end_time
from ..scenes.scene_file import SceneFile
from .plan import Plan, PlanError
from .sampling import Drawn, Value
from .sources import scene_hash

#: Digits of the hash that names folders and files.
KEY_DIGITS = 20


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


def settled(plan: Plan, scene_file: SceneFile) -> Plan:
    """A plan whose values have the types of the defaults of the scene: what a study is of."""
    return replace(plan, samples=[_options(scene_file, sample) for sample in plan.samples])


def tasks(plan: Plan, folder: Path, scene_file: SceneFile | None = None) -> list[Task]:
    """The runs of a plan in order. Raises SceneFileError or PlanError for options that the scene does not
    have."""
    scene_file = load(plan.scene) if scene_file is None else scene_file
    until = end_time(scene_file, plan.until)
    _refuse_taken(plan)
    source = scene_hash(scene_file)
    made: list[Task] = []
    for sample in plan.samples:
        for repetition in range(plan.repetitions):
            chosen = dict(sample)
            if plan.repetition_option:
                name = plan.repetition_option
                is_text = isinstance(scene_file.default_options.get(name), str)
                chosen[name] = str(repetition) if is_text else repetition
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


def entry_options(plan: Plan, task: Task, scene_file: SceneFile) -> dict[str, Value]:
    """The options of a run in the order of the plan: all that any run of it is given. Those that this run is
    not given have the values that it takes, the defaults of the scene."""
    defaults = _defaults(scene_file)
    named = dict.fromkeys(name for sample in [*plan.samples, task.options] for name in sample)
    left = {
        name: option_text(value) if isinstance(value, (list, tuple)) else value
        for name, value in defaults.items()
        if name in named and name not in task.options
    }
    known = {**_options(scene_file, left), **task.options}
    return {name: known[name] for name in named}


def _refuse_taken(plan: Plan) -> None:
    """The option that takes the number of the repetition must not have values of its own."""
    name = plan.repetition_option
    for index, sample in enumerate(plan.samples if name else []):
        if name in sample:
            raise PlanError(
                f"plan: sample {index} has {name} = {sample[name]!r}, and repetition_option = '{name}' would "
                f"replace it; leave the option out of [sampling], or name another repetition_option"
            )


def _described(value: Any) -> Any:
    """What JSON cannot hold, the same in every process."""
    if isinstance(value, (set, frozenset)):
        return sorted(map(repr, value))
    return re.sub(r" at 0x[0-9a-f]+", "", repr(value))


def _digest(what: Mapping[str, Any]) -> str:
    text = json.dumps(what, sort_keys=True, default=_described)
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
    return scene_file.default_options


def _options(scene_file: SceneFile, chosen: Mapping[str, Value]) -> dict[str, Value]:
    """As the scene's types; lists are texts, as on the command line."""
    defaults = _defaults(scene_file)
    given = {
        name: value.exact if isinstance(value, Drawn) and isinstance(defaults.get(name), float) else value
        for name, value in chosen.items()
    }
    converted = converted_options(scene_file.name, defaults, given)
    for name, value in given.items():
        if isinstance(value, str) and isinstance(converted[name], (bool, int, float)):
            rule = rule_of(defaults[name])
            raise SceneFileError(
                f"scene '{scene_file.name}': option {name} = {value!r}; must be {rule}, as its default; "
                f"write it without quotes"
            )
    return {
        name: option_text(value) if isinstance(value, (list, tuple)) else value
        for name, value in converted.items()
    }
