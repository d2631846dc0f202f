"""Pages of the site with the C++ interface: for each public header its leading comment, then every
declaration under a heading of its own, with its comment and without private members.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

UMBRELLA = Path("src/stark/stark.h")
_TYPE = re.compile(r"(?:template <.*?>\s*)?(?:class|struct|enum class|using|concept)\s+(\w+)")
_FUNCTION = re.compile(r"(operator\S+|\w+)\(")
_VALUE = re.compile(r"(\w+)\s*(?:=|\{|;)")
#: Declared elsewhere, checks of the compiler, tables of names.
_NOT_SHOWN = re.compile(r"(?:class|struct|using|using namespace) [\w:]+;|static_assert|template <>")
#: What ends a declaration is read without these.
_COMMENT_OR_TEXT = re.compile(r'//.*|"(?:[^"\\]|\\.)*"')


class Declaration(NamedTuple):
    """A type, a function or a constant of a header."""

    name: str
    comment: str
    code: str


def public_headers(root: Path) -> list[str]:
    """Headers that <stark/stark.h> brings, "stark/sim/scene/scene.h" among them."""
    return re.findall(r"^#include <(stark/[^>]+)>", (root / UMBRELLA).read_text("utf-8"), re.MULTILINE)


def leading_comment(text: str) -> list[str]:
    """Paragraphs that a header begins with. Programs in them are paragraphs of indented lines."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("//"):
            break
        lines.append(re.sub(r"^//[/!]? ?", "", line))
    return [paragraph for paragraph in re.split(r"\n\s*\n", "\n".join(lines)) if paragraph.strip()]


def declarations(text: str) -> list[Declaration]:
    """Declarations of namespace stark in a header, in its order."""
    found = []
    for lines in _chunks(text):
        first = next((k for k, line in enumerate(lines) if not line.startswith("//")), len(lines))
        code = lines[first:]
        if not code or _NOT_SHOWN.match(" ".join(code)):
            continue
        comment = " ".join(re.sub(r"^//[/!]? ?", "", line) for line in lines[:first])
        shown = "\n".join(_without_private(code))
        found.append(Declaration(_name(shown), comment, shown))
    return found


def _chunks(text: str) -> Iterator[list[str]]:
    """Comments and the declaration they belong to, of the namespace stark and those in it."""
    namespaces, depth, chunk = 0, 0, []
    for line in text.splitlines():
        if depth == 0 and re.match(r"namespace [\w:]+ \{", line):
            namespaces += 1
        elif depth == 0 and line.startswith("}"):
            namespaces -= 1
        elif namespaces and depth == 0 and (not line.strip() or line.startswith("#")):
            chunk = []  # a comment on its own
        elif namespaces:
            chunk.append(line)
            bare = _COMMENT_OR_TEXT.sub("", line)
            depth += bare.count("{") + bare.count("(") - bare.count("}") - bare.count(")")
            if depth == 0 and bare.rstrip().endswith((";", "}")):
                yield chunk
                chunk = []


def _without_private(code: list[str]) -> list[str]:
    """A class without what its users cannot use."""
    shown, hidden = [], False
    for line in code:
        if re.match(r" (?:public|private|protected):", line):
            hidden = not line.startswith(" public")
        if not hidden or line.startswith("}"):
            shown.append(line)
    while len(shown) > 1 and not shown[-2].strip():
        del shown[-2]
    return shown


def _name(code: str) -> str:
    kind = _TYPE.match(code)
    if kind is not None:
        return kind[1]
    head = re.sub(r"\[\[\w+\]\]|template <[^\n]*>\n?", "", code)
    value = re.match(r"(?:inline |constexpr |extern |const |static )+[\w:<>, ]*?(\w+)\s*[={;]", head)
    function = _FUNCTION.search(head)
    if function is not None and (value is None or function.start() < value.start(1)):
        return f"{function[1]}()"
    found = value or _VALUE.search(head)
    assert found is not None, code
    return found[1]


def pages(root: Path) -> dict[str, str]:
    """Text of the page of all headers, and of one for each, by name."""
    headers = public_headers(root)
    rows, texts = [], {}
    for header in headers:
        text = (root / "src" / header).read_text(encoding="utf-8")
        comment = leading_comment(text)
        rows.append(f"| [`{header}`]({_page(header)}.md) | {_escaped(_first_sentence(comment[0]))} |")
        texts[f"{_page(header)}.md"] = _text(header, comment, declarations(text))
    links = "\n".join(_page(header) for header in headers)
    texts["cpp.md"] = (
        "# C++ interface\n\n`#include <stark/stark.h>` brings all of these headers.\n\n"
        "| header | |\n|---|---|\n" + "\n".join(rows) + f"\n\n```{{toctree}}\n:hidden:\n\n{links}\n```\n"
    )
    return texts


def _page(header: str) -> str:
    return f"cpp/{header.removeprefix('stark/').removesuffix('.h')}"


def _text(header: str, comment: list[str], all_of_it: list[Declaration]) -> str:
    parts = [f"# {header}", *(_paragraph(paragraph) for paragraph in comment)]
    last = ""
    for name, about, code in all_of_it:
        if name != last:  # overloads stand together
            parts.append(f"## `{name}`")
        last = name
        parts += [_escaped(about)] * bool(about) + [f"````cpp\n{code}\n````"]
    return "\n\n".join(parts) + "\n"


def _paragraph(text: str) -> str:
    is_program = all(line.startswith("  ") for line in text.splitlines())
    return f"````cpp\n{text}\n````" if is_program else _escaped(text)


def _first_sentence(text: str) -> str:
    found = re.match(r"(.*?[.])(?:\s|$)", text.replace("\n", " "))
    return found[1] if found else text.replace("\n", " ")


def _escaped(comment: str) -> str:
    """A comment as text in Markdown, its `code` left as it is."""
    parts = re.split(r"(`[^`]*`)", comment)
    return "".join(part if k % 2 else re.sub(r"([<>|*_\[\]])", r"\\\1", part) for k, part in enumerate(parts))
