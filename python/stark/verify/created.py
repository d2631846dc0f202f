"""Energy that integration created: what the steps took to close their balance, of the sign that no
dissipation has.

Of each step the solver reports as ``numerical`` what is left of the balance, positive where the step lost
energy. Steps of implicit Euler lose, for stored energies that are convex along the way; bdf2 takes and gives
back. So what counts is the most that is created between any two times, net of what is lost between them, next
to the largest energy that the scene stores or turns over. What the tolerance of joints lets the weight of
the bodies do is left out: within it, a body that rests is carried up and down."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .run import Run, number

#: Beyond this share of the largest energy, motion is no more that of the scene: an amplitude grows by half of
#: it. Runs of the tests with implicit Euler stay below 2 %, most of them below 0.01 %.
CREATED_SHARE = 0.05
_STORED = ("kinetic", "elastic", "contact")  # gravity has no zero: its range counts
_TURNED_OVER = ("external", "actuation", "damping", "friction", "restitution", "belts", "placed")

Floats = NDArray[np.float64]


class Created(NamedTuple):
    """Energies [J] of a run: sums of ``numerical`` by sign, the most that was created from ``begin`` to
    ``end`` [s], net of losses, and the largest energy that was stored or turned over."""

    created: float
    dissipated: float
    net: float
    begin: float
    end: float
    largest: float
    allowed: float  # explained by the tolerance of joints

    @property
    def is_much(self) -> bool:
        """Whether it belongs to the limits of a certificate."""
        return self.net > CREATED_SHARE * self.largest + self.allowed

    def limit(self) -> str:
        """As a certificate says it."""
        share = 100.0 * self.net / self.largest if self.largest > 0.0 else math.inf
        return (
            f"integration created {self.net:.3g} J from {self.begin:.6g} s to {self.end:.6g} s, {share:.3g} "
            f"% of the largest energy that was stored or turned over, {self.largest:.3g} J: what moves by it "
            f"is not of the scene; compare a run with smaller steps"
        )

    def text(self) -> str:
        """As the claim says it."""
        return f"integration created {self.created:.3g} J and dissipated {self.dissipated:.3g} J"


def created_energy(run: Run) -> Created | None:
    """None for a run without energies, or with impossible ones."""
    rows = [row["energy"] for row in run.rows if isinstance(row.get("energy"), dict)]
    if not rows or len(rows) != len(run.rows):
        return None
    numerical = _series(rows, "numerical")
    stored = [float(_series(rows, name).max()) for name in _STORED]
    gravity = _series(rows, "gravity")
    turned = [float(np.abs(_series(rows, name)).sum()) for name in _TURNED_OVER]
    largest = max(*stored, float(np.ptp(gravity)), *turned)
    if not (np.isfinite(numerical).all() and math.isfinite(largest)):
        return None
    lost = np.concatenate(([0.0], np.cumsum(numerical)))  # until the start, and the end of each step
    gained = np.maximum.accumulate(lost) - lost
    end = int(gained.argmax())
    begin = int(lost[: end + 1].argmax())
    times = [number(run.rows[0], "time") - number(run.rows[0], "time_step")]
    times += [number(row, "time") for row in run.rows]
    created = -float(numerical[numerical < 0.0].sum()) or 0.0
    dissipated = float(numerical[numerical > 0.0].sum())
    return Created(
        created, dissipated, float(gained[end]), times[begin], times[end], largest, _explained(run)
    )


def _series(rows: list[dict[str, Any]], name: str) -> Floats:
    """One energy of all steps; those that older versions do not name are 0, those that are no number NaN."""
    return np.array([number(row, name) if name in row else 0.0 for row in rows], dtype=np.float64)


def _explained(run: Run) -> float:
    """Weight of the bodies over the tolerance of joints [J]."""
    gravity, tolerance = run.settings.get("gravity"), run.bound("joints.length_tolerance")
    if not run.has_states or tolerance is None or not isinstance(gravity, list):
        return 0.0
    masses = [float(body.masses.sum()) for body in run.bodies if body.masses is not None]
    masses += [float(body.inertia["mass"]) for body in run.bodies if isinstance(body.inertia, dict)]
    explained = math.fsum(masses) * math.hypot(*gravity) * tolerance
    return explained if math.isfinite(explained) else 0.0
