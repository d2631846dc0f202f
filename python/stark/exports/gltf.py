"""Stills as binary glTF, through trimesh: Y up, metres, one named mesh a body, fields as attributes of the
vertices. [glTF 2.0, https://registry.khronos.org/glTF]"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stark._interrupts import Deferred
from stark.array_file import write_atomically
from stark.render.camera import upright
from stark.render.colormaps import linear

from .shots import Shot

_MISSING = "glTF needs the package trimesh of the extra 'export': pip install 'stark-sim[export]'"
#: The z axis of what stands upright is the y axis of glTF.
_Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


class GltfWriter:
    """Writes the last time to ``path``, or, with ``each``, every time to a file with its number."""

    def __init__(self, path: Path, *, each: bool) -> None:
        try:
            with Deferred():  # it swallows what is raised while it is imported, also KeyboardInterrupt
                import trimesh
        except ImportError as error:
            raise ImportError(_MISSING) from error
        self._trimesh: Any = trimesh
        self._path, self._each = path, each
        self._last: Shot | None = None
        self._written: list[Path] = []

    def add(self, shot: Shot) -> None:
        """Takes note of a time, or writes it."""
        self._last = shot
        if self._each:
            self._write(shot, self._path.with_name(f"{self._path.stem}_{shot.index:06d}{self._path.suffix}"))

    def finish(self) -> list[Path]:
        """Writes the last time."""
        if not self._each and self._last is not None:
            self._write(self._last, self._path)
        return self._written

    def abandon(self) -> None:
        """Removes what was written."""
        for file in self._written:
            file.unlink(missing_ok=True)

    def _write(self, shot: Shot, path: Path) -> None:
        scene, turn = self._trimesh.Scene(), _Y_UP.copy()
        turn[:3, :3] = turn[:3, :3] @ upright(shot.up)
        for body, color in zip(shot.bodies, shot.colors, strict=True):
            if not len(body.triangles):
                continue
            shade = [*(round(255.0 * float(c)) for c in linear(color)), 255]  # factors are linear light
            material = self._trimesh.visual.material.PBRMaterial(
                baseColorFactor=shade, metallicFactor=0.0, roughnessFactor=0.7, doubleSided=True
            )
            mesh = self._trimesh.Trimesh(
                body.positions,
                body.triangles,
                process=False,
                visual=self._trimesh.visual.TextureVisuals(material=material),
            )
            for name, values in shot.fields.items():
                if body.name in values:
                    mesh.vertex_attributes[f"_{name.upper()}"] = np.asarray(
                        values[body.name], dtype=np.float32
                    )
            scene.add_geometry(mesh, node_name=body.name, geom_name=body.name, transform=turn)
        data = scene.export(file_type="glb")
        write_atomically(path, lambda file: file.write(data))
        self._written.append(path)
