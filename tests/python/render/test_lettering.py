"""Letters: all that titles and numbers need, told apart."""

from __future__ import annotations

import string

import numpy as np
import pytest

from stark.render.lettering import strokes
from stark.render.overlay import Overlay


def drawn(text: str) -> np.ndarray:
    overlay = Overlay(np.full((30, 24, 3), 255, dtype=np.uint8))
    overlay.text((4.0, 20.0), text, 14.0)
    return overlay.picture[..., 0]


def test_every_character_has_a_shape_of_its_own() -> None:
    characters = string.ascii_letters + string.digits + ".,:-+=/()[]%*_^'<>!?|#"
    shapes = {character: drawn(character) for character in characters if character not in "O0"}
    for character, shape in shapes.items():
        assert (shape < 128).sum() >= 3, character
        if character != "?":
            assert not np.array_equal(shape, shapes["?"]), character
    assert len({shape.tobytes() for shape in shapes.values()}) == len(shapes)


def test_sizes() -> None:
    rows, width = strokes("H", 12.0)
    points = np.concatenate(rows)
    assert points[:, 1].min() == pytest.approx(-12.0) and points[:, 1].max() == 0.0
    assert points[:, 0].max() == pytest.approx(width)
    assert strokes("HH", 24.0)[1] == pytest.approx(2 * strokes("HH", 12.0)[1])
    assert strokes("HH", 12.0)[1] > 2 * width
    assert strokes("", 12.0) == ([], 0.0)
    assert strokes("a b", 12.0)[1] > strokes("ab", 12.0)[1]


def test_what_has_no_letter_is_a_question_mark() -> None:
    assert np.array_equal(drawn("Ω"), drawn("?"))
