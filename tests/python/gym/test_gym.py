"""The package without what it needs, and its names."""

from __future__ import annotations

import subprocess
import sys

import pytest

import stark

_WITHOUT = """
import sys
sys.modules["gymnasium"] = None
import stark
print(stark.gym.__name__)
try:
    stark.gym.DragCloth
except ImportError as error:
    print(error)
"""


def test_without_gymnasium_the_extra_is_named() -> None:
    done = subprocess.run([sys.executable, "-c", _WITHOUT], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[0] == "stark.gym"
    assert "pip install 'stark-sim[rl]'" in done.stdout


def test_stark_does_not_import_it() -> None:
    script = "import sys, stark; print('gymnasium' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_names() -> None:
    pytest.importorskip("gymnasium")
    for name in stark.gym.__all__:
        assert getattr(stark.gym, name).__module__.startswith("stark.gym")
    with pytest.raises(AttributeError, match="did you mean"):
        stark.gym.DragClth  # noqa: B018
