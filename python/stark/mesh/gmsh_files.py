"""Numbers of nodes in text files of Gmsh (.msh). meshio reads the files; it takes the number 0 for the node
with the largest number, of two nodes with one number the last, and of an element that is cut off its tags for
nodes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from stark._core import InvalidMesh

#: A line of the file, from 0, and the numbers of nodes in it.
_Row = tuple[int, list[int]]
_RULE = "Gmsh numbers nodes from 1, and so must elements name them; write the file anew"


def require_numbers(file: Path) -> None:
    """That each node has a number of its own, from 1 on, and that elements name such numbers. Binary files,
    and damaged ones, are left to meshio."""
    try:
        lines = [line.strip() for line in file.read_bytes().decode("latin-1").splitlines()]
        nodes, elements = _rows(lines)
    except (OSError, ValueError, LookupError):
        return
    if elements and "$EndElements" not in lines:
        raise InvalidMesh(f"'{file}': $Elements has no end: the file was cut off, write it anew")
    found: dict[int, int] = {}
    for line, (number,) in nodes:
        if number < 1:
            raise InvalidMesh(f"'{file}': line {line + 1}: a node has the number {number}: {_RULE}")
        if number in found:
            raise InvalidMesh(
                f"'{file}': line {line + 1}: a node has the number {number}, as that of line "
                f"{found[number] + 1}: each must have its own; write the file anew"
            )
        found[number] = line
    for line, numbers in elements:
        if min(numbers, default=1) < 1:
            raise InvalidMesh(f"'{file}': line {line + 1}: an element names node {min(numbers)}: {_RULE}")


def _rows(lines: list[str]) -> tuple[list[_Row], list[_Row]]:
    """Of nodes and of elements."""
    version, is_binary = lines[_start(lines, "$MeshFormat")].split()[:2]
    readers: dict[str, Callable[[list[str]], tuple[list[_Row], list[_Row]]]] = {"2": _old, "4.1": _new}
    reader = readers.get(version) or readers.get(version.split(".")[0])
    return ([], []) if reader is None or is_binary != "0" else reader(lines)


def _start(lines: list[str], name: str) -> int:
    """The line behind the title of a section."""
    return lines.index(name) + 1


def _old(lines: list[str]) -> tuple[list[_Row], list[_Row]]:
    """Format 2: a node is its number and its place; an element is its number, type, tags and nodes."""
    first = _start(lines, "$Nodes")
    nodes = [(k, [int(lines[k].split()[0])]) for k in range(first + 1, first + 1 + int(lines[first]))]
    first = _start(lines, "$Elements")
    elements = []
    for k in range(first + 1, first + 1 + int(lines[first])):
        words = lines[k].split()
        elements.append((k, [int(word) for word in words[3 + int(words[2]) :]]))
    return nodes, elements


def _new(lines: list[str]) -> tuple[list[_Row], list[_Row]]:
    """Format 4.1: blocks, each with its size behind three other numbers. Of nodes they have all numbers and
    then all places, of elements a line for each, with its number and its nodes."""
    nodes: list[_Row] = []
    elements: list[_Row] = []
    for name, rows, size in (("$Nodes", nodes, 2), ("$Elements", elements, 1)):
        at = _start(lines, name)
        blocks, at = int(lines[at].split()[0]), at + 1
        for _ in range(blocks):
            count = int(lines[at].split()[3])
            skipped = 1 if name == "$Elements" else 0
            for k in range(at + 1, at + 1 + count):
                rows.append((k, [int(word) for word in lines[k].split()[skipped:]]))
            at += 1 + size * count
    return nodes, elements
