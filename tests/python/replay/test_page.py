"""Replay pages: self-contained, and a browser decodes and draws what was recorded."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from fake_simulation import FakeSimulation, record

from stark.recording import Recorder, Recording, RecordingError
from stark.replay import encode, write_page
from stark.replay.encode import _decode_range, _inflate

_CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def test_an_empty_recording_has_no_page(tmp_path: Path) -> None:
    sim = FakeSimulation()
    Recorder(tmp_path / "run", sim).close()
    with pytest.raises(RecordingError, match="has no frames"):
        write_page(Recording(tmp_path / "run"))


def _header(page: str) -> dict:
    match = re.search(r'<script type="application/json" id="header">(.*?)</script>', page, re.S)
    assert match
    return json.loads(match.group(1))


def test_page_is_self_contained_and_safe(tmp_path: Path) -> None:
    page = write_page(record(tmp_path / "run", 5)).read_text(encoding="utf-8")
    # Nothing is loaded from anywhere; the policy in the page forbids it as well.
    assert "default-src 'none'" in page
    assert not re.search(r"(src|href)\s*=\s*[\"']?\s*(https?:)?//", page)
    assert "http" not in page.replace("http-equiv", "")
    assert "{{" not in re.sub(r"<script.*?</script>", "", page, flags=re.S)
    # A name that looks like markup does not end the script element.
    header = _header(page)
    assert header["bodies"][1]["name"] == "</script>box & 'Ω'"
    blocks = page.count('class="block"')
    assert page.count("</script>") == 2 + blocks


def test_page_holds_the_telemetry(tmp_path: Path) -> None:
    header = _header(write_page(record(tmp_path / "run", 12)).read_text(encoding="utf-8"))
    plots = {plot["title"]: plot for plot in header["telemetry"]["plots"]}
    assert set(plots) == {
        "Newton iterations",
        "Contacts",
        "Smallest distance",
        "Residual",
        "Energy",
        "Wall time per step",
    }
    assert plots["Smallest distance"]["series"][0]["values"][0] is None
    assert plots["Residual"]["scale"] == "log" and plots["Residual"]["unit"] == "N"
    assert [s["label"] for s in plots["Energy"]["series"]] == ["kinetic", "elastic", "gravity"]
    assert len(header["telemetry"]["time"]) == 12


def _chromium(page: Path, fragment: str, profile: Path, *options: str, size: str = "1000,700") -> str:
    command = [
        str(_CHROMIUM),
        "--headless",
        "--no-sandbox",
        "--disable-gpu-sandbox",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--virtual-time-budget=10000",
        f"--window-size={size}",
        f"--user-data-dir={profile}",
        *options,
        f"file://{page}#{fragment}",
    ]
    for attempt in range(3):  # its virtual clock has been seen to stop on a busy machine
        try:
            done = subprocess.run(command, capture_output=True, timeout=60 * (attempt + 1), check=False)
        except subprocess.TimeoutExpired:
            continue
        return done.stdout.decode("utf-8", "replace")
    pytest.fail("the browser did not finish in three attempts")


@pytest.mark.slow
@pytest.mark.skipif(_CHROMIUM is None, reason="needs chromium: apt-get install chromium")
def test_browser_decodes_the_same_numbers(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 70, cells=10)
    dom = _chromium(write_page(run), "selftest=1", tmp_path / "profile", "--dump-dom")
    assert 'data-state="ready"' in dom, dom[:2000]
    match = re.search(r'data-selftest="([^"]*)"', dom)
    assert match, dom[:2000]
    got = json.loads(html.unescape(match.group(1)))
    page = encode(run)
    grid, numbers = 0, 0.0
    for entry in page.header["bodies"]:
        for part in entry.get("ranges", []):
            q = _decode_range(page.blocks[part["block"]], part["count"], entry["vertices"])
            grid += int(q.astype(np.int64).sum())
        for name in ("rest", "poses"):
            if name in entry:
                values = np.frombuffer(_inflate(page.blocks[entry[name]]), dtype="<f4")
                numbers += float(values.astype(np.float64).sum())
    assert got["grid"] == grid % 2**32
    assert got["numbers"] == pytest.approx(numbers, abs=1e-6)


@pytest.mark.slow
@pytest.mark.skipif(_CHROMIUM is None, reason="needs chromium: apt-get install chromium")
def test_browser_draws_the_bodies(tmp_path: Path) -> None:
    """The picture must show much of the cloth's colour (0.8, 0.3, 0.2), which appears nowhere else in the
    page."""
    page = write_page(record(tmp_path / "run", 5, cells=10))
    shot = tmp_path / "shot.png"
    options = (f"--screenshot={shot}", "--hide-scrollbars")
    _chromium(page, "t=0.1&bare=1", tmp_path / "profile", *options, size="420,300")
    picture = _pixels(shot)
    red, green, blue = (picture[..., c].astype(int) for c in range(3))
    reddish = (red > green + 60) & (red > blue + 60)
    assert reddish.mean() > 0.015


def _pixels(path: Path) -> np.ndarray:
    """Pixels of a browser's PNG, (h, w, 3); all five row filters of the format."""
    import struct
    import zlib

    data, at, body = path.read_bytes(), 8, b""
    width = height = channels = 0
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind, content = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, _, color = struct.unpack_from(">IIBB", content)
            channels = {2: 3, 6: 4}[color]
        elif kind == b"IDAT":
            body += content
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(body), dtype=np.uint8).reshape(height, 1 + width * channels)
    out = np.zeros((height + 1, width + 1, channels), dtype=np.int64)
    for y in range(height):
        kind, line = rows[y, 0], rows[y, 1:].reshape(width, channels).astype(np.int64)
        for x in range(width):
            left, up, corner = out[y + 1, x], out[y, x + 1], out[y, x]
            if kind == 0:
                base = 0
            elif kind == 1:
                base = left
            elif kind == 2:
                base = up
            elif kind == 3:
                base = (left + up) // 2
            else:
                p = left + up - corner
                a, b, c = abs(p - left), abs(p - up), abs(p - corner)
                base = np.where((a <= b) & (a <= c), left, np.where(b <= c, up, corner))
            out[y + 1, x + 1] = (line[x] + base) & 255
    return out[1:, 1:, :3].astype(np.uint8)
