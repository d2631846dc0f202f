"""A law that remembers, and settings for closed forms, that several tests share."""

from __future__ import annotations

from typing import Any

import stark

#: Equilibria to 1e-10 N.
EQUILIBRIA: dict[str, Any] = {
    "contact.enabled": False,
    "time.integrator": "quasistatic",
    "newton.acceleration_tolerance": 0.0,
    "newton.residual_tolerance": 1e-10,
}


@stark.material
def maxwell(
    F: stark.DeformationGradient,
    h: stark.TimeStep,
    modulus: float = stark.parameter(unit="Pa", above=0.0),
    branch: float = stark.parameter(unit="Pa", above=0.0),
    relaxation: float = stark.parameter(unit="s", above=0.0),
    flow: stark.Mat3 = stark.internal(0.0, doc="strain of the dashpot"),
) -> Any:
    """A spring beside a spring and a dashpot in a row, in Green strains; implicit Euler for the dashpot."""
    E = 0.5 * (F.T @ F - stark.identity(3))
    ratio = h / relaxation
    trial = E - flow
    psi = modulus * stark.squared_norm(E) + branch / (1 + ratio) * stark.squared_norm(trial)
    return psi, {"flow": flow + ratio / (1 + ratio) * trial}
