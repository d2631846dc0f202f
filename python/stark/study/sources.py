"""Which source files a scene is made of: its own file and the modules that it imports, in the end by way of
others. Files that were installed (Python's own, packages of pip, Stark) are not part of it."""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import site
import sysconfig
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..scenes.scene_file import SceneFile

#: Most files that are followed by their imports.
_MOST_MODULES = 1000

#: The folder of this package, which has a version of its own.
_STARK = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class _Module:
    """A source file; ``package`` is what its relative imports start from, empty beside the scene."""

    file: Path
    package: str


def scene_hash(scene_file: SceneFile) -> str:
    """SHA-256 of a scene file and of the modules that it imports, beside it or elsewhere. Imports by a name
    that is computed, and files that are no modules, are not seen."""
    path = Path(str(scene_file.module.__file__))
    digest, done = hashlib.sha256(), set[Path]()
    outside: dict[str, _Module] = {}
    waiting = [_Module(path, "")]
    while waiting and len(done) < _MOST_MODULES:
        module = waiting.pop(0)
        if module.file in done:
            continue
        done.add(module.file)
        source = module.file.read_bytes()
        _add(digest, str(module.file.relative_to(path.parent)), source)
        for name in sorted(_names(source, module)):
            beside = _beside(name, path.parent)
            waiting += beside
            if not beside:
                outside.update(_outside(name))
    for name, source in _followed(outside, len(done)):
        _add(digest, name, source)
    return digest.hexdigest()


def _add(digest: hashlib._Hash, name: str, source: bytes) -> None:
    digest.update(f"{name}:{len(source)}:".encode())
    digest.update(source)


def _followed(outside: dict[str, _Module], count: int) -> Iterator[tuple[str, bytes]]:
    """Names and contents of modules elsewhere and of what they import, by name."""
    sources: dict[str, bytes] = {}
    waiting = dict(outside)
    while waiting and count + len(sources) < _MOST_MODULES:
        name, module = waiting.popitem()
        sources[name] = module.file.read_bytes()
        for other in _names(sources[name], module):
            waiting |= {n: m for n, m in _outside(other).items() if n not in sources}
    yield from sorted(sources.items())


def _names(source: bytes, module: _Module) -> set[str]:
    """Names of modules that a source imports, packages around them included."""
    if module.file.suffix != ".py":
        return set()
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = _absolute(node, module.package)
            names.update([base, *(f"{base}.{alias.name}".lstrip(".") for alias in node.names)])
        elif isinstance(node, ast.Call):
            names.update(_imported_by_call(node))
    return {".".join(name.split(".")[:k]) for name in names - {""} for k in range(1, name.count(".") + 2)}


def _absolute(node: ast.ImportFrom, package: str) -> str:
    """What ``from ... import`` names; relative to the folder of the scene where there is no package."""
    parts = package.split(".") if package and node.level else []
    parts = parts[: len(parts) - max(0, node.level - 1)]
    return ".".join([*parts, *([node.module] if node.module else [])])


def _imported_by_call(node: ast.Call) -> list[str]:
    """``import_module("name")`` and ``__import__("name")``."""
    function = node.func
    called = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
    if called not in ("import_module", "__import__") or not node.args:
        return []
    name = getattr(node.args[0], "value", None)
    return [name] if isinstance(name, str) and all(map(str.isidentifier, name.split("."))) else []


def _beside(name: str, folder: Path) -> list[_Module]:
    """A module in the folder of the scene, and its package."""
    place = folder.joinpath(*name.split("."))
    files = (place.with_suffix(".py"), name.rpartition(".")[0]), (place / "__init__.py", name)
    return [_Module(file, package) for file, package in files if file.is_file()]


def _outside(name: str) -> dict[str, _Module]:
    """The module of a name elsewhere, if it was not installed. Imports nothing."""
    first, *rest = name.split(".")
    try:
        spec = importlib.util.find_spec(first)
    except (ImportError, ValueError, AttributeError):
        return {}
    if spec is None:
        return {}
    if not rest:
        return _own(name, Path(spec.origin or ""), is_package=spec.submodule_search_locations is not None)
    for folder in spec.submodule_search_locations or ():
        place = Path(folder).joinpath(*rest)
        for file, is_package in ((place / "__init__.py", True), (place.with_suffix(".py"), False)):
            if file.is_file():
                return _own(name, file, is_package=is_package)
    return {}


def _own(name: str, file: Path, *, is_package: bool) -> dict[str, _Module]:
    if file.suffix != ".py" or not file.is_file() or _is_installed(file.resolve()):
        return {}
    return {name: _Module(file, name if is_package else name.rpartition(".")[0])}


def _is_installed(file: Path) -> bool:
    folders = [*sysconfig.get_paths().values(), *site.getsitepackages(), site.getusersitepackages()]
    kept = {Path(folder).resolve() for folder in folders if folder}
    data = Path(sysconfig.get_path("data")).resolve()  # /usr itself: what lies below may be anything
    return any(file.is_relative_to(folder) for folder in (kept - {data}) | {_STARK})
