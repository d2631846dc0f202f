"""VTKHDF, read again by h5py, and by VTK where it is installed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from _falls import falling

import stark
from stark.exports.shots import MOTION, Camera
from stark.render.fields import FIELDS as COMPUTED

h5py = pytest.importorskip("h5py", reason="needs the extra 'export'")
FIELDS = (*MOTION, *COMPUTED)


def write(path: Path) -> tuple[list[float], list[np.ndarray], np.ndarray]:
    """Times, all points, triangles; what is written to ``path`` is the same."""
    sim, times, points = falling(), [], []
    with stark.exports.Exporter(path, sim, fields=FIELDS) as out:
        for _ in range(3):
            shot = Camera(()).take(sim, sim.time, 0)
            out.record(sim)
            times.append(sim.time)
            points.append(np.concatenate([body.positions for body in shot.bodies]))
            starts = np.cumsum([0, *(len(body.positions) for body in shot.bodies)])
            triangles = np.concatenate([b.triangles + s for b, s in zip(shot.bodies, starts, strict=False)])
            sim.run_until(sim.time + 0.05)
    return times, points, triangles


def test_a_file_holds_points_triangles_and_fields(tmp_path: Path) -> None:
    times, points, triangles = write(tmp_path / "fall.vtkhdf")
    with h5py.File(tmp_path / "fall.vtkhdf") as file:
        root = file["VTKHDF"]
        assert bytes(root.attrs["Type"]) == b"PolyData" and list(root.attrs["Version"]) == [2, 0]
        steps = root["Steps"]
        assert steps.attrs["NSteps"] == 3
        assert np.array_equal(steps["Values"], times)
        for k, expected in enumerate(points):
            first, count = steps["PointOffsets"][k], root["NumberOfPoints"][k]
            assert np.array_equal(root["Points"][first : first + count], expected)
            moved = root["PointData/displacement"][first : first + count]
            np.testing.assert_allclose(moved, expected - points[0], atol=1e-7)
        assert np.array_equal(root["Polygons/Connectivity"], triangles.ravel())
        for name in FIELDS:
            assert len(root[f"PointData/{name}"]) == sum(map(len, points)), name
        assert root["CellData/body"][:].max() == 2


def test_many_times_are_written_in_few_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from stark.exports.vtkhdf import VtkHdfWriter

    writes: list[int] = []
    write_rows = VtkHdfWriter._write
    monkeypatch.setattr(VtkHdfWriter, "_write", lambda self: (writes.append(self._held), write_rows(self)))
    sim = falling()
    with stark.exports.Exporter(tmp_path / "fall.vtkhdf", sim, fields=("speed",)) as out:
        for _ in range(20):
            out.record(sim)
            sim.step()
    assert len(writes) == 1 and writes[0] > 0
    with h5py.File(tmp_path / "fall.vtkhdf") as file:
        assert len(file["VTKHDF/Steps/Values"]) == 20 and file["VTKHDF/Steps/Values"].chunks == (256,)
        assert file["VTKHDF/Points"].chunks[1] == 3  # a row is in one piece


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".vtkhdf", ".pvd"])
def test_vtk_reads_every_time(tmp_path: Path, suffix: str) -> None:
    pyvista = pytest.importorskip("pyvista", reason="needs the extra 'samples'")
    times, points, triangles = write(tmp_path / f"fall{suffix}")
    if suffix == ".vtkhdf":
        from vtkmodules.vtkIOHDF import vtkHDFReader

        reader = vtkHDFReader()
        reader.SetFileName(str(tmp_path / "fall.vtkhdf"))
        reader.UpdateInformation()
        reader.Update()
        assert reader.GetNumberOfSteps() == 3
    for k, time in enumerate(times):
        if suffix == ".vtkhdf":
            reader.SetStep(k)
            reader.Update()
            mesh = pyvista.wrap(reader.GetOutputDataObject(0))
            assert np.array_equal(mesh.faces.reshape(-1, 4)[:, 1:], triangles)
        else:
            series = pyvista.get_reader(tmp_path / "fall.pvd")
            np.testing.assert_allclose(series.time_values, times, atol=1e-8)
            series.set_active_time_point(k)
            (mesh,) = series.read()
            assert np.array_equal(mesh.cells.reshape(-1, 4)[:, 1:], triangles)
        assert np.array_equal(np.asarray(mesh.points, dtype=np.float32), points[k]), time
        assert set(FIELDS) <= set(mesh.point_data.keys())
        np.testing.assert_allclose(mesh.point_data["displacement"], points[k] - points[0], atol=1e-7)
        assert np.isnan(mesh.point_data["stress"]).any() and np.nanmax(mesh.point_data["stress"]) >= 0.0
