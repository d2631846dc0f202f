// Placing of bodies: what they had of contact and history ends where they are put elsewhere.
#include <stark/sim/step/placing.h>

#include <algorithm>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/contact/friction_memory.h>
#include <stark/sim/step/release_watch.h>

namespace stark {

namespace {

/// Keeps the entries of arrays side by side whose place is not dropped.
template <typename... Arrays>
void keep(const std::vector<bool>& dropped, Arrays&... arrays) {
  const auto filter = [&](auto& array) {
    size_t count = 0;
    for (size_t k = 0; k < dropped.size(); ++k)
      if (!dropped[k]) array[count++] = array[k];
    array.resize(count);
  };
  (filter(arrays), ...);
}

/// By pair of bodies: whether one of them is among some.
std::vector<bool> involved(const std::vector<int64_t>& pairs, const std::set<int32_t>& some) {
  std::vector<bool> result;
  for (const int64_t code : pairs) {
    const auto [a, b] = groups_of_code(code);
    result.push_back(some.contains(a) || some.contains(b));
  }
  return result;
}

}  // namespace

void Placing::require_closed(const char* what) const {
  if (is_open_)
    throw InvalidArgument(std::string(what) +
                          " cannot be asked for while bodies are placed together; end the placing first");
}

void Placing::begin() {
  require_closed("another placing");
  before_ = state_;
  stored_before_ = ledger_.stored_energies(model_.site_positions(state_)).stored();
  moved_.clear();
  pushed_.clear();
  is_open_ = true;
}

void Placing::cancel() {
  if (!is_open_) return;
  state_ = std::move(before_);
  is_open_ = false;
  const std::vector<Vec3> x = model_.site_positions(state_);
  if (!step_start_.empty()) return;  // the ledger has given energies what they measure from
  for (PotentialBatch* batch : energies_.all_batches()) batch->set_previous(x);
}

std::set<int32_t> Placing::changed() const {
  std::set<int32_t> bodies = moved_;
  bodies.insert(pushed_.begin(), pushed_.end());
  return bodies;
}

bool Placing::end(const std::function<void(std::span<const Vec3> x)>& check_clear) {
  if (changed().empty()) return is_open_ = false;
  try {
    if (!moved_.empty()) {
      if (contact_) check_clear(model_.site_positions(state_));
      if (contact_) check_contacts(moved_);
      check_constraints(moved_);
    }
  } catch (...) {
    cancel();
    throw;
  }
  if (contact_) drop_contact_memory(moved_);
  for (const int32_t body : changed())
    if (moved_.contains(body))
      restart_history(body);
    else
      shift_history(body);
  restart_constraints(moved_, changed());
  placed_.energy += ledger_.stored_energies(model_.site_positions(state_)).stored() - stored_before_;
  std::set<int32_t> bodies = changed();
  bodies.insert(placed_.bodies.begin(), placed_.bodies.end());
  placed_.bodies.assign(bodies.begin(), bodies.end());
  is_open_ = false;
  return true;
}

std::pair<int32_t, int32_t> Placing::rigid_range(int32_t body) const {
  const ModelBody& b = model_.bodies()[body];
  return {b.rigid_count() == 0 ? 0 : b.rigid_index, b.rigid_count()};
}

std::vector<int32_t> Placing::fibre_frames(int32_t body) const {
  std::vector<int32_t> frames;
  for (size_t f = 0; f < model_.fibres().size(); ++f) {
    if (scene_.fibres(FibresId{static_cast<int32_t>(f)}).body.index != body) continue;
    const ModelFibres& fibres = model_.fibres()[f];
    for (int32_t k = 0; k < fibres.frame_count; ++k) frames.push_back(fibres.first_frame + k);
  }
  return frames;
}

void Placing::require_matching(int32_t body, size_t rows, const char* what) const {
  const ModelBody& b = model_.bodies()[body];
  if (static_cast<int32_t>(rows) != b.site_count)
    throw InvalidArgument("body '" + scene_.name(BodyId{body}) + "': " + what + ": " + std::to_string(rows) +
                          " rows for " + std::to_string(b.site_count) +
                          " vertices; must be one for each vertex of its mesh");
}

void Placing::put_rigid(int32_t body, const Vec3& centre, const Mat3& rotation) {
  const int32_t index = model_.bodies()[body].rigid_index;
  state_.body_position[index] = centre;
  state_.body_rotation[index] = rotation;
  moved_.insert(body);
}

void Placing::put_points(int32_t body, std::span<const Vec3> positions) {
  require_matching(body, positions.size(), "positions");
  const ModelBody& b = model_.bodies()[body];
  const std::string owner = "body '" + scene_.name(BodyId{body}) + "': positions";
  if (has_nodes(b.kind))
    throw InvalidArgument(owner +
                          " of a rod cannot be placed, as its frames would not fit them; rewind to a state "
                          "in which the rod is as it should be, or turn a joint that it hangs on");
  if (!fibre_frames(body).empty())
    throw InvalidArgument(owner +
                          " of a body with fibres that bend cannot be placed, as their frames would not fit "
                          "them; rewind to a state in which it is as it should be");
  if (is_there(b, positions)) return;
  for (int32_t i = 0; i < b.site_count; ++i) {
    state_.point_position[b.first_site + i] = positions[i];
    if (model_.map().layout().point_block[b.first_site + i] != kNoBlock) continue;
    state_.pin_target[b.first_site + i] = positions[i];  // it rests there until it is sent elsewhere
    state_.point_velocity[b.first_site + i] = {};
  }
  follow();
  moved_.insert(body);
}

bool Placing::is_there(const ModelBody& body, std::span<const Vec3> positions) const {
  for (int32_t i = 0; i < body.site_count; ++i) {
    const int32_t p = body.first_site + i;
    if (state_.point_position[p] != positions[i]) return false;
    const bool is_pinned = model_.map().layout().point_block[p] == kNoBlock;
    if (is_pinned && (state_.pin_target[p] != positions[i] || state_.point_velocity[p] != Vec3{}))
      return false;
  }
  return true;
}

void Placing::put_together(const std::set<int32_t>& bodies, const Mat3& rotation, const Vec3& shift) {
  if (rotation == Mat3::identity() && shift == Vec3{}) return;
  const Transform transform{.rotation = rotation, .shift = shift};
  move(bodies, transform);
  turn_velocities(bodies, transform, world_frame({}));
  const DofLayout& layout = model_.map().layout();
  for (const int32_t body : bodies) {
    const ModelBody& b = model_.bodies()[body];
    const auto [first, count] = rigid_range(body);
    for (int32_t i = first; i < first + count; ++i) {
      if (layout.body_block[i] == kNoBlock) state_.script_position[i] = state_.body_position[i];
      if (layout.rotation_block[i] == kNoBlock) state_.script_rotation[i] = state_.body_rotation[i];
    }
    for (int32_t p = b.first_site; count == 0 && p < b.first_site + b.site_count; ++p) {
      if (layout.point_block[p] != kNoBlock) continue;
      state_.pin_target[p] = state_.point_position[p];
      state_.point_velocity[p] = {};
    }
  }
  follow();
}

void Placing::follow() {
  for (std::vector<Vec3>* values : {&state_.point_position, &state_.point_velocity, &state_.pin_target})
    model_.map().follow(*values);
}

void Placing::push_rigid(int32_t body, const Vec3& velocity, const Vec3& angular_velocity) {
  const int32_t index = model_.bodies()[body].rigid_index;
  if (state_.body_velocity[index] == velocity && state_.body_angular_velocity[index] == angular_velocity)
    return;
  state_.body_velocity[index] = velocity;
  state_.body_angular_velocity[index] = angular_velocity;
  pushed_.insert(body);
}

void Placing::push_points(int32_t body, std::span<const Vec3> velocities) {
  require_matching(body, velocities.size(), "velocities");
  const ModelBody& b = model_.bodies()[body];
  const DofLayout& layout = model_.map().layout();
  bool is_new = false;
  const auto set = [&](Vec3& present, const Vec3& given) {
    is_new = is_new || present != given;
    present = given;
  };
  for (int32_t i = 0; i < b.site_count; ++i) {
    if (has_nodes(b.kind)) {
      if (layout.body_block[b.rigid_index + i] != kNoBlock)
        set(state_.body_velocity[b.rigid_index + i], velocities[i]);
    } else if (layout.point_block[b.first_site + i] != kNoBlock) {
      set(state_.point_velocity[b.first_site + i], velocities[i]);
    }
  }
  if (!is_new) return;
  follow();
  pushed_.insert(body);
}

void Placing::check_contacts(const std::set<int32_t>& moved) {
  const std::vector<Vec3> x = model_.site_positions(state_);
  for (const Contact& contact : contact_->find_contacts_at(x)) {
    if (!moved.contains(contact.group_a) && !moved.contains(contact.group_b)) continue;
    if (is_touching(contact, x))
      throw InitialIntersection(
          "'" + scene_.name(BodyId{contact.group_a}) + "' and '" + scene_.name(BodyId{contact.group_b}) +
          "' touch where they are placed: " + "their distance is " + rough_text(contact.distance, "m") +
          "; place them apart, or disable contact between them");
  }
}

void Placing::drop_contact_memory(const std::set<int32_t>& moved) {
  State& s = state_;
  // What an impact has left to give back is of velocities that are gone.
  keep(involved(s.restitution_bodies, changed()), s.restitution_bodies, s.restitution_speed,
       s.restitution_impulse, s.restitution_work, s.restitution_load, s.restitution_stiffness,
       s.restitution_due, s.restitution_rate, s.restitution_normal, s.restitution_moment);
  if (moved.empty()) return;
  std::vector<bool> dropped;
  for (const int64_t code : s.friction_pair) {
    const PairKey key = unpack(code);
    dropped.push_back(moved.contains(groups_of(surface_mesh_, first_kind(key.kind))[key.first]) ||
                      moved.contains(groups_of(surface_mesh_, second_kind(key.kind))[key.second]));
  }
  keep(dropped, s.friction_pair, s.friction_deflection, s.friction_force);
  const std::vector<bool> no_load = involved(s.contact_bodies, moved);
  if (!s.contact_trial.empty()) keep(no_load, s.contact_trial, s.contact_trial_age);
  keep(no_load, s.contact_bodies, s.contact_factor);
  keep(involved(s.contact_close_bodies, moved), s.contact_close_bodies, s.contact_close_distance);
  // As at the start: what is within its contact distance is not thrown apart.
  const CloseBodies now = contact_->find_close_bodies(model_.site_positions(s));
  const std::vector<bool> is_new = involved(now.bodies, moved);
  CloseBodies close{std::move(s.contact_close_bodies), std::move(s.contact_close_distance)};
  for (size_t k = 0; k < now.bodies.size(); ++k)
    if (is_new[k]) close.set(now.bodies[k], now.distance[k]);
  s.contact_close_bodies = std::move(close.bodies);
  s.contact_close_distance = std::move(close.distance);
}

void Placing::restart_history(int32_t body) {
  State& s = state_;
  if (!has_history(settings_.time.integrator)) return;
  // As if it had come here in free fall: gravity is all that is known to have acted.
  const double h = s.previous_time_step;
  const Vec3 fallen = settings_.gravity * h, ahead = fallen * 0.5;
  const ModelBody& b = model_.bodies()[body];
  const DofLayout& layout = model_.map().layout();
  const auto restart_body = [&](int32_t i) {
    const bool falls = layout.body_block[i] != kNoBlock;
    s.body_increment[i] = falls ? fallen : Vec3{};
    s.body_lag[i] = falls ? ahead : Vec3{};
    s.body_contact_increment[i] = s.body_spin_increment[i] = s.body_spin_contact_increment[i] =
        s.body_spin_lag[i] = {};
    s.previous_body_position[i] = s.body_position[i] - (s.body_velocity[i] - s.body_lag[i]) * h;
    s.previous_body_rotation[i] = exp_rotation(s.body_angular_velocity[i] * -h) * s.body_rotation[i];
    s.previous_body_angular_velocity[i] = s.body_angular_velocity[i];
  };
  const auto [first, count] = rigid_range(body);
  for (int32_t i = first; i < first + count; ++i) restart_body(i);
  for (const int32_t i : fibre_frames(body)) restart_body(i);
  if (count > 0) return;
  for (int32_t p = b.first_site; p < b.first_site + b.site_count; ++p) {
    const bool falls = layout.point_block[p] != kNoBlock;
    s.point_increment[p] = falls ? fallen : Vec3{};
    s.point_lag[p] = falls ? ahead : Vec3{};
    s.point_contact_increment[p] = {};
    s.previous_point_position[p] = s.point_position[p] - (s.point_velocity[p] - s.point_lag[p]) * h;
  }
}

void Placing::shift_history(int32_t body) {
  State& s = state_;
  if (!has_history(settings_.time.integrator)) return;
  // Forces know nothing of the speed at which all of it moves: it has always moved faster by the difference.
  const double h = s.previous_time_step;
  const ModelBody& b = model_.bodies()[body];
  const auto [first, count] = rigid_range(body);
  for (int32_t i = first; i < first + count; ++i) {
    s.previous_body_position[i] -= (s.body_velocity[i] - before_.body_velocity[i]) * h;
    const Vec3 turning = s.body_angular_velocity[i] - before_.body_angular_velocity[i];
    if (turning == Vec3{}) continue;
    s.previous_body_rotation[i] = exp_rotation(turning * -h) * s.previous_body_rotation[i];
    s.previous_body_angular_velocity[i] += turning;
  }
  if (count > 0) return;
  for (int32_t p = b.first_site; p < b.first_site + b.site_count; ++p)
    s.previous_point_position[p] -= (s.point_velocity[p] - before_.point_velocity[p]) * h;
}

}  // namespace stark
