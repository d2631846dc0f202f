"""Replay pages in notebooks."""

from __future__ import annotations

import html
import re
from pathlib import Path

import pytest
from fake_simulation import record

from stark.recording import RecordingError
from stark.replay import show, write_page


def test_a_cell_holds_the_page_itself(tmp_path: Path) -> None:
    recording = record(tmp_path / "run", 5)
    page = show(recording, height=321)
    cell = page._repr_html_()
    assert cell.startswith("<iframe ") and cell.count("<") == 2  # all of the page is in an attribute
    inner = html.unescape(re.search(r'srcdoc="([^"]*)"', cell).group(1))
    assert inner == page.html == write_page(recording, max_megabytes=20.0).read_text(encoding="utf-8")
    assert 'height="321"' in cell
    page.save(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == page.html
    assert "6 frames of" in repr(page) and len(repr(page)) < 300


def test_nothing_to_show(tmp_path: Path) -> None:
    from fake_simulation import FakeSimulation

    from stark.recording import Recorder, Recording

    Recorder(tmp_path / "run", FakeSimulation()).close()
    with pytest.raises(RecordingError, match="no frames"):
        show(Recording(tmp_path / "run"))
    with pytest.raises(
        RecordingError, match=r"show: recording = 'run': must be a stark\.recording\.Recording"
    ):
        show("run")  # type: ignore[arg-type]
