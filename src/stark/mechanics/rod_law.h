// Constitutive laws of rods: stored energy per rest length [J/m] as a formula of stretch, curvature and
// twist, and the segment that supplies them. Phase: model building.
//
// A rod is a chain of nodes, each with a position x and a material frame of directors d1, d2 (axes of the
// cross-section) and d3 (its normal): a geometrically exact rod [Simo 1985, Reissner 1981] in directors
// [Romero 2004]. A segment has one quadrature point in its middle, which keeps slender rods free of shear
// locking. With the rest length L, the edge t = (x1 - x0) / L, the rotation by phi about n from one frame to
// the other and the frame M halfway, the strains are [theory eq. 28, 29]
//     s = |t|                                  stretch,
//     g = M^T t - s M0^T t0                    shear: how far the section has left the edge, 0: at rest,
//     u = (tan(phi/2) + sin(phi/2)) n / L      curvature (1, 2) and twist (3), less those at rest.
// M is a rotation and the stretch a length, so that stretching costs energy whatever the frames do; and half
// a turn between neighbouring frames, where M has no meaning, takes energy without bound.
#pragma once

#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <stark/mechanics/formula.h>
#include <stark/mechanics/potential.h>

namespace stark {

/// Strains of a rod, zero in the rest shape, the stretch apart, which is 1 there.
struct RodStrain {
  symbolic::Scalar stretch;                   ///< length over rest length
  symbolic::Vec3 shear;                       ///< along d1, d2, d3 of the middle; d3 is of second order
  std::array<symbolic::Scalar, 2> curvature;  ///< change, about the axes d1, d2 [1/m]
  symbolic::Scalar twist;                     ///< change, about d3 [rad/m]
};

/// Evaluated when asked for, so that a law without memory has no inputs for the past.
struct RodDeformation {
  std::function<RodStrain()> strain;       ///< at the end of the step
  std::function<RodStrain()> strain_prev;  ///< what rates are measured from: at the start of the step
};

struct RodLaw {
  std::string name;
  std::string doc;
  /// Energy per rest length [J/m]. Of the builder use parameters, data, internal variables and time only.
  /// With internal variables it is the energy of the step, least in what the variables become [theory eq.
  /// 10b].
  std::function<symbolic::Scalar(PotentialBuilder&, const RodDeformation&)> psi;
  bool zero_at_rest = true;  ///< declared: no energy and no force in the rest shape; checked by the sweep
  /// Values of parameters for the automatic tests; those left out are in [0.5, 1.5].
  std::function<std::map<std::string, std::vector<double>>(std::mt19937_64&)> sample{};
};

RodLaw define_rod_law(std::string name, std::string doc,
                      std::function<symbolic::Scalar(PotentialBuilder&, const RodDeformation&)> psi);

/// Law whose psi is the first output of a formula of two points: (0, 0, stretch) and (curvature 1,
/// curvature 2, twist); the others are the updates of its internal variables; x_prev are those at the start
/// of the step. Throws InvalidArgument for another number of points.
RodLaw rod_law_from(std::string name, std::string doc, Formula formula);

/// Sum of laws, for instance of an elastic and a viscous one; parameters of the same name are one.
RodLaw sum(std::string name, const std::vector<RodLaw>& laws);

/// Segment of a rod: 8 points, the nodes x0 and x1, then d1, d2, d3 of each. psi times rest length, plus the
/// energy of shear with the parameter `shear_stiffness` [N], which keeps sections normal to the rod.
PotentialDefinition rod_segment(const RodLaw& law);
inline constexpr int kRodSegmentPoints = 8;

/// Bar: 2 points, x0 and x1. psi at the stretch of the edge, without curvature and twist, times rest length.
PotentialDefinition rod_bar(const RodLaw& law);

}  // namespace stark
