"""Shapes of links as triangle meshes, in the frame of the link."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from stark import mesh as meshes
from stark._core import InvalidArgument, InvalidMesh
from stark.mesh import TriangleMesh
from stark.robots.description import Geometry
from stark.robots.report import Report


def mesh_of(
    shape: Geometry,
    source: str,
    title: str,
    report: Report | None = None,
    remedy: str = "correct it, or leave it out with contact=False",
) -> TriangleMesh:
    """The surface of one shape in the frame of its link. InvalidArgument names source, link and remedy."""
    try:
        surface = _without_flat(_finite(_surface(shape), shape), title, report)
    except (InvalidMesh, InvalidArgument) as error:
        raise InvalidArgument(f"{source}: {title}: shape {shape.kind}: {error}; {remedy}") from None
    if report is not None and shape.file is not None and (unit := unit_of(shape.file)) != 1.0:
        report.add("kept", title, f"mesh '{shape.file.name}' is in units of {unit:g} m, as it says")
    turned = surface.vertices @ shape.rotation.T + shape.position
    return TriangleMesh(turned, surface.triangles)


def _surface(shape: Geometry) -> TriangleMesh:
    if shape.kind == "box":
        return meshes.box(shape.size)
    if shape.kind == "sphere":
        return meshes.sphere(shape.size[0])
    if shape.kind == "cylinder":
        return meshes.cylinder(shape.size[0], shape.size[1])
    if shape.kind == "capsule":
        return meshes.capsule(shape.size[0], shape.size[1])
    if shape.vertices is not None and shape.triangles is not None:
        return TriangleMesh(shape.vertices, shape.triangles)
    if shape.file is None:
        raise InvalidArgument("has neither a file nor vertices")
    if not np.all(shape.scale):
        raise InvalidArgument(f"'{shape.file}': scale = {shape.scale.tolist()}: must have no 0")
    loaded = meshes.load(shape.file)
    if not isinstance(loaded, TriangleMesh):
        raise InvalidArgument(f"'{shape.file}' is no surface")
    scaled = TriangleMesh(loaded.vertices * (unit_of(shape.file) * shape.scale), loaded.triangles)
    # A mirror turns the triangles over.
    return scaled.flipped() if np.prod(shape.scale) < 0.0 else scaled


def _finite(surface: TriangleMesh, shape: Geometry) -> TriangleMesh:
    """The surface, or InvalidMesh where a vertex is no number."""
    wrong = np.flatnonzero(~np.isfinite(surface.vertices).all(axis=1))
    if len(wrong):
        where = "" if shape.file is None else f"'{shape.file}': "
        at = ", ".join(f"{x:g}" for x in surface.vertices[wrong[0]])
        raise InvalidMesh(
            f"{where}vertex {wrong[0]} is at ({at}) m: positions must be finite; repair or remove this vertex"
        )
    return surface


def unit_of(file: Path) -> float:
    """Metres in the unit of a mesh file. Collada files name theirs, which trimesh does not apply; all others
    are taken as metres."""
    if file.suffix.lower() != ".dae":
        return 1.0
    with file.open("rb") as stream:
        found = re.search(rb"<unit\b[^>]*\bmeter\s*=\s*[\"']([^\"']+)[\"']", stream.read(1 << 16))
    try:
        unit = 1.0 if found is None else float(found[1])
    except ValueError:
        unit = math.nan
    if not 0.0 < unit < math.inf:
        raise InvalidArgument(f"'{file}': <unit>: must be a positive number of metres")
    return unit


def _without_flat(surface: TriangleMesh, title: str, report: Report | None) -> TriangleMesh:
    """Without triangles of no area, and with equal vertices as one."""
    surface = meshes.merged(surface)
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    sides = np.stack([b - a, c - b, a - c], axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    twice_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    good = twice_area > 1e-9 * longest**2
    if good.all():
        return surface
    if report is not None:
        report.add("dropped", title, f"{int((~good).sum())} triangles of a mesh that have no area")
    return meshes.compact(TriangleMesh(surface.vertices, surface.triangles[good]))
