// A traced formula together with the points that it really uses: frames offer eight points, a hinge angle
// needs three of them. Phase: model building.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <stark/mechanics/formula.h>

namespace stark {

class ReducedFormula {
 public:
  /// `outputs`: expressions of the builder's graph, as for Formula.
  ReducedFormula(const std::shared_ptr<PotentialBuilder>& traced, std::vector<symbolic::Scalar> outputs);

  /// Points of the formula that occur in the outputs, in increasing order.
  const std::vector<int>& points() const { return points_; }
  /// The outputs as expressions of `target`, whose points from `first` on stand for points(). Data and
  /// parameters get `prefix` in front of their names.
  std::vector<symbolic::Scalar> repeat(PotentialBuilder& target, int first = 0,
                                       const std::string& prefix = "") const;

 private:
  Formula formula_;
  std::vector<char> now_, before_, initial_;  ///< by point of the formula: when its position is used
  std::vector<int> points_;
};

}  // namespace stark
