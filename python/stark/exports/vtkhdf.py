"""VTKHDF: all times in one file, for ParaView 5.12 and newer. Triangles are stored once.
[https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format, temporal PolyData, version 2.0]"""

from __future__ import annotations

import io
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from stark.array_file import naming, refuse_special
from stark.files import printable
from stark.recording.export import merged
from stark.recording.format import Frame

from .shots import Shot

_MISSING = "VTKHDF needs the package h5py of the extra 'export': pip install 'stark-sim[export]'"
_CELLS = ("Vertices", "Lines", "Polygons", "Strips")
#: Rows are written so many bytes at a time: each write of one has a cost of its own.
_HELD = 1 << 20
#: Of a dataset in one piece [bytes].
_CHUNK = 1 << 16


class _Patient(io.FileIO):
    """A file that goes on where the disk is full: HDF5, once told of it, cannot close its file any more and
    takes the process down. ``error`` is what went wrong first."""

    error: OSError | None = None

    def write(self, data: Any) -> int:
        view, done = memoryview(data).cast("B"), 0
        try:
            while self.error is None and done < len(view):
                done += super().write(view[done:]) or 0
        except OSError as error:
            self.error = error
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error
            return self.tell() if size is None else size

    def check(self) -> None:
        """Raises the error, if there was one."""
        if self.error is not None:
            raise self.error


class VtkHdfWriter:
    """Appends times to a file."""

    def __init__(self, path: Path) -> None:
        try:
            import h5py
        except ImportError as error:
            raise ImportError(_MISSING) from error
        self._h5py, self._path = h5py, path
        self._temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
        with naming(path):
            refuse_special(path)
            self._temporary.unlink(missing_ok=True)
            self._raw = _Patient(self._temporary, "w+")
            self._file: Any = h5py.File(self._raw, "w")
        self._root: Any = self._file.create_group("VTKHDF")
        self._count = 0
        self._rows: dict[str, list[Any]] = {}  # to be written, by dataset
        self._held = 0  # their bytes

    def add(self, shot: Shot) -> None:
        """Appends points and fields."""
        points, triangles, owners = merged(Frame(shot.index, shot.time, shot.bodies))
        with naming(self._path):
            if self._count == 0:
                self._begin(shot, triangles, owners)
            first = self._count * len(points)
            self._append("NumberOfPoints", len(points))
            self._append("Points", points)
            for kind in _CELLS:
                corners = triangles.size if kind == "Polygons" else 0
                self._append(f"{kind}/NumberOfCells", corners // 3)
                self._append(f"{kind}/NumberOfConnectivityIds", corners)
            for name, values in shot.point_data.items():
                self._append(f"PointData/{name}", values)
                self._append(f"Steps/PointDataOffsets/{name}", first)
            for name, value in (
                ("Values", shot.time),
                ("PartOffsets", self._count),
                ("NumberOfParts", 1),
                ("PointOffsets", first),
                ("CellOffsets", np.zeros((1, 4), dtype=np.int64)),
                ("ConnectivityIdOffsets", np.zeros((1, 4), dtype=np.int64)),
                ("CellDataOffsets/body", 0),
            ):
                self._append(f"Steps/{name}", value)
            self._count += 1
            if self._held >= _HELD:
                self._write()
            self._raw.check()

    def finish(self) -> list[Path]:
        """Moves the file into place."""
        try:
            with naming(self._path):
                self._write()
                self._root["Steps"].attrs["NSteps"] = self._count
                self._file.close()
                self._raw.check()
                self._raw.close()
                os.replace(self._temporary, self._path)
        except BaseException:
            self.abandon()
            raise
        return [self._path]

    def abandon(self) -> None:
        """Leaves nothing behind."""
        self._file.close()
        self._raw.close()
        with suppress(OSError):
            self._temporary.unlink(missing_ok=True)

    def _begin(self, shot: Shot, triangles: Any, owners: Any) -> None:
        """What does not change: triangles, and the body of each."""
        self._root.attrs["Version"] = np.array([2, 0], dtype=np.int64)
        kind = self._h5py.string_dtype("ascii", len("PolyData"))
        self._root.attrs.create("Type", np.bytes_("PolyData"), dtype=kind)
        for group in _CELLS:
            cells = triangles if group == "Polygons" else triangles[:0]
            self._root[f"{group}/Offsets"] = 3 * np.arange(len(cells) + 1, dtype=np.int64)
            self._root[f"{group}/Connectivity"] = cells.ravel().astype(np.int64)
        self._root["CellData/body"] = owners
        names = [printable(body.name).encode() for body in shot.bodies]
        self._root.create_group("FieldData").attrs["stark_bodies"] = names

    def _append(self, name: str, value: Any) -> None:
        """Adds rows to a dataset that grows; a number is a row."""
        rows = np.atleast_1d(np.asarray(value))
        self._rows.setdefault(name, []).append(rows)
        self._held += rows.nbytes

    def _write(self) -> None:
        """Writes what was added since the last time."""
        for name, parts in self._rows.items():
            rows = np.concatenate(parts)
            if name not in self._root:
                width = rows.shape[1:]
                most = max(1, _CHUNK // max(1, rows[:1].nbytes))
                chunks = (min(most, max(256, len(rows))), *width)
                self._root.create_dataset(name, data=rows, maxshape=(None, *width), chunks=chunks)
                continue
            data = self._root[name]
            data.resize(len(data) + len(rows), axis=0)
            data[-len(rows) :] = rows
        self._rows, self._held = {}, 0
