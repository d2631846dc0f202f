"""Garments from OBJ files whose texture coordinates are the flat pattern."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark
from stark import mesh

RADIUS, HEIGHT, ROUND, HIGH = 0.15, 0.4, 48, 16


def skirt(path: Path) -> None:
    """A tube of quadrangles that is cut open along one line; 20 units of texture are a metre."""
    angles = np.arange(ROUND) * 2.0 * np.pi / ROUND
    side = 2.0 * RADIUS * np.sin(np.pi / ROUND)  # of the polygon
    rows = [
        f"v {RADIUS * np.cos(a)} {RADIUS * np.sin(a)} {HEIGHT * j / HIGH}"
        for j in range(HIGH + 1)
        for a in angles
    ]
    rows += [
        f"vt {20.0 * side * i} {20.0 * HEIGHT * j / HIGH}" for j in range(HIGH + 1) for i in range(ROUND + 1)
    ]
    rows += ["usemtl denim"]
    for j in range(HIGH):
        for i in range(ROUND):
            corners = [(j, i), (j, i + 1), (j + 1, i + 1), (j + 1, i)]
            numbers = [(ROUND * y + x % ROUND + 1, (ROUND + 1) * y + x + 1) for y, x in corners]
            rows.append("f " + " ".join(f"{v}/{t}" for v, t in numbers))
    path.write_text("\n".join(rows) + "\n")


def test_a_tube_is_a_sheet_with_a_seam(tmp_path: Path) -> None:
    skirt(tmp_path / "skirt.obj")
    flat, worn, seams, scale = mesh.load_pattern(tmp_path / "skirt.obj")
    assert scale == pytest.approx(0.05, rel=1e-12)
    assert len(flat.vertices) == (ROUND + 1) * (HIGH + 1) == len(worn) and len(seams) == HIGH + 1
    assert (worn[seams[:, 0]] == worn[seams[:, 1]]).all()
    around = 2.0 * ROUND * RADIUS * np.sin(np.pi / ROUND)
    gaps = flat.vertices[seams[:, 0]] - flat.vertices[seams[:, 1]]
    assert np.abs(gaps) == pytest.approx(np.tile((around, 0.0, 0.0), (HIGH + 1, 1)), abs=1e-12)
    assert flat.area == pytest.approx(around * HEIGHT, rel=1e-12)
    ends = [m.vertices[m.triangles] for m in (mesh.TriangleMesh(worn, flat.triangles), flat)]
    edges = [np.linalg.norm(e - np.roll(e, 1, axis=1), axis=2) for e in ends]
    assert edges[0] == pytest.approx(edges[1], rel=1e-9)  # a developable shape
    assert mesh.load_pattern(tmp_path / "skirt.obj", scale=0.1).mesh.area == pytest.approx(4.0 * flat.area)
    groups = mesh.load_groups(tmp_path / "skirt.obj")
    assert groups["denim"].elements.tolist() == list(range(len(flat.triangles)))


def test_it_is_sewn_and_worn(tmp_path: Path) -> None:
    """It starts without strain, and the seam holds it together where it hangs from two points."""
    skirt(tmp_path / "skirt.obj")
    garment = mesh.load_pattern(tmp_path / "skirt.obj")
    scene = stark.Scene()
    cloth = scene.add_cloth(garment.mesh, stark.materials.cotton, initial_positions=garment.positions)
    scene.attach(cloth, cloth, pairs=garment.seams)
    top = np.flatnonzero(garment.positions[:, 2] > HEIGHT - 1e-9)
    hold = scene.attach(cloth.vertices[top[[12, 36]]], None)
    sim = stark.Simulation(scene, time_step=0.01)
    assert stark.render.field_values(sim, "strain")[cloth.name].max() < 1e-9
    sim.run_until(1.5)
    apart = cloth.positions[garment.seams[:, 0]] - cloth.positions[garment.seams[:, 1]]
    assert abs(apart).max() < 1e-6
    assert hold.force[2] == pytest.approx(9.81 * cloth.mass, rel=0.1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 4: a corner of the face has no texture coordinates"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/2\n", "line 5: a corner of the face has no texture"),
        ("v 0 0 0\nv 1 0 0\nvt 0 0\nf 1/1 2/1 3/1\n", r"has the vertex 3: must be in \[1, 2\]"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nf 1/1 2/2 3/2\n", "triangle 0 has no area in texture"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0\nvt 1\nvt 2\nf 1/1 2/2 3/3\n", "coordinates are not finite"),
        ("v 0 0 0\nvt x 0\n", "line 2: could not convert"),
        ("v 0 0 0\n", "has 0 faces"),
    ],
)
def test_what_is_no_pattern_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "bad.obj").write_text(text)
    with pytest.raises(stark.InvalidMesh, match=message) as caught:
        mesh.load_pattern(tmp_path / "bad.obj")
    assert "bad.obj'" in str(caught.value)


def test_other_files_and_scales_are_refused(tmp_path: Path) -> None:
    skirt(tmp_path / "skirt.obj")
    for scale in (0.0, -1.0, np.nan, "1"):
        with pytest.raises(stark.InvalidArgument, match="load_pattern: scale ="):
            mesh.load_pattern(tmp_path / "skirt.obj", scale=scale)  # type: ignore[arg-type]
    with pytest.raises(stark.InvalidMesh, match="must be an OBJ file"):
        mesh.load_pattern(tmp_path / "skirt.stl")
    with pytest.raises(stark.InvalidMesh, match="No such file"):
        mesh.load_pattern(tmp_path / "none.obj")
