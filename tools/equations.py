"""Numbers of equations: those that docs/theory.md defines, and where sources and documents cite them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from repository import ROOT, source_files

THEORY = "docs/theory.md"
SOURCES = (".h", ".cpp", ".py")
_DEFINED = re.compile(r"^    .*\((\d+[a-z]?)\)$", re.MULTILINE)
_LABEL = r"\(?\d+(?:\.\d+|[a-z])?\)?"
_CITED = re.compile(rf"\beqs?\. ?({_LABEL}(?:(?:, | and | to ){_LABEL})*)")
#: What may stand between the name of the theory and the number: "[theory](theory.md#6-friction), eq. 19b".
_OURS = re.compile(r"\btheory\b(?:[^\s.;]|\.md)*,? $")
#: A publication: "[Li et al. 2020, eq. 17]", "the paper's eq. 18".
_FOREIGN = re.compile(r"(?:\b(?:19|20)\d\d\b[^;]*|paper's )$")
_MARKERS = re.compile(r"\s*\n\s*(?://[/!]?|#|\*)?\s*")


def defined(root: Path = ROOT) -> list[str]:
    """Numbers in the order of the document."""
    return _DEFINED.findall((root / THEORY).read_text(encoding="utf-8"))


def citing_files(root: Path = ROOT) -> list[Path]:
    """Sources, tests, tools, examples and documents."""
    places = ("src", "python/stark", "tests", "tools", "examples", "benchmarks")
    sources = [path for place in places for path in source_files(root, SOURCES, place)]
    return [*sources, *source_files(root, (".md",))]


def citations(path: Path) -> Iterator[tuple[str, str]]:
    """(number, text around it) of every citation of the theory, ranges taken apart. In documents a number
    alone is one of the theory; in sources it raises ValueError, because it could be any paper's."""
    text = _MARKERS.sub(" ", path.read_text(encoding="utf-8"))
    for match in _CITED.finditer(text):
        before = text[max(0, match.start() - 160) : match.start()]
        around = f"{before[-60:]}{match[0]}"
        if not _OURS.search(before):
            if _FOREIGN.search(before):
                continue
            if path.suffix != ".md":
                raise ValueError(f"{path}: of which paper is '... {around}'? Write 'theory eq.', or its year")
        for number in _numbers(match[1]):
            yield number, around


def _numbers(text: str) -> list[str]:
    """'28 to 31a, 33' as the numbers it names; ranges have those without a letter in between."""
    words = re.findall(r"\d+(?:\.\d+|[a-z])?|to", text)
    found: list[str] = []
    for k, word in enumerate(words):
        if word == "to":
            low, high = (int(re.sub(r"\D", "", words[j])) for j in (k - 1, k + 1))
            found += [str(n) for n in range(low + 1, high)]
        else:
            found.append(word)
    return found
