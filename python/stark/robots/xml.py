"""XML files, and what is said of those that are none."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from stark._core import InvalidArgument


def parsed(file: Path) -> ElementTree.Element:
    """The root of an XML file. Raises InvalidArgument with the file, line and rule."""
    try:
        return ElementTree.parse(file).getroot()
    except ElementTree.ParseError as error:
        raise not_xml(file, error) from None


def not_xml(file: Path, error: ElementTree.ParseError) -> InvalidArgument:
    """What to raise for a file that breaks off or has tags that do not match."""
    return InvalidArgument(f"'{file}': {error}: must be XML; xacro files have to be expanded first")
