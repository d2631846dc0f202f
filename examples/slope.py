"""A box on a slope, for a study of angle and friction: it slides where tan(angle) is above the coefficient.

stark run examples/slope.py --option angle=25
stark study run examples/slope.toml
"""

from __future__ import annotations

import numpy as np

import stark

until = 0.3  # [s]
options = {"angle": 20.0, "friction": 0.3}  # [deg], coefficient of the pair

_GRAVITY = 9.81  # [m/s^2]


def settings() -> dict[str, object]:
    return {"time_step": 0.01}


def downhill() -> np.ndarray:
    """Rotation of the slope; its first column points downhill."""
    return stark.rotation(axis="y", angle=options["angle"] * stark.deg)


def build() -> stark.Scene:
    scene = stark.Scene("slope")
    turn = downhill()
    slope = scene.add_box((4.0, 1.0, 0.1), name="slope", motion="fixed", rotation=turn)
    place = turn @ (-1.5, 0.0, 0.0718)
    box = scene.add_box((0.1, 0.1, 0.04), mass=1.0, name="box", rotation=turn, position=place)
    scene.friction[box, slope] = options["friction"]
    return scene


def _distance(sim: stark.Simulation) -> float:
    """How far the box has slid [m]."""
    return float(downhill()[:, 0] @ np.asarray(sim["box"].position)) + 1.5


def measure(sim: stark.Simulation) -> dict[str, float]:
    speed = float(downhill()[:, 0] @ np.asarray(sim["box"].velocity))
    return {"distance": _distance(sim), "speed": speed}


def observables(sim: stark.Simulation) -> dict[str, float]:
    return {"distance": _distance(sim)}


def check(run: stark.recording.Recording) -> None:
    angle = options["angle"] * stark.deg
    pull = _GRAVITY * (np.sin(angle) - options["friction"] * np.cos(angle))
    expected = max(0.0, 0.5 * pull * until**2)
    slid = float(run.telemetry["measured.distance"][-1])
    assert abs(slid - expected) < 0.05 * expected + 1e-3, f"slid {slid} m, expected {expected} m"
