// Energy and momentum of a step (step phase 8). [theory eq. 27]
//
// Dissipation is the work of the forces at the end of the step over the motion of the step, as implicit
// methods have it: W = sum of grad D . (x^{n+1} - x^n) for every dissipation potential D. What internal
// variables dissipate follows from the energy of the step alone [theory eq. 10c].
#include <algorithm>
#include <iterator>
#include <optional>

#include <stark/base/rotation.h>
#include <stark/mechanics/element_virial.h>
#include <stark/mechanics/site_gradient.h>
#include <stark/sim/model/internal_variables.h>
#include <stark/sim/model/stored_energy.h>
#include <stark/sim/step/step_joints.h>
#include <stark/sim/step/step_ledger.h>

namespace stark {

namespace {

double work(std::span<const Vec3> gradient, std::span<const Vec3> way) {
  double total = 0.0;
  for (size_t i = 0; i < gradient.size(); ++i) total += dot(gradient[i], way[i]);
  return total;
}

/// Whether three sites from i on are the axes of a body.
bool are_axes(const KinematicMap& map, int32_t i) {
  for (int32_t k = 0; k < 3; ++k) {
    if (i + k >= map.site_count()) return false;
    const Site& site = map.site(i + k);
    const bool is_axis = site.kind == SiteKind::RigidDirection && site.local == Mat3::identity().column(k);
    if (!is_axis || site.index != map.site(i).index) return false;
  }
  return true;
}

/// Change of the step by which energies are differentiated for its length, by differences of fourth order:
/// what they cut off and what rounding leaves are below 1e-9 of a dissipation and 1e-13 of an energy.
constexpr double kStepChange = 0x1p-7;

/// Part of the work of a force at rest, and of the energy, from which differences are not cut off or rounded.
constexpr double kDriven = 1e-6, kRounding = 1e-11;

/// Derivative in the direction of a step, at its end, of an energy known at parts of the way back, where what
/// is defined at both ends is defined, too: differences of fourth order.
template <typename Energy>
double slope_at_end(Energy&& energy) {
  constexpr double kFactors[] = {25.0, -48.0, 36.0, -16.0, 3.0};
  double sum = 0.0;
  for (int k = 0; k < 5; ++k) sum += kFactors[k] * energy(k * kStepChange);
  return sum / (12.0 * kStepChange);
}

/// The energy of a step of another length that ends at x.
template <typename Batch>
double energy_of_step(Batch& batch, double h, std::span<const Vec3> x) {
  const StepClock clock(law_of(batch));
  batch.set_time(h, clock.time);
  const double energy = total_energy(batch, x);
  batch.set_time(clock.step, clock.time);
  return energy;
}

/// h times the derivative of the energy of a step of length h that ends at x.
template <typename Batch>
double slope_in_step(Batch& batch, double h, std::span<const Vec3> x) {
  const auto difference = [&](double change) {
    return energy_of_step(batch, h * (1.0 + change), x) - energy_of_step(batch, h * (1.0 - change), x);
  };
  return (8.0 * difference(kStepChange) - difference(2.0 * kStepChange)) / (12.0 * kStepChange);
}

/// What elements store.
template <typename Batch>
double stored(Batch& batch, std::span<const Vec3> x, ThreadPool& pool) {
  const AtRest rest(batch, x);
  return total_energy(batch, x, &pool);
}

}  // namespace

bool depends_on_time(const Potential& potential) {
  return std::ranges::any_of(potential.uniform_fields(),
                             [](const UniformField& field) { return field.name == "time"; });
}

StepLedger::StepLedger(const StepContext& context, const StepMotion& motion)
    : StepPart(context), motion_(motion) {
  const KinematicMap& map = model_.map();
  for (int32_t i = 0; i < map.site_count(); ++i) {
    const Site& site = map.site(i);
    const bool is_of_body = site.kind == SiteKind::RigidPoint;
    if (is_of_body && site.local == Vec3{}) centres_.push_back(i);
    if (site.kind == SiteKind::RigidDirection) directions_.push_back(i);
    if (are_axes(map, i)) axes_.push_back(i);
    const bool hangs_on_points = !map.support(i).points.empty();
    const bool is_carried = is_of_body && map.layout().body_block[site.index] == kNoBlock;
    if (!map.is_prescribed(i) && (hangs_on_points || is_carried)) carried_.push_back(i);
  }
  for (int32_t k = 0; k < static_cast<int32_t>(scene_.energies().size()); ++k)
    energies_of_users_.push_back(model_.energy_batch(EnergyId{k}));
  const auto timed = [](const auto& parts) {
    std::vector<int32_t> found;
    for (size_t k = 0; k < parts.size(); ++k)
      if (depends_on_time(potential_of(parts[k].batch))) found.push_back(static_cast<int32_t>(k));
    return found;
  };
  timed_batches_ = timed(energies_.batches);
  timed_quadrature_ = timed(energies_.quadrature);
}

EnergyLedger StepLedger::begin(std::span<const Vec3> x) {
  const EnergyLedger before = stored_energies(x);
  work_of_time_ = work_of_time(x);
  return before;
}

double StepLedger::work_of_time(std::span<const Vec3> x) {
  if (timed_batches_.empty() && timed_quadrature_.empty()) return 0.0;
  const InternalOfState start(energies_, state_.internal_variable);
  double total = 0.0;
  const auto add = [&](auto& part) {
    total += stored(part.batch, x, pool_) - stored_energy(part, x);
    motion_.set_previous(part.batch);
  };
  for (const int32_t k : timed_batches_) add(energies_.batches[k]);
  for (const int32_t k : timed_quadrature_) add(energies_.quadrature[k]);
  return total;
}

// With the previous positions at x, dissipation potentials vanish and only what is stored is left.
double StepLedger::stored_energy(ModelBatch& batch, std::span<const Vec3> x) {
  if (batch.role != ModelBatch::Role::Elastic) return 0.0;
  const AtTime now(batch.batch, state_.time);
  const double energy = stored(batch.batch, x, pool_);
  motion_.set_previous(batch.batch);
  return energy;
}

double StepLedger::stored_energy(ModelQuadrature& elements, std::span<const Vec3> x) {
  const AtTime now(elements.batch, state_.time);
  const double energy = stored(elements.batch, x, pool_);
  motion_.set_previous(elements.batch);
  return energy;
}

template <typename Elements>
std::vector<Mat3> StepLedger::stored_virials_of(Elements& elements, std::span<const Vec3> x) {
  std::vector<Mat3> virials;
  {
    const AtTime now(elements.batch, state_.time);
    const AtRest rest(elements.batch, x, kInstantOfForces);
    virials = element_virials(elements.batch, x);
  }
  motion_.set_previous(elements.batch);
  return virials;
}

std::vector<Mat3> StepLedger::stored_virials(ModelBatch& batch, std::span<const Vec3> x) {
  return stored_virials_of(batch, x);
}

std::vector<Mat3> StepLedger::stored_virials(ModelQuadrature& elements, std::span<const Vec3> x) {
  return stored_virials_of(elements, x);
}

EnergyLedger StepLedger::stored_energies(std::span<const Vec3> x) {
  EnergyLedger ledger;
  const auto& masses = model_.point_masses();
  const auto& blocks = model_.map().layout().point_block;
  for (size_t p = 0; p < masses.size(); ++p) {
    if (blocks[p] == kNoBlock) continue;
    ledger.kinetic += 0.5 * masses[p] * squared_norm(state_.point_velocity[p]);
    ledger.gravity -= masses[p] * dot(settings_.gravity, state_.point_position[p]);
  }
  for (size_t b = 0; b < model_.rigid_masses().size(); ++b) {
    const RigidMass& mass = model_.rigid_masses()[b];
    const DofLayout& layout = model_.map().layout();
    if (layout.rotation_block[b] != kNoBlock)
      ledger.kinetic += 0.5 * dot(state_.body_angular_velocity[b], motion_.spin(b));
    if (layout.body_block[b] == kNoBlock) continue;
    ledger.kinetic += 0.5 * mass.mass * squared_norm(state_.body_velocity[b]);
    ledger.gravity -= mass.mass * dot(settings_.gravity, state_.body_position[b]);
  }
  if (!has_inertia(settings_.time.integrator)) ledger.kinetic = 0.0;
  const InternalOfState after(energies_, state_.internal_variable);
  ledger.elastic = elastic_energy(x);
  return ledger;
}

double StepLedger::elastic_energy(std::span<const Vec3> x) {
  double total = 0.0;
  for (ModelBatch& batch : energies_.batches) total += stored_energy(batch, x);
  for (ModelQuadrature& elements : energies_.quadrature) total += stored_energy(elements, x);
  return total;
}

// What acts on directions of a body is a torque; it works along the turn, not along the chord of a direction,
// along which parts of the force count that turn nothing.
std::vector<Vec3> StepLedger::way_to(std::span<const Vec3> x) const {
  std::vector<Vec3> way(x.size());
  for (size_t i = 0; i < x.size(); ++i) way[i] = x[i] - step_start_[i];
  std::vector<std::optional<Vec3>> turn(model_.map().layout().rotation_block.size());  // of free bodies
  for (const int32_t i : axes_) {
    const auto axes_at = [i](std::span<const Vec3> places) {
      return Mat3::from_columns(places[i], places[i + 1], places[i + 2]);
    };
    turn[model_.map().site(i).index] = log_rotation(axes_at(x) * transpose(axes_at(step_start_)));
  }
  for (const int32_t i : directions_)
    if (const auto& of_body = turn[model_.map().site(i).index]) way[i] = cross(*of_body, x[i]);
  return way;
}

double StepLedger::damping_work() {
  const std::span<const Vec3> x = potential_.site_positions();
  std::vector<Vec3> dissipative;  // empty where nothing dissipates
  const auto add = [&](auto& batch) {
    dissipative.resize(x.size());
    add_site_gradient(batch, x, 1.0, dissipative, &pool_);
    batch.set_previous(x);
    add_site_gradient(batch, x, -1.0, dissipative, &pool_);
    motion_.set_previous(batch);
  };
  for (ModelBatch& batch : energies_.batches)
    if (batch.role == ModelBatch::Role::Elastic && remembers(batch.batch)) add(batch.batch);
  for (ModelQuadrature& elements : energies_.quadrature)
    if (remembers(elements.batch.law())) add(elements.batch);
  double total = dissipative.empty() ? 0.0 : work(dissipative, way_to(x));
  for (const ModelBatch& batch : energies_.batches) {
    if (!batch.is_inertia()) continue;
    const int mass = batch.batch.field_index("mass"), damping = batch.batch.field_index("damping");
    for (int64_t e = 0; e < batch.batch.size(); ++e) {
      const double rate = batch.batch.get(damping, e);
      if (rate == 0.0) continue;
      const int32_t site = batch.batch.stencil(e)[0];
      const Vec3 momentum = (x[site] - motion_.reference().sites[site]) *
                            (batch.batch.get(mass, e) / motion_.reference().stencil.duration);
      total += rate * dot(momentum, x[site] - step_start_[site]);
    }
  }
  return total;
}

template <typename Batch>
double StepLedger::flow_dissipation(Batch& batch) {
  if (potential_of(batch).internal_width() == 0) return 0.0;
  const std::span<const Vec3> x = potential_.site_positions();
  const std::vector<double> start = batch.internal_values(), end = batch.updated_internal(x);
  const double h = StepClock(law_of(batch)).step;
  const auto stored_with = [&](std::span<const Vec3> at, std::span<const double> values) {
    batch.set_internal(values);
    const double found = stored(batch, at, pool_);
    batch.set_internal(start);
    return found;
  };
  const double left = stored_with(x, end);
  batch.set_previous(x);
  double dissipated = total_energy(batch, x) - left;
  if (h > 0.0) {
    dissipated -= slope_in_step(batch, h, x);
    motion_.set_previous(batch);
    const std::vector<double> held = batch.updated_internal(step_start_);
    dissipated = std::max(dissipated, stored_with(step_start_, start) - stored_with(step_start_, held));
  }
  motion_.set_previous(batch);
  return dissipated;
}

// Force at rest, which is that of a stored energy where nothing drives. At rest, since what the potential of
// rates adds to it is dissipated. [theory eq. 27a]
double StepLedger::driven_work() {
  const std::span<const Vec3> x = potential_.site_positions();
  double total = 0.0;
  std::vector<Vec3> gradient, at, way;  // empty where no energy may drive
  for (const int32_t k : energies_of_users_) {
    PotentialBatch& batch = energies_.batches[k].batch;
    if (!remembers(batch) || batch.potential().internal_width() > 0) continue;
    at.resize(x.size());
    if (way.empty()) way = way_to(x);
    gradient.assign(x.size(), Vec3{});
    batch.set_previous(x);
    add_site_gradient(batch, x, 1.0, gradient, &pool_);
    const double force_work = work(gradient, way);
    double largest = 0.0;
    const double slope = slope_at_end([&](double part) {
      for (size_t i = 0; i < x.size(); ++i) at[i] = x[i] - way[i] * part;
      const double energy = stored(batch, at, pool_);
      largest = std::max(largest, std::fabs(energy));
      return energy;
    });
    motion_.set_previous(batch);
    double size = 0.0;
    for (size_t i = 0; i < x.size(); ++i) size += std::fabs(dot(gradient[i], way[i]));
    const double driven = slope - force_work;
    if (std::fabs(driven) > kDriven * size + kRounding * largest) total += driven;
  }
  return total;
}

double StepLedger::flow_dissipation() {
  double total = 0.0;
  for (ModelBatch& batch : energies_.batches) total += flow_dissipation(batch.batch);
  for (ModelQuadrature& elements : energies_.quadrature) total += flow_dissipation(elements.batch);
  return total;
}

std::vector<Vec3> StepLedger::site_gradient() const {
  const std::span<const Vec3> x = potential_.site_positions();
  std::vector<Vec3> gradient(x.size());
  for (const PotentialBatch* batch : energies_.all_batches())
    add_site_gradient(*batch, x, 1.0, gradient, &pool_);
  for (const ModelQuadrature& elements : energies_.quadrature)
    add_site_gradient(elements.batch, x, 1.0, gradient, &pool_);
  if (contact_)
    for (const PotentialBatch* batch : contact_->batches(Curvature::Exact))
      add_site_gradient(*batch, x, 1.0 / contact_->weight(), gradient, &pool_);
  return gradient;
}

double StepLedger::prescribed_work() {
  const KinematicMap& map = model_.map();
  const std::span<const Vec3> x = potential_.site_positions();
  // How much of the motion of sites was prescribed.
  std::vector<Vec3> body_motion(map.layout().body_block.size());
  for (const int32_t i : centres_) body_motion[map.site(i).index] = x[i] - step_start_[i];
  // In the order of sites: those that nothing moves add nothing.
  std::vector<int32_t> driven;
  std::ranges::merge(potential_.driven_sites(), carried_, std::back_inserter(driven));
  std::vector<Vec3> motion(driven.size());
  bool any = false;
  for (size_t d = 0; d < driven.size(); ++d) {
    const int32_t i = driven[d];
    const Site& site = map.site(i);
    if (map.is_prescribed(i)) {
      motion[d] = x[i] - step_start_[i];
    } else if (const SiteSupport s = map.support(i); !s.points.empty()) {
      for (size_t k = 0; k < s.points.size(); ++k)
        if (map.layout().point_block[s.points[k]] == kNoBlock)
          motion[d] += (x[s.points[k]] - step_start_[s.points[k]]) * s.weights[k];
    } else {
      motion[d] = body_motion[site.index];  // a lever on a pinned node of a rod: its rotation is free
    }
    any = any || motion[d] != Vec3{};
  }
  if (!any) return 0.0;
  const std::vector<Vec3> gradient = site_gradient();
  double total = 0.0;
  for (size_t d = 0; d < driven.size(); ++d) total += dot(gradient[driven[d]], motion[d]);
  return total;
}

double StepLedger::friction_work(std::span<const Vec3> x) {
  friction_.begin(x.size());
  for (const PotentialBatch* batch : contact_->friction_batches()) {
    friction_.use(batch->stencils());
    add_site_gradient(*batch, x, 1.0 / contact_->weight(), friction_.values());
  }
  double total = 0.0;
  friction_.for_each([&](int32_t i, const Vec3& force) { total += dot(force, x[i] - step_start_[i]); });
  return total;
}

EnergyLedger StepLedger::balance(const EnergyLedger& before, std::span<const double> coordinates_before) {
  const std::span<const Vec3> x = potential_.site_positions();
  EnergyLedger ledger = stored_energies(x);
  if (contact_) {
    ledger.contact = contact_->energy();
    // Slip is that of the material: what a belt does on bodies is its work less what friction takes of it.
    ledger.belts = contact_->surface_work(x);
    ledger.friction = friction_work(x) + ledger.belts;
    ledger.restitution = contact_->restitution_work(x);
  }
  ledger.damping = damping_work() + flow_dissipation();
  if (!motion_.reference().half_way.empty())
    ledger.damping += before.elastic + work_of_time_ - elastic_energy(step_start_);  // in the first half
  ledger.external = prescribed_work() + driven_work() + work_of_time_;
  for (size_t k = 0; k < model_.actuators().size(); ++k)
    if (state_.actuator_enabled[k] != 0.0)
      ledger.actuation += actuator_work(model_.actuators()[k], state_, coordinates_before);
  ledger.numerical = before.stored() + ledger.external + ledger.actuation + ledger.belts +
                     ledger.restitution - ledger.stored() - ledger.damping - ledger.friction;
  return ledger;
}

Momentum StepLedger::momentum() const {
  Momentum total;
  const auto& masses = model_.point_masses();
  const auto& blocks = model_.map().layout().point_block;
  for (size_t p = 0; p < masses.size(); ++p) {
    if (blocks[p] == kNoBlock) continue;
    const Vec3 momentum = state_.point_velocity[p] * masses[p];
    total.linear += momentum;
    total.angular += cross(state_.point_position[p], momentum);
  }
  for (size_t b = 0; b < model_.rigid_masses().size(); ++b) {
    const RigidMass& mass = model_.rigid_masses()[b];
    const DofLayout& layout = model_.map().layout();
    if (layout.rotation_block[b] != kNoBlock) total.angular += motion_.spin(b);
    if (layout.body_block[b] == kNoBlock) continue;
    const Vec3 momentum = state_.body_velocity[b] * mass.mass;
    total.linear += momentum;
    total.angular += cross(state_.body_position[b], momentum);
  }
  return total;
}

}  // namespace stark
