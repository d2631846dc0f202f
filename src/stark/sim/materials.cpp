// Descriptor tables of the materials and the presets with their sources. See materials.h.
#include <stark/sim/materials.h>

namespace stark {

const FieldTable& ShellMaterial::fields() {
  using S = ShellMaterial;
  static const FieldTable table(
      "ShellMaterial", TableKind::Parameters,
      {field(&S::density, "density", "kg/m^2", positive(), "mass of a unit of area"),
       field(&S::thickness, "thickness", "m", positive(), "thickness of the membrane"),
       field(&S::youngs_modulus, "youngs_modulus", "Pa", positive(), "Young's modulus of the membrane"),
       field(&S::poissons_ratio, "poissons_ratio", "1", half_open_interval(0.0, 0.5),
             "Poisson's ratio of the membrane"),
       field(&S::strain_limit, "strain_limit", "1", positive_or_infinity(),
             "principal Green strain above which the membrane stiffens"),
       field(&S::strain_limit_stiffness, "strain_limit_stiffness", "Pa", non_negative(),
             "stiffness above the strain limit"),
       field(&S::bending_stiffness, "bending_stiffness", "J", non_negative(),
             "bending stiffness of the hinges, cheap but dependent on the mesh"),
       field(
           &S::flexural_rigidity, "flexural_rigidity", "N m", non_negative(),
           "rigidity E t^3 / (12 (1 - nu^2)) of a plate, the same on every mesh; where positive, in place of "
           "bending_stiffness"),
       field(&S::mass_damping, "mass_damping", "1/s", non_negative(), "damping rate of all motion"),
       field(&S::strain_damping, "strain_damping", "N s/m", non_negative(),
             "damping of the rate of Green strain"),
       field(&S::bending_damping, "bending_damping", "J s", non_negative(),
             "damping of the rate of the hinge angles")});
  return table;
}

const FieldTable& SolidMaterial::fields() {
  using S = SolidMaterial;
  static const FieldTable table(
      "SolidMaterial", TableKind::Parameters,
      {field(&S::density, "density", "kg/m^3", positive(), "mass of a unit of volume"),
       field(&S::youngs_modulus, "youngs_modulus", "Pa", positive(), "Young's modulus"),
       field(&S::poissons_ratio, "poissons_ratio", "1", open_interval(0.0, 0.5), "Poisson's ratio"),
       field(&S::strain_limit, "strain_limit", "1", positive_or_infinity(),
             "principal Green strain above which the solid stiffens"),
       field(&S::strain_limit_stiffness, "strain_limit_stiffness", "Pa", non_negative(),
             "stiffness above the strain limit"),
       field(&S::mass_damping, "mass_damping", "1/s", non_negative(), "damping rate of all motion"),
       field(&S::strain_damping, "strain_damping", "Pa s", non_negative(),
             "damping of the rate of Green strain")});
  return table;
}

void validate(const ShellMaterial& material, std::string_view owner) {
  ShellMaterial::fields().validate(&material, owner);
}

void validate(const SolidMaterial& material, std::string_view owner) {
  SolidMaterial::fields().validate(&material, owner);
}

namespace materials {

ShellMaterial cotton() {
  return {.density = 0.2,
          .thickness = 1e-3,
          .youngs_modulus = 5e3,
          .poissons_ratio = 0.3,
          .strain_limit = 0.1,
          .strain_limit_stiffness = 1e6,
          .bending_stiffness = 1e-6,
          .mass_damping = 0.1,
          .strain_damping = 0.5,
          .bending_damping = 1e-7};
}

ShellMaterial towel() {
  // 0.484 kg on 1.75 m x 0.75 m; thickness 3.25 mm, mass damping 2/s and damping 0.1 of the stiffness as in
  // the paper: strain damping 0.1 s * thickness * E, bending damping 0.1 s * bending stiffness.
  return {.density = 0.484 / (1.75 * 0.75),
          .thickness = 3.25e-3,
          .youngs_modulus = 1.5e4,
          .poissons_ratio = 0.3,
          .strain_limit = 0.1,
          .strain_limit_stiffness = 1e6,
          .bending_stiffness = 5e-6,
          .mass_damping = 2.0,
          .strain_damping = 0.1 * 3.25e-3 * 1.5e4,
          .bending_damping = 0.1 * 5e-6};
}

ShellMaterial plate(double youngs_modulus, double poissons_ratio, double thickness, double density) {
  const double t3 = thickness * thickness * thickness;
  return {.density = density * thickness,
          .thickness = thickness,
          .youngs_modulus = youngs_modulus,
          .poissons_ratio = poissons_ratio,
          .bending_stiffness = 0.0,
          .flexural_rigidity = youngs_modulus * t3 / (12.0 * (1.0 - poissons_ratio * poissons_ratio)),
          .mass_damping = 0.1};
}

ShellMaterial paper() { return plate(3e9, 0.3, 1e-4, 800.0); }

ShellMaterial pet() { return plate(2.8e9, 0.4, 1.45e-4, 1380.0); }

ShellMaterial steel_sheet() { return plate(2.1e11, 0.3, 1e-4, 7850.0); }

SolidMaterial soft_rubber() {
  return {.density = 1000.0,
          .youngs_modulus = 1e4,
          .poissons_ratio = 0.3,
          .strain_limit = 1.0,
          .strain_limit_stiffness = 1e2,
          .mass_damping = 0.1,
          .strain_damping = 0.0};
}

SolidMaterial silicone() {
  // Data sheet: specific gravity 1.07, 100 % modulus 10 psi = 69 kPa, taken as Young's modulus; nearly
  // incompressible.
  return {.density = 1070.0, .youngs_modulus = 6.9e4, .poissons_ratio = 0.47, .mass_damping = 0.1};
}

const std::vector<Preset<ShellMaterial>>& shell_presets() {
  static const std::vector<Preset<ShellMaterial>> presets = {
      {"cotton", "light woven cotton as in the public preset Cotton_Fabric of the paper's authors", cotton()},
      {"towel", "terry towel measured for the robot experiments of the Stark paper, section IV-A", towel()},
      {"paper",
       "office paper, 80 g/m^2 and 0.1 mm; modulus of the two directions averaged, Alava and Niskanen 2006",
       paper()},
      {"pet",
       "polyester film of 0.145 mm, the wall of a thin drinking cup; modulus and density of data sheets",
       pet()},
      {"steel_sheet", "spring steel of 0.1 mm; elastic constants of steel, EN 1993-1-1", steel_sheet()},
  };
  return presets;
}

const std::vector<Preset<SolidMaterial>>& solid_presets() {
  static const std::vector<Preset<SolidMaterial>> presets = {
      {"soft_rubber", "very soft rubber as in the public preset Soft_Rubber of the paper's authors",
       soft_rubber()},
      {"silicone", "soft platinum-cure silicone, Smooth-On Ecoflex 00-30 data sheet", silicone()},
  };
  return presets;
}

}  // namespace materials
}  // namespace stark
