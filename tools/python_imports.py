"""Which file of python/stark imports which: at the top, inside functions and for types only."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

Imports = dict[str, set[str]]  # module -> modules of stark that it imports


def imports_of_package(package: Path) -> Imports:
    """All arrows between the modules of a package in a folder; compiled modules are named by their stubs."""
    sources = {_module_of(path, package): path for path in sorted(package.rglob("*.py"))}
    compiled = {_module_of(path, package) for path in package.glob("_*.pyi") if path.stem != "__init__"}
    known = {*sources, *compiled, f"{package.name}._core"}
    return {module: set(_targets(module, path, known)) for module, path in sources.items()}


def circles(imports: Imports) -> list[list[str]]:
    """Modules that import each other, directly or by way of others: none in a house of floors."""
    reached = {module: _reachable(module, imports) for module in imports}
    found: list[list[str]] = []
    for module in sorted(imports):
        if module in reached[module] and not any(module in circle for circle in found):
            found.append([m for m in sorted(reached[module]) if module in reached.get(m, ())])
    return found


def _reachable(start: str, imports: Imports) -> set[str]:
    seen: set[str] = set()
    stack = list(imports[start])
    while stack:
        module = stack.pop()
        if module not in seen:
            seen.add(module)
            stack += imports.get(module, ())
    return seen


def _module_of(path: Path, package: Path) -> str:
    parts = path.relative_to(package.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _targets(module: str, path: Path, known: set[str]) -> Iterator[str]:
    """Modules that a file imports. ``from a import b`` is of the module a.b where there is one, else of a."""
    folder = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{_absolute(node, folder)}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            while name and name not in known:
                name = name.rpartition(".")[0]
            if name:
                yield name


def _absolute(node: ast.ImportFrom, folder: str) -> str:
    """The module that names are imported from."""
    if not node.level:
        return node.module or ""
    parts = folder.split(".")[: len(folder.split(".")) - node.level + 1]
    return ".".join([*parts, *([node.module] if node.module else [])])
