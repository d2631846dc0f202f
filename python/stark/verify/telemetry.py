"""What the solver reported of its steps: times, unbalanced forces, the energy balance, the sign of
friction."""

from __future__ import annotations

import math
from typing import Any

from .certificate import INCONCLUSIVE, NOT_APPLICABLE, NOT_RECORDED, VERIFIED, VIOLATED, Claim
from .reading import Run

_BASIS = "telemetry, as the solver reported it"
_TIME_ROUNDING = 1e-9  # of a time step
#: Rounding of a balance over the sum of its terms.
_BALANCE_ROUNDING = 1e-10
#: Contact stiffness is chosen anew in each step, and grows with the elasticity of what is deformed. A balance
#: may be off by this many times the contact energy; beyond the second factor no stiffness explains it.
_STIFFNESS_GROWTH, _IMPOSSIBLE_GROWTH = 99.0, 1e4
#: Reported contact energies are those before the last Newton iteration: how far they may be off.
_CONTACT_ERROR = 0.01
_STORED = ("kinetic", "elastic", "gravity", "contact")
_TURNED_OVER = ("external", "actuation", "damping", "friction", "numerical")

Row = dict[str, Any]


def steps_claim(run: Run, broken_states: list[int]) -> Claim:
    """Steps follow each other without gaps, each with its state; ``broken_states`` hold numbers that are not
    finite."""
    name, statement = "steps", "steps follow each other without gaps, each with a finite state"
    problems = [f"state {index} has positions that are not finite" for index in broken_states[:3]]
    time = None
    for k, row in enumerate(run.rows):
        end, h = number(row, "time"), number(row, "time_step")
        if not (math.isfinite(end) and h > 0.0):
            problems.append(f"step {k + 1} has no valid time and time_step")
            break
        if time is not None and abs(end - time - h) > _TIME_ROUNDING * h + 1e-12 * abs(end):
            problems.append(f"step {k + 1} begins at {end - h:.9g} s, the one before ends at {time:.9g} s")
        time = end
    if run.has_states:
        problems += _state_times(run)
    ended = str(run.manifest.get("status", ""))
    detail = "; ".join(problems[:3])
    if not problems and ended != "complete":
        detail = f"the run ended as '{ended}': what is certified ends there"
    status = VIOLATED if problems else VERIFIED
    if not run.rows:
        status, detail = NOT_RECORDED, "there is no accepted step"
    return Claim(name, statement, status, "telemetry and states", detail=detail)


def _state_times(run: Run) -> list[str]:
    """Every accepted step has a state of its time, and there is one before the first."""
    expected, found = len(run.rows) + 1, len(run.times)
    unfinished = run.manifest.get("status") in ("running", "interrupted")
    lost = int(run.manifest.get("chunk_frames", 1))  # a killed run loses its last chunk
    problems = []
    if not (found == expected or (unfinished and abs(found - expected) <= lost)):
        problems.append(
            f"{len(run.rows)} accepted steps, but {found} states; one more state than steps is needed"
        )
    for k, row in enumerate(run.rows[: found - 1]):
        if run.times[k + 1] != number(row, "time"):
            problems.append(
                f"state {k + 1} is at {run.times[k + 1]:.9g} s, its step ends at {row.get('time')} s"
            )
            break
    return problems


def residual_claim(run: Run) -> Claim:
    """Unbalanced forces below the tolerances of the settings."""
    settings = run.settings
    tolerances = {
        "residual": float(settings.get("newton.residual_tolerance", 0.0)),
        "acceleration": float(settings.get("newton.acceleration_tolerance", 0.0)),
    }
    active = {name: value for name, value in tolerances.items() if value > 0.0}
    combine = max if settings.get("newton.termination", "all") == "all" else min
    by_motion = float(settings.get("newton.step_tolerance", 0.0)) > 0.0
    name = "residual"
    statement = "unbalanced forces at the end of each step are below " + " and ".join(
        f"newton.{key}_tolerance" for key in active
    )
    if not active or not run.rows:
        return Claim(
            name,
            "unbalanced forces are below the tolerances of the settings",
            NOT_RECORDED,
            _BASIS,
            detail="telemetry lacks the motion that newton.step_tolerance bounds" if by_motion else "",
        )
    worst, where, failed, rounded = -1.0, None, 0, 0
    for row in run.rows:
        share = combine(number(row, key) / value for key, value in active.items())
        if not share < 1.0:  # also NaN
            stopped_otherwise = row.get("solve_status") == "round_off" or (combine is min and by_motion)
            rounded, failed = rounded + stopped_otherwise, failed + (not stopped_otherwise)
        if not share <= worst:
            worst, where = share, {"time": row.get("time"), "step": row.get("step")}
    detail = ""
    if failed:
        detail = f"not so in {failed} steps"
    elif rounded:
        detail = f"{rounded} steps ended at rounding or by newton.step_tolerance, which is not recorded"
    status = VIOLATED if failed else INCONCLUSIVE if rounded else VERIFIED
    return Claim(name, statement, status, _BASIS, worst, 1.0, "of the tolerance", where, detail)


def ledger_claim(run: Run) -> Claim:
    """The energies of successive steps close their balance."""
    name = "energy_ledger"
    statement = (
        "what is stored changes by what a step reports as supplied and dissipated, but for contact stiffness"
    )
    if not all(_has_energies(row) for row in run.rows) or len(run.rows) < 2:
        return Claim(name, statement, NOT_RECORDED, _BASIS, detail="a step lacks energies")
    worst, bound, where, largest_growth = -math.inf, 0.0, None, 0.0
    violated, unexplained = 0, 0
    for before, row in zip(run.rows, run.rows[1:], strict=False):
        imbalance, rounding = _imbalance(before, row)
        contact = number(before["energy"], "contact")
        rounding += _CONTACT_ERROR * max(contact, number(row["energy"], "contact"))
        # Of the contact energy at the start of the step only its stiffness differs from that at the end of
        # the one before: the imbalance is at least minus that energy, and nothing where there is none.
        off = max(-contact - imbalance, imbalance - _STIFFNESS_GROWTH * contact)
        if off > rounding:
            surely = imbalance < -contact - rounding or imbalance > _IMPOSSIBLE_GROWTH * contact + rounding
            violated, unexplained = violated + surely, unexplained + (not surely)
        elif contact > 0.0:
            largest_growth = max(largest_growth, abs(imbalance) / contact)
        if off - rounding > worst:
            worst, bound = off - rounding, rounding
            where = {
                "time": row.get("time"),
                "step": row.get("step"),
                "imbalance": imbalance,
                "contact": contact,
            }
    own = bool(run.scene.get("energies"))
    status = VERIFIED
    if violated or unexplained:
        status = VIOLATED if violated and not own and run.has_states else INCONCLUSIVE
    detail = f"new contact stiffnesses change the contact energy by up to {largest_growth:.3g} of it"
    if status != VERIFIED:
        detail = f"{violated + unexplained} steps do not close"
        detail += "; values of energies of the scene may have changed" if own else ""
    return Claim(name, statement, status, _BASIS, max(0.0, worst + bound), bound, "J", where, detail)


def _has_energies(row: Row) -> bool:
    energy = row.get("energy")
    return isinstance(energy, dict) and all(
        isinstance(energy.get(key), (int, float)) for key in _STORED + _TURNED_OVER
    )


def _imbalance(before: Row, row: Row) -> tuple[float, float]:
    """Stored energy that appears out of nowhere in a step [J], and what rounding explains of it."""
    old, new = before["energy"], row["energy"]
    stored = [(new[key], 1.0) for key in _STORED] + [(old[key], -1.0) for key in _STORED]
    supplied = [(new[key], -1.0 if key in ("external", "actuation") else 1.0) for key in _TURNED_OVER]
    terms = [value * sign for value, sign in stored + supplied]
    return math.fsum(terms), _BALANCE_ROUNDING * sum(abs(term) for term in terms)


def friction_claim(run: Run) -> Claim:
    """Friction takes energy out of the motion: it gives back in a step what bristles stored before, never
    more."""
    name, statement = "friction_dissipates", "from the start to any step, friction does not add energy"
    integrator = run.settings.get("time.integrator")
    if integrator not in ("implicit_euler", "quasistatic"):
        return Claim(
            name, statement, NOT_APPLICABLE, _BASIS, detail=f"not implied by {integrator}", required=False
        )
    if not all(_has_energies(row) for row in run.rows) or not run.rows:
        return Claim(name, statement, NOT_RECORDED, _BASIS, required=False)
    least, where, bound = math.inf, None, 0.0
    dissipated, rounding = 0.0, 0.0
    for row in run.rows:
        rounding += _BALANCE_ROUNDING * sum(abs(value) for value in row["energy"].values())
        dissipated += row["energy"]["friction"]
        if dissipated + rounding < least:
            least, bound = dissipated + rounding, rounding
            where = {"time": row.get("time"), "step": row.get("step")}
    status = VERIFIED if least >= 0.0 else VIOLATED
    return Claim(name, statement, status, _BASIS, least - bound, -bound, "J", where, required=False)


def number(row: Row, key: str) -> float:
    """A number of a row, NaN where there is none."""
    value = row.get(key)
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else math.nan
