"""Inertias and shapes of a robot file that cannot be, and those that are hardly meant."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable

import numpy as np

from stark._core import InvalidArgument
from stark.robots.description import Geometry, Inertia, Link
from stark.robots.report import Report

#: Radii of gyration beyond these [m] are suspicious in a robot.
SMALLEST_RADIUS, LARGEST_RADIUS = 1e-4, 2.0
#: How much farther than its largest radius of gyration a link may reach from its centre of mass; 1.7 times of
#: a thin rod, 1 of a thin ring, up to 60 and down to 1/30 where files of real robots guess inertias.
LARGEST_REACH = 100.0


def check_inertias(links: Iterable[Link], report: Report) -> None:
    """Reports links without mass, repeated and unlikely inertias. Those that cannot be are refused where
    the body of the link is made, unless another one is given there."""
    same: dict[tuple[float, ...], list[str]] = defaultdict(list)
    for link in links:
        title = f"link '{link.name}'"
        if link.between is not None:
            continue
        if link.inertia is None or is_nothing(link.inertia):
            report.add("assumed", title, "no inertia: has no mass, must be fixed to a link that has")
            continue
        moments = np.linalg.eigvalsh(link.inertia.tensor)
        same[(round(float(moments[0]), 12), round(float(moments[-1]), 12))].append(link.name)
        if link.inertia.mass > 0.0 and moments[0] > 0.0:
            radius = np.sqrt(moments / link.inertia.mass)
            if radius[-1] > LARGEST_RADIUS or radius[0] < SMALLEST_RADIUS:
                report.add(
                    "suspicious",
                    title,
                    f"mass {link.inertia.mass:g} kg with moments {_moments(moments)} kg m^2: radii of "
                    f"gyration from {radius[0]:.2g} to {radius[-1]:.2g} m",
                )
        if (problem := impossible(link.inertia)) is not None:
            report.add("suspicious", title, problem)
    for (least, largest), names in same.items():
        # Legs and wheels are alike, too; a placeholder is that of a ball, or all there is.
        if len(names) > 2 and (least == largest or 2 * len(names) > sum(map(len, same.values()))):
            report.add("suspicious", "links", f"{', '.join(names)} have the same inertia: a placeholder?")


def shapes_of(link: Link, which: str) -> tuple[Geometry, ...]:
    """Those of a kind, "visual" or "collision"."""
    return link.visuals if which == "visual" else link.collisions


def check_touching(links: Collection[Link], shapes: str, base: str, report: Report) -> None:
    """Warns of a robot that should touch things and has nothing to touch them with: it falls through floors.
    One of joints and inertias alone, which nobody sees on its fixed base, is meant so."""
    is_meant = base != "floating" and not any(link.visuals for link in links)
    if is_meant or any(shapes_of(link, shapes) for link in links):
        return
    other = "visual" if shapes == "collision" else "collision"
    remedy = (
        f"give shapes='{other}'" if any(shapes_of(link, other) for link in links) else "add some to the file"
    )
    report.add(
        "suspicious",
        "robot",
        f"no link has a {shapes} shape: it touches nothing; {remedy}, or contact=False if that is meant",
        warn=True,
    )


def check_reach(link: str, vertices: np.ndarray, inertia: Inertia, report: Report) -> None:
    """Reports shapes that hardly belong to the inertia of their link: most often a mesh in millimetres that
    is read in metres. ``vertices`` (n, 3) [m] of all shapes, in the frame of the inertia."""
    largest = float(np.linalg.eigvalsh(inertia.tensor)[-1])
    if not (inertia.mass > 0.0 and largest > 0.0 and len(vertices)):
        return
    radius = np.sqrt(largest / inertia.mass)
    reach = float(np.linalg.norm(vertices - inertia.center, axis=1).max())
    if not radius / LARGEST_REACH <= reach <= radius * LARGEST_REACH:
        report.add(
            "suspicious",
            f"link '{link}'",
            f"its meshes reach {reach:.3g} m from its centre of mass, but its mass and moments have a radius "
            f"of gyration of {radius:.3g} m: give the mesh the scale that makes it metres, or correct the "
            f"inertia",
            warn=True,
        )


def is_nothing(inertia: Inertia) -> bool:
    """Whether an inertia has neither mass nor moments, as files give it to frames."""
    return inertia.mass == 0.0 and not inertia.tensor.any()


def impossible(inertia: Inertia) -> str | None:
    """What is wrong with an inertia that no body can have; None for others."""
    if not inertia.mass > 0.0 or not np.isfinite(inertia.mass):
        return f"mass = {inertia.mass:g} kg: must be > 0"
    moments = np.linalg.eigvalsh(inertia.tensor)
    if not moments[0] > 0.0:
        return f"principal moments {_moments(moments)} kg m^2: must be positive"
    if moments[2] > (moments[0] + moments[1]) * (1.0 + 1e-9):
        return (
            f"principal moments {_moments(moments)} kg m^2: none may exceed the sum of the other two (the "
            f"triangle inequality)"
        )
    return None


def refuse_impossible(source: str, names: Iterable[str], inertia: Inertia) -> None:
    """Raises InvalidArgument for an inertia of links that no body can have."""
    if (problem := impossible(inertia)) is not None:
        links = ", ".join(f"'{name}'" for name in names)
        raise InvalidArgument(
            f"{source}: link {links}: {problem}; correct the file, or give "
            f"inertias={{link: (mass, centre of mass, tensor about it)}}"
        )


def _moments(moments: np.ndarray) -> str:
    return f"({', '.join(f'{moment:.4g}' for moment in moments)})"
