"""robot_towel_sheet: what a study of robot_towel came to: a picture of each run at its end, and a table.

stark study run examples/robot_towel.toml
python examples/robot_towel_sheet.py out/robot_towel    writes outcomes.png there, and prints the table
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pictures
import robot_towel

import stark
from stark.recording import Recording
from stark.render.overlay import Overlay
from stark.study import Study

WIDTH, HEIGHT, LETTERS = 480, 230, 11.0  # of a picture, of its title [px]
TIMES = (2.0, 3.0, 4.0, 6.0)  # of a sequence [s]
FLOORS = ("carpet", "polished")
OUTCOMES = ("over", "pushed", "stuck")


def rows(study: Study) -> list[dict[str, Any]]:
    """Runs that are complete, with their outcome in words."""
    found = [row for row in study.rows() if row["status"] == "complete"]
    for row in found:
        words = [word for word in OUTCOMES if row[f"observables.{word}"] == 1.0]
        row["outcome"] = words[0] if words else "undecided"
    return found


def table(study: Study) -> str:
    """As Markdown: outcome beside that of the laboratory, ways [m, mm], iterations and CPU time [min] of each
    run."""
    names = ("towel", "floor", "laboratory", "outcome", "robot moved [m]", "towel moved [mm]")
    lines = [f"| {' | '.join(names)} | Newton iterations | CPU [min] |", "|---|---|---|---|--:|--:|--:|--:|"]
    for row in rows(study):
        ways = f"{row['observables.robot_went']:.3f} | {1e3 * row['observables.towel_went']:,.2f}"
        cost = f"{row['newton_iterations']:,} | {row['cost.cpu'] / 60.0:.1f}"
        name = row["option.towel"].replace("_", " ")
        seen = robot_towel.LABORATORY[row["option.towel"]][FLOORS.index(row["option.floor"])]
        lines.append(f"| {name} | {row['option.floor']} | {seen} | {row['outcome']} | {ways} | {cost} |")
    return "\n".join(lines)


def sheet(study: Study, path: Path) -> Path:
    """Two columns, one for each floor: robot and towel at the end of each run."""
    pieces = {(row["option.towel"], row["option.floor"]): _piece(study, row) for row in rows(study)}
    blank = np.full((HEIGHT, WIDTH, 3), 255, dtype=np.uint8)
    towels = list(dict.fromkeys(towel for towel, _ in pieces))
    lines = [np.hstack([pieces.get((towel, floor), blank) for floor in FLOORS]) for towel in towels]
    stark.render.write_png(path, np.vstack(lines))
    return path


def sequence(study: Study, towel: str, floor: str, folder: Path) -> tuple[Path, Path]:
    """Robot and towel of a run at four times, and its curves: torque, suspension, ways."""
    row = next(r for r in rows(study) if (r["option.towel"], r["option.floor"]) == (towel, floor))
    recording = Recording(study.run_folder(row["key"]))
    pieces = [_picture(recording, time, f"{time:g} s") for time in TIMES]
    stark.render.write_png(folder / "sequence.png", np.vstack([np.hstack(pieces[:2]), np.hstack(pieces[2:])]))
    return folder / "sequence.png", robot_towel.plot(recording, folder / "curves.svg")


def _piece(study: Study, row: dict[str, Any]) -> np.ndarray:
    title = f"{row['option.towel'].replace('_', ' ')}, {row['option.floor']}: {row['outcome']}"
    return _picture(Recording(study.run_folder(row["key"])), np.inf, title)


def _picture(recording: Recording, time: float, title: str) -> np.ndarray:
    frame = recording.frame(recording.nearest(time))
    points = np.concatenate([body.positions for body in frame.bodies if body.name != "floor"])
    camera = pictures.fitted_camera(points, -40.0 * stark.deg, 25.0 * stark.deg, WIDTH / HEIGHT)
    over = Overlay(stark.render.render(frame, WIDTH, HEIGHT, camera=camera))
    over.text((10.0, 10.0 + LETTERS), title, LETTERS, halo=2.0)
    return over.picture


def main() -> int:
    study, folder = Study(sys.argv[1]), Path(sys.argv[1])
    if len(sys.argv) == 4:
        print(*sequence(study, sys.argv[2], sys.argv[3], folder), sep="\n")
    else:
        print(table(study), sheet(study, folder / "outcomes.png"), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
