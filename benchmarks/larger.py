"""Runs the larger scenes of benchmarks/scenes, each once in a process of its own, and makes their table:

    PYTHONPATH=python python -m benchmarks.larger [NAME...] [--threads N] [--rows FILE] [--write]

``--rows`` keeps rows between calls: those in the file are not run again. ``--write`` makes
benchmarks/results/larger_scenes.md and the rows beside it. Memory is the largest of the whole process."""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

from benchmarks.scenes.__main__ import profile

ROOT = Path(__file__).resolve().parents[1]
FOLDER, RESULTS = ROOT / "benchmarks" / "scenes", ROOT / "benchmarks" / "results"
#: Names, and when their steps end: those of the arm as its settings say, as a robot would be simulated.
RULES = {
    "arm_ball": "scene",
    "rigid_pile_500": "residual",
    "towel_press": "residual",
    "soft_box_drop_40": "residual",
    "cloth_sphere_576": "residual",
}


def measure_row(name: str, threads: int) -> dict[str, Any]:
    """Runs one scene in this process."""
    from stark.cli.bench import measure

    row = measure(str(FOLDER / f"{name}.py"), {"execution.threads": threads}, rule=RULES[name])
    return row | {"peak_bytes": 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss}


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown: counts and times, profile, observables."""
    columns = ("scene", "unknowns", "steps", "halved", "Newton iterations", "of conjugate gradients")
    columns += (
        "factorisations",
        "CPU s",
        "ms an iteration",
        "cpu_s / calib_s",
        "memory, GB",
        "intersections",
    )
    text = f"| {' | '.join(columns)} |\n|---|{'--:|' * (len(columns) - 1)}\n"
    for row in rows:
        text += (
            f"| {row['scene']} | {row['dofs']:,} | {row['steps']} | {row['rejected_steps']} "
            f"| {row['newton_iterations']:,} | {row['linear_iterations']:,} | {row['factorizations']:,} "
            f"| {row['cpu_s']:.3g} | {1e3 * row['cpu_s'] / row['newton_iterations']:.3g} "
            f"| {row['ratio']:.3g} | {1e-9 * row['peak_bytes']:.2f} | {row['intersections']} |\n"
        )
    text += f"\n## Profile by phase, percent\n\n{profile(rows)}\n## Observables\n\n"
    for row in rows:
        values = ", ".join(f"{name} {value:.5g}" for name, value in row["observables"].items())
        text += f"- {row['scene']}: {values}\n"
    return text


def page(rows: list[dict[str, Any]]) -> str:
    """What is written to benchmarks/results."""
    missing = [name for name in RULES if all(row["scene"] != name for row in rows)]
    left_out = f" Not measured at full size: {', '.join(missing)}." if missing else ""
    return (
        "# Larger scenes\n\n"
        "`python -m benchmarks.larger --write` writes this page; the scenes are [described "
        "here](../README.md#larger-scenes). Each was run once, on one thread. A step ends when the "
        "largest unbalanced force times the step is below 1e-6 N s; a step of the arm ends by its own "
        "settings. CPU seconds, user and system, include model building and were measured on a "
        "machine of two cores that was busy with other programs; the times of phases are shares of "
        "wall time and less accurate. Intersections are states in which the package ipctk finds any; "
        f"memory is that of the whole process, including the states kept for that check.{left_out}\n\n"
        f"{table(rows)}"
    )


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.larger", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="default: all")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--row", metavar="NAME", help="one scene, in this process")
    parser.add_argument(
        "--rows", type=Path, metavar="FILE", help="lines of JSON: rows are read, new ones added"
    )
    parser.add_argument("--write", action="store_true", help="write benchmarks/results/larger_scenes.*")
    arguments = parser.parse_args()
    if arguments.row:
        print(json.dumps(measure_row(arguments.row, arguments.threads)))
        return 0
    lines = arguments.rows.read_text().splitlines() if arguments.rows and arguments.rows.exists() else []
    rows = [json.loads(line) for line in lines]
    for name in arguments.names or ([] if rows else RULES):
        if any(row["scene"] == name for row in rows):
            continue
        command = [
            sys.executable,
            "-m",
            "benchmarks.larger",
            "--row",
            name,
            "--threads",
            str(arguments.threads),
        ]
        output = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
        rows.append(json.loads(output))
        print(output, end="", flush=True)
        if arguments.rows:
            arguments.rows.write_text("".join(f"{json.dumps(row)}\n" for row in rows))
    text = page(rows)
    print(text)
    if arguments.write:
        (RESULTS / "larger_scenes.md").write_text(text)
        (RESULTS / "larger_scenes.json").write_text(json.dumps(rows, indent=1) + "\n")
    return any(row["failure"] or row["intersections"] for row in rows)


if __name__ == "__main__":
    sys.exit(main())
