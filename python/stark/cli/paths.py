"""Paths as words of a command line."""

from __future__ import annotations

import argparse
from pathlib import Path

from .._core import InvalidArgument
from ..arguments import given_path


def path_argument(text: str) -> Path:
    """A path for argparse; an empty word is none, and not the current folder."""
    try:
        return given_path(text, "path")
    except InvalidArgument as error:
        raise argparse.ArgumentTypeError(str(error)) from None
