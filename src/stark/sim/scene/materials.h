// Materials of cloth, solids and rods: plain parameters with units, a descriptor table each, and presets.
// They say nothing about energies; sim/model picks the potentials.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <stark/base/reading.h>
#include <stark/base/settings.h>

namespace stark {

/// What a strain limit bounds: the eigenvalues of the Green strain (s^2 - 1)/2 of a stretch s, in every
/// direction; or the stretch minus 1 of the edges of the mesh, which leaves directions without edges free.
enum class StrainLimitLaw : uint8_t { GreenStrain, Edges };
template <>
struct EnumNames<StrainLimitLaw> {
  static constexpr std::array<std::string_view, 2> kNames{"green_strain", "edges"};
};

/// Cloth and thin shells. Membrane: Neo-Hookean with thickness h; bending: discrete hinges with a stiffness
/// in joules [Bergou 2006]; above strain_limit a stiffening term acts; damping is relative to the strain and
/// bending rates.
struct ShellMaterial {
  double density = 0.2;         ///< [kg/m^2] mass of a unit of area
  double thickness = 1e-3;      ///< [m] of the membrane energy only; contact has its own distance
  double youngs_modulus = 5e3;  ///< [Pa]
  double poissons_ratio = 0.3;
  double strain_limit = std::numeric_limits<double>::infinity();  ///< see StrainLimitLaw; infinity: no limit
  double strain_limit_stiffness = 1e6;                            ///< [Pa]
  double strain_limit_hardening = 500.0;  ///< growth of that stiffness, as a factor; 0: as published
  StrainLimitLaw strain_limit_law = StrainLimitLaw::GreenStrain;
  double bending_stiffness = 1e-6;  ///< [J] of hinges, cheap but dependent on the mesh
  double flexural_rigidity = 0.0;   ///< [N m] of a plate; where positive, in place of the hinges
  double yield_stress = std::numeric_limits<double>::infinity();  ///< [Pa] of von Mises; infinity: elastic
  double hardening_modulus = 0.0;     ///< [Pa] growth of the yield stress with plastic strain
  double bending_yield_moment = 0.0;  ///< [N] moment per length; 0: of the yield stress and the thickness
  double bending_hardening = 0.0;     ///< [N m] growth of it with plastic curvature; 0: of the thickness
  double mass_damping = 0.0;          ///< [1/s]
  double strain_damping = 0.0;        ///< [N s/m]
  double bending_damping = 0.0;       ///< [J s]
  double thermal_expansion = 0.0;     ///< [1/K] of bodies with a temperature
  static const FieldTable& fields();
};

/// Soft solids: stable Neo-Hookean [Smith 2018] in Lame parameters of linear elasticity.
struct SolidMaterial {
  double density = 1000.0;      ///< [kg/m^3]
  double youngs_modulus = 1e4;  ///< [Pa]
  double poissons_ratio = 0.3;
  double strain_limit = std::numeric_limits<double>::infinity();  ///< see StrainLimitLaw; infinity: no limit
  double strain_limit_stiffness = 1e2;                            ///< [Pa]
  double strain_limit_hardening = 500.0;  ///< growth of that stiffness, as a factor; 0: as published
  StrainLimitLaw strain_limit_law = StrainLimitLaw::GreenStrain;
  double mass_damping = 0.0;       ///< [1/s]
  double strain_damping = 0.0;     ///< [Pa s]
  double thermal_expansion = 0.0;  ///< [1/K] of bodies with a temperature
  static const FieldTable& fields();
};

/// Rods: Kirchhoff's rod with stretch, of a round or rectangular section. Stiffnesses of 0 are those of the
/// section.
struct RodMaterial {
  double density = 1000.0;      ///< [kg/m^3]
  double youngs_modulus = 1e6;  ///< [Pa]
  double poissons_ratio = 0.3;
  double radius = 1e-3;              ///< [m] of a round section; also the contact distance
  double width = 0.0, height = 0.0;  ///< [m] along the axes d1 and d2; 0: the section is round
  double axial_stiffness = 0.0;      ///< [N]
  double shear_stiffness = 0.0;      ///< [N]
  double bending_stiffness_1 = 0.0;  ///< [N m^2] about the axis d1
  double bending_stiffness_2 = 0.0;  ///< [N m^2] about the axis d2
  double torsional_stiffness = 0.0;  ///< [N m^2]
  double yield_stress = std::numeric_limits<double>::infinity();  ///< [Pa] in tension; infinity: elastic
  double hardening_modulus = 0.0;  ///< [Pa] growth of the yield stress with plastic strain
  double yield_force = 0.0;        ///< [N] of these four, 0: of the yield stress and the section
  double yield_moment_1 = 0.0;     ///< [N m] about the axis d1
  double yield_moment_2 = 0.0;     ///< [N m] about the axis d2
  double yield_torque = 0.0;       ///< [N m]
  double mass_damping = 0.0;       ///< [1/s]
  double strain_damping = 0.0;     ///< [s] relaxation time of stretch, bending and twist
  double thermal_expansion = 0.0;  ///< [1/K] of bodies with a temperature
  static const FieldTable& fields();
};

/// What a cross-section gives a rod, per rest length.
struct RodSection {
  double mass = 0.0;                          ///< [kg/m]
  std::array<double, 2> second_moments{};     ///< integral of rho X_k^2 along d1 and d2 [kg m]
  double axial_stiffness = 0.0;               ///< EA [N]
  double shear_stiffness = 0.0;               ///< k G A [N] with the shear factor of Cowper 1966
  std::array<double, 2> bending_stiffness{};  ///< E I about d1 and d2 [N m^2]
  double torsional_stiffness = 0.0;           ///< G J [N m^2] with Saint-Venant's torsion constant
  /// Where the whole section yields, at the yield stress in tension and at that over the root of 3 in shear.
  double yield_force = 0.0;               ///< [N]
  std::array<double, 2> yield_moments{};  ///< about d1 and d2 [N m]
  double yield_torque = 0.0;              ///< [N m]
  double yield_hardening = 0.0;           ///< growth of all four, as a factor, per plastic work [m/J]
  /// Whether any of the four is finite.
  bool yields() const;
};
RodSection section_of(const RodMaterial& material);
template <>
struct Readings<RodSection> {
  using S = RodSection;
  static constexpr std::tuple kAll{
      reading<&S::mass>("mass"),
      reading<&S::axial_stiffness>("axial_stiffness"),
      reading<&S::shear_stiffness>("shear_stiffness"),
      Reading{"bending_stiffness_1", "", [](const S& s) { return s.bending_stiffness[0]; }},
      Reading{"bending_stiffness_2", "", [](const S& s) { return s.bending_stiffness[1]; }},
      reading<&S::torsional_stiffness>("torsional_stiffness"),
      reading<&S::yield_force>("yield_force"),
      Reading{"yield_moment_1", "", [](const S& s) { return s.yield_moments[0]; }},
      Reading{"yield_moment_2", "", [](const S& s) { return s.yield_moments[1]; }},
      reading<&S::yield_torque>("yield_torque"),
      reading<&S::yield_hardening>("yield_hardening")};
};

/// Where the bending of a shell yields.
struct BendingYield {
  double moment = 0.0;     ///< per length [N], may be infinite
  double hardening = 0.0;  ///< [N m]
};
BendingYield bending_yield_of(const ShellMaterial& material);

/// Throws InvalidArgument naming owner, parameter, value, unit and rule.
void validate(const ShellMaterial& material, std::string_view owner);
void validate(const SolidMaterial& material, std::string_view owner);
void validate(const RodMaterial& material, std::string_view owner);

namespace materials {

ShellMaterial cotton();  ///< light woven cotton
/// Thin plate of an elastic material: flexural rigidity E t^3 / (12 (1 - nu^2)), mass rho t per area, mass
/// damping 0.1/s.
ShellMaterial plate(double youngs_modulus, double poissons_ratio, double thickness, double density);
ShellMaterial paper();        ///< office paper of 80 g/m^2
ShellMaterial pet();          ///< polyester film of 0.145 mm, a thin drinking cup
ShellMaterial steel_sheet();  ///< spring steel of 0.1 mm
ShellMaterial towel();        ///< terry towel, 1.75 m x 0.75 m of 0.484 kg
SolidMaterial soft_rubber();
SolidMaterial silicone();        ///< soft platinum-cure silicone (Ecoflex 00-30)
SolidMaterial foam();            ///< flexible polyurethane foam of 30 kg/m^3
SolidMaterial natural_rubber();  ///< unfilled vulcanisate of 40 IRHD
SolidMaterial pet_solid();       ///< polyester, semi-finished blocks
SolidMaterial steel();           ///< structural steel
RodMaterial steel_wire();        ///< spring steel, 1 mm thick
RodMaterial rubber_cord();       ///< natural rubber, 4 mm thick

/// One row of the reference table: name, where the numbers come from, values.
template <typename Material>
struct Preset {
  std::string name;
  std::string source;
  Material material;
};
const std::vector<Preset<ShellMaterial>>& shell_presets();
const std::vector<Preset<SolidMaterial>>& solid_presets();
const std::vector<Preset<RodMaterial>>& rod_presets();

}  // namespace materials
}  // namespace stark
