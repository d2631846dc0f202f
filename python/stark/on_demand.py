"""Packages whose names are imported when they are first used, to keep `import stark` fast."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Mapping, Sequence
from types import ModuleType


def attach(
    package: str, places: Mapping[str, str], modules: Sequence[str] = ()
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of a package. ``places``: names in a row, by the module that has them;
    ``modules``: those of the package that are names themselves."""
    module_of = {name: module for module, names in places.items() for name in names.split()}

    def known() -> set[str]:
        return {*vars(sys.modules[package]), *module_of, *modules}

    def get(name: str) -> object:
        if name in modules:
            return importlib.import_module(f"{package}.{name}")
        if name not in module_of:
            inside = {n for n in known() if n in modules or f"{package}.{n}" in sys.modules}
            near = _deeper(name, package, inside) or _nearest(name, package, known())
            message = f"module '{package}' has no attribute {name!r}{near}"
            raise AttributeError(message, name=name, obj=None)  # without an object Python adds no hint
        value = getattr(importlib.import_module(module_of[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    return get, lambda: sorted(known())


def _deeper(name: str, package: str, modules: set[str]) -> str:
    """'; did you mean ...?' for a name that a module of the package has, or nothing."""
    if name.startswith("_"):
        return ""
    for module in sorted(modules, key=lambda n: (f"{package}.{n}" not in sys.modules, n)):
        if _has(f"{package}.{module}", name):
            return f"; did you mean {package}.{module}.{name}?"
    return ""


def _has(module: str, name: str) -> bool:
    """Whether a module has a public name. One that is not loaded is read, not imported: a misspelt name
    must not take the second that all modules take."""
    if module in sys.modules:
        has = vars(sys.modules[module])
        return name in has.get("__all__", has) and not isinstance(has.get(name), ModuleType)
    spec = importlib.util.find_spec(module)
    source = getattr(spec.loader, "get_source", lambda _: None)(module) if spec else None
    return source is not None and name in source and name in _names_in(source)


def _names_in(source: str) -> set[str]:
    """What ``__all__`` lists in the text of a module, or what its statements define."""
    import ast  # not at start-up

    defined: set[str] = set()
    for statement in ast.parse(source).body:
        if isinstance(statement, (ast.FunctionDef, ast.ClassDef)):
            defined.add(statement.name)
        elif isinstance(statement, (ast.Assign, ast.AnnAssign)) and statement.value is not None:
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            named = {target.id for target in targets if isinstance(target, ast.Name)}
            if "__all__" in named:
                return set(ast.literal_eval(statement.value))
            defined |= named
    return defined


#: What other libraries call functions, too short for the nearest name to be the right one.
_SHORT = {"det": "determinant", "inv": "inverse", "tr": "trace", "eye": "identity"}


def _nearest(name: str, package: str, names: set[str]) -> str:
    """'; did you mean ...?', or nothing."""
    import difflib

    if name.startswith("_"):
        return ""
    known = sorted(n for n in names if not n.startswith("_"))
    lower = {n.lower(): n for n in known}
    near = [_SHORT[name]] if _SHORT.get(name) in names else difflib.get_close_matches(name, known, n=1)
    near = near or [lower[n] for n in difflib.get_close_matches(name.lower(), lower, n=1)]
    return f"; did you mean {package}.{near[0]}?" if near else ""
