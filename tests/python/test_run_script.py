"""./run on machines that lack something: it stops before doing anything and prints the line that helps."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TOOLS = ("sh", "dirname", "getconf", "sed", "find", "cksum", "sort", "cat")


@pytest.fixture
def bare_path(tmp_path: Path) -> Path:
    """A folder to use as the whole PATH: basic tools, an ordinary user, no compiler and no Python."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for name in TOOLS:
        found = shutil.which(name)
        assert found is not None
        (folder / name).symlink_to(found)
    script(folder / "id", "echo 1000")
    return folder


def script(path: Path, body: str) -> None:
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)


def run(path: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(ROOT / "run"), *arguments],
        env={"PATH": str(path), **environment},
        cwd="/",
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


@pytest.mark.parametrize("arguments", [[], ["nonsense"]])
def test_usage(bare_path: Path, arguments: list[str]) -> None:
    done = run(bare_path, *arguments)
    assert done.returncode == 2
    assert "./run demo | test [--all] | lint | docs | bench" in done.stderr


def test_everything_missing(bare_path: Path) -> None:
    done = run(bare_path, "demo")
    assert done.returncode == 1
    wanted = "sudo apt-get install --no-install-recommends g++ python3 python3-venv python3-dev\n"
    assert wanted in done.stderr


def test_python_without_venv_and_headers(bare_path: Path) -> None:
    script(bare_path / "g++", "exit 0")
    script(bare_path / "python3", "exit 1")
    done = run(bare_path, "demo")
    assert done.returncode == 1
    assert "install --no-install-recommends python3-venv python3-dev\n" in done.stderr


def test_old_python(bare_path: Path) -> None:
    script(bare_path / "g++", "exit 0")
    # Has venv and headers, fails the version comparison.
    script(
        bare_path / "python3",
        'case "$*" in *version_info*) exit 1 ;; -V) echo "Python 3.9.2" ;; *) exit 0 ;; esac',
    )
    done = run(bare_path, "demo")
    assert done.returncode == 1
    assert "needs Python 3.11 or newer; python3 is Python 3.9.2" in done.stderr


@pytest.mark.parametrize("works", [True, False])
def test_what_must_pass_installs_a_browser_or_says_that_there_is_none(bare_path: Path, works: bool) -> None:
    """As root; everything else is missing, so it ends after that."""
    for tool in ("bash", "env", "timeout", "chmod"):
        (bare_path / tool).symlink_to(str(shutil.which(tool)))
    (bare_path / "id").unlink()
    script(bare_path / "id", "echo 0")
    made = f"echo '#!/bin/sh' >{bare_path}/chromium && chmod +x {bare_path}/chromium"
    script(bare_path / "apt-get", f'case "$*" in *" chromium") {made if works else "exit 100"} ;; esac')
    done = subprocess.run(
        [str(ROOT / ".ci/run")],
        env={"PATH": str(bare_path)},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 1 and "Missing on this machine" in done.stderr
    wanted = "Chromium is there" if works else "NO BROWSER"
    assert done.stdout.count(wanted) == 2  # at the start and at the end


@pytest.mark.parametrize("name", ["run", "tools/dev.sh", "tools/format.sh", "tools/tidy.sh", ".ci/run"])
def test_scripts_parse_and_are_executable(name: str) -> None:
    path = ROOT / name
    assert os.access(path, os.X_OK)
    shell = path.read_text().split("\n", 1)[0].removeprefix("#!").split()
    assert subprocess.run([*shell, "-n", str(path)], check=False).returncode == 0


@pytest.mark.parametrize("word", ["-h", "--help"])
def test_help_of_the_developer_build_builds_nothing(bare_path: Path, word: str) -> None:
    done = subprocess.run(
        [ROOT / "tools/dev.sh", word],
        env={"PATH": str(bare_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "tools/dev.sh [cmake arguments...]" in done.stdout and "set -eu" not in done.stdout
