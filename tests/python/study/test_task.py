"""Keys of runs: what changes them and what does not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from _studies import FALL

from stark.scenes import SceneFileError
from stark.study import Limits, Plan
from stark.study.task import tasks


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


def test_modules_beside_a_scene_count(scene: Path) -> None:
    scene.write_text(FALL + "import study_helper_a\n")
    (scene.parent / "study_helper_a.py").write_text("import study_helper_b\n")
    (scene.parent / "study_helper_b.py").write_text("x = 1\n")
    (scene.parent / "unused.py").write_text("x = 1\n")
    first = keys(Plan(str(scene), [{}]))
    (scene.parent / "unused.py").write_text("x = 2\n")
    assert keys(Plan(str(scene), [{}])) == first
    (scene.parent / "study_helper_b.py").write_text("x = 2\n")
    assert keys(Plan(str(scene), [{}])) != first


def test_repetitions_go_into_an_option(scene: Path) -> None:
    made = tasks(Plan(str(scene), [{}], repetitions=2, repetition_option="steps"), Path("/study"))
    assert [task.options for task in made] == [{"steps": 0}, {"steps": 1}]
    assert len(set(keys(Plan(str(scene), [{}], repetitions=3)))) == 3


@pytest.mark.parametrize(
    ("sample", "message"),
    [
        ({"width": 1.0}, "has no option 'width'; its options: height"),
        ({"height": "tall"}, "option height = 'tall'; must be a float"),
        ({"steps": 1.5}, "option steps = 1.5; must be a int, as its default"),
    ],
)
def test_options_that_the_scene_does_not_have(scene: Path, sample: dict[str, object], message: str) -> None:
    with pytest.raises(SceneFileError, match=message):
        tasks(Plan(str(scene), [sample]), Path("/study"))  # type: ignore[list-item]


def test_the_same_run_twice_is_an_error(scene: Path) -> None:
    with pytest.raises(SceneFileError, match=r"runs 0 and 1 are the same .*remove one, or give repetitions"):
        tasks(Plan(str(scene), [{}, {"height": 1.0}]), Path("/study"))
