#include <stark/contact/area_weights.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include <stark/base/bucket_sort.h>
#include <stark/geometry/edge_lookup.h>
#include <stark/geometry/topology.h>

namespace stark {

namespace {

/// Least part of the contact that a vertex of a flat surface has: a barrier, and next to no pressure.
constexpr double kFlatWeight = 0.002;

/// Sharpness of the border of a sheet: it may be met edge-on, but lies flat on another more often.
constexpr double kSheetBorder = 0.5;

/// Least part of a share that faces any normal: an edge of a sheet has no area across it.
constexpr double kSmallestFacing = 0.1;

/// Length of the vector area of a vertex over its area: 1 flat; sharp from here on, the corner of a box.
constexpr double kSharpVertex = 0.6;

Vec3 area_vector(const Index3& t, std::span<const Vec3> x) {
  return cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]) * 0.5;
}

/// A flat face, or a triangle of its own.
struct Patch {
  std::span<const int32_t> triangles;
  double area = 0.0;
  int32_t largest = -1;  ///< triangle that tells the normal
};

Patch measure(std::span<const int32_t> triangles, const SurfaceMesh& mesh, std::span<const Vec3> rest) {
  Patch patch{triangles};
  double largest = -1.0;
  for (const int32_t t : triangles) {
    const double area = norm(area_vector(mesh.triangles[t], rest));
    patch.area += area;
    if (area > largest) {
      largest = area;
      patch.largest = t;
    }
  }
  return patch;
}

/// Calls body(patch) for each, in the order of their lowest triangles.
template <typename Body>
void for_each_patch(const SurfaceMesh& mesh, std::span<const Vec3> rest, std::span<const int32_t> patch,
                    Body&& body) {
  const auto patch_of = [&](int32_t t) { return patch.empty() ? t : patch[t]; };
  std::vector<int32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0);
  bucket_sort(order, patch_of, std::less());
  for (size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && patch_of(order[end]) == patch_of(order[begin])) ++end;
    body(measure(std::span(order).subspan(begin, end - begin), mesh, rest));
  }
}

/// Edges with their lengths.
using Border = std::vector<std::pair<Index2, double>>;

Border find_border(const Patch& patch, const SurfaceMesh& mesh, std::span<const Vec3> rest) {
  std::vector<Index3> triangles;
  for (const int32_t t : patch.triangles) triangles.push_back(mesh.triangles[t]);
  Border border;
  for (const auto& [a, b] : find_boundary_edges(triangles))
    border.push_back({sorted(a, b), norm(rest[b] - rest[a])});
  return border;
}

std::set<int32_t> vertices_of(const Border& border) {
  std::set<int32_t> vertices;
  for (const auto& [edge, length] : border) vertices.insert(edge.begin(), edge.end());
  return vertices;
}

/// Area of each vertex of a patch of several triangles with vertices inside that may touch: a third of those
/// of its triangles. Empty if there are none.
std::map<int32_t, double> areas_inside(const Patch& patch, const SurfaceMesh& mesh,
                                       std::span<const Vec3> rest, const std::set<int32_t>& on_border,
                                       const std::vector<bool>& is_left_out) {
  if (patch.triangles.size() == 1) return {};
  std::map<int32_t, double> areas;
  bool has_inside = false;
  for (const int32_t t : patch.triangles)
    for (const int32_t v : mesh.triangles[t]) {
      areas[v] += norm(area_vector(mesh.triangles[t], rest)) / 3.0;
      has_inside = has_inside || (!on_border.contains(v) && !is_left_out[v]);
    }
  return has_inside ? areas : std::map<int32_t, double>{};
}

}  // namespace

AreaWeights::AreaWeights(const SurfaceMesh& mesh, std::span<const Vec3> rest, std::span<const int32_t> patch,
                         std::span<const uint8_t> is_sheet, std::span<const double> group_distance)
    : is_sheet_(is_sheet.begin(), is_sheet.end()) {
  vertices_.whole.assign(mesh.vertex_count, 0.0);
  edges_.whole.assign(mesh.edges.size(), 0.0);
  share_triangles(mesh, rest, patch);
  share_rods(mesh, rest, group_distance);
  weigh(mesh, rest);
}

void AreaWeights::share_triangles(const SurfaceMesh& mesh, std::span<const Vec3> rest,
                                  std::span<const int32_t> patch) {
  const EdgeLookup edges(mesh.edges);
  std::vector<std::pair<int32_t, Share>> of_vertices, of_edges;
  const int32_t groups = mesh.triangle_group.empty() ? 0 : *std::ranges::max_element(mesh.triangle_group) + 1;
  std::vector<double> total(groups, 0.0);
  cell_area_.assign(groups, 0.0);
  std::vector<bool> is_left_out(mesh.vertex_count, false);
  for (const int32_t v : mesh.inner) is_left_out[v] = true;
  for_each_patch(mesh, rest, patch, [&](const Patch& p) {
    const Border border = find_border(p, mesh, rest);
    double length = 0.0;
    for (const auto& [edge, l] : border) length += l;
    const bool is_triangle = p.triangles.size() == 1;
    const std::set<int32_t> on_border = is_triangle ? std::set<int32_t>{} : vertices_of(border);
    const std::map<int32_t, double> inside = areas_inside(p, mesh, rest, on_border, is_left_out);
    double of_border =
        inside.empty() ? 1.0 : 0.0;  // part that its vertices have, and its edges in their place
    for (const auto& [v, area] : inside) {
      of_vertices.push_back({v, {p.largest, area}});
      if (on_border.contains(v)) of_border += area / p.area;
    }
    for (const auto& [edge, l] : border) {
      const double area =
          of_border * p.area * (is_triangle || !(length > 0.0) ? 1.0 / border.size() : l / length);
      for (const int32_t v : edge)
        if (inside.empty()) of_vertices.push_back({v, {p.largest, 0.5 * area}});
      if (const int32_t e = edges.find(edge[0], edge[1]); e >= 0) of_edges.push_back({e, {p.largest, area}});
    }
    // A mesh of triangles has half as many vertices as triangles, one of quadrilaterals has as many.
    const int32_t group = mesh.triangle_group[p.largest];
    total[group] += p.area;
    cell_area_[group] += p.area * p.area * (is_triangle ? 2.0 : 1.0);
  });
  for (int32_t g = 0; g < groups; ++g)
    if (total[g] > 0.0) cell_area_[g] /= total[g];
  vertices_.collect(mesh.vertex_count, of_vertices);
  edges_.collect(mesh.edges.size(), of_edges);
}

/// Lists those of each of `count` primitives in the order in which they are given.
void AreaWeights::Shares::collect(size_t count, std::span<const std::pair<int32_t, Share>> shares) {
  offsets.assign(count + 1, 0);
  for (const auto& [i, share] : shares) ++offsets[i + 1];
  for (size_t i = 0; i < count; ++i) offsets[i + 1] += offsets[i];
  entries.resize(shares.size());
  std::vector<int32_t> next(offsets.begin(), offsets.end() - 1);
  for (const auto& [i, share] : shares) entries[next[i]++] = share;
}

void AreaWeights::share_rods(const SurfaceMesh& mesh, std::span<const Vec3> rest,
                             std::span<const double> radius) {
  cell_area_.resize(radius.size(), 0.0);
  std::vector<double> length(radius.size(), 0.0);
  std::vector<bool> has_triangles(radius.size(), false);
  for (const int32_t g : mesh.triangle_group) has_triangles[g] = true;
  for (size_t e = 0; e < mesh.edges.size(); ++e) {
    const int32_t g = mesh.edge_group[e];
    if (has_triangles[g]) continue;
    const double l = norm(rest[mesh.edges[e][1]] - rest[mesh.edges[e][0]]), diameter = 2.0 * radius[g];
    for (const int32_t v : mesh.edges[e]) vertices_.whole[v] += 0.5 * l * diameter;
    edges_.whole[e] = std::min(l, diameter) * diameter;  // rods that cross touch over their thickness
    length[g] += l;
    cell_area_[g] += l * l * diameter;
  }
  for (size_t g = 0; g < length.size(); ++g)
    if (length[g] > 0.0) cell_area_[g] /= length[g];
  for (const int32_t v : mesh.points) {
    const int32_t g = mesh.vertex_group[v];
    if (vertices_.whole[v] > 0.0 || !vertices_.of(v).empty()) continue;
    vertices_.whole[v] = 4.0 * radius[g] * radius[g];
    if (cell_area_[g] == 0.0) cell_area_[g] = vertices_.whole[v];
  }
}

namespace {

Vec3 rest_normal(const SurfaceMesh& mesh, std::span<const Vec3> rest, int32_t triangle) {
  const Vec3 a = area_vector(mesh.triangles[triangle], rest);
  return norm(a) > 0.0 ? normalized(a) : Vec3{};
}

}  // namespace

bool AreaWeights::is_border(const SurfaceMesh& mesh, int32_t v) const {
  // A triangle gives to a vertex through two edges, and around an inner vertex each neighbour is in two of
  // them.
  std::map<int32_t, int> count;
  for (const Share& share : vertices_.of(v))
    for (const int32_t w : mesh.triangles[share.triangle]) ++count[w];
  return std::ranges::any_of(count, [](const auto& entry) { return entry.second == 2; });
}

double AreaWeights::vertex_sharpness(const SurfaceMesh& mesh, std::span<const Vec3> rest, int32_t v) const {
  if (vertices_.of(v).empty()) return 1.0;
  if (!is_directed(mesh.vertex_group[v])) return is_border(mesh, v) ? kSheetBorder : 0.0;
  Vec3 sum;
  double total = 0.0;
  for (const Share& share : vertices_.of(v)) {
    sum += rest_normal(mesh, rest, share.triangle) * share.area;
    total += share.area;
  }
  return total > 0.0 ? std::clamp((1.0 - norm(sum) / total) / (1.0 - kSharpVertex), 0.0, 1.0) : 0.0;
}

double AreaWeights::edge_sharpness(const SurfaceMesh& mesh, std::span<const Vec3> rest, int32_t e) const {
  const std::span<const Share> shares = edges_.of(e);
  if (shares.empty()) return 1.0;
  // Sheets bend: creases of their rest shape are none.
  if (!is_directed(mesh.edge_group[e])) return shares.size() == 2 ? 0.0 : kSheetBorder;
  if (shares.size() != 2) return 1.0;
  const Vec3 a = rest_normal(mesh, rest, shares[0].triangle), b = rest_normal(mesh, rest, shares[1].triangle);
  return std::min(1.0, std::atan2(norm(cross(a, b)), dot(a, b)) / (0.5 * std::numbers::pi));
}

// What faces the mean normal of both sides, or the larger side where that is more. It does not depend on the
// normal of the contact: a rope that runs over edges meets each at normals that turn with every step, and
// areas a step behind them would give it energy. [theory section 5]
double AreaWeights::area_across(const SurfaceMesh& mesh, std::span<const Vec3> rest, int32_t e) const {
  if (is_rod(e) || !is_directed(mesh.edge_group[e])) return edges_.whole[e];
  Vec3 sum;
  double largest = 0.0;
  for (const Share& share : edges_.of(e)) {
    sum += rest_normal(mesh, rest, share.triangle) * share.area;
    largest = std::max(largest, share.area);
  }
  return std::max(norm(sum), largest);
}

void AreaWeights::weigh(const SurfaceMesh& mesh, std::span<const Vec3> rest) {
  vertices_.whole.resize(mesh.vertex_count, 0.0);
  for (int32_t v = 0; v < mesh.vertex_count; ++v) {
    for (const Share& share : vertices_.of(v)) vertices_.whole[v] += share.area;
    vertices_.weight.push_back(std::pow(kFlatWeight, 1.0 - 0.5 * vertex_sharpness(mesh, rest, v)));
  }
  for (int32_t e = 0; e < static_cast<int32_t>(mesh.edges.size()); ++e) {
    for (const Share& share : edges_.of(e)) edges_.whole[e] += share.area;
    flatness_.push_back(1.0 - edge_sharpness(mesh, rest, e));
    edges_.across.push_back(area_across(mesh, rest, e));
  }
  const size_t groups = cell_area_.size();
  for (size_t a = 0; a < groups; ++a)
    for (size_t b = 0; b < groups; ++b)
      part_.push_back(a == b ? 0.5 : 1.0 / (1.0 + std::pow(cell_area_[a] / cell_area_[b], 4)));
}

double AreaWeights::area(const SurfaceMesh& mesh, const Shares& shares, int32_t i, int32_t group,
                         const Vec3& n, std::span<const Vec3> x) const {
  const std::span<const Share> of_primitive = shares.of(i);
  if (of_primitive.empty() || !is_directed(group)) return shares.whole[i];
  double front = 0.0, back = 0.0;
  for (const Share& share : of_primitive) {
    const Vec3 a = area_vector(mesh.triangles[share.triangle], x);
    const double cosine = norm(a) > 0.0 ? dot(a, n) / norm(a) : 1.0;
    (cosine > 0.0 ? front : back) += share.area * std::fabs(cosine);
  }
  return std::max({front, back, kSmallestFacing * shares.whole[i]});
}

EdgeRanges AreaWeights::edge_ranges(const SurfaceMesh& mesh) const {
  std::vector<EdgeRanges::Edge> edges;
  for (int32_t e = 0; e < static_cast<int32_t>(mesh.edges.size()); ++e)
    edges.push_back({.flatness = flatness_[e],
                     .is_sheet = !is_directed(mesh.edge_group[e]),
                     .is_rod = edges_.of(e).empty()});
  return EdgeRanges(edges);
}

bool AreaWeights::is_directed(const Contact& contact) const {
  const auto [kind, first, second] = contact.key;
  if (kind != PairKind::EdgeEdge) return is_directed(contact.group_a);
  return !is_rod(first) && !is_rod(second) && (is_directed(contact.group_a) || is_directed(contact.group_b));
}

double AreaWeights::area(const SurfaceMesh& mesh, const Contact& contact, const Vec3& n,
                         std::span<const Vec3> x) const {
  const auto [kind, first, second] = contact.key;
  if (kind == PairKind::EdgeEdge) {
    const int32_t a = mesh.edge_group[first], b = mesh.edge_group[second];
    // A rod lies across an edge over its thickness, or over what the edge stands for.
    if (is_rod(first) != is_rod(second)) return std::max(edges_.across[first], edges_.across[second]);
    if (is_rod(first)) return std::min(edges_.whole[first], edges_.whole[second]);
    return part(a, b) * area(mesh, edges_, first, a, n, x) + part(b, a) * area(mesh, edges_, second, b, n, x);
  }
  if (kind == PairKind::PointPoint) return std::min(vertices_.whole[first], vertices_.whole[second]);
  const int32_t group = mesh.vertex_group[first];
  // No vertex is without a barrier, however fine the other mesh: a corner may press between its vertices.
  return area(mesh, vertices_, first, group, n, x) *
         std::max(part(group, contact.group_b), vertices_.weight[first]);
}

}  // namespace stark
