"""What a view shows in space: bodies, fields by colour, forces of contact, the spring that pulls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from stark.body_kinds import has_pose
from stark.palette import body_colors
from stark.recording.format import drawn, surface
from stark.render.camera import auto_camera, bounds_of, up_of
from stark.render.colorbar import draw_colorbar, limits_of
from stark.render.colormaps import Colormap, linear
from stark.render.contact_marks import FORCE, LONGEST, forces_of
from stark.render.fields import Field, field_of
from stark.render.overlay import Overlay
from stark.render.pieces import NEUTRAL, at_surface
from stark.rotations import to_quaternion

from .pulls import Pulls

Array = NDArray[Any]
OnDrag = Callable[[str, str, Any, Any], None]
"""Name of a body, "start", "update" or "end", the point that was taken and where the pointer is (3,) [m]."""

_BAR_SIZE = (360, 560)  # in which the scale of colours is drawn [px]

_GROUND: tuple[Literal["yz", "xz", "xy"], ...] = ("yz", "xz", "xy")  # plane across each axis


def bytes_of(color: Any) -> tuple[int, int, int]:
    """sRGB in [0, 1] as bytes."""
    red, green, blue = (round(255.0 * float(c)) for c in tuple(color)[:3])
    return red, green, blue


class Stage:
    """The space of a server, filled from a simulation. ``on_drag`` is called, from a thread of the server,
    while a body that can be pulled is dragged."""

    def __init__(self, server: Any, sim: Any, pulls: Pulls | None, on_drag: OnDrag) -> None:
        self._server, self._sim, self._pulls, self._on_drag = server, sim, pulls, on_drag
        self._bodies = drawn(sim)
        self._colors = body_colors(self._bodies)
        self._bounds = bounds_of([self._bodies], up_of(sim))
        self._nodes: dict[str, Any] = {}
        self._colored: dict[str, Any] = {}
        self._marks: list[Any] = []
        self._limits: tuple[float, float] | None = None
        self.field: str | None = None
        self.contacts = False
        self._colormap = Colormap("viridis")
        self._set_up()

    def _set_up(self) -> None:
        scene, camera = self._server.scene, auto_camera(self._bounds)
        up = self._bounds.up
        scene.set_up_direction(up)
        start = self._server.initial_camera
        start.position, start.look_at = tuple(camera.eye), tuple(self._bounds.center)
        start.fov = camera.vertical_fov
        if not self._bounds.has_floor:
            size = 20.0 * self._bounds.radius
            middle, axis = np.array(self._bounds.center), np.array(up)
            place = middle + (self._bounds.ground - middle @ axis) * axis
            cell = 10.0 ** np.floor(np.log10(self._bounds.radius))
            scene.add_grid(
                "/ground", size, size, plane=_GROUND[int(np.argmax(np.abs(up)))], position=tuple(place),
                cell_size=cell, section_size=10.0 * cell,
            )  # fmt: skip

    # --- drawing ---

    def draw(self) -> Array | None:
        """Brings what is shown up to date; the scale of colours (h, w, 3) uint8 when there is a field.
        Raises InvalidArgument for fields that the bodies do not have."""
        field = None if self.field is None else field_of(self._sim, self.field)
        shown = {} if field is None else field.values
        values = {b.name: at_surface(b, shown[b.name]) for b in self._bodies if b.name in shown}
        if field is not None:
            self._widen(values)
        with self._server.atomic():
            for body, color in zip(self._bodies, self._colors, strict=True):
                self._draw_body(body, NEUTRAL if field is not None else color, values.get(body.name))
            self._draw_marks()
        self._server.flush()
        return None if field is None else self._bar(field)

    def forget_limits(self) -> None:
        """The colours start anew from the values of the next drawing."""
        self._limits = None

    def _widen(self, values: dict[str, Array]) -> None:
        """Limits grow and never shrink while a field is shown: colours that jump cannot be compared."""
        low, high = limits_of(list(values.values()))
        if self._limits is not None:
            low, high = min(low, self._limits[0]), max(high, self._limits[1])
        self._limits = low, high

    def _draw_body(self, body: Any, color: Any, values: Array | None) -> None:
        """A mesh of one colour; over it, where there are values, one with colours at its vertices, which the
        browser makes anew each time. The first one is there to be dragged, even when it is not seen."""
        name = str(body.name)
        positions, triangles = surface(body)
        if name not in self._nodes:
            self._nodes[name] = self._take_drags(self._plain(body, positions, triangles, color), body)
        node = self._nodes[name]
        self._move(body, node, positions)
        opacity = None if values is None else 0.0
        if node.opacity != opacity:
            node.opacity = opacity
        if node.color != bytes_of(color):
            node.color = bytes_of(color)
        if values is None:
            if name in self._colored:
                self._colored.pop(name).remove()
            return
        data = self._glb(positions, triangles, values)
        if name not in self._colored:
            self._colored[name] = self._server.scene.add_glb(
                _path(name, "colours"), data, cast_shadow=False, receive_shadow=False
            )
        elif self._colored[name].glb_data != data:
            self._colored[name].glb_data = data

    def _plain(self, body: Any, positions: Array, triangles: Array, color: Any) -> Any:
        """A mesh of one colour; of rigid bodies in their own frame, which moves."""
        rigid, place = has_pose(body), {}
        if rigid:
            position, rotation = body.pose
            positions = (positions - position) @ rotation
            place = {"position": tuple(position), "wxyz": tuple(to_quaternion(rotation))}
        return self._server.scene.add_mesh_simple(
            _path(body.name), positions.astype(np.float32), triangles.astype(np.uint32),
            color=bytes_of(color), side="double", flat_shading=rigid, **place,
        )  # fmt: skip

    def _move(self, body: Any, node: Any, positions: Array) -> None:
        if body.motion == "fixed":
            return
        if has_pose(body):
            position, rotation = body.pose
            node.position, node.wxyz = position, to_quaternion(rotation)
        else:
            node.vertices = positions.astype(np.float32)

    def _glb(self, positions: Array, triangles: Array, values: Array) -> bytes:
        """A mesh with colours at its vertices as a binary glTF, whose colours are linear light."""
        import trimesh

        assert self._limits is not None
        low, high = self._limits
        shade = linear(self._colormap((values - low) / (high - low)))
        colors = np.column_stack([255.0 * shade, np.full(len(shade), 255.0)]).astype(np.uint8)
        mesh: Any = trimesh.Trimesh(positions, triangles, vertex_colors=colors, process=False)
        return bytes(mesh.export(file_type="glb", include_normals=True, tree_postprocessor=_make_matt))

    def _bar(self, field: Field) -> Array:
        assert self._limits is not None
        width, height = _BAR_SIZE
        overlay = Overlay(np.full((height, width, 3), 255, dtype=np.uint8))
        draw_colorbar(overlay, self._colormap, self._limits, field.label, field.unit)
        return _trimmed(overlay.picture)

    # --- marks ---

    def _draw_marks(self) -> None:
        for mark in self._marks:
            mark.remove()
        self._marks = []
        if self.contacts:
            self._draw_contacts()
        point = None if self._pulls is None else self._pulls.point
        if self._pulls is not None and point is not None and self._pulls.target is not None:
            line = np.array([[point, self._pulls.target]], dtype=np.float32)
            scene = self._server.scene
            self._marks.append(
                scene.add_line_segments("/pull", line, (20, 20, 20), thickness=3.0, thickness_units="screen")
            )
            ends = line.reshape(2, 3)
            size = 0.012 * self._bounds.radius
            dots = scene.add_point_cloud(
                "/ends", ends, (20, 20, 20), point_size=size, point_shape="circle", precision="float32"
            )
            self._marks.append(dots)

    def _draw_contacts(self) -> None:
        """Arrows of the forces, the largest as long as in a picture."""
        places, forces = forces_of(self._sim, True)
        sizes = np.linalg.norm(forces, axis=1)
        largest = float(sizes.max(initial=0.0))
        if largest == 0.0:
            return
        kept = sizes > 1e-3 * largest
        starts = places[kept]
        ends = starts + LONGEST * self._bounds.radius / largest * forces[kept]
        thick = 0.006 * self._bounds.radius
        arrows = self._server.scene.add_arrows(
            "/contacts", np.stack([starts, ends], axis=1).astype(np.float32), bytes_of(FORCE),
            shaft_radius=thick, head_radius=2.5 * thick, head_length=5.0 * thick,
        )  # fmt: skip
        self._marks.append(arrows)

    # --- dragging ---

    def _take_drags(self, node: Any, body: Any) -> Any:
        if self._pulls is None or body.name not in self._pulls.bodies:
            return node
        name = str(body.name)

        async def dragged(event: Any) -> None:  # asynchronous ones come in order
            self._on_drag(name, event.phase, event.start_position, event.end_position)

        node.on_drag("left")(dragged)
        return node


def _make_matt(tree: Any) -> None:
    """Without a material, glTF has bare metal, which is too dark to be compared with a scale of colours."""
    matt = {"metallicFactor": 0.0, "roughnessFactor": 1.0}
    tree["materials"] = [{"pbrMetallicRoughness": matt, "doubleSided": True}]
    for mesh in tree["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["material"] = 0


def _trimmed(picture: Array) -> Array:
    """Without the paper around what is drawn, but for a margin [px]; as wide as the panel, or a small picture
    would be stretched."""
    inked = np.any(np.less(picture, 250), axis=2)
    rows, columns = np.flatnonzero(inked.any(axis=1)), np.flatnonzero(inked.any(axis=0))
    part = picture[rows[0] - 8 : rows[-1] + 9, columns[0] - 8 : columns[-1] + 9]
    padded = np.full((part.shape[0], max(_BAR_SIZE[0], part.shape[1]), 3), 255, dtype=np.uint8)
    padded[:, : part.shape[1]] = part
    return padded


def _path(name: str, group: str = "bodies") -> str:
    """Of a body in the tree of the server, in which a slash leads a level down."""
    return f"/{group}/{str(name).replace('/', '∕')}"
