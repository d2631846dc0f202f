// Elements of mean dilatation: the volume ratio that the law sees is the projection of det F on the constant,
// or the linear, functions of the element, which takes the volume constraints from its points that would lock
// it (step phase 4c). The energy stays a function of the nodes alone. [theory eq. 15b, 15c]
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include <stark/mechanics/potential_batch.h>

namespace stark {

class MeanDilatation {
 public:
  /// What evaluate() writes for each point: energy, derivatives in F (9), then for Order::Hessian the row of
  /// the volume ratio (itself, then F), the upper triangle in F (45), and the derivatives of det F (9).
  static constexpr int kRow = 10, kUpper = 20, kCofactors = 65, kOutputs = 74;

  /// `ratio`: compiled volume_ratio(). `modes`: 1 for a constant ratio, 4 for a linear one.
  MeanDilatation(std::shared_ptr<const Potential> ratio, int points_per_element, int modes);

  int modes() const { return modes_; }
  void resize(int64_t element_count);
  /// weights: volumes [m^3] of the points; positions: theirs at rest [m].
  void set_geometry(int64_t element, std::span<const double> weights, std::span<const Vec3> positions);

  /// Values of the modes at a point; they are orthonormal under the weights. [modes()]
  const double* modes_at(int64_t element, int point) const {
    return shapes_.data() + (element * points_ + point) * modes_;
  }
  double weight(int64_t element, int point) const { return weights_[element * points_ + point]; }
  /// Volume ratios of an element from those at its points, in place.
  void average(int64_t element, std::span<double> ratios) const;
  /// The projection itself: a value at X = 0 and the slopes in X, of ratios at the points.
  std::array<double, 4> linear_form(int64_t element, std::span<const double> ratios) const;

  static int output_count(symbolic::Order order);
  /// Evaluates `law`, compiled mean_dilatation_point(), in blocks of lanes [begin, end) that start with the
  /// first point of an element. F: [end - begin][9][kLanes]; out: [end - begin][output_count][kLanes].
  void evaluate(const PotentialBatch& law, symbolic::Order order, const double* F, int64_t begin, int64_t end,
                double* out) const;

 private:
  /// Adds what the volume ratio brings to the derivatives in F. `law`, `ratio`: outputs of the kernels at the
  /// points of an element, of which the first is lane `first`.
  void merge(int64_t element, int64_t first, symbolic::Order order, const double* law, const double* ratio,
             double* out) const;

  std::shared_ptr<const Potential> ratio_;
  int points_ = 0, modes_ = 0;
  std::vector<double> shapes_;   ///< [element][point][mode]
  std::vector<double> forms_;    ///< [element][mode][4] of the modes: a value at X = 0, slopes in X
  std::vector<double> weights_;  ///< [element][point]
};

}  // namespace stark
