"""Several environments, each in a process of its own."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium.vector import AsyncVectorEnv, AutoresetMode

from .task import TaskError


def vector(maker: Callable[..., Any], count: int, **arguments: Any) -> AsyncVectorEnv:
    """``count`` environments that ``maker(**arguments)`` makes, such as ``stark.gym.DragCloth``, each in a
    process of its own. Processes are started anew ("spawn"), never forked, so a program that calls this needs
    ``if __name__ == "__main__":``; ``maker`` and its arguments must be picklable: a class or a function of a
    module. An environment that has ended starts again with the next step.

    ``envs.reset(seed=7)`` gives environment k the seed 7 + k. Close it in the end: ``envs.close()``."""
    if not callable(maker):
        raise TaskError(
            f"vector: maker = {maker!r}: must be a class or function that makes an environment, as each "
            f"process makes its own"
        )
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise TaskError(f"vector: count = {count!r}: must be an integer >= 1")
    makers = [functools.partial(maker, **arguments)] * int(count)
    return AsyncVectorEnv(makers, context="spawn", autoreset_mode=AutoresetMode.NEXT_STEP)
