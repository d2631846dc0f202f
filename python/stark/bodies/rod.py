"""Handles of rods: nodes with material frames, drawn as tubes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import as_array, real_array
from stark.bodies.deformable import DeformableBody
from stark.bodies.following import refuse_replaced_targets
from stark.materials import RodMaterial
from stark.mesh import Indices, Polyline
from stark.readings import reading
from stark.selections import FrameHandle, node_frame, node_points, rows_of
from stark.tubes import outline, tube

if TYPE_CHECKING:
    from stark.joined_points import JoinedPoints

Floats = NDArray[np.float64]


class Rod(DeformableBody):
    """A thin elastic rod: a chain of nodes, each with a material frame."""

    kind = "rod"
    _mesh_arrays = ("vertices",)

    @classmethod
    def _mesh_of(cls, given: Mapping[str, Any]) -> Polyline:
        return Polyline(given["vertices"])

    def frame(  # type: ignore[override]
        self, node: int, *, position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike | None = None
    ) -> FrameHandle:
        """Frame carried by a node, for energies and joints: ``position`` [m] and ``rotation`` in the frame of
        the node, whose axes are d1 and d2 of the section and d3 along the rod."""
        return node_frame(self, node, position, rotation)

    def points(self, nodes: ArrayLike | slice, local: ArrayLike = (0.0, 0.0, 0.0)) -> JoinedPoints:
        """Points carried by the frames of nodes, for energies: eyelets beside the rod. ``nodes``: indices, a
        slice or a mask; ``local`` (3,), or (n, 3) for n nodes, in the frames of the nodes [m], whose axes are
        d1 and d2 of the section and d3 along the rod."""
        from stark.joined_points import JoinedPoints

        owner = f"'{self.name}': points"
        count = len(self.mesh.vertices)
        chosen = np.atleast_1d(np.arange(count)[rows_of(nodes, count, owner)])
        places = real_array(local, f"{owner}: local")
        if places.shape not in ((3,), (len(chosen), 3)):
            raise InvalidArgument(
                f"{owner}: local of shape {places.shape} for {len(chosen)} nodes: must be (3,) or "
                f"({len(chosen)}, 3) [m]"
            )
        rows = np.broadcast_to(places, (len(chosen), 3))
        return JoinedPoints(
            [node_points(self, int(node), row[None].copy()) for node, row in zip(chosen, rows, strict=True)]
        )

    @property
    def material(self) -> RodMaterial:
        """What it is made of, as it was added; it stays so."""
        material: RodMaterial = self._shared["material"]
        return material

    @property
    def frames(self) -> Floats:
        """Material frames of the nodes (n, 3, 3): axes d1, d2 of the section and d3 along the rod as columns;
        a copy."""
        simulation = self._simulation()
        if simulation is None:
            found = self._scene._core.initial_frames(self._index)
        else:
            found = simulation._core.frames(self._index)
        return reading(found.reshape(-1, 3, 3), self, "frames")

    @property
    def clamped(self) -> Indices:
        """Indices of the clamped nodes, in the order of clamping. Those of ``sim[rod]`` are what the
        simulation was made with."""
        if self._of is not None:
            return reading(self._of._clamped[self._index].copy(), self, "clamped")
        return reading(self._scene._core.clamped(self._index), self, "clamped")

    def clamp(self, nodes: ArrayLike) -> None:
        """Prescribes positions and frames of nodes, by index: they stay, or follow ``pin_targets`` and
        ``clamp_targets``. Simulations have the clamps that there are when they are made, as with pins."""
        self._require_of_scene("clamp")
        self._scene._core.clamp(self._index, np.atleast_1d(as_array(nodes, f"'{self.name}': clamp")))
        self._scene._warn_of_simulation(self, "clamp")

    @property
    def clamp_targets(self) -> Floats:
        """Frames that the clamped nodes reach at the end of the next step (k, 3, 3), in the order of
        ``clamped``; assign to turn them."""
        simulation = self._require_simulation("clamp_targets")
        found = simulation._core.clamp_targets(self._index).reshape(-1, 3, 3)
        return reading(found, self, "clamp_targets", assign=True)

    @clamp_targets.setter
    def clamp_targets(self, targets: ArrayLike) -> None:
        array = real_array(targets, f"'{self.name}': clamp_targets")
        simulation = self._require_simulation("clamp_targets")
        count = len(simulation._clamped[self._index])
        if array.shape != (count, 3, 3):
            raise InvalidArgument(
                f"'{self.name}': clamp_targets has the shape {array.shape}: "
                f"must be ({count}, 3, 3), a rotation for each node that was clamped when the simulation was "
                f"made"
            )
        present = simulation._core.clamp_targets(self._index).reshape(-1, 3, 3)
        refuse_replaced_targets(self, "clamp_targets", array, present)
        simulation._core.set_clamp_targets(self._index, np.ascontiguousarray(array.reshape(count, 9)))

    @property
    def clamp_torques(self) -> Floats:
        """Torques that hold the frames of the clamped nodes in the last step (k, 3) [N m], world axes, in the
        order of ``clamped``; ``pin_forces`` are the forces there."""
        found = self._require_simulation("clamp_torques")._core.clamp_torques(self._index)
        return reading(found, self, "clamp_torques")

    # --- what it transmits ---

    @property
    def section_forces(self) -> Floats:
        """Force through the middle of each segment in the last step (n - 1, 3) [N], world axes: of the side
        behind it, towards the last node, on the side before. Damping and active forces are in it."""
        found = self._require_simulation("section_forces")._core.section_wrenches(self._index)[:, :3]
        return reading(found, self, "section_forces")

    @property
    def section_moments(self) -> Floats:
        """Bending moment and torque through the middle of each segment in the last step (n - 1, 3) [N m],
        world axes, of the side behind it on the side before."""
        found = self._require_simulation("section_moments")._core.section_wrenches(self._index)[:, 3:]
        return reading(found, self, "section_moments")

    @property
    def tensions(self) -> Floats:
        """Part of ``section_forces`` along each segment (n - 1,) [N], positive where it is pulled."""
        along = np.diff(self.positions, axis=0)
        along /= np.linalg.norm(along, axis=1)[:, None]
        return reading((self.section_forces * along).sum(axis=1), self, "tensions")

    # --- rest state ---

    @property
    def natural_curvature(self) -> Floats:
        """Curvature of each segment without load about d1 and d2 (n, 2) [1/m], beside that of the rest shape.
        Assign it as ``growth``."""
        return self._rest_value("natural_curvature")

    @natural_curvature.setter
    def natural_curvature(self, value: Any) -> None:
        self._set_rest_value("natural_curvature", value)

    @property
    def natural_twist(self) -> Floats:
        """Twist of each segment without load (n,) [rad/m], beside that of the rest shape. Assign it as
        ``growth``."""
        return self._rest_value("natural_twist")

    @natural_twist.setter
    def natural_twist(self, value: Any) -> None:
        self._set_rest_value("natural_twist", value)

    @property
    def active_force(self) -> Floats:
        """Force of a muscle or a tendon along each segment (n,) [N], positive where it pulls, whatever the
        length of the segment. Assign it as ``growth``."""
        return self._rest_value("active_force")

    @active_force.setter
    def active_force(self, value: Any) -> None:
        self._set_rest_value("active_force", value)

    def _rest_shapes(self, name: str) -> tuple[tuple[int, ...], ...]:
        return ((2,),) if name == "natural_curvature" else ((),)

    def _element_count(self) -> int:
        return len(self._mesh.vertices) - 1

    @property
    def triangles(self) -> Indices:
        """None: rods touch with edges and nodes. ``surface_triangles`` are those of a tube for pictures."""
        return np.empty((0, 3), dtype=np.int32)

    @property
    def surface_positions(self) -> Floats:
        """Vertices of a tube around the rod (k, 3) [m], for pictures: the section at each node, and the
        middles of both ends."""
        positions, frames = self.positions, self.frames
        section = outline(self._shared["material"])
        rings = positions[:, None] + np.einsum("nij,kj->nki", frames[:, :, :2], section)
        return np.concatenate([rings.reshape(-1, 3), positions[[0, -1]]])

    @property
    def surface_triangles(self) -> Indices:
        """Triangles of a tube around the rod (m, 3), as indices of ``surface_positions``; for pictures."""
        if "tube" not in self._shared:
            self._shared["tube"] = tube(len(self._mesh.vertices), len(outline(self._shared["material"])))
        triangles: Indices = self._shared["tube"]
        return triangles

    def _edge_indices(self) -> Indices:
        assert isinstance(self._mesh, Polyline)
        return self._mesh.edges
