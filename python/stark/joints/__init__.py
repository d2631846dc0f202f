"""Joints between rigid bodies, patches of deformable ones and the world: the built-in ones and, with
``@stark.joint``, those of your own. docs/joints.md is the guide."""

from typing import Any

_PLACES = {
    "Joint": "handle",
    "Wrench": "handle",
    "JointFormula": "definition",
    "hold": "definition",
    "joint": "definition",
}

__all__ = ["Joint", "JointFormula", "Wrench", "hold", "joint"]


def __getattr__(name: str) -> Any:
    # Imported when first used, to keep `import stark` fast.
    if name in _PLACES:
        import importlib

        return getattr(importlib.import_module(f"stark.joints.{_PLACES[name]}"), name)
    raise AttributeError(f"module 'stark.joints' has no attribute {name!r}")
