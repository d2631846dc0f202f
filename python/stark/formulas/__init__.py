"""Energies and materials of the user's own: formulas of points and parameters, written in Python.
docs/energies.md is the guide."""

from stark.formulas.arguments import Time, TimeStep
from stark.formulas.energy import EnergyFormula, energy
from stark.formulas.frames import Frame
from stark.formulas.handle import Energy
from stark.formulas.internal import internal
from stark.formulas.kinematics import Edge, Hinge, Point, Stencil, Tetrahedron, Triangle
from stark.formulas.material import CauchyGreen, DeformationGradient, ShellDeformationGradient, material
from stark.formulas.material_law import MaterialLaw
from stark.formulas.parameters import parameter
from stark.formulas.plasticity import j2_plasticity, j2_viscoplasticity
from stark.formulas.softening import ogden_roxburgh
from stark.formulas.viscoelasticity import (
    generalized_maxwell,
    generalized_maxwell_rod,
    generalized_maxwell_shell,
)
from stark.selections import stencils, world_frame, world_points
from stark.symbolic.signature import Mat2, Mat3, Vec2, Vec3, Vec4

__all__ = [
    "CauchyGreen",
    "DeformationGradient",
    "Edge",
    "Energy",
    "EnergyFormula",
    "Frame",
    "Hinge",
    "Mat2",
    "Mat3",
    "MaterialLaw",
    "Point",
    "ShellDeformationGradient",
    "Stencil",
    "Tetrahedron",
    "Time",
    "TimeStep",
    "Triangle",
    "Vec2",
    "Vec3",
    "Vec4",
    "energy",
    "generalized_maxwell",
    "generalized_maxwell_rod",
    "generalized_maxwell_shell",
    "internal",
    "j2_plasticity",
    "j2_viscoplasticity",
    "material",
    "ogden_roxburgh",
    "parameter",
    "stencils",
    "world_frame",
    "world_points",
]

# Signatures and messages name the public place.
for _type in (Edge, Energy, Frame, Hinge, Point, Stencil, Tetrahedron, Time, TimeStep, Triangle):
    _type.__module__ = "stark"
