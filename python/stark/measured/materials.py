"""Ten real materials, and where their numbers come from. docs/fitting.md has the table."""

from __future__ import annotations

import math

from stark import materials
from stark.formulas import j2_plasticity
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial, plate
from stark.measured.laws import carroll, dispersed_fibres

_STEEL_MODULUS, _STEEL_RATIO, _STEEL_YIELD = 210e9, 0.3, 235e6
#: EN 1993-1-5 C.6: beyond yielding, the slope of stress over strain is Et = E/100. Over the plastic strain
#: alone that is H = E Et / (E - Et).
_STEEL_HARDENING = _STEEL_MODULUS / 99.0

rubber: SolidMaterial = carroll(
    a=1.451e5,
    b=0.3201,
    c=1.080e5,
    bulk_modulus=1.95e9,
    density=950.0,
    mass_damping=0.1,
    name="rubber",
    source="fit: vulcanised natural rubber with 8 % sulphur, three curves of Treloar, Trans. Faraday Soc. 40 "
    "(1944) 59, as tabulated by Steinmann et al. 2012; bulk modulus of natural rubber 1.95 GPa, Wood "
    "and Martin, J. Res. NBS 68A (1964) 259",
)
foam: SolidMaterial = materials.foam
pet: ShellMaterial = plate(
    youngs_modulus=5.0e9,
    poissons_ratio=0.38,
    thickness=23e-6,
    density=1390.0,
    name="pet",
    source="data sheet: polyester film Mylar 92A, DuPont Teijin Films H-37232-3: 710 kpsi along, 740 kpsi "
    "across the machine, averaged; Poisson's ratio before yield",
)
paper: ShellMaterial = materials.paper
aluminium_foil: ShellMaterial = plate(
    youngs_modulus=69e9,
    poissons_ratio=0.33,
    thickness=16e-6,
    density=2710.0,
    name="aluminium_foil",
    source="handbook: unalloyed aluminium 1100, ASM Handbook vol. 2 (1990); household foil of 16 "
    "micrometres; elastic only",
)
copper_wire: RodMaterial = RodMaterial(
    youngs_modulus=115e9,
    poissons_ratio=115.0 / (2.0 * 44.0) - 1.0,
    radius=0.5e-3,
    density=8890.0,
    mass_damping=0.1,
    name="copper_wire",
    source="handbook: copper C11000, moduli of 115 and 44 GPa, ASM Handbook vol. 2 (1990), density of IEC "
    "60028; wire of 1 mm; elastic only",
)
skin: SolidMaterial = dispersed_fibres(
    shear_modulus=0.2014e6,
    fibre_ratio=243.6,
    fibre_exponent=0.1327,
    dispersion=0.1404,
    angle=math.radians(41.0),
    bulk_modulus=1e9,
    density=1109.0,
    mass_damping=0.1,
    name="skin",
    source="published fit: human back skin along the Langer lines (first axis), tests of Ni Annaidh et al., "
    "Ann. Biomed. Eng. 40 (2012) 1666; k1 taken as a multiple of mu, as the strengths of their tests "
    "need; bulk modulus assumed, nearly incompressible",
)
terry_towel: ShellMaterial = materials.towel
cotton: ShellMaterial = ShellMaterial(
    density=0.1503,
    thickness=0.318e-3,
    youngs_modulus=0.821e6,
    poissons_ratio=0.243,
    bending_stiffness=1e-6,
    mass_damping=0.1,
    name="cotton",
    source="published test: plain woven cotton, Penava et al., Fibres Text. East. Eur. 22(2) (2014) 57, "
    "initial modulus as quoted by users of that table; bending stiffness of the preset "
    "stark.materials.cotton, not measured",
)
steel: SolidMaterial = j2_plasticity(
    shear_modulus=_STEEL_MODULUS / (2.0 * (1.0 + _STEEL_RATIO)),
    bulk_modulus=_STEEL_MODULUS / (3.0 * (1.0 - 2.0 * _STEEL_RATIO)),
    yield_stress=_STEEL_YIELD,
    hardening_modulus=_STEEL_HARDENING,
    density=7850.0,
    mass_damping=0.1,
    name="steel",
    source="standard: structural steel S235, EN 1993-1-1 sections 3.2.1 and 3.2.6, hardening of EN 1993-1-5 "
    "annex C.6",
)
