"""A test stands where its source stands: src/stark/a/b.cpp <-> tests/a/test_b.cpp, python/stark/a/b.py <->
tests/python/a/test_b.py or tests/python/test_b.py.

Sources that share a test with others are listed in tools/tested_elsewhere.txt; a new source without a test of
its name is an error, and so is an entry of the list that is not needed any more."""

from __future__ import annotations

import sys
from pathlib import Path

from repository import ROOT, run_check, source_files

LIST = "tools/tested_elsewhere.txt"


def orphans(root: Path) -> list[str]:
    """Sources for which no test file of the mirrored name exists."""
    return [*_cpp_orphans(root), *_python_orphans(root)]


def check(root: Path) -> list[str]:
    """Orphans that the list does not have, and entries that have a test now or are gone."""
    found = orphans(root)
    listed = (root / LIST).read_text().split() if (root / LIST).is_file() else []
    errors = [
        f"{source} has no test of its name; write one, or add it to {LIST}"
        for source in found
        if source not in listed
    ]
    return errors + [f"{LIST}: {source} need not be listed" for source in listed if source not in found]


def _cpp_orphans(root: Path) -> list[str]:
    found = []
    for path in source_files(root, (".cpp",), "src/stark"):
        relative = path.relative_to(root / "src/stark")
        mirrored = [root / "tests" / relative.parent, root / "tests" / relative.parts[0]]
        if not any((folder / f"test_{path.name}").is_file() for folder in mirrored):
            found.append(f"src/stark/{relative}")
    return found


def _python_orphans(root: Path) -> list[str]:
    found = []
    for path in source_files(root, (".py",), "python/stark"):
        relative = path.relative_to(root / "python/stark")
        # Packages and packaged scenes are tested as a whole.
        if path.name.startswith("__") or relative.parts[0] == "scenes":
            continue
        name = f"test_{path.stem.lstrip('_')}.py"
        folders = [root / "tests/python" / relative.parent, root / "tests/python"]
        if not any((folder / name).is_file() for folder in folders):
            found.append(f"python/stark/{relative}")
    return found


if __name__ == "__main__":
    sys.exit(run_check("mirror", check(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT)))
