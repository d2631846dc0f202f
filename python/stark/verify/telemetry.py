"""What the solver reported of its steps: times, unbalanced forces, the energy balance, the sign of
friction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .certificate import AS_REPORTED, INCONCLUSIVE, NOT_APPLICABLE, NOT_RECORDED, VERIFIED, VIOLATED, Claim
from .created import created_energy
from .run import Run, number

_TIME_ROUNDING = 1e-9  # of a time step
#: Rounding of a balance over the sum of its terms.
_BALANCE_ROUNDING = 1e-10
#: Contact stiffness is chosen anew in each step, and grows with the elasticity of what is deformed. At the
#: start of a step contact may store this many times what it did at the end of the one before; beyond the
#: second factor no stiffness explains it.
_GROWTH, _IMPOSSIBLE_GROWTH = 100.0, 1e4
#: Or as much more as this part of the kinetic energy, in a step that was retried and in any other (theory,
#: section 5, "Failed steps" and "Deep impacts").
_STIFFENED_RETRIED, _STIFFENED = 0.1, 0.01
#: In recordings without the contact energy at the start of steps, those at their ends were taken before the
#: last Newton iteration: how far they may be off.
_CONTACT_ERROR = 0.01
_CONTACT_AT_START, _BRISTLES_AT_START = "contact_energy_at_start", "bristle_energy_at_start"
_BELTS = "belts"
_STORED = ("kinetic", "elastic", "gravity", "contact")
_SUPPLIED = ("external", "actuation")
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
        if not (math.isfinite(end) and 0.0 < h < math.inf):
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
    times = run.times[~run.placed]
    expected, found = len(run.rows) + 1, len(times)
    unfinished = run.manifest.get("status") in ("running", "interrupted")
    lost = int(run.manifest.get("chunk_frames", 1))  # a killed run loses its last chunk
    problems = []
    if not (found == expected or (unfinished and abs(found - expected) <= lost)):
        problems.append(
            f"{len(run.rows)} accepted steps, but {found} states; one more state than steps is needed"
        )
    for k, row in enumerate(run.rows[: found - 1]):
        if times[k + 1] != number(row, "time"):
            problems.append(f"state {k + 1} is at {times[k + 1]:.9g} s, its step ends at {row.get('time')} s")
            break
    return problems + _placed_states(run)


def _placed_states(run: Run) -> list[str]:
    """States in which bodies were placed follow that of their time, and the next step reports them."""
    for index in np.flatnonzero(run.placed).tolist():
        if run.times[index] != run.times[index - 1]:
            return [f"in state {index} bodies are placed, but no state of its time comes before"]
        row = index - 1 - int(run.placed[:index].sum())
        if row < len(run.rows) and not run.rows[row].get("placed"):
            return [f"in state {index} bodies are placed, but the step after it reports none"]
    return []


#: What ends the minimisation of a step: setting of its tolerance, by the number of the telemetry.
_TOLERANCES = {
    "residual": "newton.residual_tolerance",
    "acceleration": "newton.acceleration_tolerance",
    "last_motion": "newton.step_tolerance",
}


def residual_claim(run: Run) -> Claim:
    """Unbalanced forces, and the last motion of Newton's method over the time step, below the tolerances of
    the settings."""
    settings = run.settings
    tolerances = {key: run.bound(name) or 0.0 for key, name in _TOLERANCES.items()}
    has_motion = all("last_motion" in row for row in run.rows)
    by_motion = tolerances["last_motion"] > 0.0
    active = {
        key: value
        for key, value in tolerances.items()
        if value > 0.0 and (key != "last_motion" or has_motion)
    }
    every = settings.get("newton.termination", "all") == "all"
    combine = max if every else min
    lacks_motion = by_motion and not has_motion
    name = "residual"
    if not active or not run.rows:
        return Claim(
            name,
            "unbalanced forces are below the tolerances of the settings",
            NOT_RECORDED,
            AS_REPORTED,
            detail="telemetry lacks the motion that newton.step_tolerance bounds"
            if lacks_motion
            else run.lacks(*_TOLERANCES.values()),
        )
    bounds = (" and " if every else " or ").join(_TOLERANCES[key] for key in active)
    statement = f"what is left to solve at the end of each step is below {bounds}"
    worst, where, failed, rounded = -1.0, None, 0, 0
    impossible = _impossible(run.rows, tuple(_TOLERANCES))
    for row in run.rows:
        share = combine(_left(row, key) / value for key, value in active.items())
        if not share < 1.0:
            at_rounding = row.get("solve_status") == "round_off" or row.get("at_rounding") is True
            stopped_otherwise = at_rounding or (lacks_motion and not every)
            rounded, failed = rounded + stopped_otherwise, failed + (not stopped_otherwise)
        if share > worst:
            worst, where = share, {"time": number(row, "time"), "step": row.get("step")}
    detail = lacking = run.lacks(*_TOLERANCES.values(), "newton.termination")
    if impossible:
        detail = impossible
    elif failed:
        detail = f"not so in {failed} steps"
    elif rounded and lacks_motion and not every:
        detail = f"{rounded} steps ended at rounding or by newton.step_tolerance, which is not recorded"
    elif rounded:
        detail = f"{rounded} steps ended at rounding"
    elif lacks_motion:
        detail = "telemetry lacks the motion that newton.step_tolerance bounds"
    status = VIOLATED if failed or impossible else INCONCLUSIVE if rounded or lacking else VERIFIED
    return Claim(name, statement, status, AS_REPORTED, worst, 1.0, "of the tolerance", where, detail)


def _left(row: Row, key: str) -> float:
    """Residual [N], acceleration [m/s^2] or speed of the last motion [m/s]; infinite where there is none, or
    none that could be."""
    value = number(row, key)
    if key == "last_motion":
        h = number(row, "time_step")
        value = value / h if h > 0.0 else math.nan
    return value if value >= 0.0 else math.inf


def _impossible(rows: list[Row], keys: tuple[str, ...]) -> str:
    """Names the first number of these keys that is negative, infinite or none; empty without one. A null is
    no number, but what was not measured."""
    for row in rows:
        for key in keys:
            if row.get(key) is not None and not 0.0 <= number(row, key) < math.inf:
                return f"step {row.get('step')} reports {key} = {row[key]!r}: must be finite and >= 0"
    return ""


def ledger_claim(run: Run) -> Claim:
    """The energies of successive steps close their balance."""
    name = "energy_ledger"
    statement = "stored energy changes by what is supplied and dissipated, and by new contact stiffness"
    if not all(_has_energies(row) for row in run.rows) or len(run.rows) < 2:
        return Claim(name, statement, NOT_RECORDED, AS_REPORTED, detail="a step lacks energies")
    worst, bound, where, largest_growth = -math.inf, 0.0, None, 0.0
    violated, unexplained = 0, 0
    if impossible := _impossible_energy(run.rows) or _work_of_no_belt(run):
        return Claim(name, statement, VIOLATED, AS_REPORTED, detail=impossible)
    recorded = any(_CONTACT_AT_START in row for row in run.rows)
    for index, (before, row) in enumerate(zip(run.rows, run.rows[1:], strict=False), 1):
        contact = number(before["energy"], "contact")
        at_start = number(row, _CONTACT_AT_START) if recorded else contact
        imbalance, rounding = _imbalance(before, row, at_start)
        off = abs(imbalance)
        if not recorded:
            # Recordings of older versions lack it. Of the contact energy at the start of the step only its
            # stiffness differs from that at the end of the one before: the imbalance is at least minus that
            # energy, and nothing where there is none.
            rounding += _CONTACT_ERROR * max(contact, number(row["energy"], "contact"))
            at_start = contact + imbalance
            off = max(-at_start, 0.0)
        # Stiffness may grow, but not out of nothing.
        share = _STIFFENED_RETRIED if number(row, "rejected_steps") > 0.0 else _STIFFENED
        stiffened = contact + share * number(before["energy"], "kinetic")
        limits = [
            max(0.0, at_start - max(factor * contact, stiffened)) for factor in (_GROWTH, _IMPOSSIBLE_GROWTH)
        ]
        # Contact between other bodies than before, or where there was none.
        if row.get("placed") or (limits[0] > 0.0 and _came_back(run, index)):
            limits = [0.0, 0.0]
        allowed = rounding + _BALANCE_ROUNDING * abs(at_start)
        surely = not (max(off, -at_start) <= rounding and limits[1] <= allowed)
        violated, unexplained = violated + surely, unexplained + (not surely and limits[0] > allowed)
        if contact > 0.0 and not surely:
            largest_growth = max(largest_growth, abs(at_start - contact) / contact)
        off = max(off, limits[0])
        if not off - rounding <= worst:
            worst, bound = off - rounding, rounding
            where = {"time": number(row, "time"), "step": row.get("step")}
            where |= {"imbalance": imbalance, "contact": contact, "contact_at_start": at_start}
    own = bool(run.scene.get("energies"))
    status = VERIFIED
    if violated or unexplained:
        status = VIOLATED if violated and not own and run.has_states else INCONCLUSIVE
    detail = f"new contact stiffnesses change the contact energy by up to {largest_growth:.3g} of it"
    if integrated := created_energy(run):
        detail += f"; {integrated.text()}"
    if status != VERIFIED:
        detail = f"{violated + unexplained} steps do not close"
        detail += "; values of energies of the scene may have changed" if own else ""
    return Claim(name, statement, status, AS_REPORTED, max(0.0, worst + bound), bound, "J", where, detail)


def _came_back(run: Run, index: int) -> bool:
    """Whether contact of what joints and attachments have released came back in the step of a row."""
    states = np.flatnonzero(~run.placed)
    if not run.has_states or index + 1 >= len(states):
        return False
    end = run.state(int(states[index + 1]))
    before, after = run.state(end.index - 1).regained, end.regained
    return before is not None and after is not None and bool((after > before).any())


def _has_energies(row: Row) -> bool:
    energy = row.get("energy")
    return isinstance(energy, dict) and all(
        isinstance(energy.get(key), (int, float)) for key in _STORED + _TURNED_OVER
    )


def _impossible_energy(rows: list[Row]) -> str:
    """Names the first impossible energy: one that is not finite, whose rounding would explain any
    imbalance, or contact that stores less than nothing but for rounding. Empty without one."""
    for row in rows:
        rounding = 2.0**-52 * max(abs(number(row["energy"], key)) for key in _STORED)
        for key in _STORED + _TURNED_OVER:
            value, least = row["energy"][key], -rounding if key == "contact" else -math.inf
            if not (math.isfinite(number(row["energy"], key)) and value >= least):
                rule = "must be finite and >= 0" if key == "contact" else "must be finite"
                return f"step {row.get('step')} reports the energy {key} = {value!r} J: {rule}"
    return ""


def _work_of_no_belt(run: Run) -> str:
    """Names the first work of moving surfaces in a scene that has none, or that is no number."""
    moving = any(body.get("surface_moves") for body in run.scene.get("bodies", []))
    for row in run.rows:
        work = row["energy"].get(_BELTS, 0.0)
        if not (isinstance(work, (int, float)) and math.isfinite(work) and (moving or work == 0.0)):
            rule = "must be finite" if moving else "must be 0, no surface of the scene moves"
            return f"step {row.get('step')} reports the energy {_BELTS} = {work!r} J: {rule}"
    return ""


def _imbalance(before: Row, row: Row, contact: float) -> tuple[float, float]:
    """Stored energy that appears out of nowhere in a step which starts with this contact energy [J], and what
    rounding explains of it."""
    old, new = {**before["energy"], "contact": contact}, row["energy"]
    stored = [(new[key], 1.0) for key in _STORED] + [(old[key], -1.0) for key in _STORED]
    # Recordings of older versions do not name the work of restitution, of belts, and of the user who places
    # bodies.
    given_back = [(new.get(key, 0.0), -1.0) for key in ("restitution", _BELTS, "placed")]
    supplied = [(new[key], -1.0 if key in _SUPPLIED else 1.0) for key in _TURNED_OVER] + given_back
    terms = [value * sign for value, sign in stored + supplied]
    return math.fsum(terms), _BALANCE_ROUNDING * sum(abs(term) for term in terms)


def friction_claim(run: Run) -> Claim:
    """Friction takes energy out of the motion: it gives back in a step what bristles stored before, never
    more."""
    name, statement = "friction_dissipates", "friction gives back no more than its bristles stored before"
    integrator = run.settings.get("time.integrator")
    if lacking := run.lacks("time.integrator"):
        return Claim(name, statement, INCONCLUSIVE, AS_REPORTED, detail=lacking, required=False)
    if integrator not in ("implicit_euler", "quasistatic"):
        return Claim(
            name,
            statement,
            NOT_APPLICABLE,
            AS_REPORTED,
            detail=f"not implied by {integrator}",
            required=False,
        )
    recorded = all(_has_energies(row) and _BRISTLES_AT_START in row for row in run.rows)
    if not recorded or not run.rows:
        return Claim(name, statement, NOT_RECORDED, AS_REPORTED, required=False)
    worst, where, bound, broken = math.inf, None, 0.0, 0
    for row in run.rows:
        # The potential of the bristles is convex: grad(u) . (u - a) >= E(u) - E(a) >= -E(a).
        friction, stored = row["energy"]["friction"], number(row, _BRISTLES_AT_START)
        rounding = _BALANCE_ROUNDING * sum(abs(value) for value in row["energy"].values())
        finite = math.isfinite(friction + stored + rounding)
        broken += not (finite and friction + stored + rounding >= 0.0 and stored >= 0.0)
        if not friction + stored >= worst:
            worst, bound = friction + stored, -rounding
            where = {
                "time": number(row, "time"),
                "step": row.get("step"),
                "friction": friction,
                "stored": stored,
            }
    status = VIOLATED if broken else VERIFIED
    detail = f"not so in {broken} steps" if broken else ""
    return Claim(name, statement, status, AS_REPORTED, worst, bound, "J", where, detail, required=False)
