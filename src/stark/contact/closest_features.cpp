#include <stark/contact/closest_features.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <utility>

#include <stark/geometry/distance.h>

namespace stark {

namespace {

/// Distance between closest points over the contact distance below which they are one.
constexpr double kSamePlace = 1e-8;

constexpr size_t kContactsPerTask = 512;

/// Mollifier of a pair of edges below which it has no energy worth a stencil. Its torque goes with the square
/// root: at 1e-9 some micronewtons appear and vanish where edges lie exactly above each other, as those of a
/// gripper on a grid of cloth, which no step of Newton's method gets over.
constexpr double kParallel = 1e-18;

/// Sites of a closest feature, descending, -1 where there are fewer than three.
using Feature = std::array<int32_t, 3>;

Feature feature_of(const Contact& contact) {
  Feature feature{-1, -1, -1};
  std::copy(contact.sites.begin() + 1, contact.sites.begin() + contact.point_count, feature.begin());
  std::ranges::sort(feature, std::ranges::greater{});
  return feature;
}

/// Comparing arrays calls memcmp, which takes longer than three integers do.
bool are_same(const Feature& a, const Feature& b) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

/// In the order of edges, for the same reason.
int64_t rank(const Index2& edge) {
  return static_cast<int64_t>(edge[0]) << 32 | static_cast<uint32_t>(edge[1]);
}

struct Term {
  Feature feature;
  Contact contact;             ///< with its multiplicity
  std::vector<int32_t> cells;  ///< that have this closest feature
  Vec3 place;                  ///< of the closest point [m]
};

/// What becomes of some contacts: those that cells name, and those beside them.
struct Merged {
  std::vector<Contact> named, other;

  void add(const Contact& contact) {
    (contact.key.kind == PairKey::kOther ? other : named).push_back(contact);
  }
};

/// A vertex with a part of its coefficient.
struct Corner {
  int32_t vertex, part;
};

/// Insertion: they are few, and std::stable_sort takes memory.
template <typename T, typename Less>
void sort_stably(std::vector<T>& values, Less less) {
  for (size_t i = 1; i < values.size(); ++i)
    for (size_t j = i; j > 0 && less(values[j], values[j - 1]); --j) std::swap(values[j], values[j - 1]);
}

/// The contacts of a point with the cells of a body. Used for one after the other.
class PointContacts {
 public:
  PointContacts(const ContactGeometry& geometry, const SurfaceCells& cells, std::span<const PairKey> names,
                std::span<const Vec3> x)
      : geometry_(geometry), cells_(cells), names_(names), x_(x) {}

  /// Merges the contacts of one point with one body.
  void append_to(std::span<const Contact> raw, Merged& out) {
    raw_ = raw;
    term_count_ = 0;
    all_edges_.clear();
    corners_.clear();
    edges_.clear();
    vertices_.clear();
    known_ = names_of_point();
    for (const Contact& contact : raw_) add(contact, 1);
    count_edges_and_vertices();
    for (const auto& [edge, coefficient] : edges_) add_edge(edge, coefficient);
    for (const auto& [vertex, coefficient] : vertices_) add_vertex(vertex, coefficient);
    sort_by_point_count();
    join_places();
    std::erase_if(order_, [](const Term* term) { return term->contact.multiplicity == 0; });
    name();
    for (const Term* term : order_) out.add(term->contact);
  }

 private:
  bool on_triangles() const { return raw_.front().key.kind == PairKind::PointTriangle; }
  int32_t point() const { return raw_.front().key.first; }

  Term& term_of(const Contact& contact) {
    const Feature feature = feature_of(contact);
    for (size_t t = 0; t < term_count_; ++t)
      if (are_same(terms_[t].feature, feature)) return terms_[t];
    if (term_count_ == terms_.size()) terms_.emplace_back();  // they stay, for their memory
    Term& term = terms_[term_count_++];
    term.feature = feature;
    term.contact = contact;
    term.contact.multiplicity = 0;
    term.cells.clear();
    // Edges point the same way from whichever cell they come, so that terms that cancel do so in every bit.
    if (contact.point_count == 3 && contact.sites[1] > contact.sites[2]) {
      std::swap(term.contact.sites[1], term.contact.sites[2]);
      std::swap(term.contact.weights[1], term.contact.weights[2]);
    }
    return term;
  }

  void add(const Contact& contact, int32_t multiplicity) {
    Term& term = term_of(contact);
    term.contact.multiplicity += multiplicity;
    if (multiplicity > 0 && contact.key.kind != PairKey::kOther) term.cells.push_back(contact.key.second);
  }

  /// Edges with the number of their cells; vertices with their coefficients, 1 minus those of the cells and
  /// edges that meet there.
  void count_edges_and_vertices() {
    for (const Contact& contact : raw_) {
      const size_t first = corners_.size();
      if (!on_triangles()) {
        for (const int32_t v : geometry_.mesh->edges[contact.key.second]) corners_.push_back({v, -1});
        continue;
      }
      for (const Index2& edge : cells_.edges(contact.key.second)) {
        all_edges_.push_back(edge);
        for (const int32_t v : edge) {
          const auto of_cell =
              std::ranges::subrange(corners_.begin() + static_cast<ptrdiff_t>(first), corners_.end());
          if (std::ranges::find(of_cell, v, &Corner::vertex) == of_cell.end()) corners_.push_back({v, -1});
        }
      }
    }
    std::ranges::sort(all_edges_, {}, rank);
    for (size_t e = 0, end = 0; e < all_edges_.size(); e = end) {
      while (end < all_edges_.size() && rank(all_edges_[end]) == rank(all_edges_[e])) ++end;
      const int32_t coefficient = 1 - static_cast<int32_t>(end - e);
      if (coefficient == 0) continue;
      edges_.push_back({all_edges_[e], coefficient});
      for (const int32_t v : all_edges_[e]) corners_.push_back({v, -coefficient});
    }
    std::ranges::sort(corners_, {}, &Corner::vertex);
    for (size_t c = 0, end = 0; c < corners_.size(); c = end) {
      int32_t coefficient = 1;
      for (; end < corners_.size() && corners_[end].vertex == corners_[c].vertex; ++end)
        coefficient += corners_[end].part;
      if (coefficient != 0) vertices_.push_back({corners_[c].vertex, coefficient});
    }
  }

  Contact other(double squared_distance) const {
    Contact contact = raw_.front();
    contact.key.kind = PairKey::kOther;
    contact.distance = std::sqrt(squared_distance);
    return contact;
  }

  void add_edge(const Index2& e, int32_t coefficient) {
    const Vec3& p = x_[point()];
    const auto type = point_edge_type(p, x_[e[0]], x_[e[1]]);
    if (type != PointEdgeType::P_E) {
      add_vertex(e[type == PointEdgeType::P_E0 ? 0 : 1], coefficient);
      return;
    }
    const double squared = point_edge_squared_distance(p, x_[e[0]], x_[e[1]], type);
    Contact contact = other(squared);
    if (!(contact.distance < contact.contact_distance)) return;
    const auto w = point_edge_weights(p, x_[e[0]], x_[e[1]], type);
    contact.kind = StencilKind::PointEdge;
    contact.point_count = 3;
    contact.sites = {point(), e[0], e[1]};
    contact.weights = {1.0, -w[0], -w[1]};
    add(contact, coefficient);
  }

  void add_vertex(int32_t v, int32_t coefficient) {
    Contact contact = other(squared_norm(x_[point()] - x_[v]));
    if (!(contact.distance < contact.contact_distance)) return;
    contact.kind = StencilKind::PointPoint;
    contact.point_count = 2;
    contact.sites = {point(), v};
    contact.weights = {1.0, -1.0};
    add(contact, coefficient);
  }

  Vec3 place(const Contact& contact) const {
    Vec3 at;
    for (int p = 1; p < contact.point_count; ++p) at -= x_[contact.sites[p]] * contact.weights[p];
    return at;
  }

  /// The terms of the largest features first.
  void sort_by_point_count() {
    order_.clear();
    for (int count = 4; count >= 2; --count)
      for (size_t t = 0; t < term_count_; ++t)
        if (terms_[t].contact.point_count == count) order_.push_back(&terms_[t]);
  }

  /// A point above a vertex or an edge is above what rounding makes of it, and above something else for each
  /// cell: such terms are one, of the largest feature.
  void join_places() {
    for (Term* term : order_) term->place = place(term->contact);
    for (size_t i = 0; i < order_.size(); ++i)
      for (size_t j = i + 1; j < order_.size(); ++j) {
        Term &a = *order_[i], &b = *order_[j];
        if (a.contact.multiplicity == 0) break;
        if (b.contact.multiplicity == 0) continue;
        if (norm(a.place - b.place) > kSamePlace * a.contact.contact_distance) continue;
        a.contact.multiplicity += std::exchange(b.contact.multiplicity, 0);
        a.cells.insert(a.cells.end(), b.cells.begin(), b.cells.end());
      }
  }

  // Names: keys that stay the same while a point slides.

  bool is_taken(int32_t cell) const {
    return std::ranges::any_of(order_, [&](const Term* t) {
      return t->contact.key.kind == raw_.front().key.kind && t->contact.key.second == cell;
    });
  }

  bool is_known(int32_t cell) const { return std::ranges::binary_search(known_, cell, {}, &PairKey::second); }

  /// Those of the point with cells of all bodies.
  std::span<const PairKey> names_of_point() const {
    const auto of_point = [&](const PairKey& key) { return std::pair(key.kind, key.first); };
    const auto found =
        std::ranges::equal_range(names_, std::pair(raw_.front().key.kind, point()), {}, of_point);
    return {found.begin(), found.end()};
  }

  bool touches(int32_t cell, const Term& term) const {
    const auto has = [&](int32_t v) {
      for (const int32_t own : term.cells) {
        if (!on_triangles() && std::ranges::count(geometry_.mesh->edges[own], v) > 0) return true;
        if (on_triangles())
          for (const Index2& edge : cells_.edges(own))
            if (edge[0] == v || edge[1] == v) return true;
      }
      return false;
    };
    if (!on_triangles()) return std::ranges::any_of(geometry_.mesh->edges[cell], has);
    return std::ranges::any_of(cells_.edges(cell), [&](const Index2& e) { return has(e[0]) || has(e[1]); });
  }

  bool take(Term& term, int32_t cell) {
    if (is_taken(cell)) return false;
    term.contact.key = {raw_.front().key.kind, point(), cell};
    return true;
  }

  void name() {
    open_.clear();  // those that push, nearest first
    for (Term* term : order_) {
      term->contact.key = {PairKey::kOther, point(), -1};
      std::ranges::sort(term->cells);
      if (term->contact.multiplicity > 0) open_.push_back(term);
    }
    sort_stably(open_,
                [](const Term* a, const Term* b) { return a->contact.distance < b->contact.distance; });
    const auto take_first = [&](const auto& cells_of, const auto& accept) {
      std::erase_if(open_, [&](Term* term) {
        for (const int32_t cell : cells_of(*term))
          if (accept(*term, cell) && take(*term, cell)) return true;
        return false;
      });
    };
    const auto own = [](const Term& term) -> std::span<const int32_t> { return term.cells; };
    take_first(own, [&](const Term&, int32_t cell) { return is_known(cell); });
    if (!open_.empty() && !known_.empty()) {
      const std::vector<int32_t> known = known_cells();
      take_first([&](const Term&) -> std::span<const int32_t> { return known; },
                 [&](const Term& term, int32_t cell) { return touches(cell, term); });
    }
    take_first(own, [](const Term&, int32_t) { return true; });
    int32_t ordinal = 0;
    for (Term* term : order_)
      if (term->contact.key.kind == PairKey::kOther)
        // Unique among all bodies that the point touches.
        term->contact.key.second = (raw_.front().group_b << 8) + ordinal++;
  }

  /// Cells of this body that the point was known to touch.
  std::vector<int32_t> known_cells() const {
    std::vector<int32_t> known;
    const PairKind kind = raw_.front().key.kind;
    const auto& groups = groups_of(*geometry_.mesh, second_kind(kind));
    for (const PairKey& name : known_)
      if (groups[name.second] == raw_.front().group_b) known.push_back(name.second);
    return known;
  }

  const ContactGeometry& geometry_;
  const SurfaceCells& cells_;
  std::span<const PairKey> names_;
  std::span<const Vec3> x_;
  std::span<const Contact> raw_;
  std::span<const PairKey> known_;  ///< names of the point
  std::deque<Term> terms_;          ///< the first term_count_ are used
  size_t term_count_ = 0;
  std::vector<Term*> order_, open_;  ///< those that are left; those without a name
  std::vector<Index2> all_edges_;    ///< one by one
  std::vector<Corner> corners_;
  std::vector<std::pair<Index2, int32_t>> edges_;      ///< with coefficients other than 0
  std::vector<std::pair<int32_t, int32_t>> vertices_;  ///< the same
};

/// Whether no force moves any vertex of the pair of primitives.
bool is_prescribed(const ContactGeometry& geometry, const PairKey& key) {
  const auto fixed = [&](PrimitiveKind kind, int32_t id) {
    return std::ranges::all_of(vertices_of(*geometry.mesh, kind, id),
                               [&](int32_t v) { return geometry.prescribed[v] != 0; });
  };
  return fixed(first_kind(key.kind), key.first) && fixed(second_kind(key.kind), key.second);
}

/// Contacts of a point with one body, which are merged together.
bool is_of_surface(const Contact& contact) {
  return contact.key.kind == PairKind::PointTriangle || contact.key.kind == PairKind::PointEdge;
}
bool are_of_same_surface(const Contact& a, const Contact& b) {
  return is_of_surface(a) && a.key.kind == b.key.kind && a.key.first == b.key.first && a.group_b == b.group_b;
}

void sort_by_key(std::vector<Contact>& contacts) {
  if (!std::ranges::is_sorted(contacts, {}, &Contact::key))  // a sort takes memory
    std::ranges::stable_sort(contacts, {}, &Contact::key);
}

/// Merges the contacts of a range that has all or none of a point with a body.
void merge_range(const ContactGeometry& geometry, std::span<const PairKey> names,
                 std::span<const Contact> near, PointContacts& merger, Merged& out) {
  std::vector<Contact> group;
  for (size_t i = 0; i < near.size();) {
    group.clear();
    const size_t first = i;
    do {
      if (geometry.prescribed.empty() || !is_prescribed(geometry, near[i].key)) group.push_back(near[i]);
    } while (++i < near.size() && are_of_same_surface(near[first], near[i]));
    if (group.empty()) continue;
    // Of one cell in range there is nothing to take away.
    const auto is_named = [&] { return names.empty() || std::ranges::binary_search(names, group[0].key); };
    if (!is_of_surface(group[0]) || (group.size() == 1 && is_named()))
      out.named.push_back(group[0]);
    else
      merger.append_to(group, out);
  }
  sort_by_key(out.named);
}

/// One after the other.
std::vector<Contact> joined(std::vector<Merged>& parts) {
  size_t count = 0;
  for (const Merged& part : parts) count += part.named.size() + part.other.size();
  std::vector<Contact> all = std::move(parts.front().named), other = std::move(parts.front().other);
  all.reserve(count);
  for (size_t k = 1; k < parts.size(); ++k) {
    all.insert(all.end(), parts[k].named.begin(), parts[k].named.end());
    other.insert(other.end(), parts[k].other.begin(), parts[k].other.end());
  }
  sort_by_key(other);
  all.insert(all.end(), other.begin(), other.end());
  sort_by_key(all);
  return all;
}

}  // namespace

SurfaceCells::SurfaceCells(const SurfaceMesh& mesh, std::span<const int32_t> face) {
  const auto triangle_count = static_cast<int32_t>(mesh.triangles.size());
  std::vector<std::vector<Index2>> of_cell(mesh.triangles.size());
  for (int32_t t = 0; t < triangle_count; ++t)
    for (int k = 0; k < 3; ++k)
      of_cell[face.empty() ? t : face[t]].push_back(
          sorted(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]));
  offsets_.push_back(0);
  for (std::vector<Index2>& edges : of_cell) {
    std::ranges::sort(edges);
    for (size_t e = 0; e < edges.size(); ++e) {
      const bool is_inner =
          (e > 0 && edges[e - 1] == edges[e]) || (e + 1 < edges.size() && edges[e + 1] == edges[e]);
      if (!is_inner) edges_.push_back(edges[e]);
    }
    offsets_.push_back(static_cast<int32_t>(edges_.size()));
  }
}

namespace {

/// Takes a closest point of an edge that is all but at an end as that end: which one rounding finds depends
/// on the edge.
void snap_to_ends(std::span<const Vec3> x, Contact& contact) {
  const auto at_end = [&](int i) {
    const double length = norm(x[contact.sites[i + 1]] - x[contact.sites[i]]);
    for (int k = 0; k < 2; ++k)
      if (std::fabs(contact.weights[i + 1 - k]) * length < kSamePlace * contact.contact_distance) return k;
    return -1;
  };
  if (contact.kind == StencilKind::EdgeEdge) {
    const int a = at_end(0), b = at_end(2);
    if (a < 0 && b < 0) return;
    if (a < 0) {  // the point comes first
      std::swap(contact.group_a, contact.group_b);
      contact.sites = {contact.sites[2 + b], contact.sites[0], contact.sites[1], 0};
      contact.weights = {1.0, -contact.weights[0], -contact.weights[1], 0.0};
    } else {
      contact.sites = {contact.sites[a], contact.sites[2], contact.sites[3], 0};
      contact.weights = {1.0, contact.weights[2], contact.weights[3], 0.0};
    }
    contact.kind = StencilKind::PointEdge;
    contact.point_count = 3;
    contact.side_a_count = 1;
  }
  if (contact.kind != StencilKind::PointEdge) return;
  const int end = at_end(1);
  if (end < 0) return;
  contact.kind = StencilKind::PointPoint;
  contact.point_count = 2;
  contact.sites = {contact.sites[0], contact.sites[1 + end], 0, 0};
  contact.weights = {1.0, -1.0, 0.0, 0.0};
}

bool is_mollified(const Contact& contact) { return contact.kind >= StencilKind::MollifiedPointPoint; }

/// Mollified pairs of edges without energy.
bool is_parallel(std::span<const Vec3> x, const Contact& contact) {
  const auto& s = contact.sites;
  return squared_norm(cross(x[s[1]] - x[s[0]], x[s[3]] - x[s[2]])) < kParallel * contact.parallel_threshold;
}

/// Sites in an order that does not tell by which edges they were found.
std::array<int32_t, 4> stencil_of(const Contact& contact) {
  std::array<int32_t, 4> stencil{-1, -1, -1, -1};
  std::copy_n(contact.sites.begin(), contact.point_count, stencil.begin());
  if (contact.point_count == 3 && stencil[1] > stencil[2]) std::swap(stencil[1], stencil[2]);
  // Of two vertices either may come first.
  if (contact.point_count == 2 && stencil[0] > stencil[1]) std::swap(stencil[0], stencil[1]);
  return stencil;
}

}  // namespace

void merge_equal_stencils(std::span<const Vec3> x, std::vector<Contact>& contacts) {
  std::map<std::pair<std::array<int32_t, 4>, double>, size_t> known;
  size_t count = 0;
  for (Contact& contact : contacts) {
    if (contact.key.kind == PairKind::EdgeEdge && is_mollified(contact) && is_parallel(x, contact)) continue;
    if (contact.key.kind == PairKind::EdgeEdge && !is_mollified(contact)) {
      snap_to_ends(x, contact);
      if (contact.kind != StencilKind::EdgeEdge) {
        const auto [entry, is_new] =
            known.try_emplace({stencil_of(contact), contact.contact_distance}, count);
        if (!is_new) {
          contacts[entry->second].stiffness += contact.stiffness;
          continue;
        }
      }
    }
    contacts[count++] = contact;
  }
  contacts.resize(count);
}

std::vector<Contact> merge_by_feature(const ContactGeometry& geometry, const SurfaceCells& cells,
                                      std::span<const PairKey> names, std::span<const Vec3> x,
                                      std::span<const Contact> near, ThreadPool& pool) {
  std::vector<PointContacts> mergers(pool.thread_count(), PointContacts(geometry, cells, names, x));
  const auto tasks = static_cast<int64_t>(near.size() / kContactsPerTask + 1);
  // Tasks end where the contacts of a point with a body do.
  const auto begin_of = [&](int64_t task) {
    size_t at = std::min(task * kContactsPerTask, near.size());
    while (task > 0 && at < near.size() && are_of_same_surface(near[at - 1], near[at])) ++at;
    return at;
  };
  std::vector<Merged> parts(tasks);
  pool.for_each_task(tasks, [&](int64_t task, int thread) {
    const size_t begin = begin_of(task), end = begin_of(task + 1);
    merge_range(geometry, names, near.subspan(begin, end - begin), mergers[thread], parts[task]);
  });
  return joined(parts);
}

}  // namespace stark
