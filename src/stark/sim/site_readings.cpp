#include <stark/sim/site_readings.h>

#include <cstring>

namespace stark {

namespace {

/// Bit by bit: 0 and -0 differ.
template <typename Value>
bool is_same(const std::vector<Value>& a, const std::vector<Value>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0);
}

}  // namespace

bool SiteReadings::is_of(const State& state) const {
  return is_same(body_position_, state.body_position) && is_same(body_rotation_, state.body_rotation) &&
         is_same(point_position_, state.point_position);
}

const std::vector<Vec3>& SiteReadings::get(const State& state, const Model& model) {
  const std::lock_guard lock(mutex_);
  if (revision_ > 0 && is_of(state)) return x_;
  x_ = model.site_positions(state);
  point_position_ = state.point_position;
  body_position_ = state.body_position;
  body_rotation_ = state.body_rotation;
  ++revision_;
  return x_;
}

}  // namespace stark
