"""Exports to a disk that is full, by a limit on the size of files: named in one line, nothing is left."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from fake_simulation import record

PROGRAM = """
import resource, sys
from stark.cli import main
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize(
    ("format", "package", "reason"),
    [
        ("usd", "pxr", "USD gives up"),
        ("vtkhdf", "h5py", "File too large"),
        ("vtu", "numpy", "File too large"),
    ],
)
def test_a_full_disk_is_named_in_one_line(format: str, package: str, reason: str, tmp_path: Path) -> None:
    """USD and HDF5 ended with pages of their own; HDF5 left a part of the file, or the process crashed."""
    pytest.importorskip(package, reason="needs the extra of the format")
    record(tmp_path / "run", 4)
    command = ["export", str(tmp_path / "run"), "--format", format, "--out", str(tmp_path / "out")]
    ended = subprocess.run([sys.executable, "-c", PROGRAM, *command], capture_output=True, text=True)
    assert ended.returncode == 1
    (line,) = ended.stderr.splitlines()
    assert line.startswith("stark: '") and f"cannot be written: {reason}" in line
    assert not list((tmp_path / "out").iterdir())
