"""The part of ``stark.Scene`` that adds loads."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from stark._core import InvalidArgument
from stark.bodies import Body, RigidBody
from stark.courses import TimeValue, at_start, set_courses
from stark.handle import SceneLink
from stark.selections import FrameHandle, Points, Stencils

if TYPE_CHECKING:
    from stark.formulas.handle import Energy


class SceneLoads(SceneLink):
    """Loads are energies: what is returned is the handle of one, whose value holds from the next step on when
    it is changed. Values may be functions of the time [s]: each step takes that of its end."""

    def add(self, energy: Any, *, name: str | None = None) -> Energy:
        raise NotImplementedError  # of Scene

    def add_pressure(
        self, surface: Body | Stencils, pressure: TimeValue, *, name: str | None = None
    ) -> Energy:
        """Pressure [Pa] inside a closed surface over that outside. ``surface`` is a cloth or a solid, or some
        of its faces, such as those of a cavity; at time 0 the inside has a positive volume, however the
        triangles are oriented. ``handle.pressure`` may change at any time, ``handle.energy`` is minus
        pressure times volume [J]. Surfaces that are not closed raise InvalidArgument."""
        from stark.loads import element_faces, formulas
        from stark.loads.closed_surface import closed_surface

        owner = "pressure" if name is None else f"pressure '{name}'"
        inside = closed_surface(surface, owner)
        values = {"pressure": at_start(pressure, owner), "origin": inside.centre}
        if inside.shares is None:
            bound = formulas.pressure(inside.triples, **values)
        else:
            bound = element_faces.pressure(inside.triples, **values, share=inside.shares)
        load = self.add(bound, name=name)
        set_courses("energy", load, {"pressure": pressure})
        return load

    def add_force(
        self,
        points: RigidBody | Points,
        force: ArrayLike | Callable[[float], ArrayLike],
        *,
        name: str | None = None,
    ) -> Energy:
        """A force [N] that keeps its direction, on each of some points, ``cloth.vertices[[0, 5]]`` or
        ``box.points((0, 0, 0.1))``, or on the centre of mass of a rigid body. (3,) for all points, (n, 3) for
        each its own. ``handle.force`` may change at any time."""
        from stark.loads import formulas

        if isinstance(points, RigidBody):
            points = points.points(points.center_of_mass)
        if not isinstance(points, Points):
            raise InvalidArgument(
                f"force on {points!r}: must be a rigid body, or points such as cloth.vertices[[0, 5]]"
            )
        load = self.add(formulas.force(points, force=at_start(force, "force")), name=name)
        set_courses("energy", load, {"force": force})
        return load

    def add_torque(
        self,
        body: RigidBody | FrameHandle,
        torque: ArrayLike | Callable[[float], ArrayLike],
        *,
        name: str | None = None,
    ) -> Energy:
        """A torque (3,) [N m] that keeps its direction in the world, on a rigid body or a frame.
        ``handle.torque`` may change at any time."""
        from stark.loads import formulas

        load = self.add(formulas.torque(body, torque=at_start(torque, "torque")), name=name)
        set_courses("energy", load, {"torque": torque})
        return load
