"""Fixtures of tests of the command."""

from __future__ import annotations

from pathlib import Path

import pytest
from _commands import FALL


@pytest.fixture
def fall(tmp_path: Path) -> Path:
    """A scene file in which a patch of cloth falls freely for 0.1 s, with a check."""
    path = tmp_path / "fall.py"
    path.write_text(FALL)
    return path
