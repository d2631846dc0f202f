// Descriptor tables of the materials and the presets with their sources. See materials.h.
#include <stark/sim/scene/materials.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <stark/base/error.h>

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
       field(
           &S::strain_limit, "strain_limit", "1", positive_or_infinity(),
           "strain above which the membrane stiffens: Green strain in any direction, or by the law edges the "
           "stretch of edges minus 1"),
       field(&S::strain_limit_stiffness, "strain_limit_stiffness", "Pa", non_negative(),
             "stiffness above the strain limit"),
       field(&S::strain_limit_hardening, "strain_limit_hardening", "1", non_negative(),
             "growth of that stiffness once the excess reaches the limit itself, as a factor; 0: none; not "
             "of the "
             "law edges"),
       field(
           &S::strain_limit_law, "strain_limit_law",
           "what is limited: green_strain, its eigenvalues, or edges, the stretch of the edges of the mesh"),
       field(&S::bending_stiffness, "bending_stiffness", "J", non_negative(),
             "bending stiffness of the hinges, cheap but dependent on the mesh"),
       field(&S::flexural_rigidity, "flexural_rigidity", "N m", non_negative(),
             "rigidity E t^3 / (12 (1 - nu^2)) of a plate, the same on most meshes; where positive, in place "
             "of bending_stiffness"),
       field(&S::yield_stress, "yield_stress", "Pa", positive_or_infinity(),
             "von Mises stress at which the sheet yields, stretched or bent"),
       field(&S::hardening_modulus, "hardening_modulus", "Pa", non_negative(),
             "growth of the yield stress with the plastic strain"),
       field(&S::bending_yield_moment, "bending_yield_moment", "N", non_negative_or_infinity(),
             "moment per length at which bending yields; 0: yield_stress t^2 / 4"),
       field(&S::bending_hardening, "bending_hardening", "N m", non_negative(),
             "growth of that moment with the plastic curvature; 0: hardening_modulus t^3 / 12"),
       field(&S::mass_damping, "mass_damping", "1/s", non_negative(), "damping rate of all motion"),
       field(&S::strain_damping, "strain_damping", "N s/m", non_negative(),
             "damping of the rate of Green strain"),
       field(&S::bending_damping, "bending_damping", "J s", non_negative(),
             "damping of the rate of the hinge angles"),
       field(&S::thermal_expansion, "thermal_expansion", "1/K", open_interval(-1.0, 1.0),
             "stretch of the rest shape with the temperature of the body")});
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
             "strain above which the solid stiffens: Green strain in any direction, or by the law edges the "
             "stretch of edges minus 1"),
       field(&S::strain_limit_stiffness, "strain_limit_stiffness", "Pa", non_negative(),
             "stiffness above the strain limit"),
       field(&S::strain_limit_hardening, "strain_limit_hardening", "1", non_negative(),
             "growth of that stiffness once the excess reaches the limit itself, as a factor; 0: none; not "
             "of the "
             "law edges"),
       field(
           &S::strain_limit_law, "strain_limit_law",
           "what is limited: green_strain, its eigenvalues, or edges, the stretch of the edges of the mesh"),
       field(&S::mass_damping, "mass_damping", "1/s", non_negative(), "damping rate of all motion"),
       field(&S::strain_damping, "strain_damping", "Pa s", non_negative(),
             "damping of the rate of Green strain"),
       field(&S::thermal_expansion, "thermal_expansion", "1/K", open_interval(-1.0, 1.0),
             "stretch of the rest shape with the temperature of the body")});
  return table;
}

const FieldTable& RodMaterial::fields() {
  using S = RodMaterial;
  static const FieldTable table(
      "RodMaterial", TableKind::Parameters,
      {field(&S::density, "density", "kg/m^3", positive(), "mass of a unit of volume"),
       field(&S::youngs_modulus, "youngs_modulus", "Pa", positive(), "Young's modulus"),
       field(&S::poissons_ratio, "poissons_ratio", "1", closed_interval(0.0, 0.5), "Poisson's ratio"),
       field(&S::radius, "radius", "m", positive(), "radius of a round section; also the contact distance"),
       field(&S::width, "width", "m", non_negative(), "of a rectangular section along d1; 0: round"),
       field(&S::height, "height", "m", non_negative(), "of a rectangular section along d2; 0: round"),
       field(&S::axial_stiffness, "axial_stiffness", "N", non_negative(),
             "force for unit stretch; 0: of the section"),
       field(&S::shear_stiffness, "shear_stiffness", "N", non_negative(),
             "force for unit shear; 0: of the section"),
       field(&S::bending_stiffness_1, "bending_stiffness_1", "N m^2", non_negative(),
             "bending stiffness about d1; 0: of the section"),
       field(&S::bending_stiffness_2, "bending_stiffness_2", "N m^2", non_negative(),
             "bending stiffness about d2; 0: of the section"),
       field(&S::torsional_stiffness, "torsional_stiffness", "N m^2", non_negative(),
             "torque for a twist of 1 rad/m; 0: of the section"),
       field(&S::yield_stress, "yield_stress", "Pa", positive_or_infinity(),
             "stress at which the rod yields in tension"),
       field(&S::hardening_modulus, "hardening_modulus", "Pa", non_negative(),
             "growth of the yield stress with the plastic strain"),
       field(&S::yield_force, "yield_force", "N", non_negative_or_infinity(),
             "axial force at which it yields; 0: of the section"),
       field(&S::yield_moment_1, "yield_moment_1", "N m", non_negative_or_infinity(),
             "bending moment about d1 at which it yields; 0: of the section"),
       field(&S::yield_moment_2, "yield_moment_2", "N m", non_negative_or_infinity(),
             "bending moment about d2 at which it yields; 0: of the section"),
       field(&S::yield_torque, "yield_torque", "N m", non_negative_or_infinity(),
             "torque at which it yields; 0: of the section"),
       field(&S::mass_damping, "mass_damping", "1/s", non_negative(), "damping rate of all motion"),
       field(&S::strain_damping, "strain_damping", "s", non_negative(),
             "relaxation time of stretch, bending and twist"),
       field(&S::thermal_expansion, "thermal_expansion", "1/K", open_interval(-1.0, 1.0),
             "stretch of the rest shape with the temperature of the body")});
  return table;
}

namespace {

constexpr double kPi = std::numbers::pi;

/// Saint-Venant's torsion constant of a rectangle [m^4], exact to 0.5 % [Timoshenko and Goodier, sec. 109].
double torsion_constant(double width, double height) {
  const double a = std::max(width, height), b = std::min(width, height), r = b / a;
  return a * b * b * b * (1.0 / 3.0 - 0.21 * r * (1.0 - r * r * r * r / 12.0));
}

double given_or(double value, double of_section) { return value > 0.0 ? value : of_section; }

/// Plastic moduli of a section [m^3]: moments of a stress of 1 in the whole section [Hill 1950, ch. IV, V].
struct PlasticModuli {
  std::array<double, 2> bending{};  ///< about d1 and d2
  double torsion = 0.0;             ///< of the shear stress; of a rectangle the heap of sand on it
};

PlasticModuli plastic_moduli(const RodMaterial& m) {
  const double r = m.radius, w = m.width, h = m.height;
  if (w == 0.0) return {{4.0 / 3.0 * r * r * r, 4.0 / 3.0 * r * r * r}, 2.0 / 3.0 * kPi * r * r * r};
  const double a = std::max(w, h), b = std::min(w, h);
  return {{0.25 * w * h * h, 0.25 * h * w * w}, b * b * (3.0 * a - b) / 6.0};
}

void set_yields(const RodMaterial& m, double area, RodSection& section) {
  const PlasticModuli moduli = plastic_moduli(m);
  const double stress = m.yield_stress;
  section.yield_force = given_or(m.yield_force, stress * area);
  section.yield_moments = {given_or(m.yield_moment_1, stress * moduli.bending[0]),
                           given_or(m.yield_moment_2, stress * moduli.bending[1])};
  section.yield_torque = given_or(m.yield_torque, stress / std::sqrt(3.0) * moduli.torsion);
  // A plastic stretch e of the work N_y e raises the yield stress by H e.
  section.yield_hardening = m.hardening_modulus / (stress * (stress * area));
}

}  // namespace

bool RodSection::yields() const {
  return std::isfinite(yield_force) || std::isfinite(yield_moments[0]) || std::isfinite(yield_moments[1]) ||
         std::isfinite(yield_torque);
}

BendingYield bending_yield_of(const ShellMaterial& m) {
  const double t = m.thickness;
  return {.moment = given_or(m.bending_yield_moment, 0.25 * m.yield_stress * t * t),
          .hardening = given_or(m.bending_hardening, m.hardening_modulus * t * t * t / 12.0)};
}

RodSection section_of(const RodMaterial& m) {
  const bool is_round = m.width == 0.0;
  const double r = m.radius, nu = m.poissons_ratio;
  const double area = is_round ? kPi * r * r : m.width * m.height;
  const double around_1 = is_round ? 0.25 * area * r * r : area * m.height * m.height / 12.0;
  const double around_2 = is_round ? around_1 : area * m.width * m.width / 12.0;
  const double torsion = is_round ? 2.0 * around_1 : torsion_constant(m.width, m.height);
  const double shear_factor =
      is_round ? 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu) : 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
  const double E = m.youngs_modulus, G = E / (2.0 * (1.0 + nu));
  RodSection section{.mass = m.density * area,
                     .second_moments = {m.density * around_2, m.density * around_1},
                     .axial_stiffness = given_or(m.axial_stiffness, E * area),
                     .shear_stiffness = given_or(m.shear_stiffness, shear_factor * G * area),
                     .bending_stiffness = {given_or(m.bending_stiffness_1, E * around_1),
                                           given_or(m.bending_stiffness_2, E * around_2)},
                     .torsional_stiffness = given_or(m.torsional_stiffness, G * torsion)};
  set_yields(m, area, section);
  return section;
}

namespace {

template <typename Material>
void require_yield_stress(const Material& material, std::string_view owner) {
  if (material.hardening_modulus > 0.0 && !std::isfinite(material.yield_stress))
    throw InvalidArgument(std::string(owner) +
                          ": hardening_modulus = " + quantity_text(material.hardening_modulus, "Pa") +
                          " without a yield_stress: must be 0 where nothing yields; give yield_stress, too");
}

}  // namespace

void validate(const RodMaterial& material, std::string_view owner) {
  RodMaterial::fields().validate(&material, owner);
  if ((material.width > 0.0) != (material.height > 0.0))
    throw InvalidArgument(std::string(owner) + ": width = " + quantity_text(material.width, "m") +
                          ", height = " + quantity_text(material.height, "m") +
                          ": must both be > 0 for a rectangular section or both be 0 for a round one");
  require_yield_stress(material, owner);
}

void validate(const ShellMaterial& material, std::string_view owner) {
  ShellMaterial::fields().validate(&material, owner);
  require_yield_stress(material, owner);
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

SolidMaterial foam() {
  // Open cells: E = E_s (rho/rho_s)^2 and nu = 1/3, with 45 MPa and 1200 kg/m^3 of solid polyurethane.
  return {.density = 30.0, .youngs_modulus = 28125.0, .poissons_ratio = 1.0 / 3.0, .mass_damping = 0.1};
}

SolidMaterial natural_rubber() {
  // 1.5 MPa at 40 IRHD. Its bulk modulus of 1 GPa would be a Poisson's ratio of 0.49975; 0.49 changes
  // volumes by more, but is easier on elements. Linear ones lock at both (docs/solids.md).
  return {.density = 950.0, .youngs_modulus = 1.5e6, .poissons_ratio = 0.49, .mass_damping = 0.1};
}

SolidMaterial pet_solid() {
  return {.density = 1360.0, .youngs_modulus = 3.1e9, .poissons_ratio = 0.4, .mass_damping = 0.1};
}

SolidMaterial steel() {
  return {.density = 7850.0, .youngs_modulus = 2.1e11, .poissons_ratio = 0.3, .mass_damping = 0.1};
}

RodMaterial rubber_cord() {
  return {
      .density = 950.0, .youngs_modulus = 1.5e6, .poissons_ratio = 0.49, .radius = 2e-3, .mass_damping = 0.1};
}

RodMaterial steel_wire() {
  return {.density = 7850.0,
          .youngs_modulus = 2.06e11,
          .poissons_ratio = 206.0 / (2.0 * 81.5) - 1.0,
          .radius = 0.5e-3,
          .mass_damping = 0.1};
}

const std::vector<Preset<ShellMaterial>>& shell_presets() {
  static const std::vector<Preset<ShellMaterial>> presets = {
      {"cotton",
       "light woven cotton as in the public preset Cotton_Fabric of the paper's authors, which has no "
       "strain_limit_hardening",
       cotton()},
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
      {"soft_rubber",
       "very soft rubber as in the public preset Soft_Rubber of the paper's authors, which has no "
       "strain_limit_hardening",
       soft_rubber()},
      {"silicone", "soft platinum-cure silicone, Smooth-On Ecoflex 00-30 data sheet", silicone()},
      {"foam",
       "flexible polyurethane foam of 30 kg/m^3; open cells by Gibson and Ashby, Cellular Solids 1997, ch. 5",
       foam()},
      {"natural_rubber",
       "unfilled natural rubber of 40 IRHD, Lindley, Engineering Design with Natural Rubber 1978; Poisson's "
       "ratio 0.49 instead of 0.49975; for quadratic elements or mean_dilatation, as linear elements lock",
       natural_rubber()},
      {"pet_solid", "polyester blocks, Ensinger TECAPET data sheet (ISO 527-2); Poisson's ratio of PET",
       pet_solid()},
      {"steel", "structural steel, EN 1993-1-1 section 3.2.6", steel()},
  };
  return presets;
}

const std::vector<Preset<RodMaterial>>& rod_presets() {
  static const std::vector<Preset<RodMaterial>> presets = {
      {"steel_wire",
       "patented cold drawn spring steel wire of EN 10270-1: E = 206 GPa, G = 81.5 GPa by EN 13906-1",
       steel_wire()},
      {"rubber_cord", "cord of 4 mm of the rubber of the preset natural_rubber", rubber_cord()},
  };
  return presets;
}

}  // namespace materials
}  // namespace stark
