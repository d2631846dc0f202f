"""Exports frames: PLY and OBJ for modelling tools, VTU with a PVD index for ParaView. Own writers, no
dependencies."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from os import PathLike
from pathlib import Path
from typing import BinaryIO
from xml.sax.saxutils import quoteattr

import numpy as np

from ..arguments import given_path, is_iterable, shown_value
from ..array_file import naming, write_atomically
from ..files import plain_name, printable
from .format import Frame, RecordingError
from .reader import Recording, given_recording

FORMATS = ("vtu", "ply", "obj")


def merged(frame: Frame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All bodies as one mesh: vertices (n, 3) float32, triangles (m, 3) int32, body of each triangle (m,)
    int32."""
    vertices, triangles, owners, start = [], [], [], 0
    for i, body in enumerate(frame.bodies):
        vertices.append(np.asarray(body.positions, dtype=np.float32))
        triangles.append(np.asarray(body.triangles, dtype=np.int32) + np.int32(start))
        owners.append(np.full(len(body.triangles), i, dtype=np.int32))
        start += len(body.positions)
    if not vertices:
        raise RecordingError("the frame has no bodies; there is nothing to export")
    return np.concatenate(vertices), np.concatenate(triangles), np.concatenate(owners)


def ply_bytes(frame: Frame) -> bytes:
    """One frame as binary little-endian PLY; the face property ``body`` is the index of its body."""
    vertices, triangles, owners = merged(frame)
    header = "\n".join(
        [
            "ply",
            "format binary_little_endian 1.0",
            f"comment Stark, time {frame.time:.9g} s",
            *(
                f"comment body {i}: {' '.join(printable(body.name).split())}"
                for i, body in enumerate(frame.bodies)
            ),
            f"element vertex {len(vertices)}",
            *(f"property float {axis}" for axis in "xyz"),
            f"element face {len(triangles)}",
            "property list uchar int vertex_indices",
            "property int body",
            "end_header\n",
        ]
    )
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("indices", "<i4", 3), ("body", "<i4")])
    faces["count"], faces["indices"], faces["body"] = 3, triangles, owners
    return header.encode("ascii", "replace") + vertices.astype("<f4").tobytes() + faces.tobytes()


def obj_bytes(frame: Frame) -> bytes:
    """One frame as OBJ text with one object a body; nine significant digits keep float32 exactly."""
    lines, start = [f"# Stark, time {frame.time:.9g} s"], 1
    for body in frame.bodies:
        lines.append(f"o {'_'.join(printable(body.name).split())}")
        lines.extend(f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in body.positions.tolist())
        lines.extend(f"f {a + start} {b + start} {c + start}" for a, b, c in body.triangles.tolist())
        start += len(body.positions)
    return ("\n".join(lines) + "\n").encode()


def _data_array(array: np.ndarray, kind: str, name: str, components: int = 1) -> str:
    """Inline binary DataArray: base64 of a uint32 byte count followed by the little-endian values."""
    payload = array.tobytes()
    text = base64.b64encode(np.uint32(len(payload)).astype("<u4").tobytes() + payload).decode()
    attributes = f'type="{kind}" Name="{name}" NumberOfComponents="{components}" format="binary"'
    return f"<DataArray {attributes}>{text}</DataArray>"


def vtu_bytes(frame: Frame, point_data: Mapping[str, np.ndarray] | None = None) -> bytes:
    """One frame as VTU (VTK XML UnstructuredGrid); cell data ``body`` is the index of the body,
    ``point_data`` are numbers (n,) or vectors (n, 3) at all vertices, by name."""
    vertices, triangles, owners = merged(frame)
    point_data = {name: np.asarray(v, dtype="<f4") for name, v in (point_data or {}).items()}
    return vtu_of(vertices.astype("<f4"), [(triangles, 5)], owners, point_data)


def vtu_of(
    points: np.ndarray,
    cells: Sequence[tuple[np.ndarray, int]],
    owners: np.ndarray,
    point_data: Mapping[str, np.ndarray],
) -> bytes:
    """VTU of ``points`` (n, 3), blocks of ``cells`` (m, nodes) with their type in VTK, the index of the body
    of each cell, and numbers (n,) or rows (n, k) at points, in single or double precision as they are."""
    connectivity = np.concatenate([rows.ravel() for rows, _ in cells]).astype("<i4")
    offsets = np.cumsum(np.concatenate([np.full(len(rows), rows.shape[1]) for rows, _ in cells])).astype(
        "<i4"
    )
    types = np.concatenate([np.full(len(rows), kind, dtype="u1") for rows, kind in cells])
    parts = [
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt32">',
        "<UnstructuredGrid>",
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(types)}">',
        f"<Points>{_floats(points, 'Points')}</Points>",
        "<Cells>",
        _data_array(connectivity, "Int32", "connectivity"),
        _data_array(offsets, "Int32", "offsets"),
        _data_array(types, "UInt8", "types"),
        "</Cells>",
        f'<CellData Scalars="body">{_data_array(owners.astype("<i4"), "Int32", "body")}</CellData>',
        "<PointData>",
        *(_floats(values, name) for name, values in point_data.items()),
        "</PointData>",
        "</Piece></UnstructuredGrid></VTKFile>\n",
    ]
    return "\n".join(parts).encode()


def _floats(values: np.ndarray, name: str) -> str:
    components = 1 if values.ndim == 1 else values.shape[1]
    single = values.dtype == np.float32
    return _data_array(
        values.astype("<f4" if single else "<f8"), "Float32" if single else "Float64", name, components
    )


def pvd_bytes(files: Iterable[tuple[float, str]]) -> bytes:
    """ParaView's index of a series of files by time [s]."""
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="Collection" version="1.0" byte_order="LittleEndian"><Collection>',
    ]
    lines += [f'<DataSet timestep="{time:.9g}" part="0" file={quoteattr(name)}/>' for time, name in files]
    return ("\n".join(lines) + "\n</Collection></VTKFile>\n").encode()


def export(
    recording: Recording,
    folder: str | PathLike[str],
    format: str = "vtu",
    *,
    frames: Iterable[int] | None = None,
) -> list[Path]:
    """Writes frames into ``folder`` and returns the files; for ``vtu`` the last one is the ``.pvd``. All
    frames, if ``frames`` is left out: then those of an earlier export that are not among them are removed.
    Raises RecordingError for frames that there are not, or not in rising order, each once."""
    given_recording(recording, "export")
    writers = {"vtu": vtu_bytes, "ply": ply_bytes, "obj": obj_bytes}
    if format not in writers:
        raise RecordingError(f"format '{format}' is unknown; choose one of {', '.join(FORMATS)}")
    chosen = chosen_frames(recording, frames)
    folder = given_path(folder, "export: folder")
    with naming(folder):
        folder.mkdir(parents=True, exist_ok=True)
    stem = plain_name(recording.scene, "run")
    written: list[Path] = []
    series: list[tuple[float, str]] = []
    for index in chosen:
        frame = recording.frame(index)
        data = writers[format](frame)
        path = folder / f"{stem}_{frame.index:06d}.{format}"
        write_atomically(path, partial(_write, data))
        written.append(path)
        series.append((frame.time, path.name))
    if format == "vtu":
        index_path = folder / f"{stem}.pvd"
        write_atomically(index_path, lambda file: file.write(pvd_bytes(series)))
        written.append(index_path)
    if frames is None:
        remove_earlier(folder / stem, format, written)
    return written


def chosen_frames(recording: Recording, frames: Iterable[int] | None) -> list[int]:
    """Numbers of the frames that are exported, all if left out."""
    if frames is None:
        return list(range(len(recording)))
    if isinstance(frames, (str, bytes, Mapping)) or not is_iterable(frames):
        raise RecordingError(
            f"export: frames = {shown_value(frames)}: must be numbers of frames, as [0, 2], or left out for "
            f"all"
        )
    chosen = [recording._frame_index(index) for index in frames]
    for before, after in pairwise(chosen):
        if after <= before:
            raise RecordingError(
                f"export: frame {after} comes after frame {before}: frames must be in the order of time, "
                f"each once; give sorted(set(frames))"
            )
    return chosen


def remove_earlier(stem: Path, suffix: str, written: Iterable[Path]) -> None:
    """Removes the numbered files of an earlier export under this name that were not written again. Programs
    take what is numbered in a row for one series."""
    kept = set(written)
    for path in stem.parent.iterdir():
        number = path.name.removeprefix(f"{stem.name}_").removesuffix(f".{suffix}")
        if path.name != f"{stem.name}_{number}.{suffix}" or not re.fullmatch(r"\d{6,}", number):
            continue
        if path not in kept and path.is_file() and not path.is_symlink():
            with naming(path):
                path.unlink(missing_ok=True)


def _write(data: bytes, file: BinaryIO) -> object:
    return file.write(data)
