"""What the command says. Names and messages may come from files of others: nothing that a terminal obeys gets
out, and one call is one line."""

from __future__ import annotations

import sys
from pathlib import Path

from ..files import printable


def say(text: object = "", *, error: bool = False, flush: bool = False) -> None:
    """Prints a line, to the standard error output with ``error``; at once with ``flush``. Nothing where the
    stream is closed."""
    line = "\\n".join(printable(str(text)).split("\n"))
    stream = sys.stderr if error else sys.stdout
    if stream is None:
        return
    try:
        print(line, file=stream, flush=flush)
    except BrokenPipeError:  # nobody reads on
        raise
    except OSError as found:
        from ..array_file import naming

        with naming(Path(stream.name)):
            raise found


def complain(message: object) -> None:
    """Prints what went wrong, on one line."""
    say(f"stark: {' '.join(str(message).split())}", error=True)
