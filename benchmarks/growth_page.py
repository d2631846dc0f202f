"""The page and the plot of benchmarks/growth.py."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

from benchmarks.growth import BARS, MEMORY_BAR, PHASES, per_iteration, slope

COLOURS = {"solids": "#c2571a", "cloth": "#1f6f8b"}
LARGEST = 1_000_000  # unknowns
WORDS = {"assemble": "assembly"}
WIDTH, HEIGHT, MARGIN = 420, 320, 58  # of a panel [px]


def page(rows: list[dict[str, Any]], peaks: dict[str, float]) -> str:
    """Markdown."""
    text = (
        "# Growth with the number of unknowns\n\n"
        "`python -m benchmarks.growth --write` writes this page. The solid is that of `soft_box_drop_40`, "
        "a cube that hits a floor, and the cloth that of `cloth_sphere_576`, which meets a sphere, both of "
        "[benchmarks/scenes](../README.md#larger-scenes), with fewer cells for the smaller sizes. The runs "
        "use one thread. A step ends when the largest unbalanced force times the step is below 1e-6 N s. "
        "Times per iteration are the CPU seconds, user and system, of the whole run, including model "
        "building and the first ordering, divided by its Newton iterations. The machine had two cores and "
        "was busy with other programs, so each time is uncertain by about a fifth; counts of iterations "
        "are exact. The times of phases are shares of wall time and less accurate. Memory is the peak of "
        "the process minus the memory before the scene.\n\n"
        "![CPU time of a Newton iteration and memory against unknowns](growth.svg)\n"
    )
    for kind in BARS:
        mine = sorted((row for row in rows if row["kind"] == kind), key=lambda row: row["dofs"])
        if len(mine) > 1:
            text += f"\n## {kind.capitalize()}\n\n{_table(mine)}\n{_verdict(kind, mine)}\n{_phases(mine)}"
    return text + "\n## Distance to the peak of the machine\n\n" + _peak(rows, peaks)


def _table(rows: list[dict[str, Any]]) -> str:
    columns = ("unknowns", "steps", "Newton iterations", "of conjugate gradients", "factorisations", "CPU s")
    columns += ("ms an iteration", "µs an unknown", "slope from the row above", "kB an unknown")
    text = f"| {' | '.join(columns)} |\n|{'--:|' * len(columns)}\n"
    for before, row in pairwise([None, *rows]):
        found = per_iteration(row)
        local = f"{slope([before, row], 'all'):.2f}" if before else ""
        text += (
            f"| {row['dofs']:,} | {row['steps']} | {row['newton_iterations']} | {row['linear_iterations']:,} "
            f"| {row['factorizations']} | {row['cpu_s']:.3g} | {1e3 * found['all']:.3g} "
            f"| {1e6 * found['all'] / row['dofs']:.2f} | {local} | {1e-3 * found['bytes']:.2f} |\n"
        )
    return text


def _verdict(kind: str, rows: list[dict[str, Any]]) -> str:
    found, bar = slope(rows, "all"), BARS[kind]
    most = max(row["bytes"] / row["dofs"] for row in rows[-2:])
    cost = "met" if found <= bar else "not met"
    memory = "met" if most <= MEMORY_BAR else "not met"
    bar_of_memory = f"; the bar of {1e-3 * MEMORY_BAR:.1f} kB is **{memory}**" if kind == "solids" else ""
    return (
        f"From {rows[0]['dofs']:,} to {rows[-1]['dofs']:,} unknowns the time of an iteration grows with the "
        f"power {found:.2f}. The bar of {bar} is **{cost}**. The two largest need up to {1e-3 * most:.2f} kB "
        f"for an unknown{bar_of_memory}. {_bound(rows)}{_missing(rows)}\n"
    )


def _missing(rows: list[dict[str, Any]]) -> str:
    """A sentence where the largest size was not measured."""
    if rows[-1]["dofs"] > 0.9 * LARGEST:
        return ""
    return f" The bars are meant up to {LARGEST:,} unknowns: larger sizes than those above were not measured."


def _bound(rows: list[dict[str, Any]]) -> str:
    """What the largest size spends its time on, and iterations of conjugate gradients for one of Newton."""
    found = per_iteration(rows[-1])
    shares = sorted(
        ((found[name] / found["all"], WORDS.get(name, name.replace("_", " "))) for name in PHASES),
        reverse=True,
    )
    text = f"The largest spends {100 * shares[0][0]:.0f} % on the {shares[0][1]} and "
    text += f"{100 * shares[1][0]:.0f} % on the {shares[1][1]}."
    first, last = (row["linear_iterations"] / row["newton_iterations"] for row in (rows[0], rows[-1]))
    if rows[-1]["factorizations"] == 0:
        text += (
            f" An iteration takes {first:.0f} of conjugate gradients at the smallest size, {last:.0f} at the "
        )
        text += "largest."
    return text


def _phases(rows: list[dict[str, Any]]) -> str:
    """Milliseconds of an iteration by phase, and the slope of each over all sizes."""
    names = [name for name in PHASES if all(row["phases"][name] > 0.0 for row in rows)]
    text = f"| ms an iteration | {' | '.join(name.replace('_', ' ') for name in names)} |\n"
    text += f"|--:|{'--:|' * len(names)}\n"
    for row in rows:
        found = per_iteration(row)
        text += f"| {row['dofs']:,} | " + " | ".join(f"{1e3 * found[name]:.3g}" for name in names) + " |\n"
    return text + "| slope | " + " | ".join(f"{slope(rows, name):.2f}" for name in names) + " |\n"


def matrix_bytes(row: dict[str, Any]) -> float:
    """Of the matrix without contact in single precision: a block of 3 x 3 for each node and for each pair of
    nodes that an element has, which is kept once. A cell has 12 tetrahedra, two nodes and 14 pairs, or two
    triangles, one node and three pairs; bending adds three pairs across edges."""
    n = row["dofs"] / 3
    return 36.0 * n * (1.0 + 7.0 if row["kind"] == "solids" else 1.0 + 6.0)


def _peak(rows: list[dict[str, Any]], peaks: dict[str, float]) -> str:
    text = (
        f"{_vectors()}One core of this machine reached {1e-9 * peaks['flops']:.0f} billion operations a "
        "second in a product of dense matrices in single precision and "
        f"{1e-9 * peaks['bytes']:.1f} GB/s in a sum of long arrays, measured by NumPy while the machine was "
        "busy. The rate of the factorisation is printed by `bench_linalg`.\n"
    )
    iterative = [row for row in rows if row["linear_iterations"] > 20 * row["newton_iterations"]]
    if not iterative:
        return text
    text += (
        "\nConjugate gradients have to read the matrix once an iteration. What they took, preconditioner, "
        "coarse space and set-up included, against reading it at the speed above:\n\n"
        "| unknowns | matrix, MB | ms an iteration | ms to read the matrix | times the least |\n"
        "|--:|--:|--:|--:|--:|\n"
    )
    for row in sorted(iterative, key=lambda row: row["dofs"]):
        share = row["phases"]["linear_solve"] / sum(row["phases"].values())
        taken, least = share * row["cpu_s"] / row["linear_iterations"], matrix_bytes(row) / peaks["bytes"]
        text += (
            f"| {row['dofs']:,} | {1e-6 * matrix_bytes(row):.0f} | {1e3 * taken:.3g} | {1e3 * least:.3g} "
            f"| {taken / least:.1f} |\n"
        )
    return text


def _vectors() -> str:
    """A sentence on the widest vectors of the processor, where Linux says it."""
    try:
        has_wide = " avx512f " in Path("/proc/cpuinfo").read_text()
    except OSError:
        return ""
    return f"The processor has vectors of {512 if has_wide else 256} bits. "


def plot(rows: list[dict[str, Any]], path: Path) -> None:
    """Two panels with logarithmic axes: time of an iteration and memory for an unknown against unknowns."""
    panels = [("CPU ms of a Newton iteration", "all", 1e3), ("kB for an unknown", "bytes", 1e-3)]
    parts = [_panel(rows, k, *panel) for k, panel in enumerate(panels)]
    size = f'width="{2 * WIDTH}" height="{HEIGHT}" viewBox="0 0 {2 * WIDTH} {HEIGHT}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="12">'
    white = f'<rect width="{2 * WIDTH}" height="{HEIGHT}" fill="white"/>'
    path.write_text("\n".join([head, white, *parts, "</svg>"]) + "\n")


def _panel(rows: list[dict[str, Any]], number: int, title: str, key: str, scale: float) -> str:
    x = [math.log10(row["dofs"]) for row in rows]
    y = [math.log10(scale * per_iteration(row)[key]) for row in rows]
    low, high = (math.floor(min(x)), math.floor(min(y))), (math.ceil(max(x)), math.ceil(max(y)))
    left = number * WIDTH + MARGIN

    def at(u: float, v: float) -> tuple[float, float]:
        along, up = (u - low[0]) / (high[0] - low[0]), (v - low[1]) / max(1, high[1] - low[1])
        return left + along * (WIDTH - MARGIN - 40), HEIGHT - MARGIN + 14 - up * (HEIGHT - MARGIN - 26)

    parts = [f'<text x="{left}" y="22">{title}</text>']
    for u in range(low[0], high[0] + 1):
        px, (_, bottom), (_, top) = at(u, low[1])[0], at(u, low[1]), at(u, high[1])
        parts.append(f'<line x1="{px:.1f}" y1="{bottom:.1f}" x2="{px:.1f}" y2="{top:.1f}" stroke="#ddd"/>')
        parts.append(f'<text x="{px:.1f}" y="{bottom + 16:.1f}" text-anchor="middle">{10**u:,}</text>')
    for v in range(low[1], high[1] + 1):
        (px, py), (end, _) = at(low[0], v), at(high[0], v)
        parts.append(f'<line x1="{px:.1f}" y1="{py:.1f}" x2="{end:.1f}" y2="{py:.1f}" stroke="#ddd"/>')
        parts.append(f'<text x="{px - 6:.1f}" y="{py + 4:.1f}" text-anchor="end">{10.0**v:g}</text>')
    for k, (kind, colour) in enumerate(COLOURS.items()):
        mine = sorted(
            (row["dofs"], u, v) for row, u, v in zip(rows, x, y, strict=True) if row["kind"] == kind
        )
        points = [at(u, v) for _, u, v in mine]
        line = " ".join(f"{px:.1f},{py:.1f}" for px, py in points)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"/>')
        parts += [f'<circle cx="{px:.1f}" cy="{py:.1f}" r="3.5" fill="{colour}"/>' for px, py in points]
        parts.append(f'<text x="{left + 10}" y="{56 + 16 * k}" fill="{colour}">{kind}</text>')
    return "\n".join(parts)
