// Densities of laws apart from elements: strains are points, parameters are inputs, nothing else is.
#include <doctest/doctest.h>

#include <stark/base/error.h>
#include <stark/mechanics/law_density.h>

using namespace stark;

TEST_CASE("the columns of F of a law are the points of its density") {
  const SolidLaw law = define_solid_law("law", "", [](PotentialBuilder& b, const SolidDeformation& d) {
    return b.parameter("modulus", "Pa", "", positive()) * d.F()(1, 2);
  });
  const LawDensity density = density_of(law);
  REQUIRE(density.builder->uniform_fields().size() == 1);
  const UniformField& modulus = density.builder->uniform_fields()[0];
  CHECK(modulus.name == "modulus");
  const symbolic::Scalar expected = density.builder->parameter_like(modulus)[0] * density.builder->x(2)[1];
  CHECK(is_same(density.psi, expected));
}

TEST_CASE("the strain of a rod is two points of its density") {
  const RodLaw law = define_rod_law("law", "", [](PotentialBuilder&, const RodDeformation& d) {
    const RodStrain strain = d.strain();
    return strain.stretch + 2.0 * strain.curvature[1] + 3.0 * strain.twist;
  });
  const LawDensity density = density_of(law);
  PotentialBuilder& b = *density.builder;
  CHECK(is_same(density.psi, b.x(0)[2] + 2.0 * b.x(1)[1] + 3.0 * b.x(1)[2]));
}

TEST_CASE("a law with memory has no density of the strain alone") {
  const ShellLaw law = define_shell_law("viscous", "", [](PotentialBuilder&, const ShellDeformation& d) {
    return squared_norm(d.F() - d.F_prev());
  });
  CHECK_THROWS_AS(density_of(law), InvalidArgument);
}
