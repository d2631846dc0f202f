"""What can be wrong with a checkpoint."""

from stark._core import InvalidArgument


class CheckpointError(InvalidArgument):
    """A checkpoint that cannot be read, or not be loaded into this simulation: names file, defect and
    remedy."""
