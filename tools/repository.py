"""What the lints share: the root of the repository and the list of source files."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SKIPPED_FOLDERS = {"build", "out", "dist", ".git", ".venv", "node_modules", "__pycache__", "shared"}
CPP = (".h", ".cpp", ".inc")


def source_files(root: Path, suffixes: Iterable[str], folder: str = ".") -> list[Path]:
    """Files below root/folder with one of the suffixes, sorted, generated folders left out."""
    wanted = set(suffixes)
    return sorted(
        path
        for path in (root / folder).rglob("*")
        if path.suffix in wanted
        and path.is_file()
        and not SKIPPED_FOLDERS.intersection(path.relative_to(root).parts)
    )


def run_check(title: str, errors: list[str], warnings: list[str] | None = None) -> int:
    """Prints the findings of one lint and returns its exit status: 1 when there are errors."""
    for line in warnings or []:
        print(f"  warning: {line}")
    for line in errors:
        print(f"  {line}")
    print(f"{title}: {f'{len(errors)} errors' if errors else 'ok'}")
    return 1 if errors else 0
