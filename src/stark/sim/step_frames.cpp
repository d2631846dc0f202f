// Free bodies of points in frames that turn with them, with implicit Euler (step phases 1 and 6).
// [theory eq. 26f]
#include <algorithm>

#include <stark/sim/step_motion.h>

namespace stark {

namespace {

/// Whether none of the points is prescribed.
bool is_free(const TurningRange& range, const DofLayout& layout) {
  const std::vector<int32_t>& blocks = range.are_nodes ? layout.body_block : layout.point_block;
  const auto first = blocks.begin() + range.first;
  return std::find(first, first + static_cast<std::ptrdiff_t>(range.masses.size()), kNoBlock) ==
         first + static_cast<std::ptrdiff_t>(range.masses.size());
}

bool turns(const std::vector<TurningFrame>& frames) {
  return std::ranges::any_of(frames, [](const TurningFrame& frame) { return frame.spin != Vec3{}; });
}

template <typename Vectors>
auto part(Vectors& values, const TurningRange& range) {
  return std::span(values).subspan(static_cast<size_t>(range.first), range.masses.size());
}

}  // namespace

void StepMotion::set_frames(double h) {
  MotionReference& r = reference_;
  r.frames.clear();
  if (settings_.time.integrator != Integrator::ImplicitEuler) return;
  for (const TurningRange& range : model_.map().turning()) {
    if (!is_free(range, model_.map().layout())) {
      r.frames.emplace_back();
      continue;
    }
    const auto x = part(range.are_nodes ? state_.body_position : state_.point_position, range);
    const auto v = part(range.are_nodes ? state_.body_velocity : state_.point_velocity, range);
    const TurningFrame& frame = r.frames.emplace_back(turning_frame(range.masses, x, v, h));
    if (frame.spin == Vec3{}) continue;
    const auto mean = part(range.are_nodes ? r.body_velocity : r.point_velocity, range);
    for (size_t i = 0; i < x.size(); ++i) mean[i] = (free_place(frame, x[i], v[i], h) - x[i]) / h;
  }
  if (turns(r.frames)) model_.map().follow(r.point_velocity);
}

void StepMotion::commit_frames(double h) {
  const MotionReference& r = reference_;
  std::vector<Vec3> x_free;
  for (size_t k = 0; k < r.frames.size(); ++k) {
    const TurningRange& range = model_.map().turning()[k];
    if (r.frames[k].spin == Vec3{}) continue;
    const auto x = part(range.are_nodes ? r.place.body_position : r.place.point_position, range);
    const auto mean = part(range.are_nodes ? r.body_velocity : r.point_velocity, range);
    x_free.resize(x.size());
    for (size_t i = 0; i < x.size(); ++i) x_free[i] = x[i] + mean[i] * h;
    end_velocities(r.frames[k], range.masses, x, x_free,
                   part(range.are_nodes ? state_.body_position : state_.point_position, range), h,
                   part(range.are_nodes ? state_.body_velocity : state_.point_velocity, range));
  }
  if (turns(r.frames)) model_.map().follow(state_.point_velocity);
}

}  // namespace stark
