"""The checker's own table of kinds of bodies agrees with that of the rest."""

from __future__ import annotations

import pytest

import stark.body_kinds
from stark.verify.body_kinds import KINDS, row_of


@pytest.mark.parametrize("kind", stark.body_kinds.names_of())
def test_the_checker_knows_what_vertices_follow(kind: str) -> None:
    assert row_of(kind).moved_by == stark.body_kinds.KINDS[kind].moved_by


def test_only_solids_have_vertices_that_are_not_drawn() -> None:
    assert [kind for kind in stark.body_kinds.names_of() if row_of(kind).has_inside] == ["solid"]
    assert set(KINDS) <= set(stark.body_kinds.names_of())
    assert row_of("cloud").moved_by == "points" and not row_of("cloud").has_inside
