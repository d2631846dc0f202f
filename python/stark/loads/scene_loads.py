"""The part of ``stark.Scene`` that adds loads."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from stark._core import InvalidArgument
from stark.arguments import real_number
from stark.bodies import Body, RigidBody
from stark.caller import warn
from stark.courses import TimeValue, at_start, set_courses
from stark.handle import SceneLink
from stark.selections import FrameHandle, Points, Stencils

if TYPE_CHECKING:
    from stark.formulas.handle import Energy
    from stark.joined_points import JoinedPoints
    from stark.loads.closed_surface import ClosedSurface

#: Points of a plane of symmetry are no farther apart along its normal, over the size of their body.
_OF_ONE_PLANE = 1e-3


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

        inside, owner = _inside(surface, "pressure", name)
        values = {"pressure": at_start(pressure, owner), "origin": inside.centre}
        if inside.shares is None:
            bound = formulas.pressure(inside.triples, **values)
        else:
            bound = element_faces.pressure(inside.triples, **values, share=inside.shares)
        load = self.add(bound, name=name)
        set_courses("energy", load, {"pressure": pressure})
        return load

    def add_face_pressure(
        self, faces: Body | Stencils, pressure: TimeValue, *, name: str | None = None
    ) -> Energy:
        """Pressure [Pa] that presses on some faces of a cloth or a solid, which need not be closed:
        ``solid.faces[mask[solid.triangles].all(axis=1)]`` with a mask of its vertices. It acts against their
        normals, which point out of solids, at the size and direction that the faces have at the end of the
        step; at their border, where these are their mean over the step. ``handle.pressure`` may change at any
        time; ``handle.energy`` is minus its work in the step [J]."""
        from stark.loads import surface_loads

        owner = "face pressure" if name is None else f"face pressure '{name}'"
        start = at_start(pressure, owner)
        chosen = surface_loads.chosen_faces(faces, owner)
        surface_loads.refuse_turned(faces, owner, chosen)
        triples, shares = surface_loads.pressed_triples(chosen)
        load = self.add(surface_loads.face_pressure(triples, pressure=start, shares=shares), name=name)
        set_courses("energy", load, {"pressure": pressure})
        return load

    def add_traction(
        self,
        faces: Body | Stencils,
        traction: ArrayLike | Callable[[float], ArrayLike],
        *,
        name: str | None = None,
    ) -> Energy:
        """A traction (3,) [Pa] on some faces of a cloth or a solid, as for ``add_face_pressure``: a force per
        area at rest that keeps its direction in the world. ``handle.traction`` may change at any time;
        ``handle.forces`` (n, 1, 3) [N] are those on the nodes, the consistent ones of finite elements."""
        from stark.loads import surface_loads

        owner = "traction" if name is None else f"traction '{name}'"
        start = at_start(traction, owner)
        points, areas = surface_loads.areas_of_nodes(surface_loads.chosen_faces(faces, owner))
        load = self.add(surface_loads.traction(points, traction=start, area=areas), name=name)
        set_courses("energy", load, {"traction": traction})
        return load

    def add_gas(
        self,
        surface: Body | Stencils,
        pressure: float = 0.0,
        *,
        amount: TimeValue = 1.0,
        outside: float = 101325.0,
        exponent: float = 1.0,
        name: str | None = None,
    ) -> Energy:
        """A gas inside a closed surface, whose pressure follows from the volume that the surface has.
        ``surface`` as for add_pressure. ``pressure``: over that ``outside`` at time 0 [Pa]; ``outside`` is
        absolute. With the ``exponent`` 1 the gas keeps its temperature, with the ratio of its heat
        capacities, 1.4 of air, it exchanges no heat. ``handle.amount`` is the gas inside over that at time 0;
        change it at any time, as a pump does. ``handle.volume`` is the volume inside [m^3],
        ``-handle.total_slopes["volume"]`` the pressure over that outside [Pa]. [theory eq. 15i]"""
        from stark.loads import fillings

        inside, owner = _inside(surface, "gas", name)
        given = {"pressure": pressure, "outside": outside, "exponent": exponent}
        for what, value in given.items():
            if callable(value):
                raise InvalidArgument(
                    f"{owner}: {what} = {value!r}: must be a number, that at time 0; amount= may be a "
                    f"function of the time"
                )
            real_number(value, f"{owner}: {what}")
        absolute = outside + pressure
        if not absolute > 0.0:
            raise InvalidArgument(
                f"{owner}: pressure = {pressure} Pa over {outside} Pa outside: together they must be above "
                f"0; pressure is that over the pressure outside"
            )
        if not exponent >= 1.0:
            raise InvalidArgument(
                f"{owner}: exponent = {exponent}: must be at least 1, where the temperature is constant; "
                f"1.4 for air that exchanges no heat"
            )
        formula = fillings.gas if exponent == 1.0 else fillings.adiabatic_gas
        values = {
            "pressure_at_start": absolute,
            "volume_at_start": inside.volume,
            "outside": outside,
            **({} if exponent == 1.0 else {"exponent": exponent}),
        }
        return self._fill(formula, inside, owner, name, {"amount": amount}, values)

    def add_liquid(
        self,
        surface: Body | Stencils,
        filling: TimeValue | None = None,
        *,
        bulk_modulus: float = 2.2e9,
        outside: float = 101325.0,
        name: str | None = None,
    ) -> Energy:
        """A liquid inside a closed surface. ``surface`` as for add_pressure. ``filling``: how much there is
        of it, the volume [m^3] that it has at the pressure ``outside`` [Pa]; by default that inside at time
        0. Change ``handle.filling`` at any time, as a pump does. ``bulk_modulus`` [Pa]: that of water by
        default. ``handle.volume`` is the volume inside, ``-handle.total_slopes["volume"]`` the pressure over
        that outside [Pa]; at an absolute pressure of zero the liquid parts. It has neither mass nor weight:
        give these to the body around it. [theory eq. 15j]"""
        from stark.loads import fillings

        inside, owner = _inside(surface, "liquid", name)
        if filling is None:
            filling = inside.volume
        values = {"bulk_modulus": bulk_modulus, "outside": outside}
        return self._fill(fillings.liquid, inside, owner, name, {"filling": filling}, values)

    def _fill(
        self,
        formula: Any,
        inside: ClosedSurface,
        owner: str,
        name: str | None,
        live: dict[str, TimeValue],
        values: dict[str, float],
    ) -> Energy:
        """A filling of a surface, with values that may follow the time and others."""
        share = 1.0 if inside.shares is None else inside.shares
        starts = {key: at_start(value, owner) for key, value in live.items()}
        load = self.add(
            formula(inside.triples, origin=inside.centre, share=share, **starts, **values), name=name
        )
        set_courses("energy", load, live)
        return load

    def add_force(
        self,
        points: RigidBody | Points | JoinedPoints,
        force: ArrayLike | Callable[[float], ArrayLike],
        *,
        name: str | None = None,
    ) -> Energy:
        """A force [N] that keeps its direction, on each of some points, ``cloth.vertices[[0, 5]]``,
        ``box.points((0, 0, 0.1))`` or ``rod.points(-1, (0.01, 0, 0))``, or on the centre of mass of a rigid
        body. (3,) for all points, (n, 3) for each its own. ``handle.force`` may change at any time."""
        from stark.joined_points import JoinedPoints
        from stark.loads import formulas

        if isinstance(points, RigidBody):
            points = points.points(points.center_of_mass)
        if not isinstance(points, Points | JoinedPoints):
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
        ``handle.torque`` may change at any time. It is exact where the body turns about it, by up to 1 rad in
        a step; of a turn about another axis it lags behind by half. For quasistatic steps on soft bodies see
        docs/integrators.md."""
        from stark.loads import formulas

        load = self.add(formulas.torque(body, torque=at_start(torque, "torque")), name=name)
        set_courses("energy", load, {"torque": torque})
        return load

    def add_rollers(
        self,
        points: Points,
        normal: str | ArrayLike,
        *,
        shift: TimeValue = 0.0,
        stiffness: float | None = None,
        name: str | None = None,
    ) -> Energy:
        """Roller supports: points of a body, ``solid.vertices[mask]``, stay in the plane across ``normal``,
        "x", "y", "z" or (3,), in which each is at time 0, and move freely in it: a plane of symmetry, a press
        without friction. Planes of symmetry of sheets that bend want ``add_symmetry``. ``handle.shift`` [m]
        moves the planes along the normal at any time; ``handle.forces`` (n, 1, 3) [N] are the reactions on
        the points. ``stiffness`` [N/m] of each support: by default a thousand times that of a cell of the
        cloth, the solid or the rod, by its law."""
        from stark.loads import rollers

        owner = "rollers" if name is None else f"rollers '{name}'"
        points = rollers.check_points(points, owner)
        across = rollers.unit_normal(normal, owner)
        values = {
            "place": points.positions,
            "normal": across,
            "stiffness": rollers.stiffness_of(points, across, owner) if stiffness is None else stiffness,
        }
        load = self.add(rollers.rollers(points, shift=at_start(shift, owner), **values), name=name)
        set_courses("energy", load, {"shift": shift})
        return load

    def add_symmetry(
        self,
        points: Points,
        normal: str | ArrayLike,
        *,
        stiffness: float | None = None,
        name: str | None = None,
    ) -> Energy:
        """A plane of symmetry, across ``normal``, "x", "y", "z" or (3,), beyond which the other half of a
        cloth, a solid or a rod is left out. ``add_rollers`` for the points that lie in it, of which the
        handle is returned; of cloths and skins that bend and of rods also the slopes at it, which rollers
        leave free: the energy that is called as the handle, with "slopes". Of a load on a node in the plane
        give half."""
        from stark.loads import rollers

        owner = "symmetry" if name is None else f"symmetry '{name}'"
        direction = rollers.unit_normal(normal, owner)
        depth, size = rollers.depth_of(rollers.check_points(points, owner), direction)
        if depth > _OF_ONE_PLANE * size:
            warn(
                f"{owner}: its points are {depth:.3g} m apart along the normal: must lie in one plane of "
                f"symmetry; choose those of the cut, or take scene.add_rollers for several planes"
            )
        for fibres in rollers.hinged_fibres(points):
            warn(
                f"{owner}: nothing holds the slopes of the fibres '{fibres}' at the plane, where they have "
                f"hinges: must not bend there; simulate the whole body, or give bending=False"
            )
        load = self.add_rollers(points, normal, stiffness=stiffness, name=name)
        held = rollers.slopes_at(points, direction)
        if held is not None:
            triangles, start, turning = held
            bound = rollers.slopes(triangles, start=start, normal=direction, stiffness=turning)
            self.add(bound, name=f"{load.name} slopes")
        turned = rollers.directions_at(points, direction)
        if turned is not None:
            nodes, tips, reach, twisting = turned
            held_nodes = rollers.directions(nodes, tips, reach=reach, normal=direction, stiffness=twisting)
            self.add(held_nodes, name=f"{load.name} slopes")
        return load


def _inside(surface: Any, what: str, name: str | None) -> tuple[ClosedSurface, str]:
    """The closed surface that is meant, and the name of the load in messages."""
    from stark.loads.closed_surface import closed_surface

    owner = what if name is None else f"{what} '{name}'"
    return closed_surface(surface, owner), owner
