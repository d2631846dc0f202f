"""Cameras by argument: a view, a place, what they look at."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from .._core import InvalidArgument
from ..arguments import real_number
from ..recording.format import surface
from ..rotations import vector
from .camera import VIEWS, Bounds, Camera, auto_camera, bounds_of
from .choosing import matching

#: A camera at a place that is told nothing else looks like that of the named views [rad].
FIELD_OF_VIEW = Camera.vertical_fov


def aimed(
    camera: Any,
    target: Any,
    field_of_view: float | None,
    bounds: Bounds,
    bodies: Sequence[Any],
    aspect: float,
) -> Camera:
    """The camera of a picture of ``bodies`` with these ``bounds``, width over height ``aspect``.

    ``camera`` is a ``Camera``, a view (oblique, front, side, top; None: oblique) or where it is (3,) [m].
    ``target`` is a point (3,) [m], or bodies by handle, name or pattern: views show them in full, a camera at
    a place looks at their middle. ``field_of_view`` [rad] is vertical. Raises InvalidArgument for views and
    bodies that are unknown, places that are no numbers, and cameras at their target."""
    fov = FIELD_OF_VIEW if field_of_view is None else real_number(field_of_view, "field_of_view")
    if not 0.0 < fov <= 3.0:
        raise InvalidArgument(
            f"field_of_view = {fov:g} rad: must be in (0, 3]; 35 degrees are 35 * stark.deg = 0.61 rad"
        )
    if isinstance(camera, Camera):
        return _adjusted(camera, target, field_of_view, bodies)
    if camera is None or isinstance(camera, str):
        view = camera or "oblique"
        if view not in VIEWS:
            raise InvalidArgument(
                f"view '{view}' is unknown; choose one of {', '.join(VIEWS)}, or a place (x, y, z) [m]"
            )
        return auto_camera(_seen(target, bounds, bodies), view, aspect, fov)
    eye = vector(camera, "camera")
    middle = np.array(bounds.center) if target is None else _middle(target, bodies)
    return _checked(Camera(eye=_triple(eye), target=_triple(middle), up=bounds.up, vertical_fov=fov))


def _adjusted(camera: Camera, target: Any, fov: float | None, bodies: Sequence[Any]) -> Camera:
    if target is not None:
        camera = dataclasses.replace(camera, target=_triple(_middle(target, bodies)))
    return _checked(camera if fov is None else dataclasses.replace(camera, vertical_fov=float(fov)))


def _checked(camera: Camera) -> Camera:
    if camera.eye == camera.target:
        raise InvalidArgument(
            f"camera and target are both at {camera.eye} m: must be apart; move one of them"
        )
    return camera


def _is_point(target: Any) -> bool:
    try:
        return np.asarray(target).dtype.kind in "iuf"
    except ValueError:
        return False


def _bodies(target: Any, bodies: Sequence[Any]) -> list[Any]:
    return [bodies[i] for i in matching(target, [body.name for body in bodies], "target")]


def _middle(target: Any, bodies: Sequence[Any]) -> np.ndarray:
    if _is_point(target):
        return vector(target, "target")
    points = np.concatenate([surface(body)[0] for body in _bodies(target, bodies)])
    if not len(points):
        raise InvalidArgument(f"target = {target!r}: has no surface to look at; give a point (x, y, z) [m]")
    middle: np.ndarray = 0.5 * (points.min(axis=0) + points.max(axis=0)).astype(np.float64)
    return middle


def _seen(target: Any, bounds: Bounds, bodies: Sequence[Any]) -> Bounds:
    """What a view shows in full: all, as much around a point, or some bodies."""
    if target is None:
        return bounds
    if not _is_point(target):
        return bounds_of([_bodies(target, bodies)], bounds.up)
    move = vector(target, "target") - bounds.center
    low, high = np.add(bounds.low, move), np.add(bounds.high, move)
    return dataclasses.replace(
        bounds, center=_triple(bounds.center + move), low=_triple(low), high=_triple(high)
    )


def _triple(values: Any) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    if not all(map(math.isfinite, (x, y, z))):
        raise InvalidArgument(f"camera: a place ({x}, {y}, {z}) m is not finite")
    return (x, y, z)
