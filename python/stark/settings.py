"""Settings with attribute access: ``settings.newton.step_tolerance = 1e-4``.

Names, units, ranges and defaults are declared once in the core; every assignment is checked there. Rules
between settings are checked when a simulation is made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, ClassVar

import numpy as np

from stark import _core
from stark._core import InvalidSetting
from stark._core import Settings as CoreSettings

#: What settings are called elsewhere.
_OTHER_WORDS = {
    "dt": "time_step",
    "h": "time_step",
    "delta_t": "time_step",
    "g": "gravity",
    "thickness": "contact_distance",
    "dhat": "contact_distance",
    "num_threads": "threads",
    "integrator": "time.integrator",
}
#: Short names, and the settings that they stand for.
_SHORT = {
    "time_step": "time.step",
    "contact_distance": "contact.distance",
    "threads": "execution.threads",
}


class _UnknownSetting(InvalidSetting, AttributeError):  # noqa: N818
    """An unknown setting asked for as an attribute, so that hasattr() works."""


class SettingsGroup:
    """The settings below one dotted prefix, as attributes."""

    __slots__ = ("_names", "_prefix", "_settings")

    def __init__(self, settings: Settings, prefix: str) -> None:
        object.__setattr__(self, "_settings", settings)
        object.__setattr__(self, "_prefix", prefix)
        object.__setattr__(
            self, "_names", tuple(n[len(prefix) :] for n in settings.names() if n.startswith(prefix))
        )

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        try:
            return self._settings[self._prefix + name]
        except InvalidSetting as error:
            raise _UnknownSetting(str(error)) from None

    def __setattr__(self, name: str, value: Any) -> None:
        self._settings[self._prefix + name] = value

    def __dir__(self) -> list[str]:
        return list(self._names)

    def __repr__(self) -> str:
        return "\n".join(f"{self._prefix}{name} = {getattr(self, name)!r}" for name in self._names)


class Settings:
    """All settings of a simulation.

    ``Settings(time_step=1/30, contact_distance=2e-3, newton={"step_tolerance": 1e-4})`` or, with
    dotted names, ``**{"newton.step_tolerance": 1e-4}``. Short names exist for ``time.step`` (time_step),
    ``contact.distance`` (contact_distance) and ``execution.threads`` (threads).
    ``settings["newton.step_tolerance"]`` and ``settings.newton.step_tolerance`` are the same."""

    __slots__ = ("__weakref__", "_core")
    _core: CoreSettings

    def __init__(self, **values: Any) -> None:
        object.__setattr__(self, "_core", _core.Settings())
        self.update(values)

    @classmethod
    def _of(cls, core: CoreSettings) -> Settings:
        settings = cls()
        object.__setattr__(settings, "_core", core)
        return settings

    def update(self, values: Mapping[str, Any]) -> None:
        """Assigns all entries by name, or none when one is refused. Groups may be nested mappings."""
        _require_mapping(values)
        changed = self._core.copy()
        for name, value in values.items():
            if isinstance(value, Mapping) and name not in _defaults() and name not in _SHORT:
                if not value and name not in _groups(self.names()):
                    _assign(changed, name, value)
                for inner, inner_value in value.items():
                    _assign(changed, f"{name}.{inner}", inner_value)
            else:
                _assign(changed, name, value)
        object.__setattr__(self, "_core", changed)

    def set_text(self, assignment: str) -> None:
        """Assigns from text, as on a command line: ``"newton.step_tolerance=1e-4"``."""
        _require_assignment(assignment)
        name, _, text = assignment.partition("=")
        self._core.set_text(name.strip(), text.strip())

    def validate(self) -> None:
        """Checks the rules between settings."""
        self._core.validate()

    def copy(self) -> Settings:
        """Settings with the same values, independent of these."""
        return Settings._of(self._core.copy())

    def names(self) -> list[str]:
        """Dotted names of all settings, as in docs/reference.md."""
        return list(_names())

    @staticmethod
    def fields() -> list[dict[str, Any]]:
        """Name, unit, default, rule, choices and meaning of every setting."""
        return _core.Settings.fields()

    @staticmethod
    def markdown() -> str:
        """The reference table of all settings."""
        return _core.Settings.markdown()

    def to_dict(self) -> dict[str, Any]:
        """All settings by dotted name; ``Settings(**d)`` restores them."""
        return self._core.to_dict()

    def changed(self) -> dict[str, Any]:
        """The settings that differ from their defaults."""
        return self._core.changed()

    def brief(self) -> str:
        """One line: what differs from the defaults."""
        return self._core.brief()

    def __getitem__(self, name: str) -> Any:
        return self._core.read(_given_name(name))

    def __setitem__(self, name: str, value: Any) -> None:
        _assign(self._core, name, value)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if any(known.startswith(name + ".") for known in _names()):
            return SettingsGroup(self, name + ".")
        try:
            return self._core.read(name)
        except InvalidSetting as error:
            raise _UnknownSetting(str(error)) from None

    def __setattr__(self, name: str, value: Any) -> None:
        if any(known.startswith(name + ".") for known in _names()):
            raise InvalidSetting(
                f"'{name}' is a group of settings, not a setting; assign to one of its fields"
            )
        _assign(self._core, name, value)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *dict.fromkeys(name.partition(".")[0] for name in self.names())]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Settings) and self._core == other._core

    __hash__: ClassVar[None]  # type: ignore[assignment]  # None, because it is mutable

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (self.to_dict(),)

    def __repr__(self) -> str:
        return self._core.listing().rstrip()


class FixedSettings(Settings):
    """Those that a simulation was made with: they can be read and copied."""

    __slots__ = ()

    def update(self, values: Mapping[str, Any]) -> None:
        _require_mapping(values)
        if values:
            self._refuse(next(iter(values)))

    def set_text(self, assignment: str) -> None:
        _require_assignment(assignment)
        self._refuse(assignment.partition("=")[0].strip())

    def __setitem__(self, name: str, value: Any) -> None:
        self._refuse(name)

    def __setattr__(self, name: str, value: Any) -> None:
        self._refuse(name)

    def _refuse(self, name: str) -> None:
        known = self._core.read(_given_name(name)) if name not in _groups(self.names()) else "..."
        raise InvalidSetting(
            f"{name} = {known!r}: settings of a simulation cannot be changed; create a new one with "
            f"stark.Simulation(scene, sim.settings, {name}=...)"
        )


@cache
def _defaults() -> dict[str, Any]:
    return {field["name"]: field["default"] for field in _core.Settings.fields()}


@cache
def _names() -> tuple[str, ...]:
    return tuple(_defaults())


def _groups(names: list[str]) -> set[str]:
    return {name.partition(".")[0] for name in names if "." in name}


def _alike(name: str, known: list[str]) -> list[str]:
    """Settings whose last word, or short name, resembles that of a name."""
    import difflib  # not at start-up

    words = {other.rpartition(".")[2]: other for other in known} | {short: short for short in _SHORT}
    return [words[word] for word in difflib.get_close_matches(name.rpartition(".")[2][:80], words, n=1)]


def _refuse_text(name: str, default: Any, text: str) -> None:
    """Numbers and switches are no texts: one in quotes may be of another unit, or a mistake."""
    if isinstance(default, bool):
        raise InvalidSetting(f"{name} = {text!r}: must be true or false, not a text; write True or False")
    numbers = "three numbers" if isinstance(default, tuple) else "a number"
    raise InvalidSetting(
        f"{name} = {text!r}: must be {numbers}, not a text; write it without quotes, "
        f"or settings.set_text('{name}={text}') for a text that was read"
    )


def _given_name(name: Any) -> str:
    """The name of a setting; InvalidSetting for anything but a text."""
    if not isinstance(name, str):
        raise InvalidSetting(f"{name!r}: must be the name of a setting, such as 'time.step'")
    return name


def _require_mapping(values: Any) -> None:
    if not isinstance(values, Mapping):
        raise InvalidSetting(
            f"{values!r}: must be a dictionary of settings by name, such as {{'time.step': 0.01}}"
        )


def _require_assignment(text: Any) -> None:
    if not isinstance(text, str) or "=" not in text:
        raise InvalidSetting(f"{text!r}: must have the form name=value, a text")


def _assign(core: _core.Settings, name: str, value: Any) -> None:
    _given_name(name)
    if isinstance(value, np.bool_):  # as comparisons of NumPy give it
        value = bool(value)
    if isinstance(value, np.ndarray) and value.ndim == 0 and not np.ma.isMaskedArray(value):
        value = value.item()  # np.array(0.01) is the number 0.01
    default = _defaults().get(_SHORT.get(name, name))
    if isinstance(value, str) and default is not None and not isinstance(default, str):
        _refuse_text(name, default, value)
    if (
        isinstance(default, tuple)
        and isinstance(value, (list, tuple, np.ndarray))
        and any(map(np.ndim, value))
    ):
        raise InvalidSetting(f"{name} = {value!r}: must be three numbers")
    if name in _SHORT:
        return core.assign(name, value)
    known = list(_names())
    near = [_OTHER_WORDS[name]] if name in _OTHER_WORDS else [other for other in known if name in other][:3]
    near = near or _alike(name, known)
    if name in known or not near:
        return core.assign(name, value)
    words = " or ".join(repr(other) for other in near)
    raise InvalidSetting(f"unknown setting '{name}' (did you mean {words}?)")


def _rebuild(values: dict[str, Any]) -> Settings:
    return Settings(**values)
