"""Tetrahedra in closed surfaces, with the edge length that was asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark
from stark import mesh


def test_the_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pytetwild", None)
    with pytest.raises(ImportError, match=r"stark-sim\[mesh\]"):
        mesh.tetrahedralise(mesh.box(1.0))


def test_open_surfaces_have_no_volume_to_mesh() -> None:
    with pytest.raises(stark.InvalidMesh, match=r"open at 4 edges, the first ones.*must be a closed surface"):
        mesh.tetrahedralise(mesh.grid(1.0, 1.0, 1))


def test_tetrahedralise(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pytetwild")
    monkeypatch.chdir(tmp_path)
    volume = mesh.tetrahedralise(mesh.sphere(0.1, 2), edge_length=0.05, keep=False)
    assert (volume.volumes > 0).all()
    assert volume.volume == pytest.approx(mesh.sphere(0.1, 2).volume, rel=0.03)
    stark.Scene().add_solid(volume)
    assert not list(tmp_path.iterdir())  # fTetWild writes a file


@pytest.mark.parametrize("length", [0.25, 0.15])
def test_edges_are_as_long_as_was_asked(length: float) -> None:
    pytest.importorskip("pytetwild")
    found = mesh.edge_lengths(mesh.tetrahedralise(mesh.sphere(1.0, 4), edge_length=length, keep=False))
    assert abs(found.mean() - length) < 0.15 * length


def test_a_mesher_that_misses_is_asked_until_it_hits(monkeypatch: pytest.MonkeyPatch) -> None:
    unit, diagonal, wanted, asked = mesh.tet_box(1.0, 2), np.sqrt(3.0), 0.12, []

    def obedient(length: float) -> float:
        return 1.5 * length if length < wanted else 1.2 * length

    def stubborn(surface: mesh.TriangleMesh, fraction: float, tolerance: float) -> mesh.TetMesh:
        asked.append(fraction * diagonal)
        length = answer(asked[-1])
        return mesh.TetMesh(unit.vertices * length / mesh.edge_lengths(unit).mean(), unit.tets)

    def off() -> float:
        asked.clear()
        found = mesh.edge_lengths(mesh.tetrahedralise(mesh.box(1.0), edge_length=wanted, keep=False)).mean()
        return float(abs(found / wanted - 1.0))

    monkeypatch.setattr("stark.mesh.tetrahedra._filled", stubborn)
    answer = obedient
    assert off() < 0.1 and len(asked) == 3  # 1.2 of it, then 1.25, then right
    answer = lambda length: 0.16 if length < 0.07 else 0.09  # noqa: E731
    assert off() == pytest.approx(0.25) and len(asked) == 4  # the nearest of those that there are


@pytest.mark.parametrize("thickness", [1e-5, 1e-3, 2e-3])
def test_sheets_that_are_lost_within_the_tolerance_are_refused(thickness: float) -> None:
    """fTetWild leaves nothing of those, and may crash at the next one."""
    pytest.importorskip("pytetwild")
    with pytest.raises(stark.InvalidMesh, match=r"may move by 0.002 m and is .* must be thicker than twice"):
        mesh.tetrahedralise(mesh.box((0.2, 0.2, thickness)), edge_length=0.02, keep=False)


def test_thin_sheets_with_a_tolerance_of_their_own() -> None:
    pytest.importorskip("pytetwild")
    sheet = mesh.box((0.1, 0.1, 1e-3))
    solid = mesh.tetrahedralise(sheet, edge_length=0.01, tolerance=0.1 * 1e-3 / 0.1415, keep=False)
    assert solid.volume == pytest.approx(1e-5, rel=0.01)


def test_edges_that_are_long_for_the_body() -> None:
    """A quarter of the diagonal is a mesh; more than all of it is most likely a mistake with units."""
    pytest.importorskip("pytetwild")
    box = mesh.joined([mesh.box((0.1, 0.06, 0.04)), mesh.box(0.05)])
    found = mesh.tetrahedralise(box, edge_length=0.03, keep=False)  # 0.24 of the diagonal
    assert found.volume == pytest.approx(2.65e-4, rel=0.05)
    for length in (0.5, 100.0):
        with pytest.raises(
            stark.InvalidArgument, match=rf"edge_length = {length:g} m: must be at most the diagonal"
        ):
            mesh.tetrahedralise(box, edge_length=length, keep=False)
    for tolerance in (0.0, -1.0, np.nan):
        with pytest.raises(stark.InvalidArgument, match="tetrahedralise: tolerance = "):
            mesh.tetrahedralise(box, edge_length=0.02, tolerance=tolerance, keep=False)


def test_longer_edges_than_the_mesher_makes_are_not_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    unit, asked = mesh.tet_box(1.0, 2), []

    def short(surface: mesh.TriangleMesh, fraction: float, tolerance: float) -> mesh.TetMesh:
        asked.append(fraction)
        share = growing * fraction if growing else 0.1
        return mesh.TetMesh(unit.vertices * share * np.sqrt(3.0) / mesh.edge_lengths(unit).mean(), unit.tets)

    monkeypatch.setattr("stark.mesh.tetrahedra._filled", short)
    growing = 0.0
    mesh.tetrahedralise(mesh.box(1.0), edge_length=0.26 * np.sqrt(3.0), keep=False)
    assert asked == pytest.approx([0.26, 0.5])  # the second one gained nothing
    asked.clear()
    growing = 0.7
    mesh.tetrahedralise(mesh.box(1.0), edge_length=0.9 * np.sqrt(3.0), keep=False)
    assert asked == pytest.approx([0.9])


def test_edge_lengths() -> None:
    square = mesh.grid(1.0, 1.0, 1)
    assert np.sort(mesh.edge_lengths(square)) == pytest.approx([1.0, 1.0, 1.0, 1.0, np.sqrt(2.0)])
    with pytest.raises(stark.InvalidMesh, match="edge_lengths: got int"):
        mesh.edge_lengths(3)  # type: ignore[arg-type]
