"""Attributes of tasks that do not fit together are named."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from gymnasium.spaces import Box, Discrete

from stark.gym import Task, TaskError
from stark.gym.task import checked


def task(**fields: Any) -> Task:
    found = Task()
    found.action_space = found.observation_space = Box(-1.0, 1.0, (1,), np.float32)
    found.__dict__.update(fields)
    return found


def test_a_good_one_passes() -> None:
    assert checked(task(settle=0.0)).control_step == 0.05
    assert checked(task(until=np.int64(2), settle=np.float32(0.5))).until == 2


@pytest.mark.parametrize(
    "fields",
    [
        {"control_step": 0.0},
        {"control_step": "1"},
        {"until": -1.0},
        {"until": float("inf")},
        {"settle": float("nan")},
        {"settle": -1.0},
        {"action_space": Discrete(3)},
        {"observation_space": None},
    ],
)
def test_a_wrong_one_is_refused(fields: dict[str, Any]) -> None:
    with pytest.raises(TaskError, match=next(iter(fields))):
        checked(task(**fields))
