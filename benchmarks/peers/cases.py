"""What all systems simulate: numbers, and what is measured of positions that a run gives. NumPy only."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

GRAVITY = 9.81  # [m/s^2]
CASES = ("incline_below", "incline_above", "free_spin", "rigid_pile_27", "soft_cube")
#: A cube of 0.1 m and 1 kg on a plane of this friction; gravity leans by so much of the limit.
FRICTION, BELOW, ABOVE, SLIDE = 0.5, 0.95, 1.05, 2.0  # [1], [1], [1], [s]
#: A box that turns freely, sides [m] and angular velocity [rad/s] about none of its axes, for so long [s].
SPIN_SIZE, SPIN_MASS, SPIN, SPIN_TIME = (0.1, 0.2, 0.3), 1.0, (6.0, 6.0, 5.2915), 10.0
PILE_TIME = 2.0  # [s]
#: A soft cube stands on the floor: side [m], cells along it, density [kg/m^3], E [Pa], nu, time [s].
CUBE, CELLS, DENSITY, YOUNG, POISSON, SETTLE = 0.2, 6, 1000.0, 1e5, 0.3, 1.0


def leaning(share: float) -> tuple[float, float, float]:
    """Gravity on a plane that is tilted to a share of the limit of friction."""
    angle = np.arctan(share * FRICTION)
    return GRAVITY * float(np.sin(angle)), 0.0, -GRAVITY * float(np.cos(angle))


def sliding() -> float:
    """Acceleration on the steeper plane [m/s^2]."""
    along, _, down = leaning(ABOVE)
    return along + FRICTION * down


def pile() -> list[tuple[Floats, float]]:
    """Centre [m] and turn about z [rad] of the 27 cubes of 0.1 m and 1 kg of the scene rigid_pile_27."""
    places = []
    for k in range(27):
        x = 0.135 * (k % 3 - 1) + 0.004 * ((5 * k) % 7 - 3)
        y = 0.135 * ((k // 3) % 3 - 1) + 0.004 * ((3 * k) % 7 - 3)
        yaw = np.radians((37 * k) % 23 - 11)
        places.append((np.array([x, y, 0.06 + 0.13 * (k // 9)]), float(yaw)))
    return places


def timed(
    step: Callable[[], Any], count: int, look: Callable[[], Any] | None = None
) -> tuple[float, list[Any]]:
    """CPU seconds of so many steps, user and system, and what was seen after each, which is not timed."""
    seconds, seen = 0.0, []
    for _ in range(count):
        start = time.process_time()
        step()
        seconds += time.process_time() - start
        if look:
            seen.append(look())
    return seconds, seen


def of_incline(places: Floats, step: float, share: float) -> dict[str, float]:
    """Of positions along the plane after each step [m]: speed of creeping in the second half [m/s], or the
    relative error of the acceleration there."""
    half = len(places) // 2
    times = step * np.arange(1, len(places) + 1)
    if share < 1.0:
        return {"creep": abs(float(np.polyfit(times[half:], places[half:], 1)[0]))}
    found = 2.0 * float(np.polyfit(times[half:], places[half:], 2)[0])
    return {"error": abs(found / sliding() - 1.0)}


def of_spin(rotation: Floats, spin: Floats) -> dict[str, float]:
    """Of the rotation matrix and the angular velocity [rad/s] at the end: the change of angular momentum."""
    size = np.square(SPIN_SIZE)
    inertia = SPIN_MASS / 12.0 * (size.sum() - size)
    before = inertia * np.array(SPIN)
    after = rotation @ (inertia * (rotation.T @ spin))
    lost = 1.0 - float(np.linalg.norm(after) / np.linalg.norm(before))
    return {"lost": lost, "error": float(np.linalg.norm(after - before) / np.linalg.norm(before))}


def of_pile(places: Floats, rotations: Floats) -> dict[str, float]:
    """Of centres (27, 3) [m] and rotation matrices (27, 3, 3): heights, pairs of cubes that overlap, the
    floor among them, and how deep at most [m]."""
    corners = np.array(list(itertools.product((-0.05, 0.05), repeat=3)))
    lowest = [float((p + corners @ r.T)[:, 2].min()) for p, r in zip(places, rotations, strict=True)]
    depths = [-z for z in lowest]
    for a, b in itertools.combinations(range(len(places)), 2):
        if np.linalg.norm(places[a] - places[b]) < 0.1 * np.sqrt(3.0):
            depths.append(_overlap(places[a], rotations[a], places[b], rotations[b]))
    deep = [depth for depth in depths if depth > 0.0]
    heights = places[:, 2]
    return {
        "z_mean": float(heights.mean()),
        "overlaps": float(len(deep)),
        "deepest": max(deep, default=0.0),
    }


def _overlap(p: Floats, a: Floats, q: Floats, b: Floats) -> float:
    """How far cubes of 0.1 m would have to move to be apart [m]; negative where they are. By the separating
    axes of boxes (Gottschalk, Lin and Manocha 1996)."""
    crossed = [np.cross(u, v) for u in a.T for v in b.T]
    axes = [*a.T, *b.T, *(axis / np.linalg.norm(axis) for axis in crossed if np.linalg.norm(axis) > 1e-6)]
    reach = [0.05 * (np.abs(axis @ a).sum() + np.abs(axis @ b).sum()) - abs(axis @ (q - p)) for axis in axes]
    return float(min(reach))


def of_cube(height: float) -> dict[str, float]:
    """Of the height of the cube at rest [m]: how much lower it is than at first."""
    return {"squash": CUBE - height}
