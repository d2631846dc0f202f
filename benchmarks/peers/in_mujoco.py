"""The cases in MuJoCo: as it comes, and with what its documentation recommends against slip: elliptic cones,
a high ratio of frictional to normal impedance, iterations against slip (XML reference, option); with those
also in steps as long as Stark's."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from cases import (
    ABOVE,
    BELOW,
    CELLS,
    CUBE,
    DENSITY,
    FRICTION,
    PILE_TIME,
    POISSON,
    SETTLE,
    SLIDE,
    SPIN,
    SPIN_MASS,
    SPIN_SIZE,
    SPIN_TIME,
    YOUNG,
    leaning,
    of_cube,
    of_incline,
    of_pile,
    of_spin,
    pile,
    timed,
)

AGAINST_SLIP = 'cone="elliptic" impratio="10" noslip_iterations="20" tolerance="1e-10"'
OPTIONS = {
    "as it comes, steps of 2 ms": 'timestep="0.002"',
    "elliptic cones, impratio 10, 20 noslip iterations, steps of 2 ms": f'timestep="0.002" {AGAINST_SLIP}',
    "the same in steps of 10 ms": f'timestep="0.01" {AGAINST_SLIP}',
}


def model(option: str, body: str, gravity: tuple[float, float, float]) -> Any:
    text = " ".join(f"{g:.17g}" for g in gravity)
    xml = f"""<mujoco><option {option} gravity="{text}"/><worldbody>
        <geom type="plane" size="10 10 1" friction="{FRICTION} 0.005 0.0001"/>{body}</worldbody></mujoco>"""
    return mujoco.MjModel.from_xml_string(xml)


def cube(place: Any, yaw: float = 0.0) -> str:
    position = " ".join(f"{x:.17g}" for x in place)
    return f"""<body pos="{position}" euler="0 0 {np.degrees(yaw):.17g}"><freejoint/><geom type="box"
        size="0.05 0.05 0.05" mass="1" friction="{FRICTION} 0.005 0.0001"/></body>"""


def incline(option: str, share: float) -> dict[str, float]:
    m = model(option, cube((0.0, 0.0, 0.05)), leaning(share))
    d = mujoco.MjData(m)
    count = round(SLIDE / m.opt.timestep)
    cpu, seen = timed(lambda: mujoco.mj_step(m, d), count, lambda: float(d.qpos[0]))
    return {"cpu_s": cpu / SLIDE} | of_incline(np.array(seen), m.opt.timestep, share)


def free_spin(option: str) -> dict[str, float]:
    size = " ".join(f"{0.5 * s:g}" for s in SPIN_SIZE)
    body = f'<body pos="0 0 5"><freejoint/><geom type="box" size="{size}" mass="{SPIN_MASS}"/></body>'
    m = model(option, body, (0.0, 0.0, 0.0))
    d = mujoco.MjData(m)
    d.qvel[3:6] = SPIN  # in the frame of the body, which is not turned yet
    cpu, _ = timed(lambda: mujoco.mj_step(m, d), round(SPIN_TIME / m.opt.timestep))
    rotation = d.xmat[1].reshape(3, 3)
    mujoco.mj_kinematics(m, d)
    return {"cpu_s": cpu / SPIN_TIME} | of_spin(rotation, rotation @ d.qvel[3:6])


def rigid_pile_27(option: str) -> dict[str, float]:
    m = model(option, "".join(cube(*place) for place in pile()), (0.0, 0.0, -9.81))
    d = mujoco.MjData(m)
    cpu, _ = timed(lambda: mujoco.mj_step(m, d), round(PILE_TIME / m.opt.timestep))
    mujoco.mj_kinematics(m, d)
    return {"cpu_s": cpu / PILE_TIME} | of_pile(d.xpos[1:].copy(), d.xmat[1:].reshape(-1, 3, 3).copy())


def soft_cube(kind: str, count: int, step: float, damping: float) -> dict[str, float]:
    """A flex of a grid of nodes, all of them unknowns ("full") or those of one trilinear cell."""
    spacing = CUBE / (count - 1)
    xml = f"""<mujoco><option timestep="{step}" solver="CG" tolerance="1e-8"/><size memory="200M"/><worldbody>
        <geom type="plane" size="10 10 1" friction="{FRICTION} 0.005 0.0001"/>
        <flexcomp name="cube" type="grid" count="{count} {count} {count}"
          spacing="{spacing} {spacing} {spacing}"
          pos="0 0 {0.5 * CUBE + 0.003}" dim="3" radius="0.001" mass="{DENSITY * CUBE**3}" dof="{kind}">
          <elasticity young="{YOUNG}" poisson="{POISSON}" damping="{damping}"/>
          <contact selfcollide="none" friction="{FRICTION} 0.005 0.0001"/>
        </flexcomp></worldbody></mujoco>"""
    m = mujoco.MjModel.from_xml_string(xml)
    d = mujoco.MjData(m)
    mujoco.mj_forward(m, d)
    z = d.flexvert_xpos[:, 2].copy()
    top, foot = z > z.max() - 1e-9, z < z.min() + 1e-9
    cpu, _ = timed(lambda: mujoco.mj_step(m, d), round(SETTLE / m.opt.timestep))
    mujoco.mj_forward(m, d)
    now = d.flexvert_xpos[:, 2]
    return {"cpu_s": cpu / SETTLE, "unknowns": float(m.nv)} | of_cube(
        float(now[top].mean() - now[foot].mean())
    )


def run(case: str) -> list[dict[str, Any]]:
    """Rows of a case."""
    if case == "soft_cube":
        kinds = {
            "flex, all nodes": ("full", CELLS + 1, 0.0005, 0.002),  # with steps of 1 ms it becomes unstable
            "flex, one trilinear cell": ("trilinear", CELLS + 1, 0.004, 0.005),
        }
        rows = []
        for words, kind in kinds.items():
            row = soft_cube(*kind)
            words += f", {row.pop('unknowns'):,.0f} unknowns, steps of {1e3 * kind[2]:g} ms"
            rows.append({"settings": words} | row)
        return rows
    options = dict(OPTIONS)
    if case == "free_spin":
        options = {"as it comes, steps of 2 ms": options["as it comes, steps of 2 ms"]}
        options["RK4, steps of 2 ms"] = 'timestep="0.002" integrator="RK4"'
        options["RK4, steps of 10 ms"] = 'timestep="0.01" integrator="RK4"'
    jobs: dict[str, Any] = {"free_spin": free_spin, "rigid_pile_27": rigid_pile_27}
    jobs["incline_below"] = lambda option: incline(option, BELOW)
    jobs["incline_above"] = lambda option: incline(option, ABOVE)
    return [{"settings": words} | jobs[case](option) for words, option in options.items()]


VERSION = f"MuJoCo {mujoco.__version__}"
