// Yielding of several strains at once, as an incremental potential in closed form. Strains e_i with
// stiffnesses K_i slip where their forces s_i = K_i e_i leave the ellipsoid sum (s_i/Y_i)^2 = R^2, with the
// yield force Y_i of each strain alone and R = 1 + H p, p the plastic work so far as without hardening. The
// energy of a step is the least over the slip d_i,
//     sum K_i (e_i - d_i)^2/2 + R g + H g^2/2,    g^2 = sum (Y_i d_i)^2,
// and that is the least over one number n >= 0 of a convex function [theory eq. 10h],
//     sum K_i e_i^2/(2 (1 + a_i n)) + R^2 n/(2 (1 - H n)),    a_i = K_i/Y_i^2,
// where each strain keeps the part 1/(1 + a_i n) as an elastic one [theory eq. 10i]. The flow is associated,
// so that what is dissipated, g, is never negative.
#pragma once

#include <vector>

#include <stark/mechanics/define.h>

namespace stark::models {

/// Only the square of a strain counts, which is smooth where the strain is the size of a vector.
struct YieldingStrain {
  Scalar squared;  ///< square of the trial strain: the strain less its plastic part at the start of the step
  Scalar stiffness;    ///< K
  Scalar yield_force;  ///< Y > 0, may be infinite
};

struct Yielding {
  Scalar energy;             ///< of the step, with what hardening has stored
  Scalar work;               ///< g, which is added to p
  std::vector<Scalar> kept;  ///< part of each trial strain that stays elastic
};

namespace detail {

/// Steps of Newton's method for 1/|s/Y| = (1 - H n)/R, which is concave in n: from n = 0 it increases to the
/// root. One step is exact where all a_i are the same. Four leave rounding where they differ up to threefold,
/// as in plates (rods that yield by their section: 1.6), and 1e-7 of the yield force where they differ
/// tenfold. They are steps of values alone: the energy is least in n, so that its derivatives need the first
/// one of n only, which one more step has from any n near the root. Differentiated with the rest, the steps
/// were half of the instructions.
inline constexpr int kYieldingSteps = 4;

struct ForceOverYield {
  Scalar squared;  ///< |s/Y|^2
  Scalar slope;    ///< -1/2 of its derivative in n
};

inline ForceOverYield force_over_yield(const std::vector<Scalar>& energies, const std::vector<Scalar>& a,
                                       const Scalar& n) {
  ForceOverYield force{0.0, 0.0};
  for (size_t i = 0; i < a.size(); ++i) {
    const Scalar kept = 1.0 / (1.0 + a[i] * n);
    const Scalar part = a[i] * energies[i] * square(kept);
    force.squared = force.squared + part;
    force.slope = force.slope + part * a[i] * kept;
  }
  return force;
}

/// A step from n. values: the energies, or what of them derivatives of the rate need.
inline Scalar yielding_step(const std::vector<Scalar>& energies, const std::vector<Scalar>& values,
                            const std::vector<Scalar>& a, const Scalar& H, const Scalar& R,
                            const Scalar& flows, const Scalar& n) {
  // Of what does not flow nothing is used; the bound keeps it finite.
  const auto inverse_of = [&](const ForceOverYield& force) {
    return 1.0 / sqrt(max(force.squared, 0.25 * square(R)));
  };
  const ForceOverYield force = force_over_yield(values, a, n);
  const Scalar inverse = inverse_of(force), rate = force.slope * inverse * square(inverse) + H / R;
  const Scalar off = inverse_of(force_over_yield(energies, a, n)) - (1.0 - H * n) / R;
  return select(flows, n - off / select(flows, rate, 1.0), 0.0);
}

}  // namespace detail

/// H: growth of all yield forces, as a factor, per plastic work; p: that of the steps before.
inline Yielding yielding(const std::vector<YieldingStrain>& strains, const Scalar& H, const Scalar& p) {
  std::vector<Scalar> energies, a;  // twice the elastic energies
  Scalar squared = 0.0;
  for (const YieldingStrain& strain : strains) {
    energies.push_back(strain.stiffness * strain.squared);
    a.push_back(strain.stiffness / square(strain.yield_force));
    squared = squared + a.back() * energies.back();
  }
  const Scalar R = 1.0 + H * p;
  const Scalar flows = squared > square(R);
  // A single strain needs one step, which is exact with all of its derivatives.
  std::vector<Scalar> values = energies;
  Scalar n = 0.0;
  if (strains.size() > 1) {
    for (Scalar& value : values) value = held(value);
    for (int k = 0; k < detail::kYieldingSteps; ++k)
      n = detail::yielding_step(values, values, a, H, R, flows, n);
  }
  n = detail::yielding_step(energies, values, a, H, R, flows, n);
  const Scalar share = n / (1.0 - H * n);
  Yielding result{0.5 * (square(R) * share + H * square(p)), R * share, {}};
  for (size_t i = 0; i < a.size(); ++i) {
    result.kept.push_back(1.0 / (1.0 + a[i] * n));
    result.energy = result.energy + 0.5 * energies[i] * result.kept[i];
  }
  return result;
}

}  // namespace stark::models
