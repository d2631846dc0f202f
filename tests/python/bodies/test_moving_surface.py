"""Moving surfaces as values of bodies: given, live, over time, refused, kept in every file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import document, reproducer
from stark.verify import verify


def conveyor(**settings: Any) -> stark.Simulation:
    return stark.Simulation(scene(), time_step=0.01, **{"contact.distance": 1e-3, **settings})


def scene() -> stark.Scene:
    made = stark.Scene("conveyor")
    belt = made.add_box((1.0, 0.3, 0.1), motion="fixed", position=(0, 0, -0.05), name="belt")
    belt.surface_velocity = lambda t: (2.0 * t, 0, 0)
    made.add_box(0.1, mass=1.0, position=(-0.2, 0, 0.0515), name="box")
    made.add_floor(3.0, height=-0.5)
    return made


def test_values_are_given_to_the_scene_and_live_in_the_simulation() -> None:
    made = stark.Scene()
    plate, rest = made.add_box(0.2, motion="fixed"), made.add_box(0.1, mass=1.0, position=(0, 0, 1))
    assert plate.surface_velocity is None and plate.surface_spin is None and plate.surface_center is None
    plate.surface_spin = (0, 0, 2)
    assert plate.surface_velocity is not None and plate.surface_center is not None
    assert plate.surface_velocity.tolist() == plate.surface_center.tolist() == [0, 0, 0]
    plate.surface_center = (0.1, 0, 0)
    sim = stark.Simulation(made)
    plate.surface_velocity = (0.3, 0, 0)
    assert sim[plate].surface_velocity.tolist() == [0.3, 0, 0]
    assert sim[plate].surface_spin.tolist() == [0, 0, 2]
    state = sim.state
    sim[plate].surface_spin = (0, 1, 0)
    assert sim.state != state
    sim.state = state
    assert plate.surface_spin.tolist() == [0, 0, 2]  # as all that is live, a part of the state
    sim.reset()
    assert plate.surface_velocity.tolist() == [0, 0, 0]
    assert rest.surface_velocity is None
    with pytest.raises(stark.InvalidArgument, match="was not given before the simulation was created"):
        rest.surface_velocity = (1, 0, 0)
    with pytest.warns(stark.StarkWarning, match="surface_center does not affect"):
        plate.surface_center = (0, 0, 0)


@pytest.mark.parametrize(
    "name, value, said",
    [
        ("surface_velocity", (1, 0), "'belt': surface_velocity = (1, 0): must be three numbers"),
        ("surface_velocity", "fast", "'belt': surface_velocity = 'fast': must be three numbers"),
        ("surface_velocity", (np.inf, 0, 0), "'belt': surface_velocity = (inf, 0, 0): must be finite"),
        ("surface_spin", 3.0, "'belt': surface_spin = 3.0: must be three numbers"),
        ("surface_spin", lambda t: (0, 0), "'belt': surface_spin = array([0., 0.]): must be three numbers"),
        ("surface_center", (0, 0, np.nan), "'belt': surface_center = (0, 0, nan): must be finite"),
    ],
)
@pytest.mark.parametrize("live", [False, True])
def test_what_is_no_velocity_is_refused(name: str, value: Any, said: str, live: bool) -> None:
    made = scene()
    sim = stark.Simulation(made) if live else None
    with pytest.raises(stark.InvalidArgument, match=re.escape(said)):
        setattr(made["belt"], name, value)
    assert sim is None or made["belt"].surface_velocity.tolist() == [0, 0, 0]


def test_what_deforms_has_no_moving_surface() -> None:
    made = stark.Scene()
    cloth = made.add_cloth(stark.mesh.grid(0.1, 0.1, 2), stark.materials.cotton)
    with pytest.raises(stark.InvalidArgument, match="must be of a rigid body"):
        made._core.set_surface_motion(cloth._index, *np.zeros((3, 3)))
    with pytest.raises(AttributeError, match="surface_velocity"):
        cloth.surface_velocity = (1, 0, 0)


def test_each_step_takes_the_value_at_its_end() -> None:
    sim = conveyor()
    sim.step()
    assert sim["belt"].surface_velocity.tolist() == pytest.approx([0.02, 0, 0])
    sim["belt"].surface_velocity = (0.5, 0, 0)  # ends the function
    sim.step()
    assert sim["belt"].surface_velocity.tolist() == [0.5, 0, 0]


def test_scenes_without_belts_have_no_such_state() -> None:
    made = stark.Scene()
    made.add_box(0.1, mass=1.0)
    arrays = stark.Simulation(made).state.arrays()
    assert len(arrays["surface_velocity"]) == len(arrays["surface_spin"]) == 0


def test_documents_reproducers_and_threads_give_the_same_bits(tmp_path: Path) -> None:
    def states(sim: stark.Simulation, steps: int = 15) -> list[str]:
        return [sim.state.hash for _ in range(steps) if not sim.step().failed]

    made, settings = scene(), {"contact.distance": 1e-3, "time.step": 0.01}
    made.save(tmp_path / "scene.json", settings=settings, until=0.2, sample_functions=True)
    read = document.read(tmp_path / "scene.json")
    assert read.scene["belt"].surface_velocity.tolist() == [0, 0, 0]
    sim = conveyor()
    expected = states(sim)
    # Functions come as values at the ends of steps: rounding of the straight lines between them is all.
    loaded = stark.Simulation(read.scene, **read.settings)
    states(loaded)
    assert loaded["box"].position == pytest.approx(sim["box"].position, abs=1e-12)
    assert states(conveyor(**{"execution.threads": 1})) == expected
    sim.write_reproducer(tmp_path / "step")
    again = reproducer.load(tmp_path / "step")
    again.step()
    assert again.state.hash == sim.state.hash


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_recordings_with_belts_are_certified(tmp_path: Path, integrator: str) -> None:
    sim = conveyor(**{"time.integrator": integrator})
    with stark.recording.Recorder(tmp_path / "run", sim, certify=True) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        for _ in range(15):
            recorder.report(sim.step())
            recorder.record_state(sim)
        recorder.record(sim)
    certificate = verify(tmp_path / "run")
    assert certificate.verdict == "certified", [c for c in certificate.claims if c.status != "verified"]
    work = stark.recording.Recording(tmp_path / "run").telemetry["energy.belts"]
    assert work.sum() > 0.01
    arrays = np.load(tmp_path / "run/states/chunk_000000.npz")
    assert arrays["surface_motions_0000"][-1, 0] == pytest.approx([0.3, 0, 0])


def test_work_of_belts_that_are_not_there_violates_the_ledger(tmp_path: Path) -> None:
    made = stark.Scene()
    made.add_box(0.1, mass=1.0)
    sim = stark.Simulation(made, time_step=0.01)
    with stark.recording.Recorder(tmp_path / "run", sim, certify=True) as recorder:
        recorder.record_state(sim)
        for _ in range(3):
            recorder.report(sim.step())
            recorder.record_state(sim)
    path = tmp_path / "run/telemetry.jsonl"
    text = path.read_text()
    assert text.count('"belts":0.0') == 3
    path.write_text(text.replace('"belts":0.0', '"belts":0.5', 1))
    claims = {claim.name: claim for claim in verify(tmp_path / "run").claims}
    assert claims["energy_ledger"].status == "violated"
    assert "belts = 0.5 J: must be 0, no surface" in claims["energy_ledger"].detail
