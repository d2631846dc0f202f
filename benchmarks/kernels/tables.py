"""Runs bench_kernels and bench_potentials and writes their tables into README.md beside this file.

python benchmarks/kernels/tables.py build/bench/benchmarks/kernels
"""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from pathlib import Path

README = Path(__file__).with_name("README.md")

# EGH of the public implementation, STARK 0.1.0, in ns per element: the path that its solver takes (scalar
# code, double, one thread) on a Xeon of the Cascade Lake generation at 2.5 GHz.
PUBLIC_EGH = {
    "tet_nh": 273, "tet_snh": 275, "tet_full": 1653, "shell": 1096,
    "ee": 738, "pt": 780, "hinge": 681, "rbee": 1489,
}  # fmt: skip


def run(program: Path) -> list[dict]:
    done = subprocess.run([program, "--json"], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def machine_backends(rows: list[dict]) -> list[str]:
    return [b for b in ("avx2", "avx512") if any(row["backend"] == b for row in rows)]


def kernel_table(rows: list[dict]) -> str:
    backends = machine_backends(rows)
    by = {(row["energy"], row["backend"]): row for row in rows}
    names = list(dict.fromkeys(row["energy"] for row in rows))
    head = ["energy"]
    for b in backends:
        head += [f"E {b}", f"EG {b}", f"EGH {b}"]
    head += ["EGH int.", "operations EGH", "instructions EGH", "build EGH [ms]", "EGH public"]
    head += [f"public / {b}" for b in backends]
    lines = [head, ["---", *["--:"] * (len(head) - 1)]]
    ratios: dict[str, list[float]] = {b: [] for b in backends}
    for name in names:
        line = [name]
        for b in backends:
            line += [f"{t:.1f}" for t in by[name, b]["ns"]]
        best = by[name, backends[-1] if backends else "interpreter"]
        line += [f"{by[name, 'interpreter']['ns'][2]:.0f}", str(best["operations"][2])]
        line += [str(best["instructions"][2]), f"{best['build_ms'][2]:.1f}", str(PUBLIC_EGH[name])]
        for b in backends:
            ratios[b].append(PUBLIC_EGH[name] / by[name, b]["ns"][2])
            line.append(f"{ratios[b][-1]:.1f}")
        lines.append(line)
    means = [f"{math.exp(sum(map(math.log, ratios[b])) / len(names)):.1f}" for b in backends]
    lines.append(["geometric mean", *[""] * (len(head) - 1 - len(means)), *means])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def potential_table(rows: list[dict]) -> str:
    backends = ["interpreter", *machine_backends(rows)]
    by = {(row["potential"], row["backend"]): row for row in rows}
    head = ["potential"]
    for b in backends[1:] + backends[:1]:
        head += [f"{order} {b.replace('interpreter', 'int.')}" for order in ("E", "EG", "EGH")]
    lines = [head, ["---", *["--:"] * (len(head) - 1)]]
    for name in dict.fromkeys(row["potential"] for row in rows):
        line = [name]
        for b in backends[1:] + backends[:1]:
            line += [f"{t:.1f}" for t in by[name, b]["ns"]]
        lines.append(line)
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def replace_table(text: str, first_column: str, table: str) -> str:
    pattern = re.compile(rf"^\| {first_column} \|.*\n(?:\|.*\n)+", re.MULTILINE)
    if not pattern.search(text):
        raise SystemExit(f"{README} has no table whose first column is '{first_column}'")
    return pattern.sub(lambda _: table + "\n", text, count=1)


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    text = replace_table(README.read_text(), "energy", kernel_table(run(folder / "bench_kernels")))
    text = replace_table(text, "potential", potential_table(run(folder / "bench_potentials")))
    README.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
