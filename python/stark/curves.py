"""Measured curves of materials, for ``stark.fit``: what was imposed, what was measured, in what test.

    pull = stark.curves.uniaxial(stretch, stress)            # lateral stress is zero
    blow = stark.curves.equibiaxial(stretch, stress)
    hold = stark.curves.relaxation(times, stress, stretch=1.2)

Stresses are nominal: force per area at rest [Pa]. Stretches are lengths over lengths at rest, 1 at rest.
Points of materials that remember are a path: loading, unloading and reversal in the order in which they were
measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import given_flag, given_name, real_array, real_number
from stark.attributes import own_names

Floats: TypeAlias = NDArray[np.float64]

#: Beyond, a stretch or a shear is taken for a percentage: rubber breaks at stretches of about 10.
_LARGEST_STRETCH = 20.0
#: Part of the largest stress from which its sign tells the direction of loading.
_LOADED = 0.05
#: Time of a step that is imposed at once, over the first time that was measured.
_AT_ONCE = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Curve:
    """A measured curve; what the functions of ``stark.curves`` make."""

    kind: str
    """uniaxial, equibiaxial, biaxial, planar, shear, volumetric, bending or torsion."""
    imposed: Floats
    """What was imposed (n, m): a stretch, two of them, a shear, a ratio of volumes, a curvature or a
    twist."""
    measured: Floats
    """What was measured (n, q): nominal stresses [Pa], of shells bending moments [N], of rods [N] or [N
    m]; NaN of a test that was not measured, to be predicted."""
    times: Floats | None
    """When [s], (n,), None where the rate does not matter."""
    name: str
    """What reports call it."""
    sigma: float | None = None
    """Standard deviation of the noise, in the unit of what was measured; None where it is not known."""
    ramp: float | None = None
    """Of a relaxation: how long the imposed value took to be reached [s], with the times counted from the
    start."""
    substeps: int = 1
    """Time steps from one point to the next."""
    free_height: bool = False
    """Of shear: whether the height adjusts itself."""
    narrow: bool = False
    """Of bending of shells: whether the strip is free to curve across."""
    axis: int = 1
    """Of bending of rods: about which axis of the section, 1 or 2."""

    def __len__(self) -> int:
        return len(self.imposed)

    def __repr__(self) -> str:
        return f"<stark.curves.Curve '{self.name}': {self.kind}, {len(self)} points>"

    @property
    def scale(self) -> float:
        """Largest of what was measured: what residuals are divided by where sigma is not known."""
        return float(np.abs(self.measured).max())

    @property
    def is_measured(self) -> bool:
        """Whether it can be fitted, not only predicted."""
        return not bool(np.isnan(self.measured).any())

    @property
    def at_rest(self) -> float:
        """The imposed value without deformation."""
        return 0.0 if self.kind in ("shear", "bending", "torsion") else 1.0

    def steps(self) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """The path from rest: imposed values (k, m), durations [s] (k,), which of them are points of the
        curve. Without times every duration is 1."""
        targets = self.imposed
        ends = np.arange(1.0, len(self) + 1.0) if self.times is None else self.times
        shown = np.ones(len(self), dtype=bool)
        at_once = _AT_ONCE * float(ends[ends > 0.0][0])
        ends = np.maximum(ends, at_once)  # rates of laws are over the duration of a step
        if self.ramp is not None:  # a step before the first point, at constant value from there
            end = self.ramp or at_once
            before = ends <= end
            ends = np.concatenate([[end], ends[~before]])
            targets = np.concatenate([targets[:1], targets[~before]])
            shown = np.concatenate([[bool(before.any())], shown[~before]])
        values, spans, marks = [], [], []
        last, begin = np.full(targets.shape[1], self.at_rest), 0.0
        for target, end, is_point in zip(targets, ends, shown, strict=True):
            for k in range(1, self.substeps + 1):
                values.append(last + (target - last) * (k / self.substeps))
                spans.append((end - begin) / self.substeps)
                marks.append(bool(is_point) and k == self.substeps)
            last, begin = target, float(end)
        return np.array(values), np.array(spans), np.array(marks)


def uniaxial(
    stretch: ArrayLike,
    stress: ArrayLike | None = None,
    *,
    times: ArrayLike | None = None,
    substeps: int = 1,
    sigma: float | None = None,
    name: str = "uniaxial",
) -> Curve:
    """Tension or compression along the first axis of the material, free to contract.

    stretch: (n,), 1 at rest. stress: nominal [Pa], (n,), of rods the force [N]; leave it out, here and in the
    other tests, where ``Fit.predict`` shall say what it is. times: [s], (n,), from 0 at
    rest, for laws that depend on the rate. substeps: time steps from point to point, where points are far
    apart for a law that remembers. sigma: standard deviation of the noise [Pa]. InvalidArgument for values
    that are not finite, shapes that differ, and what looks like a strain or a percentage."""
    return _curve("uniaxial", {"stretch": stretch}, {"stress": stress}, times, substeps, sigma, name)


def equibiaxial(
    stretch: ArrayLike,
    stress: ArrayLike | None = None,
    *,
    times: ArrayLike | None = None,
    substeps: int = 1,
    sigma: float | None = None,
    name: str = "equibiaxial",
) -> Curve:
    """The same stretch along two axes, free to contract along the third; stress [Pa] is that of one axis."""
    return _curve("equibiaxial", {"stretch": stretch}, {"stress": stress}, times, substeps, sigma, name)


def biaxial(
    stretch_1: ArrayLike,
    stretch_2: ArrayLike,
    stress_1: ArrayLike | None = None,
    stress_2: ArrayLike | None = None,
    *,
    times: ArrayLike | None = None,
    substeps: int = 1,
    sigma: float | None = None,
    name: str = "biaxial",
) -> Curve:
    """Two stretches along the first two axes, free to contract along the third; stress_2 may be left out."""
    stresses = {"stress_1": stress_1}
    if stress_2 is not None or stress_1 is None:
        stresses["stress_2"] = stress_2
    if stress_1 is None and stress_2 is not None:
        raise InvalidArgument(f"curves.{name}: stress_1 is missing: must be given where stress_2 is")
    stretches = {"stretch_1": stretch_1, "stretch_2": stretch_2}
    return _curve("biaxial", stretches, stresses, times, substeps, sigma, name)


def planar(
    stretch: ArrayLike,
    stress: ArrayLike | None = None,
    *,
    times: ArrayLike | None = None,
    substeps: int = 1,
    sigma: float | None = None,
    name: str = "planar",
) -> Curve:
    """Tension of a wide strip, which keeps its width, free to contract in thickness: "pure shear" of
    rubber."""
    return _curve("planar", {"stretch": stretch}, {"stress": stress}, times, substeps, sigma, name)


def shear(
    gamma: ArrayLike,
    tau: ArrayLike | None = None,
    *,
    free_height: bool = False,
    times: ArrayLike | None = None,
    substeps: int = 1,
    sigma: float | None = None,
    name: str = "shear",
) -> Curve:
    """Simple shear along the first axis: gamma (n,) is the displacement over the height, 0 at rest, tau the
    shear stress [Pa]. The height along the second axis is kept, as by stiff plates, or adjusts itself until
    it is free of stress, as in testers of cloth, with ``free_height``."""
    is_free = given_flag(free_height, f"curves.{name}: free_height")
    curve = _curve("shear", {"gamma": gamma}, {"tau": tau}, times, substeps, sigma, name)
    return _with(curve, free_height=is_free)


def volumetric(
    volume_ratio: ArrayLike,
    pressure: ArrayLike | None = None,
    *,
    sigma: float | None = None,
    name: str = "volumetric",
) -> Curve:
    """Compression from all sides: volume over volume at rest (n,), pressure [Pa], positive where it is
    below 1. What it takes to determine the bulk modulus of rubber."""
    return _curve("volumetric", {"volume_ratio": volume_ratio}, {"pressure": pressure}, None, 1, sigma, name)


def bending(
    curvature: ArrayLike,
    moment: ArrayLike | None = None,
    *,
    narrow: bool = False,
    axis: int = 1,
    sigma: float | None = None,
    name: str = "bending",
) -> Curve:
    """Bending of a shell or a rod: curvature [1/m] (n,), 0 at rest.

    Of shells moment is per width [N], that of ``flexural_rigidity``: of a strip that stays flat across, as
    wide ones and those of Kawabata's tester do, or of a ``narrow`` one that curves across freely. Of rods
    it is [N m] about ``axis`` 1 or 2 of the section, with no axial force."""
    if not isinstance(axis, (int, np.integer)) or axis not in (1, 2):
        raise InvalidArgument(f"curves.{name}: axis = {axis!r}: must be 1 or 2")
    is_narrow = given_flag(narrow, f"curves.{name}: narrow")
    curve = _curve("bending", {"curvature": curvature}, {"moment": moment}, None, 1, sigma, name)
    return _with(curve, narrow=is_narrow, axis=axis)


def torsion(
    twist: ArrayLike, torque: ArrayLike | None = None, *, sigma: float | None = None, name: str = "torsion"
) -> Curve:
    """Twisting of a rod without axial force: twist [rad/m] (n,), torque [N m] (n,)."""
    return _curve("torsion", {"twist": twist}, {"torque": torque}, None, 1, sigma, name)


def relaxation(
    times: ArrayLike,
    stress: ArrayLike | None = None,
    *,
    stretch: float | None = None,
    gamma: float | None = None,
    ramp: float = 0.0,
    substeps: int = 1,
    sigma: float | None = None,
    name: str = "relaxation",
) -> Curve:
    """Stress over time at a constant ``stretch`` (uniaxial) or a constant shear ``gamma``.

    times: [s], (n,), increasing, from the start of the ramp. ramp: how long the deformation took to be
    reached [s]; 0: at once. stress: nominal [Pa], (n,). substeps: time steps from point to point; laws of
    first order in the time step, as those of your own mostly are, need some where points are far apart."""
    owner = f"curves.{name}"
    if (stretch is None) == (gamma is None):
        raise InvalidArgument(f"{owner}: stretch = {stretch!r}, gamma = {gamma!r}: give one of the two")
    what, value = ("stretch", stretch) if gamma is None else ("gamma", gamma)
    number = real_number(value, f"{owner}: {what}")
    count = len(_column(times, f"{owner}: times"))
    span = real_number(ramp, f"{owner}: ramp")
    if not 0.0 <= span < np.inf:
        raise InvalidArgument(f"{owner}: ramp = {span:g} s: must be >= 0 and finite")
    kind = "uniaxial" if gamma is None else "shear"
    curve = _curve(kind, {what: np.full(count, number)}, {"stress": stress}, times, substeps, sigma, name)
    if number == curve.at_rest:
        raise InvalidArgument(
            f"{owner}: {what} = {number:g}: must differ from {curve.at_rest:g}, which is rest"
        )
    return _with(curve, ramp=span)


def _with(curve: Curve, **changes: Any) -> Curve:
    from dataclasses import replace

    return replace(curve, **changes)


def _curve(
    kind: str,
    imposed: dict[str, ArrayLike],
    measured: dict[str, ArrayLike | None],
    times: ArrayLike | None,
    substeps: int,
    sigma: float | None,
    name: str,
) -> Curve:
    owner = f"curves.{given_name(name) or kind}"
    known = {key: value for key, value in measured.items() if value is not None}
    columns = {key: _column(value, f"{owner}: {key}") for key, value in (imposed | known).items()}
    moments = None if times is None else _times(times, owner)
    if moments is not None:
        columns["times"] = moments
    lengths = {key: len(value) for key, value in columns.items()}
    if len(set(lengths.values())) > 1:
        counts = ", ".join(f"{count} of {key}" for key, count in lengths.items())
        raise InvalidArgument(f"{owner}: {counts}: must be as many, one of each for a point")
    if next(iter(lengths.values())) < 2:
        raise InvalidArgument(f"{owner}: {next(iter(lengths.values()))} points: must be 2 or more")
    for key in imposed:
        _check_imposed(columns[key], key, owner)
    first = next(iter(measured))
    if first not in known:
        columns |= {key: np.full(len(columns[next(iter(imposed))]), np.nan) for key in measured}
    elif not np.abs(columns[first]).max() > 0.0:
        raise InvalidArgument(f"{owner}: {first} is 0 at all points: must have been measured")
    elif kind not in ("biaxial", "volumetric"):
        _check_signs(columns, next(iter(imposed)), first, owner)
    if (
        isinstance(substeps, bool)
        or not isinstance(substeps, (int, np.integer))
        or not 1 <= substeps <= 10_000
    ):
        raise InvalidArgument(f"{owner}: substeps = {substeps!r}: must be a whole number from 1 to 10000")
    return Curve(
        kind,
        np.stack([columns[key] for key in imposed], axis=1),
        np.stack([columns[key] for key in measured], axis=1),
        moments,
        name,
        None if sigma is None else _sigma(sigma, owner),
        substeps=int(substeps),
    )


def _column(value: ArrayLike, what: str) -> Floats:
    array = real_array(value, what)
    if array.ndim != 1:
        raise InvalidArgument(f"{what} has the shape {array.shape}: must be (n,), a number for each point")
    wrong = ~np.isfinite(array)
    if wrong.any():
        k = int(np.argmax(wrong))
        raise InvalidArgument(
            f"{what}[{k}] = {array[k]:g}: must be finite; leave out points that were not measured"
        )
    return array


def _times(value: ArrayLike, owner: str) -> Floats:
    times = _column(value, f"{owner}: times")
    if len(times) and times[0] < 0.0:
        raise InvalidArgument(f"{owner}: times[0] = {times[0]:g} s: must be >= 0, counted from rest")
    back = np.diff(times) <= 0.0
    if back.any():
        k = int(np.argmax(back)) + 1
        raise InvalidArgument(
            f"{owner}: times[{k}] = {times[k]:g} s comes after {times[k - 1]:g} s: must increase; sort the "
            f"points"
        )
    return times


def _sigma(value: Any, owner: str) -> float:
    number = real_number(value, f"{owner}: sigma")
    if not 0.0 < number < np.inf:
        raise InvalidArgument(
            f"{owner}: sigma = {number:g}: must be > 0 and finite, in the unit of the stress"
        )
    return number


def _check_imposed(values: Floats, what: str, owner: str) -> None:
    if what in ("curvature", "twist"):
        return
    is_length = what.startswith("stretch") or what == "volume_ratio"
    if is_length and values.min() <= 0.0:
        k = int(np.argmin(values))
        raise InvalidArgument(
            f"{owner}: {what}[{k}] = {values[k]:g}: must be > 0, and 1 at rest; of a strain give 1 + strain, "
            f"of a percentage 1 + percentage / 100"
        )
    k = int(np.argmax(np.abs(values)))
    if np.abs(values[k]) > _LARGEST_STRETCH:
        remedy = "1 + percentage / 100" if is_length else "percentage / 100"
        raise InvalidArgument(
            f"{owner}: {what}[{k}] = {values[k]:g}: must be below {_LARGEST_STRETCH:g}; of a percentage "
            f"give {remedy}"
        )


def _check_signs(columns: dict[str, Floats], imposed: str, measured: str, owner: str) -> None:
    """What is pulled first must lengthen: else a strain was given for a stretch, or a sign is wrong."""
    rest = 1.0 if imposed.startswith("stretch") else 0.0
    values, stresses = columns[imposed], columns[measured]
    k = int(np.argmax(np.abs(stresses) > _LOADED * np.abs(stresses).max()))
    if (values[k] - rest) * stresses[k] >= 0.0:
        return
    raise InvalidArgument(
        f"{owner}: {imposed}[{k}] = {values[k]:g} with {measured}[{k}] = {stresses[k]:g}: must be on the "
        f"same side of rest, where {imposed} = {rest:g}; "
        + ("of a strain give 1 + strain" if rest else "look at the signs")
    )


def require_curves(curves: Curve | Sequence[Curve]) -> tuple[Curve, ...]:
    """One curve or several as a tuple; InvalidArgument for anything else."""
    given = (curves,) if isinstance(curves, Curve) else curves
    try:
        found = tuple(given)
    except TypeError:
        found = ()
    if not found or not all(isinstance(curve, Curve) for curve in found):
        raise InvalidArgument(
            f"fit: curves = {curves!r}: must be a curve of stark.curves, such as "
            f"stark.curves.uniaxial(stretch, stress), or a list of them"
        )
    for curve in found:
        if not curve.is_measured:
            raise InvalidArgument(
                f"fit: the curve '{curve.name}' was not measured: must have stresses to be fitted"
            )
    names = [curve.name for curve in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    if not twice:
        return found
    numbered = [
        f"{name} {names[: k + 1].count(name)}" if name in twice else name for k, name in enumerate(names)
    ]
    return tuple(_with(curve, name=name) for curve, name in zip(found, numbered, strict=True))


def __dir__() -> list[str]:
    return own_names(__name__, globals())
