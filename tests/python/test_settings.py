"""Settings: by attribute, by name and from text; every one has unit, rule and meaning."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import stark


def test_settings_by_attribute_by_name_and_by_text() -> None:
    settings = stark.Settings(time_step=1 / 30, contact_distance=2e-3, **{"newton.step_tolerance": 1e-4})
    assert settings.time.step == settings["time.step"] == settings.time_step == 1 / 30
    assert settings["contact_distance"] == settings.contact.distance == 2e-3
    settings.newton.max_iterations = np.int64(7)
    settings.gravity = np.array([0, 0, -1.62])
    settings.contact.enabled = False
    settings.set_text("linear.solver=pcg")
    settings.set_text("threads = 2")
    for wrong in ("threads", 2, None):
        with pytest.raises(stark.InvalidSetting, match=f"{wrong!r}: must have the form name=value"):
            settings.set_text(wrong)  # type: ignore[arg-type]
    assert settings.changed() == {
        "time.step": 1 / 30,
        "newton.step_tolerance": 1e-4,
        "newton.max_iterations": 7,
        "linear.solver": "pcg",
        "contact.enabled": False,
        "contact.distance": 2e-3,
        "execution.threads": 2,
        "gravity": (0.0, 0.0, -1.62),
    }
    assert settings == stark.Settings(**settings.to_dict())
    assert pickle.loads(pickle.dumps(settings)) == settings
    assert settings.copy() == settings and settings.copy() is not settings
    assert "newton.max_iterations = 7" in settings.brief()
    assert "contact.distance = 0.002 m\n" in repr(settings)
    assert not hasattr(settings, "nothing") and not hasattr(settings.newton, "nothing")
    assert "step_tolerance" in dir(settings.newton) and "newton" in dir(settings)
    assert stark.Settings(newton={"armijo": 0.1}).newton.armijo == 0.1


def test_every_setting_has_unit_rule_and_meaning_and_a_valid_default() -> None:
    settings = stark.Settings()
    settings.validate()
    for field in stark.Settings.fields():
        assert field["doc"] and field["rule"].startswith("must be")
        assert field["unit"] or field["choices"] or isinstance(field["default"], bool)
        settings[field["name"]] = field["default"]
    assert settings.changed() == {}
    assert settings.brief() == "all defaults"


def test_the_reference_document_is_up_to_date() -> None:
    tool = Path(__file__).resolve().parents[2] / "tools" / "reference.py"
    run = subprocess.run([sys.executable, tool, "--check"], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr


def test_a_simulation_takes_settings_as_a_mapping_by_dotted_name() -> None:
    scene = stark.Scene()
    scene.add_box(size=0.1, mass=1.0)
    sim = stark.Simulation(scene, {"time.integrator": "bdf2", "time_step": 0.02}, time_step=0.01)
    assert (sim.settings["time.integrator"], sim.settings["time.step"]) == ("bdf2", 0.01)
    with pytest.raises(
        stark.InvalidArgument, match=r"settings = 3: must be a stark\.Settings, or values by dotted name"
    ):
        stark.Simulation(scene, 3)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "text", "rule"),
    [
        ("time_step", "0.01", "must be a number, not a text; write it without quotes, or settings.set_text"),
        ("threads", "2", "must be a number, not a text"),
        ("newton.max_iterations", "50", "must be a number, not a text"),
        ("newton.max_seconds", "inf", "must be a number, not a text"),
        ("contact.distance", "1 mm", "must be a number, not a text"),
        ("contact.self_contact", "no", "must be true or false, not a text; write True or False"),
        ("gravity", "0,0,-9.81", "must be three numbers, not a text"),
    ],
)
def test_numbers_and_switches_are_no_texts(name: str, text: str, rule: str) -> None:
    """Texts are for command lines; in a program a number in quotes is a mistake."""
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    with pytest.raises(stark.InvalidSetting, match=f"{name} = '{text}': {rule}"):
        stark.Simulation(scene, **{name: text})
    settings = stark.Settings()
    with pytest.raises(stark.InvalidSetting, match=f"{name} = '{text}': {rule}"):
        settings[name] = text
    assert settings.changed() == {}


def test_a_text_that_was_read_is_set_as_text() -> None:
    settings = stark.Settings()
    for assignment in ("time_step = 0.01", "contact.self_contact=no", "newton.max_seconds=inf"):
        settings.set_text(assignment)
    assert settings.changed() == {"time.step": 0.01, "contact.self_contact": False}


@pytest.mark.parametrize(
    "value",
    [[[1, 2], [3]], [[0, 0, -1]], np.ones((1, 3)), (1, (2,), 3), b"abc", [True, False, True], np.array(2.0)],
)
def test_vectors_are_rows_of_three_numbers(value: object) -> None:
    """What is nested was taken number by number, bytes by their codes."""
    with pytest.raises(stark.InvalidSetting, match=r"gravity = .*: must be three numbers"):
        stark.Settings(gravity=value)  # type: ignore[arg-type]


def test_arrays_without_axes_are_their_value() -> None:
    settings = stark.Settings(time_step=np.array(0.01), threads=np.array(2))
    assert settings.changed() == {"time.step": 0.01, "execution.threads": 2}


@pytest.mark.parametrize("name", ["gravity", "threads", "time_step", "contact_distance", "time.step"])
@pytest.mark.parametrize("value", [{}, {"x": 1.0}])
def test_a_setting_is_no_group(name: str, value: object) -> None:
    """An empty group was taken and left the default."""
    with pytest.raises(stark.InvalidSetting, match=r"(time|contact|execution|gravity)\S* = '.*': must be"):
        stark.Settings(**{name: value})


def test_an_empty_group_must_be_one() -> None:
    assert stark.Settings(newton={}).changed() == {}
    with pytest.raises(stark.InvalidSetting, match="unknown setting 'newtn'"):
        stark.Settings(newtn={})


def test_switches_of_numpy_are_switches() -> None:
    """np.True_ was refused as 1: must be true or false."""
    on, off = np.array([1.0, 0.0]) > 0.5
    assert stark.Settings(contact={"friction": off, "enabled": on}).changed() == {"contact.friction": False}
    with pytest.raises(stark.InvalidSetting, match=r"time\.step = true: must be > 0"):
        stark.Settings(time_step=on)
