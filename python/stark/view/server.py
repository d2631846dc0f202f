"""The web server of a view: viser, an optional package."""

from __future__ import annotations

import contextlib
import errno
import io
import logging
import socket
from typing import Any

from stark._core import Error, InvalidArgument

_MISSING = "a live view needs the packages of the extra 'view': pip install 'stark-sim[view]'"

_THIS_MACHINE = "'127.0.0.1' for this machine only, '0.0.0.0' for the whole network"

#: Ports that are tried.
_MOST_PORTS = 1000


def open_server(host: Any, port: Any, title: str) -> Any:
    """A viser server at ``host`` and ``port``, or at the next port that is free. Raises ImportError that
    names the extra when viser is missing, InvalidArgument for an invalid host or port or a host of another
    machine, and stark.Error where none can be opened."""
    if not isinstance(host, str) or not host:
        raise InvalidArgument(f"view: host = {host!r}: must be a name or address, such as '127.0.0.1'")
    if isinstance(port, bool) or not isinstance(port, int) or not 1 <= port <= 65535:
        raise InvalidArgument(f"view: port = {port!r}: must be a whole number from 1 to 65535")
    try:
        import viser
    except ImportError as error:
        raise ImportError(_MISSING) from error
    place, free = _free_place(host, port)
    logging.getLogger("websockets").setLevel(logging.CRITICAL)  # browsers that go away are no news
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # it greets
            return viser.ViserServer(host=place, port=free, label=title, verbose=False)
    except OSError as error:
        raise Error(
            f"view: no server can be opened at {host}:{free}: {error}; choose another port"
        ) from error


def _free_place(host: str, port: int) -> tuple[str, int]:
    """``host``, or its first address that this machine has if it lacks others, and ``port`` or the next one
    that is free there. The server waits without end for a place that it cannot have."""
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    except (OSError, UnicodeError) as error:
        raise InvalidArgument(
            f"view: host = {host!r}: must be a name or address of this machine: {error}; take {_THIS_MACHINE}"
        ) from error
    places = [(family, address) for family, _, _, _, address in found]
    last = min(port + _MOST_PORTS, 65536)
    for candidate in range(port, last):
        try:
            can = [_can_bind(family, address, candidate) for family, address in places]
            if not any(can):
                raise InvalidArgument(
                    f"view: host = {host!r}: must be an address of this machine; take {_THIS_MACHINE}"
                )
        except OSError:  # another program has it, or it is not for everybody
            continue
        return host if all(can) else str(places[can.index(True)][1][0]), candidate
    raise Error(f"view: no port from {port} to {last - 1} is free at {host}: choose another port")


def _can_bind(family: int, place: Any, port: int) -> bool:
    """Whether the machine has this address. Raises OSError where the port is taken."""
    try:
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if family == socket.AF_INET6:
                probe.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
            probe.bind((place[0], port, *place[2:]))
            probe.listen(1)
    except OSError as error:
        if error.errno in (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT):
            return False
        raise
    return True


def close_server(server: Any) -> None:
    """Ends it and its threads."""
    with contextlib.redirect_stdout(io.StringIO()):  # it says goodbye
        server.stop()


def address(server: Any) -> str:
    """What a browser is given."""
    host = str(server.get_host())
    host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    shown = f"[{host}]" if ":" in host else host
    return f"http://{shown}:{server.get_port()}"
