"""VTU files with fields, and the PVD file that lists them by time: for ParaView, without a package."""

from __future__ import annotations

from pathlib import Path

from stark.array_file import write_atomically
from stark.recording.export import pvd_bytes, vtu_bytes
from stark.recording.format import Frame

from .shots import Shot


class VtuWriter:
    """Writes ``fall_000000.vtu`` and so on beside ``fall.pvd``, which comes last."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._series: list[tuple[float, str]] = []
        self._written: list[Path] = []

    def add(self, shot: Shot) -> None:
        """Writes the file of a time."""
        file = self._path.with_name(f"{self._path.stem}_{shot.index:06d}.vtu")
        data = vtu_bytes(Frame(shot.index, shot.time, shot.bodies), shot.point_data)
        write_atomically(file, lambda out: out.write(data))
        self._written.append(file)
        self._series.append((shot.time, file.name))

    def finish(self) -> list[Path]:
        """Writes the list."""
        data = pvd_bytes(self._series)
        write_atomically(self._path, lambda out: out.write(data))
        return [*self._written, self._path]

    def abandon(self) -> None:
        """Removes what was written."""
        for file in self._written:
            file.unlink(missing_ok=True)
