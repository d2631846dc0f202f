"""Energies of a scene: handles with live values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.courses import at_start, refuse_lost_change, set_courses
from stark.formulas.binding import BoundEnergy
from stark.formulas.checks import check
from stark.formulas.inspection import benchmark
from stark.formulas.parameters import Parameter, Value, check_range, numbers_of
from stark.handle import Handle, SceneLink, SimulationLink
from stark.readings import reading

Floats = NDArray[np.float64]


class Energy(Handle):
    """An energy of a scene. Its parameters are attributes: ``pull.center = (0, 0.1, 0.3)``, also
    ``pull.stiffness[3] = 0.0`` in place. Every simulation of the scene takes the values at its next step;
    nothing is recompiled. A function of the time [s] is followed: each step takes its value at the end of the
    step, until another is assigned."""

    _binding: BoundEnergy

    def __init__(self, scene: SceneLink, index: int, binding: BoundEnergy) -> None:
        super().__init__(scene, index)
        self.__dict__.update(_binding=binding)

    @property
    def name(self) -> str:
        """Name of the energy, unique in its scene."""
        return self._scene._core.energy_name(self._index)

    @property
    def formula(self) -> Any:
        """The decorated function."""
        return self._binding.energy

    @property
    def element_count(self) -> int:
        """Number of elements: points, edges, triangles and so on that the energy is evaluated on."""
        return self._binding.element_count

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Values by name; a number, or an array that may be changed in place."""
        return _Parameters(self)

    @property
    def energies(self) -> Floats:
        """Energies of the elements at the end of the last step (n,) [J]; of an energy of totals (1,)."""
        found = self._require_simulation("energies")._core.element_energies(self._index)
        return reading(found, self, "energies")

    @property
    def energy(self) -> float:
        """Sum of ``energies`` [J]."""
        return float(self.energies.sum())

    @property
    def forces(self) -> Floats:
        """Forces on the points of the elements at the end of the last step (n, points, 3) [N]. Points of a
        formula are those of its arguments in order; of a frame, origin and axes as far as they occur."""
        flat = self._require_simulation("forces")._core.element_forces(self._index)
        return reading(flat.reshape(self.element_count, -1, 3), self, "forces")

    @property
    def totals(self) -> Mapping[str, float]:
        """Of an energy of totals: the sums at the end of the last step, by their names."""
        return self._of_totals("totals")

    @property
    def total_slopes(self) -> Mapping[str, float]:
        """Derivatives of an energy of totals by these [J per unit]: of a gas, minus its pressure by its
        volume."""
        return self._of_totals("total_slopes")

    def _of_totals(self, what: str) -> Mapping[str, float]:
        known = self._binding.trace.totals
        if known is None:
            return {}
        core = self._require_simulation(what)._core
        values = core.energy_totals(self._index) if what == "totals" else core.energy_slopes(self._index)
        names = [name or f"total {k}" for k, name in enumerate(known.names)]
        return dict(zip(names, (float(v) for v in values), strict=False))

    def check(self) -> Any:
        """As ``EnergyFormula.check``, with the points and the present values."""
        return check(self._binding)

    def benchmark(self) -> dict[str, float]:
        """As ``EnergyFormula.benchmark``."""
        return benchmark(self._binding)

    @property
    def _title(self) -> str:
        return f"energy '{self.name}'"

    def _count_in(self, simulation: SimulationLink) -> int:
        return simulation._energy_count

    def _live_values(self) -> LiveValues:
        return LiveValues(self)

    def _parameter(self, name: str) -> Parameter:
        return next(p for p in self._binding.energy.parameters if p.name == name)

    def _read(self, name: str) -> Any:
        value = self._binding.values[name]
        if value.array.ndim == 0:
            return float(value.array)
        return value.expose()

    def _write(self, name: str, given: Any) -> None:
        self._binding.values[name].write(self._checked(name, given))

    def _checked(self, name: str, given: Any) -> Floats:
        """Of a parameter; InvalidArgument for what it cannot be."""
        owner, parameter, value = f"energy '{self.name}'", self._parameter(name), self._binding.values[name]
        array = numbers_of(owner, parameter, given)
        if value.per_element and array.shape == parameter.shape:
            array = np.broadcast_to(array, value.array.shape)
        if array.shape != value.array.shape:
            how = "with a value for each element" if value.per_element else "with one value for all elements"
            raise InvalidArgument(
                f"{owner}: {parameter.describe()}: got the shape {array.shape}: must be {value.array.shape}, "
                f"as it was added {how}; add the energy with "
                + ("one value" if value.per_element else "an array of a value for each element")
                + " to change that"
            )
        check_range(owner, parameter, array, value.per_element)
        return array

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # asked for while a copy has no attributes yet
            raise AttributeError(name)
        if name in self._binding.values:
            return self._read(name)
        known = self._binding.trace.totals
        if known is not None and name in known.names:
            return self.totals[name]
        raise AttributeError(f"energy '{self.name}' has no attribute '{name}'; {self._known()}")

    def __setattr__(self, name: str, given: Any) -> None:
        if name not in self._binding.values:
            raise AttributeError(f"energy '{self.name}' has no parameter '{name}'; {self._known()}")
        value = self._checked(name, at_start(given, f"energy '{self.name}': {name}"))
        known = self._binding.values[name]
        acts_later = callable(given) and self._simulation() is not None  # in the next step
        known.write(known.array if acts_later else value)
        set_courses("energy", self, {name: given})

    def _follow(self, simulation: SimulationLink, name: str, value: Any) -> None:
        known = self._binding.values[name]
        if known.written is not None:
            refuse_lost_change(f"energy '{self.name}'", name, known.array, known.written)
        self._write(name, value)

    def __dir__(self) -> list[str]:
        known = self._binding.trace.totals
        return [*super().__dir__(), *self._binding.values, *filter(None, known.names if known else ())]

    def _known(self) -> str:
        names = ", ".join(self._binding.values)
        known = f"its parameters are {names}" if names else "it has no parameters"
        totals = self._binding.trace.totals
        named = [name for name in totals.names if name] if totals else []
        if not named:
            return known
        slope = f"total_slopes['{named[0]}'] is the derivative of the energy by it"
        of_gas = "of a gas, minus its pressure over that outside [Pa]"
        return f"{known}; its totals are {', '.join(named)}; {slope} ({of_gas})"

    def __repr__(self) -> str:
        return f"<stark.Energy '{self.name}' on {self.element_count} elements>"


class _Parameters(Mapping[str, Any]):
    """Parameters of an energy by name."""

    def __init__(self, energy: Energy) -> None:
        self._energy = energy

    def __getitem__(self, name: str) -> Any:
        if name not in self._energy._binding.values:
            raise KeyError(f"energy '{self._energy.name}' has no parameter '{name}'; {self._energy._known()}")
        return self._energy._read(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._energy._binding.values)

    def __len__(self) -> int:
        return len(self._energy._binding.values)

    def __repr__(self) -> str:
        return repr(dict(self))


RESERVED = frozenset({"time", "time_step", *(n for n in vars(Energy) if not n.startswith("_"))})
"""Names that parameters cannot have."""


class LiveValues:
    """What one simulation knows of the values of an energy. Values that nobody touched cost nothing."""

    def __init__(self, energy: Energy) -> None:
        self.energy = energy
        self.name: str = energy.name
        # The core was given the first values with the energy.
        self._known: dict[str, tuple[int, Floats | None]] = dict.fromkeys(energy._binding.values, (0, None))

    def push(self, core: Any) -> None:
        """Hands what changed since the last call to the simulation."""
        for name, value in self.energy._binding.values.items():
            version, copy = self._known[name]
            if value.version == version and not (value.exposed and self._changed(value, copy)):
                if copy is None:  # nobody has touched it so far
                    self._known[name] = version, value.array.copy()
                continue
            owner, parameter = f"energy '{self.energy.name}'", self.energy._parameter(name)
            check_range(owner, parameter, value.array, value.per_element)
            core.set_energy_value(self.energy._index, name, value.numbers)
            self._known[name] = value.version, value.array.copy()

    def present(self) -> dict[str, Floats]:
        """Copies of the values that the next step takes."""
        return {name: value.array.copy() for name, value in self.energy._binding.values.items()}

    def check(self, owner: str, given: Mapping[str, Floats]) -> None:
        """Raises InvalidArgument for values out of range."""
        for name, array in given.items():
            value = self.energy._binding.values[name]
            check_range(owner, self.energy._parameter(name), array, value.per_element)

    def assign(self, given: Mapping[str, Floats]) -> None:
        """Makes these the values of the energy, for every simulation of its scene."""
        for name, array in given.items():
            value = self.energy._binding.values[name]
            if value.array.tobytes() != array.tobytes():
                value.write(array)

    def pushed(self) -> dict[str, Floats]:
        """The values that the last step took."""
        return {name: copy for name, (_, copy) in self._known.items() if copy is not None}

    @staticmethod
    def _changed(value: Value, copy: Floats | None) -> bool:
        return copy is None or not np.array_equal(value.array, copy)
