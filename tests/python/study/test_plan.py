"""Plans: what they say, and errors that name key, value, rule and remedy."""

from __future__ import annotations

from pathlib import Path

import pytest

from stark.study import Limits, Plan, PlanError

HEAD = 'scene = "hello_cloth"\n'
GRID = HEAD + '[sampling]\nkind = "grid"\n[sampling.options]\n'
DRAW = HEAD + '[sampling]\nkind = "random"\n'


def test_a_plan_with_all_keys(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(
        """
scene = "a/fall.py"
until = 2
repetitions = 3
repetition_option = "seed"
fps = 30
checkpoint_every = 0
certify = true
[settings]
time_step = 0.01
newton.max_iterations = 50
[limits]
time_out = 5
retries = 1
[sampling]
kind = "list"
[[sampling.runs]]
angle = 10.0
[[sampling.runs]]
angle = 20.0
label = "b"
"""
    )
    plan = Plan.read(tmp_path / "plan.toml")
    assert plan.scene == str(tmp_path / "a/fall.py") and plan.until == 2.0
    assert (plan.repetitions, plan.repetition_option, plan.fps, plan.checkpoint_every) == (
        3,
        "seed",
        30.0,
        0.0,
    )
    assert plan.settings == {"time_step": 0.01, "newton.max_iterations": 50}
    assert plan.limits == Limits(5.0, 1) and plan.certify
    assert plan.samples == [{"angle": 10.0}, {"angle": 20.0, "label": "b"}]
    assert Plan.parse(HEAD).samples == [{}]
    one = "a = [1]\n[sampling.variations]\nb = [2, 3]"
    plan = Plan.parse(HEAD + '[sampling]\nkind = "one_at_a_time"\n[sampling.options]\n' + one)
    assert plan.samples == [{"a": 1}, {"a": 1, "b": 2}, {"a": 1, "b": 3}]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "scene is missing; must be a text"),
        ("scene = 3", "scene = 3; must be a text that is not empty"),
        ("scene = ", "is no TOML"),
        (HEAD + "repetition = 3", "repetition = 3; no such key; did you mean 'repetitions'?"),
        (HEAD + "repetitions = 0", "repetitions = 0; must be an integer from 1 to 100000"),
        (HEAD + "repetitions = true", "repetitions = True; must be an integer"),
        (HEAD + "repetitions = 100001", "must be an integer from 1 to 100000"),
        (HEAD + "until = -1", "until = -1; must be a number > 0, in s"),
        (HEAD + "fps = inf", "fps = inf; must be a number > 0, in frames per simulated second"),
        (HEAD + "[limits]\ntime_out = 0", "limits.time_out = 0; must be a number > 0, in s"),
        (HEAD + "[limits]\nretry = 1", "limits.retry = 1; no such key; did you mean 'retries'?"),
        (HEAD + "limits = 3", "limits = 3; must be a table"),
        (HEAD + "[settings]\nnewton.max_iteration = 5", "settings.newton.max_iteration = 5;"),
        (HEAD + "[settings]\ntime_step = -1", "settings.time_step = -1;"),
        (
            HEAD + '[sampling]\nkind = "gird"',
            "sampling.kind = 'gird'; must be one of grid, one_at_a_time, list",
        ),
        (HEAD + '[sampling]\nkind = "grid"', "sampling.options is empty; give the values"),
        (GRID + "a = 3", "sampling.options.a = 3; must be a list of values, or a range"),
        (GRID + "a = []", "sampling.options.a = []; must hold at least one value"),
        (GRID + "a = [[1]]", "sampling.options.a[0] = [1]; must be a number, a text"),
        (GRID + "a = [nan]", "sampling.options.a[0] = nan; must be finite"),
        (GRID + "a = {from = 1, to = 2}", "sampling.options.a.count is missing; must be an integer >= 2"),
        (
            GRID + "a = {from = 2, to = 1, count = 3}",
            "sampling.options.a.to = 1; must be greater than from = 2",
        ),
        (GRID + "a = {to = 1, count = 3}", "sampling.options.a.from is missing; must be a number"),
        (
            GRID + 'a = {from = 0, to = 1, count = 3, scale = "log"}',
            "sampling.options.a.from = 0; must be > 0 with scale = 'log'; raise it",
        ),
        (GRID + 'a = {from = 0, to = 1, count = 3, scale = "cubic"}', "must be 'linear' or 'log'"),
        (
            GRID + "a = {from = 0, to = 1, count = 1000}\nb = {from = 0, to = 1, count = 1000}",
            "sampling.options make 1000000 combinations; must be at most 100000",
        ),
        (DRAW + "[sampling.options]\na = {from = 0, to = 1}", "sampling.count is missing"),
        (
            DRAW + "count = 3\nseed = -1\n[sampling.options]\na = [1]",
            "sampling.seed = -1; must be an integer",
        ),
        (
            HEAD + '[sampling]\nkind = "one_at_a_time"\n[sampling.options]\na = [1]',
            "sampling.variations is empty; give the values of at least one option",
        ),
        (
            HEAD
            + '[sampling]\nkind = "one_at_a_time"\n[sampling.options]\na = {from = 0, to = 1, count = 100}\n'
            "[sampling.variations]\nb = {from = 0, to = 1, count = 100000}",
            "sampling.options make 10000100 combinations; must be at most 100000",
        ),
        (HEAD + '[sampling]\nkind = "list"\nruns = []', "sampling.runs = []; must be tables of options"),
        (
            HEAD + '[sampling]\nkind = "list"\nruns = [{a = [1]}]',
            "sampling.runs[0].a = [1]; must be a number",
        ),
    ],
)
def test_errors_name_key_value_and_rule(text: str, message: str) -> None:
    with pytest.raises(PlanError) as raised:
        Plan.parse(text, owner="plan 'p.toml'")
    assert str(raised.value).startswith("plan 'p.toml': ") and message in str(raised.value)


def test_plans_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match="does not exist"):
        Plan.read(tmp_path / "plan.toml")
    with pytest.raises(PlanError, match="cannot be read"):
        Plan.read(tmp_path)
    (tmp_path / "plan.toml").write_bytes(b"\xff")
    with pytest.raises(PlanError, match="cannot be read"):
        Plan.read(tmp_path / "plan.toml")
    with pytest.raises(PlanError, match="has 200000 runs; must be from 1 to 100000"):
        Plan("hello_cloth", [{}] * 20000, repetitions=10)
