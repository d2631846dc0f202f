"""Motors, servos, springs, friction, limits and gears on the coordinates of joints: the built-in ones and,
with ``@stark.actuator``, those of your own. docs/actuators.md is the guide."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stark.actuators.definition import Actuation, ActuatorFormula, Coordinate, Memory, act, actuator
    from stark.joints.handle import Actuator
else:
    from stark.on_demand import attach

    # Imported when first used, to keep `import stark` fast.
    __getattr__, __dir__ = attach(
        __name__,
        {
            "stark.actuators.definition": "Actuation ActuatorFormula Coordinate Memory act actuator",
            "stark.joints.handle": "Actuator",
        },
    )

__all__ = ["Actuation", "Actuator", "ActuatorFormula", "Coordinate", "Memory", "act", "actuator"]
