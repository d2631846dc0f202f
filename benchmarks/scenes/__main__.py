"""Runs the bench scenes; prints counts, ratios and the time of each phase, beside the public implementation:

    PYTHONPATH=python python -m benchmarks.scenes [NAME...] [--threads N] [--write]

``--write`` puts the tables into benchmarks/results. Run it on a machine that does nothing else."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any, NamedTuple

from stark.cli.bench import measure

RESULTS = Path(__file__).resolve().parents[1] / "results"
PHASES = ("assemble", "linear_solve", "broad_phase", "active_set", "line_search", "step_bound", "stiffness")
#: What certifies that nothing passes through anything.
GUARANTEE = ("broad_phase", "step_bound")


class Public(NamedTuple):
    """STARK 0.1.0 at the same tolerances, one thread, with its kernel cache warm."""

    iterations: int
    ratio: float


PUBLIC = {
    "spinning_box_cloth_32": Public(1025, 600.0),
    "spinning_box_cloth_64": Public(716, 2160.0),
    "spinning_box_cloth_128": Public(103, 690.0),
    "hanging_cloth_50": Public(544, 243.0),
    "soft_box_drop_20": Public(29, 160.0),
    "rigid_pile_27": Public(106, 4.4),
    "cloth_sphere_floor_60": Public(686, 1020.0),
    "soft_column_6": Public(304, 211.0),
}


def geometric_mean(values: list[float]) -> float:
    return math.exp(sum(map(math.log, values)) / len(values))


def ratios(rows: list[dict[str, Any]]) -> str:
    """Counts and times against the public implementation."""
    text = (
        "| scene | unknowns | steps | Newton iterations, public | Newton iterations "
        "| cpu_s / calib_s, public | cpu_s / calib_s | times as fast |\n|---|--:|--:|--:|--:|--:|--:|--:|\n"
    )
    factors = []
    for row in rows:
        public = PUBLIC[row["scene"]]
        factors.append(public.ratio / row["ratio"])
        text += (
            f"| {row['scene']} | {row['dofs']:,} | {row['steps']} | {public.iterations:,} "
            f"| {row['newton_iterations']:,} | {public.ratio:,g} | {row['ratio']:.3g} | {factors[-1]:.3g} |\n"
        )
    return text + f"\nGeometric mean: {geometric_mean(factors):.2f} times as fast.\n"


def profile(rows: list[dict[str, Any]]) -> str:
    """Shares of the time of the steps, in percent."""
    text = "| scene | " + " | ".join(p.replace("_", " ") for p in PHASES) + " | other | guarantee |\n"
    text += "|---|" + "--:|" * (len(PHASES) + 2) + "\n"
    for row in rows:
        total = sum(row["phases"].values())
        shares = {name: 100.0 * seconds / total for name, seconds in row["phases"].items()}
        cells = [f"{shares[p]:.1f}" for p in PHASES]
        cells.append(f"{100.0 - sum(shares[p] for p in PHASES):.1f}")
        cells.append(f"{sum(shares[p] for p in GUARANTEE):.1f}")
        text += f"| {row['scene']} | " + " | ".join(cells) + " |\n"
    return text


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scenes", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="default: all")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--write", action="store_true", help="write benchmarks/results")
    arguments = parser.parse_args()
    rows = []
    for name in arguments.names or PUBLIC:
        rows.append(measure(name, {"execution.threads": arguments.threads}))
        print(json.dumps(rows[-1]), flush=True)
    text = f"{ratios(rows)}\n## Profile by phase, percent\n\n{profile(rows)}"
    print(text)
    if arguments.write:
        (RESULTS / "scenes.md").write_text(f"# Bench scenes\n\n{text}")
        (RESULTS / "scenes.json").write_text(json.dumps(rows, indent=1) + "\n")
    return any(row["failure"] or row["intersections"] for row in rows)


if __name__ == "__main__":
    sys.exit(main())
