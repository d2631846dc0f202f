// Some constraints and what carries them as a system of their own: sites, unknowns and rows are numbered
// anew, so that what is computed of a gripper whose fingers mimic each other costs the same beside a cloth as
// alone (step phases 4j and 6).
#pragma once

#include <span>
#include <vector>

#include <stark/mechanics/constraint_set.h>
#include <stark/mechanics/kinematic_map.h>

namespace stark {

class LoopSystem {
 public:
  /// `chosen`: by constraint, whether it is in the system.
  LoopSystem(const KinematicMap& map, const ConstraintSet& constraints, const std::vector<bool>& chosen);

  /// Takes over where everything is, and the multipliers and penalties of the constraints.
  void read(const ConstraintSet& constraints, const Configuration& configuration, std::span<const Vec3> x);

  const KinematicMap& map() const { return map_; }
  ConstraintSet& constraints() { return constraints_; }
  const ConstraintSet& constraints() const { return constraints_; }
  const Configuration& configuration() const { return configuration_; }
  std::span<const Vec3> sites() const { return x_; }

  size_t row_count() const { return rows_.size(); }
  /// Row among all constraints of row r.
  size_t row(size_t r) const { return rows_[r]; }
  /// Values of these rows, of values of all.
  template <typename Value>
  std::vector<Value> part(const std::vector<Value>& of_all) const {
    std::vector<Value> result(rows_.size());
    for (size_t r = 0; r < rows_.size(); ++r) result[r] = of_all[rows_[r]];
    return result;
  }

 private:
  /// Numbers of what is taken over, by number here.
  struct Sources {
    std::vector<int32_t> points, bodies, sites;
    std::vector<std::vector<int64_t>> elements;  ///< by group
    std::vector<int32_t> groups;
  };

  void choose_elements(const ConstraintSet& constraints, const std::vector<bool>& chosen);
  void choose_sites(const KinematicMap& map, const ConstraintSet& constraints);
  KinematicMap make_map(const KinematicMap& map) const;
  std::vector<ConstraintGroup> make_groups(const ConstraintSet& constraints) const;

  Sources from_;
  std::vector<size_t> rows_;
  KinematicMap map_;
  ConstraintSet constraints_;
  Configuration configuration_;
  std::vector<Vec3> x_;
};

}  // namespace stark
