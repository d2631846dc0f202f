"""tools/requirements.py feeds pip in ./run and tools/dev.sh: every pin must come through it."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from requirements import requirements  # noqa: E402

PYPROJECT = ROOT / "pyproject.toml"


def test_build_requirements_and_extras_are_pinned() -> None:
    lines = requirements(["build", "test", "mesh", "video"], PYPROJECT)
    assert any(line.startswith("nanobind==") for line in lines)
    assert any(line.startswith("ipctk==") for line in lines)
    assert [line for line in lines if "==" not in line] == []
    assert len(lines) == len(set(lines))


def test_unknown_group_names_the_known_ones() -> None:
    with pytest.raises(SystemExit, match="unknown group 'tset'; known are build, run"):
        requirements(["tset"], PYPROJECT)


def test_own_name_is_never_requested_from_the_registry() -> None:
    assert not any("stark" in line for line in requirements(["dev"], PYPROJECT))
