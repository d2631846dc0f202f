#include <stark/sim/simulation_parts.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <sstream>

#include <stark/base/error.h>
#include <stark/base/rotation.h>
#include <stark/contact/contact_set.h>
#include <stark/geometry/intersection.h>
#include <stark/sim/model/script_phase.h>
#include <stark/sim/scene/contact_distance.h>
#include <stark/sim/scene/validation.h>
#include <stark/sim/step/not_finite.h>

namespace stark {

namespace {

int threads_of(const ExecutionSettings& execution) {
  const bool is_free = execution.oversubscribe && execution.threads > 0;
  return is_free ? execution.threads : usable_threads(execution.threads);
}

/// Motion in a quasistatic step, over the diagonal of all bodies, beyond which there is no equilibrium.
constexpr double kFarthestMotion = 100.0;

// For each block of the system, 1 where it is a node of a solid.
std::vector<uint8_t> blocks_in_solids(const Model& model) {
  const KinematicMap& map = model.map();
  std::vector<uint8_t> in_solid(map.layout().block_count, 0);
  for (const ModelBody& body : model.bodies()) {
    if (!has_points(body.kind) || !row_of(body.kind).can_be_filled) continue;
    for (int32_t k = 0; k < body.site_count; ++k)
      if (const int32_t block = map.layout().point_block[body.first_site + k]; block != kNoBlock)
        in_solid[block] = 1;
  }
  return in_solid;
}

}  // namespace

std::string StepReport::brief() const {
  std::ostringstream out;
  out.precision(4);
  out << "step " << step << "  t " << time << " s  h " << 1e3 * time_step << " ms  " << solve.iterations
      << " iterations  " << contact_count << " contacts  residual " << solve.residual << " N";
  if (rejected_steps > 0) out << "  " << rejected_steps << " rejected";
  if (failed()) out << "  FAILED: " << message;
  return out.str();
}

Simulation::Simulation(const Scene& scene, const Settings& settings, const std::function<void()>& between)
    : scene_(scene), settings_(settings) {
  validate(settings_);
  if (scene_.body_count() == 0)
    throw InvalidArgument(
        "scene has no bodies; add at least one with add_cloth, add_solid, add_rod or add_rigid");
  pool_ = std::make_unique<ThreadPool>(threads_of(settings_.execution));
  timer_ = std::make_unique<PhaseTimer>();
  model_ = std::make_unique<Model>(scene_, settings_, energies_);
  state_ = model_->initial_state();
  site_readings_ = std::make_unique<SiteReadings>();
  between();
  ContactSurfaces surfaces = model_->make_surfaces(scene_, settings_);
  for (int32_t b = 0; b < scene_.body_count(); ++b) is_filled_.push_back(scene_.is_filled(BodyId{b}));
  Exclusions exclusions(find_exclusions(scene_, settings_.contact.self_contact), surfaces.filter,
                        model_->bodies());
  surfaces.filter = exclusions.filter({});
  surface_mesh_ = surfaces.mesh;
  between();
  PrescribedBodies prescribed;
  if (settings_.contact.enabled) {
    contact_ = std::make_unique<ContactPipeline>(
        std::move(surfaces), model_->contact_potentials(), settings_.contact,
        settings_.contact.stick_velocity * settings_.time.step, model_->map(), *pool_, *timer_);
    contact_readings_ = std::make_unique<ContactReadings>();
    between();
    prescribed = PrescribedBodies(scene_, surface_mesh_);
    intersections_ = std::make_unique<IntersectionFinder>(surface_mesh_, scene_.body_count(), is_filled_);
    between();
    check_initial_state();
    between();
    const CloseBodies close = contact_->find_close_bodies(site_positions());
    state_.contact_close_bodies = close.bodies;
    state_.contact_close_distance = close.distance;
  }
  start_state_ = state_;
  between();
  make_solver();
  parts_ = std::make_unique<Parts>(StepContext{.scene = scene_,
                                               .settings = settings_,
                                               .model = *model_,
                                               .energies = energies_,
                                               .state = state_,
                                               .contact = contact_.get(),
                                               .potential = *potential_,
                                               .step_start = step_start_,
                                               .pool = *pool_,
                                               .timer = *timer_},
                                   std::move(exclusions), surface_mesh_, is_filled_, std::move(prescribed),
                                   *assembler_, *linear_solver_);
  between();
  check_energies();
  require_finite_updates(scene_, *model_, energies_, site_positions(), settings_.time.step);
  check_joints();
  check_actuators();
  check_attachments();
}

void Simulation::make_solver() {
  assembler_ = std::make_unique<Assembler>(model_->map(), *pool_);
  std::vector<const QuadratureBatch*> quadrature;
  for (const ModelQuadrature& elements : energies_.quadrature) quadrature.push_back(&elements.batch);
  assembler_->set_static_batches(energies_.all_batches(), quadrature);
  potential_ = std::make_unique<IncrementalPotential>(
      model_->map(), *assembler_, contact_.get(), &energies_.constraints, model_->block_scales(), *timer_);
  if (energies_.constraints.joint_count() > 0) {
    self_stress_ = std::make_unique<SelfStress>(
        model_->map(), energies_.constraints, *pool_,
        [this](int32_t constraint) { return may_break(constraint); },
        [this](int32_t constraint) { return may_be_driven(constraint); });
    potential_->set_self_stress(self_stress_.get());
  }
  potential_->set_active_set_updates(settings_.contact.friction_updates);
  if (!has_inertia(settings_.time.integrator)) potential_->set_motion_limit(kFarthestMotion * scene_size());
  linear_solver_ = make_linear_solver(settings_.linear, *pool_);
  linear_solver_->prepare(assembler_->static_pattern(), blocks_in_solids(*model_));
}

bool Simulation::may_break(int32_t constraint) const {
  if (constraint < static_cast<int32_t>(scene_.joints().size()))
    return scene_.joints()[constraint].can_break();
  for (size_t k = 0; k < scene_.attachments().size(); ++k) {
    const AttachmentDescription& attachment = scene_.attachments()[k];
    const int32_t pair = constraint - model_->attachments()[k].first_constraint;
    if (pair >= 0 && pair < attachment.size()) return std::isfinite(attachment.break_force);
  }
  return false;
}

bool Simulation::may_be_driven(int32_t constraint) const {
  using Carrier = FrameDescription::Carrier;
  if (constraint >= static_cast<int32_t>(scene_.joints().size())) return true;
  const auto is_driven = [&](const FrameDescription& frame) {
    if (frame.carrier == Carrier::Body) return scene_.motion(frame.body) == Motion::Scripted;
    return frame.carrier != Carrier::World;
  };
  const JointDescription& joint = scene_.joints()[constraint];
  return is_driven(joint.a) || is_driven(joint.b);
}

Simulation::~Simulation() = default;

const StepReport& Simulation::step(double max_time_step) {
  parts_->placing.require_closed("a step");
  return parts_->runner.step(max_time_step);
}
const StepReport& Simulation::report() const { return parts_->runner.report(); }
StepProgress Simulation::progress() const { return parts_->runner.progress(); }
int64_t Simulation::exclusion_count() const { return parts_->watch.exclusions().size(); }

std::vector<std::tuple<int32_t, int32_t, double>> Simulation::close_bodies() const {
  std::vector<std::tuple<int32_t, int32_t, double>> pairs;
  for (size_t k = 0; k < state_.contact_close_bodies.size(); ++k) {
    const auto [a, b] = groups_of_code(state_.contact_close_bodies[k]);
    pairs.emplace_back(a, b, state_.contact_close_distance[k]);
  }
  return pairs;
}

namespace {

/// What else intersects; empty where there is one pair of bodies.
std::string other_pairs_text(std::span<const EdgeTriangleIntersection> intersections,
                             const SurfaceMesh& mesh) {
  std::set<std::pair<int32_t, int32_t>> pairs;
  for (const EdgeTriangleIntersection& i : intersections) {
    const auto [a, b] = std::minmax(mesh.edge_group[i.edge], mesh.triangle_group[i.triangle]);
    if (a != b) pairs.emplace(a, b);
  }
  if (pairs.size() < 2) return "";
  const size_t more = pairs.size() - 1;
  return "; " + std::to_string(more) +
         (more == 1 ? " more pair of bodies intersects" : " more pairs of bodies intersect") +
         ": scene.disable_overlapping() disables contact of all such pairs";
}

}  // namespace

void Simulation::check_clear(std::span<const Vec3> x, const std::string& when) const {
  const auto name = [&](int32_t group) { return "'" + scene_.name(BodyId{group}) + "'"; };
  // Different vertices at one place, as in files that write a vertex once for each triangle.
  const auto has_doubled_vertex = [&](const auto& pair) {
    for (const int32_t u : surface_mesh_.edges[pair.edge])
      for (const int32_t v : surface_mesh_.triangles[pair.triangle])
        if (u != v && norm(x[u] - x[v]) == 0.0) return true;
    return false;
  };
  const auto intersections = intersections_->intersections(x, contact_->filter(), *pool_);
  if (!intersections.empty()) {
    const auto& first = intersections.front();
    const Index2& edge = surface_mesh_.edges[first.edge];
    const Index3& t = surface_mesh_.triangles[first.triangle];
    const Vec3 where = meeting_point(x[edge[0]], x[edge[1]], x[t[0]], x[t[1]], x[t[2]]);
    const int32_t a = surface_mesh_.edge_group[first.edge];
    const int32_t b = surface_mesh_.triangle_group[first.triangle];
    // Contact of bodies can be disabled only before there is a simulation.
    const std::string others = parts_ ? "" : other_pairs_text(intersections, surface_mesh_);
    throw InitialIntersection(name(a) + (a == b ? " intersects itself " : " and " + name(b) + " intersect ") +
                              when + " at " + std::to_string(intersections.size()) +
                              " edge-triangle pairs, the first near " + point_text(where) +
                              (a != b ? "; move them apart, or disable contact between them" + others
                               : std::ranges::any_of(intersections, has_doubled_vertex)
                                   ? "; some of its vertices lie at the same places, so that its triangles "
                                     "are not joined there: unite them with stark.mesh.merged(mesh), or add "
                                     "it with self_contact = false"
                                   : "; pull its layers apart there, or add it with self_contact = false"));
  }
  const auto contained = intersections_->contained_groups(x, contact_->filter(), *pool_);
  if (!contained.empty()) {
    const auto& first = contained.front();
    const bool is_rigid = stark::is_rigid(scene_.kind(BodyId{first.outer}));
    throw InitialIntersection(
        name(first.inner) + " is inside " + name(first.outer) + " " + when + ", near " +
        point_text(x[first.vertex]) + ": a " + (is_rigid ? "rigid body" : "solid") +
        " fills its closed surface; move it out, " +
        (is_rigid ? "add the outer one with hollow = true if it is a shell, or with an inner wall"
                  : "mesh the outer one with a cavity") +
        ", or disable contact between them");
  }
}

void Simulation::check_initial_state() const {
  for (int32_t body = 0; body < scene_.body_count(); ++body)
    check_resolved(scene_, BodyId{body}, settings_, positions(BodyId{body}));
  const std::vector<Vec3> x = site_positions();
  check_clear(x, "at time 0");
  const auto name = [&](int32_t group) { return "'" + scene_.name(BodyId{group}) + "'"; };
  // Rods, and gaps that rounding of the coordinates swallows: barriers would be infinite, or noise.
  const std::vector<Contact> contacts = contact_->find_contacts_at(x);
  const auto nearest = std::ranges::min_element(
      contacts, {}, [](const Contact& c) { return c.distance / c.contact_distance; });
  if (nearest == contacts.end() || !is_touching(*nearest, x)) return;
  const int32_t a = nearest->group_a, b = nearest->group_b;
  const bool is_rod = scene_.kind(BodyId{a}) == BodyKind::Rod;
  throw InitialIntersection(
      name(a) + (a == b ? " touches itself" : " and " + name(b) + " touch") + " at time 0 near " +
      point_text(place_on_a(*nearest, x)) + (a == b ? ", the distance is " : ", their distance is ") +
      rough_text(nearest->distance, "m") + "; " +
      (a != b ? "move them apart, or disable contact between them"
       : is_rod
           ? "pull its parts apart there, of a ring leave out the last segment and weld the ends, or add "
             "it with self_contact = false"
           : "pull its layers apart there, or add it with self_contact = false"));
}

const ModelBody& Simulation::rigid(BodyId body, const char* what) const {
  const std::string& name = scene_.name(body);  // throws for ids of another scene
  const ModelBody& b = model_->bodies()[body.index];
  if (!is_rigid(b.kind))
    throw InvalidArgument("body '" + name + "' is a " + to_string(b.kind) + "; " + what +
                          " is for rigid bodies");
  return b;
}

std::vector<Vec3> Simulation::positions(BodyId body) const {
  scene_.name(body);
  const ModelBody& b = model_->bodies()[body.index];
  std::vector<Vec3> x(b.site_count);
  if (has_nodes(b.kind)) {
    std::copy_n(state_.body_position.begin() + b.rigid_index, b.site_count, x.begin());
  } else if (is_rigid(b.kind)) {
    for (int32_t v = 0; v < b.site_count; ++v)
      x[v] = state_.body_position[b.rigid_index] +
             state_.body_rotation[b.rigid_index] * model_->map().site(b.first_site + v).local;
  } else {
    std::copy_n(state_.point_position.begin() + b.first_site, b.site_count, x.begin());
  }
  return x;
}

std::vector<Vec3> Simulation::velocities(BodyId body) const {
  scene_.name(body);
  const ModelBody& b = model_->bodies()[body.index];
  std::vector<Vec3> v(b.site_count);
  if (has_nodes(b.kind)) {
    std::copy_n(state_.body_velocity.begin() + b.rigid_index, b.site_count, v.begin());
    return v;
  }
  for (int32_t i = 0; i < b.site_count; ++i)
    v[i] = is_rigid(b.kind) ? state_.body_velocity[b.rigid_index] +
                                  parts_->motion.turning_velocity(b.rigid_index,
                                                                  model_->map().site(b.first_site + i).local)
                            : state_.point_velocity[b.first_site + i];
  return v;
}

const std::vector<Index3>& Simulation::triangles(BodyId body) const {
  scene_.name(body);
  return model_->bodies()[body.index].triangles;
}

std::pair<std::vector<Vec3>, std::vector<Mat3>> Simulation::poses(const std::vector<BodyId>& bodies) const {
  std::pair<std::vector<Vec3>, std::vector<Mat3>> found;
  for (const BodyId body : bodies) {
    found.first.push_back(position(body));
    found.second.push_back(rotation(body));
  }
  return found;
}

Vec3 Simulation::position(BodyId body) const {
  rigid(body, "position");
  Vec3 t;
  Mat3 R;
  model_->mesh_pose(body.index, state_, t, R);
  return t;
}

Mat3 Simulation::rotation(BodyId body) const {
  rigid(body, "rotation");
  Vec3 t;
  Mat3 R;
  model_->mesh_pose(body.index, state_, t, R);
  return R;
}

Vec3 Simulation::linear_velocity(BodyId body) const {
  const ModelBody& b = rigid(body, "velocity");
  const Vec3 lever = rotation(body) * -b.centre;  // from the centre of mass to the origin of the mesh
  return state_.body_velocity[b.rigid_index] + cross(angular_velocity(body), lever);
}

Vec3 Simulation::angular_velocity(BodyId body) const {
  return state_.body_angular_velocity[rigid(body, "angular velocity").rigid_index];
}

Vec3 Simulation::centre_velocity(BodyId body) const {
  return state_.body_velocity[rigid(body, "velocity").rigid_index];
}

double Simulation::checked_duration(const std::string& owner, std::optional<double> duration) const {
  if (duration && !(*duration > 0.0 && std::isfinite(*duration)))
    throw InvalidArgument(owner + ": duration = " + quantity_text(*duration, "s") +
                          ": must be > 0 and finite; leave it out for a full time step");
  return duration.value_or(settings_.time.step);
}

void Simulation::set_pose(BodyId body, const Vec3& position, const Mat3& rotation,
                          std::optional<double> duration) {
  const ModelBody& b = rigid(body, "set_pose");
  if (scene_.motion(body) != Motion::Scripted)
    throw InvalidArgument("body '" + scene_.name(body) + "' is " + to_string(scene_.motion(body)) +
                          "; only scripted bodies follow poses, add it with motion = scripted");
  const double defect = max_abs((transpose(rotation) * rotation - Mat3::identity()) * Vec3{1, 1, 1});
  if (!is_finite(position) || !(defect < 1e-6) || !(determinant(rotation) > 0.0))
    throw InvalidArgument("pose of body '" + scene_.name(body) + "': position " + point_text(position) +
                          " must be finite and rotation orthogonal with determinant +1 (defect " +
                          to_text(defect) + ")");
  const double remaining = checked_duration("pose of body '" + scene_.name(body) + "'", duration);
  state_.script_position[b.rigid_index] = position;
  state_.script_rotation[b.rigid_index] = orthonormalized(rotation);
  state_.script_remaining[b.rigid_index] = remaining;
}

std::pair<Vec3, Mat3> Simulation::target_pose(BodyId body) const {
  const int32_t k = rigid(body, "target_pose").rigid_index;
  if (script_phase(state_.script_remaining[k]) != ScriptPhase::Velocity)
    return {state_.script_position[k], state_.script_rotation[k]};
  std::pair<Vec3, Mat3> pose;
  model_->mesh_pose(body.index, state_, pose.first, pose.second);
  return pose;
}

void Simulation::set_velocity(BodyId body, const Vec3& velocity, const Vec3& angular_velocity) {
  const ModelBody& b = rigid(body, "set_velocity");
  if (scene_.motion(body) != Motion::Scripted)
    throw InvalidArgument("body '" + scene_.name(body) + "' is " + to_string(scene_.motion(body)) +
                          "; only scripted bodies follow velocities, add it with motion = scripted");
  const std::string owner = "body '" + scene_.name(body) + "'";
  check_finite(owner, "velocity", velocity, "m/s");
  check_finite(owner, "angular_velocity", angular_velocity, "rad/s");
  state_.script_remaining[b.rigid_index] = kMovesAtVelocity;
  state_.body_velocity[b.rigid_index] = velocity;
  state_.body_angular_velocity[b.rigid_index] = angular_velocity;
}

PlannedStep Simulation::next_step(double max_time_step) const {
  return plan_step(state_, max_time_step, std::numeric_limits<double>::infinity());
}

void Simulation::set_interrupt(std::function<bool()> interrupted) {
  parts_->runner.newton().set_interrupt(std::move(interrupted));
}

int Simulation::thread_count() const { return pool_->thread_count(); }

double Simulation::scene_size() const {
  const std::vector<Vec3> x = site_positions();
  Vec3 low{1e300, 1e300, 1e300}, high = -low;
  for (const ModelBody& body : model_->bodies())
    for (int32_t i = body.first_site; i < body.first_site + body.site_count; ++i)
      for (int k = 0; k < 3; ++k) low[k] = std::fmin(low[k], x[i][k]), high[k] = std::fmax(high[k], x[i][k]);
  return norm(high - low);
}

const SurfaceMesh& Simulation::surface_mesh() const { return surface_mesh_; }

const std::vector<Vec3>& Simulation::site_positions() const { return site_readings_->get(state_, *model_); }

}  // namespace stark
