// A formula that was written once, to be repeated: in another potential, for other expressions in place of
// its points. What Python traces becomes one of these. Phase: model building.
#pragma once

#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <stark/mechanics/potential.h>

namespace stark {

/// What stands for the points of a formula where it is repeated; an empty member means the points of the
/// builder itself.
struct PointExpressions {
  std::vector<symbolic::Vec3> x{}, x_prev{}, X{}, x_initial{};
};

class Formula {
 public:
  Formula() = default;
  /// `outputs`: expressions of the builder's graph. The builder is not used for anything else from now on.
  Formula(std::shared_ptr<PotentialBuilder> builder, std::vector<symbolic::Scalar> outputs);

  int point_count() const { return builder_->point_count(); }
  const std::vector<symbolic::Scalar>& outputs() const { return outputs_; }
  const std::vector<ElementField>& element_fields() const { return builder_->element_fields(); }
  const std::vector<UniformField>& uniform_fields() const { return builder_->uniform_fields(); }

  /// Whether an input of this source occurs.
  bool uses(ElementField::Source source) const;

  /// Of an energy of totals: the parameters that occur outside of them, so that all elements share them;
  /// empty for other formulas.
  std::set<std::string> shared_parameters() const;

  /// The outputs as expressions of `target`. Fields that occur become fields of the same name there; data and
  /// parameters get `prefix` in front of their names.
  std::vector<symbolic::Scalar> repeat(PotentialBuilder& target, const PointExpressions& points = {},
                                       const std::string& prefix = "") const;
  /// The first output; the others are the updates of the internal variables, in the order of their fields.
  symbolic::Scalar repeat_energy(PotentialBuilder& target, const PointExpressions& points = {}) const;

 private:
  std::shared_ptr<PotentialBuilder> builder_;
  std::vector<symbolic::Scalar> outputs_;
};

/// Potential whose energy is the first output of a formula.
PotentialDefinition define_potential(std::string name, std::string doc, Formula formula);
/// The energy of a potential as a formula.
Formula formula_of(const PotentialDefinition& definition);

}  // namespace stark
