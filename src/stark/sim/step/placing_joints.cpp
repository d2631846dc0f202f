// Placing of joints: a coordinate is set by moving what hangs on one side of the joint as one, a rate by
// adding a rigid motion to it. The motion is the least one that leads to the coordinates with all residuals
// at zero [Gauss-Newton; Nocedal & Wright 2006, sec. 10.3], for joints of any formula.
#include <algorithm>
#include <array>
#include <cmath>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/sim/scene/joint_wrench.h>
#include <stark/sim/step/placing.h>

namespace stark {

namespace {

using Row6 = std::array<double, 6>;

constexpr int kIterations = 30;
/// Turn or relative motion in one series of iterations, which converge from there [rad].
constexpr double kWay = 0.2;
/// Differences for derivatives [m, rad], and what is left of residuals and coordinates of a placed joint.
constexpr double kDifference = 1e-6, kPlaced = 1e-9;
/// Of the normal matrix, over its trace: picks the least motion where several lead there.
constexpr double kRegularization = 1e-10;

/// The least d with J d = -F, in the sense of least squares.
Row6 least_motion(const std::vector<Row6>& J, const std::vector<double>& F) {
  double A[6][6] = {}, trace = 0.0;
  Row6 d{};
  for (size_t r = 0; r < J.size(); ++r)
    for (int i = 0; i < 6; ++i) {
      d[i] -= J[r][i] * F[r];
      for (int j = 0; j < 6; ++j) A[i][j] += J[r][i] * J[r][j];
    }
  for (int i = 0; i < 6; ++i) trace += A[i][i];
  for (int i = 0; i < 6; ++i) A[i][i] += kRegularization * trace + 1e-300;
  for (int i = 0; i < 6; ++i) {  // Cholesky, in place
    for (int j = 0; j < i; ++j) {
      for (int k = 0; k < j; ++k) A[i][j] -= A[i][k] * A[j][k];
      A[i][j] /= A[j][j];
      A[i][i] -= A[i][j] * A[i][j];
    }
    A[i][i] = std::sqrt(A[i][i]);
  }
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < i; ++k) d[i] -= A[i][k] * d[k];
    d[i] /= A[i][i];
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) d[i] -= A[k][i] * d[k];
    d[i] /= A[i][i];
  }
  return d;
}

double largest(std::span<const double> values) {
  double result = 0.0;
  for (const double v : values) result = std::fmax(result, std::fabs(v));
  return result;
}

bool holds_world(const AttachmentDescription& attachment) {
  const auto is_world = [](const PointSet& points) { return points.kind == PointKind::WorldPoints; };
  return is_world(attachment.a) || std::ranges::any_of(attachment.b, is_world);
}

}  // namespace

const std::string& Placing::joint_name(int32_t joint) const { return scene_.joints()[joint].name; }

bool Placing::touches(int32_t constraint, const std::set<int32_t>& bodies) const {
  const auto any = [&](const std::set<int32_t>& some) {
    return std::ranges::any_of(some, [&](int32_t body) { return bodies.contains(body); });
  };
  const auto joints = static_cast<int32_t>(scene_.joints().size());
  const auto actuators = static_cast<int32_t>(scene_.actuators().size());
  if (constraint < joints) return any(connected_bodies(scene_.joints()[constraint]));
  if (constraint < joints + actuators)
    return std::ranges::any_of(scene_.actuators()[constraint - joints].on, [&](const CoordinateName& name) {
      return any(connected_bodies(scene_.joints()[name.joint.index]));
    });
  const auto after =
      std::ranges::upper_bound(model_.attachments(), constraint, {}, &ModelAttachment::first_constraint);
  return any(connected_bodies(scene_.attachments()[after - model_.attachments().begin() - 1]));
}

std::string Placing::misfit_text(const std::function<bool(int32_t)>& some) {
  ConstraintSet& constraints = energies_.constraints;
  if (constraints.joint_count() == 0) return "";
  const std::vector<Vec3> x = model_.site_positions(state_);
  for (ConstraintGroup& group : constraints.groups()) group.batch.set_previous(x);
  const std::vector<Vec3> start = std::exchange(step_start_, x);
  const State kept = state_;
  const MotionReference reference = motion_.reference();  // what sensors of the last step read
  state_.previous_time_step = 0.0;  // limits and gears are asked for coordinates as they are, without history
  motion_.begin(settings_.time.step);
  joints_.begin_actuators(settings_.time.step);
  state_ = kept;
  step_start_ = start;
  const std::string text = joints_.violation_text(x, some);
  motion_.set_reference(reference);
  if (!reference.sites.empty())
    for (ConstraintGroup& group : constraints.groups()) group.batch.set_previous(reference.sites);
  return text;
}

void Placing::check_constraints(const std::set<int32_t>& moved) {
  const std::string text = misfit_text([&](int32_t constraint) { return touches(constraint, moved); });
  if (text.empty()) return;
  throw InvalidArgument(
      text +
      " where bodies are placed; place what it connects together, or set the coordinates of the joint");
}

void Placing::restart_constraints(const std::set<int32_t>& moved, const std::set<int32_t>& changed) {
  const ConstraintSet& constraints = energies_.constraints;
  if (constraints.joint_count() == 0) return;
  const std::vector<Vec3> x = model_.site_positions(state_);
  const double time = short_time(changed);
  const std::vector<double> now = constraints.coordinates(x), before = constraints.coordinates(sites(time)),
                            after = constraints.coordinates(sites(-time));
  for (int32_t j = 0; j < constraints.joint_count(); ++j) {
    if (!touches(j, changed)) continue;
    const ConstraintSet::Place& place = constraints.place(j);
    const Joint& joint = *constraints.groups()[place.group].joint;
    if (touches(j, moved)) let_go(state_, place.residual, joint.units().size());
    for (size_t k = 0; k < joint.coordinates().size(); ++k) {
      const size_t q = place.coordinate + k;
      const bool is_angle = joint.coordinates()[k].unit == "rad";
      const double change = after[q] - before[q];
      const double rate = (is_angle ? shortest_turn(change) : change) / (2.0 * time);
      if (!state_.previous_joint_rate.empty())
        state_.previous_joint_rate[q] =
            touches(j, moved) ? rate : state_.previous_joint_rate[q] + rate - state_.joint_rate[q];
      state_.joint_rate[q] = rate;
      double& value = state_.joint_coordinate[q];
      value = is_angle ? value + shortest_turn(now[q] - value) : now[q];
    }
  }
  const auto joints = static_cast<int32_t>(scene_.joints().size());
  for (size_t k = 0; k < model_.actuators().size(); ++k) {
    if (!touches(joints + static_cast<int32_t>(k), moved)) continue;
    const ModelActuator& actuator = model_.actuators()[k];
    std::fill_n(state_.actuator_memory.begin() + actuator.memory, actuator.law->memories().size(), 0.0);
    std::fill_n(state_.actuator_effort.begin() + actuator.effort, actuator.coordinates.size(), 0.0);
  }
}

bool Placing::is_held(int32_t body) const {
  const ModelBody& b = model_.bodies()[body];
  return scene_.motion(BodyId{body}) != Motion::Dynamic || !b.pins.empty() || !b.clamped.empty();
}

std::optional<std::set<int32_t>> Placing::hanging(int32_t joint, const FrameDescription& from,
                                                  const FrameDescription& other) const {
  if (from.carrier == FrameDescription::Carrier::World || is_held(from.body.index)) return {};
  std::set<int32_t> found{from.body.index};
  std::vector<int32_t> open{from.body.index};
  bool is_free = true;
  const auto follow = [&](const std::set<int32_t>& connected, int32_t body, bool to_world) {
    if (!connected.contains(body)) return;
    is_free = is_free && !to_world;
    for (const int32_t next : connected)
      if (found.insert(next).second) open.push_back(next), is_free = is_free && !is_held(next);
  };
  while (!open.empty() && is_free) {
    const int32_t body = open.back();
    open.pop_back();
    for (int32_t j = 0; j < static_cast<int32_t>(scene_.joints().size()); ++j) {
      const JointDescription& link = scene_.joints()[j];
      if (j == joint || state_.joint_enabled[j] != kHeld) continue;
      follow(connected_bodies(link), body,
             link.a.carrier == FrameDescription::Carrier::World ||
                 link.b.carrier == FrameDescription::Carrier::World);
    }
    for (size_t k = 0; k < scene_.attachments().size(); ++k) {
      const AttachmentDescription& link = scene_.attachments()[k];
      const auto first = state_.attachment_held.begin() + model_.attachments()[k].first_pair;
      if (std::none_of(first, first + link.size(), [](double held) { return held == kHeld; })) continue;
      follow(connected_bodies(link), body, holds_world(link));
    }
  }
  if (!is_free) return {};
  const bool is_loop = other.carrier != FrameDescription::Carrier::World && found.contains(other.body.index);
  return is_loop ? std::nullopt : std::optional(found);
}

Placing::Branch Placing::branch(int32_t joint) const {
  const JointDescription& description = scene_.joints()[joint];
  if (state_.joint_enabled[joint] == kBroken)
    throw InvalidArgument("joint '" + joint_name(joint) +
                          "' is broken: its coordinates cannot be set, and it does not hold again; place the "
                          "bodies, or load a state from before it broke");
  if (state_.joint_enabled[joint] != kHeld)
    throw InvalidArgument("joint '" + joint_name(joint) +
                          "' is released: its coordinates cannot be set; enable it, or place the bodies");
  if (auto found = hanging(joint, description.b, description.a)) return {*found, true};
  if (auto found = hanging(joint, description.a, description.b)) return {*found, false};
  throw InvalidArgument("joint '" + joint_name(joint) +
                        "': its coordinates cannot be set, as neither side hangs on it alone: other joints, "
                        "attachments, pins or the program hold them, too; place all bodies of the loop "
                        "together instead (sim.placing())");
}

std::vector<double> Placing::values(int32_t joint, std::span<const Vec3> x) const {
  const ConstraintSet::Place& place = energies_.constraints.place(joint);
  const ConstraintGroup& group = energies_.constraints.groups()[place.group];
  const std::vector<double> all = group.batch.evaluate(group.joint->values(), x);
  const auto outputs = static_cast<std::ptrdiff_t>(group.joint->values().output_count());
  const auto first = all.begin() + place.element * outputs;
  return {first, first + outputs};
}

std::vector<Vec3> Placing::sites(double time_ago) const {
  Configuration at{state_.point_position, state_.body_position, state_.body_rotation};
  if (time_ago != 0.0) {
    for (size_t p = 0; p < at.point_position.size(); ++p)
      at.point_position[p] -= state_.point_velocity[p] * time_ago;
    for (size_t b = 0; b < at.body_position.size(); ++b) {
      at.body_position[b] -= state_.body_velocity[b] * time_ago;
      at.body_rotation[b] = exp_rotation(state_.body_angular_velocity[b] * -time_ago) * at.body_rotation[b];
    }
  }
  std::vector<Vec3> x(model_.map().site_count());
  model_.map().positions(at, x);
  return x;
}

double Placing::short_time(const std::set<int32_t>& bodies) const {
  double speed = 1.0;
  for (const int32_t body : bodies) {
    const auto [first, count] = rigid_range(body);
    for (int32_t i = first; i < first + count; ++i)
      speed = std::fmax(speed, norm(state_.body_velocity[i]) + norm(state_.body_angular_velocity[i]));
    const ModelBody& b = model_.bodies()[body];
    for (int32_t p = b.first_site; count == 0 && p < b.first_site + b.site_count; ++p)
      speed = std::fmax(speed, norm(state_.point_velocity[p]));
  }
  return kDifference / speed;
}

std::vector<double> Placing::rates(int32_t joint) const {
  const double time = short_time(connected_bodies(scene_.joints()[joint]));
  std::vector<double> before = values(joint, sites(time)), after = values(joint, sites(-time));
  for (size_t k = 0; k < after.size(); ++k)
    after[k] = shortest_turn(after[k] - before[k]) / (2.0 * time);  // turns are tiny, lengths below a metre
  return after;
}

Vec3 Placing::pivot(int32_t joint, std::span<const Vec3> x) const {
  // The mean of the points that both frames have there: what turns about it hardly moves them.
  const ConstraintSet::Place& place = energies_.constraints.place(joint);
  const ConstraintGroup& group = energies_.constraints.groups()[place.group];
  const std::span<const int32_t> stencil = group.batch.stencil(place.element);
  Vec3 sum;
  int count = 0;
  for (const int32_t site : stencil) {
    const SiteKind kind = model_.map().site(site).kind;
    if (kind == SiteKind::RigidDirection || kind == SiteKind::World) continue;
    sum += x[site];
    ++count;
  }
  return count > 0 ? sum / count : Vec3{};
}

void Placing::move_sites(int32_t joint, bool is_b, const Transform& transform, std::vector<Vec3>& x) const {
  const ConstraintSet::Place& place = energies_.constraints.place(joint);
  const ConstraintGroup& group = energies_.constraints.groups()[place.group];
  const bool a_is_patch = scene_.joints()[joint].a.carrier == FrameDescription::Carrier::Patch;
  const int first_b = frame_point_count(a_is_patch ? FrameKind::Patch : FrameKind::Axes);
  const std::span<const int32_t> stencil = group.batch.stencil(place.element);
  std::set<int32_t> moved;  // a site may be in a stencil twice
  for (int k = 0; k < group.batch.point_count(); ++k) {
    if ((group.joint->points()[k] >= first_b) != is_b || !moved.insert(stencil[k]).second) continue;
    Vec3& p = x[stencil[k]];
    const bool is_direction = model_.map().site(stencil[k]).kind == SiteKind::RigidDirection;
    p = is_direction ? transform.rotation * p : transform(p);
  }
}

std::vector<Row6> Placing::jacobian(int32_t joint, bool is_b, const Vec3& pivot,
                                    std::span<const Vec3> x) const {
  std::vector<Row6> J(values(joint, x).size());
  for (int i = 0; i < 6; ++i) {
    std::array<std::vector<double>, 2> F;
    for (int side = 0; side < 2; ++side) {
      Vec3 shift, turn;
      (i < 3 ? shift : turn)[i % 3] = side == 0 ? -kDifference : kDifference;
      std::vector<Vec3> y(x.begin(), x.end());
      move_sites(joint, is_b, {exp_rotation(turn), pivot, shift}, y);
      F[side] = values(joint, y);
    }
    for (size_t r = 0; r < J.size(); ++r) J[r][i] = shortest_turn(F[1][r] - F[0][r]) / (2.0 * kDifference);
  }
  return J;
}

std::vector<double> Placing::error(int32_t joint, std::span<const Vec3> x,
                                   std::span<const double> target) const {
  const ConstraintSet::Place& place = energies_.constraints.place(joint);
  const Joint& law = *energies_.constraints.groups()[place.group].joint;
  std::vector<double> F = values(joint, x);
  const size_t rows = law.units().size();
  for (size_t r = 0; r < rows; ++r)
    if (law.one_sided()[r] != 0) F[r] = std::fmax(0.0, F[r]);
  for (size_t k = 0; k < target.size(); ++k) {
    const double off = F[rows + k] - target[k];
    F[rows + k] = law.coordinates()[k].unit == "rad" ? shortest_turn(off) : off;
  }
  return F;
}

std::vector<Placing::Transform> Placing::way_to(int32_t joint, bool is_b,
                                                std::span<const double> target) const {
  std::vector<Vec3> x = model_.site_positions(state_);
  const ConstraintSet::Place& place = energies_.constraints.place(joint);
  const size_t rows = energies_.constraints.groups()[place.group].joint->units().size();
  const std::vector<double> off = error(joint, x, target);
  const double way = largest(std::span(off).subspan(rows));
  const int pieces = std::max(1, static_cast<int>(std::ceil(std::fmin(way, 1e3) / kWay)));
  std::vector<Transform> transforms;
  for (int piece = 1; piece <= pieces; ++piece) {
    std::vector<double> here(target.begin(), target.end());
    for (size_t k = 0; k < here.size(); ++k)
      here[k] -= off[rows + k] * (static_cast<double>(pieces - piece) / pieces);
    std::vector<double> F = error(joint, x, here);
    double last = std::numeric_limits<double>::infinity();
    // As long as it helps: what is left is rounding.
    for (int n = 0; n < kIterations && largest(F) > 0.0 && largest(F) < 0.5 * last; ++n) {
      last = largest(F);
      const Vec3 at = pivot(joint, x);
      const Row6 d = least_motion(jacobian(joint, is_b, at, x), F);
      transforms.push_back({exp_rotation({d[3], d[4], d[5]}), at, {d[0], d[1], d[2]}});
      move_sites(joint, is_b, transforms.back(), x);
      F = error(joint, x, here);
    }
    if (!(largest(F) <= kPlaced * std::fmax(1.0, largest(here))))
      throw InvalidArgument("joint '" + joint_name(joint) +
                            "': there is no placement with these coordinates, or none on the way from the "
                            "present ones; must be coordinates that the joint can have");
  }
  return transforms;
}

void Placing::move(const std::set<int32_t>& bodies, const Transform& transform) {
  const Mat3& R = transform.rotation;
  for (const int32_t body : bodies) {
    const auto [first, count] = rigid_range(body);
    for (int32_t i = first; i < first + count; ++i) {
      state_.body_position[i] = transform(state_.body_position[i]);
      state_.body_rotation[i] = orthonormalized(R * state_.body_rotation[i]);
    }
    for (const int32_t i : fibre_frames(body))
      state_.body_rotation[i] = orthonormalized(R * state_.body_rotation[i]);
    const ModelBody& b = model_.bodies()[body];
    for (int32_t p = b.first_site; count == 0 && p < b.first_site + b.site_count; ++p)
      state_.point_position[p] = transform(state_.point_position[p]);
    moved_.insert(body);
  }
}

void Placing::turn_velocities(const std::set<int32_t>& bodies, const Transform& transform,
                              const FrameDescription& about) {
  // In the eyes of a rigid body on the other side, what hangs goes on moving as it did.
  Vec3 origin, linear, angular;
  if (about.carrier == FrameDescription::Carrier::Body) {
    const int32_t i = model_.bodies()[about.body.index].rigid_index;
    origin = state_.body_position[i], linear = state_.body_velocity[i],
    angular = state_.body_angular_velocity[i];
  }
  const auto carried = [&](const Vec3& p) { return linear + cross(angular, p - origin); };
  const Mat3& R = transform.rotation;
  const auto turned = [&](const Vec3& v, const Vec3& p) {  // p: after the motion
    const Vec3 before = transpose(R) * (p - transform.pivot - transform.shift) + transform.pivot;
    return carried(p) + R * (v - carried(before));
  };
  for (const int32_t body : bodies) {
    const auto [first, count] = rigid_range(body);
    for (int32_t i = first; i < first + count; ++i) {
      state_.body_velocity[i] = turned(state_.body_velocity[i], state_.body_position[i]);
      state_.body_angular_velocity[i] = angular + R * (state_.body_angular_velocity[i] - angular);
    }
    for (const int32_t i : fibre_frames(body))
      state_.body_angular_velocity[i] = angular + R * (state_.body_angular_velocity[i] - angular);
    const ModelBody& b = model_.bodies()[body];
    for (int32_t p = b.first_site; count == 0 && p < b.first_site + b.site_count; ++p)
      state_.point_velocity[p] = turned(state_.point_velocity[p], state_.point_position[p]);
  }
}

void Placing::add_twist(const std::set<int32_t>& bodies, const Vec3& pivot, const Twist& twist) {
  const auto at = [&](const Vec3& p) { return twist.linear + cross(twist.angular, p - pivot); };
  for (const int32_t body : bodies) {
    const auto [first, count] = rigid_range(body);
    for (int32_t i = first; i < first + count; ++i) {
      state_.body_velocity[i] += at(state_.body_position[i]);
      state_.body_angular_velocity[i] += twist.angular;
    }
    for (const int32_t i : fibre_frames(body)) state_.body_angular_velocity[i] += twist.angular;
    const ModelBody& b = model_.bodies()[body];
    for (int32_t p = b.first_site; count == 0 && p < b.first_site + b.site_count; ++p)
      state_.point_velocity[p] += at(state_.point_position[p]);
    pushed_.insert(body);
  }
}

void Placing::set_rates(int32_t joint, const Branch& branch, std::span<const double> wanted) {
  const std::vector<Vec3> x = model_.site_positions(state_);
  const ConstraintSet::Place& place = energies_.constraints.place(joint);
  const Joint& law = *energies_.constraints.groups()[place.group].joint;
  std::vector<double> off = rates(joint);
  for (size_t k = 0; k < wanted.size(); ++k) off[law.units().size() + k] -= wanted[k];
  for (size_t r = 0; r < law.units().size(); ++r)
    if (law.one_sided()[r] != 0) off[r] = 0.0;
  const Vec3 at = pivot(joint, x);
  const Row6 d = least_motion(jacobian(joint, branch.is_b, at, x), off);
  add_twist(branch.bodies, at, {{d[0], d[1], d[2]}, {d[3], d[4], d[5]}});
}

void Placing::put_joint(int32_t joint, std::span<const double> coordinates) {
  const Branch moving = branch(joint);
  const JointDescription& description = scene_.joints()[joint];
  const ConstraintSet::Place& place = energies_.constraints.place(joint);
  const auto present = state_.joint_coordinate.begin() + place.coordinate;
  if (changed().empty() && std::ranges::equal(coordinates, std::span(present, coordinates.size()))) return;
  const auto rate = state_.joint_rate.begin() + place.coordinate;
  const std::vector<double> kept{rate, rate + static_cast<std::ptrdiff_t>(coordinates.size())};
  const std::vector<Transform> way = way_to(joint, moving.is_b, coordinates);
  for (const Transform& transform : way) {
    move(moving.bodies, transform);
    turn_velocities(moving.bodies, transform, moving.is_b ? description.a : description.b);
  }
  set_rates(joint, moving, kept);
  std::ranges::copy(coordinates, state_.joint_coordinate.begin() + place.coordinate);
}

void Placing::push_joint(int32_t joint, std::span<const double> rates) {
  const Branch moving = branch(joint);
  const auto present = state_.joint_rate.begin() + energies_.constraints.place(joint).coordinate;
  if (changed().empty() && std::ranges::equal(rates, std::span(present, rates.size()))) return;
  set_rates(joint, moving, rates);
}

}  // namespace stark
