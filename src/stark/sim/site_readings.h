// Positions of the sites of a state, computed once for all readings of it. Phase: queries.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include <stark/mechanics/state.h>
#include <stark/sim/model/model.h>

namespace stark {

class SiteReadings {
 public:
  /// By site [m]; valid until the next call with another state.
  const std::vector<Vec3>& get(const State& state, const Model& model);
  /// Of the positions that it has; 0 before there are any.
  uint64_t revision() const { return revision_; }

 private:
  bool is_of(const State& state) const;

  std::mutex mutex_;
  std::vector<Vec3> x_;
  uint64_t revision_ = 0;
  // What x_ follows from:
  std::vector<Vec3> point_position_, body_position_;
  std::vector<Mat3> body_rotation_;
};

}  // namespace stark
