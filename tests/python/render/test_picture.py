"""Pictures: colours, options, bodies that cannot be drawn."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fake_simulation import FakeSimulation, record

from stark.render import render


def test_render_shows_the_cloth_in_its_colour() -> None:
    picture = render(FakeSimulation(), 320, 200, quality="draft")
    assert picture.shape == (200, 320, 3) and picture.dtype == np.uint8
    red, green = picture[..., 0].astype(int), picture[..., 1].astype(int)
    assert 0.05 < (red > green + 40).mean() < 0.6


def test_nothing_to_draw() -> None:
    picture = render(SimpleNamespace(bodies=[]), 32, 20, quality="draft")
    assert picture.shape == (20, 32, 3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"quality": "fine"}, "quality 'fine' is unknown; choose one of draft, good, best"),
        ({"camera": "left"}, "view 'left' is unknown; choose one of oblique"),
        ({"width": 0}, r"must be in \[1, 16384\]"),
        ({"hide": "*"}, r"picture: hide = '\*' leaves none of the . bodies to draw: name at least one"),
        ({"bodies": []}, r"picture: bodies = \[\] leaves none of the . bodies to draw"),
        ({"bodies": "cloth", "hide": ["cloth"]}, r"bodies = 'cloth', hide = \['cloth'\] leaves none"),
    ],
)
def test_bad_options(options, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        render(FakeSimulation(), **{"width": 16, "height": 16, **options})


def test_vertices_that_are_not_finite_are_named() -> None:
    sim = FakeSimulation()
    sim.bodies[0].positions[5, 1] = np.nan
    with pytest.raises(ValueError, match="body 'cloth': vertex 5 is not finite"):
        render(sim, 16, 16)


def test_still_of_a_recording(tmp_path: Path) -> None:
    run = record(tmp_path / "run", 6)
    early, late = (run.still(t, width=80, height=60, quality="draft") for t in (0.0, 0.2))
    assert early.shape == (60, 80, 3)
    assert not np.array_equal(early, late)
