"""What was done to a mesh: typed, to be printed."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class MeshChange:
    """One thing that was done: ``what``, to how many (``count``), in words (``text``)."""

    what: str
    count: int
    text: str

    def __str__(self) -> str:
        return f"{self.what}: {self.text}"


@dataclass
class MeshReport:
    """Changes in the order in which they were made: ``print(report)``."""

    changes: list[MeshChange] = field(default_factory=list)

    def add(self, what: str, count: int, text: str) -> None:
        """Adds a change of ``count`` parts; nothing where there were none."""
        if count:
            self.changes.append(MeshChange(what, count, text))

    def count(self, what: str) -> int:
        """How many parts all changes of one kind were made to; 0 where there were none."""
        return sum(change.count for change in self.changes if change.what == what)

    def __str__(self) -> str:
        lines = [str(change) for change in self.changes] or ["nothing was changed"]
        return "\n".join(["mesh", *(f"  {line}" for line in lines)])
