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


def test_edge_lengths() -> None:
    square = mesh.grid(1.0, 1.0, 1)
    assert np.sort(mesh.edge_lengths(square)) == pytest.approx([1.0, 1.0, 1.0, 1.0, np.sqrt(2.0)])
    with pytest.raises(stark.InvalidMesh, match="edge_lengths: got int"):
        mesh.edge_lengths(3)  # type: ignore[arg-type]
