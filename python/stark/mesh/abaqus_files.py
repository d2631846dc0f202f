"""Sets and surfaces of input files of Abaqus (.inp). meshio reads the nodes and elements; it takes sets of
several blocks of elements for others, does not read sets of numbers and names, and knows no surfaces."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidMesh

#: Corners of the faces S1, S2, ... of solids, by the beginning of meshio's name of the element.
_FACES: dict[str, tuple[tuple[int, ...], ...]] = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
}
#: Ends of the edges with a node in their middle, in the order of these nodes.
_EDGES: dict[str, tuple[tuple[int, int], ...]] = {
    "tetra10": ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)),
    "hexahedron20": (
        *((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6)),
        *((6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
    ),
}


#: Keywords that make or move nodes and elements which the file does not write out.
_NOT_READ = ("SYSTEM", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY")


class Section(NamedTuple):
    """A keyword of the file with its parameters and lines of data."""

    keyword: str
    parameters: dict[str, str]
    lines: list[list[str]]
    """The entries of each."""


def sections_of(file: Path) -> list[Section]:
    """All of a file and of those that it includes. InvalidMesh for several parts or instances, of which
    meshio would keep the nodes of the last, and for nodes in several blocks."""
    found: list[Section] = []
    for text in _lines_of(file):
        if text.startswith("*"):
            found.append(_keyword_of(text))
        elif found:
            found[-1].lines.append([entry.strip() for entry in text.split(",") if entry.strip()])
    _refuse_others(found, file)
    return found


def _lines_of(file: Path, includers: tuple[Path, ...] = ()) -> Iterator[str]:
    """Without comments, those of a keyword as one; in their places the lines of files that *INCLUDE names,
    and INPUT= as the data of another keyword."""
    try:
        lines = file.read_text(errors="replace").splitlines()
    except OSError as error:
        by = f", which '{includers[-1]}' includes" if includers else ""
        raise InvalidMesh(f"'{file}'{by}: {error.strerror or error}: must be a readable mesh file") from None
    begun = ""
    for line in lines:
        text = line.strip()
        if not text or text.startswith("**"):
            continue
        begun, text = "", begun + text
        if text.startswith("*") and text.endswith(","):
            begun = text
            continue
        yield from _with_included(text, file, includers)
    if begun:
        yield from _with_included(begun, file, includers)


def _with_included(text: str, file: Path, includers: tuple[Path, ...]) -> Iterator[str]:
    section = _keyword_of(text) if text.startswith("*") else None
    if section is None or section.keyword != "INCLUDE":
        yield text
    if section is None or not (name := section.parameters.get("INPUT", "")):
        return
    included = file.parent / name
    if included in (chain := (*includers, file)):
        raise InvalidMesh(f"'{file}' includes '{included}', which includes it: files must not go in circles")
    yield from _lines_of(included, chain)


def _keyword_of(text: str) -> Section:
    """Of its line, without data."""
    keyword, *entries = (entry.strip() for entry in text.lstrip("*").split(","))
    section = Section(" ".join(keyword.upper().split()), {}, [])
    for entry in filter(None, entries):
        name, _, value = entry.partition("=")
        section.parameters[name.strip().upper()] = value.strip().strip('"')
    return section


def _refuse_others(sections: Sequence[Section], file: Path) -> None:
    """InvalidMesh for what would be read as another mesh."""
    for keyword, what in (
        ("NODE", "blocks of nodes (*NODE)"),
        ("INSTANCE", "instances of parts (*INSTANCE)"),
    ):
        if (count := sum(section.keyword == keyword for section in sections)) > 1:
            raise InvalidMesh(
                f"'{file}' has {count} {what}: must have one; write each part to a file of its own, with all "
                f"of its nodes in one block"
            )
    for section in sections:
        if section.keyword in _NOT_READ:
            raise InvalidMesh(
                f"'{file}' has *{section.keyword}, which is not read: must have nodes and elements written "
                f"out, in Cartesian coordinates"
            )
        if section.keyword == "NODE" and section.parameters.get("SYSTEM", "R").upper() != "R":
            raise InvalidMesh(f"'{file}': *NODE, SYSTEM={section.parameters['SYSTEM']}: must be Cartesian, R")


def cells_of(sections: Sequence[Section]) -> io.StringIO:
    """The nodes and elements of a file, for meshio."""
    lines = []
    for section in sections:
        if section.keyword in ("NODE", "ELEMENT"):
            kind = section.parameters.get("TYPE", "").upper()
            lines.append(f"*{section.keyword}" + (f", TYPE={kind}" if kind else ""))
            lines += [", ".join(line) for line in section.lines]
    return io.StringIO("\n".join(lines) + "\n")


def name_parts(read: Any, sections: Sequence[Section], file: Path) -> None:
    """Gives a mesh of meshio the sets and surfaces of the file. A surface that is called as a set is called
    "NAME surface"."""
    try:
        parts = _Parts(read, sections, file)
    except (ValueError, IndexError) as error:
        raise InvalidMesh(f"'{file}': its sets cannot be read ({error}): must be numbers and names") from None
    read.point_sets = {parts.spelling[name]: np.array(rows) for name, rows in parts.nodes.items()}
    read.cell_sets = {parts.spelling[name]: parts.by_block(rows) for name, rows in parts.elements.items()}
    for name, points in parts.surfaces():
        taken = name in read.point_sets or name in read.cell_sets
        read.point_sets[f"{name} surface" if taken else name] = points


class _Parts:
    """Sets of a file, their names in lower case: Abaqus does not tell cases apart."""

    def __init__(self, read: Any, sections: Sequence[Section], file: Path) -> None:
        self._read, self._sections, self._file = read, sections, file
        self._node: dict[int, int] = {}  # number in the file -> row
        self._element: dict[int, tuple[int, int]] = {}  # number in the file -> block, row
        self.spelling: dict[str, str] = {}
        self.nodes: dict[str, list[int]] = {}
        self.elements: dict[str, list[tuple[int, int]]] = {}
        block = 0
        for section in sections:
            if section.keyword == "NODE":
                numbers = [int(line[0]) for line in section.lines]
                self._node |= {number: row for row, number in enumerate(numbers)}
                self._add(self.nodes, section, "NSET", list(self._node.values()))
            elif section.keyword == "ELEMENT":
                self._add(self.elements, section, "ELSET", self._number(section, block))
                block += 1
            elif section.keyword == "NSET":
                self._add(self.nodes, section, "NSET", list(self._nodes_of(section)))
            elif section.keyword == "ELSET":
                self._add(
                    self.elements, section, "ELSET", self._members(section, self._element, self.elements)
                )

    def by_block(self, rows: Sequence[tuple[int, int]]) -> list[NDArray[np.int64]]:
        """Rows in each block of the mesh."""
        found: list[list[int]] = [[] for _ in self._read.cells]
        for block, row in rows:
            found[block].append(row)
        return [np.unique(np.array(each, dtype=np.int64)) for each in found]

    def surfaces(self) -> Iterator[tuple[str, NDArray[np.int64]]]:
        """Names and points of surfaces of faces or nodes."""
        for section in self._sections:
            kind = section.parameters.get("TYPE", "ELEMENT").upper()
            if section.keyword != "SURFACE" or "COMBINE" in section.parameters:
                continue
            if kind == "NODE":
                rows = self._members(section, self._node, self.nodes, width=1)
                yield section.parameters.get("NAME", "surface"), np.unique(rows)
            elif kind == "ELEMENT":
                points = [self._face(*each) for line in section.lines for each in self._faces_of(line)]
                yield (
                    section.parameters.get("NAME", "surface"),
                    np.unique(np.concatenate(points)) if points else np.zeros(0, dtype=np.int64),
                )

    def _number(self, section: Section, block: int) -> list[tuple[int, int]]:
        """Elements of a block, each a number and its nodes, on one line or several."""
        width = self._read.cells[block].data.shape[1] + 1
        numbers = [int(entry) for line in section.lines for entry in line][::width]
        rows = [(block, row) for row in range(len(numbers))]
        self._element |= dict(zip(numbers, rows, strict=True))
        return rows

    def _add(self, sets: dict[str, Any], section: Section, parameter: str, members: list[Any]) -> None:
        """Repeated definitions add to a set."""
        if name := section.parameters.get(parameter, ""):
            self.spelling.setdefault(name.lower(), name)
            sets[name.lower()] = sets.get(name.lower(), []) + members

    def _nodes_of(self, section: Section) -> Iterator[int]:
        if "ELSET" not in section.parameters:
            yield from self._members(section, self._node, self.nodes)
            return
        for block, row in self._found(section.parameters["ELSET"], self._element, self.elements):
            yield from self._read.cells[block].data[row]

    def _members(
        self, section: Section, numbers: dict[int, Any], sets: dict[str, list[Any]], width: int | None = None
    ) -> list[Any]:
        """``width``: entries of a line that count."""
        if "GENERATE" in section.parameters:
            found = []
            for line in section.lines:
                first, last, step = (int(entry) for entry in (*line, "1")[:3])
                found += [numbers[n] for n in range(first, last + 1, step) if n in numbers]
            return found
        entries = [entry for line in section.lines for entry in line[:width]]
        return [member for entry in entries for member in self._found(entry, numbers, sets)]

    def _found(self, entry: str, numbers: dict[int, Any], sets: dict[str, list[Any]]) -> list[Any]:
        """Of a number or the name of a set, which may have that of an instance before it."""
        if entry.isdecimal():
            return [numbers[int(entry)]] if int(entry) in numbers else []
        name = entry.strip('"').rpartition(".")[2].lower()
        if name not in sets:
            raise InvalidMesh(
                f"'{self._file}': refers to the set '{entry}': must be one of the file, before it"
            )
        return sets[name]

    def _faces_of(self, line: list[str]) -> Iterator[tuple[int, int, int | None]]:
        """Block, row and number of the faces of a line, None of shells; all free ones where none is named."""
        label = line[1].upper() if len(line) > 1 else ""
        for block, row in self._found(line[0], self._element, self.elements):
            solid = self._solid(block)
            if not solid:
                yield block, row, None
            elif label[:1] == "S" and label[1:].isdecimal() and 1 <= int(label[1:]) <= len(_FACES[solid]):
                yield block, row, int(label[1:]) - 1
            elif label:
                raise InvalidMesh(
                    f"'{self._file}': *SURFACE: face '{label}' of a {solid}: must be S1, S2, ..."
                )
            else:
                yield from (
                    (block, row, k) for k in range(len(_FACES[solid])) if self._is_free(block, row, k)
                )

    def _solid(self, block: int) -> str:
        kind: str = self._read.cells[block].type
        return next((name for name in _FACES if kind.startswith(name)), "")

    def _face(self, block: int, row: int, face: int | None) -> NDArray[np.int64]:
        """Points of a face, those in the middle of its edges among them."""
        nodes: NDArray[np.int64] = self._read.cells[block].data[row]
        if face is None:
            return nodes
        corners = _FACES[self._solid(block)][face]
        edges = _EDGES.get(self._read.cells[block].type, ())
        count = len(nodes) - len(edges)
        middles = [count + k for k, ends in enumerate(edges) if set(ends) <= set(corners)]
        return nodes[[*corners, *middles]]

    @cached_property
    def _uses(self) -> Counter[frozenset[int]]:
        """How many elements have each face, by its corners."""
        found: Counter[frozenset[int]] = Counter()
        for k, cells in enumerate(self._read.cells):
            for corners in _FACES.get(self._solid(k), ()):
                found.update(map(frozenset, cells.data[:, corners].tolist()))
        return found

    def _is_free(self, block: int, row: int, face: int) -> bool:
        """Whether no other element has the face."""
        corners = _FACES[self._solid(block)][face]
        return self._uses[frozenset(self._read.cells[block].data[row][list(corners)].tolist())] == 1
