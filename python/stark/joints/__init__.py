"""Joints between rigid bodies, patches of deformable ones and the world: the built-in ones and, with
``@stark.joint``, those of your own. docs/joints.md is the guide."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stark.joints.definition import JointFormula, hold, joint
    from stark.joints.handle import Joint, Wrench
else:
    from stark.on_demand import attach

    # Imported when first used, to keep `import stark` fast.
    __getattr__, __dir__ = attach(
        __name__,
        {
            "stark.joints.definition": "JointFormula hold joint",
            "stark.joints.handle": "Joint Wrench",
        },
    )

__all__ = ["Joint", "JointFormula", "Wrench", "hold", "joint"]
