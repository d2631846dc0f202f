"""Ctrl-C and the command ``stark``: whenever it comes, the command ends in one line with exit code 130, and
what must stay whole is whole. A program that imports stark keeps its own handling of signals."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from types import FrameType, TracebackType
from typing import Any

EXIT_INTERRUPTED = 130

#: Signals that end a run.
_ENDS = (signal.SIGINT, signal.SIGTERM)

#: Within this time of the first, further signals are the same one again: terminals and the programs between
#: send it twice [s].
_SAME = 1.0

_told = False


def tell(what: str = "interrupted") -> None:
    """The one line that says it."""
    global _told
    if not _told:
        _told = True
        print(f"stark: {what}", file=sys.stderr, flush=True)


def forget_unhandled() -> None:
    """Where Ctrl-C comes while Python executes a string, as for each dataclass of an import, CPython keeps an
    unhandled KeyboardInterrupt in mind and ends the process by the signal at last, although it was handled.
    Executing another string resets that."""
    exec("")


def _leave(number: int = signal.SIGINT, frame: FrameType | None = None) -> None:
    if not _told:
        os.write(2, b"stark: interrupted\n")  # print() may be what it interrupts
    os._exit(EXIT_INTERRUPTED)


def _is_command() -> bool:
    words = sys.orig_argv
    as_module = sys.argv[:1] == ["-m"] and "-m" in words and words[words.index("-m") + 1 :][:1] == ["stark"]
    return as_module or os.path.basename(sys.argv[0] if sys.argv else "") == "stark"


#: Whether this process is ``stark`` or ``python -m stark``, and not a program that imports it. What tells is
#: there only while the package is imported.
IS_COMMAND = _is_command()


def leave_while_starting() -> None:
    """Until the command is up there is nothing to finish, and an exception would end in a traceback out of
    the middle of an import."""
    if IS_COMMAND and _in_main_thread() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


class RaisedOnce:
    """While it is open, the first Ctrl-C raises KeyboardInterrupt; another one, while what was run is being
    saved, leaves at once. Signals that were ignored stay so (``nohup``)."""

    _depth = 0
    _first: float | None = None  # when the first came [s], of all that are open

    def __init__(self, *numbers: int) -> None:
        self._numbers = numbers
        self._before: dict[int, Any] = {}
        self._report = sys.unraisablehook

    def __enter__(self) -> RaisedOnce:
        global _told
        if RaisedOnce._depth == 0:
            RaisedOnce._first, _told = None, False
        RaisedOnce._depth += 1
        if _in_main_thread():
            sys.unraisablehook = self._unraisable
            for number in self._numbers:
                if signal.getsignal(number) != signal.SIG_IGN:
                    self._before[number] = signal.signal(number, self._raise)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        over = RaisedOnce._first is not None and IS_COMMAND
        for number, handler in self._before.items():
            is_inner = getattr(handler, "__func__", None) is RaisedOnce._raise
            # What is left of an interrupted command is to exit with its code: the same signal again, which
            # ends a process that has no handler, would change that.
            signal.signal(number, signal.SIG_IGN if over and not is_inner else handler)
        sys.unraisablehook = self._report
        RaisedOnce._depth -= 1

    def _raise(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if RaisedOnce._first is None:
            RaisedOnce._first = now
            raise KeyboardInterrupt
        if now - RaisedOnce._first > _SAME:
            _leave()

    def _unraisable(self, problem: Any) -> None:
        """Raised where nothing can be, as in ``__del__``, it would be lost."""
        if issubclass(problem.exc_type, KeyboardInterrupt):
            _leave()
        self._report(problem)


class Deferred:
    """While it is open, signals that end a run wait: what it does is done whole or not begun."""

    def __init__(self) -> None:
        self._before: dict[int, Any] = {}
        self._came: list[int] = []

    def __enter__(self) -> Deferred:
        if _in_main_thread():
            for number in _ENDS:
                if callable(signal.getsignal(number)):
                    self._before[number] = signal.signal(number, lambda n, frame: self._came.append(n))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        if self._came:
            signal.raise_signal(self._came[0])
