"""Materials: immutable parameter sets with units, and presets.

``stark.materials.cotton``, ``towel``, ``soft_rubber``, ``silicone``; every preset says where its numbers come
from in ``.source``. ``cotton.replace(bending_stiffness=1e-5)`` gives a changed copy. The parameters, their
units and ranges are declared once in the core; ``ShellMaterial.parameters()`` lists them."""

from __future__ import annotations

from typing import Any, Generic, Self, TypeVar

from stark import _core
from stark._core import InvalidArgument

_CoreMaterial = TypeVar("_CoreMaterial", _core.ShellMaterial, _core.SolidMaterial)


class _Material(Generic[_CoreMaterial]):
    """Immutable front of a parameter struct of the core."""

    __slots__ = ("_core", "name", "source")
    _core_type: type[Any]
    _core: _CoreMaterial
    name: str
    source: str

    def __init__(self, *, name: str = "", source: str = "", **parameters: float) -> None:
        core = self._core_type()
        core.update(parameters, owner=f"material '{name}'" if name else type(self).__name__)
        self._assign(core, name, source)

    def _assign(self, core: _CoreMaterial, name: str, source: str) -> None:
        object.__setattr__(self, "_core", core)
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "source", source)

    @classmethod
    def _of(cls, core: _CoreMaterial, name: str, source: str) -> Self:
        material = cls.__new__(cls)
        material._assign(core, name, source)
        return material

    def __getattr__(self, name: str) -> float:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self._core.get(name)
        except InvalidArgument as error:
            raise AttributeError(str(error)) from None

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(
            f"{type(self).__name__} is immutable: cannot set {name} = {value!r}; "
            f"use .replace({name}={value!r})"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (type(self), self.name, self.source, self.to_dict())

    def replace(self, *, name: str | None = None, **parameters: float) -> Self:
        """Copy with some parameters changed; ranges are checked."""
        new_name = self.name if name is None else name
        core = self._core.copy()
        core.update(parameters, owner=f"material '{new_name}'" if new_name else type(self).__name__)
        return self._of(core, new_name, self.source if not parameters else "")

    def to_dict(self) -> dict[str, float]:
        """All parameters by name, in SI units."""
        return self._core.to_dict()

    @classmethod
    def parameters(cls) -> list[dict[str, Any]]:
        """Name, unit, default, rule and meaning of every parameter."""
        return cls._core_type.fields()

    @classmethod
    def markdown(cls) -> str:
        """The reference table of all parameters."""
        return cls._core_type.markdown()

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self._core == other._core

    def __hash__(self) -> int:
        return hash((type(self), *self.to_dict().values()))

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.to_dict()]

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value:g}" for name, value in self.to_dict().items())
        return f"{type(self).__name__}({f'name={self.name!r}, ' if self.name else ''}{values})"


def _rebuild(kind: type[Any], name: str, source: str, parameters: dict[str, float]) -> Any:
    return kind(name=name, source=source, **parameters)


class ShellMaterial(_Material[_core.ShellMaterial]):
    """Cloth and thin shells."""

    __slots__ = ()
    _core_type = _core.ShellMaterial
    density: float
    thickness: float
    youngs_modulus: float
    poissons_ratio: float
    strain_limit: float
    strain_limit_stiffness: float
    bending_stiffness: float
    mass_damping: float
    strain_damping: float
    bending_damping: float


class SolidMaterial(_Material[_core.SolidMaterial]):
    """Soft solids."""

    __slots__ = ()
    _core_type = _core.SolidMaterial
    density: float
    youngs_modulus: float
    poissons_ratio: float
    strain_limit: float
    strain_limit_stiffness: float
    mass_damping: float
    strain_damping: float


_shells = {name: ShellMaterial._of(core, name, source) for name, source, core in _core.shell_presets()}
_solids = {name: SolidMaterial._of(core, name, source) for name, source, core in _core.solid_presets()}

cotton: ShellMaterial = _shells["cotton"]
towel: ShellMaterial = _shells["towel"]
soft_rubber: SolidMaterial = _solids["soft_rubber"]
silicone: SolidMaterial = _solids["silicone"]

presets: dict[str, ShellMaterial | SolidMaterial] = {**_shells, **_solids}
"""All presets by name."""
