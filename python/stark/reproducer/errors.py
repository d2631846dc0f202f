"""What can be wrong with a reproducer."""

from stark._core import InvalidArgument


class ReproducerError(InvalidArgument):
    """A reproducer that cannot be written or read: names file, defect and remedy."""
