// Simulation: placing of bodies between steps (sim/step/placing.h).
#include <cmath>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/sim/scene/validation.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

namespace {

void check_rows(const std::string& owner, const char* what, std::span<const Vec3> rows, const char* unit) {
  for (size_t k = 0; k < rows.size(); ++k)
    check_finite(owner, std::string(what) + "[" + std::to_string(k) + "]", rows[k], unit);
}

}  // namespace

void Simulation::begin_placing() { parts_->placing.begin(); }
void Simulation::cancel_placing() { parts_->placing.cancel(); }
bool Simulation::is_placing() const { return parts_->placing.is_open(); }
const Placed& Simulation::placed() const { return parts_->placing.placed(); }

void Simulation::end_placing() {
  if (!is_placing()) throw InvalidArgument("end_placing(): no bodies are placed; begin_placing() begins it");
  const bool is_placed =
      parts_->placing.end([&](std::span<const Vec3> x) { check_state_clear(state_, x, "as placed"); });
  if (is_placed) forget_last_step();
}

void Simulation::place_with(const std::function<void(Placing&)>& change) {
  const bool is_alone = !is_placing();
  const State before = is_alone ? State{} : state_;  // a refused part leaves the other parts
  if (is_alone) begin_placing();
  try {
    change(parts_->placing);
    if (is_alone) end_placing();
  } catch (...) {
    if (is_alone)
      cancel_placing();
    else
      state_ = before;
    throw;
  }
}

void Simulation::require_free(BodyId body, const char* what) const {
  const std::string& name = scene_.name(body);
  if (scene_.motion(body) != Motion::Dynamic)
    throw InvalidArgument("body '" + name + "' is " + to_string(scene_.motion(body)) + ": its " + what +
                          " cannot be placed; must be dynamic");
}

void Simulation::place(BodyId body, const Vec3& position, const Mat3& rotation) {
  const ModelBody& b = rigid(body, "place");
  require_free(body, "pose");
  const std::string owner = "body '" + scene_.name(body) + "'";
  check_finite(owner, "position", position, "m");
  check_rotation(owner, rotation);
  // The place of the mesh, as it is read: that of the centre would round.
  if (position == this->position(body) && rotation == this->rotation(body)) return;
  const Mat3 turned = orthonormalized(rotation);
  place_with([&](Placing& placing) {
    placing.put_rigid(body.index, position + turned * b.centre, orthonormalized(turned * b.axes));
  });
}

void Simulation::push(BodyId body, const Vec3& velocity, const Vec3& angular_velocity) {
  rigid(body, "push");
  require_free(body, "velocity");
  const std::string owner = "body '" + scene_.name(body) + "'";
  check_finite(owner, "velocity", velocity, "m/s");
  check_finite(owner, "angular_velocity", angular_velocity, "rad/s");
  place_with([&](Placing& placing) { placing.push_rigid(body.index, velocity, angular_velocity); });
}

void Simulation::place_together(std::span<const int32_t> bodies, const Mat3& rotation, const Vec3& shift) {
  for (const int32_t body : bodies) require_free(BodyId{body}, "pose");
  check_rotation("bodies placed together", rotation);
  check_finite("bodies placed together", "shift", shift, "m");
  place_with([&](Placing& placing) {
    placing.put_together({bodies.begin(), bodies.end()}, orthonormalized(rotation), shift);
  });
}

void Simulation::place_vertices(BodyId body, std::span<const Vec3> positions) {
  const std::string owner = "body '" + scene_.name(body) + "'";
  if (is_rigid(scene_.kind(body)))
    throw InvalidArgument(owner + " is rigid: its vertices cannot be placed; place its pose");
  check_rows(owner, "positions", positions, "m");
  place_with([&](Placing& placing) { placing.put_points(body.index, positions); });
}

void Simulation::push_vertices(BodyId body, std::span<const Vec3> velocities) {
  const std::string owner = "body '" + scene_.name(body) + "'";
  if (is_rigid(scene_.kind(body)))
    throw InvalidArgument(owner + " is rigid: its vertices take no velocities; push the body");
  check_rows(owner, "velocities", velocities, "m/s");
  place_with([&](Placing& placing) { placing.push_points(body.index, velocities); });
}

namespace {

void check_numbers(const JointDescription& joint, const char* what, size_t expected,
                   std::span<const double> given) {
  const std::string owner = "joint '" + joint.name + "': " + what;
  if (expected == 0) throw InvalidArgument(owner + ": joints of its kind have no coordinates to be set");
  if (given.size() != expected)
    throw InvalidArgument(owner + ": got " + std::to_string(given.size()) + " numbers: must be " +
                          std::to_string(expected));
  for (const double value : given)
    if (!std::isfinite(value)) throw InvalidArgument(owner + " = " + to_text(value) + ": must be finite");
}

}  // namespace

void Simulation::place_joint(JointId joint, std::span<const double> coordinates) {
  check_numbers(scene_.joint(joint), "coordinates", joint_coordinate_names(joint).size(), coordinates);
  place_with([&](Placing& placing) { placing.put_joint(joint.index, coordinates); });
}

void Simulation::push_joint(JointId joint, std::span<const double> rates) {
  check_numbers(scene_.joint(joint), "rates", joint_coordinate_names(joint).size(), rates);
  place_with([&](Placing& placing) { placing.push_joint(joint.index, rates); });
}

}  // namespace stark
