"""examples/hammock.py: its scanner makes a dirty scan, which is repaired; the rabbit comes to rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stark import mesh, scenes

EXAMPLE = Path(__file__).parents[3] / "examples/hammock.py"


def test_the_scanner_is_careless_and_the_repair_finds_the_model_again() -> None:
    module = scenes.load(EXAMPLE).module
    ball = mesh.sphere(0.12, 5)
    model = mesh.TriangleMesh(ball.vertices * (1.0, 0.6, 0.8), ball.triangles)
    scan = module.scan(model)
    assert not scan.is_closed and len(scan.vertices) > 1.5 * len(model.vertices)
    np.testing.assert_array_equal(scan.vertices, module.scan(model).vertices)
    report = mesh.MeshReport()
    repaired = mesh.cleaned(scan, report=report)
    assert repaired.is_closed and repaired.volume == pytest.approx(model.volume, rel=0.01)
    for change in ("merged", "pieces", "turned", "filled"):
        assert report.count(change) > 0, change


@pytest.mark.slow
def test_the_rabbit_rests_in_the_hammock(tmp_path: Path) -> None:
    for package in ("pybullet_data", "trimesh", "pytetwild", "fast_simplification"):
        pytest.importorskip(package)
    scene = scenes.load(EXAMPLE, {"edge": "0.035", "cells": "24"})
    result = scenes.run(scene, out=tmp_path / "run", replay=False, picture=False)
    assert (result.status, result.rejected_steps) == ("complete", 0), result.message


def test_the_hammock_names_the_extra_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    module = scenes.load(EXAMPLE).module
    monkeypatch.setattr(module.running.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match=r"pip install 'stark-sim\[examples\]'"):
        module.rabbit()
