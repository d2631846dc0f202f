"""``@stark.energy``: energies written in Python.

    @stark.energy
    def spring(e: stark.Edge, stiffness: float = stark.parameter(10.0, unit="N/m", min=0.0)):
        return 0.5 * stiffness * (e.length - e.rest_length) ** 2

    springs = scene.add(spring(cloth.edges, stiffness=20.0))

The function runs once on symbols, when it is first bound; the core differentiates and compiles it."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from stark._core import InvalidArgument
from stark.arguments import given_flag, refuse_copy
from stark.formulas.applying import applied
from stark.formulas.arguments import read_arguments
from stark.formulas.binding import BoundEnergy, RecordedEnergy, counted
from stark.formulas.checks import check
from stark.formulas.frames import Frame
from stark.formulas.handle import RESERVED
from stark.formulas.inspection import benchmark
from stark.formulas.internal import refuse_internal
from stark.formulas.kinematics import Point, Stencil
from stark.formulas.tracing import Trace
from stark.handle import Waiting
from stark.overloads import overload
from stark.symbolic.errors import formula_error
from stark.symbolic.tensor import Scalar, Tensor


class EnergyFormula(RecordedEnergy):
    """An energy as a formula: what ``@stark.energy`` makes of a function. Calling it with points and values
    binds it; ``scene.add`` takes the result."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """The energy on points with values. Inside another formula: the expression of it."""
        if any(isinstance(a, (Scalar, Tensor, Point, Stencil, Frame)) for a in (*args, *kwargs.values())):
            return applied(self.name, self.function, args, kwargs)
        try:
            bound = self.__signature__.bind(*args, **kwargs)
        except TypeError as error:
            raise InvalidArgument(f"{self.name}{self.__signature__}: {error}") from None
        return Binding(self, bound.arguments)

    def check(self, *args: Any, **kwargs: Any) -> Any:
        """Tests the formula on points and values, given as in a call: derivatives against finite differences,
        invariance, definiteness, finite values near the start. Returns a report; print it."""
        return self._bound(args, kwargs).check()

    def benchmark(self, *args: Any, **kwargs: Any) -> dict[str, float]:
        """Nanoseconds per element for "value", "gradient" and "hessian" on one thread, measured on the points
        and values given as in a call."""
        return self._bound(args, kwargs).benchmark()

    def trace(self, frames: Sequence[str] = (), spanning: Sequence[str] = ()) -> Trace:
        """As RecordedEnergy.trace; refuses totals whose names the handle has for something else."""
        recorded = super().trace(frames, spanning)
        taken = RESERVED.union(parameter.name for parameter in self.parameters)
        for name in recorded.totals.names if recorded.totals else ():
            if name in taken:
                raise formula_error(
                    self.name,
                    f"a total must not be called '{name}', a name that is taken; choose another name",
                    self.function,
                )
        return recorded

    def _bound(self, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Binding:
        bound: Binding = args[0] if len(args) == 1 and isinstance(args[0], Binding) else self(*args, **kwargs)
        return bound

    def __reduce__(self) -> str:
        # Pickled by name, as functions are.
        name: str = self.function.__qualname__
        return name

    def __repr__(self) -> str:
        return f"<stark.energy {self.name}{self.__signature__}>"


_ATTRIBUTES = frozenset({"energy", "frames", "constants", "element_count", "trace", "columns", "values"})


class Binding(BoundEnergy):
    """An energy on points with values, to be added to a scene."""

    _waiting: Waiting | None = None
    """What its scenes know it by while it waits to be added; None of energies of files."""

    def __init__(self, energy: RecordedEnergy, given: dict[str, Any]) -> None:
        super().__init__(energy, given)
        waiting = self._waiting = Waiting(f"{self.name} on {counted(self.element_count, 'element')}")
        for body in self.bodies:
            body._scene._not_added[waiting] = None

    def _is_used(self) -> None:
        """Scenes need not warn any more that it was not added to them."""
        if self._waiting is not None:
            for body in self.bodies:
                body._scene._not_added.pop(self._waiting, None)

    def __setattr__(self, name: str, value: Any) -> None:
        # `pull = magnet(...); pull.center = ...` without scene.add would do nothing.
        if name not in _ATTRIBUTES and not name.startswith("_"):
            raise AttributeError(self._not_added(name))
        super().__setattr__(name, value)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name if name.startswith("_") else self._not_added(name))

    def _not_added(self, attribute: str) -> str:
        return (
            f"{self.name} is not in a scene yet, so it has no '{attribute}': add it, and use what "
            f"scene.add returns"
        )

    def check(self) -> Any:
        """As ``EnergyFormula.check``."""
        self._is_used()
        return check(self)

    def benchmark(self) -> dict[str, float]:
        """As ``EnergyFormula.benchmark``."""
        self._is_used()
        return benchmark(self)

    def __copy__(self) -> Binding:
        return self.copy()

    def __reduce_ex__(self, protocol: object) -> NoReturn:
        refuse_copy(
            f"{self.name} on {counted(self.element_count, 'element')}",
            "it is bound to bodies of a scene; pickle the energy itself, and bind it where it is needed",
        )

    def __repr__(self) -> str:
        return f"<{self.name} on {counted(self.element_count, 'element')}; add it with scene.add>"


@overload
def energy(function: Callable[..., object], /) -> EnergyFormula: ...


@overload
def energy(
    *, translation_invariant: bool | None = None
) -> Callable[[Callable[..., object]], EnergyFormula]: ...


def energy(
    function: Callable[..., object] | None = None, /, *, translation_invariant: bool | None = None
) -> Any:
    """Decorator: makes an energy [J] of a function of points, stencils, frames and parameters.

    The annotations say what the arguments are: stark.Point, Edge, Triangle, Tetrahedron, Hinge, Stencil[k],
    Frame for what it acts on; float, Vec3, Mat3 for parameters, whose defaults may be stark.parameter(...);
    Time and TimeStep. translation_invariant: whether moving all points alike leaves the energy as it is;
    found out from the formula if None."""
    if translation_invariant is not None:
        given_flag(translation_invariant, "@stark.energy: translation_invariant")
    if function is None:
        return functools.partial(energy, translation_invariant=translation_invariant)
    name = getattr(function, "__name__", "energy")
    outer = dict(sys._getframe(1).f_locals)
    signature, arguments = read_arguments(function, name, outer, RESERVED)
    refuse_internal(signature, name, function)
    return EnergyFormula(function, signature, arguments, translation_invariant)
