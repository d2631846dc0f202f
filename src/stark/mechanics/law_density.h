// Energy densities of laws as expressions of their strain, for whoever evaluates or differentiates a law
// apart from elements: the strain is the points of a builder. Phase: queries of materials.
#pragma once

#include <memory>

#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/rod_law.h>

namespace stark {

struct LawDensity {
  std::shared_ptr<PotentialBuilder>
      builder;  ///< its points are the strain, its uniform fields the parameters
  symbolic::Scalar psi;
};

/// Of solids and shells the points are the columns of F; of rods (0, 0, stretch) and (curvature 1,
/// curvature 2, twist). Throws InvalidArgument for laws that depend on more than the strain and parameters.
LawDensity density_of(const SolidLaw& law);
LawDensity density_of(const ShellLaw& law);
LawDensity density_of(const RodLaw& law);

}  // namespace stark
