"""Keeps source files short enough to read: an error above 600 lines, a warning above 400."""

from __future__ import annotations

import sys
from pathlib import Path

from repository import CPP, ROOT, run_check, source_files

ERROR_LINES = 600
WARNING_LINES = 400
SUFFIXES = (*CPP, ".py", ".js", ".css", ".html", ".sh", ".cmake")


def check(root: Path) -> tuple[list[str], list[str]]:
    """(errors, warnings) over every source file below root."""
    errors, warnings = [], []
    for path in source_files(root, SUFFIXES):
        count = path.read_text().count("\n")
        message = f"{path.relative_to(root)}: {count} lines"
        if count > ERROR_LINES:
            errors.append(f"{message}, at most {ERROR_LINES} are allowed; split it by topic")
        elif count > WARNING_LINES:
            warnings.append(message)
    return errors, warnings


if __name__ == "__main__":
    sys.exit(run_check("sizes", *check(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT)))
