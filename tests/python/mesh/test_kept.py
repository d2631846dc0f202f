"""Meshes of a randomised mesher come out the same again, in later processes as well."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from stark import mesh
from stark.mesh import kept

_BALL = mesh.sphere(0.1, 2)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    pytest.importorskip("platformdirs")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    place = kept.folder()
    assert place == tmp_path / "stark" / "meshes"
    yield place


class Mesher:
    """Boxes, each a little larger than the one before."""

    calls = 0

    def __call__(self) -> mesh.TetMesh:
        self.calls += 1
        return mesh.tet_box(1.0 + 0.1 * self.calls, 1)


def test_the_same_surface_and_arguments_give_the_same_mesh(folder: Path) -> None:
    mesher = Mesher()
    first, again = (kept.kept(_BALL, "fine", mesher) for _ in range(2))
    assert mesher.calls == 1 and np.array_equal(first.vertices, again.vertices)
    assert first.tets.dtype == again.tets.dtype and np.array_equal(first.tets, again.tets)
    kept.kept(_BALL, "coarse", mesher)
    kept.kept(_BALL.scaled(1.0 + 1e-15), "fine", mesher)
    assert mesher.calls == 3 and len(list(folder.iterdir())) == 3


def test_tetrahedra_of_two_processes_are_the_same() -> None:
    pytest.importorskip("pytetwild")
    program = (
        "import hashlib\nfrom stark import mesh\n"
        "m = mesh.tetrahedralise(mesh.sphere(0.1, 2), edge_length=0.06)\n"
        "print(hashlib.sha256(m.vertices.tobytes() + m.tets.tobytes()).hexdigest())"
    )
    first, again = (
        subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    )
    assert first == again
    other = mesh.tetrahedralise(_BALL, edge_length=0.06, keep=False)
    same = mesh.tetrahedralise(_BALL, edge_length=0.06)
    assert not np.array_equal(other.vertices, same.vertices)


def test_a_damaged_file_is_made_anew(folder: Path) -> None:
    mesher = Mesher()
    kept.kept(_BALL, "fine", mesher)
    (path,) = folder.iterdir()
    path.write_bytes(path.read_bytes()[:100])
    kept.kept(_BALL, "fine", mesher)
    kept.kept(_BALL, "fine", mesher)
    assert mesher.calls == 2


def test_where_nothing_can_be_written_nothing_is_kept(folder: Path) -> None:
    folder.parent.write_text("a file where a folder should be")
    mesher = Mesher()
    kept.kept(_BALL, "fine", mesher)
    kept.kept(_BALL, "fine", mesher)
    assert mesher.calls == 2


def test_the_ones_longest_unused_go_first(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kept, "_MOST", 2)
    mesher = Mesher()
    for name in ("a", "b", "a", "c"):
        kept.kept(_BALL, name, mesher)
        time.sleep(0.03)  # some file systems count time in hundredths of a second
    assert mesher.calls == 3 and len(list(folder.iterdir())) == 2
    kept.kept(_BALL, "a", mesher)
    assert mesher.calls == 3
    kept.kept(_BALL, "b", mesher)
    assert mesher.calls == 4
