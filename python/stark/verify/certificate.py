"""Claims about a recorded run, and the certificate that lists them."""

from __future__ import annotations

import json
import math
import os
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from .files import printable

CERTIFICATE_VERSION = 1

#: Claims of the checker end as one of these.
VERIFIED, VIOLATED = "verified", "violated"
INCONCLUSIVE = "inconclusive"  # looked at, neither shown nor refuted
NOT_RECORDED = "not recorded"  # the recording lacks what is needed
NOT_APPLICABLE = "not applicable"  # there is nothing of the kind in the scene

#: Basis of claims about numbers that the solver reported and no state can confirm.
AS_REPORTED = "telemetry, as the solver reported it"

#: Exit codes of ``stark verify``; 2 is for recordings that cannot be read.
EXIT_CERTIFIED, EXIT_VIOLATED, EXIT_UNREADABLE, EXIT_INCONCLUSIVE = 0, 1, 2, 3


def comparable(share: float) -> float:
    """A share of what is allowed; infinite for NaN, which nothing allows."""
    return math.inf if math.isnan(share) else share


@dataclass(frozen=True)
class Claim:
    """One statement about all accepted steps of a run.

    ``worst`` is the value nearest to the bound ``tolerance``, or beyond it, in ``unit``, and ``where`` it
    occurs; ``basis`` is what the statement rests on: states that were checked, or what the solver reported.
    ``required`` claims must hold for a certificate; the others compare what the solver reported with what
    follows from the states, and count only when they are violated."""

    name: str
    statement: str
    status: str
    basis: str
    worst: float | None = None
    tolerance: float | None = None
    unit: str = "1"
    where: dict[str, Any] | None = None
    detail: str = ""
    required: bool = True

    def to_json(self) -> dict[str, Any]:
        """The claim as the certificate has it: a dictionary."""
        return {key: _finite(value) for key, value in asdict(self).items()}


@dataclass(frozen=True)
class Certificate:
    """What a check of a recording came to. ``limits`` name what the claims leave out: pairs that were not
    looked at, loose tolerances, an end or a chain that is not recorded."""

    recording: dict[str, Any]
    tools: dict[str, str]
    claims: tuple[Claim, ...]
    limits: tuple[str, ...] = ()
    seconds: float = field(default=0.0, compare=False)

    @property
    def verdict(self) -> str:
        """``violated`` when any claim is; ``certified`` when all required ones are verified or have nothing
        to be about; else ``inconclusive``."""
        if any(claim.status == VIOLATED for claim in self.claims):
            return "violated"
        good = all(c.status in (VERIFIED, NOT_APPLICABLE) for c in self.claims if c.required)
        return "certified" if good else "inconclusive"

    @property
    def taken_as_reported(self) -> tuple[str, ...]:
        """Names of the verified claims that rest on reported numbers alone. The numbers agree with each other
        and with the settings; no state of the recording shows that the solver reported them truly."""
        return tuple(c.name for c in self.claims if c.status == VERIFIED and c.basis == AS_REPORTED)

    @property
    def exit_code(self) -> int:
        """Exit code of ``stark verify``: 0 certified, 1 violated, 3 inconclusive."""
        codes = {"certified": EXIT_CERTIFIED, "violated": EXIT_VIOLATED, "inconclusive": EXIT_INCONCLUSIVE}
        return codes[self.verdict]

    def __getitem__(self, name: str) -> Claim:
        """The claim of a name."""
        for claim in self.claims:
            if claim.name == name:
                return claim
        raise KeyError(f"no claim '{name}'; there are: {', '.join(claim.name for claim in self.claims)}")

    def to_json(self) -> dict[str, Any]:
        """The certificate as its JSON file has it: a dictionary."""
        return {
            "format": "stark-certificate",
            "version": CERTIFICATE_VERSION,
            "verdict": self.verdict,
            "recording": _finite(self.recording),
            "tools": self.tools,
            "seconds": round(self.seconds, 3),
            "claims": [claim.to_json() for claim in self.claims],
            "limits": list(self.limits),
            "taken_as_reported": list(self.taken_as_reported),
        }

    def write(self, path: Path) -> None:
        """Writes the certificate as JSON. A file is replaced, and so is a link; what it leads to stays."""
        text = json.dumps(self.to_json(), indent=1, allow_nan=False) + "\n"
        temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
        try:
            temporary.unlink(missing_ok=True)
            with open(temporary, "x", encoding="utf-8") as file:
                file.write(text)
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)

    def text(self) -> str:
        """The certificate for reading, a line or two for each claim."""
        count = len(self.limits)
        limited = f", with {count} limit{'s' if count > 1 else ''}" if count else ""
        name = self.recording["scene"] or "recording"
        lines = [f"{name}: {self.verdict}{limited} ({self.recording['steps']} steps)"]
        for claim in self.claims:
            lines.append(f"  {claim.status:14} {claim.name}: {claim.statement}{_measured(claim)}")
            if claim.detail:
                lines.append(f"{'':17}{claim.detail}")
        lines += [f"  {'limit':14} {limit}" for limit in self.limits]
        if self.taken_as_reported:
            names = ", ".join(self.taken_as_reported)
            lines.append(f"  {'as reported':14} {names}: numbers of the solver that no state can confirm")
        return "\n".join(printable(line) for line in lines)


def _measured(claim: Claim) -> str:
    if claim.worst is None:
        return ""
    unit, bound = "" if claim.unit == "1" else f" {claim.unit}", ""
    if claim.tolerance is not None:
        is_floor = (claim.worst > claim.tolerance) == (claim.status == VERIFIED)
        bound = f", must be at {'least' if is_floor else 'most'} {claim.tolerance:.4g}{unit}"
    at = (claim.where or {}).get("time")
    return f": {claim.worst:.4g}{unit}{bound}" + ("" if at is None else f" at {at:.6g} s")


def _finite(value: Any) -> Any:
    """JSON knows no infinite numbers: they become null."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
