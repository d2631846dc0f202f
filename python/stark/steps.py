"""Steps of a simulation: what they started from, how they are shortened to end at a given time."""

from __future__ import annotations

import copy
import copyreg
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

from stark import _core
from stark._core import Error, InvalidArgument, State, StepProgress, StepReport
from stark.attributes import answer_attributes
from stark.caller import warn
from stark.handle import BodyHandle, SimulationLink
from stark.scene_record import Call


def _state_of(arrays: dict[str, Any]) -> _core.State:
    return _core.State.of_arrays(arrays)


answer_attributes(
    StepReport,
    {
        "iterations": "newton_iterations",
        "dt": "time_step",
        "contacts": "contact_count, or sim.contacts for each of them",
        "converged": "not report.failed",
        "success": "not report.failed",
        "energies": "energy, a dictionary",
    },
)

# States are values: they can be copied, pickled and sent to other processes.
copyreg.pickle(_core.State, lambda state: (_state_of, (state.arrays(),)))


class KeptReport:
    """What a pickled ``StepReport`` or ``Diagnosis`` comes back as, in another process or from a file: all of
    its readings, ``brief()`` and ``to_dict()``."""

    def __init__(self, values: Mapping[str, Any], plain: Mapping[str, Any], texts: Sequence[str]) -> None:
        self.__dict__.update(values)
        self._plain, self._texts = dict(plain), tuple(texts)

    def brief(self) -> str:
        """One line."""
        return self._texts[0]

    def to_dict(self) -> dict[str, Any]:
        """All of it, as JSON has it."""
        return copy.deepcopy(self._plain)

    def __repr__(self) -> str:
        return self._texts[1]


def _kept(report: Any) -> Any:
    """The values of a reading, without objects of the core."""
    if isinstance(report, list):
        return [_kept(item) for item in report]
    if not type(report).__module__.startswith(_core.__name__) or not hasattr(report, "to_dict"):
        return report
    values = {name: getattr(report, name) for name in dir(report) if not name.startswith("_")}
    values = {name: _kept(value) for name, value in values.items() if not callable(value)}
    texts = [report.brief() if hasattr(report, "brief") else "", repr(report)]
    return KeptReport(values, report.to_dict(), texts)


def _keep_reports(kind: Any) -> None:
    """Reports do not change: a copy is the report itself. They are pickled as their readings."""
    kind.__copy__ = lambda self: self
    kind.__deepcopy__ = lambda self, memo: self
    copyreg.pickle(kind, lambda report: (_itself, (_kept(report),)))


def _itself(kept: KeptReport) -> KeptReport:
    return kept


for _kind in (StepReport, _core.Diagnosis):
    _keep_reports(_kind)


class LastStep(NamedTuple):
    """What a step started from: taken again, it brings back what sensors read."""

    before: State
    limit: float | None  #: [s], of a step that was cut short
    values: list[dict[str, Any]]  #: live values of the energies, arrays by name
    placed: float  #: [J], given to what is stored between the step before and this one


class TakenStep(NamedTuple):
    """The step that was taken last, failed or not: what a reproducer holds."""

    before: State
    limit: float | None  #: [s]
    report: StepReport
    values: list[dict[str, Any]]  #: live values of the energies, arrays by name


#: Called while a step is under way: how far it has come.
OnProgress = Callable[[StepProgress], object]


class Stepping(SimulationLink):
    """What checkpoints and reproducers know of a simulation."""

    _loaded: LastStep | None  # of the checkpoint that it goes on from
    _taken: TakenStep | None
    _calls: list[Call]  # that made its scene
    _again: tuple[Any, Any]  # stark.Scene and stark.Simulation, to make both again

    @property
    def _last_step(self) -> LastStep | None:
        if self._taken is None:
            return self._loaded
        before, limit, report, values = self._taken
        return None if report.failed else LastStep(before, limit, values, report.energy["placed"])

    @cached_property
    def _parts(self) -> list[tuple[str, bool, str]]:
        """What the model was made of: name, whether a state depends on it, hash."""
        return self._core.parts()

    @property
    def time(self) -> float:
        raise NotImplementedError

    @property
    def time_step(self) -> float:
        raise NotImplementedError

    @property
    def state(self) -> State:
        raise NotImplementedError

    @state.setter
    def state(self, state: State) -> None:
        raise NotImplementedError

    @property
    def bodies(self) -> Sequence[BodyHandle]:
        raise NotImplementedError

    def step(self, *, max_time_step: float | None = None, progress: OnProgress | None = None) -> StepReport:
        raise NotImplementedError

    def _require_free(self, what: str) -> None:
        raise NotImplementedError


class Steps(Iterator[StepReport]):
    """The steps of a loop, each taken when it is asked for. Whoever asks for none, ``sim.run(until=1.0)``
    alone on a line, is told that nothing happened."""

    def __init__(self, steps: Iterator[StepReport], until: float, *, is_due: bool) -> None:
        self._steps, self._until, self._unasked = steps, until, is_due

    def __iter__(self) -> Iterator[StepReport]:
        self._unasked = False
        return self._steps

    def __next__(self) -> StepReport:
        self._unasked = False
        return next(self._steps)

    def __del__(self) -> None:
        if self._unasked and not sys.is_finalizing():
            warn(
                f"run(until={self._until:g}) alone takes no step: write for step in sim.run(until="
                f"{self._until:g}): ..., or sim.run_until({self._until:g})"
            )


#: Share of a step below which a difference of times is rounding, not a step to take.
TIME_SLIVER = 1e-9


def _time_rounding(sim: Stepping) -> float:
    return max(TIME_SLIVER * sim.time_step, 4.0 * math.ulp(sim.time))


def reached(sim: Stepping, end: float) -> bool:
    """Whether a simulation has come to the time ``end`` [s], up to rounding."""
    return sim.time >= end - _time_rounding(sim)


def limit_of_step(sim: Stepping, end: float) -> float | None:
    """What the coming step has to be shortened to [s], not to go beyond ``end``; None when it is taken whole.
    What differs from a whole step by rounding is one, so that ends between steps of a longer run change
    nothing in it. What is left of less than two steps is taken in two halves: after a much shorter step than
    the one before, reactions of joints are wrong in proportion to both lengths."""
    rest, rounding = float(end) - sim.time, _time_rounding(sim)
    if sim.time_step + rounding < rest < 2.0 * sim.time_step - rounding:
        return 0.5 * rest
    if rest >= sim.time_step - rounding:
        return None
    # Rounded so that the sum is the end, in every bit.
    candidates = (rest, math.nextafter(rest, 0.0), math.nextafter(rest, math.inf))
    return next((limit for limit in candidates if sim.time + limit == end), rest)


def require_callable(progress: OnProgress | None, caller: str) -> None:
    if progress is not None and not callable(progress):
        raise InvalidArgument(
            f"{caller}: progress = {progress!r}: must be a function of one argument, or None"
        )


class StepFailed(Error):  # noqa: N818 (exceptions of Stark say what happened)
    """``Simulation.run`` met a step that failed even at the shortest time step; ``report`` is its report."""

    def __init__(self, report: StepReport) -> None:
        super().__init__(report.message or "the time step failed")
        self.report = report
