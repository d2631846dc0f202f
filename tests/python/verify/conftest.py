"""Recordings that are certified as they are, for tests that tamper with copies of them."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from _recorded_runs import mechanism, record, sheet_on_box

from stark.verify import verify


@pytest.fixture(scope="session")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sheet that falls onto a box, 20 steps. Files with scenes of their own have another one."""
    folder = tmp_path_factory.mktemp("sheet") / "run"
    record(folder, sheet_on_box(), 20, time_step=0.01, contact_distance=0.001)
    assert verify(folder).verdict == "certified"
    return folder


@pytest.fixture(scope="session")
def joined(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A mechanism of all kinds of joints, 10 steps."""
    folder = tmp_path_factory.mktemp("joints") / "run"
    record(folder, mechanism(), 10, time_step=0.01, contact_distance=0.0005)
    assert verify(folder).verdict == "certified"
    return folder


@pytest.fixture
def run(good: Path, tmp_path: Path) -> Path:
    """A copy of ``good`` to tamper with."""
    return Path(shutil.copytree(good, tmp_path / "run"))
