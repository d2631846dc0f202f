"""Keeps source files short enough to read: an error above 600 lines, in the library and its Python package
above 500, a warning above 400."""

from __future__ import annotations

import sys
from pathlib import Path

from repository import CPP, ROOT, run_check, source_files

ERROR_LINES = 600
PRODUCT, PRODUCT_LINES = ("src", "python/stark", "python/bindings"), 500
WARNING_LINES = 400
SUFFIXES = (*CPP, ".py", ".js", ".css", ".html", ".sh", ".cmake")


def check(root: Path) -> tuple[list[str], list[str]]:
    """(errors, warnings) over every source file below root."""
    errors, warnings = [], []
    for path in source_files(root, SUFFIXES):
        count = path.read_text().count("\n")
        message = f"{path.relative_to(root)}: {count} lines"
        is_product = any(path.is_relative_to(root / folder) for folder in PRODUCT)
        most = PRODUCT_LINES if is_product else ERROR_LINES
        if count > most:
            errors.append(f"{message}, at most {most} are allowed; split it by topic")
        elif count > WARNING_LINES:
            warnings.append(message)
    return errors, warnings


if __name__ == "__main__":
    sys.exit(run_check("sizes", *check(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT)))
