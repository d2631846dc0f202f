#include <stark/contact/restitution.h>

#include <algorithm>
#include <cmath>

namespace stark {

namespace {

/// Of a force between two bodies: three on each.
constexpr int kPoints = 6;

/// Part of the speed of approach that may be left when an approach is over: steps that are long beside an
/// impact come to rest slowly.
constexpr double kLittleLeft = 0.05;

/// Force by missing speed, over what brings both bodies there in one step: how exact the speed is.
constexpr double kGain = 1e3;

/// Least stiffness of a layer that has taken up an impact, over its own, and the time in which it gets by a
/// factor of e stiffer again [s].
constexpr double kSpent = 3e-4, kRecovery = 0.1;

/// Force over the one that lasts from which a spent layer is pressed on, and by what it gets stiffer then in
/// a step.
constexpr double kPressed = 2.0, kStiffer = 10.0;

/// What may be taken back over what an impact and its layer can have given too much: other contacts may push,
/// too.
constexpr double kMostPull = 2.0;

/// Time with which the force that lasts follows the one of the step [s].
constexpr double kLoadTime = 0.02;

}  // namespace

RestitutionSet::RestitutionSet(RestitutionTable table, std::shared_ptr<const Potential> potential)
    : table_(std::move(table)) {
  if (!empty()) batch_.emplace_back(std::move(potential));
}

void RestitutionSet::begin_step(RestitutionMemory memory, std::span<const Vec3> x, const Motion& motion) {
  if (empty()) return;
  impacts_.clear();
  motion_ = motion;
  references_.assign(motion.references.begin(), motion.references.end());
  if (references_.empty()) memory = {};
  std::vector<int32_t> stencils;
  for (size_t k = 0; k < memory.bodies.size(); ++k) {
    const int64_t bodies = memory.bodies[k];
    if (!table_.coefficient.contains(bodies)) continue;  // states may name any
    impacts_[bodies] = {memory.speed[k], memory.impulse[k],   memory.work[k],
                        memory.load[k],  memory.stiffness[k], memory.due[k],
                        memory.rate[k],  memory.normal[k],    memory.moment[k]};
    if (memory.due[k] == 0.0) continue;
    impacts_[bodies].mass = memory.impulse[k] / (memory.speed[k] + memory.rate[k]);
    impacts_[bodies].rate = along(bodies, impacts_[bodies], motion.turned, motion.velocities);
    const auto [a, b] = groups_of_code(bodies);
    for (const int32_t group : {a, b})
      for (const int32_t site : table_.frame[group]) stencils.push_back(site);
  }
  PotentialBatch& batch = batch_.front();
  batch.resize(stencils);
  batch.set_uniform("duration", motion.duration);
  int64_t element = 0;
  for (const auto& [bodies, impact] : impacts_)
    if (impact.due != 0.0) set_element(element++, bodies, impact);
  batch.set_previous(references_);
  remember(x);
}

void RestitutionSet::set_element(int64_t element, int64_t bodies, const Impact& impact) {
  const double e = table_.coefficient.at(bodies), V = impact.speed, u0 = impact.rate;
  const double h = motion_.step, sigma = motion_.duration, a = fall(bodies, impact.normal);
  const double mass = impact.mass;
  // u^2/2 + a (way(u) - delay u h/2) = e^2 V^2/2 with way(u) = d + sigma u: the speed with which the bodies
  // would have left where the approach ended.
  const double d = along(bodies, impact, motion_.turned, motion_.lead);
  const double b = a * (sigma - 0.5 * motion_.delay * h);
  const double target = -b + std::sqrt(std::max(0.0, b * b + e * e * V * V - 2.0 * a * d));
  // What the layer has given back by itself before the end of the step is part of what is due.
  const double back = 0.5 * mass * std::max(0.0, u0) * u0;
  const double energy = std::max(0.0, e * e * (impact.work + back) - back);
  // What comes up since, as a body whose script turns it round, is for contact to stop.
  const double by_impulse = mass * std::max(0.0, e * V - std::max(u0, -kLittleLeft * V)) / h;
  const double mean = 0.5 * (u0 + target);
  const double by_energy = mean > 0.0 ? energy / (h * mean) : by_impulse;
  const double w = motion_.weight;
  PotentialBatch& batch = batch_.front();
  batch.set("target", element, target);
  batch.set("gain", element, w * kGain * mass / h);
  batch.set("push", element, w * std::min(by_impulse, by_energy));
  batch.set("pull", element, w * impact.impulse / h);
  const auto [first, second] = groups_of_code(bodies);
  double side = 1.0;
  int i = 0;
  for (const int32_t group : {first, second}) {
    for (const Vec3& share : shares(group, impact.normal, impact.moment, motion_.turned)) {
      const Vec3 g = share * side;
      const int field = batch.field_index("share" + std::to_string(i++));
      batch.set(field, element, {&g.x, 3});
    }
    side = -1.0;
  }
}

// What moves a body by its script in this step says nothing of the impact before it: a plate that draws back
// would take along what it has hit.
void RestitutionSet::bound_pull(int64_t element, const Impact& impact, double stored) {
  PotentialBatch& batch = batch_.front();
  const double target = batch.get(batch.field_index("target"), element);
  const double by_layer = std::sqrt(2.0 * std::max(0.0, stored) / impact.mass);
  const double most =
      kMostPull * impact.mass * (std::max(0.0, impact.rate - target) + by_layer) / motion_.step;
  const double pull = batch.get(batch.field_index("pull"), element);
  batch.set("pull", element, std::min(pull, motion_.weight * most));
}

std::map<int64_t, SpentLayer> RestitutionSet::spent() const {
  std::map<int64_t, SpentLayer> spent;
  for (const auto& [bodies, impact] : impacts_)
    if (impact.stiffness != 1.0) spent[bodies] = {impact.stiffness, impact.normal};
  return spent;
}

void RestitutionSet::set_contacts(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                                  std::span<const double> energies) {
  contacts_.clear();
  int64_t element = 0;
  for (const auto& [bodies, impact] : impacts_) {
    if (impact.due == 0.0) continue;
    const size_t first = contacts_.size();
    const Vec3& n = impact.normal;  // shorter than 1 where contacts press in several directions
    Vec3 sum;
    double stored = 0.0;
    for (size_t c = 0; c < contacts.size(); ++c) {
      const Contact& contact = contacts[c];
      if (group_code(contact) != bodies) continue;
      stored += energies[c];
      contacts_.emplace_back(contact, forces[c]);
      sum += forces[c] * side_of_first(contact, bodies);
    }
    const double total = dot(sum, n);
    bound_pull(element++, impact, stored / motion_.weight);
    if (!(total > 0.0)) contacts_.resize(first);
    // Contacts have moved since the approach: what their sum lacks is spread over them.
    const double scale = squared_norm(n) / total;
    const Vec3 rest = n - sum * scale;
    for (size_t k = first; k < contacts_.size(); ++k) {
      auto& [contact, share] = contacts_[k];
      share = share * scale + rest * (dot(share, n) / total);
    }
  }
}

std::vector<RestitutionSet::Return> RestitutionSet::returns(std::span<const Vec3> x) const {
  std::vector<Return> returns;
  int64_t element = 0;
  for (const auto& [bodies, impact] : impacts_) {
    if (impact.due == 0.0) continue;
    const PotentialBatch& batch = batch_.front();
    const auto field = [&](const char* name) { return batch.get(batch.field_index(name), element); };
    double way = 0.0;
    for (int i = 0; i < kPoints; ++i) {
      const int share = batch.field_index("share" + std::to_string(i));
      const int32_t site = batch.stencil(element)[i];
      const Vec3 motion = x[site] - references_[site];
      for (int c = 0; c < 3; ++c) way += batch.get(share, element, c) * motion[c];
    }
    const double rate = way / motion_.duration, wanted = field("gain") * (field("target") - rate);
    const double force = std::clamp(wanted, -field("pull"), field("push")) / motion_.weight;
    returns.push_back({bodies, force, 0.5 * (impact.rate + rate)});
    ++element;
  }
  return returns;
}

std::vector<std::pair<Contact, Vec3>> RestitutionSet::given_back(std::span<const Vec3> x) const {
  std::vector<std::pair<Contact, Vec3>> result;
  for (const Return& given : returns(x))
    for (const auto& [contact, share] : contacts_)
      if (group_code(contact) == given.bodies) result.emplace_back(contact, share * given.force);
  return result;
}

std::vector<RestitutionSet::LineForce> RestitutionSet::given_back_beyond(std::span<const Vec3> x) const {
  std::vector<LineForce> result;
  for (const Return& given : returns(x)) {
    const bool is_shown = std::ranges::any_of(
        contacts_, [&](const auto& entry) { return group_code(entry.first) == given.bodies; });
    if (is_shown || given.force == 0.0) continue;
    const Impact& impact = impacts_.at(given.bodies);
    result.push_back({given.bodies, impact.normal, given.force,
                      cross(impact.normal, impact.moment) / squared_norm(impact.normal)});
  }
  return result;
}

double RestitutionSet::work(std::span<const Vec3> x) const {
  double total = 0.0;
  for (const Return& given : returns(x)) total += given.force * given.mean_rate * motion_.step;
  return total;
}

std::vector<const PotentialBatch*> RestitutionSet::batches() const {
  if (batch_.empty() || batch_.front().size() == 0) return {};
  return {&batch_.front()};
}

void RestitutionSet::remember(std::span<const Vec3> x) {
  for (const PotentialBatch* batch : batches()) remembered_ = batch->evaluate(symbolic::Order::Energy, x);
}

EnergyDifference RestitutionSet::energy_difference(std::span<const Vec3> x) const {
  EnergyDifference total;
  for (const PotentialBatch* batch : batches()) {
    const std::vector<double> now = batch->evaluate(symbolic::Order::Energy, x);
    for (size_t e = 0; e < now.size(); ++e) {
      total.difference += now[e] - remembered_[e];
      total.magnitude += std::fabs(remembered_[e]);
    }
  }
  return total;
}

std::array<Vec3, 3> RestitutionSet::shares(int32_t group, const Vec3& normal, const Vec3& moment,
                                           std::span<const Vec3> x) const {
  // The smallest ones: n/3 + b x r_i with the lever r_i from the centre of the three points.
  const std::array<int32_t, 3>& frame = table_.frame[group];
  const Vec3 centre = (x[frame[0]] + x[frame[1]] + x[frame[2]]) / 3.0;
  Mat3 inertia{};
  for (const int32_t site : frame) {
    const Vec3 r = x[site] - centre;
    inertia += Mat3::identity() * squared_norm(r) - outer(r, r);
  }
  const Vec3 turn = inverse(inertia) * (moment - cross(centre, normal));
  std::array<Vec3, 3> shares;
  for (int k = 0; k < 3; ++k) shares[k] = normal / 3.0 + cross(turn, x[frame[k]] - centre);
  return shares;
}

double RestitutionSet::along(int64_t bodies, const Impact& impact, std::span<const Vec3> x,
                             std::span<const Vec3> vectors) const {
  const auto [first, second] = groups_of_code(bodies);
  double sum = 0.0, side = 1.0;
  for (const int32_t group : {first, second}) {
    const auto g = shares(group, impact.normal, impact.moment, x);
    for (int k = 0; k < 3; ++k) sum += side * dot(g[k], vectors[table_.frame[group][k]]);
    side = -1.0;
  }
  return sum;
}

double RestitutionSet::fall(int64_t bodies, const Vec3& normal) const {
  const auto [first, second] = groups_of_code(bodies);
  return std::max(0.0, dot(normal, table_.gravity[second] - table_.gravity[first]));
}

std::map<int64_t, RestitutionSet::Sum> RestitutionSet::sums(const std::vector<Contact>& contacts,
                                                            std::span<const Vec3> forces,
                                                            std::span<const Vec3> x, const End& end) const {
  std::map<int64_t, Sum> sums;
  for (size_t c = 0; c < contacts.size(); ++c) {
    const Contact& contact = contacts[c];
    const int64_t bodies = group_code(contact);
    if (!table_.coefficient.contains(bodies)) continue;
    const double side = side_of_first(contact, bodies);
    const Vec3 force = forces[c] * side, gap = gap_vector(contact, x) * side;
    Vec3 at;  // of the closest point of side A
    for (int p = 0; p < contact.side_a_count; ++p) at += x[contact.sites[p]] * contact.weights[p];
    Sum& sum = sums[bodies];
    sum.force += dot(force, normalized(gap));
    sum.normal += force;
    sum.moment += cross(at, force);
    sum.rate_start += dot(forces[c], gap_vector(contact, end.before));
    sum.rate_end += dot(forces[c], gap_vector(contact, end.after));
    sum.way += dot(forces[c], gap_vector(contact, end.way));
  }
  for (auto& [bodies, sum] : sums) {
    if (!(sum.force > 0.0)) continue;
    for (double* value : {&sum.rate_start, &sum.rate_end, &sum.way}) *value /= sum.force;
    sum.normal = sum.normal / sum.force;
    sum.moment = sum.moment / sum.force;
  }
  return sums;
}

RestitutionSet::Impact RestitutionSet::next(int64_t bodies, Impact impact, Sum sum) const {
  const double h = motion_.step, follow = 1.0 - std::exp(-h / kLoadTime);
  impact.stiffness = std::min(1.0, impact.stiffness * std::exp(h / kRecovery));
  if (impact.due != 0.0)
    impact = {.load = impact.load, .stiffness = impact.stiffness, .normal = impact.normal};
  const double a = fall(bodies, sum.normal), u0 = sum.rate_start, u1 = sum.rate_end;
  // Else what pushes slowly would close the gap before the layer carries it.
  if (u1 < 0.0 && sum.force > kPressed * impact.load)
    impact.stiffness = std::min(1.0, kStiffer * impact.stiffness);
  const bool approaches = sum.force > 0.0 && u0 < 0.0;
  const double by_rate = approaches ? u0 * u0 - motion_.delay * a * h * u0 : 0.0;
  const double by_fall = 2.0 * a * std::max(0.0, -sum.way);
  if (impact.speed == 0.0 && (!approaches || !(by_rate + by_fall > 4.0 * a * a * h * h))) {
    impact.load += (sum.force - impact.load) * follow;
    return impact;
  }
  const double force = std::max(0.0, sum.force - impact.load);
  // What another body drives on meanwhile comes faster than it began.
  impact.speed = std::sqrt(std::max(impact.speed * impact.speed, by_rate) + by_fall);
  impact.impulse += force * h;
  impact.work -= force * h * 0.5 * (u0 + u1);
  impact.rate = u1;
  if (sum.force > 0.0) {
    impact.normal = sum.normal;
    impact.moment = sum.moment;
  }
  if (u1 < -kLittleLeft * impact.speed) return impact;
  if (!(impact.impulse > 0.0) || !(impact.work > 0.0))
    return {.load = impact.load, .stiffness = impact.stiffness, .normal = impact.normal};
  impact.due = 1.0;
  const double carried = impact.load + a * impact.impulse / (impact.speed + u1);
  if (sum.force > carried) impact.stiffness = std::max(kSpent, impact.stiffness * carried / sum.force);
  impact.load = std::max(impact.load, carried);
  return impact;
}

RestitutionMemory RestitutionSet::end_step(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                                           std::span<const Vec3> x, const End& end) const {
  RestitutionMemory memory;
  if (empty() || references_.empty()) return memory;
  std::map<int64_t, Sum> now = sums(contacts, forces, x, end);
  for (const auto& [bodies, impact] : impacts_)
    if (const auto [entry, is_new] = now.try_emplace(bodies); is_new && impact.speed > 0.0) {
      entry->second.rate_start = along(bodies, impact, x, end.before);
      entry->second.rate_end = along(bodies, impact, x, end.after);
    }
  for (const auto& [bodies, sum] : now) {
    const auto found = impacts_.find(bodies);
    const Impact impact = next(bodies, found == impacts_.end() ? Impact{} : found->second, sum);
    const bool is_apart = !(sum.force > 0.0) && impact.due == 0.0;
    if (is_apart) continue;
    memory.bodies.push_back(bodies);
    memory.speed.push_back(impact.speed);
    memory.impulse.push_back(impact.impulse);
    memory.work.push_back(impact.work);
    memory.load.push_back(impact.load);
    memory.stiffness.push_back(impact.stiffness);
    memory.due.push_back(impact.due);
    memory.rate.push_back(impact.rate);
    memory.normal.push_back(impact.normal);
    memory.moment.push_back(impact.moment);
  }
  return memory;
}

}  // namespace stark
