"""Makes the simulation of a reproducer again, right before the step."""

from __future__ import annotations

import warnings
from typing import Any

from stark import _core
from stark.bodies import HANDLES
from stark.checkpoint import memory
from stark.errors import StarkWarning

from .errors import ReproducerError
from .formulas import ReadFormulas
from .parts import from_data

#: Of an energy: values that the step took where they are not those that it was added with.
VALUES = "values_of_the_step"


def simulation_of(
    header: dict[str, Any], arrays: dict[str, Any], owner: str, classes: tuple[Any, Any]
) -> Any:
    """The simulation of what a file holds. ``classes``: ``stark.Scene`` and ``stark.Simulation``, which stand
    above."""
    new_scene, new_simulation = classes
    needed = [row["what"] for row in header["missing"] if row["call"] != "add_energy"]
    if needed:
        raise ReproducerError(
            f"{owner}: {', '.join(needed)} could not be written, because their formulas are not "
            f"recorded or too long, and the state does not fit a scene without; make the scene with its own "
            f"script and load a checkpoint"
        )
    scene = new_scene(str(header["scene"]))
    formulas = ReadFormulas(header["formulas"])
    live: list[Any] = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StarkWarning)  # given when the scene was made
        for name, arguments in header["calls"]:
            given = from_data(memory.decode(arguments, arrays), formulas)
            if name == "add_energy":
                live.append(given[0].pop(VALUES))
            _repeat(scene, name, given)
        sim = new_simulation(scene, **header["settings"])
    for energy, values in enumerate(live):
        for name, numbers in values.items():
            sim._core.set_energy_value(energy, name, numbers)
    state = _core.State.of_arrays(
        {n.removeprefix("state/"): a for n, a in arrays.items() if n[:6] == "state/"}
    )
    if state.hash != header["state_hash"]:
        raise ReproducerError(f"{owner} is damaged (state); write it again")
    sim.state = state
    return sim


def _repeat(scene: Any, name: str, arguments: list[Any]) -> None:
    """A call on the core, and a handle of the body that it adds."""
    if name not in _CALLS:
        raise ValueError(f"unknown call '{name}'")
    if name == "default_friction":
        scene.default_friction = arguments[0]
        return
    index = getattr(scene._core, name)(*arguments)
    if name in _BODIES:
        handle, given = _BODIES[name], arguments[0]
        scene._append(handle(scene, index, handle._mesh_of(given), given["color"]))


_BODIES = {f"add_{kind}": handle for kind, handle in HANDLES.items()}
_CALLS = {
    *_BODIES,
    *("add_skin", "add_fibres", "add_energy", "add_joint", "add_actuator", "add_attachment"),
    *("set_actuator_value", "set_actuator_enabled", "pin", "clamp", "set_rest_state"),
    *("set_friction", "set_anisotropic_friction", "set_restitution", "set_surface_directions"),
    "set_surface_motion",
    *("disable_contact", "enable_contact", "disable_contacts", "enable_contacts", "default_friction"),
}
