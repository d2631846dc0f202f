"""Files of robots in installed packages."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

#: Packages by their folder, and the folders in them that hold robots.
PACKAGES: dict[str, tuple[str, ...]] = {
    "robosuite": ("models/assets/robots", "models/assets/grippers"),
    "gymnasium_robotics": ("envs",),
    "dm_control": ("suite", "third_party", "locomotion/walkers/assets"),
    "pybullet_data": ("",),
    "metaworld": ("assets/sawyer_xyz",),
}
#: Objects and parts of other files, no robots.
_PASSED_OVER = ("random_urdfs", "build_fruitfly")


def robot_files(packages: list[str]) -> Iterator[tuple[str, Path, Path]]:
    """Package, folder and file of each robot, in order: files with a joint that moves."""
    for package in packages or ["example-robot-data", *PACKAGES]:
        for root in _roots(package):
            for file in sorted((*root.rglob("*.urdf"), *root.rglob("*.xml"))):
                if not set(_PASSED_OVER) & set(file.parts) and _has_joints(file):
                    yield package, root, file


def _roots(package: str) -> list[Path]:
    if package == "example-robot-data":
        folders = [
            Path(entry).parents[2] / "share/example-robot-data/robots"
            for entry in sys.path
            if len(Path(entry).parents) > 2
        ]
        return [folder for folder in folders[:] if folder.is_dir()][:1]
    spec = importlib.util.find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        return []
    root = Path(next(iter(spec.submodule_search_locations)))
    return [root / folder for folder in PACKAGES[package] if (root / folder).is_dir()]


def _has_joints(file: Path) -> bool:
    try:
        tree = ElementTree.parse(file).getroot()
    except ElementTree.ParseError:
        return False
    if tree.tag == "robot":
        return any(joint.get("type") not in (None, "fixed") for joint in tree.iter("joint"))
    # Included parts of others have no world of their own.
    return (
        tree.tag == "mujoco"
        and tree.find("worldbody") is not None
        and tree.find(".//worldbody//body") is not None
    )
