#include <stark/contact/contact_set.h>

#include <algorithm>
#include <cmath>

#include <stark/base/collect.h>
#include <stark/base/error.h>
#include <stark/geometry/distance.h>
#include <stark/mechanics/lane_outputs.h>

namespace stark {

using symbolic::kLanes;
using symbolic::Order;

namespace {

constexpr double kParallelFactor =
    1e-3;  ///< mollify below this times |e_a|^2 |e_b|^2 of the rest shape [Li 2020]
constexpr int64_t kCandidatesPerTask = 512, kContactsPerTask = 1024;

/// Where barriers are infinite, over the distance that collision detection keeps: the force there is 10^4
/// times that at half the contact distance, and what pushes harder is blocked instead of pushed to rounding.
constexpr double kPole = 0.9;
/// The same for cores, which are met by loads of every day.
constexpr double kCorePole = 0.9999;

struct Box {
  Vec3 low, high;
};

Box box_of(const Vec3& a, const Vec3& b) {
  return {{std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)},
          {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}};
}

/// Whether two boxes are farther apart than d along an axis: most candidates are, and the test is cheap.
bool boxes_apart(const Box& a, const Box& b, double d) {
  return a.low.x - b.high.x > d || b.low.x - a.high.x > d || a.low.y - b.high.y > d ||
         b.low.y - a.high.y > d || a.low.z - b.high.z > d || b.low.z - a.high.z > d;
}

/// Fills a contact from vertex ids; unused points are left out.
void set_points(Contact& contact, StencilKind kind, int side_a_count, std::initializer_list<int32_t> sites,
                std::initializer_list<double> weights) {
  contact.kind = kind;
  contact.point_count = static_cast<int8_t>(sites.size());
  contact.side_a_count = static_cast<int8_t>(side_a_count);
  std::copy(sites.begin(), sites.end(), contact.sites.begin());
  std::copy(weights.begin(), weights.end(), contact.weights.begin());
}

void set_point_edge(Contact& contact, int32_t p, int32_t a, int32_t b, const std::array<double, 2>& w) {
  set_points(contact, StencilKind::PointEdge, 1, {p, a, b}, {1.0, -w[0], -w[1]});
}

class Classifier {
 public:
  Classifier(const ContactGeometry& geometry, std::span<const Vec3> x)
      : geometry_(geometry), mesh_(*geometry.mesh), x_(x) {}

  bool classify(PairTag<PairKind::PointTriangle> kind, const PrimitivePair& c, Contact& contact) const {
    const int32_t p = c.first;
    const auto& t = mesh_.triangles[c.second];
    begin(contact, kind, c);
    const Box edge = box_of(x_[t[0]], x_[t[1]]);
    const Box triangle{box_of(edge.low, x_[t[2]]).low, box_of(edge.high, x_[t[2]]).high};
    if (boxes_apart({x_[p], x_[p]}, triangle, contact.contact_distance)) return false;
    const auto type = point_triangle_type(x_[p], x_[t[0]], x_[t[1]], x_[t[2]]);
    if (!within(contact, point_triangle_squared_distance(x_[p], x_[t[0]], x_[t[1]], x_[t[2]], type)))
      return false;
    const auto w = point_triangle_weights(x_[p], x_[t[0]], x_[t[1]], x_[t[2]], type);
    const int k = static_cast<int>(type);
    if (k < 3) {
      set_points(contact, StencilKind::PointPoint, 1, {p, t[k]}, {1.0, -1.0});
    } else if (k < 6) {
      const int i = k - 3, j = (i + 1) % 3;
      set_point_edge(contact, p, t[i], t[j], {w[i], w[j]});
    } else {
      set_points(contact, StencilKind::PointTriangle, 1, {p, t[0], t[1], t[2]}, {1.0, -w[0], -w[1], -w[2]});
    }
    return true;
  }

  bool classify(PairTag<PairKind::EdgeEdge> kind, const PrimitivePair& c, Contact& contact) const {
    const Index2 a = mesh_.edges[c.first], b = mesh_.edges[c.second];
    begin(contact, kind, c);
    if (geometry_.edge_ranges)
      contact.contact_distance =
          geometry_.edge_distance(contact, (*geometry_.edge_ranges)(c.first, c.second));
    if (boxes_apart(box_of(x_[a[0]], x_[a[1]]), box_of(x_[b[0]], x_[b[1]]), contact.contact_distance))
      return false;
    auto type = edge_edge_type(x_[a[0]], x_[a[1]], x_[b[0]], x_[b[1]]);
    if (!within(contact, edge_edge_squared_distance(x_[a[0]], x_[a[1]], x_[b[0]], x_[b[1]], type)))
      return false;
    const auto w = edge_edge_weights(x_[a[0]], x_[a[1]], x_[b[0]], x_[b[1]], type);
    contact.parallel_threshold =
        kParallelFactor * geometry_.edge_squared_length[c.first] * geometry_.edge_squared_length[c.second];
    const bool mollified =
        squared_norm(cross(x_[a[1]] - x_[a[0]], x_[b[1]] - x_[b[0]])) < contact.parallel_threshold;
    using enum EdgeEdgeType;
    if (type == EA_EB) {
      set_points(contact, mollified ? StencilKind::MollifiedEdgeEdge : StencilKind::EdgeEdge, 2,
                 {a[0], a[1], b[0], b[1]}, {w[0], w[1], -w[2], -w[3]});
    } else if (type == EA_EB0 || type == EA_EB1) {
      // An end of edge B against the inside of edge A: the point side comes first.
      const int i = type == EA_EB0 ? 0 : 1;
      std::swap(contact.group_a, contact.group_b);
      if (mollified)
        set_points(contact, StencilKind::MollifiedPointEdge, 2, {b[i], b[1 - i], a[0], a[1]},
                   {1.0, 0.0, -w[0], -w[1]});
      else
        set_point_edge(contact, b[i], a[0], a[1], {w[0], w[1]});
    } else if (type == EA0_EB || type == EA1_EB) {
      const int i = type == EA0_EB ? 0 : 1;
      if (mollified)
        set_points(contact, StencilKind::MollifiedPointEdge, 2, {a[i], a[1 - i], b[0], b[1]},
                   {1.0, 0.0, -w[2], -w[3]});
      else
        set_point_edge(contact, a[i], b[0], b[1], {w[2], w[3]});
    } else {
      const int i = type == EA1_EB0 || type == EA1_EB1 ? 1 : 0,
                j = type == EA0_EB1 || type == EA1_EB1 ? 1 : 0;
      if (mollified)
        set_points(contact, StencilKind::MollifiedPointPoint, 2, {a[i], a[1 - i], b[j], b[1 - j]},
                   {1.0, 0.0, -1.0, 0.0});
      else
        set_points(contact, StencilKind::PointPoint, 1, {a[i], b[j]}, {1.0, -1.0});
    }
    return true;
  }

  bool classify(PairTag<PairKind::PointEdge> kind, const PrimitivePair& c, Contact& contact) const {
    const auto& e = mesh_.edges[c.second];
    begin(contact, kind, c);
    const auto type = point_edge_type(x_[c.first], x_[e[0]], x_[e[1]]);
    if (!within(contact, point_edge_squared_distance(x_[c.first], x_[e[0]], x_[e[1]], type))) return false;
    if (type == PointEdgeType::P_E)
      set_point_edge(contact, c.first, e[0], e[1], point_edge_weights(x_[c.first], x_[e[0]], x_[e[1]], type));
    else
      set_points(contact, StencilKind::PointPoint, 1, {c.first, e[type == PointEdgeType::P_E0 ? 0 : 1]},
                 {1.0, -1.0});
    return true;
  }

  bool classify(PairTag<PairKind::PointPoint> kind, const PrimitivePair& c, Contact& contact) const {
    begin(contact, kind, c);
    if (!within(contact, squared_norm(x_[c.first] - x_[c.second]))) return false;
    set_points(contact, StencilKind::PointPoint, 1, {c.first, c.second}, {1.0, -1.0});
    return true;
  }

 private:
  template <PairKind kind>
  void begin(Contact& contact, PairTag<kind>, const PrimitivePair& pair) const {
    const PrimitivePair groups = PairRow<kind>::groups(mesh_, pair);
    contact.key = {kind, pair.first, pair.second};
    contact.group_a = groups.first;
    contact.group_b = groups.second;
    contact.contact_distance = geometry_.distance(groups.first, groups.second);
  }

  bool within(Contact& contact, double squared_distance) const {
    if (!(squared_distance < contact.contact_distance * contact.contact_distance)) return false;
    contact.distance = std::sqrt(squared_distance);
    contact.least_distance = geometry_.least_distance(contact.group_a, contact.group_b);
    return true;
  }

  const ContactGeometry& geometry_;
  const SurfaceMesh& mesh_;
  std::span<const Vec3> x_;
};

template <typename Tag>
std::vector<Contact> classify_all(const Classifier& classifier, Tag kind,
                                  const std::vector<PrimitivePair>& candidates, ThreadPool& pool) {
  return collect_ranges<Contact>(pool, std::ssize(candidates), kCandidatesPerTask,
                                 [&](int64_t begin, int64_t end, std::vector<Contact>& out) {
                                   Contact contact;
                                   for (int64_t i = begin; i < end; ++i)
                                     if (classifier.classify(kind, candidates[i], contact))
                                       out.push_back(contact);
                                 });
}

/// One contact of a point with each face. It is named by the face, so it stays the same one, with its
/// stiffness and its friction, while the point slides from triangle to triangle.
void keep_nearest_of_faces(std::span<const int32_t> face, std::vector<Contact>& contacts) {
  for (Contact& contact : contacts) contact.key.second = face[contact.key.second];
  const auto by_face = [](const Contact& a, const Contact& b) {
    return a.key != b.key ? a.key < b.key : a.distance < b.distance;
  };
  if (!std::ranges::is_sorted(contacts, by_face)) std::ranges::stable_sort(contacts, by_face);
  const auto rest = std::ranges::unique(contacts, {}, &Contact::key);
  contacts.erase(rest.begin(), rest.end());
}

}  // namespace

int64_t group_code(int32_t group_a, int32_t group_b) {
  const auto [a, b] = std::minmax(group_a, group_b);
  return (static_cast<int64_t>(a) << 32) | b;
}

std::optional<double> CloseBodies::of(int64_t code) const {
  const auto found = std::ranges::lower_bound(bodies, code);
  if (found == bodies.end() || *found != code) return {};
  return distance[found - bodies.begin()];
}

void CloseBodies::set(int64_t code, double value) {
  const auto found = std::ranges::lower_bound(bodies, code);
  const auto at = found - bodies.begin();
  if (found == bodies.end() || *found != code) {
    bodies.insert(found, code);
    distance.insert(distance.begin() + at, value);
  }
  distance[at] = value;
}

double ContactGeometry::distance(int32_t group_a, int32_t group_b) const {
  if (!close.bodies.empty())
    if (const auto given = close.of(group_code(group_a, group_b))) return *given;
  return group_distance[group_a] + group_distance[group_b];
}

double ContactGeometry::core(int32_t group_a, int32_t group_b) const {
  return group_core.empty() ? 0.0 : group_core[group_a] + group_core[group_b];
}

double ContactGeometry::edge_distance(const Contact& edges, double part) const {
  const double distance = edges.contact_distance * part;
  if (core(edges.group_a, edges.group_b) == 0.0) return distance;
  return std::max(distance, 2.0 * least_distance(edges.group_a, edges.group_b));
}

Separations ContactGeometry::separations() const {
  return {.by_group = group_separation,
          .by_pair = pair_separation,
          .core = has_least_distance ? std::span(group_core) : std::span<const double>{},
          .core_part = kCorePole};
}

double ContactGeometry::least_distance(int32_t group_a, int32_t group_b) const {
  if (!has_least_distance || group_separation.empty()) return 0.0;
  const double pole = core(group_a, group_b) > 0.0 ? kCorePole : kPole;
  return pole * separations()(group_a, group_b);
}

void find_contacts(const ContactGeometry& geometry, const CandidateList& candidates, std::span<const Vec3> x,
                   ThreadPool& pool, std::vector<Contact>& out) {
  out.clear();
  const Classifier classifier(geometry, x);
  for_each_pair_kind([&](auto kind) {
    std::vector<Contact> found = classify_all(classifier, kind, candidates[kind], pool);
    if (kind == PairKind::PointTriangle && !geometry.face.empty())
      keep_nearest_of_faces(geometry.face, found);
    if (out.empty())
      out = std::move(found);
    else
      out.insert(out.end(), found.begin(), found.end());
  });
}

ContactSet::ContactSet(const std::array<std::shared_ptr<const Potential>, kStencilKindCount>& barriers,
                       ThreadPool& pool)
    : pool_(pool), contact_of_(kStencilKindCount) {
  for (const auto& barrier : barriers) {
    const PotentialBatch& batch = batches_.emplace_back(barrier);
    const bool is_mollified = batches_.size() > static_cast<size_t>(StencilKind::MollifiedPointPoint);
    fields_.push_back({batch.field_index("stiffness"), batch.field_index("contact_distance"),
                       batch.field_index("least_distance"),
                       is_mollified ? batch.field_index("parallel_threshold") : -1});
  }
}

void ContactSet::reset(std::vector<Contact> contacts) {
  contacts_ = std::move(contacts);
  std::vector<std::vector<int32_t>> stencils(kStencilKindCount);
  for (auto& numbers : contact_of_) numbers.clear();
  for (size_t c = 0; c < contacts_.size(); ++c) {
    const auto kind = static_cast<size_t>(contacts_[c].kind);
    const auto sites = contacts_[c].sites.begin();
    stencils[kind].insert(stencils[kind].end(), sites, sites + contacts_[c].point_count);
    contact_of_[kind].push_back(static_cast<int64_t>(c));
  }
  for (int kind = 0; kind < kStencilKindCount; ++kind) {
    batches_[kind].resize(stencils[kind]);
    pool_.for_each_range(batches_[kind].size(), kContactsPerTask, [&](int64_t begin, int64_t end) {
      for (int64_t e = begin; e < end; ++e) set_fields(kind, e);
    });
  }
}

void ContactSet::set_fields(int kind, int64_t e) {
  const Contact& contact = contacts_[contact_of_[kind][e]];
  PotentialBatch& batch = batches_[kind];
  const Fields& fields = fields_[kind];
  const double weighted = contact.stiffness * weight_;
  batch.set(fields.stiffness, e, {&weighted, 1});
  batch.set(fields.distance, e, {&contact.contact_distance, 1});
  batch.set(fields.least_distance, e, {&contact.least_distance, 1});
  if (fields.parallel_threshold >= 0)
    batch.set(fields.parallel_threshold, e, {&contact.parallel_threshold, 1});
}

void ContactSet::swap(ContactSet& other) {
  std::swap_ranges(batches_.begin(), batches_.end(), other.batches_.begin());
  contact_of_.swap(other.contact_of_);
  contacts_.swap(other.contacts_);
  energies_.swap(other.energies_);
  std::swap(weight_, other.weight_);
}

std::vector<const PotentialBatch*> ContactSet::batches() const {
  std::vector<const PotentialBatch*> result;
  result.reserve(batches_.size());
  for (const PotentialBatch& batch : batches_)
    if (batch.size() > 0) result.push_back(&batch);
  return result;
}

const std::vector<double>& ContactSet::evaluate_energies(std::span<const Vec3> x) {
  energies_.assign(contacts_.size(), 0.0);
  for (int kind = 0; kind < kStencilKindCount; ++kind) {
    const PotentialBatch& batch = batches_[kind];
    if (batch.size() == 0) continue;
    const AlignedVector<double> out = lane_outputs(batch, Order::Energy, x, &pool_);
    for (int64_t e = 0; e < batch.size(); ++e) energies_[contact_of_[kind][e]] = out[e];
  }
  return energies_;
}

void ContactSet::evaluate_forces(std::span<const Vec3> x, std::vector<Vec3>& out_forces) const {
  out_forces.assign(contacts_.size(), Vec3{});
  for (int kind = 0; kind < kStencilKindCount; ++kind) {
    const PotentialBatch& batch = batches_[kind];
    if (batch.size() == 0) continue;
    const int outputs = batch.potential().kernel().output_count(Order::Gradient);
    const AlignedVector<double> out = lane_outputs(batch, Order::Gradient, x, &pool_);
    for (int64_t e = 0; e < batch.size(); ++e) {
      const int64_t c = contact_of_[kind][e];
      const double* lane = out.data() + (e / kLanes) * outputs * kLanes + e % kLanes;
      for (int p = 0; p < contacts_[c].side_a_count; ++p)
        for (int a = 0; a < 3; ++a) out_forces[c][a] -= lane[(1 + 3 * p + a) * kLanes] / weight_;
    }
  }
}

EnergyDifference energy_difference(const ContactSet& a, const ContactSet& b) {
  const auto &ca = a.contacts(), &cb = b.contacts();
  const auto &ea = a.energies(), &eb = b.energies();
  EnergyDifference total;
  size_t i = 0, j = 0;
  while (i < ca.size() || j < cb.size()) {
    const bool take_a = j == cb.size() || (i < ca.size() && ca[i].key <= cb[j].key);
    const bool take_b = i == ca.size() || (j < cb.size() && cb[j].key <= ca[i].key);
    const double energy_a = take_a ? ea[i++] : 0.0, energy_b = take_b ? eb[j++] : 0.0;
    total.difference += energy_b - energy_a;
    total.magnitude += std::fabs(energy_a);
  }
  return total;
}

}  // namespace stark
