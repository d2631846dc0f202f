"""docs/validation.md and the tests name the same quantities, and the comparison of the two can fail."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from _validation import PAGE, rows, validate
from test_joint_loads import KINDS


def test_every_row_is_measured_by_a_test() -> None:
    names = set()
    for path in Path(__file__).parent.glob("test_*.py"):
        names |= set(re.findall(r'validate\(f?"([^"]+)"', path.read_text()))
    patterns = [re.compile(re.sub(r"\\\{.*?\\\}", "[a-z0-9_]+", re.escape(name))) for name in names]
    unmeasured = [row for row in rows() if not any(p.fullmatch(row) for p in patterns)]
    assert not unmeasured and len(rows()) > len(KINDS)
    assert len(rows()) == len(re.findall(r"^\| `", PAGE.read_text(), re.MULTILINE))  # none is misspelt


def test_what_is_wrong_or_stale_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("STARK_WRITE_VALIDATION", raising=False)  # these numbers are not for the page
    row = rows()["V15.period_90"]
    validate("V15.period_90", row.measured)
    with pytest.raises(AssertionError, match="expected"):
        validate("V15.period_90", row.reference + 1.01 * row.tolerance)
    with pytest.raises(AssertionError, match="says"):
        validate("V15.period_90", row.reference + 0.9 * row.tolerance)
    with pytest.raises(AssertionError, match="beyond"):
        validate("chain.iterations", rows()["chain.iterations"].reference + 0.1)
    with pytest.raises(KeyError):
        validate("V15.period_91", 1.0)
