#include <stark/contact/friction_set.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include <stark/base/collect.h>
#include <stark/base/rotation.h>
#include <stark/mechanics/lane_outputs.h>

namespace stark {

using symbolic::Order;

namespace {

constexpr int64_t kPairsPerTask = 256;

/// Resets of a step after which pairs keep their tangent planes and closest points.
constexpr int kGeometryResets = 2;

/// Resets in a step after which limits go half of the way only, or more where they go on in the same way.
constexpr int kPlainResets = 3;

/// Part of the stick displacement from which a remembered pair counts as sliding.
constexpr double kSliding = 1.0 - 1e-6;

/// Cosine of the angle between two triangles above which a point that goes from one to the other slides on.
constexpr double kSameSide = 0.9;

/// A vector laid into the plane of a unit normal without changing its length.
Vec3 turned(const Vec3& v, const Vec3& normal) {
  const Vec3 t = v - normal * dot(normal, v);
  const double length = norm(t);
  return length > 0.0 ? t * (norm(v) / length) : Vec3{};
}

/// Part of u in the direction of v; zero where v is.
Vec3 project(const Vec3& u, const Vec3& v) {
  const double squared = squared_norm(v);
  return squared > 0.0 ? v * (dot(u, v) / squared) : Vec3{};
}

/// A unit vector in the plane of a unit normal.
Vec3 any_tangent(const Vec3& normal) {
  const Vec3 axis = std::fabs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  return normalized(axis - normal * dot(normal, axis));
}

}  // namespace

FrictionSet::Fields::Fields(const PotentialBatch& batch, bool is_anisotropic)
    : limit(batch.field_index("limit")),
      deflection(batch.field_index("deflection")),
      first(batch.field_index(is_anisotropic ? "along" : "normal")),
      second(is_anisotropic ? batch.field_index("across") : -1),
      facing(batch.point_count() > 2 ? batch.field_index("facing") : -1),
      slope(batch.field_index("slope")),
      pull(batch.field_index("pull")),
      way(batch.field_index("way")),
      pull_at_iterate(batch.field_index("pull_at_iterate")),
      way_at_iterate(batch.field_index("way_at_iterate")) {
  for (int p = 0; p < batch.point_count(); ++p) {
    weights[p] = batch.field_index("weight" + std::to_string(p));
    if (facing >= 0) slopes[p] = batch.field_index("slope" + std::to_string(p));
  }
}

FrictionSet::FrictionSet(const FrictionPotentials& potentials, double stick_displacement, ThreadPool& pool,
                         SurfaceDirections directions)
    : stick_displacement_(stick_displacement), pool_(pool), directions_(std::move(directions)) {
  const auto add = [&](const std::shared_ptr<const Potential>& potential) {
    if (potential == nullptr) return;
    batches_.emplace_back(potential).set_uniform("is_model", 0.0);
    fields_.emplace_back(batches_.back(), batches_.size() > FrictionPotentials::kCounts);
    models_.emplace_back(potential).set_uniform("is_model", 1.0);
  };
  for (const auto& potential : potentials.isotropic) add(potential);
  for (const auto& potential : potentials.anisotropic) add(potential);
  members_.resize(batches_.size());
}

void FrictionSet::begin_step(const SurfaceMesh& mesh, FrictionMemory memory, std::span<const Vec3> x,
                             DisplacementReference reference) {
  if (mesh_ != &mesh)
    carriers_ = FrictionCarriers(mesh, rigid_sites_, FrictionLevers(mesh, lever_sites_, patch_));
  mesh_ = &mesh;
  memory_ = std::move(memory);
  x_start_.assign(x.begin(), x.end());
  reference_ = std::move(reference);
  resets_ = 0;
  shares_.begin_step();
  next_start_.reset();
  for (PotentialBatch& batch : batches_)
    batch.set_uniform("stick_displacement", stick_displacement_ / reference_.scale);
}

FrictionSet::Pair FrictionSet::make_pair(const Contact& contact, const FrictionCoefficient& mu,
                                         const Vec3& force, std::span<const Vec3> x,
                                         PressedAreas& areas) const {
  const Pair* before = resets_ > 0 ? find(contact.key) : nullptr;
  // Arms that followed the iterates of an impact would keep friction from settling. A corner that lifts off
  // on the way to the solution comes back to its own.
  std::optional<LeverArm> arm = resets_ > 0 ? arms_at_start_.find(contact.key, patch_) : std::nullopt;
  if (!arm && before) arm = before->stencil.arm;
  Pair pair{.contact = contact,
            .stencil = carriers_.stencil(*mesh_, contact, x, arm, areas),
            .normal = normalized(force),
            .force = norm(force)};
  pair.is_anisotropic = mu.is_anisotropic();
  if (pair.is_anisotropic) set_axes(mu, x, pair);
  pair.drift = drift(contact, pair.normal, x, pair.stencil.shift);
  const int64_t known = find_bristles(contact, x);
  if (before != nullptr && before->modelled) {
    pair.dual = turned(before->dual, pair.normal);
    pair.modelled = turned(*before->modelled, pair.normal);
  }
  if (known >= 0) {
    pair.deflection = turned(memory_.deflection[known], pair.normal) * orientation(*mesh_, contact);
    if (resets_ == 0 && memory_.pair[known] == pack(contact.key)) pair.force = memory_.force[known];
    const double bent =
        pair.is_anisotropic ? measure(pair, pair.deflection) : norm(memory_.deflection[known]);
    pair.slides = bent >= kSliding * stick_displacement_;
  }
  if (resets_ >= kGeometryResets && before != nullptr) {
    pair.contact = before->contact;
    pair.stencil = carriers_.stencil(*mesh_, pair.contact, x, arm, areas);
    pair.normal = before->normal;
    pair.deflection = before->deflection;
    pair.along = before->along;
    pair.across = before->across;
    pair.drift = before->drift;
  }
  if (resets_ > 0) pair.slides = measure(pair, deflection(pair, x)) >= stick_displacement_;
  return pair;
}

int64_t FrictionSet::find_bristles(const Contact& contact, std::span<const Vec3> x) const {
  const int64_t own = memory_.find(contact.key);
  if (own >= 0 || contact.key.kind != PairKind::PointTriangle) return own;
  const auto normal = [&](const Index3& t) {
    return normalized(cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]));
  };
  const Index3& triangle = mesh_->triangles[contact.key.second];
  const auto [first, last] = memory_.of_first(contact.key);
  for (int64_t k = first; k < last; ++k) {
    const Index3& other = mesh_->triangles[unpack(memory_.pair[k]).second];
    if (std::ranges::find_first_of(triangle, other) != triangle.end() &&
        dot(normal(triangle), normal(other)) > kSameSide)
      return k;
  }
  return -1;
}

Vec3 FrictionSet::drift(const Contact& contact, const Vec3& normal, std::span<const Vec3> x,
                        const Vec3& shift) const {
  if (moving_.empty()) return {};
  // Displacements that are differences of places are chords of what turns; those of bdf2 are velocities.
  const bool is_chord = reference_.scale == 1.0;
  Vec3 way;
  for (const bool is_a : {true, false}) {
    const int first = is_a ? 0 : contact.side_a_count,
              end = is_a ? contact.side_a_count : contact.point_count;
    Vec3 point = shift;
    for (int p = first; p < end; ++p) point += x[contact.sites[p]] * std::fabs(contact.weights[p]);
    const int32_t group = mesh_->vertex_group[contact.sites[first]];
    way += moving_.way(group, point, x, reference_.duration, is_chord) * (is_a ? 1.0 : -1.0);
  }
  return way - normal * dot(normal, way);
}

void FrictionSet::set_axes(const FrictionCoefficient& mu, std::span<const Vec3> x, Pair& pair) const {
  const Vec3 t = directions_.of_pair(*mesh_, pair.contact.key, mu.frame, pair.normal, x);
  const bool has_direction = squared_norm(t) > 0.0;
  // Without a direction all are alike: the geometric mean of the two coefficients.
  const double mean = std::sqrt(mu.along * mu.across);
  const Vec3 tangent = has_direction ? t : any_tangent(pair.normal);
  pair.along = tangent * (has_direction ? mu.along : mean);
  pair.across = cross(pair.normal, tangent) * (has_direction ? mu.across : mean);
}

double FrictionSet::measure(const Pair& pair, const Vec3& deflection) {
  if (!pair.is_anisotropic) return norm(deflection);
  const double a = dot(pair.along, deflection), b = dot(pair.across, deflection);
  return std::sqrt(a * a + b * b);
}

Vec3 FrictionSet::limited(const Pair& pair, Vec3 u) const {
  if (pair.is_anisotropic) {
    // What nothing resists leaves no deflection behind.
    if (pair.along == Vec3{}) u = project(u, pair.across);
    if (pair.across == Vec3{}) u = project(u, pair.along);
  }
  const double length = measure(pair, u);
  return length > stick_displacement_ ? u * (stick_displacement_ / length) : u;
}

int64_t FrictionSet::bodies_of(const Pair& pair) { return group_code(pair.contact); }

std::vector<FrictionSet::Pair> FrictionSet::make_pairs(const std::vector<Contact>& contacts,
                                                       std::span<const Vec3> forces,
                                                       const FrictionTable& coefficient,
                                                       std::span<const Vec3> x) const {
  return collect_ranges<Pair>(
      pool_, std::ssize(contacts), kPairsPerTask, [&](int64_t begin, int64_t end, std::vector<Pair>& out) {
        PressedAreas areas;
        for (int64_t c = begin; c < end; ++c) {
          const FrictionCoefficient mu = coefficient(contacts[c].group_a, contacts[c].group_b);
          if (!(mu.sticking > 0.0) || !(norm(forces[c]) > 0.0)) continue;
          Pair pair = make_pair(contacts[c], mu, forces[c], x, areas);
          pair.limit = (pair.slides ? mu.sliding : mu.sticking) * pair.force;
          out.push_back(std::move(pair));
        }
      });
}

void FrictionSet::renew(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                        const FrictionTable& coefficient, std::span<const Vec3> x, Lagged lagged) {
  std::vector<Pair> pairs = make_pairs(contacts, forces, coefficient, x);
  if (lagged == Lagged::FromStart)
    std::erase_if(pairs, [&](const Pair& pair) { return !touching_.contains(bodies_of(pair)); });
  freeze(std::move(pairs));
}

double FrictionSet::reset(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                          const FrictionTable& coefficient, std::span<const Vec3> x) {
  std::vector<Pair> next = make_pairs(contacts, forces, coefficient, x);
  if (++resets_ == 1) return start(std::move(next));
  const std::vector<FrictionLimit> before = limits(pairs_), now = limits(next);
  const LimitComparison comparison(before, now);
  if (comparison.is_settled()) {
    // The solution is one with the friction that it was found with; where the next step starts from is new.
    next_start_ = std::move(next);
    return 0.0;
  }
  // Of those that go all of the way, the last one is what the next is compared with.
  const double share = resets_ < kPlainResets ? 1.0 : shares_.next(before, now, resets_ == kPlainResets);
  if (share != 1.0) {
    // Limits that go back and forth between two solutions meet in the middle. Places that one of them lacks
    // are left out: what is left of their limits would fade over more refreshes than there are.
    const std::vector<double> damped = damped_limits(before, now, share);
    for (size_t k = 0; k < next.size(); ++k) next[k].limit = damped[k];
  }
  previous_ = std::move(pairs_);
  freeze(std::move(next));
  return comparison.total().largest_change;
}

double FrictionSet::start(std::vector<Pair> pairs) {
  touching_.clear();
  arms_at_start_.clear();
  double largest = 0.0;
  for (const Pair& pair : pairs) {
    touching_.insert(bodies_of(pair));
    arms_at_start_.append(pair.contact.key, pair.stencil.arm);
    largest = std::max(largest, pair.limit);
  }
  previous_ = std::move(pairs_);
  freeze(std::move(pairs));
  return largest;
}

void FrictionSet::restore() { freeze(std::move(kept_)); }

void FrictionSet::freeze(std::vector<Pair> pairs) {
  pairs_ = std::move(pairs);
  next_start_.reset();
  for (auto& members : members_) members.clear();
  for (size_t i = 0; i < pairs_.size(); ++i)
    members_[pairs_[i].stencil.point_count - 2 + (pairs_[i].is_anisotropic ? FrictionPotentials::kCounts : 0)]
        .push_back(i);
  fill(batches_);
  fill(models_);
}

const FrictionSet::Pair* FrictionSet::find(const PairKey& key) const {
  const auto found = std::ranges::lower_bound(pairs_, key, {}, [](const Pair& p) { return p.contact.key; });
  return found != pairs_.end() && found->contact.key == key ? &*found : nullptr;
}

Vec3 FrictionSet::deflection(const Pair& pair, std::span<const Vec3> x) const {
  Vec3 u = pair.stencil.motion(x, reference_.positions) * reference_.scale + pair.deflection;
  if (!moving_.empty()) u += pair.drift * reference_.scale;
  return u - pair.normal * dot(pair.normal, u);
}

LimitComparison FrictionSet::residual(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                                      const FrictionTable& coefficient) const {
  std::vector<FrictionLimit> now;
  for (size_t c = 0; c < contacts.size(); ++c) {
    if (!(norm(forces[c]) > 0.0)) continue;
    const FrictionCoefficient mu = coefficient(contacts[c].group_a, contacts[c].group_b);
    const Pair* frozen = find(contacts[c].key);
    const bool slides = frozen != nullptr && frozen->slides;
    const double limit = (slides ? mu.sliding : mu.sticking) * norm(forces[c]);
    now.push_back(limit_of(contacts[c], normalized(forces[c]), limit));
  }
  return {limits(pairs_), now};
}

std::vector<FrictionLimit> FrictionSet::limits(const std::vector<Pair>& pairs) {
  std::vector<FrictionLimit> limits;
  limits.reserve(pairs.size());
  for (const Pair& pair : pairs) limits.push_back(limit_of(pair.contact, pair.normal, pair.limit));
  return limits;
}

void FrictionSet::fill(std::vector<PotentialBatch>& batches) const {
  for (size_t k = 0; k < batches.size(); ++k) {
    PotentialBatch& batch = batches[k];
    const int points = batch.point_count();
    const Fields& fields = fields_[k];
    std::vector<int32_t> stencils;
    stencils.reserve(members_[k].size() * points);
    for (const size_t i : members_[k])
      stencils.insert(stencils.end(), pairs_[i].stencil.sites.begin(),
                      pairs_[i].stencil.sites.begin() + points);
    batch.resize(stencils);
    if (stencils.empty()) continue;
    batch.set_previous(reference_.positions);
    pool_.for_each_range(batch.size(), kPairsPerTask, [&](int64_t begin, int64_t end) {
      for (int64_t e = begin; e < end; ++e) set_fields(pairs_[members_[k][e]], fields, e, batch);
    });
  }
}

void FrictionSet::set_fields(const Pair& pair, const Fields& fields, int64_t e, PotentialBatch& batch) const {
  const int points = batch.point_count();
  const bool is_anisotropic = fields.second >= 0;
  Vec3 start = pair.deflection / reference_.scale;
  if (!moving_.empty()) start += pair.drift;
  const double weighted = pair.limit * reference_.weight;
  batch.set(fields.limit, e, {&weighted, 1});
  batch.set(fields.first, e, {is_anisotropic ? &pair.along.x : &pair.normal.x, 3});
  if (is_anisotropic) batch.set(fields.second, e, {&pair.across.x, 3});
  batch.set(fields.deflection, e, {&start.x, 3});
  for (int p = 0; p < points; ++p) batch.set(fields.weights[p], e, {&pair.stencil.weights[p], 1});
  if (points == 2) return;
  batch.set(fields.facing, e, {&pair.stencil.facing.x, 3});
  for (int p = 0; p < points; ++p) batch.set(fields.slopes[p], e, {&pair.stencil.slopes[p].x, 3});
}

FrictionMemory FrictionSet::end_step(std::span<const Vec3> x) const {
  FrictionMemory memory;
  const std::vector<Pair>& pairs = next_start_ ? *next_start_ : pairs_;
  memory.reserve(pairs.size());
  for (const Pair& pair : pairs) {
    const Vec3 u = limited(pair, deflection(pair, x));
    double angle = spin(*mesh_, pair.contact.key, pair.normal, x_start_, x);
    if (!moving_.empty()) angle += surface_turn(pair, x);
    memory.append(pair.contact.key, exp_rotation(pair.normal * angle) * u * orientation(*mesh_, pair.contact),
                  pair.force);
  }
  return memory;
}

double FrictionSet::surface_turn(const Pair& pair, std::span<const Vec3> x) const {
  const PairKey& key = pair.contact.key;
  const bool is_face = key.kind == PairKind::PointTriangle;
  if (!is_face && key.kind != PairKind::EdgeEdge && key.kind != PairKind::PointEdge) return 0.0;
  const int32_t group = is_face                          ? mesh_->triangle_group[key.second]
                        : key.kind == PairKind::EdgeEdge ? mesh_->edge_group[key.first]
                                                         : mesh_->edge_group[key.second];
  return moving_.turn(group, pair.normal, x, reference_.duration * reference_.scale);
}

std::vector<const PotentialBatch*> FrictionSet::non_empty(const std::vector<PotentialBatch>& batches) {
  std::vector<const PotentialBatch*> result;
  for (const PotentialBatch& batch : batches)
    if (batch.size() > 0) result.push_back(&batch);
  return result;
}

std::vector<const PotentialBatch*> FrictionSet::models(std::span<const Vec3> x) {
  for (size_t k = 0; k < models_.size(); ++k)
    pool_.for_each_range(models_[k].size(), kPairsPerTask, [&](int64_t begin, int64_t end) {
      for (int64_t e = begin; e < end; ++e) set_model(k, e, x);
    });
  return non_empty(models_);
}

void FrictionSet::set_model(size_t k, int64_t e, std::span<const Vec3> x) {
  PotentialBatch& batch = models_[k];
  const Fields& fields = fields_[k];
  Pair& pair = pairs_[members_[k][e]];
  const Vec3 u = deflection(pair, x) / reference_.scale;
  update_dual(u, pair);
  const double y = measure(pair, u), slope = slope_at(y);
  const Vec3 way = in_metric(pair, y > 0.0 ? u / y : Vec3{}),
             pull = in_metric(pair, pair.dual * phi_prime(y));
  const double p = dot(pull, u), q = dot(way, u);
  batch.set(fields.slope, e, {&slope, 1});
  batch.set(fields.pull, e, {&pull.x, 3});
  batch.set(fields.way, e, {&way.x, 3});
  batch.set(fields.pull_at_iterate, e, {&p, 1});
  batch.set(fields.way_at_iterate, e, {&q, 1});
}

// With the force as an unknown of its own, phi(|u|) w = u, and a Newton step of this system from the last
// iterate [theory eq. 20e; Chan, Golub, Mulet 1999]; first, the force of the bristles at the start of the
// step.
void FrictionSet::update_dual(const Vec3& u, Pair& pair) const {
  if (!pair.modelled) {
    const Vec3 start = pair.deflection / reference_.scale;
    pair.dual = start * slope_at(measure(pair, start));
  } else if (u != *pair.modelled) {
    const Vec3& before = *pair.modelled;
    const double y = measure(pair, before);
    const double growth = y > 0.0 ? dot(in_metric(pair, before), u - before) / y : 0.0;
    pair.dual = (u - pair.dual * (phi_prime(y) * growth)) * slope_at(y);
  }
  const double length = measure(pair, pair.dual);
  if (length > 1.0) pair.dual = pair.dual / length;
  pair.modelled = u;
}

Vec3 FrictionSet::in_metric(const Pair& pair, const Vec3& u) {
  return pair.is_anisotropic ? pair.along * dot(pair.along, u) + pair.across * dot(pair.across, u) : u;
}

double FrictionSet::slope_at(double y) const {
  const double eps = stick_displacement_ / reference_.scale;
  return y < eps ? (2.0 - y / eps) / eps : 1.0 / y;
}

double FrictionSet::phi_prime(double y) const {
  const double part = std::min(1.0, y * reference_.scale / stick_displacement_);
  return 1.0 / ((2.0 - part) * (2.0 - part));
}

std::map<PairKey, FrictionSet::PairMotion> FrictionSet::motions(std::span<const Vec3> x) const {
  std::map<PairKey, PairMotion> motions;
  for (const Pair& pair : pairs_) {
    const double sign = orientation(*mesh_, pair.contact);
    Vec3 motion = pair.stencil.motion(x, reference_.positions);
    if (!moving_.empty()) motion += pair.drift;
    motions[pair.contact.key] = {.force = force(pair, x) * sign,
                                 .motion = motion * sign,
                                 .contact = pair.contact,
                                 .normal = pair.normal,
                                 .stencil = pair.stencil};
  }
  return motions;
}

Vec3 FrictionSet::force(const Pair& pair, std::span<const Vec3> x) const {
  const Vec3 u = deflection(pair, x) / reference_.scale;
  return in_metric(pair, u) * (-pair.limit * slope_at(measure(pair, u)));
}

double FrictionSet::surface_work(std::span<const Vec3> x) const {
  if (moving_.empty()) return 0.0;
  double total = 0.0;
  for (const Pair& pair : pairs_) total -= dot(force(pair, x), pair.drift) * reference_.scale;
  return total;
}

double FrictionSet::energy_at_start() const {
  const double eps = stick_displacement_;
  double total = 0.0;
  for (const Pair& pair : pairs_) {
    const Vec3& a = pair.deflection;
    const double y = std::min(norm(a - pair.normal * dot(pair.normal, a)), eps);
    total += pair.limit * (y * y / eps) * (1.0 - y / (3.0 * eps));
  }
  return total / reference_.scale;
}

std::vector<double> FrictionSet::energies(std::span<const Vec3> x) const {
  std::vector<double> energies;
  energies.reserve(pairs_.size());
  for (const PotentialBatch& batch : batches_) {
    if (batch.size() == 0) continue;
    const AlignedVector<double> out = lane_outputs(batch, Order::Energy, x, &pool_);
    energies.insert(energies.end(), out.begin(), out.begin() + batch.size());
  }
  return energies;
}

void FrictionSet::remember(std::span<const Vec3> x) { remembered_ = energies(x); }

EnergyDifference FrictionSet::energy_difference(std::span<const Vec3> x) const {
  EnergyDifference total;
  const std::vector<double> now = energies(x);
  for (size_t e = 0; e < now.size(); ++e) {
    total.difference += now[e] - remembered_[e];
    total.magnitude += std::fabs(remembered_[e]);
  }
  return total;
}

}  // namespace stark
