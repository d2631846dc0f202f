"""Materials: immutable parameter sets with units, presets, and constitutive laws.

``stark.materials.cotton``, ``towel``, ``soft_rubber``, ``silicone``, ``steel_wire``; every preset says where
its numbers come from in ``.source``. ``cotton.replace(bending_stiffness=1e-5)`` gives a changed copy. The
parameters, their units and ranges are declared once in the core; ``ShellMaterial.parameters()`` lists them.

Materials of another law than Neo-Hookean come from the function of its name::

    rubber = stark.materials.mooney_rivlin(c10=3e4, c01=1e4, bulk_modulus=2e6, density=1100.0)

A parameter may be an array with a value for each element: ``soft_rubber.replace(youngs_modulus=values)``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Self, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark import _core
from stark._core import InvalidArgument, RodLaw, ShellLaw, SolidLaw
from stark.arguments import given_word, nearest, refuse_masked, wrong_mass
from stark.attributes import own_names

_LARGEST = float(np.finfo(np.float64).max)
_CoreMaterial = TypeVar("_CoreMaterial", _core.ShellMaterial, _core.SolidMaterial, _core.RodMaterial)
_Law: TypeAlias = SolidLaw | ShellLaw | RodLaw
_Fields: TypeAlias = dict[str, NDArray[np.float64]]


class _Material(Generic[_CoreMaterial]):
    """Immutable front of a parameter struct of the core, a law and the values that only the law needs."""

    __slots__ = ("_core", "_fields", "_recorded", "law", "name", "source")
    _core_type: type[_CoreMaterial]
    _law_type: ClassVar[type[Any]]
    _laws: ClassVar[dict[str, Any]]
    _core: _CoreMaterial
    _fields: _Fields
    _recorded: Any  # (recorded law, whether it is isotropic), None for laws of the core
    law: Any
    """The constitutive law, None for that of the class. Made with the name of a built-in one, or with the law
    itself: ``SolidMaterial(law="neo_hookean", ...)``."""
    name: str
    source: str

    def __init__(
        self, *, law: _Law | str | None = None, name: str = "", source: str = "", **parameters: ArrayLike
    ) -> None:
        found = self._law_of(law)
        self._refuse_replaced(found, parameters, name)
        self._make(found, name, source, parameters)

    def _make(self, law: _Law | None, name: str, source: str, parameters: Mapping[str, ArrayLike]) -> None:
        self._assign(self._core_type(), name, source, law, {})
        core, fields = self._changed(parameters, name)
        self._assign(core, name, source, law, fields)

    @classmethod
    def _with(cls, law: _Law | None, name: str, source: str, parameters: Mapping[str, ArrayLike]) -> Self:
        """Of all parameters that a material has, whether its law reads them or not."""
        material = cls.__new__(cls)
        material._make(law, name, source, parameters)
        return material

    @classmethod
    def _refuse_replaced(cls, law: _Law | None, given: Mapping[str, Any], name: str) -> None:
        if law is not None:
            owner = f"material '{name}'" if name else cls.__name__
            refuse_replaced(cls, law.name, [row["name"] for row in law.parameters], given, owner)

    @classmethod
    def _law_of(cls, law: _Law | str | None) -> _Law | None:
        """The law itself, or that of a name."""
        if law is None or isinstance(law, cls._law_type):
            return law
        if isinstance(law, str) and law in cls._laws:
            found: _Law = cls._laws[law]
            return found
        raise InvalidArgument(
            f"{cls.__name__}: law = {law!r}: must be one of {', '.join(cls._laws)}; laws of your own are "
            f"functions with @stark.material, which make materials when they are called"
        )

    def _assign(self, core: _CoreMaterial, name: str, source: str, law: Any, fields: _Fields) -> None:
        given_word(name, f"{type(self).__name__}: name")
        for slot, value in zip(_Material.__slots__, (core, fields, None, law, name, source), strict=True):
            object.__setattr__(self, slot, value)

    def _recorded_as(self, recorded: Any) -> Self:
        """This material, whose law was recorded."""
        object.__setattr__(self, "_recorded", recorded)
        return self

    @classmethod
    def _of(
        cls, core: _CoreMaterial, name: str, source: str, law: Any = None, fields: _Fields | None = None
    ) -> Self:
        material = cls.__new__(cls)
        material._assign(core, name, source, law, fields or {})
        return material

    def _changed(self, parameters: Mapping[str, ArrayLike], name: str) -> tuple[_CoreMaterial, _Fields]:
        """Core and fields with some parameters changed: what the core cannot hold becomes a field."""
        owner = f"material '{name}'" if name else type(self).__name__
        core, fields = self._core.copy(), dict(self._fields)
        known = {row["name"] for row in core.fields()}
        of_law = {row["name"] for row in self.law.parameters} if self.law else set()
        plain: dict[str, Any] = {}
        for parameter, value in parameters.items():
            _refuse_number_in_quotes(value, f"{owner}: {parameter}")
            is_array = isinstance(value, (list, tuple)) or (isinstance(value, np.ndarray) and value.ndim > 0)
            if (parameter in known and not is_array) or parameter not in known | of_law:
                plain[parameter] = value  # of an unknown name: refused by the core, with a hint
                fields.pop(parameter, None)
            else:
                fields[parameter] = _numbers(value, f"{owner}: {parameter}")
        core.update(plain, owner=owner)
        if self.law:
            self.law.check(_flat(fields, self.law), owner)
        return core, fields

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if name in self._fields:
            value = self._fields[name]
            return value if value.ndim else float(value)
        if name in self._replaced():
            instead = _instead([row["name"] for row in self.law.parameters])
            raise AttributeError(f"material of the law '{self.law.name}' has no {name}: the law {instead}")
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
        recorded = None if self._recorded is None else self._recorded[0]
        if callable(recorded):  # made of a function, which is pickled by its name
            return _recalled, (recorded, self.name, self.source, self.to_dict())
        law = None if self.law is None else self.law.name
        if law is not None and law not in self._laws:
            raise TypeError(f"material with the law '{law}' cannot be pickled: the law is not built in")
        return _rebuild, (type(self), self.name, self.source, law, self._all_values())

    def replace(self, *, name: str | None = None, **parameters: ArrayLike) -> Self:
        """Copy with other parameters, numbers or arrays with a value for each element; ranges are checked."""
        new_name = self.name if name is None else given_word(name, f"{type(self).__name__}: name")
        self._refuse_replaced(self.law, parameters, new_name)
        core, fields = self._changed(parameters, new_name)
        source = self.source if not parameters else ""
        return self._of(core, new_name, source, self.law, fields)._recorded_as(self._recorded)

    def _replaced(self) -> set[str]:
        """Parameters in whose place the law has its own."""
        of_law = None if self.law is None else {row["name"] for row in self.law.parameters}
        return set() if of_law is None else set(_replaced_by_laws(type(self))) - of_law

    def _all_values(self) -> dict[str, Any]:
        """Of all parameters that the core has, whether the law reads them or not."""
        return self._core.to_dict() | {name: getattr(self, name) for name in self._fields}

    def _with_mass(self, mass: float, size: float, owner: str) -> Self:
        """Copy whose density gives a body of this area [m^2] or volume [m^3] the mass [kg].
        Sizes that are not positive are left to the checks of meshes."""
        if not size > 0.0:
            return self
        real = isinstance(mass, (int, float, np.number)) and not isinstance(mass, (bool, np.complexfloating))
        if not real or not 0.0 < mass <= _LARGEST:
            raise wrong_mass(owner, mass)
        if "density" in self._fields:
            raise InvalidArgument(
                f"{owner}: mass = {mass!r} kg and a density of each element: must be one of the two; leave "
                f"out the mass, or give a material with one density"
            )
        return self.replace(density=float(mass) / size)

    def to_dict(self) -> dict[str, Any]:
        """All parameters that it has with its law, by name in SI units; arrays where elements differ."""
        return {name: value for name, value in self._all_values().items() if name not in self._replaced()}

    @classmethod
    def parameters(cls) -> list[dict[str, Any]]:
        """Name, unit, default, rule and meaning of every parameter, those of other laws aside."""
        return cls._core_type.fields()

    @classmethod
    def markdown(cls) -> str:
        """The reference table of all parameters."""
        return cls._core_type.markdown()

    def __eq__(self, other: object) -> bool:
        return (
            type(other) is type(self)
            and self._core == other._core
            and getattr(self.law, "name", None) == getattr(other.law, "name", None)
            and self._fields.keys() == other._fields.keys()
            and all(np.array_equal(value, other._fields[name]) for name, value in self._fields.items())
        )

    def __hash__(self) -> int:
        return hash((type(self), *self._core.to_dict().values(), *sorted(self._fields)))

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.to_dict()]

    def __repr__(self) -> str:
        shown = {name: _text(value) for name, value in self.to_dict().items()}
        if self.law is not None:
            shown = {"law": self.law.name} | shown
        if self.name:
            shown = {"name": repr(self.name)} | shown
        return f"{type(self).__name__}({', '.join(f'{name}={text}' for name, text in shown.items())})"

    def _description(self) -> dict[str, Any]:
        """What a body of this material hands to the core beside the parameters of the core."""
        return {"law": self.law, "fields": _flat(self._fields, self.law)}


def _replaced_by_laws(kind: type[Any]) -> tuple[str, ...]:
    """Parameters of the law of a class, in whose place another law has its own; rods take their shear
    stiffness from them."""
    return () if kind is RodMaterial else ("youngs_modulus", "poissons_ratio")


def refuse_replaced(
    kind: type[Any], law: str, of_law: Sequence[str], given: Mapping[str, Any], owner: str
) -> None:
    """A parameter that would change nothing, beside a law that does not have it."""
    for name in _replaced_by_laws(kind):
        if name in given and name not in of_law:
            raise InvalidArgument(
                f"{owner}: {name} = {given[name]!r}: must be left out, as its law '{law}' does not depend on "
                f"it; the law {_instead(of_law)}" + ("; change these" if of_law else "")
            )


def _instead(of_law: Sequence[str]) -> str:
    return f"has {', '.join(of_law)} instead" if of_law else "has no parameters"


def _refuse_number_in_quotes(value: Any, what: str) -> None:
    """The core reads words, and would read a number from a text, which no other value takes."""
    if not isinstance(value, str):
        return
    try:
        float(value)
    except ValueError:
        return  # for the core to say which words there are
    raise InvalidArgument(f"{what} = {value!r}: must be a number, not a text; write {value.strip()}")


def _numbers(value: ArrayLike, name: str) -> NDArray[np.float64]:
    refuse_masked(value, name)
    try:
        array = np.array(value)
        if array.dtype.kind not in "iuf":
            raise TypeError
    except (TypeError, ValueError):
        raise InvalidArgument(f"{name} = {value!r}: must be a number, or an array of numbers") from None
    array = array.astype(np.float64)
    array.setflags(write=False)
    return array


def _flat(fields: _Fields, law: _Law | None) -> dict[str, tuple[NDArray[np.float64], bool]]:
    """Name -> (all numbers in a row, whether they are of each element)."""
    widths = {row["name"]: row["width"] for row in law.parameters} if law else {}
    return {
        name: (value.reshape(-1), value.ndim > (1 if widths.get(name, 1) > 1 else 0))
        for name, value in fields.items()
    }


def _text(value: float | str | NDArray[np.float64]) -> str:
    if isinstance(value, str):
        return repr(value)
    return f"{value:g}" if np.ndim(value) == 0 else f"<array of shape {np.shape(value)}>"


def _rebuild(kind: type[Any], name: str, source: str, law: str | None, parameters: dict[str, Any]) -> Any:
    return kind._with(None if law is None else kind._laws[law], name, source, parameters)


def _recalled(law: Any, name: str, source: str, parameters: dict[str, Any]) -> Any:
    material = law(name=name, **parameters)
    object.__setattr__(material, "source", source)
    return material


class ShellMaterial(_Material[_core.ShellMaterial]):
    """Cloth and thin shells: a Neo-Hookean membrane unless another ``law`` is given. With a ``yield_stress``
    membrane and bending yield, with a ``bending_yield_moment`` alone the bending does: creases stay."""

    __slots__ = ()
    _core_type = _core.ShellMaterial
    _law_type = ShellLaw
    _laws: ClassVar[dict[str, Any]] = {law.name: law for law in _core.shell_laws()}
    density: float
    thickness: float
    youngs_modulus: float
    poissons_ratio: float
    strain_limit: float
    strain_limit_stiffness: float
    strain_limit_hardening: float
    strain_limit_law: str
    bending_stiffness: float
    flexural_rigidity: float
    yield_stress: float
    hardening_modulus: float
    bending_yield_moment: float
    bending_hardening: float
    mass_damping: float
    strain_damping: float
    bending_damping: float
    thermal_expansion: float


class SolidMaterial(_Material[_core.SolidMaterial]):
    """Soft solids: stable Neo-Hookean unless another ``law`` is given."""

    __slots__ = ()
    _core_type = _core.SolidMaterial
    _law_type = SolidLaw
    _laws: ClassVar[dict[str, Any]] = {law.name: law for law in _core.solid_laws()}
    density: float
    youngs_modulus: float
    poissons_ratio: float
    strain_limit: float
    strain_limit_stiffness: float
    strain_limit_hardening: float
    strain_limit_law: str
    mass_damping: float
    strain_damping: float
    thermal_expansion: float


class RodMaterial(_Material[_core.RodMaterial]):
    """Rods: Kirchhoff's rod with stretch unless another ``law`` is given. The section is round, or
    rectangular with ``width`` along the first axis and ``height`` along the second one; stiffnesses that are
    given replace those of the section. With a ``yield_stress`` the rod yields where its whole section does;
    yield forces and moments that are given replace those of the section."""

    __slots__ = ()
    _core_type = _core.RodMaterial
    _law_type = RodLaw
    _laws: ClassVar[dict[str, Any]] = {law.name: law for law in _core.rod_laws()}
    density: float
    youngs_modulus: float
    poissons_ratio: float
    radius: float
    width: float
    height: float
    axial_stiffness: float
    shear_stiffness: float
    bending_stiffness_1: float
    bending_stiffness_2: float
    torsional_stiffness: float
    yield_stress: float
    hardening_modulus: float
    yield_force: float
    yield_moment_1: float
    yield_moment_2: float
    yield_torque: float
    mass_damping: float
    strain_damping: float
    thermal_expansion: float

    @property
    def section(self) -> dict[str, float]:
        """What the section gives the rod: mass [kg/m], axial_stiffness and shear_stiffness [N],
        bending_stiffness_1, bending_stiffness_2 and torsional_stiffness [N m^2]; where it yields:
        yield_force [N], yield_moment_1, yield_moment_2 and yield_torque [N m], which are infinite where it
        does not, and yield_hardening [m/J]."""
        return _core.rod_section(self._core)


solid_laws: dict[str, SolidLaw] = SolidMaterial._laws
"""All built-in laws of solids by name."""
shell_laws: dict[str, ShellLaw] = ShellMaterial._laws
"""All built-in laws of membranes by name, the Neo-Hookean one of ShellMaterial itself aside."""


def _material_of(kind: type[Any], law: _Law) -> Callable[..., Any]:
    """Function that makes a material of a law: its parameters are keywords, those that the material has not
    are required."""
    optional = {row["name"] for row in kind.parameters()} | {"warp_direction"}
    required = [row["name"] for row in law.parameters if row["name"] not in optional]

    def make(*, name: str = law.name, source: str = "", **parameters: ArrayLike) -> Any:
        for parameter in required:
            if parameter not in parameters:
                row = next(row for row in law.parameters if row["name"] == parameter)
                unit = "" if row["unit"] == "1" else f" [{row['unit']}]"
                raise InvalidArgument(
                    f"materials.{law.name}: no value of {parameter}{unit}, {row['doc']}: it is "
                    f"needed; give a number, or an array with a value for each element"
                )
        return kind(law=law, name=name, source=source, **parameters)

    lines = [f"{row['name']} [{row['unit']}]: {row['doc']}, {row['rule']}" for row in law.parameters]
    make.__name__ = make.__qualname__ = law.name
    make.__doc__ = (
        f"{kind.__name__} of {law.doc}. Parameters, besides those of the class: " + "; ".join(lines) + "."
    )
    keywords = [Parameter(p, Parameter.KEYWORD_ONLY, annotation="ArrayLike") for p in required]
    make.__signature__ = Signature([*keywords, Parameter("parameters", Parameter.VAR_KEYWORD)])  # type: ignore[attr-defined]
    return make


neo_hookean: Callable[..., SolidMaterial] = _material_of(SolidMaterial, solid_laws["neo_hookean"])
st_venant_kirchhoff: Callable[..., SolidMaterial] = _material_of(
    SolidMaterial, solid_laws["st_venant_kirchhoff"]
)
corotated: Callable[..., SolidMaterial] = _material_of(SolidMaterial, solid_laws["corotated"])
mooney_rivlin: Callable[..., SolidMaterial] = _material_of(SolidMaterial, solid_laws["mooney_rivlin"])
fiber_reinforced: Callable[..., SolidMaterial] = _material_of(SolidMaterial, solid_laws["fiber_reinforced"])
membrane_st_venant_kirchhoff: Callable[..., ShellMaterial] = _material_of(
    ShellMaterial, shell_laws["membrane_st_venant_kirchhoff"]
)
plastic_membrane: Callable[..., ShellMaterial] = _material_of(ShellMaterial, shell_laws["plastic_membrane"])
orthotropic_cloth: Callable[..., ShellMaterial] = _material_of(ShellMaterial, shell_laws["orthotropic_cloth"])


_shells = {name: ShellMaterial._of(core, name, source) for name, source, core in _core.shell_presets()}
_solids = {name: SolidMaterial._of(core, name, source) for name, source, core in _core.solid_presets()}
_rods = {name: RodMaterial._of(core, name, source) for name, source, core in _core.rod_presets()}


def plate(
    *, youngs_modulus: float, poissons_ratio: float, thickness: float, density: float, **parameters: ArrayLike
) -> ShellMaterial:
    """Thin plate of an elastic material: ``youngs_modulus`` [Pa], ``thickness`` [m], ``density`` of volume
    [kg/m^3]: flexural rigidity E t^3 / (12 (1 - nu^2)), mass rho t per area. Further parameters are those of
    ShellMaterial."""
    numbers = {
        "youngs_modulus": youngs_modulus, "poissons_ratio": poissons_ratio, "thickness": thickness,
        "density": density,
    }  # fmt: skip
    given = {name: _numbers(value, f"materials.plate: {name}") for name, value in numbers.items()}
    E, nu, t, rho = given.values()
    try:
        with np.errstate(all="ignore"):
            given["density"], rigidity = rho * t, E * t**3 / (12.0 * (1.0 - nu**2))
    except ValueError:
        shapes = ", ".join(str(value.shape) for value in given.values())
        raise InvalidArgument(
            f"materials.plate: arrays of the shapes {shapes}: must be numbers, or a value for each element"
        ) from None
    if not np.isfinite(rigidity).all():
        raise InvalidArgument(
            f"materials.plate: poissons_ratio = {poissons_ratio!r}, youngs_modulus = {youngs_modulus!r} Pa, "
            f"thickness = {thickness!r} m: must give a finite rigidity"
        )
    values: dict[str, Any] = {"flexural_rigidity": rigidity, "mass_damping": 0.1, **given, **parameters}
    return ShellMaterial(**values)


cotton: ShellMaterial = _shells["cotton"]
towel: ShellMaterial = _shells["towel"]
paper: ShellMaterial = _shells["paper"]
pet: ShellMaterial = _shells["pet"]
steel_sheet: ShellMaterial = _shells["steel_sheet"]
soft_rubber: SolidMaterial = _solids["soft_rubber"]
silicone: SolidMaterial = _solids["silicone"]
foam: SolidMaterial = _solids["foam"]
natural_rubber: SolidMaterial = _solids["natural_rubber"]
pet_solid: SolidMaterial = _solids["pet_solid"]
steel: SolidMaterial = _solids["steel"]
steel_wire: RodMaterial = _rods["steel_wire"]
rubber_cord: RodMaterial = _rods["rubber_cord"]

presets: dict[str, ShellMaterial | SolidMaterial | RodMaterial] = {**_shells, **_solids, **_rods}
"""All presets by name."""

if not TYPE_CHECKING:  # checkers would take every name for known

    def __getattr__(name: str) -> Any:
        """Says which preset was probably meant."""
        if name.startswith("_"):
            raise AttributeError(name)
        near = nearest(name, [other for other in globals() if other[0].islower()])
        hint = f"did you mean '{near}'?" if near else f"presets are {', '.join(presets)}"
        raise AttributeError(
            f"there is no material '{name}' in stark.materials; {hint}",
            name=name,
            obj=None,  # without one Python adds no hint of its own
        )


def __dir__() -> list[str]:
    return own_names(__name__, globals())
