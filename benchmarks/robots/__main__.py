"""Reads every robot of some packages, compares it with pinocchio and mujoco, and prints what became of it:

    PYTHONPATH=python python -m benchmarks.robots [PACKAGE...] [--only TEXT] [--write]

``--write`` puts the table into benchmarks/results. Packages that are not installed are left out:
``pip install pin example-robot-data robosuite gymnasium-robotics dm-control pybullet metaworld``."""

from __future__ import annotations

import argparse
import contextlib
import io
import logging
import sys
from pathlib import Path

from .compare import QUANTITIES, Row, compare
from .sources import robot_files

RESULTS = Path(__file__).resolve().parents[1] / "results"
_HEADER = (
    f"| package | file | links | coordinates | {' | '.join(QUANTITIES)} | outcome |\n"
    f"|---|---|--:|--:|{'--:|' * len(QUANTITIES)}---|\n"
)


def line(row: Row) -> str:
    """Of the table."""
    numbers = [f"{row.differences[name]:.0e}" if name in row.differences else "" for name in QUANTITIES]
    outcome = row.outcome.replace("|", "/").replace("\n", " ")
    outcome = outcome if len(outcome) < 160 else f"{outcome[:157]}..."
    cells = [row.package, row.file, row.links or "", row.coordinates or "", *numbers, outcome]
    return f"| {' | '.join(map(str, cells))} |"


def text(rows: list[Row]) -> str:
    """Markdown."""
    agree = [row for row in rows if row.outcome == "agrees"]
    packages = {row.package for row in agree}
    what = f"{len(agree)} of {len(rows)} files of {len(packages)} packages"
    return (
        "# Robots of packages\n\n"
        f"{what} agree with pinocchio (URDF) and mujoco (MJCF) within 1e-9. The table gives the largest "
        "differences of masses [kg], centres of mass [m], inertias [kg m^2], "
        "frames [m, 1] and gravity efforts [N m, N] at 20 random q, and of the frames in the scene. "
        "`python -m benchmarks.robots --write` writes this page.\n\n"
        + _HEADER
        + "\n".join(map(line, rows))
        + "\n"
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("packages", nargs="*")
    parser.add_argument("--only", default="", help="files whose path has this text")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    logging.disable(logging.WARNING)  # readers of meshes warn about textures
    rows = []
    for package, root, file in robot_files(given.packages):
        if given.only in str(file):
            with contextlib.redirect_stdout(io.StringIO()):
                rows.append(compare(package, root, file))
            print(line(rows[-1]), flush=True)
    if given.write:
        (RESULTS / "robots.md").write_text(text(rows))
    wrong = [row for row in rows if row.outcome.startswith("differs")]
    print(f"{len(rows)} files, {len(wrong)} differ")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
