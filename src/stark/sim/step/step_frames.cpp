// Free bodies of points in frames that turn with them, with implicit Euler (step phases 1 and 6).
// [theory eq. 26f]
#include <algorithm>

#include <stark/sim/step/step_motion.h>

namespace stark {

namespace {

/// Whether none of the points is prescribed.
bool is_free(const TurningRange& range, const DofLayout& layout) {
  const auto blocks = range.of(range.are_nodes ? layout.body_block : layout.point_block);
  return std::ranges::find(blocks, kNoBlock) == blocks.end();
}

bool turns(const std::vector<TurningFrame>& frames) {
  return std::ranges::any_of(frames, [](const TurningFrame& frame) { return frame.spin != Vec3{}; });
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
    const auto x = range.of(range.are_nodes ? state_.body_position : state_.point_position);
    const auto v = range.of(range.are_nodes ? state_.body_velocity : state_.point_velocity);
    const TurningFrame& frame = r.frames.emplace_back(turning_frame(range.masses, x, v, h));
    if (frame.spin == Vec3{}) continue;
    const auto mean = range.of(range.are_nodes ? r.body_velocity : r.point_velocity);
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
    const auto x = range.of(range.are_nodes ? r.place.body_position : r.place.point_position);
    const auto mean = range.of(range.are_nodes ? r.body_velocity : r.point_velocity);
    x_free.resize(x.size());
    for (size_t i = 0; i < x.size(); ++i) x_free[i] = x[i] + mean[i] * h;
    end_velocities(r.frames[k], range.masses, x, x_free,
                   range.of(range.are_nodes ? state_.body_position : state_.point_position), h,
                   range.of(range.are_nodes ? state_.body_velocity : state_.point_velocity));
  }
  if (turns(r.frames)) model_.map().follow(state_.point_velocity);
}

}  // namespace stark
