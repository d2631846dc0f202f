#include <stark/contact/closest_features.h>

#include <algorithm>
#include <cmath>
#include <map>

#include <stark/geometry/distance.h>

namespace stark {

namespace {

constexpr uint8_t kOther = 4;  ///< list of contacts that no cell is left to name

Index2 sorted(int32_t a, int32_t b) { return a < b ? Index2{a, b} : Index2{b, a}; }

/// Sites of a closest feature, ascending, -1 where there are fewer than three.
using Feature = std::array<int32_t, 3>;

Feature feature_of(const Contact& contact) {
  Feature feature{-1, -1, -1};
  std::copy(contact.sites.begin() + 1, contact.sites.begin() + contact.point_count, feature.begin());
  std::sort(feature.begin(), feature.begin() + (contact.point_count - 1));
  return feature;
}

struct Term {
  Feature feature;
  Contact contact;             ///< with its multiplicity
  std::vector<int32_t> cells;  ///< that have this closest feature
};

/// The contacts of one point with the cells of one body.
class PointContacts {
 public:
  PointContacts(const ContactGeometry& geometry, const SurfaceCells& cells, std::span<const PairKey> names,
                std::span<const Vec3> x, std::span<const Contact> raw)
      : geometry_(geometry), cells_(cells), names_(names), x_(x), raw_(raw) {}

  void append_to(std::vector<Contact>& out) {
    for (const Contact& contact : raw_) add(contact, 1);
    count_edges_and_vertices();
    for (const auto& [edge, count] : edge_count_)
      if (count != 1) add_edge(edge, 1 - count);
    for (const auto& [vertex, coefficient] : vertex_coefficient_)
      if (coefficient != 0) add_vertex(vertex, coefficient);
    std::erase_if(terms_, [](const Term& term) { return term.contact.multiplicity == 0; });
    name();
    for (const Term& term : terms_) out.push_back(term.contact);
  }

 private:
  bool on_triangles() const { return raw_.front().key.list == 0; }
  int32_t point() const { return raw_.front().key.first; }

  void add(Contact contact, int32_t multiplicity) {
    const Feature feature = feature_of(contact);
    auto term = std::ranges::find(terms_, feature, &Term::feature);
    if (term == terms_.end()) {
      // Edges point the same way from whichever cell they come, so that terms that cancel do so in every bit.
      if (contact.point_count == 3 && contact.sites[1] > contact.sites[2]) {
        std::swap(contact.sites[1], contact.sites[2]);
        std::swap(contact.weights[1], contact.weights[2]);
      }
      contact.multiplicity = 0;
      terms_.push_back({feature, contact, {}});
      term = terms_.end() - 1;
    }
    term->contact.multiplicity += multiplicity;
    if (multiplicity > 0 && contact.key.list != kOther) term->cells.push_back(contact.key.second);
  }

  /// Vertex coefficients: 1 minus those of its cells and of its edges.
  void count_edges_and_vertices() {
    for (const Contact& contact : raw_) {
      if (!on_triangles()) {
        for (const int32_t v : geometry_.mesh->edges[contact.key.second])
          --vertex_coefficient_.try_emplace(v, 1).first->second;
        continue;
      }
      std::vector<int32_t> vertices;
      for (const Index2& edge : cells_.edges(contact.key.second)) {
        ++edge_count_[edge];
        vertices.insert(vertices.end(), edge.begin(), edge.end());
      }
      std::ranges::sort(vertices);
      vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
      for (const int32_t v : vertices) --vertex_coefficient_.try_emplace(v, 1).first->second;
    }
    for (const auto& [edge, count] : edge_count_)
      for (const int32_t v : edge) vertex_coefficient_[v] -= 1 - count;
  }

  Contact other(double squared_distance) const {
    Contact contact = raw_.front();
    contact.key.list = kOther;
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

  // Names: keys that stay the same while a point slides.

  bool is_taken(int32_t cell) const {
    return std::ranges::any_of(terms_, [&](const Term& t) {
      return t.contact.key.list == raw_.front().key.list && t.contact.key.second == cell;
    });
  }

  bool is_known(int32_t cell) const {
    return std::ranges::binary_search(names_, PairKey{raw_.front().key.list, point(), cell});
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
    term.contact.key = {raw_.front().key.list, point(), cell};
    return true;
  }

  void name() {
    for (Term& term : terms_) term.contact.key = {kOther, point(), -1};
    std::vector<Term*> open;  // those that push, nearest first
    for (Term& term : terms_) {
      std::ranges::sort(term.cells);
      if (term.contact.multiplicity > 0) open.push_back(&term);
    }
    std::ranges::stable_sort(open, {}, [](const Term* t) { return t->contact.distance; });
    const auto take_first = [&](const auto& cells_of, const auto& accept) {
      std::erase_if(open, [&](Term* term) {
        for (const int32_t cell : cells_of(*term))
          if (accept(*term, cell) && take(*term, cell)) return true;
        return false;
      });
    };
    const auto own = [](const Term& term) { return term.cells; };
    take_first(own, [&](const Term&, int32_t cell) { return is_known(cell); });
    if (!open.empty() && !names_.empty()) {
      const std::vector<int32_t> known = known_cells();
      take_first([&](const Term&) { return known; },
                 [&](const Term& term, int32_t cell) { return touches(cell, term); });
    }
    take_first(own, [](const Term&, int32_t) { return true; });
    int32_t ordinal = 0;
    for (Term& term : terms_)
      if (term.contact.key.list == kOther)
        // Unique among all bodies that the point touches.
        term.contact.key.second = (raw_.front().group_b << 8) + ordinal++;
  }

  /// Cells of this body that the point was known to touch.
  std::vector<int32_t> known_cells() const {
    std::vector<int32_t> known;
    const uint8_t list = raw_.front().key.list;
    for (auto n = std::ranges::lower_bound(names_, PairKey{list, point(), 0});
         n != names_.end() && n->list == list && n->first == point(); ++n) {
      const SurfaceMesh& mesh = *geometry_.mesh;
      const int32_t group = list == 0 ? mesh.triangle_group[n->second] : mesh.edge_group[n->second];
      if (group == raw_.front().group_b) known.push_back(n->second);
    }
    return known;
  }

  const ContactGeometry& geometry_;
  const SurfaceCells& cells_;
  std::span<const PairKey> names_;
  std::span<const Vec3> x_;
  std::span<const Contact> raw_;
  std::vector<Term> terms_;
  std::map<Index2, int32_t> edge_count_;
  std::map<int32_t, int32_t> vertex_coefficient_;
};

/// Whether no force moves any vertex of the pair of primitives.
bool is_prescribed(const ContactGeometry& geometry, const PairKey& key) {
  const SurfaceMesh& mesh = *geometry.mesh;
  const auto fixed = [&](const auto& sites) {
    return std::ranges::all_of(sites, [&](int32_t v) { return geometry.prescribed[v] != 0; });
  };
  if (key.list == 1) return fixed(mesh.edges[key.first]) && fixed(mesh.edges[key.second]);
  if (!geometry.prescribed[key.first]) return false;
  if (key.list == 0) return fixed(mesh.triangles[key.second]);
  if (key.list == 2) return fixed(mesh.edges[key.second]);
  return geometry.prescribed[key.second] != 0;
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
      const bool is_inner = (e > 0 && edges[e - 1] == edges[e]) ||
                            (e + 1 < edges.size() && edges[e + 1] == edges[e]);
      if (!is_inner) edges_.push_back(edges[e]);
    }
    offsets_.push_back(static_cast<int32_t>(edges_.size()));
  }
}

void merge_by_feature(const ContactGeometry& geometry, const SurfaceCells& cells,
                      std::span<const PairKey> names, std::span<const Vec3> x,
                      std::vector<Contact>& contacts) {
  if (!geometry.prescribed.empty())
    std::erase_if(contacts, [&](const Contact& c) { return is_prescribed(geometry, c.key); });
  std::vector<Contact> merged;
  merged.reserve(contacts.size());
  const auto same_surface = [](const Contact& a, const Contact& b) {
    return a.key.list == b.key.list && a.key.first == b.key.first && a.group_b == b.group_b;
  };
  for (size_t i = 0, end = 0; i < contacts.size(); i = end) {
    end = i + 1;
    if (contacts[i].key.list != 0 && contacts[i].key.list != 2) {
      merged.push_back(contacts[i]);
      continue;
    }
    while (end < contacts.size() && same_surface(contacts[i], contacts[end])) ++end;
    const bool is_named = names.empty() || std::ranges::binary_search(names, contacts[i].key);
    if (end == i + 1 && is_named) {  // one cell in range: nothing to take away
      merged.push_back(contacts[i]);
      continue;
    }
    PointContacts(geometry, cells, names, x, std::span(contacts).subspan(i, end - i)).append_to(merged);
  }
  contacts = std::move(merged);
  std::ranges::stable_sort(contacts, {}, &Contact::key);
}

}  // namespace stark
