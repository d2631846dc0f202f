// One element of a potential, outside of any simulation: for tests against other programs and for inspection.
// Phase: none.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <stark/mechanics/potential.h>

namespace stark {

struct ElementEvaluation {
  double energy = 0.0;            ///< [J]
  std::vector<Vec3> gradient{};   ///< by point [N]
  std::vector<double> hessian{};  ///< (3n, 3n), row by row [N/m]
};

/// An input that a potential asks for.
struct ElementInput {
  const std::string &name, &unit, &doc;
  int width;
};

/// At the positions x, with rest positions X and positions x_prev at the start of the step [m], as many as
/// the potential has points. `value` gives the data and the parameters, `width` numbers each. Throws
/// InvalidArgument for other counts.
ElementEvaluation evaluate_element(const Potential& potential, std::span<const Vec3> x,
                                   std::span<const Vec3> X, std::span<const Vec3> x_prev,
                                   const std::function<std::vector<double>(const ElementInput&)>& value);

}  // namespace stark
