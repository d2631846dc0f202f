"""Ten real materials with the source of every number, and measured curves from the literature.

    rubber = stark.measured.rubber                 # Treloar's rubber, up to rupture
    for curve in stark.measured.treloar(): ...     # what it was fitted to

Unlike those of ``stark.materials``, which scenes and benchmarks use, these are not tuned for anything:
rubber is nearly incompressible (take quadratic elements), sheets are as thin as they are. ``.source``
begins with what the numbers are: a fit to a curve, a published fit or test, a data sheet, a handbook or a
standard. docs/fitting.md has the table."""

from stark.materials import RodMaterial, ShellMaterial, SolidMaterial
from stark.measured.curves import treloar
from stark.measured.laws import carroll, dispersed_fibres
from stark.measured.materials import (
    aluminium_foil,
    copper_wire,
    cotton,
    foam,
    paper,
    pet,
    rubber,
    skin,
    steel,
    terry_towel,
)

presets: dict[str, SolidMaterial | ShellMaterial | RodMaterial] = {
    "rubber": rubber,
    "foam": foam,
    "pet": pet,
    "paper": paper,
    "aluminium_foil": aluminium_foil,
    "copper_wire": copper_wire,
    "skin": skin,
    "terry_towel": terry_towel,
    "cotton": cotton,
    "steel": steel,
}
"""All of them by name."""

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
