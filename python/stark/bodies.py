"""Handles of bodies: what ``scene.add_*`` returns and what ``simulation.bodies`` holds.

A handle names a body of a scene. The properties that change in time (positions, velocities, poses) are those
of the newest simulation of the scene that is alive; ``simulation[body]`` is the same body in one particular
simulation."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark import _core
from stark._core import InvalidArgument
from stark.arguments import added_later, as_array, needs_simulation, real_array
from stark.attributes import KnownAttributes
from stark.layers import LayeredBody
from stark.mesh import Indices, Points, Polyline, SolidMesh, TetMesh, TriangleMesh
from stark.rotations import as_matrix, check_places, vector
from stark.sensors import ContactSensors, InertialSensors

if TYPE_CHECKING:
    from stark.formulas.points import FrameHandle, Points, Stencils
    from stark.scene import Scene
    from stark.simulation import Simulation


class Body(ContactSensors, KnownAttributes):
    """A body of a scene; equal and hashed by scene and name."""

    kind: str = ""

    def __init__(
        self, scene: Scene, index: int, mesh: TriangleMesh | TetMesh | SolidMesh | Polyline, color: Any = None
    ) -> None:
        self._scene = scene
        self._index = index
        self._mesh = mesh
        self._color = None if color is None else tuple(float(c) for c in color)
        self._of: Simulation | None = None  # of handles that sim[body] gave
        self._shared: dict[str, Any] = {}  # what is computed once for all handles of the body
        self._rest_placement: tuple[Any, Any] | None = None  # of bodies that start in another shape than rest

    @property
    def name(self) -> str:
        return self._scene._core.name(self._index)

    @property
    def motion(self) -> str:
        """ "dynamic", "fixed" or "scripted"."""
        return self._scene._core.motion(self._index)

    @property
    def mesh(self) -> TriangleMesh | TetMesh | SolidMesh | Polyline:
        """The mesh it was made from, in the frame of the body [m]."""
        return self._mesh

    @property
    def triangles(self) -> Indices:
        """Surface triangles (m, 3) as indices of ``positions``."""
        assert isinstance(self._mesh, TriangleMesh)
        return self._mesh.triangles

    @property
    def positions(self) -> Points:
        """Positions of all vertices in the world (n, 3) [m], in the order of ``mesh.vertices``; a copy."""
        simulation = self._simulation()
        if simulation is None:
            return self._scene._core.initial_positions(self._index)
        return simulation._core.positions(self._index)

    @property
    def surface_positions(self) -> Points:
        """Positions of the vertices of the surface (k, 3) [m]."""
        return self.positions

    @property
    def surface_triangles(self) -> Indices:
        """Surface triangles (m, 3) as indices of ``surface_positions``."""
        return self.triangles

    # --- points for energies ---

    @property
    def vertices(self) -> Points:
        """All vertices, as points for energies: ``cloth.vertices[[0, 5]]`` are two of them."""
        from stark.formulas.points import vertex_points

        return vertex_points(self, np.arange(len(self._mesh.vertices), dtype=np.int32))

    @property
    def edges(self) -> Stencils:
        """All edges, as stencils of two points for energies."""
        return self._stencils(self._edge_indices, "edges")

    @property
    def faces(self) -> Stencils:
        """All triangles of the surface, as stencils of three points for energies."""
        return self._stencils(lambda: self.triangles, "triangles")

    def _edge_indices(self) -> Indices:
        return _core.find_edges(self.triangles)

    def _stencils(self, indices: Callable[[], Indices], noun: str) -> Stencils:
        from stark.formulas.points import stencils

        if noun not in self._shared:
            self._shared[noun] = stencils(self, indices(), noun)
        return self._shared[noun]

    @property
    def color(self) -> tuple[float, ...] | None:
        """Red, green, blue in [0, 1] for pictures, or None."""
        return self._color

    @property
    def mass(self) -> float:
        """[kg], with that of all of its layers; 0 for fixed and scripted bodies."""
        return self._scene._core.mass(self._index)

    @property
    def contact_distance(self) -> float | None:
        """[m]; its own, else that of ``Simulation.contact_distance``; None while there is no simulation."""
        own, simulation = self._scene._core.contact_distance(self._index), self._simulation()
        return simulation.contact_distance(self) if own is None and simulation is not None else own

    @property
    def contact_stiffness(self) -> float | None:
        """Pressure [Pa] at which the gap is half of the contact distance; None: ``contact.stiffness`` of the
        settings, which by default follows from the weight of each body."""
        return self._scene._core.contact_stiffness(self._index)

    @property
    def surface_direction(self) -> NDArray[np.float64] | None:
        """Direction of the surface, for ``stark.Anisotropic`` friction: the nap of a fabric, the grooves of a
        belt. One vector (3,), or one for each of the ``surface_triangles`` (m, 3), in the frame of the mesh;
        None: no direction.

        Its part in the plane of a triangle counts, not its length nor its sign. It turns and deforms with the
        body. Simulations see the value that it has when they are made."""
        given = self._scene._core.surface_directions(self._index)
        return None if len(given) == 0 else given[0] if len(given) == 1 else given

    @surface_direction.setter
    def surface_direction(self, direction: ArrayLike | None) -> None:
        self._require_of_scene("surface_direction")
        none = np.zeros((0, 3))
        rows = none if direction is None else real_array(direction, f"'{self.name}': surface_direction")
        if rows.shape == (3,):
            rows = rows.reshape(1, 3)
        elif rows.ndim < 2:
            raise InvalidArgument(
                f"'{self.name}': surface_direction = {direction!r}: must be a vector (3,), one for each "
                f"triangle (m, 3), or None"
            )
        self._scene._core.set_surface_directions(self._index, rows)

    def _require_simulation(self, what: str) -> Simulation:
        simulation = self._simulation()
        if simulation is None:
            exists = self._scene._latest_simulation() is not None
            raise (added_later if exists else needs_simulation)(f"'{self.name}'", what)
        return simulation

    def _require_of_scene(self, what: str) -> None:
        """For what changes the scene, which a simulation has copied."""
        if self._of is not None:
            raise InvalidArgument(
                f"'{self.name}': {what}: the simulation keeps the scene that it was made with: must be asked "
                f"of the body of the scene, sim.scene['{self.name}'], before stark.Simulation(scene) is made"
            )

    def _bound_to(self, simulation: Simulation) -> Any:
        handle = object.__new__(type(self))
        handle.__dict__.update(self.__dict__)
        handle._of = simulation
        return handle

    def _simulation(self) -> Simulation | None:
        """That of sim[body]; of handles of the scene the newest one that is alive. None: there has been none
        with this body."""
        if self._of is not None:
            return self._of
        latest = self._scene._latest_simulation()
        if latest is not None and self._index < latest._core.body_count:
            return latest
        if latest is None and self._index < self._scene._simulated_bodies:
            raise InvalidArgument(
                f"'{self.name}': its simulation is gone; keep the stark.Simulation in a variable while "
                f"its bodies are used"
            )
        return None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and other._scene is self._scene and other._index == self._index

    def __hash__(self) -> int:
        return hash((id(self._scene), self._index))

    def __repr__(self) -> str:
        return f"<stark.{type(self).__name__} '{self.name}'>"


class _Deformable(Body):
    def frame(
        self, vertices: ArrayLike, *, position: ArrayLike | None = None, rotation: ArrayLike | None = None
    ) -> FrameHandle:
        """Frame carried by the triangle of three vertices, for energies. ``position`` [m] and ``rotation``
        are those in the world at time 0; without them the centre of the triangle, and its axes along the
        first edge, across it, and along the normal."""
        from stark.formulas.points import patch_frame

        return patch_frame(self, vertices, position, rotation)

    def embedded(self, elements: ArrayLike, weights: ArrayLike) -> Points:
        """Points of elements, for energies: ``elements`` are numbers of triangles (of solids: of tetrahedra),
        ``weights`` their barycentric coordinates (n, 3) or (n, 4), or one row for all."""
        from stark.formulas.points import embedded_points

        rows = self._elements()
        numbers = np.atleast_1d(as_array(elements, f"'{self.name}': elements"))
        if numbers.ndim != 1 or numbers.dtype.kind not in "iu":
            raise InvalidArgument(f"'{self.name}': elements = {elements!r}: must be numbers of elements")
        wrong = numbers[(numbers < 0) | (numbers >= len(rows))]
        if wrong.size:
            raise InvalidArgument(f"'{self.name}': element {wrong[0]}: must be in [0, {len(rows)})")
        return embedded_points(self, rows[numbers], weights)

    def _elements(self) -> Indices:
        return self.triangles

    @property
    def velocities(self) -> Points:
        """Velocities of all vertices (n, 3) [m/s]; a copy."""
        return self._require_simulation("velocities")._core.velocities(self._index)

    @property
    def pins(self) -> Indices:
        """Indices of the pinned vertices, in the order of pinning. Those of ``sim[body]`` are what the
        simulation was made with."""
        if self._of is not None:
            return self._of._pins[self._index].copy()
        return self._scene._core.pins(self._index)

    def pin(self, vertices: ArrayLike) -> None:
        """Prescribes vertices, by index or by a mask: they stay, or follow ``pin_targets``. Simulations have
        the pins that there are when they are made: a StarkWarning says where one is there already."""
        self._require_of_scene("pin")
        indices = as_array(vertices, f"'{self.name}': pin")
        if indices.dtype == bool:
            if indices.shape != (len(self._mesh.vertices),):
                raise InvalidArgument(
                    f"'{self.name}': pin: the mask has the shape {indices.shape}: "
                    f"must be ({len(self._mesh.vertices)},)"
                )
            indices = np.flatnonzero(indices)
        self._scene._core.pin(self._index, np.atleast_1d(indices))
        self._scene._warn_of_simulation(self, "pin")

    @property
    def pin_targets(self) -> Points:
        """Positions that the pinned vertices reach at the end of the next step (k, 3) [m], in the order of
        the ``pins`` of the simulation; assign to move them."""
        return self._require_simulation("pin_targets")._core.pin_targets(self._index)

    @pin_targets.setter
    def pin_targets(self, targets: ArrayLike) -> None:
        array = real_array(targets, f"'{self.name}': pin_targets")
        simulation = self._require_simulation("pin_targets")
        count = len(simulation._pins[self._index])
        if array.shape != (count, 3):
            raise InvalidArgument(
                f"'{self.name}': pin_targets has the shape {array.shape}: "
                f"must be ({count}, 3), a row for each vertex that was pinned when the simulation was made"
            )
        check_places(array, f"'{self.name}': pin_targets")
        simulation._core.set_pin_targets(self._index, np.ascontiguousarray(array))

    def follow(
        self,
        targets: Any = None,
        *,
        displacement: Any = None,
        rotation: Any = None,
        center: ArrayLike | None = None,
        vertices: ArrayLike | None = None,
    ) -> None:
        """Moves pinned vertices on motions (stark.motion, or functions of the time [s]) from the next step
        on.

        ``targets``: positions (k, 3) [m] of the pins, in their order. Or all together, like a rigid body:
        turned by ``rotation`` about ``center`` [m] (the mean of the pins at time 0 if left out) and moved by
        ``displacement`` [m] from where they are at time 0; clamped nodes of rods turn with them.
        ``vertices``: only these of the pinned ones; others may follow another motion. Without arguments
        nothing is followed any more. Values are those of the end of each step, whatever its length; a step
        that the solver halves goes halfway on the straight line."""
        from stark.following import follow_pins

        follow_pins(self, targets, displacement, rotation, center, vertices)


class Cloth(LayeredBody, _Deformable):
    """A sheet of triangles."""

    kind = "cloth"

    @property
    def hinges(self) -> Stencils:
        """All pairs of triangles with a common edge, as stencils of four points for energies: the edge, then
        the opposite vertices."""
        return self._stencils(lambda: _core.find_hinges(self.triangles), "hinges")


class Solid(LayeredBody, _Deformable):
    """A soft volume."""

    kind = "solid"

    @property
    def tetrahedra(self) -> Stencils:
        """All elements of a mesh of linear tetrahedra, as stencils of four points for energies."""
        return self._stencils(self._elements, "tetrahedra")

    def _elements(self) -> Indices:
        mesh = self._mesh
        elements = mesh.tets if isinstance(mesh, TetMesh) else mesh.elements  # type: ignore[union-attr]
        if elements.shape[1] != 4:
            raise InvalidArgument(
                f"'{self.name}': its elements have {elements.shape[1]} nodes: must be tetrahedra of 4; "
                f"choose points with vertices, faces or stark.stencils(body, indices)"
            )
        return elements

    def _edge_indices(self) -> Indices:
        return _core.find_tet_edges(self._elements())

    def _surface(self) -> tuple[Indices, Indices, Indices]:
        """Boundary triangles, the sorted vertices they use, the triangles renumbered to those."""
        if "surface" not in self._shared:
            assert isinstance(self._mesh, (TetMesh, SolidMesh))
            triangles = self._mesh.surface_triangles()
            used, renumbered = np.unique(triangles, return_inverse=True)
            renumbered = renumbered.reshape(triangles.shape).astype(np.int32)
            self._shared["surface"] = triangles, used, renumbered
        return self._shared["surface"]

    @property
    def triangles(self) -> Indices:
        return self._surface()[0]

    @property
    def surface_positions(self) -> Points:
        return self.positions[self._surface()[1]]

    @property
    def surface_triangles(self) -> Indices:
        return self._surface()[2]


class RigidBody(InertialSensors, Body):
    """A rigid body. ``position`` and ``rotation`` place the frame of its mesh, whose origin need not be its
    centre of mass. Scripted bodies are moved by assigning to them: the pose that holds at the end of the next
    step."""

    kind = "rigid"

    def points(self, local: ArrayLike) -> Points:
        """Points fixed to the body, for energies: (n, 3) or (3,) in the frame of its mesh [m]."""
        from stark.formulas.points import local_points

        return local_points(self, local)

    def frame(self, position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike | None = None) -> FrameHandle:
        """Frame fixed to the body, for energies: ``position`` [m] and ``rotation`` in the frame of its
        mesh."""
        from stark.formulas.points import rigid_frame

        return rigid_frame(self, position, rotation)

    @property
    def position(self) -> NDArray[np.float64]:
        """Origin of the mesh frame in the world (3,) [m]."""
        return self._pose()[0]

    @position.setter
    def position(self, value: ArrayLike) -> None:
        position = vector(value, f"'{self.name}': position")
        self._require_scripted("position")
        self._set_pose(position, self._target()[1])

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Rotation of the mesh frame to the world (3, 3); a quaternion (w, x, y, z) may be assigned too."""
        return self._pose()[1]

    @rotation.setter
    def rotation(self, value: ArrayLike) -> None:
        rotation = as_matrix(value, f"'{self.name}': rotation")
        self._require_scripted("rotation")
        self._set_pose(self._target()[0], rotation)

    @property
    def pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(position, rotation); assign both at once to a scripted body."""
        return self._pose()

    @pose.setter
    def pose(self, value: tuple[ArrayLike, ArrayLike]) -> None:
        if not isinstance(value, (tuple, list)) or len(value) != 2:
            raise InvalidArgument(
                f"'{self.name}': pose = {value!r}: must be (position [m], rotation); assign position or "
                f"rotation for one of them"
            )
        self._set_pose(
            vector(value[0], f"'{self.name}': position"), as_matrix(value[1], f"'{self.name}': rotation")
        )

    def follow(self, position: Any = None, rotation: Any = None) -> None:
        """Moves a scripted body on motions (stark.motion, or functions of the time [s]) from the next step:
        ``position`` (3,) [m], ``rotation`` (matrix or quaternion); what is left out stays as at time 0.
        Without arguments nothing is followed any more. Values are those of the end of each step, whatever its
        length; a step that the solver halves goes halfway on the straight line."""
        from stark.following import follow_pose

        follow_pose(self, position, rotation)

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocity of the centre of mass (3,) [m/s]; of the origin of the mesh frame for scripted bodies,
        which move at it from the next step on when it is assigned."""
        core = self._require_simulation("velocity")._core
        of_origin, angular = core.twist(self._index)
        return of_origin + np.cross(angular, core.pose(self._index)[1] @ self.center_of_mass)

    @velocity.setter
    def velocity(self, value: ArrayLike) -> None:
        velocity = vector(value, f"'{self.name}': velocity")
        self._require_scripted("velocity")
        self._set_velocity(velocity, self.angular_velocity)

    @property
    def angular_velocity(self) -> NDArray[np.float64]:
        """(3,) [rad/s], world axes; assign it to scripted bodies."""
        return self._require_simulation("angular_velocity")._core.twist(self._index)[1]

    @angular_velocity.setter
    def angular_velocity(self, value: ArrayLike) -> None:
        angular_velocity = vector(value, f"'{self.name}': angular_velocity")
        self._require_scripted("angular_velocity")
        self._set_velocity(self.velocity, angular_velocity)

    @property
    def center_of_mass(self) -> NDArray[np.float64]:
        """In the frame of the mesh (3,) [m]."""
        return np.array(self._scene._core.inertia(self._index)["center_of_mass"])

    @property
    def inertia(self) -> NDArray[np.float64]:
        """About the centre of mass, axes of the mesh frame (3, 3) [kg m^2]."""
        return self._scene._core.inertia(self._index)["tensor"]

    def _pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        simulation = self._simulation()
        return (
            self._scene._core.pose(self._index) if simulation is None else simulation._core.pose(self._index)
        )

    def _target(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return self._require_simulation("setting a pose")._core.target_pose(self._index)

    def _set_pose(self, position: NDArray[np.float64], rotation: NDArray[np.float64]) -> None:
        simulation = self._require_simulation("setting a pose")
        simulation._core.set_pose(self._index, position, rotation)

    def _set_velocity(self, velocity: NDArray[np.float64], angular_velocity: NDArray[np.float64]) -> None:
        simulation = self._require_simulation("setting a velocity")
        simulation._core.set_twist(self._index, velocity, angular_velocity)

    def _require_scripted(self, what: str) -> None:
        if self.motion != "scripted":
            raise InvalidArgument(
                f"'{self.name}' is {self.motion}: its {what} cannot be set; "
                f"only bodies with motion='scripted' are moved so; where a body starts is said when it is "
                f"added, with position=, rotation=, velocity= and angular_velocity="
            )
