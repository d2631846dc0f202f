"""Simulations of a scene: which one its handles read, and warnings of changes that come too late for it."""

from __future__ import annotations

import warnings
import weakref
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stark.bodies import Body
    from stark.simulation import Simulation


class StarkWarning(UserWarning):
    """Something that can be simulated but is probably not meant."""


class SceneSimulations:
    """What a scene knows of its simulations."""

    _simulations: list[weakref.ref[Simulation]]  # in the order in which they were made
    _simulated_bodies: int  # that some simulation had

    def _begin_simulations(self) -> None:
        self._simulations, self._simulated_bodies = [], 0

    def _is_simulated_by(self, simulation: Simulation) -> None:
        """Handles of the scene read the newest simulation that is alive. Weak, or a scene would keep all of
        its simulations alive."""
        self._simulations = [known for known in self._simulations if known() is not None]
        self._simulations.append(weakref.ref(simulation))
        self._simulated_bodies = max(self._simulated_bodies, simulation._core.body_count)

    def _latest_simulation(self) -> Simulation | None:
        for known in reversed(self._simulations):
            if (simulation := known()) is not None:
                return simulation
        return None

    def _warn_of_late(self, what: str) -> None:
        """After something that acts was added to a scene that is being simulated."""
        if self._latest_simulation() is not None:
            warnings.warn(
                f"{what}: was added after the simulation was made: it acts in simulations made from now on, "
                f"not in that one; add it before stark.Simulation(scene) is made, or make a new one",
                StarkWarning,
                stacklevel=4,
            )

    def _warn_of_simulation(self, body: Body, what: str) -> None:
        """After a change of a body that one may take for a change of the simulation that it is in."""
        latest = self._latest_simulation()
        if latest is not None and body._index < latest._core.body_count:
            warnings.warn(
                f"'{body.name}': {what}: holds in simulations made from now on, not in the one that was "
                f"made; {what} before stark.Simulation(scene) is made, or make a new one",
                StarkWarning,
                stacklevel=3,
            )
