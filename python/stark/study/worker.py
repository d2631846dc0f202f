"""A process that makes runs: ``python -m stark.study.worker``. Tasks come as lines of JSON on its standard
input, what it has to tell goes out as lines of JSON; it ends when the input does, which is when the process
that started it ends in whatever way."""

from __future__ import annotations

import json
import os
import queue
import signal
import sys
import threading
import time as clock
from typing import Any, TextIO

from .._core import Error
from .task import Task
from .work import perform

#: Between two reports of how far a run is [s].
_PERIOD = 0.5


class _Teller:
    """Writes lines for the process that started this one."""

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._told = stream, 0.0

    def tell(self, **what: Any) -> None:
        self._stream.write(json.dumps(what) + "\n")
        self._stream.flush()

    def time(self, reached: float) -> None:
        now = clock.monotonic()
        if now - self._told >= _PERIOD:
            self._told = now
            self.tell(time=reached)


def main() -> int:
    """Works until the input ends, or SIGTERM comes."""
    # What scenes print must not get between the lines.
    stream = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    tasks = os.fdopen(os.dup(0), encoding="utf-8")  # no scene may read them
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    lines: queue.SimpleQueue[str] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(tasks, lines), daemon=True).start()
    teller = _Teller(stream)
    try:
        teller.tell(ready=True)
        while True:
            _work(Task(**json.loads(lines.get())), teller)
    except KeyboardInterrupt:
        return 0
    except BrokenPipeError:
        return 1


def _work(task: Task, teller: _Teller) -> None:
    try:
        result = perform(task, teller.time)
    except (Error, OSError) as error:
        teller.tell(broken=f"{error}", errno=getattr(error, "errno", None))
    else:
        teller.tell(done=result["status"])


def _read(tasks: TextIO, lines: queue.SimpleQueue[str]) -> None:
    for line in tasks:
        lines.put(line)
    os._exit(0)  # nobody is there any more


if __name__ == "__main__":
    sys.exit(main())
