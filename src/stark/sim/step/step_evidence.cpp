#include <stark/sim/step/step_evidence.h>

#include <stark/mechanics/congruence.h>
#include <stark/mechanics/force_rounding.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <stark/sim/model/held_between.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/unit_checks.h>
#include <stark/sim/step/element_strain.h>
#include <stark/sim/step/not_finite.h>
#include <stark/sim/step/rough_energies.h>

namespace stark {

namespace {

constexpr size_t kListed = 5;  ///< entries that lists are cut to
/// An energy E with forces g and stiffness H is like a power or a logarithm of a length where |E| |H| is
/// above this part of |g|^2; and near its end where that length is below this part of the scene.
constexpr double kPowerLaw = 0.9, kNoLength = 1e-6;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

std::string owner_of(const Scene& scene, int32_t body) {
  return owner_text(scene.kind(BodyId{body}), scene.name(BodyId{body}));
}

/// The body that a site is a vertex of, -1 for points that energies and joints made.
int32_t body_of_site(const Model& model, int32_t site) {
  for (int32_t b = 0; b < static_cast<int32_t>(model.bodies().size()); ++b) {
    const ModelBody& body = model.bodies()[b];
    if (site >= body.first_site && site < body.first_site + body.site_count) return b;
  }
  return -1;
}

/// Vertices of one body.
BodyVertices place_of(const Scene& scene, const Model& model, std::span<const int32_t> sites) {
  const int32_t body = body_of_site(model, sites[0]);
  if (body < 0) return {"a point of an energy"};
  BodyVertices place{owner_of(scene, body)};
  for (const int32_t site : sites) place.vertices.push_back(site - model.bodies()[body].first_site);
  return place;
}

void add_forces(const FailedStep& step, std::span<const double> gradient, StepEvidence& out) {
  const std::vector<BodyVertices> owners = block_owners(step.scene, step.model);
  const std::vector<BlockScale>& scales = step.model.block_scales();
  const std::span<const Vec3> x = step.potential.block_positions();
  std::vector<UnbalancedForce> all;
  for (size_t b = 0; b < owners.size(); ++b) {
    const double force = norm({gradient[3 * b], gradient[3 * b + 1], gradient[3 * b + 2]});
    all.push_back({owners[b], x[b], force * scales[b].inverse_length, force * scales[b].inverse_inertia});
  }
  const auto larger = [](const UnbalancedForce& a, const UnbalancedForce& b) {
    return std::isnan(a.force) ? !std::isnan(b.force) : a.force > b.force;
  };
  const size_t count = std::min(kListed, all.size());
  std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end(), larger);
  all.resize(count);
  out.forces = std::move(all);
}

std::vector<NarrowGap> find_gaps(const FailedStep& step, std::span<const Vec3> x) {
  if (!step.contact) return {};
  return find_narrow_gaps(step.scene, step.model, step.contact->find_contacts_at(x), kListed);
}

/// Of all contacts where the step started and where its last attempt ended.
void add_between(const FailedStep& step, StepEvidence& out) {
  if (!step.contact) return;
  std::vector<Contact> all = step.contact->find_contacts_at(step.start);
  std::ranges::copy(step.contact->find_contacts_at(step.potential.site_positions()), std::back_inserter(all));
  out.is_between = is_something_between(step.scene, step.model, all);
}

/// The two parts that the last motion which was looked at has been limited by.
std::optional<BlockingPair> limiting_parts(const FailedStep& step) {
  const CcdReport& limit = step.contact->limiting_pair();
  const SurfaceMesh& mesh = step.contact->mesh();
  if (!limit.kind) return {};
  const auto place = [&](PrimitiveKind kind, int32_t id) {
    return place_of(step.scene, step.model, vertices_of(mesh, kind, id));
  };
  return BlockingPair{place(first_kind(*limit.kind), limit.first),
                      place(second_kind(*limit.kind), limit.second), limit.step};
}

std::optional<BlockingPair> find_blocking_pair(const FailedStep& step, double max_rotation) {
  if (!step.contact || step.direction.empty() ||
      !std::ranges::all_of(step.direction, [](double v) { return std::isfinite(v); }))
    return {};
  const std::vector<Vec3> end = step.potential.positions_along(step.direction, max_rotation);
  if (!std::ranges::all_of(end, [](const Vec3& p) { return is_finite(p); })) return {};
  if (step.contact->max_step(step.potential.site_positions(), end) >= 1.0) return {};
  return limiting_parts(step);
}

void add_strains(const FailedStep& step, StepEvidence& out) {
  // Prescribed parts count where they were to go, not where they got stuck.
  std::vector<Vec3> target(step.start.size());
  step.model.map().positions(step.target, target);
  const std::span<const Vec3> x = step.potential.site_positions();
  for (int32_t b = 0; b < step.scene.body_count(); ++b) {
    const ModelBody& body = step.model.bodies()[b];
    if (is_rigid(body.kind)) continue;
    std::vector<Vec3> places(x.begin() + body.first_site, x.begin() + body.first_site + body.site_count);
    for (const int32_t v : body.pins) places[v] = target[body.first_site + v];
    for (StrainedElement& element : find_strained_elements(step.scene, BodyId{b}, places, kListed))
      out.elements.push_back(std::move(element));
    std::optional<PinPair> pins = find_stretched_pins(step.scene, BodyId{b}, places);
    if (pins && (!out.pins || pins->stretch() > out.pins->stretch())) out.pins = std::move(pins);
  }
  std::ranges::stable_sort(out.elements, std::greater<>{}, severity);
  out.elements.resize(std::min(kListed, out.elements.size()));
}

/// Bodies whose prescribed parts move in this step.
void add_prescribed(const FailedStep& step, StepEvidence& out) {
  std::vector<Vec3> target(step.start.size());
  step.model.map().positions(step.target, target);
  for (int32_t b = 0; b < step.scene.body_count(); ++b) {
    const ModelBody& body = step.model.bodies()[b];
    for (int32_t i = body.first_site; i < body.first_site + body.site_count; ++i)
      if (step.model.map().is_prescribed(i) && !(target[i] == step.start[i])) {
        out.pushing.push_back(owner_of(step.scene, b));
        break;
      }
  }
  out.prescribed_arrived = !step.potential.has_pending_motion();
}

/// Steepness of one element of an energy: its largest force on a point, and force over stiffness.
struct Steepness {
  double force = 0.0, length = 0.0, growth = 0.0;
  int point = 0;
};

Steepness steepness(std::span<const double> outputs, int points) {
  const int n = 3 * points;
  Steepness result;
  for (int p = 0; p < points; ++p) {
    const double force = norm({outputs[1 + 3 * p], outputs[2 + 3 * p], outputs[3 + 3 * p]});
    if (force > result.force) result.force = force, result.point = p;
  }
  double stiffness = 0.0;
  for (int i = 0, k = 1 + n; i < n; ++i)
    for (int j = i; j < n; ++j, ++k) stiffness = std::fmax(stiffness, std::fabs(outputs[k]));
  result.length = result.force / stiffness;
  result.growth = std::fabs(outputs[0]) * stiffness / (result.force * result.force);
  return result;
}

/// A power or a logarithm of a distance r near zero: forces over stiffness are about r, and |E| |H|/|g|^2 is
/// above 1, where it is 1/2 for a spring.
void add_steep_energy(const FailedStep& step, StepEvidence& out) {
  const std::span<const Vec3> x = step.potential.site_positions();
  for (int32_t k = 0; k < static_cast<int32_t>(step.scene.energies().size()); ++k) {
    const ModelBatch& batch = step.energies.batches[step.model.energy_batch(EnergyId{k})];
    const int points = batch.batch.point_count();
    if (batch.batch.size() == 0 || batch.batch.potential().totals()) continue;
    const std::vector<double> values = batch.batch.evaluate(symbolic::Order::Hessian, x);
    const size_t outputs = values.size() / static_cast<size_t>(batch.batch.size());
    for (int64_t e = 0; e < batch.batch.size(); ++e) {
      const std::span<const double> element =
          std::span(values).subspan(static_cast<size_t>(e) * outputs, outputs);
      const Steepness now = steepness(element, points);
      const bool is_singular = now.growth > kPowerLaw && now.length < kNoLength * out.scene_size;
      if (!is_singular || (out.steep && out.steep->force >= now.force)) continue;
      const std::span<const int32_t> sites = batch.batch.stencil(e);
      out.steep =
          SteepEnergy{place_of(step.scene, step.model, sites.subspan(static_cast<size_t>(now.point), 1)),
                      batch.owner, now.force, now.length};
    }
  }
}

void add_rounding(const FailedStep& step, const BlockMatrix& hessian, StepEvidence& out) {
  const DofLayout& layout = step.model.map().layout();
  const std::span<const Vec3> x = step.potential.block_positions();
  const std::vector<double> noise = force_rounding(hessian, x, layout);
  const std::vector<BlockScale>& scales = step.model.block_scales();
  for (size_t b = 0; b < noise.size(); ++b) {
    out.force_rounding = std::max(out.force_rounding, noise[b] * scales[b].inverse_length);
    out.acceleration_rounding = std::max(out.acceleration_rounding, noise[b] * scales[b].inverse_inertia);
    out.speed_rounding = std::max(out.speed_rounding, kEpsilon * norm(x[b]));
  }
}

/// 1 for blocks that are rotations.
std::vector<char> turning_blocks(const Model& model) {
  const DofLayout& layout = model.map().layout();
  std::vector<char> turns(layout.block_count, 0);
  for (const int32_t block : layout.rotation_block)
    if (block != kNoBlock) turns[block] = 1;
  return turns;
}

void add_stiffness_ratio(const FailedStep& step, const BlockMatrix& hessian, StepEvidence& out) {
  const std::vector<BodyVertices> owners = block_owners(step.scene, step.model);
  const std::vector<char> turns = turning_blocks(step.model);
  double smallest = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (size_t b = 0; b < owners.size(); ++b) {
    if (turns[b]) continue;
    const double* d = hessian.values.data() + 9 * hessian.pattern.row_start[b];
    const double stiffness = (std::fabs(d[0]) + std::fabs(d[4]) + std::fabs(d[8])) / 3.0;
    if (stiffness < smallest) smallest = stiffness, out.softest = owners[b].body;
    if (stiffness > largest) largest = stiffness, out.stiffest = owners[b].body;
  }
  if (largest > 0.0 && smallest > 0.0) out.stiffness_ratio = largest / smallest;
}

/// Of what each actuator does where the attempt ended, the largest acceleration.
void add_actuator(const FailedStep& step, StepEvidence& out) {
  const KinematicMap& map = step.model.map();
  const std::span<const Vec3> x = step.potential.site_positions();
  const std::vector<BlockScale>& scales = step.model.block_scales();
  const std::vector<BodyVertices> owners = block_owners(step.scene, step.model);
  const std::vector<char> turns = turning_blocks(step.model);
  const size_t joints = step.scene.joints().size(), actuators = step.scene.actuators().size();
  std::vector<double> gradient(3 * owners.size());
  for (const ConstraintGroup& group : step.energies.constraints.groups()) {
    const size_t first = group.joints.front();
    if (first < joints || first >= joints + actuators) continue;
    const std::vector<double> values = group.batch.evaluate(symbolic::Order::Gradient, x);
    const size_t outputs = values.size() / static_cast<size_t>(group.batch.size());
    for (int64_t e = 0; e < group.batch.size(); ++e) {
      std::ranges::fill(gradient, 0.0);
      const double* g = values.data() + static_cast<size_t>(e) * outputs + 1;
      for (const int32_t site : group.batch.stencil(e)) {
        add_mapped_gradient(map.jacobian(site, step.potential.configuration()), {g[0], g[1], g[2]}, gradient);
        g += 3;
      }
      for (size_t b = 0; b < owners.size(); ++b) {
        const double a =
            norm({gradient[3 * b], gradient[3 * b + 1], gradient[3 * b + 2]}) * scales[b].inverse_inertia;
        if (!std::isfinite(a) || a <= (out.actuator ? out.actuator->acceleration : 0.0)) continue;
        const bool is_turn = turns[b] != 0;
        out.actuator =
            StrongActuator{step.scene.actuators()[static_cast<size_t>(group.joints[e]) - joints].name,
                           owners[b], a, is_turn, is_turn ? scales[b].reach : out.scene_size};
      }
    }
  }
}

void add_motion(const FailedStep& step, StepEvidence& out) {
  const std::span<const Vec3> x = step.potential.site_positions();
  Vec3 low{1e300, 1e300, 1e300}, high = -low;
  int32_t fastest = -1;
  for (const ModelBody& body : step.model.bodies())
    for (int32_t i = body.first_site; i < body.first_site + body.site_count; ++i) {
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], step.start[i][k]);
        high[k] = std::max(high[k], step.start[i][k]);
      }
      const double motion = norm(x[i] - step.start[i]);
      if (!(motion > out.motion)) continue;
      out.motion = motion;
      fastest = i;
    }
  if (fastest >= 0) out.fastest = place_of(step.scene, step.model, {&fastest, 1});
  out.scene_size = norm(high - low);
}

}  // namespace

std::vector<NarrowGap> find_narrow_gaps(const Scene& scene, const Model& model, std::span<const Contact> all,
                                        size_t count) {
  std::vector<const Contact*> contacts;
  for (const Contact& contact : all) contacts.push_back(&contact);
  const auto ratio = [](const Contact* c) { return c->distance / c->contact_distance; };
  std::ranges::stable_sort(contacts, {}, ratio);
  std::vector<NarrowGap> gaps;
  for (size_t k = 0; k < std::min(count, contacts.size()); ++k) {
    const Contact& c = *contacts[k];
    const std::span<const int32_t> sites(c.sites.data(), static_cast<size_t>(c.point_count));
    const auto side_a = static_cast<size_t>(c.side_a_count);
    gaps.push_back({place_of(scene, model, sites.first(side_a)),
                    place_of(scene, model, sites.subspan(side_a)), c.distance, c.contact_distance});
  }
  return gaps;
}

std::vector<BodyVertices> block_owners(const Scene& scene, const Model& model) {
  const DofLayout& layout = model.map().layout();
  std::vector<BodyVertices> owners(layout.block_count, {"a part of the model"});
  for (int32_t b = 0; b < scene.body_count(); ++b) {
    const ModelBody& body = model.bodies()[b];
    const std::string owner = owner_of(scene, b);
    if (has_points(body.kind)) {
      for (int32_t v = 0; v < body.site_count; ++v)
        if (const int32_t block = layout.point_block[body.first_site + v]; block != kNoBlock)
          owners[block] = {owner, {v}};
      continue;
    }
    const bool is_rod = has_nodes(body.kind);
    for (int32_t v = 0; v < body.rigid_count(); ++v)
      for (const int32_t block :
           {layout.body_block[body.rigid_index + v], layout.rotation_block[body.rigid_index + v]})
        if (block != kNoBlock) owners[block] = {owner, is_rod ? std::vector{v} : std::vector<int32_t>{}};
  }
  for (size_t k = 0; k < model.fibres().size(); ++k)
    for (int32_t f = 0; f < model.fibres()[k].frame_count; ++f) {
      const int32_t frame = model.fibres()[k].first_frame + f;
      if (const int32_t block = layout.rotation_block[frame]; block != kNoBlock)
        owners[block] = {"fibres '" + scene.fibres()[k].name + "'"};
    }
  return owners;
}

StepEvidence collect_evidence(const FailedStep& step) {
  StepEvidence evidence;
  evidence.is_first_step = step.is_first_step;
  if (step.is_detour) evidence.in_the_way = limiting_parts(step);
  add_motion(step, evidence);
  add_prescribed(step, evidence);
  add_between(step, evidence);
  evidence.start_gaps = find_gaps(step, step.start);
  evidence.gaps = find_gaps(step, step.potential.site_positions());
  evidence.blocking = find_blocking_pair(step, step.settings.newton.max_rotation);
  std::vector<double> gradient(3 * static_cast<size_t>(step.potential.block_count()), 0.0);
  BlockMatrix hessian;
  step.potential.linearize(false, gradient, hessian);
  add_forces(step, gradient, evidence);
  add_not_finite(step, evidence);
  add_strains(step, evidence);
  add_rounding(step, hessian, evidence);
  add_stiffness_ratio(step, hessian, evidence);
  add_steep_energy(step, evidence);
  evidence.acting = energies_acting(step, gradient);
  evidence.rough = find_rough_energy(step, gradient);
  add_actuator(step, evidence);
  evidence.unit_suspicions = check_units(step.scene, step.settings);
  return evidence;
}

StepEvidence collect_energy_evidence(const FailedStep& step) {
  StepEvidence evidence;
  add_motion(step, evidence);
  std::vector<double> gradient(3 * static_cast<size_t>(step.potential.block_count()), 0.0);
  BlockMatrix hessian;
  step.potential.linearize(false, gradient, hessian);
  add_forces(step, gradient, evidence);
  add_steep_energy(step, evidence);
  evidence.rough = find_rough_energy(step, gradient);
  return evidence;
}

}  // namespace stark
