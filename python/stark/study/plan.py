"""``plan.toml``: which scene a study runs, with which options, how often, and within which limits."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

from .._core import InvalidArgument
from ..arguments import given_path, nearest, shown_value
from ..files import NotAFile, read_bytes
from . import sampling
from .sampling import Axis, Options, Range, Value

#: Most runs of a study.
LARGEST_STUDY = 100_000

#: Largest plan that is read [bytes].
LARGEST_PLAN = 1 << 22

_KINDS = ("grid", "one_at_a_time", "list", "random", "latin_hypercube")


class PlanError(InvalidArgument):
    """A plan that cannot be used: names the key, its value, the rule and a remedy."""


@dataclass(frozen=True)
class Limits:
    """What a run may take. ``time_out`` [s] of wall-clock time, None: no limit. ``retries``: how often
    a run is tried again whose process was killed; each time from its last checkpoint."""

    time_out: float | None = None
    retries: int = 3


@dataclass(frozen=True)
class Plan:
    """A study: ``samples`` are the options of its runs, each made ``repetitions`` times. The number of the
    repetition goes into the option ``repetition_option`` of the scene, if that is given. ``settings`` go over
    those of the scene; ``until`` [s] replaces its end. ``certify`` records every accepted step in double
    precision, for ``stark verify``."""

    scene: str
    samples: list[Options]
    until: float | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    repetitions: int = 1
    repetition_option: str = ""
    fps: float = 60.0
    checkpoint_every: float = 60.0
    certify: bool = False
    limits: Limits = field(default_factory=Limits)

    def __post_init__(self) -> None:
        if not isinstance(self.samples, list) or type(self.repetitions) is not int:
            raise PlanError(
                f"plan: samples = {shown_value(self.samples)}, repetitions = "
                f"{shown_value(self.repetitions)}: must be a list of options and a whole number"
            )
        count = len(self.samples) * self.repetitions
        if not 1 <= count <= LARGEST_STUDY:
            raise PlanError(
                f"plan: has {count} runs; must be from 1 to {LARGEST_STUDY}; take fewer values or repetitions"
            )

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Plan:
        """Reads a plan. Scene files are found from the folder of the plan."""
        place = given_path(path, "plan")
        try:
            text = read_bytes(place, LARGEST_PLAN).decode("utf-8-sig")
        except FileNotFoundError:
            raise PlanError(f"plan '{place}' does not exist; give the path of a TOML file") from None
        except (NotAFile, UnicodeDecodeError, OSError) as error:
            raise PlanError(f"plan '{place}' cannot be read: {error}") from error
        return cls.parse(text, place.parent, f"plan '{place}'")

    @classmethod
    def parse(cls, text: str, folder: str | PathLike[str] = ".", owner: str = "plan") -> Plan:
        """The plan that a TOML text describes; ``owner`` is what errors call it."""
        try:
            table = tomllib.loads(text.removeprefix("\ufeff"))  # the byte-order mark of some editors
        except tomllib.TOMLDecodeError as error:
            raise PlanError(f"{owner}: is no TOML: {error}") from None
        except RecursionError:
            raise PlanError(f"{owner}: is nested too deeply") from None
        return _plan(_Table(table, owner), Path(folder))


class _Table:
    """A table of the plan: keys are taken one by one, and those that are left are unknown."""

    def __init__(self, values: Mapping[str, Any], owner: str, prefix: str = "") -> None:
        self._values, self._left, self.owner, self.prefix = dict(values), set(values), owner, prefix
        self._known: list[str] = []

    def error(self, key: str, value: Any, rule: str) -> PlanError:
        return PlanError(f"{self.owner}: {self.prefix}{key} = {shown_value(value, 80)}; {rule}")

    def take(self, key: str, default: Any = None) -> Any:
        self._known.append(key)
        self._left.discard(key)
        return self._values.get(key, default)

    def has(self, key: str) -> bool:
        return key in self._values

    def items(self) -> list[tuple[str, Any]]:
        self._left.clear()
        return list(self._values.items())

    def table(self, key: str) -> _Table:
        value = self.take(key, {})
        if not isinstance(value, dict):
            raise self.error(key, value, "must be a table")
        return _Table(value, self.owner, f"{self.prefix}{key}.")

    def text(self, key: str, default: str | None = None) -> str:
        value = self.take(key, default)
        if not isinstance(value, str) or (default is None and not value):
            if key not in self._values:
                raise PlanError(f"{self.owner}: {self.prefix}{key} is missing; must be a text")
            raise self.error(key, value, "must be a text that is not empty")
        return value

    def whole(self, key: str, default: int | None, least: int, most: int = LARGEST_STUDY) -> int:
        value = self.take(key, default)
        if type(value) is not int or not least <= value <= most:
            if key not in self._values:
                raise PlanError(f"{self.owner}: {self.prefix}{key} is missing; must be an integer >= {least}")
            raise self.error(key, value, f"must be an integer from {least} to {most}")
        return value

    def number(self, key: str, default: float | None, unit: str, *, zero: bool = False) -> float | None:
        value = self.take(key, default)
        if value is None:
            return None
        good = type(value) in (int, float) and math.isfinite(value) and (value > 0 or (zero and value == 0))
        if not good:
            raise self.error(key, value, f"must be a number {'>=' if zero else '>'} 0, in {unit}")
        return float(value)

    def flag(self, key: str, default: bool) -> bool:
        value = self.take(key, default)
        if not isinstance(value, bool):
            raise self.error(key, value, "must be true or false")
        return value

    def finish(self) -> None:
        """Raises PlanError for keys that nobody took."""
        for key in sorted(self._left):
            near = nearest(key, self._known)
            hint = f"did you mean '{near}'?" if near else f"known here: {', '.join(self._known)}"
            raise self.error(key, self._values[key], f"no such key; {hint}")


def _plan(table: _Table, folder: Path) -> Plan:
    scene = table.text("scene")
    if scene.endswith(".py") or "/" in scene:
        scene = str((folder / scene).resolve())
    limits = table.table("limits")
    settings = table.table("settings").items()
    plan = Plan(
        scene=scene,
        until=table.number("until", None, "s"),
        settings=_settings(table, dict(settings)),
        repetitions=table.whole("repetitions", 1, 1),
        repetition_option=table.text("repetition_option", ""),
        fps=table.number("fps", 60.0, "frames per simulated second") or 60.0,
        checkpoint_every=table.number("checkpoint_every", 60.0, "s", zero=True) or 0.0,
        certify=table.flag("certify", False),
        limits=Limits(limits.number("time_out", None, "s"), limits.whole("retries", 3, 0, 100)),
        samples=_samples(table.table("sampling")) if table.has("sampling") else [{}],
    )
    table.take("sampling")
    limits.finish()
    table.finish()
    return plan


def _settings(table: _Table, values: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Settings by dotted name; tables within tables are names with dots. Each is checked by Settings."""
    from ..settings import Settings

    flat: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, dict):
            flat |= _settings(table, value, f"{prefix}{name}.")
        else:
            flat[prefix + name] = value
    if not prefix:
        for name, value in flat.items():
            try:
                Settings(**{name: value})
            except InvalidArgument as error:
                raise table.error(f"settings.{name}", value, str(error)) from None
    return flat


def _samples(table: _Table) -> list[Options]:
    kind = table.text("kind")
    if kind not in _KINDS:
        near = nearest(kind, _KINDS)
        hint = f"; did you mean '{near}'?" if near else ""
        raise table.error("kind", kind, f"must be one of {', '.join(_KINDS)}{hint}")
    if kind == "list":
        samples = _listed(table)
    else:
        drawn = kind in ("random", "latin_hypercube")
        axes = _axes(table, "options", drawn)
        if drawn:
            count, seed = table.whole("count", None, 1), table.whole("seed", 0, 0, 2**32 - 1)
            draw = sampling.random if kind == "random" else sampling.latin_hypercube
            samples = draw(axes, count, seed)
        else:
            _check_size(table, axes)
            samples = sampling.grid(axes)
            if kind == "one_at_a_time":
                variations = _axes(table, "variations", False)
                _check_size(table, axes, variations)
                samples = sampling.one_at_a_time(samples, variations)
    table.finish()
    return samples


def _axes(table: _Table, key: str, drawn: bool) -> dict[str, Axis]:
    options = table.table(key)
    axes = {name: _axis(options, name, value, drawn) for name, value in options.items()}
    if not axes:
        raise PlanError(f"{table.owner}: sampling.{key} is empty; give the values of at least one option")
    return axes


def _check_size(
    table: _Table, axes: Mapping[str, Axis], variations: Mapping[str, Axis] | None = None
) -> None:
    def counts(of: Mapping[str, Axis]) -> list[int]:
        return [axis.count if isinstance(axis, Range) else len(axis) for axis in of.values()]

    count = math.prod(counts(axes)) * (1 + sum(counts(variations or {})))
    if count > LARGEST_STUDY:
        raise PlanError(
            f"{table.owner}: sampling.options make {count} combinations; must be at most {LARGEST_STUDY}; "
            "take fewer values, or kind = 'latin_hypercube'"
        )


def _listed(table: _Table) -> list[Options]:
    runs = table.take("runs", [])
    if not isinstance(runs, list) or not runs or not all(isinstance(run, dict) for run in runs):
        raise table.error("runs", runs, "must be tables of options: [[sampling.runs]]")
    for number, run in enumerate(runs):
        for name, value in run.items():
            _value(table, f"runs[{number}].{name}", value)
    return [dict(run) for run in runs]


def _value(table: _Table, key: str, value: Any) -> Value:
    if not isinstance(value, (bool, int, float, str)):
        hint = "; a list is given as a text: '1.0, 2.0'" if isinstance(value, list) else ""
        raise table.error(key, value, f"must be a number, a text, true or false{hint}")
    if isinstance(value, float) and not math.isfinite(value):
        raise table.error(key, value, "must be finite")
    return value


def _axis(options: _Table, name: str, value: Any, drawn: bool) -> Axis:
    """The values of an option: a list, or a table {from, to} with a count in a grid."""
    if isinstance(value, list):
        if not value:
            raise options.error(name, value, "must hold at least one value")
        return [_value(options, f"{name}[{k}]", v) for k, v in enumerate(value)]
    if not isinstance(value, dict):
        raise options.error(name, value, "must be a list of values, or a range { from = 0.1, to = 0.5 }")
    table = _Table(value, options.owner, f"{options.prefix}{name}.")
    low, high = (_bound(table, key) for key in ("from", "to"))
    count = 0 if drawn else table.whole("count", None, 2)
    scale = table.text("scale", "linear")
    table.finish()
    if not low < high:
        raise table.error("to", high, f"must be greater than from = {low}")
    if scale not in ("linear", "log"):
        raise table.error("scale", scale, "must be 'linear' or 'log'")
    if scale == "log" and not low > 0:
        raise table.error("from", low, "must be > 0 with scale = 'log'; raise it, or take scale = 'linear'")
    whole_ends = isinstance(low, int) and isinstance(high, int)
    return Range(low, high, count, scale == "log", either=whole_ends and drawn)


def _bound(table: _Table, key: str) -> float:
    value: int | float | None = table.take(key)
    if value is None:
        raise PlanError(f"{table.owner}: {table.prefix}{key} is missing; must be a number")
    if type(value) not in (int, float) or not math.isfinite(value):
        raise table.error(key, value, "must be a finite number")
    return value
