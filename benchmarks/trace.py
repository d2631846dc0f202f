"""Every Newton iteration of a scene: how far it went, what held it back, what it gained.

    PYTHONPATH=python python -m benchmarks.trace soft_column_6 [--steps FROM TO] [--until T] [--csv FILE]

The scene is a file, a packaged scene or one of benchmarks/scenes, by name. One line for each iteration of the
steps asked for:

  kind       exact or projected Hessian; `again`: the last factors, no new matrix; `+n` for n iterations of
             conjugate gradients
  bound      largest share of the full step that collision detection and the limit of rotations allow
  length     share that was taken; below the bound after backtracking, above 1 where the matrix was too stiff
  gain       decrease of the energy over that of the quadratic model along the share that was taken: 1 where
             the model is right
  motion     of the full step, its fastest vertex [m];  residual [N];  contacts: pairs within contact distance
  cause      what kept the iteration from being the last: `bound`, `backtracked`, `projected`, `friction` (the
             limits were refreshed after it), `slow` (a full step that gained less than half of the model's)

The summary counts iterations by cause. Tolerances are those of the table of scenes: residual only."""

from __future__ import annotations

import argparse
import csv
import sys
from collections import Counter
from typing import Any

from benchmarks.larger import FOLDER, RULES

import stark
from stark.cli.settings_arguments import add_setting_arguments, parse_settings
from stark.scenes import load
from stark.scenes.runner import end_time
from stark.steps import reached

COLUMNS = (
    "step",
    "attempt",
    "iteration",
    "kind",
    "bound",
    "length",
    "gain",
    "motion",
    "residual",
    "contacts",
)
COUNTERS = (
    "iterations",
    "backtracks",
    "projected_iterations",
    "factorizations",
    "linear_iterations",
    "refreshes",
)
FREE = 0.999  # of a full step: what is not held back


class Trace:
    """Rows of one step, made of what the progress of the step shows between two iterations."""

    def __init__(self) -> None:
        self.rows: list[dict[str, Any]] = []
        self._before: dict[str, int] = {}

    def __call__(self, progress: stark.StepProgress) -> None:
        now = {name: getattr(progress, name) for name in COUNTERS}
        before = self._before
        self._before = now
        attempt_begins = not before or now["factorizations"] + now["linear_iterations"] == 0
        if attempt_begins or now == before:
            return
        change = {name: now[name] - before[name] for name in COUNTERS}
        share, slope = progress.step_length, progress.slope
        promised = slope * (share - 0.5 * share**2)
        self.rows.append(
            {
                "step": progress.step,
                "attempt": progress.attempt,
                "iteration": now["iterations"],
                "kind": _kind(change),
                "bound": progress.bound,
                "length": share,
                "gain": progress.difference / promised if promised else 0.0,
                "motion": progress.last_motion,
                "residual": progress.residual,
                "contacts": progress.contacts,
                "cause": _cause(change, progress, promised),
            }
        )


def _kind(change: dict[str, int]) -> str:
    kind = "projected" if change["projected_iterations"] else "exact"
    if change["factorizations"] == 0 and change["linear_iterations"] == 0:
        kind = "again"
    return kind + (f"+{change['linear_iterations']}" if change["linear_iterations"] else "")


def _cause(change: dict[str, int], progress: stark.StepProgress, promised: float) -> str:
    if progress.bound < FREE:
        return "bound"
    if change["backtracks"]:
        return "backtracked"
    if change["refreshes"]:
        return "friction"
    if change["projected_iterations"]:
        return "projected"
    return "slow" if progress.difference > 0.5 * promised else ""


def trace(
    name: str, settings: dict[str, Any], until: float | None, steps: range | None
) -> list[dict[str, Any]]:
    """Rows of all iterations of the steps asked for; all steps without `steps`."""
    larger = FOLDER / f"{name}.py"
    scene_file = load(larger if name in RULES else name)
    end = end_time(scene_file, until)
    scene, own = scene_file.build()
    sim = stark.Simulation(scene, **{**own, "newton.step_tolerance": 0.0, "execution.threads": 1, **settings})
    rows: list[dict[str, Any]] = []
    while not reached(sim, end):
        scene_file.drive(sim)
        step = Trace()
        report = sim._step(None, step, period=0.0)
        if steps is None or report.step in steps:
            rows += step.rows
        if report.failed:
            print(f"step {report.step} failed: {report.message}", file=sys.stderr)
            break
    return rows


def text_of(row: dict[str, Any]) -> str:
    return (
        f"{row['step']:5} {row['attempt']:2} {row['iteration']:4} {row['kind']:>14} {row['bound']:8.4f} "
        f"{row['length']:8.4f} {row['gain']:7.3f} {row['motion']:9.2e} {row['residual']:9.2e} "
        f"{row['contacts']:8} {row['cause']}"
    )


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.trace", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("scene")
    parser.add_argument(
        "--until", type=float, metavar="T", help="simulated time [s]; default: the scene's own"
    )
    parser.add_argument("--steps", type=int, nargs=2, metavar=("FROM", "TO"), help="steps to list, from 1")
    parser.add_argument("--csv", metavar="FILE", help="write the rows there instead of listing them")
    add_setting_arguments(parser)
    arguments = parser.parse_args()
    steps = range(arguments.steps[0], arguments.steps[1] + 1) if arguments.steps else None
    rows = trace(arguments.scene, parse_settings(arguments), arguments.until, steps)
    if arguments.csv:
        with open(arguments.csv, "w", newline="") as file:
            writer = csv.DictWriter(file, [*COLUMNS, "cause"])
            writer.writeheader()
            writer.writerows(rows)
    else:
        print(" step  a iter           kind    bound   length    gain    motion  residual contacts cause")
        print("\n".join(text_of(row) for row in rows))
    causes = Counter(row["cause"] or "none" for row in rows)
    print(f"{len(rows)} iterations: " + ", ".join(f"{n} {cause}" for cause, n in causes.most_common()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
