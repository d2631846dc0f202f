"""Python programs in the README and the guides, block after block in reading order. The tests run them;
`tools/check_types.py` hands them to type checkers."""

from __future__ import annotations

from pathlib import Path

_FENCE, _START = "```", "```python"


def guides(root: Path) -> list[Path]:
    """README and guides that have programs. Tutorials are not among them: they show parts of examples."""
    places = [root / "README.md", *sorted((root / "docs").glob("*.md"))]
    return [path for path in places if python_blocks(path)]


def python_blocks(guide: Path) -> list[str]:
    """The Python blocks of a document. Each begins with as many blank lines as there are lines before it, so
    that line 12 of a block is line 12 of the document."""
    blocks: list[str] = []
    block: list[str] | None = None
    for number, line in enumerate(guide.read_text(encoding="utf-8").splitlines()):
        if block is None:
            block = [""] * (number + 1) if line == _START else None
        elif line.startswith(_FENCE):
            blocks.append("".join(f"{text}\n" for text in block))
            block = None
        else:
            block.append(line)
    if block is not None:
        raise ValueError(f"{guide}: a program does not end")
    return blocks


def program(guide: Path) -> str:
    """All blocks of a document as one file, with the lines of the document."""
    text = ""
    for block in python_blocks(guide):
        text += block[text.count("\n") :]
    return text
