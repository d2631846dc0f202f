"""``Scene``: attachments. The work is done in stark.attachments.adding, imported when first used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stark.attachments.handle import Attachment
from stark.bodies import Body
from stark.caller import warn
from stark.handle import SceneLink
from stark.named import NamedTuple
from stark.selections import Points, Stencils

if TYPE_CHECKING:
    from stark.formulas.handle import Energy


class SceneAttachments(SceneLink):
    """``Scene``: attachments."""

    _attachments: list[Attachment]

    def add(self, energy: Any, *, name: str | None = None) -> Energy:
        raise NotImplementedError  # of Scene

    def attach(
        self,
        a: Body | Points | Stencils | str,
        b: Body | Points | str | None,
        *,
        distance: float | None = None,
        pairs: ArrayLike | None = None,
        break_force: float | None = None,
        contact: bool = True,
        enabled: bool = True,
        name: str | None = None,
    ) -> Attachment:
        """Glues points of ``a`` to ``b``, where they are at time 0.

        ``a``: points (``cloth.vertices[[0, 5]]``, ``cloth.faces[mask]``, ``box.points(...)``), or a body, of
        which ``distance`` or ``pairs`` choose vertices. ``b``: a body (each point is carried by the nearest
        place of its surface), points (as many as in ``a``, or the nearest ones with ``distance``), or None
        for the world. ``distance`` [m]: only points that are this near to ``b``. ``pairs`` (n, 2): indices of
        vertices of the bodies ``a`` and ``b``. ``break_force`` [N]: a pair whose force exceeds it in a step
        is released for good.

        Surfaces around attached vertices do not touch the other body; with ``contact=False`` the two bodies
        do not touch at all."""
        from stark.attachments.adding import attach
        from stark.attachments.seams import gaping_seam, glued_to_finer, repeated_points

        attachment = attach(
            self,
            a,
            b,
            distance=distance,
            pairs=pairs,
            break_force=break_force,
            contact=contact,
            enabled=enabled,
            name=name,
        )
        self._attachments.append(attachment)
        self._warn_of_late(f"attachment '{attachment.name}'")
        carrier = b.body if isinstance(b, Points) else self[b] if isinstance(b, str) and b != "world" else b
        for found in (gaping_seam, glued_to_finer):
            if doubt := found(attachment.points, carrier if isinstance(carrier, Body) else None):
                warn(f"attachment '{attachment.name}': {doubt}")
        if repeats := repeated_points(attachment._given, len(attachment.points)):
            warn(f"attachment '{attachment.name}': {repeats}")
        return attachment

    def sew(
        self,
        a: Body | Points | str,
        b: Body | Points | str,
        *,
        pairs: ArrayLike | None = None,
        duration: float = 0.5,
        force: float = 1.0,
        break_force: float | None = None,
        name: str | None = None,
    ) -> Attachment:
        """Sews points that are apart at time 0: threads draw each pair together, and
        ``seam.pull_together()`` fastens it then, for good.

        ``a`` and ``b``: as many points on both sides, or bodies with ``pairs`` (n, 2), indices of their
        vertices. Each thread becomes shorter until it has no length after ``duration`` [s], and pulls with
        ``force`` [N] at most; ``seam.gaps`` says how far the pairs are apart. Threads are an energy,
        ``scene.energies["<name of the seam> threads"]``; at an extension of its ``reach``, 1 mm at first,
        they pull with 0.7 of the force. Surfaces around the points do not touch the other
        body from time 0 on, so that they can meet. ``break_force`` [N] as in ``attach``."""
        from stark.attachments.adding import sew
        from stark.attachments.sewing import check_thread, threads

        check_thread(name, duration, force)
        seam, others = sew(self, a, b, pairs=pairs, break_force=break_force, name=name)
        self._attachments.append(seam)
        lengths = np.linalg.norm(seam.points.positions - others.positions, axis=1)
        bound = threads(seam.points, others, length=lengths, duration=duration, force=force)
        self.add(bound, name=f"{seam.name} threads")
        self._warn_of_late(f"attachment '{seam.name}'")
        return seam

    @property
    def attachments(self) -> NamedTuple[Attachment]:
        """Attachments in the order of adding."""
        return NamedTuple("attachment", self._attachments, self)
