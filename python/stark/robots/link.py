"""A link of a robot in a scene: where it is, what touches it, how it looks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.bodies import RigidBody
from stark.handle import BodyHandle
from stark.joints.handle import Wrench
from stark.mesh import TriangleMesh, joined
from stark.readings import reading
from stark.robots.description import Link
from stark.robots.kinematics import Placement
from stark.robots.meshes import mesh_of

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RobotLink:
    """A link in the scene: a part of ``body``, or of the world where ``body`` is None."""

    name: str
    description: Link
    body: RigidBody | None
    """What moves with it, and maybe with others that are fixed to it."""
    offset: Placement
    """Of its frame in that of the body."""
    source: str
    vertices: tuple[int, int] = (0, 0)
    """First vertex of its shapes in the mesh of the body, and the one after the last."""

    @property
    def pose(self) -> tuple[Floats, Floats]:
        """Origin (3,) [m] and rotation (3, 3) of its frame in the world, as they are now."""
        place = self.offset if self.body is None else Placement(*self.body.pose).at(*self.offset)
        return (
            reading(np.array(place.position), self, "position"),
            reading(np.array(place.rotation), self, "rotation"),
        )

    @property
    def position(self) -> Floats:
        """Origin of its frame in the world (3,) [m]."""
        return self.pose[0]

    @property
    def rotation(self) -> Floats:
        """Axes of its frame in the world, as columns (3, 3)."""
        return self.pose[1]

    @property
    def velocity(self) -> Floats:
        """Of the origin of its frame (3,) [m/s], world axes."""
        if self.body is None:
            return np.zeros(3)
        arm = self.position - moving_point(self.body)
        return reading(self.body.velocity + np.cross(self.angular_velocity, arm), self, "velocity")

    @property
    def angular_velocity(self) -> Floats:
        """(3,) [rad/s], world axes."""
        if self.body is None:
            return np.zeros(3)
        return reading(np.array(self.body.angular_velocity), self, "angular_velocity")

    @cached_property
    def visual(self) -> TriangleMesh | None:
        """The surface that the file shows, in the frame of the link [m]; None where there is none."""
        return self._mesh(self.description.visuals)

    @cached_property
    def collision(self) -> TriangleMesh | None:
        """The surface that the file lets touch, in the frame of the link [m]; None where there is none."""
        return self._mesh(self.description.collisions)

    def contact_wrench(self, other: BodyHandle | str | None = None) -> Wrench:
        """Contact forces on the shapes of this link in the last step, of everything or of another body: their
        sum (3,) [N], friction included, and their moment about the origin of the frame of the link (3,) [N
        m], in world axes. Links that are fixed to it have their own. Links without shapes have none."""
        if self.body is None:
            return Wrench(np.zeros(3), np.zeros(3))
        contacts = self.body.contacts(other)
        first, end = self.vertices
        mine = (contacts.vertices[:, 0] >= first) & (contacts.vertices[:, 0] < end)
        touching = contacts._take(mine)
        return Wrench(touching.forces.sum(axis=0), touching.torque_about(self.position))

    def _mesh(self, shapes: Sequence[Any]) -> TriangleMesh | None:
        parts = [mesh_of(shape, self.source, f"link '{self.name}'") for shape in shapes]
        return joined(parts) if parts else None

    @property
    def _title(self) -> str:
        return f"link '{self.name}'"

    def __repr__(self) -> str:
        return f"<stark.robots.RobotLink '{self.name}'>"


def moving_point(body: RigidBody) -> Floats:
    """What ``body.velocity`` is of: the centre of mass; of scripted bodies, the origin."""
    position, rotation = body.pose
    return position if body.motion == "scripted" else position + rotation @ body.center_of_mass
