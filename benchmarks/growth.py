"""How cost and memory grow with the number of unknowns, for solids and for cloth:

    PYTHONPATH=python python -m benchmarks.growth [solids|cloth ...] [--most UNKNOWNS] [--write]
    PYTHONPATH=python python -m benchmarks.growth --rows FILE --write      # of rows measured before

The scenes are soft_box_drop_40 and cloth_sphere_576 of benchmarks/scenes with fewer cells, on one thread; a
step ends when the largest unbalanced force times the time step is below 1e-6 N s. Each size runs in a
process of its own, whose largest memory less that before the scene is what the scene needs. Times are CPU
seconds of the whole run over its Newton iterations: making of the model and, of the first matrix, the
ordering are in them. Phases are measured by the wall clock, so on a busy machine their shares are rough.
``--write`` makes the page benchmarks/results/growth.md, its plot and its rows."""

from __future__ import annotations

import argparse
import json
import math
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results"
SCENES = {"solids": "soft_box_drop_40", "cloth": "cloth_sphere_576"}
#: Cells along a side: 1e4 to 1e6 unknowns.
SIZES = {"solids": (11, 17, 25, 40, 54), "cloth": (57, 100, 182, 316, 576)}
BARS = {"solids": 1.15, "cloth": 1.3}  # of the slope of time per Newton iteration against unknowns
MEMORY_BAR = 2500.0  # bytes for an unknown of solids; sparse factors of cloth need more
PHASES = ("assemble", "linear_solve", "broad_phase", "active_set", "step_bound", "line_search", "friction")


def unknowns(kind: str, cells: int) -> int:
    """Of a scene, before anything is built."""
    return 3 * ((cells + 1) ** 3 + cells**3 if kind == "solids" else (cells + 1) ** 2)


def peak_bytes() -> int:
    """Largest memory of this process so far."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def measure_row(kind: str, cells: int) -> dict[str, Any]:
    """Runs one size in this process."""
    from stark.cli.bench import measure

    small = 8 if kind == "solids" else 16
    path = ROOT / "benchmarks" / "scenes" / f"{SCENES[kind]}.py"
    measure(str(path), {}, check=False, options={"cells": small})  # what every run needs is loaded
    before = peak_bytes()
    row = measure(str(path), {}, check=False, options={"cells": cells})
    return {"kind": kind, "cells": cells, "bytes": peak_bytes() - before} | row


def run_row(kind: str, cells: int) -> dict[str, Any]:
    """Runs one size in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.growth", "--row", kind, str(cells)]
    output = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    row: dict[str, Any] = json.loads(output)
    return row


def machine_peaks() -> dict[str, float]:
    """What one core reaches [1/s]: single-precision operations in a product of dense matrices, and bytes of a
    sum of arrays larger than any cache. CPU seconds, best of five."""
    import time

    def best(job: Any) -> float:
        seconds = []
        for _ in range(5):
            start = time.process_time()
            job()
            seconds.append(time.process_time() - start)
        return min(seconds)

    a = np.ones((1024, 1024), dtype=np.float32)
    x, y, z = (np.ones(20_000_000) for _ in range(3))
    out = np.empty_like(a)
    flops = 2.0 * 1024**3 / best(lambda: np.matmul(a, a, out=out))
    return {"flops": flops, "bytes": 3 * x.nbytes / best(lambda: np.add(x, y, out=z))}


def slope(rows: list[dict[str, Any]], key: str) -> float:
    """Of a least-squares line through logarithms of a number against those of the unknowns."""
    x = np.log([row["dofs"] for row in rows])
    return float(np.polyfit(x, np.log([per_iteration(row)[key] for row in rows]), 1)[0])


def per_iteration(row: dict[str, Any]) -> dict[str, float]:
    """CPU seconds of a Newton iteration, all and by phase, and bytes for an unknown."""
    seconds = row["cpu_s"] / row["newton_iterations"]
    total = sum(row["phases"].values())
    shares = {name: row["phases"][name] / total for name in PHASES}
    numbers = {name: share * seconds for name, share in shares.items()}
    return numbers | {"all": seconds, "bytes": row["bytes"] / row["dofs"]}


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.growth", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"of {', '.join(SCENES)}; default: both")
    parser.add_argument("--most", type=float, default=math.inf, help="unknowns of the largest scene")
    parser.add_argument("--row", nargs=2, metavar=("KIND", "CELLS"), help="one size, here")
    parser.add_argument(
        "--rows", type=Path, metavar="FILE", help="lines of JSON: rows are read, new ones added"
    )
    parser.add_argument("--write", action="store_true", help="write benchmarks/results/growth.*")
    arguments = parser.parse_args()
    if arguments.row:
        print(json.dumps(measure_row(arguments.row[0], int(arguments.row[1]))))
        return 0
    from benchmarks.growth_page import page, plot

    lines = arguments.rows.read_text().splitlines() if arguments.rows and arguments.rows.exists() else []
    rows = [json.loads(line) for line in lines]
    for kind in arguments.kinds or ([] if rows else SCENES):
        for cells in SIZES[kind]:
            known = any((row["kind"], row["cells"]) == (kind, cells) for row in rows)
            if known or unknowns(kind, cells) > arguments.most:
                continue
            rows.append(run_row(kind, cells))
            print(json.dumps(rows[-1]), flush=True)
            if arguments.rows:
                arguments.rows.write_text("".join(f"{json.dumps(row)}\n" for row in rows))
    text = page(rows, machine_peaks())
    print(text)
    if arguments.write:
        (RESULTS / "growth.md").write_text(text)
        (RESULTS / "growth.json").write_text("".join(f"{json.dumps(row)}\n" for row in rows))
        plot(rows, RESULTS / "growth.svg")
    return any(row["failure"] for row in rows)


if __name__ == "__main__":
    sys.exit(main())
