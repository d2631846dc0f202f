"""What is raised for documents."""

import json
from pathlib import Path

import pytest

import stark
from stark.document import DocumentError


def test_it_is_an_error_of_stark_and_a_value_error() -> None:
    assert stark.DocumentError is DocumentError
    assert issubclass(DocumentError, stark.InvalidArgument) and issubclass(DocumentError, stark.Error)


def test_damaged_names_of_any_length_can_be_read(tmp_path: Path) -> None:
    """The name of a parameter with five thousand digits behind it was told in full."""
    scene = stark.Scene()
    scene.add_solid(stark.mesh.tet_box(0.1, 1), name="block")
    path = scene.save(tmp_path / "scene.json")
    damaged = path.read_text().replace('"poissons_ratio"', json.dumps("poissons_ratio" + "9" * 5000))
    assert damaged != path.read_text()
    path.write_text(damaged)
    with pytest.raises(
        DocumentError, match=r"scene\.json.*unknown parameter 'poissons_ratio9+ \.\.\. 9"
    ) as found:
        stark.load_scene(path)
    assert len(str(found.value)) < 3000
