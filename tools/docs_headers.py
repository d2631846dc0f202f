"""The page of the site with the C++ interface: the public headers, each with its leading comment and text."""

from __future__ import annotations

import re
from pathlib import Path

UMBRELLA = Path("src/stark/stark.h")


def public_headers(root: Path) -> list[str]:
    """Headers that <stark/stark.h> brings, "stark/sim/scene.h" among them."""
    return re.findall(r"^#include <(stark/[^>]+)>", (root / UMBRELLA).read_text("utf-8"), re.MULTILINE)


def leading_comment(text: str) -> str:
    """What a header says of itself in its first lines, as one paragraph."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("//"):
            break
        lines.append(line.lstrip("/").strip())
    return " ".join(lines)


def pages(root: Path) -> dict[str, str]:
    """Text of the page of all headers, and of one for each, by name."""
    headers = public_headers(root)
    rows, texts = [], {}
    for header in headers:
        text = (root / "src" / header).read_text(encoding="utf-8")
        page = f"cpp/{header.removeprefix('stark/').removesuffix('.h')}"
        comment = _escaped(leading_comment(text))
        rows.append(f"| [`{header}`]({page}.md) | {comment} |")
        texts[f"{page}.md"] = f"# {header}\n\n{comment}\n\n````cpp\n{text}````\n"
    links = "\n".join(f"cpp/{header.removeprefix('stark/').removesuffix('.h')}" for header in headers)
    texts["cpp.md"] = (
        "# C++ interface\n\n`#include <stark/stark.h>` has all of it; these are the headers that it brings. "
        "The text of a header is its reference.\n\n| header | |\n|---|---|\n"
        + "\n".join(rows)
        + f"\n\n```{{toctree}}\n:hidden:\n\n{links}\n```\n"
    )
    return texts


def _escaped(comment: str) -> str:
    """A comment as text of a table in Markdown."""
    return re.sub(r"([<>|*_\[\]])", r"\\\1", comment)
