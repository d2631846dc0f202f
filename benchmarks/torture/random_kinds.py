"""All kinds of random scenes by name."""

from __future__ import annotations

from collections.abc import Callable

from .case import Setup
from .random_containers import build_containers, draw_containers
from .random_impacts import build_impacts, draw_impacts
from .random_joints import build_joints, draw_joints
from .random_materials import build_materials, draw_materials
from .random_scenes import Description, Source, build, draw
from .random_squeezes import build_squeezes, draw_squeezes

KINDS: dict[str, tuple[Callable[[Source], Description], Callable[[Description], Setup]]] = {
    "mixed": (draw, build),
    "impacts": (draw_impacts, build_impacts),
    "joints": (draw_joints, build_joints),
    "containers": (draw_containers, build_containers),
    "squeezes": (draw_squeezes, build_squeezes),
    "materials": (draw_materials, build_materials),
}
