"""A checkpoint as a value: taken from a simulation, put into one."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from os import PathLike
from typing import Any, Self

from stark import _core
from stark._core import InvalidArgument
from stark.arguments import given_flag, given_path
from stark.caller import warn
from stark.steps import Stepping

from . import differences, file
from . import memory as memories
from .errors import CheckpointError
from .file import Content, Values


@dataclass(frozen=True)
class Checkpoint(Content):
    """Where a simulation is. ``Checkpoint.of(sim)``, ``Checkpoint.read(path)``; ``write(path)`` and
    ``put_into(sim)`` are the ways back. ``Simulation.save`` and ``load`` are these in one."""

    @classmethod
    def of(
        cls, sim: Stepping, *, memory: dict[str, Any] | None = None, run: dict[str, Any] | None = None
    ) -> Self:
        """Takes a copy of everything, so that the simulation may go on. Raises ``CheckpointError`` for a
        memory that no file can hold."""
        memories.check(memory)
        if sim._core.is_placing:
            raise CheckpointError(
                "bodies are being placed together, and not checked so far: must be saved after the block of "
                "sim.placing()"
            )
        return cls(
            scene=sim._scene.name,
            stark_version=_core.__version__,
            state=sim.state,
            settings=sim.settings.to_dict(),
            parts=sim._parts,
            energies=[live.name for live in sim._live_values],
            values=[live.present() for live in sim._live_values],
            # What was placed since is not what the last step led to.
            last=None if len(sim._core.placed_bodies) > 0 else sim._last_step,
            memory=copy.deepcopy(memory or {}),
            run=copy.deepcopy(run),
        )

    def write(self, path: str | PathLike[str]) -> None:
        """Writes the checkpoint to a file, in one piece. Raises ``CheckpointError`` if it cannot be
        written."""
        file.write(self, given_path(path, "checkpoint: path"))

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Self:
        """Raises ``CheckpointError`` for files that are missing, damaged or of another format."""
        return cls(**vars(file.read(given_path(path, "checkpoint: path"))))

    def put_into(self, sim: Stepping, *, exact: bool = True, owner: str = "checkpoint") -> None:
        """Makes a simulation go on from here, bit for bit, with sensors that read what they read.

        Raises ``CheckpointError`` and changes nothing when the scene or the settings are not the same; the
        number of threads and the back end may differ. ``exact=False`` accepts other materials, values,
        masses, rest shapes and settings, as long as bodies, joints and their numbers are the same."""
        sim._require_free("load()")
        exact = given_flag(exact, f"{owner}: exact")
        self._check_scene(sim, exact, owner)
        self._check_values(sim, owner)
        present, values = sim.state, [live.present() for live in sim._live_values]
        try:
            self._replay(sim) if exact and self.last is not None else self._set(sim)
        except InvalidArgument as error:
            sim.state = present
            _assign(sim, values)
            raise CheckpointError(f"{owner}: {error}") from None

    def _check_scene(self, sim: Stepping, exact: bool, owner: str) -> None:
        found = differences.of_parts(self.parts, sim._parts, structure_only=not exact)
        if exact:
            found += differences.of_settings(self.settings, sim.settings.to_dict())
        if found:
            remedy = (
                "make the scene and the settings that it was written with, or load it with exact=False to go "
                "on with these"
                if exact
                else "make a scene with the same bodies and joints"
            )
            raise CheckpointError(
                f"{owner}: is of another scene: it differs in {differences.listed(found)}; {remedy}"
            )

    def _check_values(self, sim: Stepping, owner: str) -> None:
        names = [live.name for live in sim._live_values]
        if names != self.energies:
            raise CheckpointError(
                f"{owner}: has values of the energies {self.energies}, the scene has {names}; make the scene "
                f"that it was written with"
            )
        for values in [self.values] + ([self.last.values] if self.last else []):
            for live, given in zip(sim._live_values, values, strict=True):
                what = f"{owner}: '{live.name}'"
                mine = live.present()
                if {n: v.shape for n, v in given.items()} != {n: v.shape for n, v in mine.items()}:
                    raise CheckpointError(f"{what}: has values of other parameters or shapes")
                try:
                    live.check(what, given)
                except InvalidArgument as error:
                    raise CheckpointError(str(error)) from None

    def _set(self, sim: Stepping) -> None:
        sim.state = self.state
        _assign(sim, self.values)

    def _replay(self, sim: Stepping) -> None:
        assert self.last is not None
        _assign(sim, self.last.values)
        for live in sim._live_values:
            live.push(sim._core)
        same = sim._core.resume(self.last.before, self.last.limit, self.state, self.last.placed)
        _assign(sim, self.values)
        sim._loaded = self.last if same else None
        if not same:
            warn(
                f"the last step before the checkpoint at {self.time:g} s, taken again, has other bits: this "
                f"Stark ({_core.__version__}, written by {self.stark_version}) computes differently; the "
                f"simulation goes on from the state of the checkpoint, but not as it would have"
            )


def _assign(sim: Stepping, values: list[Values]) -> None:
    for live, given in zip(sim._live_values, values, strict=True):
        live.assign(given)
