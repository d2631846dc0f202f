"""Runs the bench scenes; prints counts, ratios and the time of each phase, beside the public implementation:

    PYTHONPATH=python python -m benchmarks.scenes [NAME...] [--rule any] [--runs N] [--threads N] [--write]

Counts of iterations scatter, so each scene runs several times, with gravity a little larger from run to run,
and the tables have medians. ``--write`` puts them into benchmarks/results. Run it on a machine that does
nothing else."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from statistics import geometric_mean
from typing import Any, NamedTuple

from stark.cli.bench import measure

RESULTS = Path(__file__).resolve().parents[1] / "results"
PHASES = ("assemble", "linear_solve", "broad_phase", "active_set", "line_search", "step_bound", "stiffness")
#: What certifies that nothing passes through anything.
GUARANTEE = ("broad_phase", "step_bound")


class Public(NamedTuple):
    """STARK 0.1.0 at the same tolerances, one thread, with its kernel cache warm."""

    iterations: int
    cpu_s: float
    ratio: float


#: By the rule of ``stark bench`` and scene.
PUBLIC = {
    "residual": {
        "spinning_box_cloth_32": Public(979, 35.9, 625.0),
        "spinning_box_cloth_64": Public(929, 155.0, 2771.0),
        "spinning_box_cloth_128": Public(189, 102.5, 1908.0),
        "hanging_cloth_50": Public(584, 14.9, 253.0),
        "soft_box_drop_20": Public(49, 12.1, 225.0),
        "rigid_pile_27": Public(173, 0.33, 5.5),
        "cloth_sphere_floor_60": Public(691, 77.7, 1359.0),
        "soft_column_6": Public(373, 18.0, 298.0),
    },
    "any": {
        "spinning_box_cloth_32": Public(1025, 64.5, 600.0),
        "spinning_box_cloth_64": Public(716, 216.0, 2160.0),
        "spinning_box_cloth_128": Public(103, 86.0, 690.0),
        "hanging_cloth_50": Public(544, 24.8, 243.0),
        "soft_box_drop_20": Public(29, 18.5, 160.0),
        "rigid_pile_27": Public(106, 0.62, 4.4),
        "cloth_sphere_floor_60": Public(686, 133.0, 1020.0),
        "soft_column_6": Public(304, 22.0, 211.0),
    },
}
WORDS = {
    "residual": "A step ends when the largest unbalanced force times the time step is below 1e-6 N s.",
    "any": "A step ends when the largest unbalanced force times the time step is below 1e-6 N s, or the next "
    "full Newton step moves no point faster than 1e-3 m/s.",
}


def median_run(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """The run with the middle ratio, with the least and most Newton iterations of all."""
    counts = [run["newton_iterations"] for run in runs]
    middle = sorted(runs, key=lambda run: run["ratio"])[(len(runs) - 1) // 2]
    return middle | {"runs": len(runs), "least_iterations": min(counts), "most_iterations": max(counts)}


def ratios(rows: list[dict[str, Any]], rule: str) -> str:
    """Counts and times against the public implementation."""
    columns = (
        "scene",
        "unknowns",
        "steps",
        "Newton iterations, public",
        "Newton iterations",
        "from, to",
    )
    columns += ("cpu_s, public", "cpu_s", "times as fast")
    columns += ("cpu_s / calib_s, public", "cpu_s / calib_s", "times as fast")
    text = f"| {' | '.join(columns)} |\n|---|{'--:|' * (len(columns) - 1)}\n"
    in_seconds, in_ratios = [], []
    for row in rows:
        public = PUBLIC[rule][row["scene"]]
        in_seconds.append(public.cpu_s / row["cpu_s"])
        in_ratios.append(public.ratio / row["ratio"])
        text += (
            f"| {row['scene']} | {row['dofs']:,} | {row['steps']} | {public.iterations:,} "
            f"| {row['newton_iterations']:,} | {row['least_iterations']:,} to {row['most_iterations']:,} "
            f"| {public.cpu_s:g} | {row['cpu_s']:.3g} | {in_seconds[-1]:.3g} "
            f"| {public.ratio:,g} | {row['ratio']:.3g} | {in_ratios[-1]:.3g} |\n"
        )
    return text + (
        f"\n{WORDS[rule]} Medians of {rows[0]['runs']} runs.\n"
        f"\nGeometric mean: {geometric_mean(in_seconds):.2f} times as fast in CPU seconds, "
        f"{geometric_mean(in_ratios):.2f} in cpu_s / calib_s; "
        f"calib_s was {min(r['calib_s'] for r in rows):.3f} to {max(r['calib_s'] for r in rows):.3f} s.\n"
    )


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
    parser.add_argument("--rule", choices=sorted(PUBLIC), default="residual", help="when a step ends")
    parser.add_argument("--runs", type=int, default=3, help="of each scene (3)")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--write", action="store_true", help="write benchmarks/results")
    arguments = parser.parse_args()
    settings = {"execution.threads": arguments.threads}
    rows = []
    for name in arguments.names or PUBLIC[arguments.rule]:
        runs = []
        for k in range(arguments.runs):
            runs.append(measure(name, settings, check=k == 0, rule=arguments.rule, nudges=k))
            print(json.dumps(runs[-1]), flush=True)
        rows.append(median_run(runs) | {"intersections": runs[0]["intersections"]})
    text = f"{ratios(rows, arguments.rule)}\n## Profile by phase, percent\n\n{profile(rows)}"
    print(text)
    if arguments.write:
        stem = "scenes" if arguments.rule == "residual" else f"scenes_{arguments.rule}"
        (RESULTS / f"{stem}.md").write_text(f"# Bench scenes\n\n{text}")
        (RESULTS / f"{stem}.json").write_text(json.dumps(rows, indent=1) + "\n")
    return any(row["failure"] or row["intersections"] for row in rows)


if __name__ == "__main__":
    sys.exit(main())
