"""Ten real materials with the source of every number, and measured curves from the literature.

    rubber = stark.measured.rubber                 # Treloar's rubber, up to rupture
    for curve in stark.measured.treloar(): ...     # what it was fitted to

Unlike those of ``stark.materials``, which scenes and benchmarks use, these are not tuned for anything:
rubber is nearly incompressible (take quadratic elements), sheets are as thin as they are. ``.source``
begins with what the numbers are: a fit to a curve, a published fit or test, a data sheet, a handbook or a
standard. docs/fitting.md has the table."""

from stark.measured.curves import treloar
from stark.measured.laws import carroll, dispersed_fibres
from stark.measured.presets import (
    aluminium_foil,
    copper_wire,
    cotton,
    foam,
    paper,
    pet,
    presets,
    rubber,
    skin,
    steel,
    terry_towel,
)

__all__ = [
    "aluminium_foil",
    "carroll",
    "copper_wire",
    "cotton",
    "dispersed_fibres",
    "foam",
    "paper",
    "pet",
    "presets",
    "rubber",
    "skin",
    "steel",
    "terry_towel",
    "treloar",
]
