"""What can be wrong with a scene document."""

from stark._core import InvalidArgument


class DocumentError(InvalidArgument):
    """A scene that cannot be saved, or a scene document that cannot be read: names the file, the place in
    it, the value, the rule and the remedy."""
