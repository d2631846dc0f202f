"""Loading of scene files and checking of what they define."""

from __future__ import annotations

import copy
import hashlib
import importlib
import importlib.util
import inspect
import math
import pkgutil
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from numbers import Real
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ..arguments import nearest
from ..caller import warn
from ..telemetry.given import RULE, given_number
from .options import SceneFileError, converted_options, option_text

_INTERNAL = {"options", "resuming", "runner", "scene_file"}

#: Functions that a scene file may define, and how many arguments they take.
_FUNCTIONS = {"build": 0, "settings": 0, "drive": 1, "measure": 1, "observables": 1, "check": 1}


@dataclass(frozen=True)
class SceneFile:
    """What a scene file defines. ``until`` is the simulated time [s], None when the file leaves it to the
    caller."""

    name: str
    description: str
    module: ModuleType
    until: float | None
    source: str = ""  #: the packaged scene's name, or the absolute path of the file
    options: dict[str, str] = field(default_factory=dict)  #: what the caller chose
    content: str = ""  #: SHA-256 of a Python file, as it was loaded

    def build(self) -> tuple[Any, dict[str, Any]]:
        """A fresh scene and the settings of the file by dotted name."""
        settings = self._mapping("settings()", self._call("settings", {}))
        built = self.module.build()
        if isinstance(built, tuple):
            if len(built) != 2:
                raise SceneFileError(
                    f"scene '{self.name}': build() returned {len(built)} values; "
                    "must return a stark.Scene or (scene, settings)"
                )
            built, more = built
            settings.update(self._mapping("build()", more))
        if built is None:
            raise SceneFileError(f"scene '{self.name}': build() returned nothing; end it with 'return scene'")
        return built, settings

    def drive(self, sim: Any) -> None:
        """The file's hook before every step, if it has one."""
        if hasattr(self.module, "drive"):
            self.module.drive(sim)

    @property
    def default_options(self) -> dict[str, Any]:
        """The options of the file as nobody has chosen any."""
        return dict(self.module.__dict__.get("_default_options", {}))

    @property
    def memory(self) -> dict[str, Any]:
        """What the file's functions remember from step to step, if it has that; see stark.checkpoint."""
        return getattr(self.module, "memory", {})

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Puts back what they remembered at a checkpoint."""
        if memory or self.memory:
            self.memory.clear()
            self.memory.update(memory)

    def measure(self, sim: Any) -> dict[str, float]:
        """What the file measures after every step, for the telemetry."""
        return self._numbers("measure", sim)

    def observables(self, sim: Any) -> dict[str, float]:
        """Numbers that characterise the state, if the file defines any."""
        return self._numbers("observables", sim)

    @property
    def has_check(self) -> bool:
        """Whether the scene file defines ``check(run)``."""
        return hasattr(self.module, "check")

    def check(self, recording: Any) -> None:
        """The file's check of a finished run, if it has one; raises AssertionError when the run is wrong,
        also where it returns False instead."""
        if self.has_check:
            returned = self.module.check(recording)
            if isinstance(returned, (bool, np.bool_)) and not returned:
                raise AssertionError(
                    "it returned False; write assert with a message, which says what is wrong"
                )

    def _call(self, function: str, default: Any, *arguments: Any) -> Any:
        return getattr(self.module, function)(*arguments) if hasattr(self.module, function) else default

    def _numbers(self, function: str, sim: Any) -> dict[str, float]:
        values = self._mapping(f"{function}()", self._call(function, {}, sim), what="numbers")
        numbers = {}
        for name, value in values.items():
            try:
                numbers[str(name)] = given_number(value)
            except ValueError:
                raise SceneFileError(
                    f"scene '{self.name}': {function}() returned '{name}' = {value!r}; {RULE}"
                ) from None
        return numbers

    def _mapping(self, source: str, value: Any, what: str = "settings") -> dict[str, Any]:
        if not hasattr(value, "keys"):
            kind = type(value).__name__
            raise SceneFileError(
                f"scene '{self.name}': {what} of {source} are a {kind}; must be a dictionary"
            )
        return dict(value)


def names() -> list[str]:
    """Names of the packaged scenes."""
    found = (m.name for m in pkgutil.iter_modules([str(Path(__file__).parent)]))
    return sorted(name for name in found if not name.startswith("_") and name not in _INTERNAL)


def load(scene: str | PathLike[str], options: Mapping[str, Any] | None = None) -> SceneFile:
    """A scene by the name of a packaged one, or by the path of a Python file or a scene document
    (``.json``). ``options`` replace values of the file's own ``options``; those that differ are appended to
    the name."""
    if not isinstance(scene, (str, PathLike)):
        raise SceneFileError(f"scene = {scene!r}: must be the name of a packaged scene, or a path")
    if options is not None and not isinstance(options, Mapping):
        raise SceneFileError(
            f"scene '{scene}': options = {options!r}: must be a dictionary of values by name"
        )
    text = str(scene)
    chosen = {name: option_text(value) for name, value in (options or {}).items()}
    if text.endswith(".json"):
        converted_options(Path(text).stem, {}, options or {})  # it has none
        return _document(Path(text))
    if text.endswith(".py") or "/" in text:
        module = _import_file(Path(text))
        name = Path(text).stem + _choose(module, Path(text).stem, options or {})
        content = hashlib.sha256(Path(text).read_bytes()).hexdigest()
        source = str(Path(text).resolve())
        return replace(_checked(module, name), source=source, options=chosen, content=content)
    if text not in names():
        near = nearest(text, names())
        hint = f"did you mean '{near}'?" if near else f"packaged scenes: {', '.join(names())}"
        raise SceneFileError(f"no scene is called '{text}'; {hint} (a file must end in .py or .json)")
    module = importlib.import_module(f"{__package__}.{text}")
    checked = _checked(module, text + _choose(module, text, options or {}))
    return replace(checked, source=text, options=chosen)


def _document(path: Path) -> SceneFile:
    """A scene document as a scene file. It is read again for each scene that is built."""
    import stark.document

    content = stark.document.read(path)
    module = ModuleType(f"stark_scene_{path.stem}")
    module.__file__ = str(path.resolve())

    def build() -> tuple[Any, dict[str, Any]]:
        again = stark.document.read(str(module.__file__))
        return again.scene, again.settings

    module.build = build  # type: ignore[attr-defined]
    description = content.description.strip().split("\n")[0]
    return SceneFile(path.stem, description, module, content.until, source=str(path.resolve()))


def _import_file(path: Path) -> ModuleType:
    if not path.is_file():
        raise SceneFileError(f"scene file '{path}' does not exist")
    spec = importlib.util.spec_from_file_location(f"stark_scene_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise SceneFileError(f"scene file '{path}' cannot be imported; it must be a Python file")
    module = importlib.util.module_from_spec(spec)
    beside = str(path.parent.resolve())
    sys.path.insert(0, beside)  # so that a scene may import files beside it
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise SceneFileError(f"scene file '{path}' line {error.lineno}: {error.msg}") from error
    finally:
        sys.path.remove(beside)  # the first one; the scene may have put others before it
        if beside not in sys.path:
            sys.path.append(beside)  # for what its functions import, after everything else
    return module


def _choose(module: ModuleType, name: str, chosen: Mapping[str, Any]) -> str:
    """Sets the options of a module to its defaults and what was chosen; returns what to append to the
    name."""
    options = getattr(module, "options", {})
    if not isinstance(options, dict):
        raise SceneFileError(f"scene '{name}': options must be a dictionary of default values by name")
    # Modules of packaged scenes are imported once: what an earlier caller chose must not stay.
    defaults = module.__dict__.setdefault("_default_options", _copied(options))
    options.update(_copied(defaults))
    converted = converted_options(name, defaults, chosen)
    options.update(converted)
    changed = [
        option_text(converted[key])
        for key in defaults
        if key in converted and converted[key] != defaults[key]
    ]
    return "".join("_" + re.sub(r"[^\w.-]+", "-", value) for value in changed)


def _copied(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options whose lists and dictionaries a scene may change."""
    own = (list, dict, set)
    return {name: copy.deepcopy(v) if isinstance(v, own) else v for name, v in options.items()}


def _forget(module: ModuleType, name: str) -> None:
    """Makes the memory of a module that was imported before what it was at first."""
    memory = getattr(module, "memory", None)
    if memory is None:
        return
    if not isinstance(memory, dict):
        raise SceneFileError(f"scene '{name}': memory must be a dictionary of what its functions remember")
    first = module.__dict__.setdefault("_first_memory", copy.deepcopy(memory))
    memory.clear()
    memory.update(copy.deepcopy(first))


def _require_arguments(name: str, function: Callable[..., Any], attribute: str, count: int) -> None:
    if not callable(function):
        raise SceneFileError(f"scene '{name}': {attribute} must be a function")
    try:
        inspect.signature(function).bind(*[None] * count)
    except TypeError as error:
        arguments = {0: "no arguments", 1: "one argument"}[count]
        raise SceneFileError(f"scene '{name}': {attribute}() must accept {arguments}: {error}") from error


def _warn_of_misspelt(module: ModuleType, name: str) -> None:
    """Of functions that are nearly called what a scene file may define."""
    for attribute, value in vars(module).items():
        is_its_own = inspect.isfunction(value) and value.__module__ == module.__name__
        if not is_its_own or attribute in _FUNCTIONS or attribute.startswith("_"):
            continue
        near = nearest(attribute, _FUNCTIONS, cutoff=0.75)
        if near and not hasattr(module, near):
            warn(f"scene '{name}': stark does not call {attribute}(); if {near}() is meant, rename it")


def _checked(module: ModuleType, name: str) -> SceneFile:
    if not hasattr(module, "build"):
        raise SceneFileError(f"scene '{name}': defines no build(); add a function that returns a stark.Scene")
    for attribute, count in _FUNCTIONS.items():
        if hasattr(module, attribute):
            _require_arguments(name, getattr(module, attribute), attribute, count)
    _warn_of_misspelt(module, name)
    _forget(module, name)
    until = getattr(module, "until", None)
    if until is not None and not (isinstance(until, Real) and 0.0 < float(until) < math.inf):
        raise SceneFileError(f"scene '{name}': until = {until!r} s; must be a positive number")
    description = (inspect.getdoc(module) or "").strip().split("\n")[0]
    return SceneFile(name, description, module, None if until is None else float(until))
