"""What is read of point caches, and what is refused."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

import stark
from stark.point_cache import header, read_point_cache

FRAMES = np.arange(18, dtype=np.float32).reshape(3, 2, 3)
GOOD = header(2, 1.0, 0.5, 3) + FRAMES.tobytes()


def test_what_was_written_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.pc2").write_bytes(GOOD)
    cache = read_point_cache(tmp_path / "a.pc2")
    assert (cache.start, cache.rate) == (1.0, 0.5)
    np.testing.assert_array_equal(cache.positions, FRAMES)


def test_the_first_frame_is_at_the_start(tmp_path: Path) -> None:
    (tmp_path / "a.pc2").write_bytes(GOOD)
    for smooth in (False, True):
        motion = stark.motion.point_cache(tmp_path / "a.pc2", fps=25.0, smooth=smooth)
        np.testing.assert_allclose(motion(0.0), FRAMES[0])
        np.testing.assert_allclose(motion(0.04), FRAMES[2], atol=1e-12)  # 2 samples of half a frame


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"v 0 0 0", "is no PC2 point cache"),
        (GOOD[:-1], r"has 103 bytes: must have 104 for 3 frames of 2 points; it was cut off"),
        (struct.pack("<12siiffi", b"POINTCACHE2\0", 1, 0, 0.0, 1.0, 3), "says version 1, 0 points, 3 frames"),
        (header(2, 0.0, float("nan"), 3) + FRAMES.tobytes(), "at a rate above 0"),
    ],
)
def test_damaged_files_are_refused(tmp_path: Path, data: bytes, text: str) -> None:
    (tmp_path / "a.pc2").write_bytes(data)
    with pytest.raises(stark.InvalidArgument, match=text):
        stark.motion.point_cache(tmp_path / "a.pc2")


def test_missing_files_and_rates_are_refused(tmp_path: Path) -> None:
    with pytest.raises(stark.InvalidArgument, match="No such file"):
        stark.motion.point_cache(tmp_path / "none.pc2")
    with pytest.raises(stark.InvalidArgument, match=r"fps = 0\.0: must be > 0"):
        stark.motion.point_cache(tmp_path / "none.pc2", fps=0.0)
