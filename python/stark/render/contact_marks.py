"""Contacts over a picture: a dot at each pair of points in contact, an arrow for its force."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from .._core import InvalidArgument
from .camera import Bounds, Camera
from .choosing import matching
from .clipping import Plane
from .colorbar import numbers
from .lettering import strokes
from .overlay import PAPER, Color, Overlay, rectangle

FORCE: Color = (0.80, 0.09, 0.13)
#: Length of the longest arrow over the radius of the scene.
LONGEST = 0.35
_NOTHING_CUT: Mapping[str, Plane] = {}


def draw_contacts(
    overlay: Overlay,
    sim: Any,
    which: Any,
    camera: Camera,
    bounds: Bounds,
    shown: Collection[str] | None = None,
    cut: Mapping[str, Plane] = _NOTHING_CUT,
) -> None:
    """Dots and arrows of the last step over everything, and an arrow of a round force as a key. ``which`` is
    True, or a body by handle or name: forces on it, from all others. Else they are those on the body that
    moves freely, of two such on the first one of the scene. Forces below a thousandth of the largest have a
    dot only. Contacts between bodies none of which is ``shown`` are left out, and so are those where both are
    taken away by the planes of ``cut``. Raises InvalidArgument where
    there are no contacts to tell of: in recordings."""
    places, forces = forces_of(sim, which, shown, cut)
    sizes = np.linalg.norm(forces, axis=1)
    largest = float(sizes.max(initial=0.0))
    if largest == 0.0:
        return
    scale = LONGEST * bounds.radius / largest  # [m/N]
    starts, start_depths = camera.project(places, overlay.size)
    ends, end_depths = camera.project(places + scale * forces, overlay.size)
    thick = max(1.5, 0.0032 * overlay.size[1])
    seen = (start_depths > 1e-3 * bounds.radius) & (end_depths > 1e-3 * bounds.radius)
    for start in starts[seen]:
        overlay.lines([start[None]], 2.2 * thick, FORCE, halo=0.4 * thick)
    for k in np.flatnonzero(seen & (sizes > 1e-3 * largest)):
        draw_arrow(overlay, starts[k], ends[k], thick)
    _draw_key(overlay, camera, bounds, largest, scale, thick)


def forces_of(
    sim: Any,
    which: Any,
    shown: Collection[str] | None = None,
    cut: Mapping[str, Plane] = _NOTHING_CUT,
) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 3) [m] and forces (n, 3) [N] of the contacts of the last step, as ``draw_contacts`` has
    them."""
    if getattr(sim, "recorded", None) is not None:
        return _recorded_forces(sim, which, shown, cut)
    if not hasattr(sim, "contacts"):
        raise InvalidArgument("contacts = True needs a simulation; a recording has positions only")
    contacts = sim.contacts if which is True else sim.contacts.of(which)
    middles = 0.5 * (contacts.points_a + contacts.points_b)
    contacts = contacts._take(_in_sight(contacts.names, contacts.bodies, middles, shown, cut))
    forces = contacts.forces
    if which is True and len(contacts):
        moves = np.array([body.motion == "dynamic" for body in sim.bodies])
        turned = ~moves[contacts.bodies[:, 0]] & moves[contacts.bodies[:, 1]]
        forces = np.where(turned[:, None], -forces, forces)
    return 0.5 * (contacts.points_a + contacts.points_b), forces


def _in_sight(
    names: Sequence[str],
    pairs: np.ndarray,
    places: np.ndarray,
    shown: Collection[str] | None,
    cut: Mapping[str, Plane],
) -> np.ndarray:
    """Which contacts (n,) have a body that is shown, and not taken away at their place."""
    seen = np.zeros(pairs.shape, dtype=bool)
    for body, name in enumerate(names):
        if shown is None or name in shown:
            kept = cut[name].heights(places) <= 0.0 if name in cut else np.ones(len(places), dtype=bool)
            seen |= (pairs == body) & kept[:, None]
    return np.asarray(seen.any(axis=1))


def _recorded_forces(
    frame: Any, which: Any, shown: Collection[str] | None, cut: Mapping[str, Plane]
) -> tuple[np.ndarray, np.ndarray]:
    """Of a frame of a recording."""
    if not frame.recorded.has_contacts:
        raise InvalidArgument(
            "contacts: the recording has none; record them: stark run, or Recorder(contacts=True)"
        )
    found = frame.recorded.contacts(frame.index)
    a, b = found.bodies[:, 0], found.bodies[:, 1]
    moves = np.array([body.motion == "dynamic" for body in frame.bodies], dtype=bool)
    names = [body.name for body in frame.bodies]
    drawn, turned = _in_sight(names, found.bodies, found.points, shown, cut), ~moves[a] & moves[b]
    if which is not True:
        own = matching(which, names, "contacts: body")
        drawn &= np.isin(a, own) | np.isin(b, own)
        turned = ~np.isin(a, own)
    forces = np.where(turned[:, None], -found.forces, found.forces)
    return found.points[drawn].astype(np.float64), forces[drawn].astype(np.float64)


def draw_arrow(overlay: Overlay, start: np.ndarray, end: np.ndarray, thick: float) -> None:
    """From one place to another [px]; the head is shorter where the arrow is."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length < 0.5 or length > 1e5:
        return
    along = along / length
    across = np.array([-along[1], along[0]])
    head = min(5.0 * thick, 0.6 * length)
    neck = end - head * along
    overlay.lines([np.array([start, neck])], thick, FORCE, halo=0.4 * thick)
    overlay.polygon([end, neck + 0.4 * head * across, neck - 0.4 * head * across], FORCE)


def _draw_key(
    overlay: Overlay, camera: Camera, bounds: Bounds, largest: float, scale: float, thick: float
) -> None:
    """An arrow at the lower left, as long as that of a round force in the middle of the scene."""
    height = overlay.size[1]
    depth = float(camera.axes()[2] @ (np.array(bounds.center) - camera.eye))
    if depth <= 0.0:
        return
    pixels = scale * 0.5 * height / (math.tan(0.5 * camera.vertical_fov) * depth)  # [px/N]
    force = round_force(largest)
    size = max(6.0, 0.017 * height)
    texts, unit = numbers((0.0, force), "N")
    x, y = 2.0 * size, height - 2.2 * size
    words, end = f"{texts[-1]} {unit}", x + pixels * force
    right = end + 2.0 * size + strokes(words, size)[1]
    overlay.polygon(rectangle(x - size, y - 1.3 * size, right, y + 1.3 * size), PAPER, 0.72)
    draw_arrow(overlay, np.array([x, y]), np.array([end, y]), thick)
    overlay.text((end + size, y + 0.5 * size), words, size)


def round_force(largest: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not beyond ``largest`` [N]."""
    power = 10.0 ** math.floor(math.log10(largest))
    return max(m * power for m in (1.0, 2.0, 5.0) if m == 1.0 or m * power <= largest)
