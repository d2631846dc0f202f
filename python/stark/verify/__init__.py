"""An independent checker: what is certain about a recorded run, found without the code that computed it.

``stark.verify.verify(folder)`` gives a Certificate; ``stark verify`` on the command line writes it. The
modules here import NumPy, the standard library and each other, nothing else of Stark, and run without its
compiled core: ``python path/to/stark/verify RUN``. docs/verify.md says what is claimed and what is not."""

from .certificate import Certificate, Claim
from .check import verify
from .files import UnreadableRecording

__all__ = ["Certificate", "Claim", "UnreadableRecording", "verify"]
