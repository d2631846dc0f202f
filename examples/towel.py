"""The towel of the robot experiments, 1.35 m x 0.75 m, flat, folded and rolled: where its vertices are.

A sheet that is bent in one direction only keeps all lengths: its rows lie on a curve in a vertical plane
whose edges are as long as those of the flat sheet. Creases are rows. Layers are ``PITCH`` apart, a little
more than the contact distance of terry cloth with itself. Creases that cross are folded by simulation
(fold_towel.py); files beside this one have the results.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

import stark

LENGTH, WIDTH, MASS = 1.35, 0.75, 0.484  # [m], [m], [kg]
PITCH = 1.02 * 2.0 * stark.surfaces.terry_towel.thickness  # of layers [m]
#: Share of the length rolled, outer radius of the roll [m], distance of its turns [m].
ROLLED, ROLL_RADIUS, ROLL_PITCH = 0.85 / 1.35, 0.035, 1.2 * PITCH


def mesh(cells: int) -> stark.mesh.TriangleMesh:
    """The flat towel about the origin, its length along y, with ``cells`` along that."""
    return stark.mesh.grid(WIDTH, LENGTH, cells=(round(cells * WIDTH / LENGTH), cells))


def placed(cells: int, configuration: str) -> np.ndarray:
    """Vertices (n, 3) of the towel before the robot, which comes along +y; the nearest one is at y = 0, the
    lowest at z = 0 [m]."""
    x, y, _ = mesh(cells).vertices.T
    row = np.rint((y / LENGTH + 0.5) * cells).astype(int)
    if configuration.startswith("three_folds"):
        points = _three_folds(cells, configuration)
    elif configuration == "flat":
        points = np.column_stack([y, x, 0.0 * x])
    else:
        curves = {"one_fold": _one_fold, "two_folds": _two_folds}
        along, height = curves.get(configuration, _roll)(cells)
        points = np.column_stack([x, along[row], height[row]])
        if configuration == "roll_open":
            points *= (-1.0, -1.0, 1.0)
        elif configuration == "roll_side":
            points = points[:, [1, 0, 2]]
    points[:, 1:] -= points[:, 1:].min(axis=0)
    return points


def folded_file(cells: int) -> Path:
    """What fold_towel.py writes."""
    return Path(__file__).parent / f"towel_three_folds_{cells}.npz"


def recipe() -> str:
    """Hash of the files that a folded towel follows from."""
    names = ("towel.py", "fold_towel.py")
    return hashlib.sha256(b"".join(Path(__file__).with_name(name).read_bytes() for name in names)).hexdigest()


def _three_folds(cells: int, configuration: str) -> np.ndarray:
    """Two folds halved across: the third crease or the eight free edges face the robot."""
    path = folded_file(cells)
    if not path.exists():
        raise FileNotFoundError(f"{path}: is not there; make it: python examples/fold_towel.py {cells}")
    x, y, z = np.load(path)["positions"].astype(float).T
    sign = {"three_folds_folded": 1.0, "three_folds_open": -1.0}[configuration]
    across = y - 0.5 * (y.min() + y.max())
    return np.column_stack([sign * across, -sign * x, z])


def _one_fold(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Halved; the crease faces the robot."""
    half = cells // 2
    return _creased(cells, {half: 0}, [0.0, PITCH])


def _two_folds(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Halved twice: two nested creases face the robot, the inner one a row further back."""
    quarter = cells // 4
    inner = max(1, round(0.0134 * cells / LENGTH))
    creases = [quarter, 2 * quarter, 3 * quarter - inner]
    return _creased(cells, dict.fromkeys(creases, 0), [0.0, 3.0 * PITCH, 2.0 * PITCH, PITCH])


def _creased(cells: int, creases: dict[int, int], levels: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Rows at the heights of their layers, creases between two; edges keep their length. The first layer goes
    towards the robot."""
    layer, heights, signs = 0, [], []
    for row in range(cells + 1):
        if row in creases:
            heights.append(0.5 * (levels[layer] + levels[layer + 1]))
            layer += 1
        else:
            heights.append(levels[layer])
        signs.append(-1.0 if layer % 2 == 0 else 1.0)
    height = np.array(heights)
    steps = np.sqrt((LENGTH / cells) ** 2 - np.diff(height) ** 2) * np.array(signs[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)]), height


def _roll(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """A spiral, from the inside: up its far side, over the top, down the side that faces the robot, under
    itself, and the tail on the floor behind it."""
    edge = LENGTH / cells
    rolled = round(ROLLED * cells)
    angle, radius, points = 0.0, ROLL_RADIUS, []
    for _ in range(rolled + 1):  # from the outside inwards, by chords of the length of an edge
        points.append((radius * np.sin(angle), -radius * np.cos(angle)))
        low, high, turn = 0.0, np.pi, 0.0
        for _ in range(60):
            turn = 0.5 * (low + high)
            inner = radius - ROLL_PITCH * turn / (2.0 * np.pi)
            chord = np.hypot(inner * np.sin(turn), radius - inner * np.cos(turn))
            low, high = (turn, high) if chord < edge else (low, turn)
        angle, radius = angle + turn, radius - ROLL_PITCH * turn / (2.0 * np.pi)
    spiral = np.array(points[::-1]) * (-1.0, 1.0)
    tail = spiral[-1] + np.arange(1, cells - rolled + 1)[:, None] * (edge, 0.0)
    along, height = np.concatenate([spiral, tail]).T
    return along, height
