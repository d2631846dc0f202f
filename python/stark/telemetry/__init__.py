"""Per-step telemetry: the numbers of every time step as JSON lines, with the unit of each series.

One line of ``telemetry.jsonl`` is one call of ``sim.step()``. Numbers of the simulator that are not finite
(the minimum distance of a step without contacts, the residual of a failed solve) are written as ``null``,
because JSON knows no NaN, and read as NaN. So is NaN that users give; infinite numbers are refused.
"""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from .._core import InvalidArgument
from ..arguments import given_path, given_word, shown_value
from ..array_file import naming, write_atomically
from ..files import LONGEST_LINE, open_regular
from .given import given_numbers

__all__ = ["SERIES", "Telemetry", "TelemetryError", "TelemetryWriter", "report_to_dict"]

#: Unit of every series that the simulator itself reports; nested groups are written ``group.name``.
SERIES: dict[str, str] = {
    "step": "1",
    "time": "s",
    "time_step": "s",
    "newton_iterations": "1",
    "linear_iterations": "1",
    "factorizations": "1",
    "line_search_backtracks": "1",
    "rejected_steps": "1",
    "contact_count": "1",
    "min_distance": "m",
    "friction_residual": "N",
    "residual": "N",
    "acceleration": "m/s^2",
    "last_motion": "m",
    "wall": "s",
    "energy": "J",
    "contact_energy_at_start": "J",
    "bristle_energy_at_start": "J",
    "momentum": "N s",
    "angular_momentum": "N m s",
    "phases": "s",
    "measured": "SI",
}


class TelemetryError(InvalidArgument):
    """A telemetry file that cannot be read: names file, line and defect."""


def unit_of(name: str) -> str:
    """Unit of a series; ``energy.kinetic`` has the unit of its group ``energy``, and names of the user may
    end with one, ``measured.grip [N]``. Unknown names are dimensionless."""
    name = given_word(name, "telemetry: the name of a series")
    if name.startswith("measured.") and name.endswith("]") and "[" in name:
        return name[name.rindex("[") + 1 : -1]
    return SERIES.get(name) or SERIES.get(name.split(".", 1)[0], "1")


def _plain(value: Any) -> Any:
    """A JSON value: NumPy scalars become numbers, non-finite floats null, enums their names."""
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, Iterable):
        return [_plain(item) for item in value]
    return str(getattr(value, "name", value))


_REPORT_FIELDS = (
    "status",
    "time",
    "time_step",
    "integrator",
    "lasting_contact",
    "newton_iterations",
    "linear_iterations",
    "factorizations",
    "contact_count",
    "min_distance",
    "friction_residual",
    "residual",
    "acceleration",
    "last_motion",
    "energy",
    "contact_energy_at_start",
    "bristle_energy_at_start",
    "line_search_backtracks",
    "rejected_steps",
    "phases",
    "message",
)


def report_to_dict(report: Any) -> dict[str, Any]:
    """The numbers of a ``StepReport`` as a plain dictionary that JSON can hold."""
    if hasattr(report, "to_dict"):
        numbers: dict[str, Any] = _plain(report.to_dict())
        return numbers
    return {name: _plain(getattr(report, name)) for name in _REPORT_FIELDS if hasattr(report, name)}


class TelemetryWriter:
    """Appends one line a step. Each line is handed to the system at once, so a killed run loses at most one
    line. ``kept``: goes on after these lines, see ``first_lines``. ``chain``: gives each line its digest
    (stark.recording.chain)."""

    def __init__(self, path: str | os.PathLike[str], *, kept: bytes = b"", chain: Any = None) -> None:
        self.path: Path = given_path(path, "telemetry: path")
        if not isinstance(kept, bytes):
            raise InvalidArgument(f"telemetry: kept = {shown_value(kept)}: must be bytes, as of first_lines")
        write_atomically(self.path, lambda file: file.write(kept))  # a file of its own, whatever was there
        with naming(self.path):
            self._file = self.path.open("a", encoding="utf-8", buffering=1)
        self._step = kept.count(b"\n")
        self._chain = chain

    @property
    def line_count(self) -> int:
        """Lines so far, those that were kept included."""
        return self._step

    def sync(self) -> None:
        """Returns when all lines are on disk."""
        with naming(self.path):
            self._file.flush()
            os.fsync(self._file.fileno())

    def write(self, report: Any, **extra: float | Mapping[str, float]) -> None:
        """Adds one step; ``extra`` holds further numbers in SI units, for example ``wall`` seconds, or
        groups of them. Raises InvalidArgument for anything but finite numbers and NaN, and writes nothing."""
        line = {"step": self._step, **report_to_dict(report)}
        line |= given_numbers(extra, {**line, "chain": ""})
        text = json.dumps(line, separators=(",", ":"), allow_nan=False)
        if self._chain is not None:
            text = self._chain.add_line(text)
        with naming(self.path):
            self._file.write(text + "\n")
        self._step += 1

    def close(self) -> None:
        """Closes the file. Raises OSError where the disk is full."""
        with naming(self.path):
            self._file.close()

    def __enter__(self) -> TelemetryWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _number(value: Any) -> float:
    """NaN for what is not a number; JSON has integers that no float can hold."""
    try:
        return float(value) if isinstance(value, (int, float)) else math.nan
    except OverflowError:
        return math.nan


def _row(path: Path, number: int, line: str | bytes) -> dict[str, Any]:
    """A line of a file, by number from 1."""
    try:
        row = json.loads(line)
    except (ValueError, RecursionError) as error:
        what = getattr(error, "msg", error)
        raise TelemetryError(f"telemetry '{path}' line {number} is not JSON: {what}") from error
    if not isinstance(row, dict):
        raise TelemetryError(f"telemetry '{path}' line {number} must be a JSON object")
    return row


def _sharing(row: dict[str, Any], keys: dict[str, str]) -> dict[str, Any]:
    """The same with the keys of all rows, which take half of the memory of a long run."""
    return {
        keys.setdefault(key, key): _sharing(value, keys) if isinstance(value, dict) else value
        for key, value in row.items()
    }


def first_lines(path: Path, count: int) -> bytes:
    """So many lines of a file, each a JSON object; those of a file that goes on after them."""
    lines = []
    try:
        with open_regular(path) as file:
            for number in range(count):
                line = file.readline(LONGEST_LINE)
                if not line.endswith(b"\n"):
                    raise TelemetryError(f"telemetry '{path}' has {number} lines: must have {count}")
                _row(path, number + 1, line)
                lines.append(line)
    except OSError as error:
        raise TelemetryError(f"telemetry '{path}' cannot be read: {error.strerror or error}") from error
    return b"".join(lines)


def digest_of_last(lines: bytes) -> str:
    """Digest of the last line and of all before it (stark.recording.chain)."""
    row = json.loads(lines[lines.rfind(b"\n", 0, -1) + 1 :])
    if not isinstance(row.get("chain"), str):
        raise TelemetryError("a line of telemetry lacks its digest; run the scene anew")
    digest: str = row["chain"]
    return digest


def _lines(path: Path) -> Iterable[tuple[int, bytes]]:
    """Lines of a file by number from 1; the last one may lack its end."""
    with open_regular(path) as file:
        number = 0
        while line := file.readline(LONGEST_LINE):
            number += 1
            if len(line) == LONGEST_LINE:
                raise TelemetryError(f"telemetry '{path}' line {number} is longer than {LONGEST_LINE} bytes")
            yield number, line


class Telemetry:
    """The steps of a run as columns: ``telemetry["newton_iterations"]`` is a float64 array with one value a
    step."""

    def __init__(self, rows: list[dict[str, Any]]) -> None:
        self.rows = rows
        self._columns: dict[str, np.ndarray] = {}
        self._names: tuple[int, dict[str, None]] = 0, {}  # of so many rows

    @classmethod
    def read(cls, path: str | os.PathLike[str], *, tolerate_cut_line: bool = False) -> Telemetry:
        """Reads a JSONL file; ``tolerate_cut_line`` leaves out an unfinished last line (a killed run)."""
        path = given_path(path, "telemetry: path")
        rows: list[dict[str, Any]] = []
        keys: dict[str, str] = {}
        try:
            for number, line in _lines(path):
                if line.endswith(b"\n"):
                    rows.append(_sharing(_row(path, number, line), keys))
                elif not tolerate_cut_line:
                    raise TelemetryError(
                        f"telemetry '{path}' line {number} is cut off; copy the run folder again"
                    )
        except OSError as error:
            raise TelemetryError(f"telemetry '{path}' cannot be read: {error.strerror or error}") from error
        for row in rows:
            row.pop("chain", None)
        return cls(rows)

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def names(self) -> list[str]:
        """Names of all numeric series, in order of appearance; groups are flattened to ``group.name``."""
        return list(self._known_names())

    def _known_names(self) -> dict[str, None]:
        """Found once: all rows are gone through, and each column asks for them."""
        count, names = self._names
        if count == len(self.rows):
            return names
        names = {}
        for row in self.rows:
            for key, value in row.items():
                if isinstance(value, dict):
                    names.update({f"{key}.{inner}": None for inner in value})
                elif not isinstance(value, (str, list)):
                    names[key] = None
        self._names = len(self.rows), names
        return names

    def keys(self) -> list[str]:
        """As ``names``: ``dict(telemetry)`` has all series, for ``pandas.DataFrame``."""
        return self.names

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self._known_names()

    def __getitem__(self, name: str) -> np.ndarray:
        """Column of shape (steps,), float64, NaN where a step has no value; a copy."""
        if not isinstance(name, str):
            raise TelemetryError(
                f"telemetry[{name!r}]: must be the name of a series, such as telemetry['time'], which is an "
                "array with one value a step"
            )
        if name not in self._columns:
            if self.rows and name not in self._known_names():
                raise KeyError(f"no series '{name}'; there are: {', '.join(self.names)}")
            group, _, inner = name.partition(".")
            values = []
            for row in self.rows:
                value = row.get(name, row.get(group))
                if isinstance(value, dict):
                    value = value.get(inner)
                values.append(_number(value))
            self._columns[name] = np.array(values, dtype=np.float64)
        return self._columns[name].copy()

    def unit(self, name: str) -> str:
        """Unit of a series in SI symbols, ``1`` for counts."""
        return unit_of(name)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Writes all series as CSV; the header holds ``name [unit]``."""
        names = self.names
        text = io.StringIO(newline="")
        writer = csv.writer(text)
        units = [f" [{self.unit(name)}]" for name in names]
        writer.writerow([name.removesuffix(unit) + unit for name, unit in zip(names, units, strict=True)])
        columns = [self[name] for name in names]
        writer.writerows(
            ["" if math.isnan(value) else repr(float(value)) for value in row]
            for row in zip(*columns, strict=True)
        )
        data = text.getvalue().encode("utf-8", "backslashreplace")
        write_atomically(given_path(path, "to_csv: path"), lambda file: file.write(data))
