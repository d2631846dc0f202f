#include <stark/contact/pipeline.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <stark/base/error.h>
#include <stark/contact/pushing_forces.h>

namespace stark {

namespace {

/// Part of their contact distance that bodies keep however close they start.
constexpr double kClosest = 0.01;

/// Gap in a fold of a body with a given law, over its contact distance and over its core, down to which it is
/// a compressed layer: a few times the contact stiffness.
constexpr double kFold = 0.25, kFoldOnCore = 1.25;

/// Rounding of a gap that does not count as closer.
constexpr double kRounding = 1e-9;

/// Of vertices equally far from the line of an impact, the one that faces the other body.
constexpr double kFacing = 1e-3;

/// Part of their gap that pairs of bodies keep in a step that starts below their least distance.
constexpr double kKeptGap = 0.5;

Separations::Pair pair_of(int64_t code, double separation) {
  const auto [a, b] = groups_of_code(code);
  return {a, b, separation};
}

ContactLaw make_law(const ContactSurfaces& surfaces) {
  std::vector<BodyStiffness> bodies = surfaces.stiffness;
  if (bodies.empty()) bodies.assign(surfaces.group_distance.size(), {.pressure = 1.0, .is_given = false});
  return {AreaWeights(surfaces.mesh, surfaces.rest_positions, surfaces.patch, surfaces.is_sheet,
                      surfaces.group_distance),
          std::move(bodies), surfaces.group_distance};
}

/// Adds friction of contacts that others of the same place have taken over since it was frozen, as one edge
/// does for the next at their common end, to the strongest of these. Where none has, what was left of the
/// friction is within the tolerance of its limits.
void add_friction_elsewhere(const SurfaceMesh& mesh,
                            const std::map<PairKey, FrictionSet::PairMotion>& frictions,
                            std::vector<ContactForce>& entries) {
  if (frictions.empty()) return;
  std::map<FrictionPlace, size_t> strongest;
  const auto force_at = [&](size_t c) { return squared_norm(entries[c].normal_force); };
  for (size_t c = 0; c < entries.size(); ++c) {
    const Vec3 n = normalized(entries[c].point_a - entries[c].point_b);
    const FrictionLimit at = limit_of(entries[c].contact, n, 0.0);
    const auto offer = [&](const FrictionPlace& place) {
      const auto [found, is_new] = strongest.emplace(place, c);
      if (!is_new && force_at(c) > force_at(found->second)) found->second = c;
    };
    offer(at.place);
    if (at.other) offer(*at.other);
  }
  for (const auto& [key, pair] : frictions) {
    const FrictionLimit at = limit_of(pair.contact, pair.normal, 0.0);
    auto found = strongest.find(at.place);
    if (found == strongest.end() && at.other) found = strongest.find(*at.other);
    if (found == strongest.end()) continue;
    ContactForce& entry = entries[found->second];
    const double side = orientation(mesh, pair.contact);  // of side A
    const bool is_same_side = pair.contact.group_a == pair.contact.group_b
                                  ? dot(pair.normal, entry.point_a - entry.point_b) >= 0.0
                                  : pair.contact.group_a == entry.contact.group_a;
    entry.friction += pair.force * (side * (is_same_side ? 1.0 : -1.0));
  }
}

}  // namespace

ContactPipeline::ContactPipeline(ContactSurfaces surfaces, const ContactPotentials& potentials,
                                 const ContactSettings& settings, double stick_displacement,
                                 const KinematicMap& map, ThreadPool& pool, PhaseTimer& timer)
    : search_(surfaces.mesh, surfaces.filter, surfaces.group_distance, pool, timer),
      friction_coefficient_(std::move(surfaces.friction)),
      settings_(settings),
      pool_(pool),
      timer_(timer),
      law_(make_law(surfaces)),
      cells_(surfaces.mesh, surfaces.face),
      rest_positions_(std::move(surfaces.rest_positions)),
      active_(potentials.barriers, pool),
      trial_(potentials.barriers, pool),
      friction_(potentials.friction, stick_displacement, pool,
                SurfaceDirections(surfaces.mesh, std::move(surfaces.directions))),
      restitution_(std::move(surfaces.restitution), potentials.restitution) {
  for (const Index2& edge : surfaces.mesh.edges)
    geometry_.edge_squared_length.push_back(
        squared_norm(rest_positions_[edge[1]] - rest_positions_[edge[0]]));
  geometry_.group_distance = surfaces.group_distance;
  geometry_.face = std::move(surfaces.face);
  for (int32_t site = 0; site < map.site_count(); ++site)
    geometry_.prescribed.push_back(map.is_prescribed(site) ? 1 : 0);
  const auto is_positive = [](double core) { return core > 0.0; };
  if (std::ranges::any_of(surfaces.core, is_positive)) geometry_.group_core = std::move(surfaces.core);
  for (size_t g = 0; g < surfaces.group_distance.size(); ++g) {
    const double separation = settings.min_separation_factor * surfaces.group_distance[g];
    const double core = geometry_.group_core.empty() ? 0.0 : geometry_.group_core[g];
    geometry_.group_separation.push_back(std::max(separation, core));
  }
  geometry_.mesh = &search_.mesh();
  geometry_.edge_ranges = std::make_shared<const EdgeRanges>(law_.areas().edge_ranges(mesh()));
  search_.set_edges(geometry_.edge_ranges, geometry_.group_separation);
  std::vector<bool> rigid;
  for (int32_t i = 0; i < map.site_count(); ++i) rigid.push_back(map.site(i).kind == SiteKind::RigidPoint);
  friction_.set_rigid_sites(std::move(rigid));
  friction_.set_levers(std::move(surfaces.levers), std::move(surfaces.patch));
  friction_.set_moving_surfaces(MovingSurfaces(std::move(surfaces.moving)));
}

void ContactPipeline::begin_step(const SitePositions& positions, const VelocityReference& reference,
                                 ContactMemory memory) {
  const std::span<const Vec3> x = positions.all;
  ++revision_;
  x_reference_.assign(reference.positions.begin(), reference.positions.end());
  duration_ = reference.duration;
  weight_ = reference.weight;
  active_.set_weight(weight_);
  trial_.set_weight(weight_);
  names_.clear();
  for (const int64_t code : memory.friction.pair)
    if (const PairKey key = unpack(code); is_name(key)) names_.push_back(key);
  friction_.begin_step(mesh(), std::move(memory.friction), x,
                       {x_reference_, reference.step / reference.duration, weight_, reference.duration});
  friction_.set_surface_motions(reference.surface_velocity, reference.surface_spin);
  set_close_bodies(std::move(memory.close));
  restitution_.begin_step(std::move(memory.restitution), x, reference.motion);
  law_.begin_step(std::move(memory.load), restitution_.spent());
  geometry_.has_least_distance = is_bound_;
  forget_sets();
  update(positions);
  if (is_bound_ && lower_separations()) {
    forget_sets();
    update(positions);
  }
  if (!restitution_.batches().empty()) {
    restitution_.set_contacts(contacts(), forces(x), active_.energies());
    restitution_.remember(x);
  }
  if (settings_.friction) freeze_friction(x);
}

void ContactPipeline::set_close_bodies(CloseBodies close) {
  geometry_.close = std::move(close);
  geometry_.pair_separation.clear();
  for (size_t k = 0; k < geometry_.close.bodies.size(); ++k) {
    const int64_t code = geometry_.close.bodies[k];
    const double distance = geometry_.close.distance[k];
    // Of a core there is as much as the gap at the start leaves room for.
    const auto [a, b] = groups_of_code(code);
    const double core = std::min(0.5 * distance, geometry_.core(a, b));
    const double separation = std::max(settings_.min_separation_factor * distance, core);
    geometry_.pair_separation.push_back(pair_of(code, separation));
  }
}

bool ContactPipeline::lower_separations() {
  std::map<int64_t, double> lower;
  for (const Contact& contact : contacts()) {
    if (contact.distance > (1.0 + kRounding) * contact.least_distance) continue;
    const double kept = kKeptGap * contact.distance;
    const auto [entry, is_new] = lower.try_emplace(group_code(contact), kept);
    entry->second = std::min(entry->second, kept);
  }
  if (lower.empty()) return false;
  for (const Separations::Pair& pair : geometry_.pair_separation)
    lower.try_emplace(group_code(pair.low, pair.high), pair.separation);
  geometry_.pair_separation.clear();
  for (const auto& [code, separation] : lower) geometry_.pair_separation.push_back(pair_of(code, separation));
  return true;
}

ContactMemory ContactPipeline::end_step(const SitePositions& positions, double duration,
                                        const RestitutionSet::End& motion) {
  const std::span<const Vec3> x = positions.all;
  ++revision_;
  settle(positions);
  std::vector<Vec3> all = forces(x);
  LoadMemory load =
      law_.end_step(contacts(), all, duration, find_pressed_sheets(law_.areas(), contacts(), all));
  RestitutionMemory restitution = restitution_.end_step(contacts(), all, x, motion);
  friction_residual_ = 0.0;
  unsettled_friction_.reset();
  if (settings_.friction) {
    const LimitComparison limits =
        friction_.residual(contacts(), pushing_forces(contacts(), std::move(all)), friction_coefficient_);
    friction_residual_ = limits.total().largest_change;
    unsettled_friction_ = limits.unsettled();
  }
  ContactMemory memory{friction_.end_step(x), std::move(load)};
  memory.close = parted(x);
  memory.restitution = std::move(restitution);
  return memory;
}

bool ContactPipeline::is_name(const PairKey& key) const {
  if (key.kind != PairKind::PointTriangle && key.kind != PairKind::PointEdge) return false;
  const size_t seconds = groups_of(mesh(), second_kind(key.kind)).size();
  return key.first < mesh().vertex_count && static_cast<size_t>(key.second) < seconds;
}

std::vector<Vec3> ContactPipeline::forces(std::span<const Vec3> x) const {
  std::vector<Vec3> forces;
  active_.evaluate_forces(x, forces);
  return forces;
}

std::map<int64_t, double> ContactPipeline::smallest_gaps(std::span<const Vec3> x) {
  std::map<int64_t, double> gaps;
  for (const Contact& contact : find_contacts_at(x)) {
    if (contact.group_a == contact.group_b &&
        std::sqrt(squared_distance(mesh(), contact.key.kind, contact.key.pair(), rest_positions_)) <
            contact.contact_distance)
      continue;
    const int64_t code = group_code(contact);
    const double gap = std::max(contact.distance, kClosest * contact.contact_distance);
    const auto [entry, is_new] = gaps.try_emplace(code, gap);
    entry->second = std::min(entry->second, gap);
  }
  return gaps;
}

CloseBodies ContactPipeline::find_close_bodies(std::span<const Vec3> x) {
  CloseBodies close;
  for (const auto& [code, gap] : smallest_gaps(x)) {
    const auto [a, b] = groups_of_code(code);
    double least = geometry_.group_distance[a] + geometry_.group_distance[b];
    // A fold that is tighter than the layer is thick compresses the layer there, if its law says how much
    // that takes. A smaller distance would make the body thinner everywhere.
    if (a == b && law_.is_given(a, a)) least = std::max(kFold * least, kFoldOnCore * geometry_.core(a, a));
    if (gap > (1.0 - kRounding) * least) continue;
    close.bodies.push_back(code);
    close.distance.push_back(gap);
  }
  return close;
}

CloseBodies ContactPipeline::parted(std::span<const Vec3> x) {
  CloseBodies close;
  if (geometry_.close.bodies.empty()) return close;
  const std::map<int64_t, double> gaps = smallest_gaps(x);
  for (size_t k = 0; k < geometry_.close.bodies.size(); ++k) {
    const int64_t code = geometry_.close.bodies[k];
    const auto gap = gaps.find(code);
    if (gap == gaps.end()) continue;  // farther apart than their contact distance
    close.bodies.push_back(code);
    close.distance.push_back(std::max(geometry_.close.distance[k], gap->second));
  }
  return close;
}

void ContactPipeline::set_filter(PairFilter filter) {
  search_.set_filter(std::move(filter));
  forget_sets();
}

void ContactPipeline::fill(const std::vector<Contact>& near, std::span<const Vec3> x, ContactSet& out) {
  std::vector<Contact> contacts = merge_by_feature(geometry_, cells_, names_, x, near, pool_);
  law_.assign(mesh(), x, pool_, contacts);
  merge_equal_stencils(x, contacts);
  out.reset(std::move(contacts));
  out.evaluate_energies(x);
}

void ContactPipeline::update(const SitePositions& positions) {
  const std::span<const Vec3> x = positions.all;
  const bool is_here = x_active_.are(positions, pool_);
  if (is_active_ && is_here) return;
  ++revision_;
  if (is_trial_ && x_trial_.are(positions, pool_)) {
    search_.at_accepted_trial(x);
    active_.swap(trial_);
    near_active_.swap(near_trial_);
    x_active_.swap(x_trial_);
  } else {
    const CandidateList& candidates = search_.at(x);
    if (!is_near_ || !is_here) find_contacts(geometry_, candidates, x, pool_, near_active_);
    fill(near_active_, x, active_);
    x_active_.hold(positions, pool_);
  }
  is_active_ = is_near_ = true;
  is_trial_ = false;
  friction_.remember(x);
  restitution_.remember(x);
}

std::vector<const PotentialBatch*> ContactPipeline::batches(Curvature curvature) {
  std::vector<const PotentialBatch*> all = active_.batches();
  const auto frictions =
      curvature == Curvature::Modelled ? friction_.models(x_active_.get()) : friction_.batches();
  all.insert(all.end(), frictions.begin(), frictions.end());
  const auto restitution = restitution_.batches();
  all.insert(all.end(), restitution.begin(), restitution.end());
  return all;
}

double ContactPipeline::max_step(std::span<const Vec3> x0, std::span<const Vec3> x1) {
  return safe_fraction(x0, x1, geometry_.separations());
}

bool ContactPipeline::is_clear(std::span<const Vec3> x0, std::span<const Vec3> x1) {
  const std::vector<double> none(geometry_.group_separation.size(), 0.0);
  return safe_fraction(x0, x1, {none}) == 1.0;
}

double ContactPipeline::safe_fraction(std::span<const Vec3> x0, std::span<const Vec3> x1,
                                      const Separations& separations) {
  return search_.max_safe_step(x0, x1, separations, {.is_bound = is_bound_}, &ccd_report_);
}

EnergyDifference ContactPipeline::energy_difference(const SitePositions& positions) {
  const std::span<const Vec3> x = positions.all;
  find_contacts(geometry_, search_.at_trial(x), x, pool_, near_trial_);
  fill(near_trial_, x, trial_);
  x_trial_.hold(positions, pool_);
  is_trial_ = true;
  EnergyDifference total = stark::energy_difference(active_, trial_);
  for (const EnergyDifference& other : {friction_.energy_difference(x), restitution_.energy_difference(x)}) {
    total.difference += other.difference;
    total.magnitude += other.magnitude;
  }
  return total;
}

double ContactPipeline::refresh_lagged(const SitePositions& x) {
  if (!settings_.friction) return 0.0;
  update(x);
  return freeze_friction(x.all);
}

void ContactPipeline::refresh_early(const SitePositions& positions, Lagged lagged) {
  if (!settings_.friction) return;
  const std::span<const Vec3> x = positions.all;
  ++revision_;
  update(positions);
  const PhaseTimer::Scope scope(timer_, Phase::Friction);
  friction_.renew(contacts(), pushing_forces(contacts(), forces(x)), friction_coefficient_, x, lagged);
  friction_.remember(x);
  keep_names();
}

double ContactPipeline::freeze_friction(std::span<const Vec3> x) {
  const PhaseTimer::Scope scope(timer_, Phase::Friction);
  ++revision_;
  const double change =
      friction_.reset(contacts(), pushing_forces(contacts(), forces(x)), friction_coefficient_, x);
  friction_.remember(x);
  keep_names();
  return change;
}

void ContactPipeline::keep_names() {
  std::vector<PairKey> now, all;  // sorted, as contacts are
  for (const Contact& contact : contacts())
    if (is_name(contact.key)) now.push_back(contact.key);
  if (std::ranges::includes(names_, now)) return;
  std::ranges::set_union(names_, now, std::back_inserter(all));
  names_ = std::move(all);
  is_active_ = is_trial_ = false;
}

ContactPipeline::Approach ContactPipeline::approach(std::span<const Vec3> x0, std::span<const Vec3> x1) {
  Approach result;
  result.hits = max_step(x0, x1) < 1.0;
  if (result.hits && ccd_report_.kind) {
    const auto group = [&](PrimitiveKind kind, int32_t id) { return groups_of(mesh(), kind)[id]; };
    result.after.insert(group_code(group(first_kind(*ccd_report_.kind), ccd_report_.first),
                                   group(second_kind(*ccd_report_.kind), ccd_report_.second)));
  }
  const auto visit = [&](std::span<const Vec3> at, std::span<const Vec3> other, std::set<int64_t>& bodies) {
    for (const Contact& contact : find_contacts_at(at)) {
      const Vec3 here = gap_vector(contact, at);
      const double way = dot(here - gap_vector(contact, other), normalized(here));
      result.largest = std::max(result.largest, std::fabs(way) / contact.contact_distance);
      bodies.insert(group_code(contact));
    }
  };
  visit(x0, x1, result.before);
  visit(x1, x0, result.after);
  return result;
}

std::vector<ContactForce> ContactPipeline::contact_forces(std::span<const Vec3> x) const {
  const std::vector<Vec3> normal = forces(x);
  auto frictions = friction_.motions(x);
  std::vector<ContactForce> result;
  for (size_t c = 0; c < normal.size(); ++c)
    result.push_back({.contact = contacts()[c], .normal_force = normal[c]});
  for (const auto& [contact, force] : restitution_.given_back(x))
    result.push_back({.contact = contact, .normal_force = force});
  for (size_t c = 0; c < result.size(); ++c) {
    ContactForce& entry = result[c];
    Vec3 motion;
    for (int p = 0; p < entry.contact.point_count; ++p) {
      const int32_t site = entry.contact.sites[p];
      const double weight = entry.contact.weights[p];
      (p < entry.contact.side_a_count ? entry.point_a : entry.point_b) += x[site] * std::fabs(weight);
      motion += (x[site] - x_reference_[site]) * weight;
    }
    const Vec3 gap = entry.point_a - entry.point_b, n = normalized(gap);
    if (c >= normal.size()) entry.contact.distance = norm(gap);  // theirs is of the start of the step
    const auto found = c < normal.size() ? frictions.find(entry.contact.key) : frictions.end();
    if (found != frictions.end()) {
      const double side = orientation(mesh(), entry.contact);
      entry.friction = found->second.force * side;
      motion = found->second.motion * side;
      const FrictionStencil& at = found->second.stencil;
      const bool is_swapped = side * orientation(mesh(), found->second.contact) < 0.0;
      if (at.turns()) entry.friction_at = is_swapped ? at.swapped() : at;
      frictions.erase(found);
    } else {
      motion += friction_.drift(entry.contact, n, x);
    }
    entry.friction_point = entry.friction_at.is_carried() ? entry.friction_at.point(x) : entry.point_a;
    entry.slip = (motion - n * dot(n, motion)) / duration_;
  }
  add_friction_elsewhere(mesh(), frictions, result);
  for (const RestitutionSet::LineForce& given : restitution_.given_back_beyond(x))
    result.push_back(beyond_reach(given, x));
  return result;
}

ContactForce ContactPipeline::beyond_reach(const RestitutionSet::LineForce& given,
                                           std::span<const Vec3> x) const {
  const auto [a, b] = groups_of_code(given.bodies);
  const Vec3 n = normalized(given.normal);
  Contact contact{.group_a = a, .group_b = b};
  contact.contact_distance = geometry_.group_distance[a] + geometry_.group_distance[b];
  // The vertex of each body that is nearest to the line, on the side of the other body.
  double nearest = std::numeric_limits<double>::infinity();
  Vec3 at = given.at;
  for (const int side : {0, 1}) {
    double best = std::numeric_limits<double>::infinity();
    for (int32_t v = 0; v < mesh().vertex_count; ++v) {
      if (mesh().vertex_group[v] != (side == 0 ? a : b)) continue;
      const Vec3 r = x[v] - given.at, across = r - n * dot(r, n);
      const double off = squared_norm(across) + kFacing * dot(r, n) * std::fabs(dot(r, n)) * (1 - 2 * side);
      if (off < best) best = off, contact.sites[side] = v;
      if (squared_norm(across) < nearest) nearest = squared_norm(across), at = x[v] - across;
    }
  }
  contact.weights = {1.0, -1.0};
  contact.distance = contact.contact_distance;
  const Vec3 force = given.normal * given.force;
  return {.contact = contact, .point_a = at, .point_b = at, .normal_force = force, .friction_point = at};
}

double ContactPipeline::energy() const {
  double total = 0.0;
  for (const double energy : active_.energies()) total += energy;
  return total / weight_;
}

Nearness ContactPipeline::nearness(const SitePositions& x) {
  Nearness found;
  for (const Contact& contact : find_contacts_at(x)) {
    found.distance = std::min(found.distance, contact.distance);
    const double least = settings_.min_separation_factor * (geometry_.group_distance[contact.group_a] +
                                                            geometry_.group_distance[contact.group_b]);
    if (contact.distance * found.least < found.nearest * least)
      found = {found.distance, contact.group_a, contact.group_b, contact.distance, least};
  }
  return found;
}

const std::vector<Contact>& ContactPipeline::find_contacts_at(const SitePositions& positions) {
  if (is_found_ && x_found_.are(positions, pool_)) return found_;
  const std::span<const Vec3> x = positions.all;
  is_found_ = false;
  const CandidateList& candidates = search_.at(x);
  CloseBodies close = std::exchange(geometry_.close, {});
  std::shared_ptr<const EdgeRanges> ranges = std::exchange(geometry_.edge_ranges, {});
  find_contacts(geometry_, candidates, x, pool_, found_);
  std::vector<Contact> edges;
  find_contacts(geometry_, search_.distant_edges(), x, pool_, edges);
  found_.insert(found_.end(), edges.begin(), edges.end());
  x_found_.hold(positions, pool_);
  is_found_ = true;
  geometry_.close = std::move(close);
  geometry_.edge_ranges = std::move(ranges);
  return found_;
}

}  // namespace stark
