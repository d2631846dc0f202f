"""``stark.internal``: what a material remembers, as arguments of a law."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stark._core import FormulaBuilder, TraceError
from stark.formulas.kinematics import Inputs
from stark.symbolic.errors import formula_error
from stark.symbolic.signature import ArgumentType
from stark.symbolic.tensor import Scalar, convert, describe, from_shape


@dataclass(frozen=True)
class InternalDeclaration:
    """What ``stark.internal`` makes; its fields are the arguments."""

    initial: np.ndarray
    unit: str
    doc: str


def internal(initial: Any = 0.0, *, unit: str = "1", doc: str = "") -> Any:
    """Declares an internal variable of a law, as the default of an argument::

        @stark.material
        def law(F: stark.DeformationGradient, plastic: stark.Mat3 = stark.internal(np.eye(3)), ...):
            ...
            return psi, {"plastic": new_value}

    Every element, or quadrature point, has a value of its own, which starts as ``initial``. The argument is
    the value at the start of the time step; what the law returns for it beside psi is taken over when the
    step is accepted. initial: a number, or an array of the shape of the annotation; a single number fills it.
    unit: for messages. Raises TraceError for an initial value that is not finite numbers."""
    if not isinstance(unit, str):
        raise TraceError(f"stark.internal: unit = {unit!r}: must be a text such as 'Pa'")
    try:
        values = np.array(initial, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TraceError(f"stark.internal: initial = {initial!r}: must be a number or an array") from None
    if not np.isfinite(values).all():
        raise TraceError(f"stark.internal: initial = {initial!r} {unit}: must be finite")
    return InternalDeclaration(values, unit, doc)


@dataclass(frozen=True)
class Internal:
    """An internal variable of a law: its name, its shape () (k,) or (r, c), and how it was declared."""

    name: str
    shape: tuple[int, ...]
    declaration: InternalDeclaration

    @property
    def initial(self) -> list[float]:
        """Its numbers at time 0, in a row."""
        values: list[float] = np.broadcast_to(self.declaration.initial, self.shape).reshape(-1).tolist()
        return values

    def entries(self, builder: FormulaBuilder) -> list[Scalar]:
        """Its value at the start of the step, in a row."""
        doc = self.declaration.doc or self.name
        made: list[Scalar] = builder.internal(self.name, self.initial, self.declaration.unit, doc)
        return made

    def symbols(self, inputs: Inputs) -> object:
        """Its value at the start of the step as a Scalar, Vec or Mat of named inputs."""
        entries = self.entries(inputs.builder)
        inputs.note(entries, self.name)
        for k, entry in enumerate(entries):
            place = ",".join(map(str, np.unravel_index(k, self.shape))) if self.shape else ""
            inputs.builder.set_name(entry, f"{self.name}[{place}]" if place else self.name)
        return from_shape(entries, self.shape)


def read_internal(parameter: inspect.Parameter, law: str, function: Callable[..., object]) -> Internal | None:
    """The argument if its default is ``stark.internal(...)``; a wrong shape is refused."""
    declaration, kind = parameter.default, parameter.annotation
    if not isinstance(declaration, InternalDeclaration):
        return None
    if kind in (float, int, Scalar):
        kind = ArgumentType(())
    if not isinstance(kind, ArgumentType):
        raise formula_error(
            law,
            f"internal variable '{parameter.name}': annotate it float, stark.Vec3 or stark.Mat3",
            function,
        )
    if declaration.initial.shape not in ((), kind.shape):
        raise formula_error(
            law,
            f"internal variable '{parameter.name}': its initial value has the shape "
            f"{declaration.initial.shape}: must be {kind.shape} or a number",
            function,
        )
    return Internal(parameter.name, kind.shape, declaration)


def refuse_internal(signature: inspect.Signature, energy: str, function: Callable[..., object]) -> None:
    """Energies remember nothing: only laws of materials have internal variables."""
    for parameter in signature.parameters.values():
        if isinstance(parameter.default, InternalDeclaration):
            raise formula_error(
                energy,
                f"argument '{parameter.name}': stark.internal is for laws of materials (@stark.material); an "
                f"energy knows the start of the step (x_prev), and parameters that you set between steps",
                function,
            )


def split_result(
    law: str, result: object, internals: Sequence[Internal], function: Callable[..., object]
) -> tuple[object, list[Scalar]]:
    """psi and the new values of all internal variables in a row, from what a law has returned."""
    if not internals:
        return result, []
    names = [variable.name for variable in internals]
    if not (isinstance(result, tuple) and len(result) == 2 and isinstance(result[1], Mapping)):
        example = ", ".join(f'"{name}": ...' for name in names)
        raise formula_error(
            law, f"with internal variables it must return the energy and a dict: psi, {{{example}}}", function
        )
    psi, updates = result
    if set(updates) != set(names):
        raise formula_error(
            law,
            f"it returns new values of {sorted(map(str, updates))}: must be all its internal variables, "
            f"{names}",
            function,
        )
    values: list[Scalar] = []
    for variable in internals:
        value = convert(updates[variable.name], f"the new value of '{variable.name}'")
        shape = () if isinstance(value, Scalar) else value.shape
        if shape != variable.shape:
            raise formula_error(
                law,
                f"the new value of '{variable.name}' is {describe(value)}: must have the shape "
                f"{variable.shape}",
                function,
            )
        values += [value] if isinstance(value, Scalar) else list(value.entries)
    return psi, values
