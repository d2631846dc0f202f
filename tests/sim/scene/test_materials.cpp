// Presets against the numbers of their sources, and the ranges of all parameters.
#include <doctest/doctest.h>

#include <cmath>

#include <limits>
#include <string>

#include <stark/base/error.h>
#include <stark/sim/scene/materials.h>

using namespace stark;

TEST_CASE("presets have the documented numbers") {
  const ShellMaterial cotton = materials::cotton();
  CHECK(cotton.density == 0.2);
  CHECK(cotton.thickness == 1e-3);
  CHECK(cotton.youngs_modulus == 5e3);
  CHECK(cotton.poissons_ratio == 0.3);
  CHECK(cotton.strain_limit == 0.1);
  CHECK(cotton.strain_limit_stiffness == 1e6);
  CHECK(cotton.strain_limit_law == StrainLimitLaw::GreenStrain);
  CHECK(cotton.bending_stiffness == 1e-6);
  CHECK(cotton.mass_damping == 0.1);
  CHECK(cotton.strain_damping == 0.5);
  const SolidMaterial rubber = materials::soft_rubber();
  CHECK(rubber.density == 1000.0);
  CHECK(rubber.youngs_modulus == 1e4);
  CHECK(rubber.poissons_ratio == 0.3);
  CHECK(rubber.strain_limit == 1.0);
  CHECK(rubber.mass_damping == 0.1);
  CHECK(materials::towel().density * 1.75 * 0.75 == doctest::Approx(0.484).epsilon(1e-14));
  CHECK(materials::foam().youngs_modulus ==
        doctest::Approx(45e6 * std::pow(30.0 / 1200.0, 2)).epsilon(1e-14));
  CHECK(materials::natural_rubber().youngs_modulus == 1.5e6);
  CHECK(materials::pet_solid().youngs_modulus == 3.1e9);
  CHECK(materials::steel().youngs_modulus == 2.1e11);
  for (const auto& preset : materials::shell_presets()) CHECK_NOTHROW(validate(preset.material, preset.name));
  for (const auto& preset : materials::solid_presets()) CHECK_NOTHROW(validate(preset.material, preset.name));
  for (const auto& preset : materials::rod_presets()) CHECK_NOTHROW(validate(preset.material, preset.name));
}

TEST_CASE("every parameter refuses values outside its range and keeps the defaults inside") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto sweep = [&](auto material) {
    using Material = decltype(material);
    CHECK_NOTHROW(validate(material, "default"));
    for (const Field& field : Material::fields().fields()) {
      if (field.type != FieldType::Real) continue;
      CAPTURE(field.name);
      for (const double bad : {-1.0, nan, -std::numeric_limits<double>::infinity()}) {
        Material changed = material;
        field.set(&changed, bad);
        CHECK_THROWS_AS(validate(changed, "changed"), InvalidArgument);
      }
    }
  };
  sweep(ShellMaterial{});
  sweep(SolidMaterial{});
}
