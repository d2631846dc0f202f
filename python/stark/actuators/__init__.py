"""Motors, servos, springs, friction, limits and gears on the coordinates of joints: the built-in ones and,
with ``@stark.actuator``, those of your own. docs/actuators.md is the guide."""

from typing import Any

_PLACES = {
    "Actuation": "definition",
    "Actuator": "handle",
    "ActuatorFormula": "definition",
    "Coordinate": "definition",
    "Memory": "definition",
    "act": "definition",
    "actuator": "definition",
}

__all__ = ["Actuation", "Actuator", "ActuatorFormula", "Coordinate", "Memory", "act", "actuator"]


def __getattr__(name: str) -> Any:
    # Imported when first used, to keep `import stark` fast.
    if name in _PLACES:
        import importlib

        return getattr(importlib.import_module(f"stark.actuators.{_PLACES[name]}"), name)
    raise AttributeError(f"module 'stark.actuators' has no attribute {name!r}")
