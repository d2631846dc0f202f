"""Runs on this machine: a few worker processes, each with one run at a time."""

from __future__ import annotations

import json
import os
import selectors
import signal
import subprocess
import sys
import time as clock
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from ..array_file import WriteError
from .folder import StudyError, StudyFolder
from .task import Task
from .work import empty_result, reached, timed_out_result

#: After its time-out a run has so long to end by itself before its process is killed [s].
_GRACE = 5.0

#: Processes in a row that may end before they have work.
_MOST_STILLBORN = 5

#: Processes that are told to stop have so long to write their checkpoints [s].
_FAREWELL = 0.6

#: Called with a task and the share of it that is done; 1 when its result is there.
OnShare = Callable[[Task, float], None]


@dataclass(eq=False)
class _Worker:
    process: subprocess.Popen[bytes]
    task: Task | None = None
    began: float = 0.0
    unread: bytes = b""

    def give(self, task: Task) -> None:
        self.task, self.began = task, clock.monotonic()
        assert self.process.stdin is not None
        with suppress(BrokenPipeError):  # its end is noticed where its output ends
            self.process.stdin.write(json.dumps(asdict(task)).encode() + b"\n")
            self.process.stdin.flush()

    @property
    def overdue(self) -> bool:
        limit = None if self.task is None else self.task.time_out
        return limit is not None and clock.monotonic() > self.began + limit + _GRACE


@dataclass
class LocalPool:
    """Makes tasks in ``processes`` processes; a task whose process dies is tried ``retries`` times more."""

    folder: StudyFolder
    processes: int
    retries: int
    on_share: OnShare
    _selector: selectors.BaseSelector = field(default_factory=selectors.DefaultSelector)
    _workers: list[_Worker] = field(default_factory=list)
    _waiting: deque[Task] = field(default_factory=deque)
    _deaths: dict[str, int] = field(default_factory=dict)
    _stillborn: int = 0  # processes in a row that ended before they were ready

    def run(self, tasks: Sequence[Task]) -> None:
        """Returns when every task has a result. On KeyboardInterrupt all processes are ended within a second.
        Raises WriteError when results cannot be written."""
        self._waiting.extend(tasks)
        try:
            for _ in range(min(self.processes, len(tasks))):
                self._start()
            while self._workers:
                heard = [key.data for key, _ in self._selector.select(1.0)]
                for worker in heard:
                    self._hear(worker)
                # Its output does not end where a process that its scene has forked still has it.
                for worker in [w for w in self._workers if w not in heard and w.process.poll() is not None]:
                    self._bury(worker)
                for worker in [w for w in self._workers if w.overdue]:
                    self._kill(worker)
        finally:
            self._end()

    def _start(self) -> None:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "stark.study.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=_environment(),
            start_new_session=True,  # Ctrl-C of the terminal is for this process; it tells the others
        )
        assert process.stdout is not None
        worker = _Worker(process)
        self._workers.append(worker)
        self._selector.register(process.stdout, selectors.EVENT_READ, worker)

    def _hear(self, worker: _Worker) -> None:
        assert worker.process.stdout is not None
        data = os.read(worker.process.stdout.fileno(), 1 << 16)
        if not data:
            self._bury(worker)
            return
        *lines, worker.unread = (worker.unread + data).split(b"\n")
        for line in lines:
            self._told(worker, json.loads(line))

    def _told(self, worker: _Worker, what: dict[str, Any]) -> None:
        task = worker.task
        if "broken" in what:
            error = WriteError(what["broken"])
            error.errno = what["errno"]
            raise error
        if "time" in what and task is not None:
            self.on_share(task, min(0.999, what["time"] / task.until))
        elif "done" in what or "ready" in what:
            self._stillborn = 0
            if task is not None:
                self.on_share(task, 1.0)
            self._give(worker)

    def _give(self, worker: _Worker) -> None:
        worker.task = None
        if self._waiting:
            worker.give(self._waiting.popleft())
        else:
            self._dismiss(worker)

    def _dismiss(self, worker: _Worker) -> None:
        """Its input ends, and so does it."""
        self._workers.remove(worker)
        assert worker.process.stdout is not None and worker.process.stdin is not None
        self._selector.unregister(worker.process.stdout)
        with suppress(BrokenPipeError):
            worker.process.stdin.close()
        worker.process.stdout.close()
        worker.process.wait()

    def _bury(self, worker: _Worker) -> None:
        """A process has died: its task is tried again, by another one. What its scene has forked would keep
        the lock of the run."""
        task = worker.task
        _kill_group(worker.process)
        self._dismiss(worker)
        self._stillborn += task is None
        if self._stillborn > _MOST_STILLBORN:
            raise StudyError(
                f"study '{self.folder.path}': a process {_how(worker.process)} before it had work; see why: "
                f"{sys.executable} -m stark.study.worker"
            )
        if task is not None and self.folder.result(task.key) is not None:
            self.on_share(task, 1.0)
        elif task is not None:
            deaths = self._deaths[task.key] = self._deaths.get(task.key, 0) + 1
            if deaths > self.retries:
                result = crashed_result(task, self.folder, _how(worker.process), deaths)
                self.folder.write_result(task.key, result)
                self.on_share(task, 1.0)
            else:
                self._waiting.appendleft(task)
        if self._waiting:
            self._start()

    def _kill(self, worker: _Worker) -> None:
        """A run that did not end by itself after its time-out."""
        assert worker.task is not None
        task, worker.task = worker.task, None
        _kill_group(worker.process)
        worker.process.wait()
        if self.folder.result(task.key) is None:
            self.folder.write_result(task.key, timed_out_result(task, self.folder))
        self.on_share(task, 1.0)
        self._dismiss(worker)
        if self._waiting:
            self._start()

    def _end(self) -> None:
        """Ends all processes that are left; those that can, write their checkpoints first."""
        for worker in self._workers:
            worker.process.terminate()
        deadline = clock.monotonic() + _FAREWELL
        for worker in self._workers:
            with suppress(subprocess.TimeoutExpired):
                worker.process.wait(max(0.0, deadline - clock.monotonic()))
        for worker in list(self._workers):
            worker.process.kill()
            self._dismiss(worker)
        self._selector.close()


def _kill_group(process: subprocess.Popen[bytes]) -> None:
    """Ends a process and those that it has started: it leads its session."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)


def crashed_result(task: Task, folder: StudyFolder, how: str, deaths: int) -> dict[str, Any]:
    """The result of a run whose process died too often."""
    message = (
        f"its process {how}, {deaths} times; raise limits.retries, or run it alone to see why: "
        f"stark run {Path(task.scene)} {' '.join(f'--option {k}={v}' for k, v in task.options.items())}"
    )
    found = {**empty_result(task), **reached(task, folder)}
    return {**found, "status": "crashed", "message": message.strip()}


def _how(process: subprocess.Popen[bytes]) -> str:
    code = process.returncode
    return f"was killed by signal {-code}" if code < 0 else f"ended with exit code {code}"


def default_processes() -> int:
    """As many as this process may use cores."""
    return max(1, len(os.sched_getaffinity(0)))


def _environment() -> dict[str, str]:
    """In which the workers import this very package."""
    root = str(Path(__file__).resolve().parents[2])
    others = os.environ.get("PYTHONPATH", "")
    limits = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    return {**os.environ, **limits, "PYTHONPATH": os.pathsep.join(filter(None, [root, others]))}
