"""PNG files: what other programs read, damage, arrays that are no pictures."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

import stark
from stark.render import read_png, write_png


def test_png_roundtrip_and_structure(tmp_path: Path) -> None:
    picture = np.random.default_rng(1).integers(0, 256, (31, 17, 3), dtype=np.uint8)
    write_png(tmp_path / "p.png", picture)
    assert np.array_equal(read_png(tmp_path / "p.png"), picture)
    data = (tmp_path / "p.png").read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack_from(">II", data, 16) == (17, 31)
    assert data[-12:] == struct.pack(">I", 0) + b"IEND" + struct.pack(">I", zlib.crc32(b"IEND"))


@pytest.mark.parametrize("name", ["p.jpg", "p.JPEG", "p.svg"])
def test_names_of_other_formats_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match=r"must be a PNG file; name it 'p\.png'"):
        write_png(tmp_path / name, np.zeros((4, 4, 3), dtype=np.uint8))
    assert not list(tmp_path.iterdir())


def test_damaged_png(tmp_path: Path) -> None:
    write_png(tmp_path / "p.png", np.zeros((4, 4, 3), dtype=np.uint8))
    data = bytearray((tmp_path / "p.png").read_bytes())
    data[20] ^= 1
    (tmp_path / "p.png").write_bytes(bytes(data))
    with pytest.raises(ValueError, match="block IHDR is damaged"):
        read_png(tmp_path / "p.png")
    for cut in (8, 11, 40):
        (tmp_path / "p.png").write_bytes(bytes(data[:cut]))
        with pytest.raises(
            stark.InvalidArgument, match=r"p.png'( is damaged: .*; write it again|: block .* is damaged)"
        ):
            read_png(tmp_path / "p.png")
    header = struct.pack(">IIBBBBB", 4, 4, 8, 6, 0, 0, 0)  # with an alpha channel
    block = b"IHDR" + header
    whole = data[:8] + struct.pack(">I", len(header)) + block + struct.pack(">I", zlib.crc32(block))
    (tmp_path / "p.png").write_bytes(whole)
    with pytest.raises(stark.InvalidArgument, match=r"^'[^']*p.png': only 8-bit RGB pictures are read"):
        read_png(tmp_path / "p.png")
    with pytest.raises(stark.InvalidArgument, match="it is a folder, not a file: must be a readable pic"):
        read_png(tmp_path)


@pytest.mark.parametrize("shape", [(4, 4), (4, 4, 4), (0, 4, 3)])
def test_arrays_that_are_no_pictures(tmp_path: Path, shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"must be \(h, w, 3\) uint8"):
        write_png(tmp_path / "p.png", np.zeros(shape, dtype=np.uint8))
    assert not list(tmp_path.iterdir())
