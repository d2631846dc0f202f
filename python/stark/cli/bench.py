"""``stark bench``: measures a scene so that it can be compared with other systems.

Steps end by one of ``RULES``, by default when the residual alone is small: systems that stop by their own
last correction are not equally exact.

Nothing is recorded and nothing is warmed up. The clock runs from the finished scene description to the last
step, so the making of the model and of its kernels counts. A calibration job right before and right after
tells how fast the machine was: compare ``cpu_s / calib_s`` rather than seconds.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Mapping
from typing import Any

from .output import say
from .settings_arguments import add_option_argument, add_setting_arguments, parse_options, parse_settings

#: When a step ends. residual: the largest unbalanced force times the time step is below 1e-6 N s. any: that,
#: or the next full Newton step moves no point faster than 1e-3 m/s. scene: as the settings of the scene say.
RULES = ("residual", "any", "scene")
_RESIDUAL, _CORRECTION = 1e-6, 1e-3  # [N s], [m/s]
_GRAVITY, _NUDGE = (0.0, 0.0, -9.81), 1e-9
#: Numbers of a report that are summed up.
_COUNTS = ("newton_iterations", "linear_iterations", "factorizations", "rejected_steps")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scene", metavar="SCENE.py|NAME", help="a scene file, or the name of a packaged scene"
    )
    parser.add_argument(
        "--until", type=float, metavar="T", help="simulated time [s]; default: the scene's own"
    )
    parser.add_argument("--json", action="store_true", help="print one line of JSON and nothing else")
    parser.add_argument(
        "--rule",
        choices=RULES,
        default=RULES[0],
        help="a step ends when its residual is below 1e-6 N s (default), that or when its next correction is "
        "below 1e-3 m/s (any), or by the settings of the scene",
    )
    add_option_argument(parser)
    parser.add_argument("--no-check", action="store_true", help="do not check all states for intersections")
    add_setting_arguments(parser)


def calibrate() -> float:
    """CPU seconds of the calibration job, best of three: 30 evaluations of sin(sqrt(a^2 + 1)) + a on 200,000
    numbers."""
    import numpy as np

    a = np.linspace(0.1, 1.0, 200_000)
    best = math.inf
    for _ in range(3):
        begin = time.process_time()
        for _ in range(30):
            _ = np.sin(np.sqrt(a * a + 1.0)) + a
        best = min(best, time.process_time() - begin)
    return best


def rule_settings(rule: str, time_step: float) -> dict[str, Any]:
    """Settings with which steps of a length [s] end by a rule of ``RULES``."""
    if rule == "scene":
        return {}
    return {
        "newton.termination": "any",
        "newton.acceleration_tolerance": 0.0,
        "newton.residual_tolerance": _RESIDUAL / time_step,
        "newton.step_tolerance": _CORRECTION if rule == "any" else 0.0,
    }


def measure(
    name: str,
    settings: dict[str, Any],
    until: float | None = None,
    check: bool = True,
    rule: str = RULES[0],
    nudges: int = 0,
    options: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Runs the scene once and returns the numbers of the JSON line. ``settings`` go before those of the rule
    and those of the scene. Gravity is larger by ``nudges`` times 1e-9 of itself: counts of iterations of one
    scene scatter, and runs that differ by that say how much. ``options`` are those of the scene file."""
    import numpy as np

    import stark

    from ..recording.format import surface
    from ..scenes import load
    from ..scenes.runner import DRIVE_RULE, end_time, status_of
    from ..steps import reached
    from ..telemetry import report_to_dict

    scene_file = load(name, options)
    end = end_time(scene_file, until)
    scene, file_settings = scene_file.build()
    gravity = file_settings.get("gravity", _GRAVITY)
    settings = {
        **file_settings,
        "gravity": [(1.0 + _NUDGE * nudges) * g for g in gravity],
        **rule_settings(rule, _time_step(file_settings | settings)),
        **settings,
    }
    checker = _IntersectionCheck.make() if check else None
    states: list[list[np.ndarray]] = []
    totals = _Totals()

    calib_before = calibrate()
    wall, cpu = time.perf_counter(), time.process_time()
    sim = stark.Simulation(scene, **settings)
    while not reached(sim, end):  # in whole steps: a shortened one costs less than those that are measured
        with sim._held_still("drive(sim) of the scene", DRIVE_RULE):
            scene_file.drive(sim)
        report = sim.step()
        totals.add(report_to_dict(report))
        if checker:
            states.append([np.array(surface(body)[0], dtype=np.float64) for body in sim.bodies])
        if status_of(report) == "failed":
            totals.failure = str(report.message)
            break
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    calib = 0.5 * (calib_before + calibrate())

    return {
        "scene": scene_file.name,
        "rule": rule,
        "threads": sim.threads,
        "sim_s": round(float(sim.time), 9),
        "wall_s": round(wall, 4),
        "cpu_s": round(cpu, 4),
        "calib_s": round(calib, 5),
        "ratio": round(cpu / calib, 2),
        **totals.counts,
        "dofs": int(sim._core.dof_count),
        "max_residual_n": _finite(totals.largest_residual),
        "min_distance_m": _finite(totals.smallest_distance),
        "intersections": checker.count(sim, states) if checker else None,
        "state_hash": sim.state.hash,
        "phases": {key: round(seconds, 4) for key, seconds in totals.phases.items()},
        "observables": scene_file.observables(sim),
        "failure": totals.failure or None,
    }


class _Totals:
    """Of the reports of all steps."""

    def __init__(self) -> None:
        self.counts: dict[str, int] = dict.fromkeys(("steps", *_COUNTS), 0)
        self.phases: dict[str, float] = {}  # wall-clock time [s]
        self.largest_residual = 0.0  # [N]
        self.smallest_distance = math.inf  # [m]
        self.failure = ""

    def add(self, report: Mapping[str, Any]) -> None:
        """A report as ``report_to_dict`` gives it: numbers that are not finite are None."""
        self.counts["steps"] += 1
        for key in _COUNTS:
            self.counts[key] += report[key]
        for key, seconds in report["phases"].items():
            self.phases[key] = self.phases.get(key, 0.0) + seconds
        residual, distance = report["residual"], report["min_distance"]
        self.largest_residual = max(self.largest_residual, math.inf if residual is None else residual)
        self.smallest_distance = min(self.smallest_distance, math.inf if distance is None else distance)


def _finite(number: float) -> float | None:
    return number if math.isfinite(number) else None


def _time_step(settings: dict[str, Any]) -> float:
    import stark

    return float(settings.get("time_step", settings.get("time.step", stark.Settings().time.step)))


class _IntersectionCheck:
    """Counts the states in which surfaces intersect, with the independent package ipctk."""

    def __init__(self, ipctk: Any) -> None:
        self._ipctk = ipctk

    @classmethod
    def make(cls) -> _IntersectionCheck | None:
        try:
            import ipctk
        except ImportError:
            return None
        return cls(ipctk)

    def count(self, sim: Any, states: list[list[Any]]) -> int:
        import numpy as np

        from ..recording.format import surface

        triangles, start = [], 0
        for body in sim.bodies:
            positions, faces = surface(body)
            triangles.append(np.asarray(faces, dtype=np.int64) + start)
            start += len(positions)
        faces = np.concatenate(triangles).astype(np.int32)
        edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
        if not states:
            return 0
        mesh = self._ipctk.CollisionMesh(np.concatenate(states[0]), edges, faces)
        return sum(bool(self._ipctk.has_intersections(mesh, np.concatenate(state))) for state in states)


def run(args: argparse.Namespace) -> int:
    check, options = not args.no_check, parse_options(args)
    result = measure(args.scene, parse_settings(args), args.until, check, args.rule, options=options)
    if args.json:
        say(json.dumps(result, allow_nan=False))
    else:
        for key, value in result.items():
            if isinstance(value, dict):
                say(f"{key}:")
                for inner, number in value.items():
                    say(f"  {inner:24}{number:.6g}")
            elif value is not None:
                say(f"{key:20}{value:.6g}" if isinstance(value, float) else f"{key:20}{value}")
    return 1 if result["failure"] else 0
