"""The part of ``stark.Scene`` that adds robots."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from stark._core import InvalidArgument
from stark.arguments import given_choice, given_flag, given_name
from stark.caller import warn
from stark.handle import SceneLink
from stark.named import NamedTuple
from stark.rotations import Vec3Like, as_matrix, vector

if TYPE_CHECKING:
    from stark.robots.description import Inertia, RobotDescription
    from stark.robots.handle import Robot


class SceneRobots(SceneLink):
    """What ``stark.Scene`` knows about robots."""

    _robots: list[Robot]
    _bodies: list[Any]
    _joints: list[Any]
    _ghosts: list[Any]
    _attachments: list[Any]

    def add_robot(
        self,
        robot: str | os.PathLike[str] | RobotDescription,
        *,
        name: str | None = None,
        base: str | None = None,
        position: Vec3Like = (0.0, 0.0, 0.0),
        rotation: ArrayLike | None = None,
        q: ArrayLike | Mapping[str, float] | None = None,
        contact: bool = True,
        self_contact: bool = True,
        exclude: Iterable[tuple[str, str]] | str | os.PathLike[str] = (),
        shapes: str = "collision",
        shown: str | None = None,
        merge_fixed: bool = True,
        inertias: Mapping[str, tuple[float, Vec3Like, ArrayLike]] | None = None,
        packages: Mapping[str, str | os.PathLike[str]] | None = None,
        contact_distance: float | None = None,
        friction: float | None = None,
        color: Vec3Like | None = None,
    ) -> Robot:
        """Adds a robot: a URDF, MJCF or USD file, or a ``stark.robots.RobotDescription`` (docs/robots.md).

        ``base`` is "fixed", "floating" or "scripted" (moved as scripted bodies are), what the file says
        if left out; ``position`` [m] and ``rotation`` place it. ``q``: where joints start, (n,) [rad, m]
        or numbers by joint; others where the file draws them, 0 or ``ref`` of MJCF, or at the limit next
        to it. Links touch by their collision shapes, or those that ``shapes`` names ("visual"); with
        ``contact=False`` they touch nothing. Pictures show what touches, with ``contact=False`` the
        visual shapes, or what ``shown`` names. Links that a joint connects do not touch each other, nor
        the pairs of ``exclude`` (or an SRDF file), nor any with ``self_contact=False``. Links that are
        fixed to each other are one body, or with ``merge_fixed=False`` joined by fixed joints where both
        have mass. ``inertias``: (mass [kg], centre of mass (3,) [m], tensor about it (3, 3) [kg m^2]) by
        link, instead of those of the file. ``packages``: folders of ``package://`` names.
        ``contact_distance`` [m], ``friction`` and ``color`` as in ``add_rigid``.

        ``print(robot.report)`` says what became of the file. Raises InvalidArgument with the file, part,
        rule and remedy, and leaves the scene as it was; ImportError where a reader is missing."""
        from stark.robots.building import BASES, Options, build
        from stark.robots.description import RobotDescription
        from stark.robots.kinematics import Placement
        from stark.robots.reading import read

        if isinstance(robot, RobotDescription):
            description = _as_it_is(robot)
        else:
            description = read(robot, packages=packages)
        title = self._robot_name(given_name(name) or description.name, chosen=name is not None)
        owner = f"robot '{title}'"
        base = description.base if base is None else given_choice(base, BASES, f"{owner}: base")
        body = {"contact_distance": contact_distance, "friction": friction, "color": color}
        options = Options(
            title,
            base,
            Placement(vector(position, f"{owner}: position"), as_matrix(rotation, f"{owner}: rotation")).at(
                *description.placement
            ),
            q,
            given_flag(contact, f"{owner}: contact"),
            given_flag(self_contact, f"{owner}: self_contact"),
            _exclusions(description, owner, exclude),
            given_choice(shapes, ("collision", "visual"), f"{owner}: shapes"),
            None if shown is None else given_choice(shown, ("collision", "visual"), f"{owner}: shown"),
            given_flag(merge_fixed, f"{owner}: merge_fixed"),
            _inertias(description, owner, {} if inertias is None else inertias),
            {key: value for key, value in body.items() if value is not None},
        )
        with self._whole_or_not(), self._adding_a_whole():
            built = build(self, description, options)
            self._robots.append(built)
        self._warn_of_late(owner)
        for finding in built.report.warnings:
            warn(f"{built.report.source}: {finding}")
        return built

    @property
    def robots(self) -> NamedTuple[Robot]:
        """Robots in the order of adding."""
        return NamedTuple("robot", self._robots, self)

    def _robot_name(self, name: str, *, chosen: bool) -> str:
        taken = {robot.name for robot in self._robots}
        if name not in taken:
            return name
        if chosen:
            raise InvalidArgument(f"robot '{name}': there is one of this name: must be unique; give another")
        return next(f"{name}_{k}" for k in range(2, len(taken) + 3) if f"{name}_{k}" not in taken)

    @contextlib.contextmanager
    def _whole_or_not(self) -> Iterator[None]:
        """A robot of which a part is refused is not there at all."""
        parts = (self._bodies, self._joints, self._actuators, self._ghosts, self._attachments)
        before, counts = self._core.snapshot(), [len(part) for part in parts]
        try:
            yield
        except BaseException:
            self._core.restore(before)
            for part, count in zip(parts, counts, strict=True):
                del part[count:]
            raise


def _as_it_is(description: RobotDescription) -> RobotDescription:
    """With the links and joints that are in its dictionaries now: parts may have been removed or replaced."""
    return type(description)(
        description.name,
        description.links.values(),
        description.joints.values(),
        excluded=[pair for pair in description.excluded if set(pair) <= set(description.links)],
        base=description.base,
        placement=description.placement,
        report=description.report,
        flexes=description.flexes.values(),
        closures=description.closures.values(),
    )


def _exclusions(description: RobotDescription, owner: str, given: Any) -> tuple[tuple[str, str], ...]:
    from stark.robots.reading import read_exclusions

    if isinstance(given, (str, os.PathLike)):
        return read_exclusions(given, description.links)
    try:
        return tuple((str(a), str(b)) for a, b in given)
    except (TypeError, ValueError, OverflowError):
        raise InvalidArgument(
            f"{owner}: exclude = {given!r}: must be pairs of links, as [('wrist', 'base')], or an SRDF file"
        ) from None


def _inertias(
    description: RobotDescription, owner: str, given: Mapping[str, tuple[float, Vec3Like, ArrayLike]]
) -> dict[str, Inertia]:
    import numpy as np

    from stark.arguments import real_array, real_number
    from stark.robots.checks import refuse_impossible
    from stark.robots.description import Inertia

    if not isinstance(given, Mapping):
        raise InvalidArgument(
            f"{owner}: inertias = {given!r}: must be (mass, centre of mass, 3x3 tensor) by link"
        )
    found = {}
    for link, value in given.items():
        title = f"{owner}: inertias['{link}']"
        if link not in description.links:
            raise InvalidArgument(f"{title}: must be one of {', '.join(description.links)}")
        if not isinstance(value, (tuple, list)) or len(value) != 3:
            raise InvalidArgument(f"{title} = {value!r}: must be (mass, centre of mass, 3x3 tensor)")
        tensor = real_array(value[2], f"{title}: tensor")
        if tensor.shape != (3, 3) or not np.allclose(
            tensor, tensor.T, rtol=0.0, atol=1e-9 * np.abs(tensor).max()
        ):
            raise InvalidArgument(f"{title}: tensor = {value[2]!r}: must be a symmetric 3x3 matrix")
        found[link] = Inertia(
            real_number(value[0], f"{title}: mass"), vector(value[1], f"{title}: centre"), tensor
        )
        refuse_impossible(title, [link], found[link])
    return found
