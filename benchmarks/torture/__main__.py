"""Runs the scenes at full size, or many random ones, and prints what became of them:

    PYTHONPATH=python python -m benchmarks.torture [NAME...] [--small] [--write]
    PYTHONPATH=python python -m benchmarks.torture random --count 2000 --seed 1 [--first N] [--kinds KIND...]
    PYTHONPATH=python python -m benchmarks.torture random --count 0 --rows FILE --write     # of what was run

Scene N of a seed is of kind N modulo the number of kinds.
``--write`` puts tables into benchmarks/results."""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

import stark

from .campaign import PATIENCE, read, run_campaign, summary
from .case import run
from .random_kinds import KINDS
from .scenes import CASES

RESULTS = Path(__file__).resolve().parents[1] / "results"
_COLUMNS = (
    *("scene", "steps", "iterations", "most in a step", "retries", "contacts", "smallest gap / d"),
    *("ways not straight (open)", "CPU s", "outcome", "hash"),
)
_HEADER = f"| {' | '.join(_COLUMNS)} |\n|---|{'--:|' * 8}---|---|\n"


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown."""
    lines = []
    for row in rows:
        gap = f"{row['gap']:.2g}" if math.isfinite(row["gap"]) else "-"
        outcome = row["status"] if not row["problems"] else f"**{row['problems'][0]}**"
        ways = f"{row['around'] + row['open']} ({row['open']})"
        cells = [row["name"], row["steps"], row["iterations"], row["most_iterations"], row["retries"]]
        cells += [row["contacts"], gap, ways, f"{row['seconds']:.2f}", outcome, f"`{row['hash'][:12]}`"]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return _HEADER + "\n".join(lines) + "\n"


def run_scenes(names: list[str], full: bool) -> list[dict[str, Any]]:
    rows = []
    for name in names or CASES:
        case = CASES[name]
        rows.append(run(name, case.build(full)).row())
        print(table(rows[-1:]).removeprefix(_HEADER), end="", flush=True)
    return rows


def write(name: str, title: str, text: str, rows: Any) -> None:
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / f"{name}.md").write_text(f"# {title}\n\n{text}")
    data = json.dumps(_finite(rows), indent=1, allow_nan=False)
    (RESULTS / f"{name}.json").write_text(data + "\n")


def _finite(value: Any) -> Any:
    """JSON has no infinity."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.torture", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="scenes of the list, or `random`")
    parser.add_argument("--small", action="store_true", help="the size of the tests")
    parser.add_argument("--write", action="store_true", help="write benchmarks/results")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", nargs="+", choices=list(KINDS), default=list(KINDS), metavar="KIND")
    parser.add_argument("--patience", type=float, default=PATIENCE, help="CPU seconds for a scene")
    parser.add_argument("--rows", type=Path, help="file to which random scenes are appended, one a line")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", stark.StarkWarning)
    if arguments.names == ["random"]:
        with tempfile.TemporaryDirectory() as folder:
            path = arguments.rows or Path(folder) / "rows.jsonl"
            span = arguments.seed, arguments.first, arguments.count
            run_campaign(*span, path, arguments.kinds, arguments.patience)
            rows = read(path)  # also of what ran before
        counts = {"seed": arguments.seed, "patience": arguments.patience, **summary(rows)}
        text = json.dumps(_finite(counts), indent=1)
        print(text)
        if arguments.write:
            write("torture_random", "Random scenes", f"```json\n{text}\n```\n", counts)
        return 1 if any(row["status"] in ("exception", "crash") for row in rows) else 0
    unknown = [name for name in arguments.names if name not in CASES]
    if unknown:
        parser.error(f"no scene is called {', '.join(unknown)}; there are {', '.join(CASES)}, and random")
    rows = run_scenes(arguments.names, full=not arguments.small)
    if arguments.write:
        write("torture", "Torture scenes", table(rows), rows)
    return 1 if any(row["problems"] for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
