"""What a certificate leaves out, named: pairs that were not looked at, settings that weaken a claim, ends and
digests that are not recorded. Claims hold within these limits only."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import chain
from typing import Any, TypeGuard

import numpy as np

from .certificate import INCONCLUSIVE, NOT_RECORDED, VERIFIED, Claim
from .created import created_energy
from .run import Run, pair_count
from .surface import exclusions, leaves_out_parts, length_without_contact

#: Settings that bound something: unit and default. Values beyond it weaken a claim; 0 leaves a test of
#: Newton's method out.
_TOLERANCES = {
    "newton.acceleration_tolerance": ("m/s^2", 1e-2),
    "newton.residual_tolerance": ("N", 0.0),
    "newton.step_tolerance": ("m/s", 1e-3),
    "joints.length_tolerance": ("m", 1e-6),
    "joints.angle_tolerance": ("rad", 1e-5),
    "contact.stick_velocity": ("m/s", 1e-3),
}
_SEPARATION = ("contact.min_separation_factor", 1e-3)
#: Tests of Newton's method that the default has: without them, steps may be far from solved.
_TESTS = ("newton.acceleration_tolerance", "newton.step_tolerance")
_NAMED = 8  # pairs in one limit

Pair = dict[str, Any]


def limits_of(run: Run, claims: list[Claim]) -> list[str]:
    """One sentence for each limit; empty for a complete run of which everything was looked at, with
    tolerances not looser than the defaults."""
    parts = [_end(run), _missing(claims), _settings(run), _created(run)]
    parts += [_placed(run), _contact(run), _attached(run), _formulas(run)] if run.has_states else []
    return list(chain.from_iterable(parts))


# --- the recording ---


def _end(run: Run) -> Iterator[str]:
    status = run.manifest.get("status")
    if status == "complete":
        return
    times = [row.get("time") for row in run.rows] or [0.0]
    at = f"ends at step {len(run.rows)}, {times[-1]} s"
    if status == "running":
        yield f"the recording {at}: its end is not recorded, what came after it may have been cut off"
    else:
        yield f"the run {at}: it was {status}"


def _missing(claims: list[Claim]) -> Iterator[str]:
    for claim in claims:
        if claim.name == "chain" and claim.status == NOT_RECORDED:
            yield "no chain: nothing shows whether the recording was changed since it was made"
        if claim.name == "minimum_distance" and claim.status == VERIFIED and _is_beyond(claim):
            gap, asked = f"{claim.worst:.3g} m", f"{claim.tolerance:.3g} m"
            yield f"surfaces come to {gap}, where {asked} are asked for: {claim.detail}"
        if claim.name == "display" and claim.status == INCONCLUSIVE:
            yield f"frames for display without a state are not compared: {claim.detail}"


def _is_beyond(claim: Claim) -> bool:
    return claim.worst is not None and claim.tolerance is not None and claim.worst < claim.tolerance


# --- settings ---


def _settings(run: Run) -> Iterator[str]:
    settings = run.settings
    for name, (unit, default) in _TOLERANCES.items():
        value = settings.get(name)
        if _is_number(value) and value > default > 0.0:
            yield f"{name} = {value:g} {unit} is looser than the default, {default:g} {unit}"
    off = [name for name in _TESTS if settings.get(name) == 0.0]
    if off:
        yield f"{' and '.join(off)} = 0: steps are not bounded by {'them' if len(off) > 1 else 'it'}"
    if settings.get("newton.termination", "all") != "all":
        yield f"newton.termination = {settings['newton.termination']}: one tolerance is enough for a step"
    name, default = _SEPARATION
    value = settings.get(name)
    if _is_number(value) and value < default:
        yield f"{name} = {value:g} asks for less distance than the default, {default:g}"
    if settings.get("contact.friction") is False:
        yield "friction is off: contact.friction = False"
    if not any(map(_is_number, (settings.get(name) for name in _TOLERANCES))):
        yield "the recording lacks the tolerances of the run"


def _is_number(value: Any) -> TypeGuard[float]:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _created(run: Run) -> Iterator[str]:
    energy = created_energy(run)
    if energy is not None and energy.is_much:
        yield energy.limit()


# --- pairs ---


def excluded_pairs(run: Run) -> list[Pair]:
    """Pairs of bodies that the claims about contact are not about, with the reason. A rigid body cannot meet
    itself, and two fixed ones do not move: they are not listed."""
    if not run.has_states:
        return []
    bodies, excluded = run.bodies, []
    for a, b in sorted({(min(pair), max(pair)) for pair in map(tuple, run.scene["pairs_without_contact"])}):
        first, second = bodies[a], bodies[b]
        if a == b:
            reason = "" if first.has_pose else "self-contact is off"
        elif first.motion == second.motion == "fixed":
            reason = ""
        elif first.motion != "dynamic" and second.motion != "dynamic":
            reason = "the scene moves both"
        else:
            reason = "excluded by the scene"
        if reason:
            excluded.append({"bodies": [first.name, second.name], "reason": reason})
    every = np.ones((len(bodies),) * 2, dtype=bool)
    for a, vertex, b in exclusions(run.scene, every):
        if vertex < 0:
            reason = "excluded by a joint or attachment while it holds them"
            excluded.append({"bodies": [bodies[a].name, bodies[b].name], "reason": reason})
    return excluded


def _contact(run: Run) -> Iterator[str]:
    if not run.scene["contact_enabled"]:
        yield "contact is off: nothing is said about intersections, distances and paths of any pair"
        return
    by_reason: dict[str, list[Pair]] = {}
    for pair in excluded_pairs(run):
        by_reason.setdefault(pair["reason"], []).append(pair)
    for reason, pairs in by_reason.items():
        names = [_named(*pair["bodies"]) for pair in pairs]
        more = f" and {len(names) - _NAMED} more, see recording.excluded_pairs" if len(names) > _NAMED else ""
        count = "1 pair" if len(names) == 1 else f"{len(names)} pairs"
        yield f"{count} not looked at, {reason}: {', '.join(names[:_NAMED])}{more}"
    without = {tuple(pair) for pair in run.scene["pairs_without_contact"]}
    for i, body in enumerate(run.bodies):
        if body.contact_distance == 0.0:
            yield f"contact distance of '{body.name}' is 0: no distance is asked of it"
        if leaves_out_parts(body) and (i, i) not in without:
            length = length_without_contact(body)
            yield f"parts of '{body.name}' within {length:.3g} m along it are not looked at"
        if not len(body.triangles) and not len(body.edges):
            yield f"'{body.name}' has no surface: nothing is said about its contact"


def _named(a: str, b: str) -> str:
    return f"'{a}' with itself" if a == b else f"'{a}' and '{b}'"


def _placed(run: Run) -> Iterator[str]:
    if not run.placed_count:
        return
    bodies: dict[str, int] = {}
    for index in np.flatnonzero(run.placed).tolist():
        placed = run.state(index).placed
        assert placed is not None
        for body in np.flatnonzero(placed).tolist():
            bodies[run.bodies[body].name] = bodies.get(run.bodies[body].name, 0) + 1
    names = [f"'{name}' {'once' if n == 1 else f'{n} times'}" for name, n in bodies.items()]
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    yield (
        f"the user has placed bodies between steps, which are jumps and not motion: "
        f"{', '.join(names[:_NAMED])}{more}"
    )


def _attached(run: Run) -> Iterator[str]:
    found: dict[str, list[tuple[str, int]]] = {}  # by what is said of them: names and numbers of points
    for attachment in run.scene["attachments"]:
        if "patches" not in attachment and all(b.get("body") is None for b in attachment["b"]):
            continue  # to the world, which has no surface
        others = {attachment.get("patch_body"), *(b.get("body") for b in attachment["b"])}
        near = "what is near what" if others - {None} == {attachment["a"].get("body")} else "what"
        found.setdefault(near, []).append((str(attachment.get("name", "")), pair_count(attachment)))
    for near, attachments in found.items():
        count = sum(points for _, points in attachments)
        names = ", ".join(f"'{name}'" for name, _ in attachments[:_NAMED])
        more = f" and {len(attachments) - _NAMED} more" if len(attachments) > _NAMED else ""
        yield (
            f"attachment{'s' if len(attachments) != 1 else ''} {names}{more}: {count} "
            f"point{'s' if count != 1 else ''} not looked at against {near} carries "
            f"{'them' if count != 1 else 'it'}"
        )


def _formulas(run: Run) -> Iterator[str]:
    if names := [str(name) for name in run.scene["energies"]]:
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        yield (
            f"energies of loads, of seams and of the user are taken as reported: "
            f"{', '.join(map(repr, names[:_NAMED]))}{more}"
        )
