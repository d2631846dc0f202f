"""Handles of rigid bodies: poses, velocities, placing, scripted motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.bodies.body import Body
from stark.bodies.following import follow_pose, refuse_other_motion, refuse_replaced_pose
from stark.bodies.moving_surface import MovingSurface
from stark.bodies.sensors import InertialSensors
from stark.handle import SimulationLink
from stark.mesh import TriangleMesh
from stark.readings import reading
from stark.rotations import as_matrix, vector
from stark.selections import FrameHandle, Points, local_points, rigid_frame


class RigidBody(InertialSensors, Body, MovingSurface):
    """A rigid body. ``position`` and ``rotation`` place the frame of its mesh, whose origin need not be its
    centre of mass. Dynamic bodies are placed by assigning to them, at once (docs/state.md). Scripted bodies
    are moved so: to the pose that holds at the end of the next step."""

    kind = "rigid"
    _elsewhere: ClassVar[Mapping[str, str]] = {
        **Body._elsewhere,
        "density": "body.mass [kg]; density= is given where the body is added",
        **dict.fromkeys(
            ("youngs_modulus", "poisson_ratio", "thickness"),
            "scene.add_solid or add_cloth for what deforms: a rigid body has none",
        ),
        "material": "mass= or density= where it is added; scene.friction, restitution and stark.Surface say "
        "how it touches",
    }

    def points(self, local: ArrayLike) -> Points:
        """Points fixed to the body, for energies: (n, 3) or (3,) in the frame of its mesh [m]."""
        return local_points(self, local)

    def frame(self, position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike | None = None) -> FrameHandle:
        """Frame fixed to the body, for energies: ``position`` [m] and ``rotation`` in the frame of its
        mesh."""
        return rigid_frame(self, position, rotation)

    @property
    def position(self) -> NDArray[np.float64]:
        """Origin of the mesh frame in the world (3,) [m]; assign it to place a dynamic body."""
        return reading(self._pose()[0], self, "position", assign=True)

    @position.setter
    def position(self, value: ArrayLike) -> None:
        position = vector(value, f"'{self.name}': position")
        self._set_pose("position", position, self._target("position")[1])

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Rotation of the mesh frame to the world (3, 3); a quaternion (w, x, y, z) may be assigned too. A
        dynamic body is turned about the origin of its mesh."""
        return reading(self._pose()[1], self, "rotation", assign=True)

    @rotation.setter
    def rotation(self, value: ArrayLike) -> None:
        rotation = as_matrix(value, f"'{self.name}': rotation")
        self._set_pose("rotation", self._target("rotation")[0], rotation)

    @property
    def pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(position, rotation); assign both at once to a dynamic or scripted body."""
        position, rotation = self._pose()
        return (
            reading(position, self, "position", assign=True),
            reading(rotation, self, "rotation", assign=True),
        )

    @pose.setter
    def pose(self, value: tuple[ArrayLike, ArrayLike]) -> None:
        if not isinstance(value, (tuple, list)) or len(value) != 2:
            raise InvalidArgument(
                f"'{self.name}': pose = {value!r}: must be (position [m], rotation); assign position or "
                f"rotation for one of them"
            )
        position = vector(value[0], f"'{self.name}': position")
        self._set_pose("pose", position, as_matrix(value[1], f"'{self.name}': rotation"))

    def follow(self, position: Any = None, rotation: Any = None, *, displacement: None = None) -> None:
        """Moves a scripted body on motions (stark.motion, or functions of the time [s]) from the next step:
        ``position`` (3,) [m], ``rotation`` (matrix or quaternion), both of the body in the world, not changes
        since time 0 as those of pins: ``lambda t: turn(t) @ start`` turns a body on from the rotation
        ``start`` that it was added with. What is left out stays as at time 0. ``displacement``, of pins, is
        refused.
        Without arguments nothing is followed any more. Values are those of the end of each step, whatever its
        length; a step that the solver halves goes halfway on the straight line."""
        refuse_other_motion(self.name, "displacement", displacement)
        follow_pose(self, position, rotation)

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocity of the centre of mass (3,) [m/s]; of the origin of the mesh frame for scripted bodies.
        When it is assigned, dynamic bodies have it at once, and scripted ones move at it from the next step
        on."""
        found = self._require_simulation("velocity")._core.center_velocity(self._index)
        return reading(found, self, "velocity", assign=True)

    @velocity.setter
    def velocity(self, value: ArrayLike) -> None:
        velocity = vector(value, f"'{self.name}': velocity")
        self._require_movable("velocity")
        self._set_velocity("velocity", velocity, self.angular_velocity)

    @property
    def angular_velocity(self) -> NDArray[np.float64]:
        """(3,) [rad/s], world axes; assign it to dynamic and scripted bodies."""
        found = self._require_simulation("angular_velocity")._core.twist(self._index)[1]
        return reading(found, self, "angular_velocity", assign=True)

    @angular_velocity.setter
    def angular_velocity(self, value: ArrayLike) -> None:
        angular_velocity = vector(value, f"'{self.name}': angular_velocity")
        self._require_movable("angular_velocity")
        self._set_velocity("angular_velocity", self.velocity, angular_velocity)

    @property
    def center_of_mass(self) -> NDArray[np.float64]:
        """In the frame of the mesh (3,) [m]."""
        found = np.array(self._scene._core.inertia(self._index)["center_of_mass"])
        return reading(found, self, "center_of_mass")

    @property
    def inertia(self) -> NDArray[np.float64]:
        """About the centre of mass, axes of the mesh frame (3, 3) [kg m^2]."""
        return reading(self._scene._core.inertia(self._index)["tensor"], self, "inertia")

    @property
    def shown(self) -> TriangleMesh | None:
        """What pictures, replays and exports show instead of the surface that touches, in the frame of the
        mesh; None where that is shown. Given where the body is added."""
        shown: TriangleMesh | None = self._shared.get("shown")
        return shown

    def _pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        simulation = self._simulation()
        return (
            self._scene._core.pose(self._index) if simulation is None else simulation._core.pose(self._index)
        )

    def _target(self, what: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What the rest of the pose is when a part of it is assigned: of scripted bodies what they head
        for."""
        simulation = self._require_movable(what)
        if self.motion == "scripted":
            return simulation._core.target_pose(self._index)
        return simulation._core.pose(self._index)

    def _set_pose(self, what: str, position: NDArray[np.float64], rotation: NDArray[np.float64]) -> None:
        simulation = self._require_movable(what)
        if self.motion == "scripted":
            there, turned = self._target(what)
            refuse_replaced_pose(self, what, (position, there), (rotation, turned))
            simulation._core.set_pose(self._index, position, rotation)
        else:
            simulation._to_place(what).place(self._index, position, rotation)

    def _set_velocity(
        self, what: str, velocity: NDArray[np.float64], angular_velocity: NDArray[np.float64]
    ) -> None:
        simulation = self._require_movable(what)
        if self.motion == "scripted":
            moving, turning = simulation._core.twist(self._index)
            refuse_replaced_pose(self, what, (velocity, moving), (angular_velocity, turning))
            simulation._core.set_twist(self._index, velocity, angular_velocity)
        else:
            simulation._to_place(what).push(self._index, velocity, angular_velocity)

    def _require_movable(self, what: str) -> SimulationLink:
        if self.motion == "fixed":
            raise InvalidArgument(
                f"'{self.name}' is fixed: its {what} cannot be set; only dynamic and scripted bodies can be "
                f"moved, add it with motion='scripted'"
            )
        if self._newest() is None:
            raise InvalidArgument(
                f"'{self.name}': {what} = ... needs a simulation: create one with sim = "
                f"stark.Simulation(scene) and keep it; to say how a body starts, give position=, rotation=, "
                f"velocity= and angular_velocity= where it is added"
            )
        return self._require_simulation(what)
