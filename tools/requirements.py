"""Prints the pinned requirements of pyproject.toml, one a line: tools/requirements.py GROUP [GROUP ...].

`build` stands for the build requirements, `run` for the dependencies, `tools` for Ninja, and for CMake where
this machine has none that is new enough, any other word for an extra of that name.
"""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

CMAKE_MINIMUM = (3, 25)


def missing_tools() -> list[str]:
    """Build tools to take from PyPI. Those already in .venv do not count, so the answer is stable."""
    missing = ["ninja"]
    system_path = os.pathsep.join(path_without_venv())
    cmake = shutil.which("cmake", path=system_path)
    version = ""
    if cmake:
        version = subprocess.run([cmake, "--version"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"(\d+)\.(\d+)", version)
    if found is None or (int(found[1]), int(found[2])) < CMAKE_MINIMUM:
        missing.append("cmake")
    return missing


def path_without_venv() -> list[str]:
    """Entries of PATH outside the virtual environment that runs this script."""
    return [p for p in os.environ.get("PATH", "").split(os.pathsep) if p and not p.startswith(sys.prefix)]


def requirements(groups: list[str], pyproject: Path) -> list[str]:
    """Requirements of the named groups in the order asked for, without repetitions."""
    config = tomllib.loads(pyproject.read_text())
    project = config["project"]
    found: list[str] = []
    for group in groups:
        if group == "build":
            lines = config["build-system"]["requires"]
        elif group == "run":
            lines = project["dependencies"]
        elif group == "tools":
            lines = missing_tools()
        elif group in project["optional-dependencies"]:
            lines = project["optional-dependencies"][group]
        else:
            known = ", ".join(["build", "run", "tools", *project["optional-dependencies"]])
            raise SystemExit(f"unknown group '{group}'; known are {known}")
        found += [line for line in lines if line not in found and not line.startswith("stark-sim")]
    return found


if __name__ == "__main__":
    print("\n".join(requirements(sys.argv[1:], Path(__file__).resolve().parents[1] / "pyproject.toml")))
