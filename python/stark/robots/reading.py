"""``stark.robots.read``: the reader of a file by what is in it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree import ElementTree

from stark._core import InvalidArgument
from stark.arguments import given_path
from stark.robots.description import RobotDescription
from stark.robots.xml import not_xml, parsed


def read(
    path: str | os.PathLike[str], *, packages: Mapping[str, str | os.PathLike[str]] | None = None
) -> RobotDescription:
    """Reads a robot from a URDF file (``<robot>``, with yourdfpy), an MJCF file (``<mujoco>``, with mujoco,
    both by ``pip install 'stark-sim[robots]'``) or a USD file (UsdPhysics, with usd-core, by
    ``pip install 'stark-sim[usd]'``). ``packages``: folders of ``package://`` names in URDF files; those not
    given are looked for beside the file and in the folders above it.

    Raises InvalidArgument with file, part, value, rule and remedy for what cannot be a robot, ImportError
    where the package is missing."""
    file = given_path(path, "robot: path")
    if file.suffix.lower() in (".usd", ".usda", ".usdc", ".usdz"):
        from stark.robots.usd import read_usd

        return read_usd(file)
    root = _root_of(file)
    if root == "robot":
        from stark.robots.urdf import read_urdf

        return read_urdf(file, _folders(packages))
    if root == "mujoco":
        from stark.robots.mjcf import read_mjcf

        return read_mjcf(file)
    raise InvalidArgument(
        f"'{file}': begins with <{root}>: must be a URDF file (<robot>), an MJCF file (<mujoco>) "
        f"or a USD file (.usd); convert it"
    )


def read_exclusions(path: str | os.PathLike[str], links: Iterable[str]) -> tuple[tuple[str, str], ...]:
    """Pairs of links that do not touch, of an SRDF file (``<disable_collisions link1= link2=>``). Pairs of
    links that the robot does not have are passed over: such files are of several robots. InvalidArgument as
    in ``read``."""
    file = given_path(path, "robot: exclude")
    if _root_of(file) != "robot":
        raise InvalidArgument(f"'{file}': must be an SRDF file, or give pairs of links")
    known, pairs = set(links), []
    for element in parsed(file).iter("disable_collisions"):
        pair = element.get("link1", ""), element.get("link2", "")
        if not all(pair):
            raise InvalidArgument(f"'{file}': <disable_collisions>: link1 and link2 must be given; add them")
        if known.issuperset(pair):
            pairs.append(pair)
    return tuple(pairs)


def _folders(packages: Mapping[str, str | os.PathLike[str]] | None) -> dict[str, Path]:
    if packages is not None and not isinstance(packages, Mapping):
        raise InvalidArgument(f"robot: packages = {packages!r}: must be folders by name, {{'name': folder}}")
    return {name: given_path(path, f"robot: packages['{name}']") for name, path in (packages or {}).items()}


def _root_of(file: Path) -> str:
    try:
        with file.open("rb") as stream:
            for _, element in ElementTree.iterparse(stream, events=("start",)):
                return str(element.tag)
    except OSError as error:
        raise InvalidArgument(
            f"'{file}': {error.strerror or error}: must be a URDF, MJCF or USD file; check the path"
        ) from None
    except ElementTree.ParseError as error:
        raise not_xml(file, error) from None
    raise InvalidArgument(f"'{file}': is empty: must be a URDF or MJCF file")
