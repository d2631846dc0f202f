"""Environments in processes of their own: the same bits as here, none of them forked."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from stark.gym import DragCloth, TaskError, vector


@pytest.mark.slow
def test_processes_give_the_bits_of_this_one() -> None:
    envs = vector(DragCloth, 2, settings={"time_step": 0.05})
    try:
        observations, _ = envs.reset(seed=7)
        moved = envs.step(np.ones((2, 3), dtype=np.float32))[0]
    finally:
        envs.close()
    for k in range(2):
        env = DragCloth(settings={"time_step": 0.05})
        assert env.reset(seed=7 + k)[0].tobytes() == observations[k].tobytes()
        assert env.step(np.ones(3, dtype=np.float32))[0].tobytes() == moved[k].tobytes()


def test_counts_are_checked() -> None:
    for count in (0, -1, True, 1.5, np.int64(0), np.float64(2.0)):
        with pytest.raises(TaskError, match="must be an integer >= 1"):
            vector(DragCloth, count)  # type: ignore[arg-type]


def test_an_environment_is_no_maker_of_environments() -> None:
    with pytest.raises(TaskError, match=r"vector: maker = .*: must be a class or function that makes"):
        vector(DragCloth(), 2)  # type: ignore[arg-type]


@pytest.mark.slow
def test_counts_may_be_of_numpy() -> None:
    envs = vector(DragCloth, np.int64(1))  # type: ignore[arg-type]
    assert envs.num_envs == 1
    envs.close()
