"""Keys of runs: what changes them and what does not."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from _studies import FALL

from stark.scenes import SceneFileError, load
from stark.study import Limits, Plan, PlanError
from stark.study.task import settled, tasks


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "fall.py"
    path.write_text(FALL)
    return path


def keys(plan: Plan) -> list[str]:
    return [task.key for task in tasks(plan, Path("/study"))]


def test_keys_are_of_scene_options_settings_and_end_not_of_limits(scene: Path) -> None:
    plan = Plan(str(scene), [{"height": 2.0}, {"height": 3.0}])
    first = keys(plan)
    assert len(set(first)) == 2 and keys(plan) == first
    assert keys(replace(plan, limits=Limits(1.0, 0))) == first
    assert keys(replace(plan, samples=plan.samples[::-1])) == first[::-1]
    assert (
        keys(replace(plan, samples=[{"height": 2, "label": "a"}]))[0] == first[0]
    )  # default, and an integer
    for changed in (replace(plan, until=0.04), replace(plan, settings={"time_step": 0.02})):
        assert not set(keys(changed)) & set(first)
    scene.write_text(FALL + "# other\n")
    assert not set(keys(plan)) & set(first)


def test_repetitions_go_into_an_option(scene: Path) -> None:
    made = tasks(Plan(str(scene), [{}], repetitions=2, repetition_option="steps"), Path("/study"))
    assert [task.options for task in made] == [{"steps": 0}, {"steps": 1}]
    assert len(set(keys(Plan(str(scene), [{}], repetitions=3)))) == 3
    made = tasks(Plan(str(scene), [{}], repetitions=2, repetition_option="label"), Path("/study"))
    assert [task.options for task in made] == [{"label": "0"}, {"label": "1"}]


@pytest.mark.parametrize(
    ("sample", "message"),
    [
        ({"width": 1.0}, "has no option 'width'; its options: height"),
        ({"height": "tall"}, "option height = 'tall'; must be a float"),
        ({"steps": 1.5}, "option steps = 1.5; must be an int"),
        ({"steps": True}, "option steps = True; must be an int"),
        ({"steps": "1"}, "option steps = '1'; must be an int, as its default"),
        ({"height": "1"}, "option height = '1'; must be a float, as its default"),
        ({"bad": 1}, "option bad = 1; must be true or false"),
        ({"bad": "true"}, "option bad = 'true'; must be true or false, as its default"),
        ({"label": 1}, "option label = 1; must be a str"),
    ],
)
def test_options_that_the_scene_does_not_have(scene: Path, sample: dict[str, object], message: str) -> None:
    with pytest.raises(SceneFileError, match=message):
        tasks(Plan(str(scene), [sample]), Path("/study"))  # type: ignore[list-item]


def test_the_same_run_twice_is_an_error(scene: Path) -> None:
    with pytest.raises(SceneFileError, match=r"runs 0 and 1 are the same .*remove one, or give repetitions"):
        tasks(Plan(str(scene), [{}, {"height": 1.0}]), Path("/study"))


LISTS = FALL.replace("options = {", "options = {'place': [0.1, 0.2], 'tags': {'b', 'a'}, ")


def test_lists_are_texts_in_the_plan_and_lists_in_the_scene(scene: Path) -> None:
    scene.write_text(LISTS)
    made = tasks(Plan(str(scene), [{"place": "0.3,0.4"}, {"place": "12"}]), Path("/study"))
    assert [task.options for task in made] == [{"place": "0.3, 0.4"}, {"place": "12.0"}]
    with pytest.raises(SceneFileError, match="option tags = 'a': its default is a set"):
        tasks(Plan(str(scene), [{"tags": "a"}]), Path("/study"))


def test_the_key_of_a_run_is_the_same_in_every_process(scene: Path) -> None:
    """Sets have another order in another process; objects stand elsewhere in memory."""
    scene.write_text(LISTS.replace("{'b', 'a'}", "{'b', 'a', 'c', 'd', 'e'}, 'f': len, 'g': (lambda: 1)"))
    code = (
        "from stark.study import Plan; from stark.study.task import tasks; from pathlib import Path\n"
        f"print(tasks(Plan({str(scene)!r}, [{{}}]), Path('/study'))[0].key)"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(found) == 1


def test_an_option_has_no_values_beside_the_number_of_the_repetition(scene: Path) -> None:
    plan = Plan(str(scene), [{}, {"steps": 2}], repetitions=2, repetition_option="steps")
    with pytest.raises(PlanError, match=r"sample 1 has steps = 2, and repetition_option = 'steps' would"):
        tasks(plan, Path("/study"))


def test_the_default_of_an_option_decides_whether_draws_are_whole(scene: Path) -> None:
    drawn = Plan.parse(
        f"scene = '{scene}'\n[sampling]\nkind = 'random'\ncount = 20\nseed = 1\n"
        "[sampling.options]\nheight = { from = 1, to = 3 }\nsteps = { from = 1, to = 3 }"
    )
    made = tasks(drawn, Path("/study"))
    heights, steps = ([task.options[name] for task in made] for name in ("height", "steps"))
    assert set(steps) == {1, 2, 3} and all(type(value) is int for value in steps)
    assert len(set(heights)) == 20 and all(type(value) is float and 1 <= value <= 3 for value in heights)
    plan = settled(drawn, load(scene))  # as study.json holds it
    assert keys(replace(plan, samples=json.loads(json.dumps(plan.samples)))) == keys(drawn)
