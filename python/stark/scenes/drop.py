"""A soft CAD part, a nut, falls into a cloth hammock and presses it on the floor.

The mesh is ``nut.ply`` of the package pyvista (MIT licence), which the extra ``samples`` brings along;
pytetwild fills it with tetrahedra.
"""

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np

import stark

from ._common import no_nans

until: float = 1.5  # [s]
_SIZE = 0.12  # largest extent of the nut [m]
_HAMMOCK = (0.6, 0.36, 0.15)  # length, width and height above the floor [m]


def settings() -> dict[str, object]:
    return {"time_step": 1.0 / 60.0, "contact_distance": 0.001}


def nut() -> stark.TetMesh:
    """The nut about the origin, as tetrahedra [m]."""
    package = importlib.util.find_spec("pyvista")
    if package is None or package.origin is None:
        raise ImportError(
            "the scene 'drop' needs the packages of the extra 'samples': pip install 'stark-sim[samples]'"
        )
    surface = stark.mesh.load(Path(package.origin).parent / "examples" / "nut.ply").centered()
    surface = surface.scaled(_SIZE / float(np.ptp(surface.vertices, axis=0).max()))
    return stark.mesh.tetrahedralise(surface, edge_length=0.1 * _SIZE)


def build() -> stark.Scene:
    scene = stark.Scene()
    scene.default_friction = 0.5
    length, width, height = _HAMMOCK
    cloth = stark.mesh.grid(length, width, cells=(40, 24))
    hammock = scene.add_cloth(cloth, stark.materials.cotton, name="hammock", position=(0.0, 0.0, height))
    hammock.pin(np.abs(cloth.vertices[:, 0]) > 0.5 * length - 1e-9)
    rubber = stark.materials.soft_rubber.replace(youngs_modulus=2e5)
    turn = stark.rotation(axis="x", angle=60 * stark.deg) @ stark.rotation(axis="z", angle=25 * stark.deg)
    scene.add_solid(nut(), rubber, name="nut", position=(0.03, 0.02, height + 0.14), rotation=turn)
    scene.add_box((4.0, 4.0, 0.1), name="floor", position=(0.0, 0.0, -0.05), motion="fixed")
    return scene


def check(run: Any) -> None:
    nut_end, hammock = no_nans(run, "nut"), no_nans(run, "hammock")
    assert nut_end[:, 2].min() > 0.0 and hammock[:, 2].min() > 0.0, "something went into the floor"
    center = nut_end.mean(axis=0)
    assert np.abs(center[:2]).max() < 0.15, "the nut fell out of the hammock"
    below = hammock[np.hypot(*(hammock[:, :2] - center[:2]).T) < 0.02]
    assert len(below) and below[:, 2].max() < center[2], "the nut went through the hammock"
    assert center[2] < _HAMMOCK[2], "the nut did not fall into the hammock"
    size = np.ptp(run.positions("nut", 0), axis=0).max()
    assert np.ptp(nut_end, axis=0).max() < 1.3 * size, "the nut came apart"
