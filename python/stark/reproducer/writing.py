"""Writes a time step of a simulation as data and a script that takes it again."""

from __future__ import annotations

import json
import textwrap
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from stark import _core
from stark._core import InvalidArgument
from stark.arguments import given_flag, given_path, shown_value
from stark.array_file import naming, write_arrays, write_atomically
from stark.checkpoint import CheckpointError, memory
from stark.scene_record import Call
from stark.steps import Stepping, TakenStep

from . import reduction
from .errors import ReproducerError
from .formulas import WrittenFormulas
from .parts import NotDataError, as_data
from .rebuilding import VALUES, simulation_of

FORMAT_NAME = "stark-reproducer"
FORMAT_VERSION = 2
DATA, SCRIPT = "step.npz", "reproduce.py"

_SCRIPT = '''"""{title}

{message}

Takes the step again: python {script}. {data} beside it holds the scene, the settings, the state
before the step.

{bodies}
{missing}"""

from pathlib import Path

from stark import reproducer

sim = reproducer.load(Path(__file__).with_name("{data}"))

if __name__ == "__main__":
    report = sim.step({limit})
    print(report.brief())
    if report.diagnosis:
        print(report.diagnosis.cause)
        print(report.diagnosis.finding)
        print(report.diagnosis.remedy)
'''


def write(sim: Stepping, folder: str | PathLike[str], *, reduce: bool = False) -> Path:
    """Writes the step that ``sim`` took last, failed or not, into ``folder``; returns the script. ``reduce``
    leaves out the bodies that have no part in it, where the step of what is left fails for the same cause: it
    is taken, which may last as long as the step itself.

    Raises ReproducerError when no step was taken since the simulation was made, loaded or rewound, and when
    the folder cannot be written. Files of an earlier reproducer there are replaced."""
    place = given_path(folder, "write_reproducer: folder")
    reduce = given_flag(reduce, "write_reproducer: reduce")
    if not hasattr(sim, "_taken") or isinstance(sim, type):
        raise ReproducerError(f"write_reproducer: sim = {shown_value(sim)}: must be a stark.Simulation")
    taken = sim._taken
    if taken is None:
        raise ReproducerError(
            "no step to reproduce: must be written after a step, before the state is set; call sim.step()"
        )
    state = taken.before.arrays()
    calls = [*_with_live_values(sim._calls, taken.values), *_rest_states(sim)]
    header, arrays = _described(sim, taken, calls, state)
    left_out: list[str] = []
    if reduce and taken.report.diagnosis:
        for keep in reduction.candidates(sim, taken.report.diagnosis):
            smaller = _described(sim, taken, *reduction.reduced(sim, state, keep))
            if _fails_alike(sim, taken, *smaller):
                header, arrays = smaller
                left_out = [body.name for k, body in enumerate(sim.bodies) if k not in keep]
                break
    text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    try:
        with naming(place):
            place.mkdir(parents=True, exist_ok=True)
        write_arrays(place / DATA, {"header": text, **arrays})
        script = _script(sim, taken, left_out, header["missing"])
        write_atomically(place / SCRIPT, lambda file: file.write(script.encode("utf-8")))
    except OSError as error:
        raise ReproducerError(f"reproducer {error}") from error
    return place / SCRIPT


def _with_live_values(calls: list[Call], values: list[dict[str, Any]]) -> list[Call]:
    """The calls, those that add energies with the values that the step took where they differ."""
    steps = iter(values)  # of the energies, in the order in which they were added, then of others
    return [_with_values(call, next(steps)) if call[0] == "add_energy" else call for call in calls]


def _with_values(call: Call, live: dict[str, Any]) -> Call:
    name, (given,) = call
    first = {key: np.asarray(numbers).reshape(-1) for key, (numbers, _) in given["values"].items()}
    flat = {key: np.ascontiguousarray(live[key]).reshape(-1) for key in live.keys() & first.keys()}
    changed = {key: array for key, array in flat.items() if array.tobytes() != first[key].tobytes()}
    return name, ({**given, VALUES: changed},)


def _rest_states(sim: Stepping) -> list[Call]:
    """Calls that give bodies the rest states that the step took."""
    return [call for live in sim._live_values for call in getattr(live, "calls", list)()]


def _described(
    sim: Stepping, taken: TakenStep, calls: list[Call], state: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Header and arrays of the file."""
    arrays: dict[str, Any] = {f"state/{name}": array for name, array in state.items()}
    formulas = WrittenFormulas(sim._scene)
    try:
        encoded, missing = _encoded(calls, formulas, arrays)
    except CheckpointError as error:
        raise ReproducerError(f"reproducer: {error}") from None
    report = taken.report
    header = {
        "format": FORMAT_NAME,
        "version": FORMAT_VERSION,
        "stark_version": _core.__version__,
        "scene": sim._scene.name,
        "step": report.step,
        "settings": sim.settings.to_dict(),
        "formulas": formulas.rows,
        "calls": encoded,
        "missing": missing,
        "state_hash": _core.State.of_arrays(state).hash,
        "status": report.status,
        "solve_status": report.solve_status,
        "cause": report.diagnosis.cause if report.diagnosis else None,
        "message": report.message,
    }
    return header, arrays


def _fails_alike(sim: Stepping, taken: TakenStep, header: dict[str, Any], arrays: dict[str, Any]) -> bool:
    try:
        smaller: Stepping = simulation_of(json.loads(json.dumps(header)), arrays, "reproducer", sim._again)
        report = smaller.step() if taken.limit is None else smaller.step(max_time_step=taken.limit)
    except InvalidArgument:
        return False
    expected = taken.report
    return (
        report.failed
        and report.solve_status == expected.solve_status
        and report.diagnosis is not None
        and expected.diagnosis is not None
        and report.diagnosis.cause == expected.diagnosis.cause
    )


def _encoded(
    calls: list[Call], formulas: WrittenFormulas, arrays: dict[str, Any]
) -> tuple[list[Any], list[dict[str, Any]]]:
    """Calls as JSON, and what cannot be: formulas that were made by other means than those of Python."""
    encoded, missing = [], []
    for name, arguments in calls:
        try:
            encoded.append([name, memory.encode(as_data(list(arguments), formulas), arrays, place=name)])
        except NotDataError as error:
            what = name.removeprefix("add_")
            given = arguments[0].get("name") or arguments[0].get("formula_name", "")
            title = f"{what} '{given}'"
            missing.append({"call": name, "what": title if str(error) == "formula" else f"{title}: {error}"})
    return encoded, missing


def _script(sim: Stepping, taken: TakenStep, left_out: list[str], missing: list[dict[str, Any]]) -> str:
    report = taken.report
    failed = f"which {report.status}" if not report.failed else "which failed"
    title = f"Step {report.step} of the scene '{sim._scene.name}' at t = {taken.before.time:.6g} s, {failed}."
    bodies = "\n".join(
        f"    {body.kind} '{body.name}' ({len(body.mesh.vertices)} vertices)"
        for body in sim.bodies
        if body.name not in left_out
    )
    if left_out:
        bodies += f"\nWithout {len(left_out)} bodies, which have no part in it: {', '.join(left_out)}"
    lost = ""
    if missing:
        rows = "\n".join(f"    {row['what']}" for row in missing)
        lost = (
            "\nNot in here, because their formulas are not recorded or too long. The step goes without\n"
            f"energies; other parts must be added to the scene by hand:\n{rows}\n"
        )
    return _SCRIPT.format(
        title=_quoted(title),
        message=_quoted(report.message or "It has nothing to say."),
        script=SCRIPT,
        data=DATA,
        limit="" if taken.limit is None else f"max_time_step={taken.limit!r}",
        bodies=_quoted(f"Bodies:\n{bodies}", width=0),
        missing=_quoted(lost, width=0),
    )


def _quoted(text: str, width: int = 100) -> str:
    """For a docstring."""
    safe = text.replace("\\", "\\\\").replace('"""', "'''")
    return textwrap.fill(safe, width) if width else safe
