"""The reader of a robot file is found by what is in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from robots._robots import ARM

import stark.robots


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<sdf version='1'/>", "begins with <sdf>: must be a URDF file .* an MJCF file .* or a USD file"),
        ("", "must be XML"),
        ("robot: {}", "must be XML; xacro files have to be expanded first"),
    ],
)
def test_other_files_are_refused(text: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "robot.xml"
    file.write_text(text)
    with pytest.raises(stark.InvalidArgument, match=message):
        stark.robots.read(file)


def test_files_that_are_not_there_are_named(tmp_path: Path) -> None:
    for file in (tmp_path / "no.urdf", tmp_path):
        with pytest.raises(
            stark.InvalidArgument, match=f"'{file}': .* must be a URDF, MJCF or USD file; check the path"
        ):
            stark.robots.read(file)
    with pytest.raises(stark.InvalidArgument, match="robot: path = 3: must be a path"):
        stark.robots.read(3)  # type: ignore[arg-type]


def test_folders_of_packages_are_paths_by_name() -> None:
    pytest.importorskip("yourdfpy")
    for packages, message in [
        ("meshes", r"robot: packages = 'meshes': must be folders by name, \{'name': folder\}"),
        ({"meshes": 3}, r"robot: packages\['meshes'\] = 3: must be a path"),
    ]:
        with pytest.raises(stark.InvalidArgument, match=message):
            stark.robots.read(ARM, packages=packages)  # type: ignore[arg-type]
