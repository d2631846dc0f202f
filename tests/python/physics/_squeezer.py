"""Andrews' squeezer: seven bodies in the plane, the benchmark of multibody codes. Data and initial angles
of W. Schiehlen (ed.), Multibody Systems Handbook, Springer 1990, and of the IVP test set (problem "andrews"),
in SI units; names of the test set."""

from __future__ import annotations

from typing import Any

import numpy as np
from _mechanisms import TIGHT, Floats, Work, record, simulate
from numpy.typing import NDArray

import stark

XA, YA = -0.06934, -0.00227
XB, YB = -0.03635, 0.03273
XC, YC = 0.014, 0.072
D, DA, E, EA = 0.028, 0.0115, 0.02, 0.01421
ZF, FA, RR, RA = 0.02, 0.01421, 0.007, 0.00092
SS, SA, SB, SC, SD = 0.035, 0.01874, 0.01043, 0.018, 0.02
TA, TB, U, UA, UB, ZT = 0.02308, 0.00916, 0.04, 0.01228, 0.00449, 0.04
STIFFNESS, REST_LENGTH, TORQUE = 4530.0, 0.07785, 0.033  # [N/m], [m], [N m]
MASSES = (0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498)  # [kg]
INERTIAS = (2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)  # [kg m^2]
START = {
    "beta": -0.0617138900142764496,
    "Theta": 0.0,
    "gamma": 0.45527981916307038,
    "Phi": 0.22266839016588588,
    "delta": 0.48736497954384255,
    "Omega": -0.22266839016588588,
    "epsilon": 1.23054744454982119,
}
# With constraints of 1e-2 m, forces of 1e2 N and steps of 1e-5 s, rounding is near 1e-9 N.
SETTINGS = {**TIGHT, "newton.residual_tolerance": 1e-6, "joints.length_tolerance": 1e-9}


@stark.energy
def motor(shaft: stark.Frame, torque: float):
    """A torque about z [N m]: its work in the time step."""
    before, now = shaft.axes_prev.column(0), shaft.x
    turn = stark.atan2(before[0] * now[1] - before[1] * now[0], before[0] * now[0] + before[1] * now[1])
    return -torque * turn


@stark.energy
def spring(p: stark.Point, end: stark.Vec3, stiffness: float, length: float):
    return 0.5 * stiffness * (stark.norm(p.x - end) - length) ** 2


def _at(x: float, y: float) -> Floats:
    return np.array([x, y, 0.0])


def _polar(angle: float, along: float, across: float) -> Floats:
    """A vector in axes turned by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    return _at(along * c - across * s, along * s + across * c)


def squeezer(
    time_step: float, until: float, work: Work | None = None, **settings: Any
) -> tuple[NDArray, NDArray]:
    """The seven angles [rad] after each step."""
    beta, theta, gamma, phi, delta, omega, epsilon = START.values()
    A, B, C = _at(XA, YA), _at(XB, YB), _at(XC, YC)
    knee = _polar(beta, RR, 0.0)
    meeting = knee - _polar(beta + theta, D, 0.0)  # K2, K3, K4 and K6 share this point
    upper, lower = A + _polar(delta, ZT, 0.0), A + _polar(epsilon, 0.0, -U)
    centers = [
        _polar(beta, RA, 0.0),
        knee - _polar(beta + theta, DA, 0.0),
        B + _polar(gamma, SB, -SA),
        upper + _polar(phi + delta, 0.0, -(E - EA)),
        A + _polar(delta, TA, TB),
        lower + _polar(omega + epsilon, ZF - FA, 0.0),
        A + _polar(epsilon, -UB, -UA),
    ]
    scene = stark.Scene()
    bodies = [
        scene.add_box(1e-3, inertia=(m, (0.0, 0.0, 0.0), inertia * np.eye(3)), position=center)
        for m, inertia, center in zip(MASSES, INERTIAS, centers, strict=True)
    ]
    k1, k2, k3, k4, k5, k6, k7 = bodies
    pairs = [
        (None, k1, _at(0, 0)),
        (k1, k2, knee),
        (None, k3, B),
        (k2, k3, meeting),
        (k2, k4, meeting),
        (k2, k6, meeting),
        (k4, k5, upper),
        (None, k5, A),
        (k6, k7, lower),
        (None, k7, A),
    ]
    joints = [scene.add_hinge(a, b, anchor=at, axis=(0, 0, 1)) for a, b, at in pairs]
    scene.add(motor(k1, torque=TORQUE))
    end = B + _polar(gamma, SD, -SC)
    scene.add(spring(k3.points(end - centers[2]), end=C, stiffness=STIFFNESS, length=REST_LENGTH))
    sim = simulate(scene, time_step, gravity=(0, 0, 0), **{**SETTINGS, **settings})

    def angles() -> Floats:
        if sim.time == 0.0:
            return np.array(list(START.values()))
        turn = [j.angle for j in joints]
        t4, t6 = turn[4] + turn[1] + turn[0], turn[5] + turn[1] + turn[0]
        t5, t7 = turn[7], turn[9]
        return np.array(
            [
                beta + turn[0],
                theta + turn[1],
                gamma + turn[2],
                phi + t4 - t5,
                delta + t5,
                omega + t6 - t7,
                epsilon + t7,
            ]
        )

    return record(sim, until, angles, work)
