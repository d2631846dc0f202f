"""Bodies of vertices that move against each other: pins, frames, embedded points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import as_array, real_array
from stark.bodies.body import Body
from stark.bodies.following import follow_pins, refuse_other_motion, refuse_replaced_targets
from stark.bodies.rest_state import RestState
from stark.mesh import Indices
from stark.readings import reading
from stark.rotations import check_places
from stark.selections import FrameHandle, Points, embedded_points, patch_frame

Floats = NDArray[np.float64]


class DeformableBody(Body, RestState):
    """A body of vertices that move against each other: cloth, solids, rods."""

    def frame(
        self, vertices: ArrayLike, *, position: ArrayLike | None = None, rotation: ArrayLike | None = None
    ) -> FrameHandle:
        """Frame carried by the triangle of three vertices, for energies. ``position`` [m] and ``rotation``
        are those in the world at time 0; without them the centre of the triangle, and its axes along the
        first edge, across it, and along the normal."""
        return patch_frame(self, vertices, position, rotation)

    def embedded(self, elements: ArrayLike, weights: ArrayLike) -> Points:
        """Points of elements, for energies: ``elements`` are numbers of triangles (of solids: of tetrahedra),
        ``weights`` their barycentric coordinates (n, 3) or (n, 4), or one row for all."""
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
    def positions(self) -> Floats:
        """Positions of all vertices in the world (n, 3) [m], in the order of ``mesh.vertices``; a copy.
        Assign them to place the body at once (docs/state.md); pinned vertices rest where they are placed."""
        return self._positions(assign=True)

    @positions.setter
    def positions(self, value: ArrayLike) -> None:
        simulation, rows = self._require_simulation("positions"), self._rows(value, "positions")
        simulation._to_place("positions").place_vertices(self._index, rows)

    @property
    def velocities(self) -> Floats:
        """Velocities of all vertices (n, 3) [m/s]; a copy. Assign them, or one for all, to give others to the
        vertices that are not pinned."""
        found = self._require_simulation("velocities")._core.velocities(self._index)
        return reading(found, self, "velocities", assign=True)

    @velocities.setter
    def velocities(self, value: ArrayLike) -> None:
        simulation, rows = self._require_simulation("velocities"), self._rows(value, "velocities")
        simulation._to_place("velocities").push_vertices(self._index, rows)

    def _rows(self, value: ArrayLike, what: str) -> Floats:
        """(n, 3) for all vertices; a velocity may be one for all."""
        array, count = real_array(value, f"'{self.name}': {what}"), len(self._mesh.vertices)
        if what == "velocities" and array.shape == (3,):
            array = np.tile(array, (count, 1))
        if array.shape != (count, 3):
            raise InvalidArgument(
                f"'{self.name}': {what} has the shape {array.shape}: must be ({count}, 3), a row for each "
                f"vertex of the mesh"
            )
        check_places(array, f"'{self.name}': {what}", "m/s" if what == "velocities" else "m")
        return np.ascontiguousarray(array)

    @property
    def pins(self) -> Indices:
        """Indices of the pinned vertices, in the order of pinning. Those of ``sim[body]`` are what the
        simulation was made with."""
        if self._of is not None:
            return reading(self._of._pins[self._index].copy(), self, "pins")
        return reading(self._scene._core.pins(self._index), self, "pins")

    def pin(self, vertices: ArrayLike) -> None:
        """Prescribes vertices, by index or by a mask: they stay, or follow ``pin_targets``. Simulations have
        the pins that there are when they are made: a StarkWarning says where one is there already. Pins hold
        for good; what is to be let go is attached to a scripted body: ``scene.attach``."""
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
    def pin_targets(self) -> Floats:
        """Positions that the pinned vertices reach at the end of the next step (k, 3) [m], in the order of
        the ``pins`` of the simulation; assign to move them."""
        found = self._require_simulation("pin_targets")._core.pin_targets(self._index)
        return reading(found, self, "pin_targets", assign=True)

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
        refuse_replaced_targets(self, "pin_targets", array, simulation._core.pin_targets(self._index))
        simulation._core.set_pin_targets(self._index, np.ascontiguousarray(array))

    @property
    def pin_forces(self) -> Floats:
        """Forces that hold the pinned vertices in the last step (k, 3) [N], in the order of the ``pins`` of
        the simulation: against all that acts on them, their own weight and inertia included."""
        found = self._require_simulation("pin_forces")._core.pin_forces(self._index)
        return reading(found, self, "pin_forces")

    def follow(
        self,
        targets: Any = None,
        *,
        displacement: Any = None,
        rotation: Any = None,
        center: ArrayLike | None = None,
        vertices: ArrayLike | None = None,
        position: None = None,
    ) -> None:
        """Moves pinned vertices on motions (stark.motion, or functions of the time [s]) from the next step
        on.

        ``targets``: positions (k, 3) [m] of the pins, in their order. Or all together, like a rigid body:
        turned by ``rotation`` about ``center`` [m] (the mean of the pins at time 0 if left out) and moved by
        ``displacement`` [m] from where they are at time 0; clamped nodes of rods turn with them. Both are
        changes since time 0, so no turn is the identity; those of scripted bodies are in the world.
        ``vertices``: only these of the pinned ones, by index or by a mask; others may follow another motion.
        Without arguments nothing is followed any more. Values are those of the end of each step, whatever
        its length; a step that the solver halves goes halfway on the straight line. ``position``, of rigid
        bodies, is refused."""
        refuse_other_motion(self.name, "position", position)
        follow_pins(self, targets, displacement, rotation, center, vertices)
