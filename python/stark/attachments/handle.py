"""Attachments of a scene: forces, what has broken, enabling."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import as_array
from stark.attributes import KnownAttributes
from stark.handle import Handle, SceneLink, SimulationLink
from stark.readings import reading
from stark.selections import Points

Floats = NDArray[np.float64]


class Attachment(Handle, KnownAttributes):
    """Pairs of a scene that are glued: points of ``a``, each carried by ``b``."""

    def __init__(self, scene: SceneLink, index: int, a: Points, given: Mapping[str, Any]) -> None:
        super().__init__(scene, index)
        self._a = a
        self._given = given  # as the core was given it

    @property
    def name(self) -> str:
        """Name of the attachment, unique in its scene."""
        return self._scene._core.attachment_name(self._index)

    @property
    def points(self) -> Points:
        """The attached points of ``a``, in the order of the pairs."""
        return self._a

    @property
    def break_force(self) -> float:
        """Force [N] above which a pair breaks; inf: none breaks."""
        return float(self._given["break_force"])

    @property
    def forces(self) -> Floats:
        """Forces on the points of ``a`` in the last step (n, 3) [N], zero for pairs that were not held; what
        carries them gets the opposite. After a rewind, of the multipliers of the state, which differ by what
        residuals below a hundredth of the tolerance hold."""
        found = self._require_simulation("forces")._core.attachment_forces(self._index)
        return reading(found, self, "forces")

    @property
    def force(self) -> Floats:
        """Sum of ``forces``, on side a (3,) [N]."""
        return reading(np.asarray(self.forces.sum(axis=0)), self, "force")

    @property
    def gaps(self) -> Floats:
        """How far each pair is from where it is attached, held or not (n,) [m]: of a seam, how far it is
        open."""
        found = self._require_simulation("gaps")._core.attachment_gaps(self._index)
        return reading(found, self, "gaps")

    @property
    def broken(self) -> NDArray[np.bool_]:
        """Which pairs have broken (n,)."""
        return self._require_simulation("broken")._core.attachment_status(self._index) < 0

    @property
    def enabled(self) -> bool:
        """Whether it holds all that is not broken; assign False to release it and True to hold it again, from
        the next step on, but for broken pairs. Raises InvalidArgument where pairs are elsewhere by then
        than where they were attached; ``hold_here`` takes them where they are."""
        if self._newest() is None:
            return bool(self._given["enabled"])
        return not bool((self._require_simulation("enabled")._core.attachment_status(self._index) == 0).any())

    @enabled.setter
    def enabled(self, value: bool) -> None:
        if not isinstance(value, (bool, np.bool_)):
            raise InvalidArgument(f"attachment '{self.name}': enabled = {value!r}: must be True or False")
        core = self._require_simulation("enabled")._core
        if value:
            core.check_attachment_agrees(self._index)
        core.set_attachment_enabled(self._index, bool(value))

    def pull_together(self) -> None:
        """Holds its pairs again wherever they are, but for broken ones: the next step brings them to where
        they were attached, as seen from what carries them, at the speed of the way over the time step, with
        the energy of that, which comes from nowhere."""
        self._require_simulation("pull_together")._core.set_attachment_enabled(self._index, True)

    def hold_here(self, pairs: ArrayLike | None = None) -> None:
        """Holds pairs from the next step on with their points where they are now, as what carries them sees
        it: a suction cup, a picker. ``pairs``: numbers, or True for each that is meant (n,); None: all that
        have not broken. Only attachments that are added with ``enabled=False`` can do it, on rigid bodies,
        nodes of rods or the world. Raises InvalidArgument for others and for broken pairs; then nothing has
        changed."""
        core = self._require_simulation("hold_here")._core
        meant = np.flatnonzero(~self.broken).astype(np.int32) if pairs is None else self._numbers(pairs)
        core.hold_pairs_here(self._index, meant)

    def release(self, pairs: ArrayLike | None = None) -> None:
        """Releases pairs from the next step on. ``pairs``: as in ``hold_here``; None: all."""
        core = self._require_simulation("release")._core
        meant = np.arange(len(self), dtype=np.int32) if pairs is None else self._numbers(pairs)
        core.release_pairs(self._index, meant)

    @property
    def held(self) -> NDArray[np.bool_]:
        """Which pairs hold (n,)."""
        held: NDArray[np.bool_] = self._require_simulation("held")._core.attachment_status(self._index) == 1
        return held

    def _numbers(self, pairs: ArrayLike) -> NDArray[np.int32]:
        """Numbers of pairs that are given as such, or by a mask."""
        given = as_array(pairs, f"{self._title}: pairs")
        if given.dtype == np.bool_ and given.shape == (len(self),):
            return np.flatnonzero(given).astype(np.int32)
        if given.size == 0:
            return np.zeros(0, dtype=np.int32)
        if given.dtype.kind not in "iu" or given.ndim > 1:
            raise InvalidArgument(
                f"{self._title}: pairs of shape {given.shape} and type {given.dtype}: must be numbers of "
                f"pairs, or True or False for each of the {len(self)}"
            )
        numbers = np.atleast_1d(given)
        wrong = numbers[(numbers < 0) | (numbers >= len(self))]
        if wrong.size:
            raise InvalidArgument(f"{self._title}: pair {wrong[0]}: must be in [0, {len(self)})")
        return numbers.astype(np.int32)

    def __len__(self) -> int:
        """Number of pairs."""
        return len(self._a)

    def __repr__(self) -> str:
        return f"<stark.Attachment '{self.name}' of {len(self)} points>"

    @property
    def _title(self) -> str:
        return f"attachment '{self.name}'"

    def _count_in(self, simulation: SimulationLink) -> int:
        return simulation._core.attachment_count
