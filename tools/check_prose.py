"""Prose: spelling by codespell, and turns of phrase that readers stumble over (CONTRIBUTING.md, Style)."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from repository import CPP, ROOT, run_check, source_files

#: Where users and contributors read.
FOLDERS = ("docs", "python", "src", "examples", "benchmarks", "tools")
PAGES = ("README.md", "CHANGELOG.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "RELEASING.md", "SECURITY.md")

#: (pattern, what to write instead)
RIDDLES = [
    (r"\bwhat is no [a-z]", "name it: 'anything but a path', 'a text that is not a path'"),
    (r"\bthat none can\b", "'impossible', or which one it is"),
    (r"\bof which none\b", "'none of which'"),
    (r"\bthe empty one\b", "repeat the noun"),
    (r"\bwhat it is of\b", "say what it belongs to"),
    (r"\bone an? (?:triangle|vertex|node|step|pair|body)\b", "'one per'"),
    (r"\bclock on the wall\b", "'wall-clock time'"),
    (r"\blooked at between\b", "'checked between'"),
    (r"\bswitch of all\b", "'enables'"),
    (r"\bon the word of\b", "'on the basis of'"),
    (r"\bis made, or make\b", "two sentences"),
    (r"\bholds in simulations\b", "'does not affect the existing simulation'"),
    (r"\bwhat nobody\b", "name it"),
]


def riddles(root: Path) -> list[str]:
    """Lines with one of the patterns; they may go over the end of a line."""
    paths = [root / name for name in PAGES if (root / name).is_file()]
    for folder in FOLDERS:
        paths += source_files(root, (".md", ".py", *CPP), folder)
    errors = []
    for path in paths:
        if path.name == Path(__file__).name:
            continue
        text = path.read_text()
        for pattern, instead in RIDDLES:
            for match in re.finditer(pattern.replace(" ", r"\s+(?:(?:#|///?|\*)\s*)?"), text, re.IGNORECASE):
                line = text.count("\n", 0, match.start()) + 1
                words = " ".join(match.group().split())
                errors.append(f"{path.relative_to(root)}:{line}: '{words}': write {instead}")
    return errors


def misspelled(root: Path) -> list[str]:
    """What codespell finds; its settings are in pyproject.toml."""
    names = [name for name in (*FOLDERS, *PAGES) if (root / name).exists()]
    command = [sys.executable, "-m", "codespell_lib", *names]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    found = done.stdout.splitlines()
    if done.returncode and not found:
        return [f"codespell: {done.stderr.strip()}; install it: pip install codespell"]
    return found


def check(root: Path) -> list[str]:
    """All findings."""
    return riddles(root) + misspelled(root)


if __name__ == "__main__":
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT
    sys.exit(run_check("prose", check(root)))
