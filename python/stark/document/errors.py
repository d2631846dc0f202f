"""What can be wrong with a scene document."""

from stark._core import InvalidArgument
from stark.files import printable

#: Longest text of an error that is shown whole [characters].
_LONGEST = 2000


class DocumentError(InvalidArgument):
    """A scene that cannot be saved, or a scene document that cannot be read: names the file, the place in
    it, the value, the rule and the remedy."""


def told(error: Exception) -> str:
    """Text of an error about a document, fit for a terminal. Damaged names may have any length: of what is
    too long to read the middle is left out."""
    text = printable(str(error))
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]} ... {text[-_LONGEST // 2 :]}"
