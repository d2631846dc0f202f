"""``replay.html``: one self-contained page that replays a recording in any browser, offline.

The page holds the viewer (our own WebGL2 code, ``viewer.js``), the motion of all bodies, quantised and
compressed, and the telemetry of every step. It opens from disk and makes no network request.
"""

from .encode import EncodedReplay, decode, encode
from .inline import InlinePage, show
from .page import write_page

__all__ = ["EncodedReplay", "InlinePage", "decode", "encode", "show", "write_page"]
