"""Pieces of bodies: values at drawn vertices, clip planes, colours."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import stark
from stark.palette import body_colors
from stark.render.clipping import Plane
from stark.render.pieces import NEUTRAL, at_surface, crease_angle, pieces_of
from stark.tubes import rings


@pytest.fixture
def sim() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_solid(stark.mesh.tet_box((0.2, 0.2, 0.2), (3, 3, 3)), name="jelly")
    scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=3), name="cloth", position=(1.0, 0.0, 0.0))
    scene.add_rod(np.linspace((2.0, 0.0, 0.0), (2.2, 0.0, 0.0), 5), name="rod")
    scene.add_box(0.2, name="box", position=(3.0, 0.0, 0.0), mass=1.0)
    return stark.Simulation(scene)


def test_values_of_all_vertices_come_to_drawn_ones(sim) -> None:
    """x is linear along bodies: at the vertices of surfaces and of the tubes of rods it is x again."""
    for body in sim.bodies:
        shown = at_surface(body, body.positions[:, 0])
        assert shown == pytest.approx(body.surface_positions[:, 0], abs=1e-12), body.name


def pieces(sim, values=None, planes=None):
    n = len(sim.bodies)
    return pieces_of(
        sim.bodies, body_colors(sim.bodies), [False] * n, [1.0] * n, values or {}, planes or [None] * n
    )


def test_others_are_neutral_where_values_are_shown(sim) -> None:
    plain = {piece.name: piece for piece in pieces(sim)}
    assert NEUTRAL not in {piece.color for piece in plain.values()}
    shown = {p.name: p for p in pieces(sim, {"jelly": sim["jelly"].positions[:, 2]})}
    assert shown["jelly"].values is not None and shown["box"].values is None
    assert {shown[name].color for name in ("cloth", "rod", "box")} == {NEUTRAL}
    assert crease_angle(plain["cloth"]) == math.pi > crease_angle(plain["box"])


def test_clipped_solids_show_their_section(sim) -> None:
    plane = Plane.of((0, 0, 0.013), (0, 0, 1))
    values = {"jelly": sim["jelly"].positions[:, 0]}
    outside, inside, *_ = pieces(sim, values, [plane, None, None, plane])
    assert outside.name == inside.name == "jelly"
    assert outside.positions[outside.triangles][..., 2].max() == pytest.approx(0.013)
    assert inside.positions[:, 2] == pytest.approx(0.013)
    assert inside.values == pytest.approx(inside.positions[:, 0])


def section_area(piece) -> float:
    x = piece.positions[piece.triangles]
    return float(0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum())


def test_clipped_rigid_bodies_and_rods_are_filled_and_cloth_is_not(sim) -> None:
    plane = Plane.of((0, 0, 0.013), (0, 0, 1))
    along = Plane.of((2.1, 0, 0), (1, 0, 0))
    cut = pieces(sim, {"box": sim["box"].positions[:, 0]}, [None, plane, along, plane])
    box, filled = (piece for piece in cut if piece.name == "box")
    assert section_area(filled) == pytest.approx(0.04)
    assert filled.positions[:, 2] == pytest.approx(0.013, abs=1e-4)
    assert (
        filled.values is None and filled.color == NEUTRAL and not filled.outlined
    )  # values inside are not known
    assert box.values is not None and box.outlined
    radius = np.linalg.norm(sim["rod"].surface_positions[0, 1:])
    rod = [piece for piece in cut if piece.name == "rod"][1]
    assert 0.8 * math.pi * radius**2 < section_area(rod) < math.pi * radius**2  # of a tube with few sides
    assert [piece.name for piece in cut].count("cloth") == 1


def test_thin_tubes_are_as_wide_as_can_be_seen(sim) -> None:
    """Rods and the prisms of fibres get the least radius that is asked for, around the same lines."""
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=4), name="sheet")
    wire = stark.materials.steel_wire
    fibres = sheet.add_fibres(wire.replace(radius=1e-4), paths=[range(5, 10), range(15, 20)], bending=False)
    ribbon = scene.add_rod(np.eye(3), wire.replace(width=4e-3, height=3e-4), name="ribbon")

    def widths(body, least: float) -> np.ndarray:
        args = [body], [NEUTRAL], [False], [1.0], {}, [None]
        thin, wide = (pieces_of(*args, thinnest=t)[0] for t in (None, lambda p: np.full(len(p), least)))
        assert (thin.triangles == wide.triangles).all() and thin.positions.shape == wide.positions.shape
        sections = rings(len(wide.positions), wide.triangles)
        corners, before = wide.positions[sections], thin.positions[sections]
        assert corners.mean(axis=1) == pytest.approx(before.mean(axis=1), abs=1e-13)
        return np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2)

    assert widths(fibres, 1e-3) == pytest.approx(np.full((16, 8), 1e-3))
    assert widths(fibres, 5e-5) == pytest.approx(np.full((16, 8), 1e-4))
    assert widths(ribbon, 4e-3) == pytest.approx(np.full((3, 4), 4e-3))
    assert widths(ribbon, 2e-3) == pytest.approx(np.full((3, 4), np.hypot(2e-3, 1.5e-4)))
    assert widths(sim["rod"], 0.01).max() == pytest.approx(0.01)
    for body in (sim["jelly"], sheet, sim["box"]):
        assert rings(len(body.surface_positions), body.surface_triangles) is None


def test_scenery_is_not_cut(sim) -> None:
    plane, box = Plane.of((3.0, 0, 0), (1, 0, 0)), [sim["box"]]
    for far, right in ((True, 3.1), (False, 3.0)):
        piece, *cut = pieces_of(box, [NEUTRAL], [far], [1.0], {}, [plane])
        assert len(cut) == (0 if far else 1)
        assert piece.positions[piece.triangles][..., 0].max() == pytest.approx(right)


def test_hexahedra_have_sections_too() -> None:
    scene = stark.Scene()
    scene.add_solid(stark.mesh.box_hexahedra((0.2, 0.2, 0.2), (2, 2, 2)), name="block")
    block = scene["block"]
    body = SimpleNamespace(bodies=[block])
    low, high = block.positions.min(axis=0), block.positions.max(axis=0)
    plane = Plane.of(0.5 * (low + high) + 0.01, (0, 0, 1))
    *_, cut = pieces_of(body.bodies, [NEUTRAL], [False], [1.0], {}, [plane])
    x = cut.positions[cut.triangles]
    area = 0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum()
    assert area == pytest.approx(0.04)
