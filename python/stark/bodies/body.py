"""Handles of bodies: what ``scene.add_*`` returns and what ``simulation.bodies`` holds.

A handle names a body of a scene. The properties that change in time (positions, velocities, poses) are those
of the newest simulation of the scene that is alive; ``simulation[body]`` is the same body in one particular
simulation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark import _core
from stark._core import InvalidArgument
from stark.arguments import real_array
from stark.attributes import AnsweredAttributes
from stark.bodies.sensors import ContactSensors
from stark.handle import AnyMesh, SceneLink
from stark.mesh import Indices, TriangleMesh
from stark.readings import reading
from stark.selections import Points, Stencils, stencils, vertex_points

Floats = NDArray[np.float64]


class Body(ContactSensors, AnsweredAttributes):
    """A body of a scene; equal and hashed by scene and name."""

    _elsewhere: ClassVar[Mapping[str, str]] = {
        "force": "scene.add_force(body, (0, 0, 1.0)) [N], before the simulation; contact_force is what "
        "others do to it",
        "add_force": "scene.add_force(body, (0, 0, 1.0)) [N], before the simulation",
        "apply_force": "scene.add_force(body, (0, 0, 1.0)) [N], before the simulation",
        "torque": "scene.add_torque(body, (0, 0, 1.0)) [N m], before the simulation",
        "add_torque": "scene.add_torque(body, (0, 0, 1.0)) [N m], before the simulation",
        "apply_impulse": "body.velocity += impulse / body.mass, of rigid bodies",
        **dict.fromkeys(
            ("pos", "x", "translation", "location", "set_position"),
            "position of rigid bodies, positions of others",
        ),
        **dict.fromkeys(
            ("orientation", "rot", "quat", "quaternion"),
            "rotation, a matrix; a quaternion (w, x, y, z) may be assigned too",
        ),
        **dict.fromkeys(
            ("vel", "v", "linear_velocity", "set_velocity"), "velocity of rigid bodies, velocities of others"
        ),
        **dict.fromkeys(("omega", "ang_vel", "rotational_velocity"), "angular_velocity"),
        **dict.fromkeys(
            ("density", "youngs_modulus", "poisson_ratio", "thickness"),
            "body.material, of cloth, solids and rods; it is given where the body is added",
        ),
        "friction": "scene.friction[a, b] for a pair, or friction=0.5 where the body is added",
        "restitution": "scene.restitution[a, b]",
        **dict.fromkeys(
            ("stress", "stresses", "cauchy_stress"),
            "stark.render.tensor_values(sim, 'stress')[body.name], or sim.picture(field='stress')",
        ),
        **dict.fromkeys(
            ("strain", "strains", "von_mises", "von_mises_stress"),
            "stark.render.field_values(sim, 'strain')[body.name], or 'stress' for that of von Mises",
        ),
        **dict.fromkeys(
            ("deformation_gradient", "deformation_gradients"),
            "stark.render.tensor_values(sim, 'deformation_gradient', at='elements')[body.name]",
        ),
        **dict.fromkeys(
            ("energy", "kinetic_energy", "potential_energy"), "report.energy of what sim.step() returns"
        ),
        **dict.fromkeys(("bounds", "aabb"), "body.positions.min(axis=0) and .max(axis=0)"),
        **dict.fromkeys(("volume", "area"), "body.mesh.volume, body.mesh.area"),
        **dict.fromkeys(
            ("fix", "fixed", "pinned"), "pins= where the body is added; rigid bodies have motion='fixed'"
        ),
        **dict.fromkeys(
            ("unpin", "unfix", "release"),
            "scene.attach(body.vertices[[0]], None) in place of pins, which hold for good; enabled = False "
            "of the attachment lets go",
        ),
    }

    _given_by: ClassVar[Mapping[str, str]] = {
        "mass": "mass= where the body is added",
        "inertia": "inertia=(mass, center_of_mass, tensor) where the body is added",
        "color": "color= where the body is added",
        "name": "name= where the body is added",
        "motion": "motion= where the body is added, scene.add_box(..., motion='scripted')",
        **dict.fromkeys(("contact_distance", "contact_stiffness"), "it where the body is added, as argument"),
        "pins": "pins= where the body is added, or body.pin(vertices); pins hold for good, what "
        "scene.attach(body.vertices[[0]], None) holds is let go by enabled = False",
        "contact_force": "scene.add_force(body, (0, 0, 1.0)) [N], before the simulation",
    }

    #: Arrays of the description that its mesh is made of.
    _mesh_arrays: ClassVar[tuple[str, ...]] = ("vertices", "triangles")

    def __init__(self, scene: SceneLink, index: int, mesh: AnyMesh, color: Any = None) -> None:
        super().__init__(scene, index)
        self._mesh = mesh._kept()
        self._color = None if color is None else tuple(float(c) for c in color)
        self._shared: dict[str, Any] = {}  # what is computed once for all handles of the body
        self._rest_placement = None

    @classmethod
    def _mesh_of(cls, given: Mapping[str, Any]) -> AnyMesh:
        """The mesh of a body of this kind from the arrays of its description."""
        return TriangleMesh(given["vertices"], given["triangles"])

    @property
    def triangles(self) -> Indices:
        """Surface triangles (m, 3) as indices of ``positions``."""
        assert isinstance(self._mesh, TriangleMesh)
        return self._mesh.triangles

    @property
    def positions(self) -> Floats:
        """Positions of all vertices in the world (n, 3) [m], in the order of ``mesh.vertices``; a copy."""
        return self._positions(assign=False)

    def _positions(self, *, assign: bool) -> Floats:
        simulation = self._simulation()
        if simulation is None:
            return reading(self._scene._core.initial_positions(self._index), self, "positions", assign=assign)
        return reading(simulation._core.positions(self._index), self, "positions", assign=assign)

    @property
    def surface_positions(self) -> Floats:
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
        if noun not in self._shared:
            self._shared[noun] = stencils(self, indices(), noun)
        chosen: Stencils = self._shared[noun]
        return chosen

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
    def contact_core(self) -> float:
        """Part of the contact distance [m] that no pressure takes: ``stark.Surface.core``; 0 without one."""
        return self._scene._core.contact_core(self._index)

    @property
    def surface_direction(self) -> NDArray[np.float64] | None:
        """Direction of the surface, for ``stark.Anisotropic`` friction: the nap of a fabric, the grooves of a
        belt. One vector (3,), or one for each of the ``surface_triangles`` (m, 3), in the frame of the mesh;
        None: no direction.

        Its part in the plane of a triangle counts, not its length nor its sign. It turns and deforms with the
        body. Simulations see the value that it has when they are made."""
        given = self._scene._core.surface_directions(self._index)
        if len(given) == 0:
            return None
        return reading(given[0] if len(given) == 1 else given, self, "surface_direction", assign=True)

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

    def _require_of_scene(self, what: str) -> None:
        """For what changes the scene, which a simulation has copied."""
        if self._of is not None:
            raise InvalidArgument(
                f"'{self.name}': {what} changes the scene, not the simulation, which has copied it: use the "
                f"body of the scene, sim.scene['{self.name}'], before you create stark.Simulation(scene)"
            )

    def _if_gone(self) -> None:
        if self._index < self._scene._simulated_bodies:
            raise InvalidArgument(
                f"'{self.name}': its simulation is gone; keep the stark.Simulation in a variable while "
                f"its bodies are used"
            )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and other._scene is self._scene and other._index == self._index

    def __hash__(self) -> int:
        return hash((id(self._scene), self._index))

    def __repr__(self) -> str:
        return f"<stark.{type(self).__name__} '{self.name}'>"
