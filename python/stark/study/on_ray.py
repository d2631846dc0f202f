"""Runs on a Ray cluster. Ray decides where each run is made, and makes it again when its process or machine
is lost; the study folder must be on a file system that all machines share."""

from __future__ import annotations

import os
import socket
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..array_file import WriteError
from .folder import StudyError, StudyFolder
from .local import OnShare, crashed_result
from .task import Task
from .work import perform

#: Runs that are told to stop have so long to write their checkpoints [s].
_FAREWELL = 0.6

#: How long to wait for a cluster to answer [s].
_PATIENCE = 10.0


def run_on_ray(
    folder: StudyFolder, tasks: Sequence[Task], address: str, retries: int, on_share: OnShare
) -> None:
    """Returns when every task has a result. ``address`` is that of a cluster, ``auto`` finds the one of this
    machine, ``local`` makes one for this process. Raises ImportError without Ray, StudyError where there is
    no such cluster, and WriteError when results cannot be written."""
    ray = _ray()
    mine = not ray.is_initialized()
    if mine:
        try:
            _require_listener(address)
            made_here = {"include_dashboard": False} if address == "local" else {}
            quiet = {"log_to_driver": False, "logging_level": "ERROR"}
            ray.init(address=address, runtime_env=_environment(), **quiet, **made_here)
        except (ConnectionError, ValueError, RuntimeError) as error:
            raise StudyError(
                f"study: ray = '{address}': no Ray cluster can be reached there ({error}); start one with "
                f"'ray start --head', or give 'local'"
            ) from error
    try:
        _run(ray, folder, tasks, retries, on_share)
    finally:
        if mine:
            ray.shutdown()


def _require_listener(address: str) -> None:
    """Ray itself tries an address where nobody listens for minutes. Raises ConnectionError there."""
    host, colon, port = address.rpartition(":")
    if not colon or "/" in address or not port.isdecimal():
        return
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=_PATIENCE).close()
    except (OSError, OverflowError) as error:
        raise ConnectionError(str(error)) from error


def _ray() -> Any:
    """The package, told to leave the standard error output to progress and messages."""
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")  # without it Ray warns
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # a cluster that is made here reports to nobody
    try:
        import ray
    except ImportError:
        raise ImportError("--ray needs Ray: pip install 'stark-sim[sweep]'") from None
    return ray


def _environment() -> dict[str, Any]:
    """In which workers import this very package, if their machine has it in the same place."""
    root, others = str(Path(__file__).resolve().parents[2]), os.environ.get("PYTHONPATH", "")
    return {"env_vars": {"PYTHONPATH": os.pathsep.join(filter(None, [root, others]))}}


def _make(task: dict[str, Any]) -> str:
    """In a process of Ray."""
    return str(perform(Task(**task))["status"])


def _run(ray: Any, folder: StudyFolder, tasks: Sequence[Task], retries: int, on_share: OnShare) -> None:
    make = ray.remote(num_cpus=1, max_retries=retries)(_make)
    under_way = {make.options(name=task.label()).remote(asdict(task)): task for task in tasks}
    try:
        while under_way:
            done, _ = ray.wait(list(under_way), num_returns=1, timeout=1.0)
            for reference in done:
                task = under_way.pop(reference)
                _finish(ray, folder, reference, task)
                on_share(task, 1.0)
    except BaseException:
        _cancel(ray, list(under_way))
        raise


def _finish(ray: Any, folder: StudyFolder, reference: Any, task: Task) -> None:
    """Sees to it that there is a result."""
    try:
        ray.get(reference)
    except ray.exceptions.RayTaskError as error:  # it was raised by the task
        cause = error.cause
        raised = WriteError(str(cause))
        raised.errno = getattr(cause, "errno", None)
        raise raised from error
    except ray.exceptions.RayError as error:  # processes or machines were lost too often
        if folder.result(task.key) is None:
            how, count = f"was lost ({type(error).__name__})", folder.attempts(task.key)
            folder.write_result(task.key, crashed_result(task, folder, how, count))


def _cancel(ray: Any, references: list[Any]) -> None:
    """Lets runs write their checkpoints for a moment, then kills their processes."""
    for force in (False, True):
        for reference in references:
            with suppress(Exception):
                ray.cancel(reference, force=force)
        if not force:
            with suppress(Exception):
                ray.wait(references, num_returns=len(references), timeout=_FAREWELL)
