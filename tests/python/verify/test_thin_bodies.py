"""Rods and open sheets have no inside: what is certified of them is their distance and their paths."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from _recorded_runs import edit_states, record

import stark
from stark.verify import verify

_RADIUS = stark.materials.rubber_cord.radius
_LOWER, _UPPER, _SHEET, _CORD = range(4)
_LEAST = 1e-3  # contact.min_separation_factor


def thin() -> stark.Scene:
    """A cord that falls across another one, held at both ends; a cord that falls on a sheet held around."""
    scene = stark.Scene("thin")
    for k, (way, height) in enumerate((((0.1, 0.0, 0.0), 0.0), ((0.0, 0.1, 0.0), 2.5 * _RADIUS))):
        mesh = stark.mesh.polyline(-np.array(way), way, 9)
        scene.add_rod(
            mesh,
            stark.materials.rubber_cord,
            name=("lower", "upper")[k],
            position=(0.0, 0.0, height),
            clamps=None if k else [0, 9],
        )
    grid = stark.mesh.grid(0.2, 0.2, cells=6)
    rim = np.flatnonzero(np.abs(grid.vertices[:, :2]).max(axis=1) > 0.0999)
    scene.add_cloth(
        grid, stark.materials.cotton, name="sheet", position=(1.0, 0.0, 0.0), pins=rim, contact_distance=0.001
    )
    mesh = stark.mesh.polyline((0.95, 0.01, 0.0), (1.05, 0.013, 0.0), 5)
    height = _RADIUS + 0.002
    scene.add_rod(mesh, stark.materials.rubber_cord, name="cord", position=(0.0, 0.0, height))
    return scene


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("thin") / "run", thin(), 12, time_step=0.01)


def _onto(height: float, state: int = 8, rest: bool = False) -> Callable[[np.ndarray, np.ndarray], None]:
    """Lays a body at this height, in one state or from there on."""

    def change(array: np.ndarray, times: np.ndarray) -> None:
        array[state : None if rest else state + 1, :, 2] = height

    return change


def test_rods_and_sheets_that_touch_are_certified(good: Path) -> None:
    """They touch: within the sum of their contact distances, which for rods are the radii."""
    certificate = verify(good)
    assert certificate.verdict == "certified", certificate.text()
    claim = certificate["minimum_distance"]
    assert claim.tolerance in (
        pytest.approx(_LEAST * 2 * _RADIUS, rel=1e-4),
        pytest.approx(_LEAST * (_RADIUS + 0.001), rel=1e-4),
    )
    assert claim.worst is not None and claim.worst < 2 * _RADIUS
    assert certificate["rigid_shapes"].status == "verified" or certificate["rigid_shapes"].worst is None


@pytest.mark.parametrize(("share", "status"), [(0.5, "violated"), (2.0, "verified")])
def test_the_gap_of_two_rods(run: Path, share: float, status: str) -> None:
    """Edges against edges: half of the distance that is kept, and twice of it."""
    gap = share * _LEAST * 2 * _RADIUS
    edit_states(run, f"positions_{_LOWER:04d}", _onto(0.0))
    edit_states(run, f"positions_{_UPPER:04d}", _onto(gap))
    claim = verify(run)["minimum_distance"]
    assert claim.status == status
    assert claim.worst == pytest.approx(gap, rel=1e-5)
    assert claim.where is not None
    assert (claim.where["state"], set(claim.where["bodies"])) == (8, {"lower", "upper"})


@pytest.mark.parametrize(("share", "status"), [(0.5, "violated"), (2.0, "verified")])
def test_the_gap_of_a_rod_and_a_sheet(run: Path, share: float, status: str) -> None:
    """Contact distances differ: what counts is their sum."""
    gap = share * _LEAST * (_RADIUS + 0.001)
    edit_states(run, f"positions_{_SHEET:04d}", _onto(0.0))
    edit_states(run, f"positions_{_CORD:04d}", _onto(-gap))  # from below: an open sheet has two sides
    claim = verify(run)["minimum_distance"]
    assert claim.status == status
    assert claim.worst == pytest.approx(gap, rel=1e-5)


def test_the_gap_of_a_sheet_to_itself(run: Path) -> None:
    """A corner folded over onto the middle."""

    def fold(array: np.ndarray, times: np.ndarray) -> None:
        array[8, :, 2] = 0.0
        array[8, 0] = array[8, 24] + [0.002, 0.003, 0.5e-6]

    edit_states(run, f"positions_{_SHEET:04d}", fold)
    claim = verify(run)["minimum_distance"]
    assert claim.status == "violated"
    assert claim.where is not None
    assert set(claim.where["bodies"]) == {"sheet"}


def test_a_rod_through_a_sheet_is_an_intersection(run: Path) -> None:
    def pierce(array: np.ndarray, times: np.ndarray) -> None:
        array[8, 3:, 2] = -0.02

    edit_states(run, f"positions_{_CORD:04d}", pierce)
    claim = verify(run)["no_intersection"]
    assert claim.status == "violated"
    assert claim.where is not None
    assert (claim.where["state"], set(claim.where["bodies"])) == (8, {"cord", "sheet"})


@pytest.mark.parametrize(
    ("body", "other", "bodies"),
    [(_UPPER, _LOWER, {"lower", "upper"}), (_CORD, _SHEET, {"cord", "sheet"})],
)
def test_passing_through_between_states_is_not_certified(
    run: Path, body: int, other: int, bodies: set[str]
) -> None:
    """Both states are good; there is no crossing to be seen in either, as thin bodies have no inside."""
    edit_states(run, f"positions_{other:04d}", _onto(0.0, 0, rest=True))
    edit_states(run, f"positions_{body:04d}", _onto(3.0 * _RADIUS, 0, rest=True))
    edit_states(run, f"positions_{body:04d}", _onto(-3.0 * _RADIUS, rest=True))
    certificate = verify(run)
    assert certificate["no_intersection"].status == certificate["minimum_distance"].status == "verified"
    claim = certificate["paths"]
    assert claim.status == "inconclusive", certificate.text()
    assert claim.where is not None
    assert (claim.where["state"], set(claim.where["bodies"])) == (8, bodies)
    assert certificate.exit_code == 1  # the reported energies tell that it was not so


def test_a_rope_thicker_than_its_segments_are_long_is_certified(tmp_path: Path) -> None:
    """A loop of it bends and lands on the floor; what is near along it is left out, and said to be."""
    rope = stark.RodMaterial(density=1000.0, youngs_modulus=1e6, radius=0.01)
    angle = np.linspace(0.0, 1.8 * np.pi, 100)
    path = 0.1 * np.column_stack([np.cos(angle), np.sin(angle), 0.15 + 0.02 * angle])
    scene = stark.Scene("rope")
    scene.add_floor()
    scene.add_rod(path, rope)
    certificate = verify(record(tmp_path / "run", scene, 12, time_step=0.01))
    assert certificate.verdict == "certified"
    assert certificate.limits == ("parts of 'rod' within 0.0314 m along it are not looked at",)
