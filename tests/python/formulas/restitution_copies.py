"""Copy of the built-in potential of restitution as users write it."""

from __future__ import annotations

import stark


@stark.energy
def restitution(
    s: stark.Stencil[6],
    target: float,
    gain: float,
    push: float,
    pull: float,
    duration: float,
    share0: stark.Vec3,
    share1: stark.Vec3,
    share2: stark.Vec3,
    share3: stark.Vec3,
    share4: stark.Vec3,
    share5: stark.Vec3,
):
    way = 0.0
    for p, share in zip(list(s), (share0, share1, share2, share3, share4, share5), strict=True):
        way = way + stark.dot(share, p.x - p.x_prev)
    y = gain * (target - way / duration)
    above, below = push * (y - 0.5 * push), pull * (-y - 0.5 * pull)
    psi = stark.where(y > push, above, stark.where(y < -pull, below, 0.5 * stark.square(y)))
    return duration / gain * psi
