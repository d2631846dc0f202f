"""Flexes of MJCF files (``<flexcomp>``, ``<flex>``), of which mujoco makes a body for each vertex or node."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark.robots.description import Flex
from stark.robots.report import Report

Floats = NDArray[np.float64]

_SLIDE, _NO_SELF_CONTACT = 2, 0
#: Values of ``elastic2d`` with which a cloth bends.
_BENDING = (1, 3)


def flex_bodies(model: Any) -> set[int]:
    """Numbers of the bodies that stand for vertices or nodes: they slide, and have nothing else."""
    found = {int(body) for body in (*model.flex_vertbodyid, *model.flex_nodebodyid)}
    parents = set(np.asarray(model.body_parentid).tolist())
    return {body for body in found if body > 0 and body not in parents and _only_slides(model, body)}


def _only_slides(model: Any, body: int) -> bool:
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    return (
        count > 0
        and int(model.body_geomnum[body]) == 0
        and all(int(kind) == _SLIDE for kind in model.jnt_type[first : first + count])
    )


def read_flexes(spec: Any, model: Any, name_of: Callable[[int], str], report: Report) -> list[Flex]:
    """All that are cloth or solids and move. ``name_of``: links of bodies."""
    import mujoco

    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    reader = _Reader(model, data, name_of, report)
    found = [reader.read(number, described) for number, described in enumerate(spec.flexes)]
    return [flex for flex in found if flex is not None]


class _Reader:
    def __init__(self, model: Any, data: Any, name_of: Callable[[int], str], report: Report) -> None:
        self.model, self.data, self.name_of, self.report = model, data, name_of, report
        self.own = sorted(flex_bodies(model))

    def read(self, number: int, described: Any) -> Flex | None:
        model, name = self.model, str(described.name) or f"flex_{number}"
        title, size = f"flex '{name}'", int(model.flex_dim[number]) + 1
        carriers = self._carriers(number)
        free = np.isin(carriers, self.own)
        if size == 2:
            text = "a line, for which a file has no stiffness of bending: add a rod with scene.add_rod"
            self.report.add("dropped", title, text, warn=True)
            return None
        if not free.any():
            text = "no vertex of it moves by itself: add its shape to the scene"
            self.report.add("dropped", title, text, warn=True)
            return None
        link = min(
            {int(model.body_parentid[body]) for body in carriers[free]} | set(carriers[~free].tolist())
        )
        start = int(model.flex_elemdataadr[number])
        cells = model.flex_elem[start : start + size * int(model.flex_elemnum[number])]
        r, g, b = (float(value) for value in model.flex_rgba[number][:3])
        return Flex(
            name,
            self.name_of(link),
            self._vertices(number, link),
            np.array(cells, dtype=np.int32).reshape(-1, size),
            # mujoco leaves out the mass of vertices that are fixed.
            mass=float(model.body_mass[carriers[free]].sum()) * len(carriers) / int(free.sum()),
            held=self._held(number, carriers, free, link, title),
            youngs_modulus=float(described.young),
            poissons_ratio=float(described.poisson),
            thickness=max(0.0, float(described.thickness)),
            bends=int(described.elastic2d) in _BENDING,
            damping=float(described.damping),
            radius=float(model.flex_radius[number]),
            touches=bool(model.flex_contype[number] or model.flex_conaffinity[number]),
            touches_itself=int(model.flex_selfcollide[number]) != _NO_SELF_CONTACT,
            color=(r, g, b),
        )

    def _has_nodes(self, number: int) -> bool:
        """Whether vertices follow the nodes of coarser cells."""
        return int(self.model.flex_interp[number]) != 0

    def _carriers(self, number: int) -> NDArray[np.int32]:
        """Bodies of its vertices, or of its nodes."""
        model = self.model
        if self._has_nodes(number):
            first, count = int(model.flex_nodeadr[number]), int(model.flex_nodenum[number])
            return np.array(model.flex_nodebodyid[first : first + count])
        first, count = int(model.flex_vertadr[number]), int(model.flex_vertnum[number])
        return np.array(model.flex_vertbodyid[first : first + count])

    def _vertices(self, number: int, link: int) -> Floats:
        """Where they are at rest, in the frame of a body."""
        first, count = int(self.model.flex_vertadr[number]), int(self.model.flex_vertnum[number])
        turned = np.array(self.data.xmat[link]).reshape(3, 3)
        away: Floats = np.array(self.data.flexvert_xpos[first : first + count]) - self.data.xpos[link]
        rest: Floats = away @ turned
        return rest

    def _held(
        self, number: int, carriers: NDArray[np.int32], free: NDArray[np.bool_], link: int, title: str
    ) -> tuple[int, ...]:
        if self._has_nodes(number):
            self.report.add(
                "kept", title, "all its vertices move, not only the nodes of the coarse cells of the file"
            )
            if not free.all():
                self.report.add("dropped", title, "nodes that are fixed: use scene.attach for its vertices")
            return ()
        if (carriers[~free] != link).any():
            self.report.add(
                "dropped", title, f"vertices that are fixed to others than '{self.name_of(link)}'"
            )
        return tuple(np.flatnonzero(~free & (carriers == link)).tolist())
