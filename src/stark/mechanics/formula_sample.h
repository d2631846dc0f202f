// A formula on elements that are given as arrays, outside of any scene: for checks, plots and timings. Every
// element has points of its own. Phase: none.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include <stark/mechanics/field_values.h>
#include <stark/mechanics/formula.h>

namespace stark {

/// Positions [m] of the points of all elements, element by element; times in seconds.
struct SamplePoints {
  std::vector<Vec3> x, X, x_prev, x_initial;
  double time_step = 0.0, time = 0.0;
};

class FormulaSample {
 public:
  /// `values` gives the numbers of a parameter or of data, for all elements in a row. Throws InvalidArgument
  /// for other counts of numbers or points.
  FormulaSample(const Formula& formula, symbolic::Backend backend, SamplePoints points,
                const std::function<std::vector<double>(const ParameterDeclaration&)>& values);

  size_t point_count() const { return x_.size(); }
  void set_positions(std::vector<Vec3> x);  ///< as many as before, or it throws InvalidArgument
  /// Energy, gradient, upper triangle of the Hessian of each element, in a row one after another.
  std::vector<double> evaluate(symbolic::Order order) const { return batch_.evaluate(order, x_); }
  /// The work of evaluate() without its results, for timings.
  void run(symbolic::Order order) const;

 private:
  PotentialBatch batch_;
  std::vector<Vec3> x_;
};

}  // namespace stark
