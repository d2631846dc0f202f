"""Writes the type stub of the compiled module: make_stub.py FOLDER_OF_THE_MODULE FOLDER_OF_THE_STUB.

nanobind writes the signatures; here containers get types of entries, and results that may be anything are
Any, so that strict type checkers know all of it."""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

from nanobind import stubgen

MODULE = "_core"
_SIGNATURE = re.compile(r"^\s*(def |\w+: )")
_OPERATOR = re.compile(r"^    def (__\w+__)\(self, arg: object, /\) -> Any: \.\.\.$", re.MULTILINE)
_OVERLOADS = r"""    @overload
    def \1(self, arg: Scalar | float | numpy.number[Any] | numpy.bool, /) -> Scalar: ...

    @overload
    def \1(self, arg: NDArray[Any], /) -> Any: ..."""
_ENTRIES = {"dict": "dict[str, Any]", "list": "list[Any]", "tuple": "tuple[Any, ...]"}


def typed(text: str) -> str:
    """A stub without containers of unknown entries."""
    lines = [_typed_signature(line) if _SIGNATURE.match(line) else line for line in text.splitlines()]
    body = "\n".join(lines).replace(f"from {MODULE} import", "from . import")
    body = _OPERATOR.sub(_OVERLOADS, body)
    found = re.search(r"^from typing import (.*)$", body, re.MULTILINE)
    if found is None:
        return body.replace("\nimport numpy", "\nfrom typing import Any\n\nimport numpy", 1) + "\n"
    needed = {"Any", "overload"} if "@overload" in body else {"Any"}
    names = sorted(needed | set(found[1].split(", ")))
    return body.replace(found[0], f"from typing import {', '.join(names)}", 1) + "\n"


def _typed_signature(line: str) -> str:
    line = re.sub(r"(?<![\w\]'\".])(dict|list|tuple)(?![\w\[('\"])", lambda m: _ENTRIES[m[1]], line)
    if line.lstrip().startswith("def __eq__(") or line.lstrip().startswith("def __ne__("):
        line = re.sub(r"(arg|other): [\w.| ]+(, /)?\) -> \w+:", r"\1: object\2) -> bool:", line)
    # Comparisons are told by bool.
    return re.sub(r"-> object:", "-> Any:", line)


def main(module: str, place: str) -> None:
    """Writes FOLDER/_core/*.pyi."""
    with tempfile.TemporaryDirectory() as folder:
        stubgen.main(["-q", "-r", "-m", MODULE, "-i", module, "-O", folder])
        target = Path(place) / MODULE
        target.mkdir(parents=True, exist_ok=True)
        for path in Path(folder, MODULE).glob("*.pyi"):
            text = typed(path.read_text(encoding="utf-8"))
            if path.name == "__init__.pyi":
                text += "\n__version__: str\n"  # left out by the generator
            (target / path.name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
