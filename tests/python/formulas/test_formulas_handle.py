"""Parameters are live: assigned, changed in place, per element; what was not touched costs nothing."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from _scenes import anchor, sheet, spring

import stark
from stark import InvalidArgument

H = 0.01


def forces_of(stiffness: float, sim: stark.Simulation, cloth: stark.Cloth, target: object) -> np.ndarray:
    return stiffness * (np.asarray(target) - sim[cloth].positions)


def test_assigned_values_hold_from_the_next_step_on() -> None:
    scene, cloth = sheet(2)
    pull = scene.add(anchor(cloth.vertices, target=(0.0, 0.0, 0.1), stiffness=0.1))
    sim = stark.Simulation(scene, time_step=H)
    sim.step()
    pull.target, pull.stiffness = (0.2, 0.0, 0.1), 0.3
    assert pull.stiffness == 0.3 and list(pull.target) == [0.2, 0.0, 0.1]
    sim.step()
    np.testing.assert_allclose(
        pull.forces[:, 0], forces_of(0.3, sim, cloth, (0.2, 0.0, 0.1)), rtol=1e-12, atol=1e-15
    )


def test_changes_in_place_reach_the_simulation() -> None:
    scene, cloth = sheet(2)
    pull = scene.add(anchor(cloth.vertices, target=(0.0, 0.0, 0.1), stiffness=np.full(9, 0.1)))
    sim = stark.Simulation(scene, time_step=H)
    sim.step()
    handed_out = pull.stiffness
    handed_out[3] = 0.0
    pull.target[2] = 0.5
    sim.step()
    assert (pull.forces[3] == 0.0).all() and (pull.forces[4, 0] != 0.0).all()
    handed_out[3] = 0.2
    pull.stiffness = 0.1  # one number for all elements; the array that was handed out stays live
    handed_out[5] = 0.0
    sim.step()
    assert (pull.forces[5] == 0.0).all() and (pull.forces[3, 0] != 0.0).all()
    assert pull.parameters["stiffness"] is pull.stiffness
    assert dict(pull.parameters).keys() == {"target", "stiffness"}


def test_values_changed_before_the_simulation_is_made_count() -> None:
    scene, cloth = sheet(2)
    pull = scene.add(anchor(cloth.vertices, target=(0.0, 0.0, 0.1), stiffness=0.1))
    pull.stiffness = 0.4
    pull.target[1] = 0.3
    sim = stark.Simulation(scene, time_step=H)
    sim.step()
    np.testing.assert_allclose(
        pull.forces[:, 0], forces_of(0.4, sim, cloth, (0.0, 0.3, 0.1)), rtol=1e-12, atol=1e-15
    )


def test_every_simulation_of_the_scene_follows() -> None:
    scene, cloth = sheet(2)
    pull = scene.add(anchor(cloth.vertices, target=(0.0, 0.0, 0.1), stiffness=0.1))
    first, second = stark.Simulation(scene, time_step=H), stark.Simulation(scene, time_step=H)
    first.step()
    pull.stiffness = 0.2
    first.step()
    second.step()
    second.step()
    in_first, in_second = first.energies[0], second.energies[0]
    np.testing.assert_allclose(in_first.forces[:, 0], forces_of(0.2, first, cloth, (0, 0, 0.1)), atol=1e-14)
    np.testing.assert_allclose(in_second.forces[:, 0], forces_of(0.2, second, cloth, (0, 0, 0.1)), atol=1e-14)
    assert in_first.energy != in_second.energy
    np.testing.assert_array_equal(pull.forces, in_second.forces)  # the last one that was made


def test_bindings_that_are_added_twice_have_values_of_their_own() -> None:
    scene, cloth = sheet(2)
    binding = spring(cloth.edges, stiffness=1.0)
    a, b = scene.add(binding), scene.add(binding)
    a.stiffness = 2.0
    assert (a.stiffness, b.stiffness) == (2.0, 1.0)
    assert (a.name, b.name) == ("spring", "spring_2")
    assert scene.energies == (a, b)


def test_untouched_values_are_not_sent_again(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, cloth = sheet(2)
    pull = scene.add(anchor(cloth.vertices, target=(0.0, 0.0, 0.1), stiffness=np.full(9, 0.1)))
    sim = stark.Simulation(scene, time_step=H)
    sent: list[str] = []

    class Core:
        def set_energy_value(self, index: int, name: str, numbers: np.ndarray) -> None:
            sent.append(name)

    live = sim._live_values[0]
    live.push(Core())
    assert sent == []
    pull.stiffness = 0.2
    live.push(Core())
    live.push(Core())
    assert sent == ["stiffness"]
    target = pull.target  # an array that was handed out is sent when it has changed
    for _ in range(3):
        live.push(Core())
    assert sent == ["stiffness"]
    target[0] = 1.0
    live.push(Core())
    live.push(Core())
    assert sent == ["stiffness", "target"]


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("stiffness", "soft", ["'stiffness' [N/m]", "'soft'", "must be a number"]),
        ("stiffness", -1.0, ["stiffness = -1 N/m", "must be >= 0"]),
        ("stiffness", np.nan, ["stiffness = nan N/m", "must be finite"]),
        ("stiffness", np.ones(9), ["shape (9,)", "one value for all elements"]),
        ("target", (0.0, 1.0), ["'target'", "shape (2,)", "(3,)"]),
    ],
)
def test_refused_values(name: str, value: object, words: list[str]) -> None:
    scene, cloth = sheet(2)
    pull = scene.add(anchor(cloth.vertices, target=(0.0, 0.0, 0.1)))
    before = pull.parameters[name]
    with pytest.raises(InvalidArgument) as raised:
        setattr(pull, name, value)
    assert all(word in str(raised.value) for word in ["energy 'anchor'", *words]), raised.value
    np.testing.assert_array_equal(pull.parameters[name], before)


def test_values_spoilt_in_place_are_refused_at_the_step() -> None:
    scene, cloth = sheet(2)
    pull = scene.add(anchor(cloth.vertices, target=(0.0, 0.0, 0.1), stiffness=np.full(9, 0.1)))
    sim = stark.Simulation(scene, time_step=H)
    pull.stiffness[4] = -2.0
    with pytest.raises(InvalidArgument, match=r"stiffness\[4\] of element 4 = -2 N/m: must be >= 0"):
        sim.step()
    pull.stiffness[4] = 0.2
    assert not sim.step().failed


def test_unknown_names_and_missing_simulations() -> None:
    scene, cloth = sheet(2)
    pull = scene.add(anchor(cloth.vertices, target=(0.0, 0.0, 0.1)))
    with pytest.raises(AttributeError, match="its parameters are target, stiffness"):
        pull.stifness = 1.0
    with pytest.raises(AttributeError, match="its parameters are target, stiffness"):
        _ = pull.stifness
    with pytest.raises(KeyError, match="its parameters are"):
        pull.parameters["stifness"]
    with pytest.raises(InvalidArgument, match="forces need a simulation"):
        _ = pull.forces
    assert {"target", "stiffness", "forces"} <= set(dir(pull))
    assert repr(pull) == "<stark.Energy 'anchor' on 9 elements>"


def test_an_energy_that_was_not_added_has_no_values_to_set() -> None:
    scene, cloth = sheet(2)
    forgotten = anchor(cloth.vertices, target=(0.0, 0.0, 0.1))
    with pytest.raises(AttributeError, match=r"not in a scene yet.*'stiffness': add it"):
        forgotten.stiffness = 1.0
    with pytest.raises(AttributeError, match="not in a scene yet"):
        _ = forgotten.forces
    pull = scene.add(forgotten)
    assert copy.copy(pull).name == pull.name


def test_energies_added_after_the_simulation_say_so() -> None:
    scene, cloth = sheet(2)
    sim = stark.Simulation(scene, time_step=H)
    pull = scene.add(anchor(cloth.vertices, target=(0.0, 0.0, 0.1)))
    with pytest.raises(InvalidArgument, match="was added after the simulation was created"):
        _ = pull.energy
    assert sim.energies == []
