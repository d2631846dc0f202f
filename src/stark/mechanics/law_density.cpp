#include <stark/mechanics/law_density.h>

#include <stark/base/error.h>

namespace stark {

namespace {

/// Deformation gradient whose columns are the points of the builder.
template <int columns>
Deformation<columns> deformation_of(PotentialBuilder* b) {
  return {[b](PotentialBuilder::Position position) {
    symbolic::Mat<3, columns> F;
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < 3; ++i) F(i, j) = (b->*position)(j)[i];
    return F;
  }};
}

RodDeformation rod_deformation_of(PotentialBuilder* b) {
  const auto strain = [b](PotentialBuilder::Position position) {
    const symbolic::Vec3 first = (b->*position)(0), second = (b->*position)(1);
    return RodStrain{first[2], symbolic::Vec3(0.0, 0.0, 0.0), {second[0], second[1]}, second[2]};
  };
  return {[strain] { return strain(&PotentialBuilder::x); },
          [strain] { return strain(&PotentialBuilder::x_prev); }};
}

template <typename Law, typename Strain>
LawDensity density(const Law& law, int points, Strain strain_of) {
  const auto builder = std::make_shared<PotentialBuilder>(points);
  LawDensity result{builder, law.psi(*builder, strain_of(builder.get()))};
  if (!builder->element_fields().empty())
    throw InvalidArgument("law '" + law.name +
                          "': depends on the strain at the start of the step: must depend on the strain "
                          "alone; write it with @stark.material");
  return result;
}

}  // namespace

LawDensity density_of(const SolidLaw& law) { return density(law, 3, deformation_of<3>); }
LawDensity density_of(const ShellLaw& law) { return density(law, 2, deformation_of<2>); }
LawDensity density_of(const RodLaw& law) { return density(law, 2, rod_deformation_of); }

}  // namespace stark
