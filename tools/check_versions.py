"""The version stands in several files, one for each tool; all of them must agree with CMakeLists.txt."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from repository import ROOT, run_check

PLACES = {
    "CMakeLists.txt": r"project\(Stark VERSION ([\d.]+)",
    "pyproject.toml": r'^version = "([^"]+)"',
    "CITATION.cff": r"^version: ([\d.]+)",
    "CHANGELOG.md": r"^## ([\d.]+)",
}


def check(root: Path) -> list[str]:
    """Files whose version is missing or differs from that of CMakeLists.txt."""
    found = {}
    for name, pattern in PLACES.items():
        match = re.search(pattern, (root / name).read_text(), re.MULTILINE)
        found[name] = match[1] if match else "none"
    wanted = found["CMakeLists.txt"]
    return [
        f"{name} says {version}, CMakeLists.txt {wanted}"
        for name, version in found.items()
        if version != wanted or version == "none"
    ]


if __name__ == "__main__":
    sys.exit(run_check("versions", check(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT)))
