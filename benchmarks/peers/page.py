"""The page of the peers: speeds are compared among rows that are accurate enough."""

from __future__ import annotations

from typing import Any, NamedTuple

HEIGHT = 0.15  # of the middles of three layers of cubes [m]


class Case(NamedTuple):
    """What a case is about, its error with the unit it is shown in, and the most that counts as equal."""

    title: str
    words: str
    error: str
    scale: float
    most: float


CASES = {
    "incline_below": Case(
        "Cube on an incline at 0.95 of the limit of friction",
        "A cube of 1 kg must not move (friction 0.5).",
        "creep, µm/s",
        1e6,
        1.0,
    ),
    "incline_above": Case(
        "Cube on an incline at 1.05 of the limit of friction",
        "Its acceleration must be that of Coulomb's law.",
        "error of the acceleration, %",
        1e2,
        1.0,
    ),
    "free_spin": Case(
        "Free rotation",
        "A box of 0.1 x 0.2 x 0.3 m rotates at 10 rad/s about an axis that is not a principal one, for 10 s. "
        "Its angular momentum must not change.",
        "change of the angular momentum, %",
        1e2,
        0.1,
    ),
    "rigid_pile_27": Case(
        "Pile of 27 cubes",
        "The scene rigid_pile_27, 2 s. Three layers of cubes of 0.1 m come to rest. With exact contact, the "
        "mean height of their centres is 150 mm; gaps raise it and penetration lowers it. Overlaps are pairs "
        "of cubes, or of a cube and the floor, that intersect at the end, by the same test for all systems.",
        "error of the mean height, mm",
        1e3,
        0.6,
    ),
    "soft_cube": Case(
        "Soft cube under its own weight",
        "A cube of 0.2 m, 1000 kg/m3, E 100 kPa, Poisson's ratio 0.3 stands on a floor for 1 s. Its loss of "
        "height is compared with that of Stark on 5 x 5 x 5 quadratic hexahedra. Since strains are 2 %, "
        "differences between the material laws account for no more than that.",
        "error of the squash, %",
        1e2,
        10.0,
    ),
}


def with_errors(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows with their errors, in the units of the cases."""
    squash = [row["squash"] for row in rows if row["case"] == "soft_cube" and "reference" in row["settings"]]
    found = []
    for row in rows:
        error = row.get("creep", row.get("error", 0.0))
        if row["case"] == "rigid_pile_27":
            error = abs(row["z_mean"] - HEIGHT)
        if row["case"] == "soft_cube":
            error = abs(row["squash"] / squash[0] - 1.0)
        found.append(row | {"shown": CASES[row["case"]].scale * error})
    return found


def page(rows: list[dict[str, Any]]) -> str:
    """Markdown."""
    systems = ", ".join(dict.fromkeys(row["system"] for row in rows))
    text = (
        "# Beside other simulators\n\n`python -m benchmarks.peers --write` writes this page. "
        f"It compares {systems}; "
        "the other simulators are installed from PyPI in a separate environment and run on the CPU with one "
        "thread. Materials and friction are the same. Settings are those of the documentation of each "
        "simulator; where it recommends others for accuracy, these have rows of their own. The CPU seconds, "
        "user and system, are for the steps of one second of simulated time, on two cores of a shared "
        "machine, and uncertain by a fifth. Only rows whose error is within the bound given with the table "
        "are compared in speed; the cheapest of them is bold.\n"
    )
    rows = with_errors(rows)
    for name, case in CASES.items():
        mine = [row for row in rows if row["case"] == name]
        if mine:
            text += f"\n## {case.title}\n\n{case.words}\n\n{_table(case, mine)}\n{_verdict(case, mine)}"
    return text + (
        "\n## What is not compared\n\nCloth, grips and fast projectiles; Newton, which compiles its kernels "
        "for about a minute of CPU time before its first step on a CPU; a soft cube in PyBullet.\n"
    )


def _equal(case: Case, row: dict[str, Any]) -> bool:
    return bool(row["shown"] <= case.most) and "reference" not in row["settings"]


def _table(case: Case, rows: list[dict[str, Any]]) -> str:
    overlaps = any("overlaps" in row for row in rows)
    columns = ["system", "settings", "CPU s for a second", case.error, f"within {case.most:g}"]
    columns += ["overlaps", "deepest, mm"] if overlaps else []
    text = f"| {' | '.join(columns)} |\n|---|---|{'--:|' * (len(columns) - 2)}\n"
    best = min((row["cpu_s"] for row in rows if _equal(case, row)), default=0.0)
    for row in rows:
        cpu = (
            f"**{row['cpu_s']:.2g}**" if row["cpu_s"] == best and _equal(case, row) else f"{row['cpu_s']:.2g}"
        )
        cells = [
            row["system"],
            row["settings"],
            cpu,
            f"{row['shown']:.2g}",
            "" if "reference" in row["settings"] else "yes" if _equal(case, row) else "no",
        ]
        cells += [f"{row['overlaps']:.0f}", f"{1e3 * row['deepest']:.2g}"] if overlaps else []
        text += f"| {' | '.join(cells)} |\n"
    return text


def _verdict(case: Case, rows: list[dict[str, Any]]) -> str:
    """Who is cheaper at equal accuracy, whoever it is."""
    cheapest: dict[str, float] = {}
    for row in rows:
        if _equal(case, row):
            cheapest[row["system"]] = min(row["cpu_s"], cheapest.get(row["system"], row["cpu_s"]))
    ours = next((cpu for system, cpu in cheapest.items() if system.startswith("Stark")), None)
    lines = []
    for system in dict.fromkeys(row["system"] for row in rows if not row["system"].startswith("Stark")):
        if system not in cheapest or ours is None:
            lines.append(f"{system} is not accurate enough to be compared.")
        elif cheapest[system] < ours:
            lines.append(f"{system} is {ours / cheapest[system]:.1f} times as fast as Stark.")
        else:
            lines.append(f"Stark is {cheapest[system] / ours:.1f} times as fast as {system}.")
    return " ".join(lines) + "\n"
