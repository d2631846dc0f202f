"""One picture of a simulation or of a frame of a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .._core import InvalidArgument
from ..arguments import given_flag, given_word, real_array, shown_value
from ..palette import body_colors
from ..recording.format import drawn
from .aiming import aimed
from .array import Picture
from .camera import Bounds, bounds_of, up_of
from .choosing import matching, opacities
from .clipping import Plane
from .colorbar import draw_colorbar, limits_of
from .colormaps import Colormap
from .contact_marks import draw_contacts
from .fields import field_of
from .overlay import Overlay
from .pieces import pieces_of
from .shading import QUALITIES, Style, draw

#: Least radius of rods and fibres [pixels]: thinner ones would be dotted lines, or not be seen at all.
_THINNEST = 0.6


def render(
    source: Any,
    width: int = 1280,
    height: int = 720,
    *,
    camera: Any = None,
    target: Any = None,
    field_of_view: float | None = None,
    quality: str = "good",
    bodies: Any = None,
    hide: Any = (),
    opacity: Mapping[Any, float] | None = None,
    clip: Sequence[Any] | None = None,
    edges: bool = False,
    grid: bool = True,
    field: Any = None,
    limits: Sequence[float] | None = None,
    colormap: Any = "viridis",
    label: str | None = None,
    contacts: Any = False,
    bounds: Bounds | None = None,
    threads: int = 0,
) -> Picture:
    """Picture of ``source`` as a (height, width, 3) uint8 sRGB array, which notebooks show.

    ``source`` is a simulation, a frame of a recording, or anything with ``.bodies`` that have ``positions``
    (n, 3) [m], ``triangles`` (m, 3), ``kind``, ``motion`` and ``color``. ``quality`` is draft, good or best.
    ``bounds`` keeps camera and light still over the frames of a film. ``threads`` = 0 uses all cores; the
    picture does not depend on it.

    ``camera`` is a view (oblique, front, side, top; None: oblique), where the camera is (3,) [m], or a
    ``Camera``; ``target`` is a point (3,) [m] or bodies to look at, else the middle of the scene;
    ``field_of_view`` is vertical [rad]. Up is against gravity where that is along an axis, else z.

    Bodies are named by handle, name, pattern such as "finger*", or several of these: ``bodies`` are the only
    ones to draw, ``hide`` are left out, ``opacity`` has numbers in [0, 1] for some. ``clip`` = (point [m],
    normal), or (point, normal, bodies), takes away what lies on the side that the normal points to, scenery
    apart; solids show their section with its values, other closed bodies in their own colour; cloth and open
    surfaces are hollow.

    ``field`` colours bodies by numbers at their vertices: "stress", "strain", "pressure", "contact_force" or
    "speed" (``field_values`` says what they are), or a dictionary of bodies with arrays (n,) or one of these
    words. ``limits`` = (low, high) are those of the colours, else those of the values that are shown;
    ``colormap`` is viridis, magma, coolwarm or colours (k, 3); ``label`` replaces the title of the scale.
    ``contacts`` = True draws points and forces of contact in front of everything; a body in its place, those
    of this body.

    Raises InvalidArgument for names and words that are unknown and numbers out of range."""
    if not isinstance(quality, str) or quality not in QUALITIES:
        raise InvalidArgument(
            f"quality {shown_value(quality)} is unknown; choose one of {', '.join(QUALITIES)}"
        )
    sizes = [isinstance(size, (int, np.integer)) and 1 <= size <= 16384 for size in (width, height)]
    if not all(sizes):
        raise InvalidArgument(
            f"size {shown_value(width)} x {shown_value(height)} px: each must be in [1, 16384], and whole"
        )
    if not (isinstance(threads, (int, np.integer)) and 0 <= threads <= 1024):
        raise InvalidArgument(f"threads = {shown_value(threads)}: must be in [0, 1024], and whole")
    for what, given in (("limits", limits), ("label", label)):
        if field is None and given is not None:
            raise InvalidArgument(
                f"{what} = {shown_value(given)}: is of the scale of a field: must come with field=, such as "
                f"'stress'"
            )
    everything = drawn(source)
    names = [str(body.name) for body in everything]
    kept = kept_of(names, bodies, hide)
    if names and not kept:
        raise InvalidArgument(_nothing_left(bodies, hide, names))
    shown = [everything[i] for i in kept]
    share, paint = opacities(opacity, names), body_colors(everything)
    box = bounds_of([shown], up_of(source)) if bounds is None else _bounds(bounds, len(everything))
    far = dict(zip(map(id, shown if bounds is None else everything), box.scenery, strict=True))
    colors = Colormap(colormap)
    shades = None if field is None else field_of(source, field, {body.name for body in shown})
    planes = _planes(clip, shown)
    eye = aimed(camera, target, field_of_view, box, everything, width / height)
    pieces = pieces_of(
        shown,
        [paint[i] for i in kept],
        [far[id(body)] for body in shown],
        [share[i] for i in kept],
        {} if shades is None else shades.values,
        planes,
        lambda points: eye.pixels(points, int(height)) * _THINNEST,
    )
    seen = [piece.values for piece in pieces if piece.values is not None]
    range_of_colors = limits_of(seen) if limits is None else _limits(limits)
    style = Style(
        size=(int(width), int(height)),
        camera=eye,
        bounds=box,
        quality=quality,
        edges=given_flag(edges, "edges"),
        grid=given_flag(grid, "grid"),
        threads=int(threads),
        colormap=colors,
        limits=range_of_colors,
    )
    overlay = Overlay(draw(pieces, style))
    if contacts is not False:
        cut = {body.name: plane for body, plane in zip(shown, planes, strict=True) if plane is not None}
        draw_contacts(overlay, source, contacts, style.camera, box, {body.name for body in shown}, cut)
    if shades is not None:
        words, unit = (shades.label, shades.unit) if label is None else (given_word(label, "label"), "")
        draw_colorbar(overlay, colors, range_of_colors, words, unit)
    return Picture.of(overlay.picture)


def kept_of(names: Sequence[str], bodies: Any, hide: Any) -> list[int]:
    """Numbers of the bodies that a picture draws."""
    hidden = matching(hide, names, "hide")
    chosen = range(len(names)) if bodies is None else matching(bodies, names, "bodies")
    return [i for i in chosen if i not in hidden]


def _nothing_left(bodies: Any, hide: Any, names: Sequence[str]) -> str:
    asked = f"bodies = {bodies!r}" if bodies is not None else f"hide = {hide!r}"
    if bodies is not None and matching(bodies, names, "bodies"):
        asked += f", hide = {hide!r}"
    return (
        f"picture: {asked} leaves none of the {len(names)} bodies to draw: name at least one that is to "
        f"be seen; leave out bodies and hide to draw all"
    )


def _bounds(bounds: Any, count: int) -> Bounds:
    if not isinstance(bounds, Bounds) or len(bounds.scenery) != count:
        raise InvalidArgument(
            f"bounds = {shown_value(bounds)}: must be stark.render.scene_bounds(...) of the same {count} "
            f"bodies"
        )
    return bounds


def _limits(limits: Any) -> tuple[float, float]:
    values = real_array(limits, "limits")
    if values.shape != (2,) or not np.isfinite(values).all() or not values[0] < values[1]:
        raise InvalidArgument(f"limits = {limits!r}: must be (low, high), two finite numbers, low < high")
    return float(values[0]), float(values[1])


def _planes(clip: Sequence[Any] | None, bodies: Sequence[Any]) -> list[Plane | None]:
    """The plane that cuts each body, or None."""
    if clip is None:
        return [None] * len(bodies)
    try:
        point, normal, *cut = clip
        (chosen,) = cut or [None]
    except (TypeError, ValueError, OverflowError):
        raise InvalidArgument(
            f"clip = {clip!r}: must be (point [m], normal) or (point, normal, bodies): "
            f"((0, 0, 0.1), (0, -1, 0), 'jelly')"
        ) from None
    plane = Plane.of(point, normal)
    names = [str(body.name) for body in bodies]
    meant = range(len(bodies)) if chosen is None else matching(chosen, names, "clip: body")
    return [plane if i in meant else None for i in range(len(bodies))]
