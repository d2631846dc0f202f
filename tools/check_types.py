"""Types: mypy finds nothing wrong inside the package, every public name has a type that tools know, and mypy
and basedpyright accept what users copy: the programs of the README and the guides, and the examples.

The package is the one in python/ where the stub of the compiled module stands beside it, else the installed
one; without either there is nothing to check. `basedpyright` is Pyright with a Node of its own from PyPI."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from guides import guides, program
from repository import ROOT, run_check

STUB = "_core/__init__.pyi"
_SCORE = re.compile(r"Type completeness score: ([\d.]+)%")
#: As a user has them who has set nothing, but functions without annotations are checked too.
_MYPY_OPTIONS = (
    "--config-file=",
    "--check-untyped-defs",
    "--follow-imports=silent",
    "--ignore-missing-imports",
)
_PYRIGHT_OPTIONS = {
    "typeCheckingMode": "standard",
    "reportMissingImports": "none",  # extras, which are not installed for the lints
    "reportMissingModuleSource": "none",
}


def check(root: Path) -> list[str]:
    """What mypy and basedpyright find, one message each."""
    place = _place_of_package(root)
    if place is None:
        print("  types: not checked, the extension is not built")
        return []
    environment = _environment(root, place)
    return (
        _mypy(root, environment) + _unknown_types(environment) + check_scripts(user_scripts(root), root=root)
    )


def user_scripts(root: Path) -> dict[str, str]:
    """What users copy: text by name of a file. Programs of docs/rods.md are the file docs_rods_md.py."""
    named = {path: "_".join(path.relative_to(root).with_suffix("").parts) for path in guides(root)}
    scripts = {f"{name.lower()}_md.py": program(path) for path, name in named.items()}
    return scripts | {path.name: path.read_text() for path in sorted((root / "examples").glob("*.py"))}


def check_scripts(scripts: Mapping[str, str], root: Path = ROOT) -> list[str]:
    """What type checkers say of scripts, each message with the file and line."""
    place = _place_of_package(root)
    if place is None:
        return []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        for file, text in scripts.items():
            (folder / file).write_text(text)
        environment = _environment(root, place)
        return _mypy_of_scripts(folder, sorted(scripts), environment) + _pyright_of_scripts(
            folder, place, environment
        )


def _environment(root: Path, place: Path) -> dict[str, str]:
    tools = Path(sys.executable).parent
    environment = os.environ | {"PATH": f"{tools}{os.pathsep}{os.environ.get('PATH', '')}"}
    # Search paths are for the checkout alone: mypy refuses one that is site-packages.
    local = place == root / "python"
    return environment | ({"MYPYPATH": str(place), "PYTHONPATH": str(place)} if local else {})


def _place_of_package(root: Path) -> Path | None:
    """Folder in which stark stands with its stub."""
    places = [root / "python", *(Path(entry) for entry in sys.path if entry.endswith("site-packages"))]
    return next((place for place in places if (place / "stark" / STUB).is_file()), None)


def _run(
    folder: Path, environment: dict[str, str], tool: str, *arguments: str
) -> subprocess.CompletedProcess[str]:
    command = [str(Path(sys.executable).parent / tool), *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def _mypy(root: Path, environment: dict[str, str]) -> list[str]:
    done = _run(root, environment, "mypy")
    return [line for line in done.stdout.splitlines() if "error:" in line] or _crash("mypy", done)


def _unknown_types(environment: dict[str, str]) -> list[str]:
    """Public names whose types are not known. Run where no configuration or package lies around."""
    folder = Path(sys.executable).parent
    done = _run(folder, environment, "basedpyright", "--ignoreexternal", "--verifytypes", "stark")
    score = _SCORE.search(done.stdout)
    if score is None:
        return _crash("basedpyright", done) or ["basedpyright gives no score"]
    if score[1] == "100":
        return []
    return [line.strip() for line in done.stdout.splitlines() if "error:" in line]


def _mypy_of_scripts(folder: Path, files: list[str], environment: dict[str, str]) -> list[str]:
    done = _run(folder, environment, "mypy", *_MYPY_OPTIONS, f"--cache-dir={folder / 'cache'}", *files)
    return [line for line in done.stdout.splitlines() if "error:" in line] or _crash("mypy", done)


def _pyright_of_scripts(folder: Path, place: Path, environment: dict[str, str]) -> list[str]:
    options = _PYRIGHT_OPTIONS | {"extraPaths": [str(place)], "exclude": ["cache"]}
    (folder / "pyrightconfig.json").write_text(json.dumps(options))
    done = _run(folder, environment, "basedpyright", "--level", "error", "--pythonpath", sys.executable)
    found = [line.strip() for line in done.stdout.splitlines() if " - error:" in line]
    return [line.removeprefix(f"{folder}{os.sep}") for line in found] or _crash("basedpyright", done)


def _crash(tool: str, done: subprocess.CompletedProcess[str]) -> list[str]:
    return [f"{tool}: {(done.stderr or done.stdout).strip()[-500:]}"] if done.returncode else []


if __name__ == "__main__":
    sys.exit(run_check("types", check(ROOT)))
