"""Pictures as arrays: notebooks show them, what is computed from them is plain."""

from __future__ import annotations

import numpy as np

from stark.render import Picture, read_png


def test_notebooks_show_pictures_only(tmp_path) -> None:
    pixels = np.random.default_rng(3).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    picture = Picture.of(pixels)
    (tmp_path / "p.png").write_bytes(picture._repr_png_())
    assert np.array_equal(read_png(tmp_path / "p.png"), pixels)
    assert picture[:2]._repr_png_() is not None
    for part in (picture[..., 0], picture[0, 0], picture[:0], picture.astype(float)):
        assert part._repr_png_() is None


def test_numbers_and_masks_are_plain() -> None:
    picture = Picture.of(np.full((2, 2, 3), 7, dtype=np.uint8))
    assert type(picture.mean()) is np.float64
    assert type(picture > 3) is np.ndarray and type(picture + 1) is np.ndarray
    assert isinstance(picture, np.ndarray) and type(picture[:1]) is Picture
