"""Warnings of Stark: a category of their own that users can filter, raised where they called."""

from __future__ import annotations

import pickle
import warnings

import pytest

import stark


def doubtful() -> stark.Simulation:
    """A contact distance above half of the mesh width: it can be simulated, but is hardly meant."""
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, 20), contact_distance=0.01)
    return stark.Simulation(scene)


def test_warnings_have_a_category_of_their_own_and_name_the_line_of_the_user() -> None:
    with pytest.warns(stark.StarkWarning, match="contact_distance") as caught:
        doubtful()
    assert caught[0].filename == __file__
    assert issubclass(stark.StarkWarning, UserWarning)
    assert not issubclass(stark.StarkWarning, (stark.Error, DeprecationWarning))


def test_warnings_can_be_silenced_or_made_errors() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", stark.StarkWarning)
        assert doubtful().time == 0.0
        warnings.simplefilter("error", stark.StarkWarning)
        with pytest.raises(stark.StarkWarning):
            doubtful()


def test_warnings_name_the_public_place_and_can_be_sent_between_processes() -> None:
    assert stark.StarkWarning.__module__ == "stark"
    again = pickle.loads(pickle.dumps(stark.StarkWarning("cloth 'a': is thin")))
    assert type(again) is stark.StarkWarning and str(again) == "cloth 'a': is thin"
