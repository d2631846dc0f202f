"""The table of a study: a row for each run, as CSV or Parquet."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..array_file import write_atomically

Row = dict[str, Any]

#: Columns that say what a run took. All others are the same whenever and wherever a study is made.
COST = ("cost.wall", "cost.cpu", "cost.attempts", "cost.host")

_COUNTS = ("simulated", "steps", "rejected_steps", "newton_iterations", "max_contacts", "state_hash")


def row(index: int, key: str, repetition: int, options: Mapping[str, Any], status: str) -> Row:
    """What is known of a run before it is over."""
    chosen = {f"option.{name}": value for name, value in options.items()}
    return {"run": index, "key": key, **chosen, "repetition": repetition, "status": status, "message": ""}


def with_result(known: Row, result: Mapping[str, Any], attempts: int) -> Row:
    """The row of a run that is over; times in s."""
    made = dict(known)
    made.update(status=result["status"], message=result["message"])
    for kind in ("observables", "measured"):
        made.update({f"{kind}.{name}": value for name, value in sorted(result[kind].items())})
    made.update({name: result[name] for name in _COUNTS})
    cost = {"wall": result["wall"], "cpu": result["cpu"], "attempts": attempts, "host": result["host"]}
    made.update({f"cost.{name}": value for name, value in cost.items()})
    return made


def columns(rows: Iterable[Row]) -> list[str]:
    """Names of all columns, in one order: run, options, how it ended, observables, measured, counts, cost."""
    names = dict.fromkeys(name for line in rows for name in line)
    groups = ("run", "key", "option.", "repetition", "status", "message", "observables.", "measured.")
    order = [*groups, *_COUNTS, "cost."]

    def rank(name: str) -> int:
        return next(k for k, start in enumerate(order) if name == start or name.startswith(start))

    return sorted(names, key=rank)


def write_csv(path: Path, rows: Sequence[Row]) -> None:
    """Numbers have all their digits; what a run does not have is empty."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns(rows), restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_atomically(path, lambda file: file.write(text.getvalue().encode("utf-8")))


def write_parquet(path: Path, rows: Sequence[Row]) -> None:
    """Raises ImportError without pyarrow."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise ImportError("Parquet needs pyarrow: pip install 'stark-sim[sweep]'") from None
    table = pyarrow.table({name: _alike([line.get(name) for line in rows]) for name in columns(rows)})
    write_atomically(path, lambda file: parquet.write_table(table, file))


def _alike(values: list[Any]) -> list[Any]:
    """Values of one type: a column of numbers and texts becomes texts."""
    kinds = {type(value) for value in values if value is not None}
    if len(kinds) < 2 or kinds == {int, float}:
        return values if kinds != {int, float} else [None if v is None else float(v) for v in values]
    return [None if value is None else str(value) for value in values]
