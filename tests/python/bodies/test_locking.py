"""Solids of one to three linear elements across: they are said where they bend too little, and only there."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
import pytest

import stark

LENGTH, WIDTH, HEIGHT = 0.4, 0.1, 0.01  # [m]
RUBBER = stark.SolidMaterial(density=1000.0, youngs_modulus=1e6, poissons_ratio=0.3)


def plate(kind: str, cells: tuple[int, int, int]) -> Any:
    make = stark.mesh.tet_box if kind == "tetrahedra" else stark.mesh.box_hexahedra
    return make((LENGTH, WIDTH, HEIGHT), cells)


def said_of(scene: stark.Scene) -> list[str]:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        stark.Simulation(scene)
    return [str(each.message) for each in told]


def sag(mesh: Any) -> tuple[float, str]:
    """Deflection of a cantilever under a load at its end, over that of the theory of beams, and what is
    said of it."""
    force, (x, _, z) = 1e-5, mesh.vertices.T
    scene = stark.Scene()
    body = scene.add_solid(mesh, RUBBER, pins=np.flatnonzero(x < -0.199))
    end = np.flatnonzero(x > 0.199)
    scene.add_traction(
        body.faces[np.isin(body.triangles, end).all(axis=1)], (0, 0, -force / (WIDTH * HEIGHT))
    )
    said = " ".join(said_of(scene))
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), time={"integrator": "quasistatic"})
    sim.step()
    theory = 12.0 * force * LENGTH**3 / (3.0 * 1e6 * WIDTH * HEIGHT**3)
    return float((z - body.positions[:, 2])[end].mean() / theory), said


@pytest.mark.parametrize("cells", [(40, 10, 1), (20, 5, 1)])
def test_tetrahedra_bend_by_less_than_is_said(cells: tuple[int, int, int]) -> None:
    share, said = sag(plate("tetrahedra", cells))
    assert "solid 'solid': it is one element thick, of linear tetrahedra" in said and "to_quadratic" in said
    assert "is 3 times or more too stiff" in said and share < 1.0 / 3.0


@pytest.mark.parametrize("cells", [(24, 6, 1), (16, 4, 1), (10, 3, 1)])
def test_hexahedra_bend_by_what_is_said(cells: tuple[int, int, int]) -> None:
    share, said = sag(plate("hexahedra", cells))
    found = re.search(r"solid 'solid': it is one element thick, of hexahedra of 8 .* about (\S+) times", said)
    assert found is not None
    assert share * float(found[1]) == pytest.approx(1.0, rel=0.1)  # a fit, said to two digits


@pytest.mark.parametrize(
    ("kind", "cells", "layers"),
    [
        ("tetrahedra", (27, 7, 2), "two elements"),
        ("tetrahedra", (20, 5, 2), "two elements"),
        ("tetrahedra", (20, 5, 3), "three elements"),
        ("hexahedra", (20, 5, 2), "two elements"),
        ("hexahedra", (13, 4, 2), "two elements"),
        ("hexahedra", (20, 5, 3), "three elements"),
    ],
)
def test_layers_of_long_cells_bend_by_what_is_said(
    kind: str, cells: tuple[int, int, int], layers: str
) -> None:
    share, said = sag(plate(kind, cells))
    found = re.search(rf"solid 'solid': it is {layers} thick, of .* about (\S+) times", said)
    assert found is not None
    assert share * float(found[1]) == pytest.approx(1.0, rel=0.1)  # a fit, said to two digits


def test_even_tetrahedra_bend_by_what_is_said() -> None:
    """Unstructured meshes, those of fTetWild for edges as long as the plate is thick; each is another one."""
    pytest.importorskip("pytetwild")
    box, bends = stark.mesh.box((LENGTH, WIDTH, HEIGHT)), []
    for _ in range(5):
        share, said = sag(stark.mesh.tetrahedralise(box, edge_length=0.01, keep=False))
        found = re.search(r"it is (\S+) edges thick, of linear tetrahedra: .* about (\S+) times", said)
        assert found is not None, said
        assert 0.8 < float(found[1]) < 1.3
        bends.append(share * float(found[2]))
    assert bends == pytest.approx(np.ones(5), rel=0.25)  # 10 % apart from each other
    assert np.mean(bends) == pytest.approx(1.0, rel=0.12)  # a fit to meshes of other edges, too
    fine = stark.Scene()
    fine.add_solid(stark.mesh.tetrahedralise(box, edge_length=0.006, keep=False), RUBBER)
    assert said_of(fine) == []


def test_two_layers_of_a_slim_beam_are_said() -> None:
    """Few of its vertices are inside of it."""
    scene = stark.Scene()
    scene.add_solid(stark.mesh.tet_box((0.4, 0.04, 0.04), (7, 2, 2)), RUBBER)
    assert any("it is two elements thick" in text for text in said_of(scene))


@pytest.mark.parametrize(
    "mesh",
    [
        stark.mesh.to_quadratic(plate("tetrahedra", (20, 5, 1))),
        stark.mesh.to_quadratic(plate("hexahedra", (10, 3, 1))),
        plate("hexahedra", (40, 10, 1)),
        plate("tetrahedra", (53, 13, 2)),
        plate("hexahedra", (30, 8, 2)),
        plate("tetrahedra", (20, 5, 4)),
        stark.mesh.tet_box(0.1, 1),
        stark.mesh.tet_box((0.3, 0.1, 0.1), (3, 1, 1)),
        stark.mesh.tet_ball(0.1, 3),
    ],
    ids=["tet10", "hex27", "cubes", "two layers", "two of hexahedra", "four layers", "cube", "brick", "ball"],
)
def test_nothing_is_said_of_others(mesh: Any) -> None:
    scene = stark.Scene()
    scene.add_solid(mesh, RUBBER)
    assert said_of(scene) == []


def test_nothing_is_said_of_what_cannot_bend() -> None:
    """Slices of plane strain, pads that are glued to something."""
    mesh = plate("hexahedra", (16, 4, 1))
    z = mesh.vertices[:, 2]
    slices = stark.Scene()
    solid = slices.add_solid(mesh, RUBBER)
    slices.add_rollers(solid.vertices, "z")
    assert said_of(slices) == []
    glued = stark.Scene()
    pad = glued.add_solid(mesh, RUBBER)
    glued.attach(pad.vertices[z < 0], glued.add_box((1.0, 1.0, 0.1), mass=1.0, position=(0, 0, -0.055)))
    assert said_of(glued) == []
    pinned = stark.Scene()
    pinned.add_solid(mesh, RUBBER, pins=np.flatnonzero(z < 0))
    assert said_of(pinned) == []


def test_curved_walls_are_said() -> None:
    """A half pipe is thin, though its bounds are not."""
    flat = stark.mesh.box_hexahedra(1.0, (12, 8, 1))
    u, v, w = flat.vertices.T
    angle, radius = np.pi * u, 0.1 + 0.01 * w
    bent = np.column_stack((radius * np.sin(angle), 0.3 * v, radius * np.cos(angle)))
    scene = stark.Scene()
    scene.add_solid(stark.mesh.SolidMesh(bent, flat.elements), RUBBER, name="pipe")
    assert any("solid 'pipe': it is one element thick" in text for text in said_of(scene))


@pytest.mark.parametrize(
    ("kind", "cells", "factor"),
    [
        ("tet", 2, 2.8),
        ("tet", 4, 1.49),
        ("hex", 2, 1.19),
        ("hex", 4, 1.06),
        ("tet10", 1, 1.17),
        ("hex27", 2, 1.02),
    ],
)
def test_twisted_bars_take_the_torque_that_is_said(kind: str, cells: int, factor: float) -> None:
    """Over that of Saint-Venant for a square section; the table in docs/solids.md."""
    side, length, modulus, twist = 0.02, 0.2, 1e5, 0.05
    make: Any = stark.mesh.tet_box if kind.startswith("tet") else stark.mesh.box_hexahedra
    mesh = make((side, side, length), (cells, cells, 10 * cells))
    mesh = stark.mesh.to_quadratic(mesh) if kind in ("tet10", "hex27") else mesh
    ends = np.abs(mesh.vertices[:, 2]) > length / 2 - 1e-9
    scene = stark.Scene()
    stuff = stark.SolidMaterial(density=1000.0, youngs_modulus=modulus, poissons_ratio=0.3)
    bar = scene.add_solid(mesh, stuff, pins=np.flatnonzero(ends), self_contact=False)
    top = np.flatnonzero(ends & (mesh.vertices[:, 2] > 0.0))
    bar.follow(rotation=lambda t: stark.rotation(axis="z", angle=twist * t), vertices=top)
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), time={"integrator": "quasistatic"})
    assert not sim.step().failed
    chosen = np.isin(bar.pins, top)
    arms = bar.positions[np.asarray(bar.pins)[chosen]]
    torque = np.cross(arms, bar.pin_forces[chosen]).sum(axis=0)[2]
    exact = 0.1406 * modulus / 2.6 * side**4 * twist / length
    assert abs(torque) / exact == pytest.approx(factor, rel=0.01)
