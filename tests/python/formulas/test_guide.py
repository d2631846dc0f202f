"""The code of docs/energies.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

GUIDE = Path(__file__).resolve().parents[3] / "docs/energies.md"


def test_the_code_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 16
    names: dict[str, object] = {}
    for block in blocks:
        shortened = block.replace("until=1.0", "until=0.05")
        exec(compile(shortened, str(GUIDE), "exec"), names)
    assert list(names["pull"].center) == [0.1, 0.0, 0.3]  # type: ignore[attr-defined]
    assert len(names["line"]) == 4 and names["bend"].fold > 0.0  # type: ignore[arg-type, attr-defined]
    assert names["rubber"].c10 == 3e4  # type: ignore[attr-defined]
    assert names["air"].pressure == pytest.approx(7000.0)  # type: ignore[attr-defined]
    assert names["gas"].amount == pytest.approx(1.1)  # type: ignore[attr-defined]
    assert names["pressure"] < 5000.0  # the skin gives way  # type: ignore[operator]
    assert names["tension"] > 0.0  # type: ignore[operator]
    printed = capsys.readouterr().out
    assert "magnet(p, center, strength, core):" in printed and "nothing is wrong" in printed
