#include <stark/contact/contact_law.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

namespace stark {

namespace {

/// |b'(1/2)| of b = -(r - 1)^2 ln r.
constexpr double kMiddleSlope = std::numbers::ln2 + 0.5;

/// Part of the contact distance at which the largest lasting pressure is carried.
constexpr double kLoadedGap = 0.1;

/// Part of the contact distance by which a sheet keeps two bodies farther apart than they act on each other,
/// and the largest part of it at which it is asked to carry them.
constexpr double kClearOfEachOther = 0.1, kWidestGap = 0.9;

/// Cosine of the angle between a contact and the impact that has spent the layer, down to which it is of it.
constexpr double kFacing = 0.5;

/// Growth of a factor after an attempt that failed, and where that ends.
constexpr double kRaise = 1e3, kHighest = 1e9;

/// What contact may store at the start of a step with raised factors, over what it did at the end of the one
/// before: the difference comes out of nothing. Beyond the first no more than a part of what moves has
/// anyway.
constexpr double kStored = 10.0, kMostStored = 1e3, kPartOfMotion = 0.1;

constexpr int64_t kContactsPerTask = 1024;

/// Pairs of edges, or vertices with all of a body, which have one area.
int64_t area_code(const Contact& contact) {
  const bool is_edges = contact.key.kind == PairKind::EdgeEdge;
  const int64_t second = is_edges ? contact.key.second : contact.group_b;
  return (static_cast<int64_t>(is_edges) << 62) | (static_cast<int64_t>(contact.key.first) << 31) | second;
}

}  // namespace

double barrier_slope(double r) {
  return r < 1.0 ? 2.0 * (r - 1.0) * std::log(r) + (1.0 - r) * (1.0 - r) / r : 0.0;
}

double relative_pressure(double r) { return barrier_slope(r) / kMiddleSlope; }

ContactLaw::ContactLaw(AreaWeights areas, std::vector<BodyStiffness> bodies, std::vector<double> distance)
    : areas_(std::move(areas)), bodies_(std::move(bodies)), distance_(std::move(distance)) {}

void ContactLaw::begin_step(LoadMemory memory, std::map<int64_t, SpentLayer> spent) {
  memory_ = std::move(memory);
  spent_ = std::move(spent);
  relief_.begin();
  left_.clear();
  frozen_.clear();
}

double ContactLaw::left(const Contact& contact) const {
  const auto found = left_.find(area_code(contact));
  return found == left_.end() ? 1.0 : found->second;
}

void ContactLaw::freeze_left(std::span<const Vec3> x, const std::vector<Contact>& contacts) {
  if (spent_.empty()) return;
  std::map<int64_t, double> met;
  for (const Contact& contact : contacts) {
    const auto layer = spent_.find(group_code(contact));
    if (layer == spent_.end()) continue;
    const int64_t code = area_code(contact);
    if (left_.contains(code)) continue;
    const double side = side_of_first(contact, layer->first);
    const double along = dot(normalized(gap_vector(contact, x)), layer->second.normal) * side;
    double& left = met[code];
    left = std::max(left, along > kFacing * norm(layer->second.normal) ? layer->second.stiffness : 1.0);
  }
  left_.merge(met);
}

double ContactLaw::pressure(int32_t group_a, int32_t group_b) const {
  const bool is_given = this->is_given(group_a, group_b);
  // Where only one side was given, the other counts as rigid: what is measured is what was given.
  const auto compliance = [&](int32_t g) {
    return is_given && !bodies_[g].is_given ? 0.0 : distance_[g] / bodies_[g].pressure;
  };
  const double compliances = compliance(group_a) + compliance(group_b);
  return (distance_[group_a] + distance_[group_b]) / compliances;
}

void ContactLaw::freeze_areas(const SurfaceMesh& mesh, std::span<const Vec3> x,
                              const std::vector<Contact>& contacts) {
  struct Open {
    int64_t code;
    const Contact* contact;
  };
  std::vector<Open> open;
  open.reserve(contacts.size());
  for (const Contact& contact : contacts)
    if (const int64_t code = area_code(contact); areas_.is_directed(contact) && !frozen_.contains(code))
      open.push_back({code, &contact});
  // The nearest of each code; of equals, the first.
  std::ranges::sort(open, {},
                    [](const Open& o) { return std::tuple(o.code, o.contact->distance, o.contact); });
  for (const auto& [code, contact] : open)
    if (!frozen_.contains(code))
      frozen_[code] = areas_.area(mesh, *contact, normalized(gap_vector(*contact, x)), x);
}

void ContactLaw::assign(const SurfaceMesh& mesh, std::span<const Vec3> x, ThreadPool& pool,
                        std::vector<Contact>& contacts) {
  freeze_areas(mesh, x, contacts);
  freeze_left(x, contacts);
  pool.for_each_range(std::ssize(contacts), kContactsPerTask, [&](int64_t begin, int64_t end) {
    int64_t bodies = -1;
    double pressure = 0.0;  // of these bodies, under their load
    for (Contact& contact : std::span(contacts).subspan(begin, end - begin)) {
      if (const int64_t code = group_code(contact); code != bodies) {
        bodies = code;
        pressure = this->pressure(contact.group_a, contact.group_b) * factor(code);
      }
      const double area = areas_.is_directed(contact) ? frozen_.at(area_code(contact))
                                                      : areas_.area(mesh, contact, Vec3{}, x);
      contact.stiffness = contact.multiplicity * area * pressure / (kMiddleSlope * contact.contact_distance);
      if (!left_.empty()) contact.stiffness *= left(contact);
    }
  });
}

std::map<int64_t, double> ContactLaw::wanted(const std::vector<Contact>& contacts,
                                             std::span<const Vec3> forces, bool as_left) const {
  std::map<int64_t, double> wanted;
  for (const int64_t bodies : memory_.bodies) wanted[bodies] = 0.0;
  const double loaded = barrier_slope(kLoadedGap);
  for (size_t c = 0; c < contacts.size(); ++c) {
    if (!(contacts[c].stiffness > 0.0)) continue;
    const int64_t code = group_code(contacts[c]);
    const double part = as_left ? 1.0 : left(contacts[c]);
    const double natural = contacts[c].stiffness / (factor(code) * part);
    double& largest = wanted[code];
    largest = std::max(largest, norm(forces[c]) / (loaded * contacts[c].contact_distance * natural));
  }
  return wanted;
}

bool ContactLaw::relieve(const std::vector<Contact>& contacts, std::span<const Vec3> forces) {
  return relief_.stiffen(contacts, forces, [&](int64_t bodies) {
    const auto [a, b] = groups_of_code(bodies);
    return !is_given(a, b);
  });
}

std::map<int64_t, double> ContactLaw::sheet_factors(const std::vector<Contact>& contacts,
                                                    std::span<const Vec3> forces,
                                                    std::span<const PressedSheet> sheets) const {
  std::map<int64_t, double> total, factors;  // forces of bodies on each other [N]
  if (sheets.empty()) return factors;
  for (size_t c = 0; c < contacts.size(); ++c)
    if (contacts[c].stiffness > 0.0) total[group_code(contacts[c])] += norm(forces[c]);
  for (const auto& [sheet, a, b] : sheets) {
    if (std::isinf(bodies_[a].pressure) && std::isinf(bodies_[b].pressure)) continue;
    // The bodies touch each other where both gaps to the sheet add up to their own contact distance.
    const double own = distance_[a] + distance_[b];
    const double gap = std::min(own / (own + 2.0 * distance_[sheet]) + kClearOfEachOther, kWidestGap);
    if (gap <= kLoadedGap) continue;
    const double wider = barrier_slope(kLoadedGap) / barrier_slope(gap);
    const double through = total[group_code(a, b)];
    for (const int32_t body : {a, b}) {
      const double force = total[group_code(sheet, body)];
      double& factor = factors[group_code(sheet, body)];
      if (force > 0.0) factor = std::max(factor, wider * (1.0 + through / force));
    }
  }
  return factors;
}

LoadMemory ContactLaw::end_step(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                                double duration, std::span<const PressedSheet> sheets) const {
  LoadMemory memory;
  const auto count = static_cast<int64_t>(bodies_.size());
  const std::map<int64_t, double> of_sheets = sheet_factors(contacts, forces, sheets);
  for (auto [bodies, asked] : wanted(contacts, forces, false)) {
    if (const auto of_sheet = of_sheets.find(bodies); of_sheet != of_sheets.end())
      asked *= std::max(1.0, of_sheet->second);
    const int64_t a = bodies >> 32, b = bodies & 0xffffffff;
    const bool exists = a >= 0 && a < count && b < count;  // states may name any
    if (exists && !is_given(static_cast<int32_t>(a), static_cast<int32_t>(b)))
      memory.follow(memory_, bodies, asked, duration);
  }
  return memory;
}

std::map<int64_t, double> ContactLaw::highest_factors(const std::vector<Contact>& contacts,
                                                      const std::vector<double>& energies,
                                                      const LoadMemory& before, double kinetic) const {
  std::map<int64_t, double> each;  // with a factor of 1 [J]
  double total = 0.0;              // with those of the step before [J]
  for (size_t c = 0; c < contacts.size(); ++c) {
    const int64_t code = group_code(contacts[c]);
    const double energy = energies[c] / factor(code);
    each[code] += energy;
    total += energy / left(contacts[c]) * before.find(code);
  }
  const double most = std::min(kMostStored * total, std::max(kStored * total, kPartOfMotion * kinetic));
  std::map<int64_t, double> highest;
  for (const auto& [code, energy] : each)
    if (energy > 0.0) highest[code] = most / (energy * static_cast<double>(each.size()));
  return highest;
}

LoadMemory ContactLaw::raised(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                              const std::map<int64_t, double>& most) const {
  LoadMemory memory;
  for (const auto& [bodies, asked] : wanted(contacts, forces, true)) {
    const auto bound = most.find(bodies);
    const double now = memory_.find(bodies), end = bound == most.end() ? kHighest : bound->second;
    const double highest = std::max(now, std::min({kRaise * now, kHighest, end}));
    if (asked > 1.0)
      memory.add(bodies, std::clamp(asked, now, highest));
    else
      memory.add(bodies, memory_.pending(bodies), memory_.trial_of(bodies));
  }
  return memory;
}

}  // namespace stark
