// The way from start to end of a step (step phase 5).
#pragma once

#include <string>
#include <vector>

#include <stark/sim/step/prescribed.h>
#include <stark/sim/step/step_motion.h>

namespace stark {

class StepWay : private StepPart {
 public:
  StepWay(const StepContext& context, const StepMotion& motion, PrescribedBodies prescribed);

  /// Whether the attempt that ends where the potential stands went around something: its iterates followed a
  /// clear path from `start`, but the way that the bodies had to go is not clear.
  bool leads_through_something(const Configuration& start);
  /// "'gripper' and 'table'", of prescribed bodies that meet in the step that ends at the solution; or empty.
  std::string meeting_text();

 private:
  /// Whether something moved so far in the step that it may have gone around something.
  bool moved_far() const;
  /// Whether nothing meets on the way from the start of the step, in `pieces` of equal length in which
  /// vertices go straight.
  bool is_way_clear(const Configuration& start, const Configuration& end, int pieces);

  const StepMotion& motion_;
  PrescribedBodies prescribed_;
  /// By body: what the diagonal of its box is never below, however it turns; 0 of what changes its shape [m].
  std::vector<double> least_size_;
};

}  // namespace stark
