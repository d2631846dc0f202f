"""Warnings of Stark. Its exceptions are made in the core."""


class StarkWarning(UserWarning):
    """Something that can be simulated but is probably not meant."""
