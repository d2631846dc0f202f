// The way from start to end of a step, which has to be clear (step phase 5). Newton's iterates follow a clear
// path, but at large steps it may lead around what is straight ahead: an end that is no motion of the bodies.
#include <algorithm>
#include <cmath>
#include <limits>

#include <stark/base/rotation.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/step/step_way.h>

namespace stark {

namespace {

/// Motion in a step, over the diagonal of the smallest body's box, from which the way is looked at. Who
/// changes sides with less has slipped over a border that was as near, which bodies do.
constexpr double kFarMotion = 0.25;

/// Turn of a body in a piece of its way, which its vertices go straight [rad]: chords are off from the arc by
/// an eighth of its square, 1 % of the radius.
constexpr double kTurnOfPiece = 0.3;

/// Pieces of the ways that are tried beyond those that the turn asks for.
constexpr int kFinerPieces[] = {4, 16};

/// Below it arcs are straight lines [rad].
constexpr double kSmallestTurn = 1e-6;

double largest_turn(const Configuration& a, const Configuration& b) {
  double turn = 0.0;
  for (size_t k = 0; k < a.body_rotation.size(); ++k)
    if (!(a.body_rotation[k] == b.body_rotation[k]))
      turn = std::max(turn, norm(log_rotation(b.body_rotation[k] * transpose(a.body_rotation[k]))));
  return turn;
}

/// At `fraction` of the way: points and centres of mass go straight, bodies turn about one axis.
Configuration interpolated(const Configuration& a, const Configuration& b, double fraction) {
  Configuration c = b;
  for (size_t p = 0; p < a.point_position.size(); ++p)
    c.point_position[p] = a.point_position[p] + (b.point_position[p] - a.point_position[p]) * fraction;
  for (size_t k = 0; k < a.body_position.size(); ++k) {
    c.body_position[k] = a.body_position[k] + (b.body_position[k] - a.body_position[k]) * fraction;
    if (!(a.body_rotation[k] == b.body_rotation[k]))
      c.body_rotation[k] = interpolate_rotation(a.body_rotation[k], b.body_rotation[k], fraction);
  }
  return c;
}

}  // namespace

bool StepWay::leads_through_something(const Configuration& start) {
  if (!contact_) return false;
  const PhaseTimer::Scope scope(timer_, Phase::StepBound);
  if (!moved_far()) return false;
  const Configuration& end = potential_.configuration();
  const double turn = largest_turn(start, end);
  const int pieces = std::max(1, static_cast<int>(std::ceil(turn / kTurnOfPiece)));
  if (is_way_clear(start, end, pieces)) return false;
  if (turn < kSmallestTurn) return true;
  return std::ranges::none_of(kFinerPieces,
                              [&](int finer) { return finer > pieces && is_way_clear(start, end, finer); });
}

StepWay::StepWay(const StepContext& context, const StepMotion& motion, PrescribedBodies prescribed)
    : StepPart(context), motion_(motion), prescribed_(std::move(prescribed)) {
  std::vector<Vec3> x(model_.map().site_count());
  model_.map().positions(motion_.start_configuration(), x);
  for (const ModelBody& body : model_.bodies()) {
    const Vec3 size = box_size(std::span(x).subspan(body.first_site, body.site_count));
    least_size_.push_back(is_rigid(body.kind) ? std::max({size.x, size.y, size.z}) : 0.0);
  }
}

bool StepWay::moved_far() const {
  const std::span<const Vec3> x = potential_.site_positions();
  double squared = 0.0;
  for (const ModelBody& body : model_.bodies()) {
    if (is_rigid(body.kind) && potential_.rests(body.rigid_index)) continue;
    for (int32_t i = body.first_site; i < body.first_site + body.site_count; ++i)
      squared = std::max(squared, squared_norm(x[i] - step_start_[i]));
  }
  const double motion = std::sqrt(squared);
  for (size_t k = 0; k < model_.bodies().size(); ++k) {
    const ModelBody& body = model_.bodies()[k];
    if (motion <= kFarMotion * least_size_[k]) continue;
    const Vec3 size = box_size(std::span(step_start_).subspan(body.first_site, body.site_count));
    if (motion > kFarMotion * norm(size)) return true;
  }
  return false;
}

std::string StepWay::meeting_text() {
  const PhaseTimer::Scope scope(timer_, Phase::StepBound);
  const Configuration start = motion_.start_configuration();
  const auto sites_at = [&](double fraction) {
    std::vector<Vec3> x(model_.map().site_count());
    model_.map().positions(interpolated(start, potential_.configuration(), fraction), x);
    return x;
  };
  std::string text;
  for (const auto& [a, b] :
       prescribed_.find_meetings(step_start_, potential_.site_positions(), sites_at, pool_))
    text += (text.empty() ? "'" : ", '") + scene_.name(BodyId{a}) + "' and '" + scene_.name(BodyId{b}) + "'";
  return text;
}

bool StepWay::is_way_clear(const Configuration& start, const Configuration& end, int pieces) {
  std::vector<Vec3> from(step_start_), to(from.size());
  for (int k = 1; k <= pieces; ++k) {
    if (k == pieces)
      std::ranges::copy(potential_.site_positions(), to.begin());
    else
      model_.map().positions(interpolated(start, end, static_cast<double>(k) / pieces), to);
    if (!contact_->is_clear(from, to)) return false;
    std::swap(from, to);
  }
  return true;
}

}  // namespace stark
