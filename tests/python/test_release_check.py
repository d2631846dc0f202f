"""Releases: the check of the files finds what is missing, the workflow runs tools that exist, the smoke test
passes on this package."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import stark

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import release_check  # noqa: E402

WORKFLOW = ROOT / ".github/workflows/wheels.yml"
CHANGELOG = "# Changelog\n\n## Unreleased\n\n## 1.2.0\n\nAdded\n\n- A wheel.\n\n## 1.1.0\n\n- Older.\n"


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Files of version 1.2.0 that may be released."""
    (tmp_path / "CMakeLists.txt").write_text("project(Stark VERSION 1.2.0 LANGUAGES CXX)\n")
    (tmp_path / "CITATION.cff").write_text("version: 1.2.0\n")
    (tmp_path / "CHANGELOG.md").write_text(CHANGELOG.replace("## Unreleased\n\n", ""))
    (tmp_path / "pyproject.toml").write_text(
        '[project]\nname = "stark-sim"\nversion = "1.2.0"\nurls = { Source = "https://stark.org" }\n'
    )
    return tmp_path


def test_files_of_a_release_pass(tree: Path) -> None:
    assert release_check.check(tree, "v1.2.0") == []
    (tree / "CHANGELOG.md").write_text(CHANGELOG)  # an empty section is fine
    assert release_check.check(tree, "v1.2.0") == []


@pytest.mark.parametrize("tag", ["1.2.0", "v1.2", "v1.1.0", ""])
def test_a_tag_of_another_version_is_refused(tree: Path, tag: str) -> None:
    (error,) = release_check.check(tree, tag)
    assert f"the tag is '{tag}'" in error and "must be v1.2.0" in error


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("CITATION.cff", "1.2.0", "1.1.0", "CITATION.cff says 1.1.0"),
        ("CHANGELOG.md", "- A wheel.\n", "", "no entries for 1.2.0"),
        ("CHANGELOG.md", "## 1.2.0", "## Unreleased\n\n- New.\n\n## 1.2.0", "entries under Unreleased"),
        ("pyproject.toml", "stark.org", "stark.example", "Source = https://stark.example is a placeholder"),
    ],
)
def test_what_is_missing_is_named(tree: Path, file: str, old: str, new: str, message: str) -> None:
    text = (tree / file).read_text()
    assert old in text
    (tree / file).write_text(text.replace(old, new))
    (error,) = release_check.check(tree, "v1.2.0")
    assert message in error


def test_the_workflow_and_the_wheels_run_tools_that_exist() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["cibuildwheel"]
    text = WORKFLOW.read_text() + settings["test-command"]
    tools = set(re.findall(r"tools/\w+\.py", text))
    assert tools == {"tools/release_check.py", "tools/requirements.py", "tools/smoke_test.py"}
    assert all((ROOT / name).is_file() for name in tools)


def test_the_wheel_is_built_for_the_oldest_python_and_tested_on_all() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    oldest = project["tool"]["scikit-build"]["wheel"]["py-api"]
    built = [name.split("-")[0] for name in project["tool"]["cibuildwheel"]["build"]]
    assert built[0] == oldest == "cp311" and built == sorted(built) and len(built) >= 3
    assert project["project"]["requires-python"] == ">=3.11"


def smoke_test(*words: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": str(Path(stark.__file__).parents[1])}
    command = [sys.executable, str(ROOT / "tools/smoke_test.py"), *words]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def test_the_smoke_test_passes_on_this_package() -> None:
    done = smoke_test("--checkout")
    assert done.returncode == 0 and done.stdout.endswith("smoke test: passed\n"), done.stdout + done.stderr


@pytest.mark.skipif("site-packages" in stark.__file__, reason="the package is installed")
def test_the_smoke_test_refuses_a_checkout() -> None:
    done = smoke_test()
    assert done.returncode == 1 and "is a checkout, not an installed wheel" in done.stdout
