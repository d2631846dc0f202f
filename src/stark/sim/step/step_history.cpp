// What a step measures velocities from, and what the next one needs to know of it
// (mechanics/time_integrator.h). [theory eq. 26, 26a]
#include <algorithm>
#include <cmath>

#include <stark/base/rotation.h>
#include <stark/mechanics/free_rotation.h>
#include <stark/mechanics/site_gradient.h>
#include <stark/sim/model/internal_variables.h>
#include <stark/sim/step/step_motion.h>

namespace stark {

namespace {

/// Motion of contact pairs along their normals in a step, over their contact distance, from which the step
/// does not resolve how contact grows and fades.
constexpr double kLargestResolved = 0.1;

/// Of the kind bdf2_impact(): velocities of the end of the step are its mean ones.
bool is_impact(const TimeStencil& stencil) { return stencil.history > 0.0 && stencil.ahead == 0.0; }

/// What contact did to a body in the last step, and what is left of it beside all else: contact that is
/// balanced lasts. Elements balance even an impact where it acts, so the body as a whole must be, too.
/// [theory eq. 26e]
class Balance {
 public:
  void add(double mass, const Vec3& A, const Vec3& p) {
    left_over_ += (A + p) * mass;
    contact_ += p * mass;
    sum_ += mass * norm(p);
    add_products(mass * dot(A + p, p), mass * squared_norm(p));
  }
  /// Of kinetic energy: of what is left over with contact, and of contact with itself [J].
  void add_products(double left_over, double contact) {
    left_over_product_ += left_over;
    contact_product_ += contact;
  }
  bool touches() const { return contact_product_ > 0.0; }
  /// Where contact that has only begun is sudden, too.
  double part(bool begins_suddenly) const {
    const double net = squared_norm(contact_);
    const double whole = net > kPushed * kPushed * sum_ * sum_ ? dot(left_over_, contact_) / net : 0.0;
    const double product = left_over_product_ / contact_product_;
    const double sudden = kSudden * std::max(whole, product);
    return std::clamp(1.0 - (begins_suddenly ? std::max(sudden, -product - kBegun) : sudden), 0.0, 1.0);
  }

 private:
  static constexpr double kPushed = 0.1;  ///< share of the forces on a body that its parts do not cancel
  static constexpr double kSudden = 2.0;  ///< joints carry their part of an impact, too
  /// What pushes against contact beyond what it takes, over that: more, and contact has only begun.
  static constexpr double kBegun = 1.0;
  Vec3 left_over_, contact_;  ///< momenta [kg m/s]
  double sum_ = 0.0;          ///< [kg m/s]
  double left_over_product_ = 0.0, contact_product_ = 0.0;
};

Balance balance_of(const Model& model, const State& s, const ModelBody& body) {
  const DofLayout& layout = model.map().layout();
  Balance balance;
  for (int32_t b = body.rigid_index; b < body.rigid_index + body.rigid_count(); ++b) {
    const RigidMass& mass = model.rigid_masses()[b];
    if (layout.body_block[b] != kNoBlock)
      balance.add(mass.mass, s.body_increment[b], s.body_contact_increment[b]);
    if (layout.rotation_block[b] == kNoBlock) continue;
    const Vec3& p = s.body_spin_contact_increment[b];
    const Vec3 turn = velocity_of_momentum(s.body_rotation[b], mass.moments, p);
    balance.add_products(dot(s.body_spin_increment[b] + p, turn), dot(p, turn));
  }
  for (int32_t i = body.first_site; i < body.first_site + body.site_count; ++i)
    if (model.map().is_point(i) && layout.point_block[i] != kNoBlock)
      balance.add(model.point_masses()[i], s.point_increment[i], s.point_contact_increment[i]);
  return balance;
}

}  // namespace

std::vector<Vec3> StepMotion::free_motion(double h) const {
  Configuration free = target_configuration(h);
  const DofLayout& layout = model_.map().layout();
  for (size_t p = 0; p < free.point_position.size(); ++p)
    if (layout.point_block[p] != kNoBlock) free.point_position[p] += state_.point_velocity[p] * h;
  for (size_t b = 0; b < free.body_position.size(); ++b) {
    if (layout.body_block[b] != kNoBlock) free.body_position[b] += state_.body_velocity[b] * h;
    if (layout.rotation_block[b] != kNoBlock)
      free.body_rotation[b] =
          free_rotation(state_.body_rotation[b], model_.rigid_masses()[b].moments, spin(b), h);
  }
  model_.map().follow(free.point_position);
  std::vector<Vec3> x(model_.map().site_count());
  model_.map().positions(free, x);
  return x;
}

TimeStencil StepMotion::choose_stencil(double h, bool hits_stop) {
  const double h_before = state_.previous_time_step;
  const bool goes_on =
      has_history(settings_.time.integrator) && h_before > 0.0 && h <= kLargestBdf2Ratio * h_before;
  if (!goes_on) return implicit_euler(h);
  if (hits_stop) return bdf2_impact(h, h_before);
  if (!contact_) return bdf2(h, h_before);
  const bool gives_back = std::ranges::any_of(state_.restitution_due, [](double due) { return due != 0.0; });
  if (gives_back) return bdf2_impact(h, h_before);
  const std::vector<Vec3> x = free_motion(h);
  const ContactPipeline::Approach ahead = contact_->approach(step_start_, x);
  if (!ahead.hits && ahead.largest <= kLargestResolved) return bdf2(h, h_before);
  // What meets anew is sudden, however little it pushes at first.
  const bool meets = !std::ranges::includes(ahead.before, ahead.after);
  const double lasting = meets ? 0.0 : lasting_contact(ahead.before);
  return ahead.hits ? bdf2_impact(h, h_before, lasting) : bdf2_unresolved(h, h_before, lasting);
}

double StepMotion::lasting_contact(const std::set<int64_t>& touching) const {
  std::set<int32_t> bodies, bounce;
  for (const int64_t code : touching) {
    const auto [a, b] = groups_of_code(code);
    bodies.insert({a, b});
    // What stops them is given back at once, and never carried on.
    if (std::ranges::binary_search(state_.restitution_bodies, code)) bounce.insert({a, b});
  }
  double least = 1.0;
  bool has_pushed = false;
  for (const int32_t body : bodies) {
    const Balance balance = balance_of(model_, state_, model_.bodies()[body]);
    if (!balance.touches()) continue;
    has_pushed = true;
    least = std::min(least, balance.part(bounce.contains(body)));
  }
  return has_pushed ? least : 0.0;
}

void StepMotion::begin(double h, bool hits_stop) {
  const State& s = state_;
  MotionReference& r = reference_;
  const TimeStencil stencil = r.stencil = choose_stencil(h, hits_stop);
  r.has_impact = hits_stop || is_impact(stencil);
  const bool has_history = stencil.history != 0.0;
  const auto set = [&](const auto& x, const auto& v, const auto& A, const auto& p, const auto& Q, auto& place,
                       auto& velocity) {
    place = x;
    velocity = v;
    if (!has_history) return;
    for (size_t i = 0; i < x.size(); ++i) {
      place[i] = stencil.place(x[i], v[i], Q[i]);
      velocity[i] = stencil.velocity(v[i], A[i], p[i]);
    }
  };
  set(s.point_position, s.point_velocity, s.point_increment, s.point_contact_increment, s.point_lag,
      r.place.point_position, r.point_velocity);
  set(s.body_position, s.body_velocity, s.body_increment, s.body_contact_increment, s.body_lag,
      r.place.body_position, r.body_velocity);
  if (has_history) {
    model_.map().follow(r.place.point_position);
    model_.map().follow(r.point_velocity);
  }
  r.place.body_rotation = s.body_rotation;
  r.joint_rate = s.joint_rate;
  if (has_history) {
    for (size_t b = 0; b < s.body_rotation.size(); ++b) {
      const Mat3& R = s.body_rotation[b];
      const Mat3 v = skew(s.body_angular_velocity[b]) * R;
      const Mat3 Q = v - (R - s.previous_body_rotation[b]) * (1.0 / s.previous_time_step);
      r.place.body_rotation[b] = stencil.place(R, v, Q);
    }
    for (size_t q = 0; q < s.joint_rate.size(); ++q)
      r.joint_rate[q] += (s.joint_rate[q] - s.previous_joint_rate[q]) * stencil.history;
  }
  set_free_rotations(h);
  set_frames(h);
  r.sites.resize(model_.map().site_count());
  model_.map().positions(r.place, r.sites);
  r.friction_sites = step_start_;
  r.friction_duration = h;
  r.before.clear();
  r.beyond.clear();
  r.half_way.clear();
  r.beyond_half_way.clear();
  if (!has_history) return;
  r.since_before = s.previous_time_step;
  r.before.resize(r.sites.size());
  model_.map().positions({s.previous_point_position, s.previous_body_position, s.previous_body_rotation},
                         r.before);
  if (stencil.has_smooth_contact) {
    // By places, not by lags: what sticks has none of its own, whatever moves it.
    r.friction_duration = stencil.duration;
    for (size_t i = 0; i < r.sites.size(); ++i)
      r.friction_sites[i] += (step_start_[i] - r.before[i]) * stencil.history;
  }
  if (stencil.duration != stencil.scale) return;
  const double way = std::sqrt(1.0 + 1.0 / stencil.history);
  for (size_t i = 0; i < r.sites.size(); ++i)
    r.beyond.push_back(r.sites[i] + (r.sites[i] - step_start_[i]) * way);
}

void StepMotion::begin_flow(double h) {
  if (reference_.stencil.history == 0.0 || !has_flow(energies_)) return;
  const std::vector<Vec3> v = site_velocities();
  flow_for_half(energies_, {step_start_, v, state_.time, settings_.time.step}, h);
  for (size_t i = 0; i < v.size(); ++i) {
    reference_.half_way.push_back(step_start_[i] + v[i] * (0.5 * h));
    reference_.beyond_half_way.push_back(step_start_[i] + v[i] * h);
  }
}

std::vector<double> StepMotion::coordinates() const {
  const ConstraintSet& constraints = energies_.constraints;
  if (reference_.before.empty()) return constraints.coordinates(reference_.sites);
  std::vector<double> result = constraints.coordinates(step_start_);
  const std::vector<double> before = constraints.coordinates(reference_.before);
  for (int32_t j = 0; j < constraints.joint_count(); ++j) {
    const ConstraintSet::Place& place = constraints.place(j);
    const auto& coordinates = constraints.groups()[place.group].joint->coordinates();
    for (size_t k = 0; k < coordinates.size(); ++k) {
      const size_t q = place.coordinate + k;
      const double change = result[q] - before[q], rate = state_.joint_rate[q];
      const double mean =
          (coordinates[k].unit == "rad" ? shortest_turn(change) : change) / reference_.since_before;
      result[q] = reference_.stencil.place(result[q], rate, rate - mean);
    }
  }
  return result;
}

std::vector<Vec3> StepMotion::impulses_of(std::span<const PotentialBatch* const> batches) const {
  const KinematicMap& map = model_.map();
  std::vector<Vec3> impulses(map.layout().block_count);
  if (batches.empty()) return impulses;
  const std::span<const Vec3> x = potential_.site_positions();
  std::vector<Vec3> gradient(x.size());
  for (const PotentialBatch* batch : batches) add_site_gradient(*batch, x, 1.0, gradient);
  // Smooth or not, they have pushed for s with the weight that they have.
  const double factor = -reference_.stencil.scale;
  for (int32_t i = 0; i < map.site_count(); ++i) {
    if (gradient[i] == Vec3{}) continue;
    const SiteJacobian jacobian = map.jacobian(i, potential_.configuration());
    for (int t = 0; t < jacobian.term_count; ++t) {
      const JacobianTerm& term = jacobian.terms[t];
      if (term.block == kNoBlock) continue;
      impulses[term.block] += jacobian.pull_back(term, gradient[i]) * factor;
    }
    for (size_t k = 0; k < jacobian.support_blocks.size(); ++k)
      if (const int32_t block = jacobian.support_blocks[k]; block != kNoBlock)
        impulses[block] += gradient[i] * (jacobian.support_weights[k] * factor);
  }
  return impulses;
}

StepMotion::Impulses StepMotion::contact_impulses() {
  Impulses impulses{std::vector<Vec3>(model_.map().layout().block_count), {}, {}};
  if (contact_) {
    contact_->settle(potential_.known_positions());
    impulses.contact = impulses_of(contact_->batches(Curvature::Exact));
    impulses.restitution = impulses_of(contact_->restitution_batches());
    for (size_t b = 0; b < impulses.contact.size(); ++b) impulses.contact[b] -= impulses.restitution[b];
  }
  if (reference_.has_impact) {
    // Whatever is held gives way to the impact, too: a door that hits its stop or a wall pulls at its hinges.
    std::vector<const PotentialBatch*> held;
    for (const ConstraintGroup& group : energies_.constraints.groups())
      if (!group.joint->units().empty()) held.push_back(&group.batch);
    impulses.hit = impulses_of(held);
    for (size_t b = 0; b < impulses.hit.size(); ++b) impulses.contact[b] += impulses.hit[b];
  }
  return impulses;
}

void StepMotion::remember_state(double h) {
  State& s = state_;
  s.previous_time_step = h;
  s.previous_point_position = s.point_position;
  s.previous_body_position = s.body_position;
  s.previous_body_rotation = s.body_rotation;
  s.previous_body_angular_velocity = s.body_angular_velocity;
  s.previous_joint_rate = s.joint_rate;
}

StepMotion::Motions StepMotion::motions() const {
  Motions now{state_.point_velocity, state_.body_velocity, {}};
  for (size_t b = 0; b < state_.body_position.size(); ++b) now.spin.push_back(spin(b));
  return now;
}

void StepMotion::remember_increments(const Motions& before, const Impulses& impulses, double h) {
  State& s = state_;
  const DofLayout& layout = model_.map().layout();
  const TimeStencil& stencil = reference_.stencil;
  double lasting = 1.0;  // smallest part of contact on what joints have held in an impact
  const auto find_lasting = [&](int32_t block, double part) {
    const bool is_hit = block != kNoBlock && !impulses.hit.empty() && !(impulses.hit[block] == Vec3{});
    if (is_hit) lasting = std::min(lasting, part);
  };
  for (size_t p = 0; p < s.point_position.size(); ++p) {
    const Vec3 change = s.point_velocity[p] - before.point_velocity[p];
    const int32_t block = layout.point_block[p];
    if (block == kNoBlock) {
      s.point_increment[p] = change;
      s.point_contact_increment[p] = {};
      s.point_lag[p] = s.point_velocity[p] - (s.point_position[p] - s.previous_point_position[p]) / h;
      continue;
    }
    const Vec3 by_contact = s.point_contact_increment[p] =
        stencil.by_contact(s.point_contact_increment[p], impulses.contact[block] / model_.point_masses()[p]);
    const Vec3 A = s.point_increment[p] = change - by_contact;
    const double part = smooth_part(stencil, dot(A, by_contact), squared_norm(by_contact));
    s.point_lag[p] = next_lag(stencil, s.point_lag[p], A, by_contact, part);
    find_lasting(block, part);
  }
  for (size_t b = 0; b < s.body_position.size(); ++b) {
    const RigidMass& mass = model_.rigid_masses()[b];
    const bool moves = layout.body_block[b] != kNoBlock, turns = layout.rotation_block[b] != kNoBlock;
    const Vec3 pushed = moves ? impulses.contact[layout.body_block[b]] / mass.mass : Vec3{};
    const Vec3 p = s.body_contact_increment[b] = stencil.by_contact(s.body_contact_increment[b], pushed);
    const Vec3 p_spin = s.body_spin_contact_increment[b] = stencil.by_contact(
        s.body_spin_contact_increment[b], turns ? impulses.contact[layout.rotation_block[b]] : Vec3{});
    // What restitution gives back is sudden: no part of it is smooth.
    const bool gives_back = !impulses.restitution.empty();
    const Vec3 back = gives_back && moves ? impulses.restitution[layout.body_block[b]] / mass.mass : Vec3{};
    const Vec3 back_spin = gives_back && turns ? impulses.restitution[layout.rotation_block[b]] : Vec3{};
    const Vec3 A = s.body_increment[b] = s.body_velocity[b] - before.body_velocity[b] - p - back;
    const Vec3 A_spin = s.body_spin_increment[b] =
        turns ? spin(b) - before.spin[b] - p_spin - back_spin : Vec3{};
    const Vec3 turn = turns ? velocity_of_momentum(s.body_rotation[b], mass.moments, p_spin) : Vec3{};
    const double part = smooth_part(stencil, mass.mass * dot(A, p) + dot(A_spin, turn),
                                    mass.mass * squared_norm(p) + dot(p_spin, turn));
    s.body_lag[b] = moves ? next_lag(stencil, s.body_lag[b], A, p, part) : Vec3{};
    s.body_spin_lag[b] = turns ? next_lag(stencil, s.body_spin_lag[b], A_spin, p_spin, part) : Vec3{};
    if (!stencil.has_smooth_contact) reference_.contact_velocity[b] = pushed + back;
    find_lasting(layout.body_block[b], part);
    find_lasting(layout.rotation_block[b], part);
  }
  if (!impulses.hit.empty()) drop_impact(impulses.hit, 1.0 - lasting);
}

// A step that resolves contact takes p up again: of what joints have given in an impact, what lasts. The
// same part of it everywhere, so that what a joint has given its two sides still adds up to nothing.
void StepMotion::drop_impact(std::span<const Vec3> hit, double part) {
  const DofLayout& layout = model_.map().layout();
  const auto drop = [&](Vec3& increment, int32_t block, double mass) {
    if (block != kNoBlock) increment -= hit[block] * (part / mass);
  };
  for (size_t p = 0; p < state_.point_position.size(); ++p)
    drop(state_.point_contact_increment[p], layout.point_block[p], model_.point_masses()[p]);
  for (size_t b = 0; b < state_.body_position.size(); ++b) {
    drop(state_.body_contact_increment[b], layout.body_block[b], model_.rigid_masses()[b].mass);
    drop(state_.body_spin_contact_increment[b], layout.rotation_block[b], 1.0);
  }
}

}  // namespace stark
