// All elements of one potential with the same parameters: stencils of sites and their inputs in the
// lane-major layout of the kernels, so that only the unknown positions are gathered at an evaluation (step
// phase 4c).
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <stark/base/aligned.h>
#include <stark/mechanics/energy_difference.h>
#include <stark/mechanics/potential.h>
#include <stark/symbolic/evaluate.h>

namespace stark {

/// An energy of totals where it was touched last. [theory eq. 15h]
struct TouchingPlane {
  std::vector<double> totals{};     ///< [m]
  std::vector<double> slopes{};     ///< [m] of the energy
  std::vector<double> curvature{};  ///< [m][m]
  double energy = 0.0;              ///< [J]
};

class PotentialBatch {
 public:
  /// Blocks of lanes that are gathered before the kernel runs: 64 elements at least avoid store-forwarding
  /// stalls.
  static constexpr int64_t kGroupBlocks = 8;

  explicit PotentialBatch(std::shared_ptr<const Potential> potential);

  const Potential& potential() const { return *potential_; }
  int64_t size() const { return size_; }
  int64_t block_count() const { return (size_ + symbolic::kLanes - 1) / symbolic::kLanes; }
  int point_count() const { return potential_->point_count(); }

  /// Replaces all elements; stencils is [count][point_count] site indices. Element data become zero.
  void resize(std::span<const int32_t> stencils);
  std::span<const int32_t> stencil(int64_t element) const {
    return {stencils_.data() + element * point_count(), static_cast<size_t>(point_count())};
  }
  std::span<const int32_t> stencils() const { return stencils_; }

  /// Sets a per-element Data field of one element; values has the width of the field.
  void set(int field, int64_t element, std::span<const double> values);
  void set(const std::string& field, int64_t element, std::span<const double> values) {
    set(field_index(field), element, values);
  }
  void set(const std::string& field, int64_t element, double value) { set(field, element, {&value, 1}); }
  int field_index(const std::string& name) const;
  /// Numbers of all elements, lane by lane, and shared ones: what the batch was given.
  std::span<const double> element_values() const { return elements_; }
  std::span<const double> uniform_values() const { return uniforms_; }
  /// Value of component c of an element field.
  double get(int field, int64_t element, int c = 0) const;

  /// Numbers of elements of another batch of the same potential, one for each of this, and the shared ones.
  void take(const PotentialBatch& from, std::span<const int64_t> elements);

  /// Sets a shared parameter; unknown names throw.
  void set_uniform(const std::string& name, std::span<const double> values);
  void set_uniform(const std::string& name, double value) { set_uniform(name, {&value, 1}); }
  /// Sets "time_step" and "time" (at the end of the step) where the potential uses them.
  void set_time(double h, double time);

  /// Elements that have neither energy nor derivatives until this is called again, or resize(): constraints
  /// that hold nothing. Blocks of lanes that all rest cost nothing.
  void set_resting(const std::function<bool(int64_t element)>& rests);
  bool rests(int64_t block) const { return !resting_.empty() && resting_[block] != 0; }

  void set_rest(std::span<const Vec3> X);  ///< fills the Rest fields; X by site [m]
  /// Fills the Previous and the Beyond fields; by site [m].
  void set_previous(std::span<const Vec3> x_prev);
  void set_beyond(std::span<const Vec3> x_beyond);  ///< fills the Beyond fields; by site [m]
  void set_initial(std::span<const Vec3> x);        ///< fills the Initial fields; by site [m]

  /// Internal variables at the start of the step, [element][potential().internal_width()]; those of new
  /// elements have their values of time 0.
  std::vector<double> internal_values() const;
  void set_internal(std::span<const double> values);
  /// What they become in a step that ends at x; x by site [m].
  std::vector<double> updated_internal(std::span<const Vec3> x) const;

  /// Of an energy of totals: x becomes where the plane touches it that evaluate() of some blocks gives. To be
  /// done before, and anew for other positions or parameters; nothing to do for other energies.
  void touch(std::span<const Vec3> x);
  PotentialBatch touching(std::span<const Vec3> x) const;  ///< a copy that does
  /// What was found there; empty without totals.
  const TouchingPlane& plane() const { return plane_; }
  /// Energy at x beyond that of the plane's last place, and what its rounding is in proportion to [J]; of an
  /// energy of totals.
  EnergyDifference change_of_totals(std::span<const Vec3> x) const;
  /// Derivative of total k with respect to the position of every site, added to `out`.
  void add_total_gradient(int k, std::span<const Vec3> x, std::span<Vec3> out) const;

  /// Evaluates blocks [first, last) at site positions x. out: [last-first][output_count][kLanes]. Padding
  /// lanes of the last block repeat the last element.
  void evaluate(symbolic::Order order, std::span<const Vec3> x, int64_t first, int64_t last,
                double* out) const;
  /// The same of the blocks that act, one after another; returns how many there are and which. Of a one-sided
  /// potential those without energy do not: their derivatives are zero, and nothing is written for them. At
  /// most kGroupBlocks blocks.
  struct ActiveBlocks {
    int count = 0;
    std::array<int64_t, kGroupBlocks> blocks{};
  };
  ActiveBlocks evaluate_active(symbolic::Order order, std::span<const Vec3> x, int64_t first, int64_t last,
                               double* out) const;
  /// Outputs of an order for all elements, [element][output]; of an energy of totals those of the plane that
  /// touches it at x.
  std::vector<double> evaluate(symbolic::Order order, std::span<const Vec3> x) const;
  std::vector<double> energies(std::span<const Vec3> x) const { return evaluate(symbolic::Order::Energy, x); }
  /// Outputs of a function of the same inputs for all elements, [element][output].
  std::vector<double> evaluate(const symbolic::Function& function, std::span<const Vec3> x) const;
  /// The same with unknowns in lanes instead of positions by site: [last-first][3 points][kLanes].
  void evaluate_lanes(symbolic::Order order, const double* unknowns, int64_t first, int64_t last,
                      double* out) const;

 private:
  std::vector<double> evaluate_all(symbolic::Order order, std::span<const Vec3> x) const;
  /// Totals at x, [m].
  std::vector<double> totals_at(std::span<const Vec3> x) const;
  /// Outputs of a measure for all blocks, lane by lane.
  AlignedVector<double> evaluate_measure(int k, symbolic::Order order, std::span<const Vec3> x) const;
  /// Positions of the points of blocks [first, last), lane by lane; padding repeats the last element.
  void gather(std::span<const Vec3> x, int64_t first, int64_t last, double* lanes) const;
  void fill(ElementField::Source source, std::span<const Vec3> values);
  double* lane(int64_t element, int offset) {
    return elements_.data() + (element / symbolic::kLanes) * potential_->element_width() * symbolic::kLanes +
           static_cast<int64_t>(offset) * symbolic::kLanes + element % symbolic::kLanes;
  }
  void copy_padding(int64_t element, int offset);

  std::shared_ptr<const Potential> potential_;
  int64_t size_ = 0;
  std::vector<int32_t> stencils_;
  AlignedVector<double> elements_;
  AlignedVector<double> uniforms_;
  std::vector<char> resting_;  ///< by block of lanes; empty: none rests
  TouchingPlane plane_;
  int time_step_offset_ = -1, time_offset_ = -1;
};

}  // namespace stark
