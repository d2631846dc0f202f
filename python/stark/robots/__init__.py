"""Robots from URDF, MJCF and USD files: ``scene.add_robot("panda.urdf")``. docs/robots.md is the guide."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stark.robots.description import (
        Closure,
        Flex,
        Gains,
        Geometry,
        Inertia,
        Link,
        Mimic,
        RobotDescription,
        RobotJoint,
    )
    from stark.robots.drives import Drives
    from stark.robots.handle import Robot
    from stark.robots.inverse import Reach
    from stark.robots.link import RobotLink
    from stark.robots.reading import read
    from stark.robots.report import Finding, Report
else:
    from stark.on_demand import attach

    # Imported when first used, to keep `import stark` fast.
    __getattr__, __dir__ = attach(
        __name__,
        {
            "stark.robots.handle": "Robot",
            "stark.robots.inverse": "Reach",
            "stark.robots.link": "RobotLink",
            "stark.robots.description": (
                "Closure Flex Gains Geometry Inertia Link Mimic RobotDescription RobotJoint"
            ),
            "stark.robots.drives": "Drives",
            "stark.robots.reading": "read",
            "stark.robots.report": "Finding Report",
        },
    )

__all__ = [
    "Closure",
    "Drives",
    "Finding",
    "Flex",
    "Gains",
    "Geometry",
    "Inertia",
    "Link",
    "Mimic",
    "Reach",
    "Report",
    "Robot",
    "RobotDescription",
    "RobotJoint",
    "RobotLink",
    "read",
]
