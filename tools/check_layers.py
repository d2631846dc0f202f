"""Keeps the arrows between the layers pointing down.

The allowed arrows are the DEPENDS lists of src/stark/CMakeLists.txt. A file of a layer may include headers of
its own layer and of the layers in its list, nothing else of Stark; the umbrella stark.h is for users only.
The PARTS of a layer are folders of it, bottom up, below the files beside them: none sees one above it.
The floors of the Python package are in python_floors.py.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import python_floors
from repository import CPP, ROOT, run_check, source_files

LIST = "src/stark/CMakeLists.txt"
LAYER = re.compile(
    r"^\s*stark_layer\(\s*(\w+)(?:\s+PARTS\s+([a-z\s]+))?(?:\s+DEPENDS\s+([\w\s]+))?\)", re.MULTILINE
)
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)


def allowed_arrows(cmake: str) -> dict[str, set[str]]:
    """Layer -> layers that it may include, from the text of src/stark/CMakeLists.txt."""
    return {name: set(depends.split()) for name, _, depends in LAYER.findall(cmake)}


def parts(cmake: str) -> dict[str, list[str]]:
    """Layer -> its parts, bottom up, from the same text."""
    return {name: folders.split() for name, folders, _ in LAYER.findall(cmake)}


def cycles_and_unknowns(arrows: dict[str, set[str]]) -> list[str]:
    """A layer may depend only on layers that stand above its own line in the list, hence no cycles."""
    errors = []
    seen: set[str] = set()
    for layer, depends in arrows.items():
        for name in sorted(depends - seen):
            errors.append(f"{LIST}: {layer} depends on {name}, which is not listed above it")
        seen.add(layer)
    return errors


def check(root: Path) -> list[str]:
    """All forbidden includes below root/src/stark and imports of the Python package, one message each."""
    return cpp_errors(root) + (python_floors.check(root) if (root / python_floors.PACKAGE).is_dir() else [])


def cpp_errors(root: Path) -> list[str]:
    """All forbidden includes below root/src/stark."""
    cmake = (root / LIST).read_text()
    arrows, parts_of = allowed_arrows(cmake), parts(cmake)
    errors = cycles_and_unknowns(arrows)
    for path in source_files(root, CPP, "src/stark"):
        relative = path.relative_to(root / "src/stark")
        layer = relative.parts[0]
        if len(relative.parts) == 1:
            continue
        if layer not in arrows:
            errors.append(f"src/stark/{relative}: folder '{layer}' is not a layer of {LIST}")
            continue
        for bracket, target in INCLUDE.findall(path.read_text()):
            where = f"src/stark/{relative} includes {target}"
            if bracket == '"':
                errors.append(f"{where} in quotes; write <stark/layer/file.h>")
            if target == "stark/stark.h":
                errors.append(f"{where}: the umbrella is for users only")
            elif target.startswith("stark/"):
                other = target.split("/")[1]
                if other != layer and other not in arrows[layer]:
                    errors.append(f"{where}: {layer} may not see {other}")
                elif other == layer and _level(target, parts_of) > _level(f"stark/{relative}", parts_of):
                    errors.append(f"{where}: the part '{relative.parts[1]}' of {layer} may not see it")
    return errors


def _level(header: str, parts_of: dict[str, list[str]]) -> int:
    """Place of a header's part within its layer, from the bottom; files beside the parts are at the top."""
    _, layer, folder, *_ = header.split("/")
    folders = parts_of[layer]
    return folders.index(folder) if folder in folders else len(folders)


if __name__ == "__main__":
    sys.exit(run_check("layers", check(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT)))
