"""Lists sources without a test file of the same place and name: src/stark/a/b.cpp <-> tests/a/test_b.cpp.

Only warnings: one test file may cover several small sources.
"""

from __future__ import annotations

import sys
from pathlib import Path

from repository import ROOT, run_check, source_files


def check(root: Path) -> list[str]:
    """Sources below src/stark for which no test file of the mirrored name exists."""
    warnings = []
    for path in source_files(root, (".cpp",), "src/stark"):
        relative = path.relative_to(root / "src/stark")
        mirrored = [root / "tests" / relative.parent, root / "tests" / relative.parts[0]]
        if not any((folder / f"test_{path.name}").is_file() for folder in mirrored):
            warnings.append(f"src/stark/{relative} has no tests/{relative.parent}/test_{path.name}")
    return warnings


if __name__ == "__main__":
    sys.exit(run_check("mirror", [], check(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT)))
