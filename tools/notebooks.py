"""Notebooks of the documentation as Markdown: their text as it stands, their code in fences. Outputs are not
stored; the tests make them (tests/python/test_notebooks.py)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def notebooks(root: Path) -> list[Path]:
    """All notebooks of the documentation."""
    return sorted((root / "docs").rglob("*.ipynb"))


def cells(path: Path) -> list[dict[str, Any]]:
    """Cells of a notebook, with their source as one text."""
    content = json.loads(path.read_text(encoding="utf-8"))
    return [{**cell, "source": "".join(cell["source"])} for cell in content["cells"]]


def as_markdown(path: Path) -> str:
    """A notebook as a page of the site."""
    parts = [
        cell["source"] if cell["cell_type"] == "markdown" else f"```python\n{cell['source']}\n```"
        for cell in cells(path)
    ]
    return "\n\n".join(parts) + "\n"
