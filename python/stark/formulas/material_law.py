"""Laws of solids and shells: called with values, they give materials."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from stark import _core
from stark._core import InvalidArgument
from stark.arguments import shown_value
from stark.caller import warn
from stark.formulas import law_checks
from stark.formulas.applying import applied
from stark.formulas.parameters import Parameter
from stark.formulas.recorded_law import RecordedLaw
from stark.formulas.update_checks import bad_update
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial, refuse_replaced
from stark.symbolic.tensor import Mat, Tensor


class MaterialLaw(RecordedLaw):
    """A constitutive law; what ``@stark.material`` makes of a function. Calling it with values gives a
    material for ``add_solid`` or ``add_cloth``."""

    def __call__(
        self,
        *args: Any,
        base: SolidMaterial | ShellMaterial | RodMaterial | None = None,
        name: str = "",
        **given: Any,
    ) -> Any:
        """A material of this law. Keywords are the parameters of the law, each a number or an array with a
        value for each element, and those of the material (density, thickness, damping, ...), which come from
        ``base`` where they are left out. Called with a strain instead: its energy density."""
        if args:
            return applied(self.name, self._function, (self._as_strain(args[0]), *args[1:]), given)
        kind = self.material_type
        if base is not None and not isinstance(base, kind):
            raise InvalidArgument(
                f"{self.name}: base = {base!r}: must be a stark.{kind.__name__}, for which the law is"
            )
        self._warn_of_changes()
        values = {p.name: self.value(p, given.pop(p.name, p.declaration.default)) for p in self.parameters}
        refuse_replaced(kind, self.name, [p.name for p in self.parameters], given, self.name)
        self.checked(values)
        inherited = {} if base is None else base._core.to_dict()
        flat = {p.name: _flattened(p, values[p.name]) for p in self.parameters}
        source = given.pop("source", "")
        material = kind._with(self.law(values), name or self.name, source, {**inherited, **given, **flat})
        return material._recorded_as((self, self._is_isotropic(values)))

    def values_of(self, material: Any) -> dict[str, np.ndarray]:
        """Its parameters as a material of it has them, by name."""
        return {
            p.name: self.value(p, np.asarray(getattr(material, p.name), dtype=np.float64))
            for p in self.parameters
        }

    @property
    def material_type(self) -> type[Any]:
        """The class of its materials."""
        return SolidMaterial if self.is_solid else ShellMaterial

    def _as_strain(self, given: Any) -> Any:
        """Values or symbols of a strain, rows in a list among them."""
        strain, shape = self._strain
        if not shape:
            return given
        if not isinstance(given, (Tensor, list, tuple, np.ndarray)):
            first = next((f"{parameter.name}=..." for parameter in self.parameters), "")
            raise InvalidArgument(
                f"{self.name}: got {shown_value(given)} without a name: must be values by name for a "
                f"material, such as {self.name}({first}), or the strain {strain} for its energy density"
            )
        if isinstance(given, (list, tuple)):
            given = Mat(given)
        if given.shape != shape:
            raise InvalidArgument(
                f"{self.name}: the strain {strain} has the shape {given.shape}: must be {shape}"
            )
        return given

    def check(self, **given: Any) -> Any:
        """Tests the law with these parameters: rest state, objectivity, isotropy, derivatives, stability.
        Returns a report; print it."""
        values = {p.name: self.value(p, given.pop(p.name, p.declaration.default)) for p in self.parameters}
        return law_checks.check(self, values)

    def checked(self, values: Mapping[str, np.ndarray]) -> None:
        """Raises InvalidArgument for a law that is not finite or has stresses at rest, and warns of one that
        is not objective or not stable, unless it is declared so."""
        if bad := bad_update(self, values, self._rest_points):
            raise InvalidArgument(bad)
        for problem in self._problems(values):
            if problem.is_error:
                raise InvalidArgument(f"{problem.text}\n{self.location}")
            warn(f"{problem.text}\n{self.location}")

    @property
    def _rest_points(self) -> np.ndarray:
        """The points of the formula at rest: columns of F."""
        return np.eye(3)[: self.directions]

    def _problems(self, values: Mapping[str, np.ndarray]) -> list[law_checks.Problem]:
        return law_checks.problems(self, values)

    def law(self, values: Mapping[str, np.ndarray]) -> Any:
        """The law of the core."""
        make = _core.solid_law if self.is_solid else _core.shell_law
        return make(self.name, self.doc, self.formula, self._is_isotropic(values))

    def _is_isotropic(self, values: Mapping[str, np.ndarray]) -> bool:
        declared = self.declared["isotropic"]
        return law_checks.is_isotropic(self, values) if declared is None else declared


def _flattened(parameter: Parameter, value: np.ndarray) -> Any:
    """As materials hold it: matrices in a row."""
    if not parameter.shape:
        return float(value) if value.ndim == 0 else value
    return value.reshape(*value.shape[: value.ndim - len(parameter.shape)], -1)
