"""Mesh files: own readers of STL and NPZ, and the way to those of other files and to other libraries."""

from __future__ import annotations

import io
import math
import os
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidMesh
from stark._interrupts import Deferred
from stark.arguments import given_flag, given_path
from stark.files import read_bytes
from stark.mesh.arguments import require_finite
from stark.mesh.obj_files import read_obj, text_of, vertex_of
from stark.mesh.ply_files import read_ply
from stark.mesh.repair import merged, whole
from stark.mesh.types import EmbeddedMesh, Mesh, SolidMesh, TetMesh, TriangleMesh
from stark.mesh.usd_files import SUFFIXES, read_usd

_LARGEST_ARRAY = 1 << 32  # bytes, after decompression
_VOLUME_FORMATS = {".msh", ".vtk", ".vtu", ".mesh", ".xdmf"}
#: Those that trimesh reads itself; it leaves others to meshio.
_TRIMESH_FORMATS = {
    ".3dxml",
    ".3mf",
    ".ctm",
    ".dae",
    ".glb",
    ".gltf",
    ".off",
    ".step",
    ".stp",
    ".xaml",
    ".zae",
}


def load(path: str | os.PathLike[str], *, merge: bool = True) -> Mesh:
    """Reads a mesh file. OBJ, PLY and STL surfaces and saved meshes (NPZ) need nothing; MSH and VTK volumes
    are read by ``meshio``, all other formats by ``trimesh`` (``pip install stark-sim[mesh]``). Coordinates
    are taken as metres: use ``.scaled`` if they are not. USD says what they are, and which way is up: its
    visible meshes are read by ``usd-core`` as they start, in metres, z up.

    Polygons of OBJ, PLY and DAE become triangles that cover them and nothing else; those that no fan of
    triangles covers need ``manifold3d``, of the same extra. Warns of polygons that cross themselves.

    Programs write a vertex once for each normal or texture coordinate that it has there. Of surfaces that are
    open as written, vertices at exactly the same place become one, unused ones and collapsed triangles go;
    ``merge=False`` keeps them, for slits. Closed surfaces and NPZ stay as they are, and what meshio reads but
    for unused vertices. Of a file with solid cells its surface cells are left out; ``load_groups`` has the
    names of both, and those of parts of an OBJ."""
    file, is_merged = given_path(path, "mesh.load: path"), given_flag(merge, "mesh.load: merge")
    try:
        data = read_bytes(file)
    except OSError as error:
        raise InvalidMesh(f"'{file}': {error.strerror or error}: must be a readable mesh file") from None
    readers: dict[str, Callable[[bytes, Path], Mesh]] = {
        ".obj": lambda data, file: read_obj(data, file).surface,
        ".ply": read_ply, ".stl": _read_stl, ".npz": _read_npz,
    }  # fmt: skip
    suffix = file.suffix.lower()
    if suffix in readers:
        try:
            mesh = readers[suffix](data, file)
        except InvalidMesh as error:
            raise InvalidMesh(f"'{file}': {error}") from None
        except _damage() as error:
            raise InvalidMesh(f"'{file}' is not a valid {suffix[1:].upper()} file: {error}") from None
    elif suffix in _VOLUME_FORMATS:
        from stark.mesh.volume_files import load_by_meshio

        return load_by_meshio(file)
    elif suffix in SUFFIXES:
        mesh = read_usd(file).mesh
    else:
        mesh = _load_by_trimesh(file)
    if isinstance(mesh, TriangleMesh) and len(mesh.triangles) == 0:
        raise InvalidMesh(f"'{file}' has 0 triangles: must have at least one")
    require_finite(mesh.vertices, f"'{file}': vertex")
    if is_merged and suffix != ".npz" and isinstance(mesh, TriangleMesh):
        return whole(mesh)
    return mesh


def _damage() -> tuple[type[Exception], ...]:
    """What readers stumble over in files that are not what they say."""
    import zipfile

    lies = (ValueError, LookupError, TypeError, EOFError, OverflowError, MemoryError, NotImplementedError)
    return (*lies, zipfile.BadZipFile, zlib.error)


def _read_stl(data: bytes, _: Path) -> TriangleMesh:
    corners = _text_stl(text_of(data)) if _is_text_stl(data) else _binary_stl(data)
    require_finite(corners, "corner")
    # STL repeats every vertex for each of its triangles; equal corners are one vertex.
    return merged(TriangleMesh(corners, np.arange(len(corners)).reshape(-1, 3)))


def _is_text_stl(data: bytes) -> bool:
    """Titles of binary files may start with the same word."""
    text = text_of(data[:1024])
    return (
        text.lstrip()[:5].lower() == "solid" and "\0" not in text and len(data) != _size_of_binary_stl(data)
    )


def _size_of_binary_stl(data: bytes) -> int:
    return 84 + 50 * int.from_bytes(data[80:84], "little")


def _binary_stl(data: bytes) -> NDArray[np.float64]:
    """Corners of triangles (3 m, 3): 80 bytes of title, their number, and 50 bytes each."""
    if len(data) < 84:
        raise InvalidMesh(
            f"{len(data)} bytes: must be text that starts with 'solid', or the 84 bytes and more of a binary "
            f"STL file"
        )
    declared, held, rest = int.from_bytes(data[80:84], "little"), *divmod(len(data) - 84, 50)
    if held != declared or rest:
        more = f" and {rest} bytes more" if rest else ""
        raise InvalidMesh(
            f"its header declares {declared} triangles, but it holds {held}{more}: must agree; the file "
            f"was cut off or has something behind its triangles, write it again"
        )
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    corners = np.frombuffer(data, dtype=record, offset=84)["corners"]
    return np.asarray(corners, dtype=np.float64).reshape(-1, 3)


def _text_stl(text: str) -> NDArray[np.float64]:
    corners: list[list[float]] = []
    opened = closed = 0
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        word = words[0].lower() if words else ""
        if word == "vertex":
            corners.append(vertex_of(words, number, line))
        opened += word == "facet"
        closed += word == "endfacet"
    if len(corners) % 3:
        raise InvalidMesh(f"{len(corners)} corners do not make whole triangles: the file was cut off")
    is_ended = "".join(text[-1024:].lower().split()).rfind("endsolid") >= 0
    if len(corners) != 3 * opened or opened != closed or not is_ended:
        raise InvalidMesh(
            f"{opened} facets, of which {closed} end, with {len(corners)} corners, and "
            f"{'an' if is_ended else 'no'} 'endsolid' at the end: must be three corners for each facet, and "
            f"an end; the file was cut off, write it again"
        )
    return np.array(corners).reshape(-1, 3)


_EMBEDDED = ("vertices", "elements", "triangles", "cells", "filling")


def _read_npz(data: bytes, _: Path) -> Mesh:
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        _require_sizes(arrays)
        if "tets" in arrays:
            return TetMesh(arrays["vertices"], arrays["tets"])
        if "filling" in arrays:
            return EmbeddedMesh(**{name: arrays[name] for name in _EMBEDDED})
        if "elements" in arrays:
            return SolidMesh(arrays["vertices"], arrays["elements"])
        return TriangleMesh(arrays["vertices"], arrays["triangles"])


def _require_sizes(arrays: Any) -> None:
    """Arrays as large as they say: memory is taken by what their headers claim."""
    for member in arrays.zip.infolist():
        with arrays.zip.open(member) as stored:
            version = np.lib.format.read_magic(stored)
            header = getattr(np.lib.format, f"read_array_header_{version[0]}_0")(stored)
            shape, _, dtype = header
            if math.prod(shape) * dtype.itemsize > member.file_size or member.file_size > _LARGEST_ARRAY:
                raise InvalidMesh(f"array '{member.filename}' claims the shape {shape}, more than it holds")


def _is_of_meshio(file: Path) -> bool:
    try:
        import meshio
    except ImportError:
        return False
    return file.suffix.lower() in meshio.extension_to_filetypes


def _require_off_counts(file: Path) -> None:
    """As many lines as the header of an OFF file declares: trimesh leaves out what is too much, and takes
    faces for vertices where those are too few. Other headers are left to it."""
    text = text_of(file.read_bytes())
    lines = [words for words in (line.split("#")[0].split() for line in text.splitlines()) if words]
    if not lines or lines[0][0].upper() not in ("OFF", "COFF"):
        return
    lines = [lines[0][1:], *lines[1:]] if len(lines[0]) > 1 else lines[1:]
    if not lines or len(lines[0]) < 2 or not all(word.isdigit() for word in lines[0]):
        return
    vertices, faces = int(lines[0][0]), int(lines[0][1])
    if len(lines) - 1 != vertices + faces:
        raise InvalidMesh(
            f"'{file}' declares {vertices} vertices and {faces} faces, but {len(lines) - 1} lines follow: "
            f"must be one for each; the file was cut off, or its header is wrong, write it again"
        )
    for number, words in enumerate(lines[1 + vertices :]):
        if not words[0].isdigit() or len(words) <= int(words[0]):
            raise InvalidMesh(
                f"'{file}': face {number} (from 0) is '{' '.join(words)}': must be a count and as many "
                f"vertices"
            )


def _loaded_by_trimesh(trimesh: Any, file: Path) -> Any:
    if file.suffix.lower() == ".off":
        _require_off_counts(file)
    if file.suffix.lower() != ".dae":
        # Processing drops vertices that are not finite.
        return trimesh.load(file, force="mesh", process=False)
    from stark.mesh.collada import with_triangles

    data = io.BytesIO(with_triangles(file.read_bytes(), file))
    resolver = trimesh.resolvers.FilePathResolver(file)
    return trimesh.load(data, file_type="dae", force="mesh", resolver=resolver, process=False)


def _load_by_trimesh(file: Path) -> Mesh:
    try:
        with Deferred():  # it swallows what is raised while it is imported, also KeyboardInterrupt
            import trimesh
    except ImportError as error:
        raise ImportError(f"'{file}': this format needs trimesh: pip install 'stark-sim[mesh]'") from error
    if file.suffix.lower() not in _TRIMESH_FORMATS and _is_of_meshio(file):
        from stark.mesh.volume_files import load_by_meshio

        return load_by_meshio(file)
    names = trimesh.available_formats()
    if not any(file.name.lower().endswith(f".{name}") for name in names):
        known = sorted(_TRIMESH_FORMATS & {f".{name}" for name in names})
        raise InvalidMesh(
            f"'{file}': '{file.suffix}' is the suffix of no format of meshes: must be one of .obj, .ply, "
            f".stl, .npz, .usd, {', '.join(known)}, {', '.join(sorted(_VOLUME_FORMATS))}, or another one of "
            f"meshio; convert others, such as Alembic and FBX, to USD or OBJ in a modelling program"
        )
    try:
        loaded: Any = _loaded_by_trimesh(trimesh, file)
    except ImportError as error:
        raise ImportError(f"'{file}': {error}: pip install 'stark-sim[mesh]'") from error
    except InvalidMesh:
        raise
    except Exception as error:  # readers of many formats raise what they like
        raise InvalidMesh(
            f"'{file}' cannot be read: {error}; must be OBJ, PLY, STL, NPZ, or a mesh of a format of "
            f"trimesh or meshio"
        ) from None
    return TriangleMesh(np.asarray(loaded.vertices), np.asarray(loaded.faces))
