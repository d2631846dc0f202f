"""What a simulation shows of itself: pictures at once, without a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from stark._core import InvalidArgument
from stark.handle import SimulationLink

if TYPE_CHECKING:
    from stark.render import Picture
    from stark.replay import InlinePage
    from stark.view import View


class Pictures(SimulationLink):
    """Pictures of the state of a simulation; a part of ``Simulation``."""

    def picture(
        self,
        path: str | PathLike[str] | None = None,
        *,
        camera: Any = None,
        target: Any = None,
        field_of_view: float | None = None,
        size: Sequence[int] = (1280, 720),
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
    ) -> Picture:
        """Draws the bodies where they are now (docs/pictures.md): an array (height, width, 3) uint8, sRGB,
        which notebooks show. Writes it to ``path``, a PNG file, if there is one.

        ``camera`` is a view ("oblique", "front", "side", "top"), the place of the camera (3,) [m], or a
        ``stark.render.Camera``. ``target`` is a point (3,) [m] or bodies to look at; by default the middle of
        the scene. ``field_of_view`` is the vertical angle [rad]. ``size`` is (width, height) in pixels and
        ``quality`` is "draft", "good" or "best".

        Name bodies by handle, by name or by a pattern such as "finger*"; a list names several. Only
        ``bodies`` are drawn, ``hide`` leaves some out, ``opacity`` makes some transparent: {"glass*": 0.3}.
        ``clip`` = (point [m], normal) or (point, normal, bodies) removes the side that the normal points to;
        closed bodies show their section. ``edges`` draws the edges of meshes, ``grid`` the lines on the
        ground.

        ``field`` colours bodies by "stress", "strain", "pressure", "contact_force" or "speed". A dictionary
        colours chosen bodies, by one of these words or by values at the vertices (n,). ``limits`` = (low,
        high) belong to the ends of the colours; by default they span the values. ``colormap`` is "viridis",
        "magma", "coolwarm" or colours (k, 3) in [0, 1]. ``label`` replaces the title of the scale.
        ``contacts=True`` draws points and forces of contact; give a body to draw the forces on it.

        Raises InvalidArgument for unknown names and words, numbers out of range, paths that do not end with
        .png, and where ``bodies`` and ``hide`` leave nothing to draw."""
        from stark.render import render, write_png
        from stark.render.png import png_path

        file = None if path is None else png_path(path, "picture: path")
        width, height = _size(size)
        picture = render(
            self, width, height, camera=camera, target=target, field_of_view=field_of_view, quality=quality,
            bodies=bodies, hide=hide, opacity=opacity, clip=clip, edges=edges, grid=grid,
            field=field, limits=limits, colormap=colormap, label=label, contacts=contacts,
        )  # fmt: skip
        if file is not None:
            write_png(file, picture)
        return picture

    def show(self, *, height: int = 480, max_megabytes: float = 20.0) -> InlinePage | Picture:
        """Shows the simulation in a notebook: the newest recording that a ``stark.recording.Recorder`` made
        of it, up to now, as a replay page of ``height`` pixels that needs no network. Frames are left out so
        that the page stays below about ``max_megabytes``. Without a recording it shows a picture."""
        from stark.recording.latest import latest_recording
        from stark.replay import show

        recording = latest_recording(self)
        if recording is None:
            return self.picture(size=(16 * height // 9, height))
        return show(recording, height=height, max_megabytes=max_megabytes)

    def view(
        self,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
        paused: bool = False,
        field: str | None = None,
        contacts: bool = False,
        record_to: str | PathLike[str] = "out/view",
        drive: Callable[[Any], object] | None = None,
    ) -> View:
        """Opens a page that shows the simulation in a browser and takes commands between steps
        (docs/view.md): ``with sim.view() as view: view.run()``. The simulation computes the same bits with
        and without it.

        ``host``, ``port``: where the page is, ``view.url``; other machines see it only where ``host`` says
        so; the next port that is free is taken. ``paused``: waits at the start. ``field`` colours bodies as
        in ``picture``, ``contacts`` shows forces. ``record_to``: folder of recordings that the page asks for;
        where it exists a number is appended. ``drive(sim)`` is called before each step of ``view.run()``.

        Raises ImportError that names the extra when viser is missing, InvalidArgument for bad arguments."""
        from stark.view import View

        return View(
            self, host=host, port=port, paused=paused, field=field, contacts=contacts, record_to=record_to,
            drive=drive,
        )  # fmt: skip

    def _repr_png_(self) -> bytes | None:
        """A small picture in place of the name, where notebooks show values."""
        return self.picture(size=(640, 360), quality="draft")._repr_png_()


def _size(size: Any) -> tuple[int, int]:
    try:
        width, height = (int(length) for length in size)
        whole = width == size[0] and height == size[1]
    except (TypeError, ValueError, KeyError):
        whole = False
    if not whole:
        raise InvalidArgument(
            f"picture: size = {size!r}: must be (width, height) in pixels, like (1280, 720)"
        )
    return width, height
