"""Types: mypy finds nothing wrong inside the package, and every public name has a type that tools know.

The package is the one in python/ where the stub of the compiled module stands beside it, else the installed
one; without either there is nothing to check. `basedpyright` is Pyright with a Node of its own from PyPI."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

from repository import ROOT, run_check

STUB = "_core/__init__.pyi"
_SCORE = re.compile(r"Type completeness score: ([\d.]+)%")


def check(root: Path) -> list[str]:
    """What mypy and basedpyright find, one message each."""
    place = _place_of_package(root)
    if place is None:
        print("  types: not checked, the extension is not built")
        return []
    tools = Path(sys.executable).parent
    environment = os.environ | {"PATH": f"{tools}{os.pathsep}{os.environ.get('PATH', '')}"}
    # Search paths are for the checkout alone: mypy refuses one that is site-packages.
    local = place == root / "python"
    environment |= {"MYPYPATH": str(place), "PYTHONPATH": str(place)} if local else {}
    return _mypy(root, tools, environment) + _unknown_types(tools, environment)


def _place_of_package(root: Path) -> Path | None:
    """Folder in which stark stands with its stub."""
    places = [root / "python", *(Path(entry) for entry in sys.path if entry.endswith("site-packages"))]
    return next((place for place in places if (place / "stark" / STUB).is_file()), None)


def _mypy(root: Path, tools: Path, environment: dict[str, str]) -> list[str]:
    done = subprocess.run(
        [tools / "mypy"], cwd=root, env=environment, capture_output=True, text=True, check=False
    )
    return [line for line in done.stdout.splitlines() if "error:" in line] or _crash("mypy", done)


def _unknown_types(tools: Path, environment: dict[str, str]) -> list[str]:
    """Public names whose types are not known. Run where no configuration or package lies around."""
    command = [tools / "basedpyright", "--ignoreexternal", "--verifytypes", "stark"]
    done = subprocess.run(command, cwd=tools, env=environment, capture_output=True, text=True, check=False)
    score = _SCORE.search(done.stdout)
    if score is None:
        return _crash("basedpyright", done) or ["basedpyright gives no score"]
    if score[1] == "100":
        return []
    return [line.strip() for line in done.stdout.splitlines() if "error:" in line]


def _crash(tool: str, done: subprocess.CompletedProcess[str]) -> list[str]:
    return [f"{tool}: {(done.stderr or done.stdout).strip()[-500:]}"] if done.returncode else []


if __name__ == "__main__":
    sys.exit(run_check("types", check(ROOT)))
