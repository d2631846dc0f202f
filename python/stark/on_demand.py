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
            near = _deeper(name, package, known()) or _nearest(name, package, known())
            message = f"module '{package}' has no attribute {name!r}{near}"
            raise AttributeError(message, name=name, obj=None)  # without an object Python adds no hint
        value = getattr(importlib.import_module(module_of[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    return get, lambda: sorted(known())


def _deeper(name: str, package: str, names: set[str]) -> str:
    """'; did you mean ...?' for a name that a module of the package has, or nothing."""
    if name.startswith("_"):
        return ""
    loaded = vars(sys.modules[package])
    modules = sorted(n for n in names if importlib.util.find_spec(f"{package}.{n}"))
    for module in sorted(modules, key=lambda n: n not in loaded):
        try:
            has = vars(importlib.import_module(f"{package}.{module}"))
        except ImportError:  # of an optional package
            continue
        if name in has.get("__all__", has) and not isinstance(has.get(name), ModuleType):
            return f"; did you mean {package}.{module}.{name}?"
    return ""


def _nearest(name: str, package: str, names: set[str]) -> str:
    """'; did you mean ...?', or nothing."""
    import difflib

    if name.startswith("_"):
        return ""
    known = sorted(n for n in names if not n.startswith("_"))
    lower = {n.lower(): n for n in known}
    near = difflib.get_close_matches(name, known, n=1)
    near = near or [lower[n] for n in difflib.get_close_matches(name.lower(), lower, n=1)]
    return f"; did you mean {package}.{near[0]}?" if near else ""
