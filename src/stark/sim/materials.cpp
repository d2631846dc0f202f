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
             "stretch of an edge minus 1 above which the membrane stiffens"),
       field(&S::strain_limit_stiffness, "strain_limit_stiffness", "Pa", non_negative(),
             "stiffness above the strain limit"),
       field(&S::bending_stiffness, "bending_stiffness", "J", non_negative(),
             "bending stiffness of the hinges"),
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
       field(&S::poissons_ratio, "poissons_ratio", "1", half_open_interval(0.0, 0.5), "Poisson's ratio"),
       field(&S::strain_limit, "strain_limit", "1", positive_or_infinity(),
             "stretch of an edge minus 1 above which the solid stiffens"),
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
