"""A test stands where its source stands: src/stark/a/b.cpp <-> tests/a/test_b.cpp, python/stark/a/b.py <->
tests/python/a/test_b.py, or tests/python/a/test_a_b.py where another test has the short name. A module whose
name no other one has may be tested by tests/python/test_b.py.

Sources that share a test with others are listed in tools/tested_elsewhere.txt; a new source without a test of
its name is an error, and so is an entry of the list that is not needed any more. A folder in the list, with a
slash at its end, stands for sources that are rows of a table each, all of which a test walks. Modules that
define public names of the Python package must not be listed. Names of Python tests are unique."""

from __future__ import annotations

import ast
import sys
from collections import Counter
from pathlib import Path

from repository import ROOT, run_check, source_files

LIST = "tools/tested_elsewhere.txt"
PACKAGE = "python/stark"


def orphans(root: Path) -> list[str]:
    """Sources for which no test file of the mirrored name exists."""
    return [*_cpp_orphans(root), *_python_orphans(root)]


def check(root: Path) -> list[str]:
    """Orphans that the list does not have, and entries that have a test now, are gone or are public."""
    found, public = orphans(root), public_modules(root)
    listed = (root / LIST).read_text().split() if (root / LIST).is_file() else []
    errors = [
        f"{source} has no test of its name; write one"
        + ("" if source in public else f", or add it to {LIST}")
        for source in found
        if not _is_listed(source, listed) or source in public
    ]
    needed = {*found, *(f"{Path(source).parent}/" for source in found)}
    errors += [f"{LIST}: {entry} need not be listed" for entry in listed if entry not in needed]
    return errors + _namesakes(root)


def _namesakes(root: Path) -> list[str]:
    """Test modules of one name in two folders: pytest imports the first one for both."""
    tests = source_files(root, (".py",), "tests")
    same_name = Counter(path.name for path in tests)
    return [
        f"{path.relative_to(root)}: another test has its name; write test_{path.parent.name}_..."
        for path in tests
        if path.name.startswith("test_") and same_name[path.name] > 1
    ]


def _is_listed(source: str, listed: list[str]) -> bool:
    return source in listed or f"{Path(source).parent}/" in listed


def public_modules(root: Path) -> set[str]:
    """Modules from which stark or one of its packages takes names for its users."""
    package = root / PACKAGE
    found = set()
    for path in [*package.glob("__init__.pyi"), *package.glob("*/__init__.py")]:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names = _exported(tree) if path.suffix == ".py" else None
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom):
                taken = [a.name for a in node.names if names is None or (a.asname or a.name) in names]
                found |= _modules_of(node, taken, path.parent, package)
    return {str(path.relative_to(root)) for path in found}


def _exported(tree: ast.Module) -> set[str]:
    """The names in __all__."""
    lists = [
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__"
    ]
    return {name for names in lists for name in names}


def _modules_of(node: ast.ImportFrom, names: list[str], folder: Path, package: Path) -> set[Path]:
    """Files of the package that these names of an import are from."""
    parts = node.module.split(".") if node.module else []
    if node.level:
        base = folder.parents[node.level - 2] if node.level > 1 else folder
    elif parts[:1] == ["stark"]:
        base, parts = package, parts[1:]
    else:
        return set()
    module = base.joinpath(*parts)
    # `from stark import motion as motion`: the name is a module itself.
    files = [module.with_suffix(".py"), *(module / f"{name}.py" for name in names)] if names else []
    return {path for path in files if path.is_file()}


def _cpp_orphans(root: Path) -> list[str]:
    found = []
    for path in source_files(root, (".cpp",), "src/stark"):
        relative = path.relative_to(root / "src/stark")
        mirrored = [root / "tests" / relative.parent, root / "tests" / relative.parts[0]]
        if not any((folder / f"test_{path.name}").is_file() for folder in mirrored):
            found.append(f"src/stark/{relative}")
    return found


def _python_orphans(root: Path) -> list[str]:
    # Packages and packaged scenes are tested as a whole.
    sources = [
        path.relative_to(root / PACKAGE)
        for path in source_files(root, (".py",), PACKAGE)
        if not path.name.startswith("__") and path.relative_to(root / PACKAGE).parts[0] != "scenes"
    ]
    same_name = Counter(path.stem for path in sources)
    same_name.update(path.parent.name for path in (root / PACKAGE).glob("*/__init__.py"))
    tests = root / "tests/python"
    found = []
    for path in sources:
        stem, folder = path.stem.lstrip("_"), path.parent.name or "stark"
        names = [path.parent / f"test_{stem}.py", path.parent / f"test_{folder}_{stem}.py"]
        if same_name[path.stem] == 1:
            names.append(Path(f"test_{stem}.py"))
        if not any((tests / name).is_file() for name in names):
            found.append(f"{PACKAGE}/{path}")
    return found


if __name__ == "__main__":
    sys.exit(run_check("mirror", check(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT)))
