"""The web server of a view: viser, an optional package."""

from __future__ import annotations

import contextlib
import io
import logging
from typing import Any

from stark._core import Error, InvalidArgument

_MISSING = "a live view needs the packages of the extra 'view': pip install 'stark-sim[view]'"


def open_server(host: Any, port: Any, title: str) -> Any:
    """A viser server at ``host`` and ``port``, or at the next port that is free. Raises ImportError that
    names the extra when viser is missing, InvalidArgument for an invalid host or port, and stark.Error where
    none can be opened."""
    if not isinstance(host, str) or not host:
        raise InvalidArgument(f"view: host = {host!r}: must be a name or address, such as '127.0.0.1'")
    if isinstance(port, bool) or not isinstance(port, int) or not 1 <= port <= 65535:
        raise InvalidArgument(f"view: port = {port!r}: must be a whole number from 1 to 65535")
    try:
        import viser
    except ImportError as error:
        raise ImportError(_MISSING) from error
    logging.getLogger("websockets").setLevel(logging.CRITICAL)  # browsers that go away are no news
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # it greets
            return viser.ViserServer(host=host, port=port, label=title, verbose=False)
    except OSError as error:
        raise Error(
            f"view: no server can be opened at {host}:{port}: {error}; choose another port"
        ) from error


def close_server(server: Any) -> None:
    """Ends it and its threads."""
    with contextlib.redirect_stdout(io.StringIO()):  # it says goodbye
        server.stop()


def address(server: Any) -> str:
    """What a browser is given."""
    host = server.get_host()
    shown = "127.0.0.1" if host in ("0.0.0.0", "::") else host
    return f"http://{shown}:{server.get_port()}"
