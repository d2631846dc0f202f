"""What became of a robot file: what is kept, what is dropped, what is suspicious."""

from __future__ import annotations

from dataclasses import dataclass, field

from stark.attributes import AnsweredAttributes

KINDS = ("kept", "assumed", "dropped", "suspicious")


@dataclass(frozen=True)
class Finding:
    """One line of a report: its ``kind`` ("kept", "assumed", "dropped" or "suspicious"), which part of the
    file it is about, and what was found."""

    kind: str
    part: str
    text: str

    def __str__(self) -> str:
        return f"{self.part}: {self.text}"


@dataclass(repr=False)
class Report(AnsweredAttributes):
    """Findings of reading and building a robot, to be printed: ``print(robot.report)``."""

    source: str
    """The file, or the name of the description."""
    findings: list[Finding] = field(default_factory=list)
    warnings: list[Finding] = field(default_factory=list)
    """Those of which adding the robot warns, too: of parts without which it is another robot."""

    def add(self, kind: str, part: str, text: str, *, warn: bool = False) -> None:
        """Adds a finding, once."""
        finding = Finding(kind, part, text)
        if finding not in self.findings:
            self.findings.append(finding)
            if warn:
                self.warnings.append(finding)

    def of(self, kind: str) -> tuple[Finding, ...]:
        """Findings of one kind, in the order in which they were made."""
        return tuple(finding for finding in self.findings if finding.kind == kind)

    @property
    def kept(self) -> tuple[Finding, ...]:
        """Parts of the file that the scene has: findings with ``part`` and ``text``."""
        return self.of("kept")

    @property
    def assumed(self) -> tuple[Finding, ...]:
        """Values that the file leaves out, and what was assumed: findings with ``part`` and ``text``."""
        return self.of("assumed")

    @property
    def dropped(self) -> tuple[Finding, ...]:
        """Parts of the file that the scene leaves out, and why: findings with ``part`` and ``text``."""
        return self.of("dropped")

    @property
    def suspicious(self) -> tuple[Finding, ...]:
        """What is taken as the file says it, but is hardly meant so."""
        return self.of("suspicious")

    def copy(self) -> Report:
        """A report with the same findings, to which others may be added."""
        return Report(self.source, list(self.findings), list(self.warnings))

    def __repr__(self) -> str:
        return f"<stark.robots.Report of {self.source}: {len(self.findings)} findings>"

    def __str__(self) -> str:
        lines = [f"robot from {self.source}"]
        for kind in KINDS:
            found = self.of(kind)
            lines += [f"  {kind} ({len(found)}):"] if found else []
            lines += [f"    {finding}" for finding in found]
        return "\n".join(lines)
