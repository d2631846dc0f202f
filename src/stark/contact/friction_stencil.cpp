#include <stark/contact/friction_stencil.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <stark/base/smooth_step.h>
#include <stark/geometry/edge_lookup.h>

namespace stark {

namespace {

/// Twice the area of a triangle over its squared size below which it has no normal to speak of.
constexpr double kFlattest = 1e-8;

/// Squared sines of the angle between two rods from where their common normal carries their gap, and all of
/// it: 10 and 20 degrees.
constexpr double kParallel = 0.03, kCrossing = 0.12;

struct Frame {
  std::array<Vec3, 3> gradient;  ///< of the barycentric coordinates [1/m]
  Vec3 centre, normal;
  double shape = 0.0;  ///< twice the area over the squared size
};

Frame frame_of(const Index3& triangle, std::span<const Vec3> x) {
  const std::array<Vec3, 3> v{x[triangle[0]], x[triangle[1]], x[triangle[2]]};
  const Vec3 area = cross(v[1] - v[0], v[2] - v[0]);
  const double twice = norm(area);
  const double size =
      std::max({squared_norm(v[1] - v[0]), squared_norm(v[2] - v[1]), squared_norm(v[0] - v[2])});
  Frame frame{.gradient = {}, .centre = (v[0] + v[1] + v[2]) / 3.0, .normal = {}};
  if (!(twice > kFlattest * size)) return frame;
  frame.shape = twice / size;
  frame.normal = area / twice;
  for (int k = 0; k < 3; ++k)
    frame.gradient[k] = cross(frame.normal, v[(k + 2) % 3] - v[(k + 1) % 3]) / twice;
  return frame;
}

void add(FrictionStencil& stencil, int32_t site, double weight, const Vec3& slope) {
  int k = 0;
  while (k < stencil.point_count && stencil.sites[k] != site) ++k;
  if (k == stencil.point_count) ++stencil.point_count;
  stencil.sites[k] = site;
  stencil.weights[k] += weight;
  stencil.slopes[k] += slope;
}

/// The triangle of a frame carries a point of side A (1) or B (-1) that is a height above it.
void add_carrier(const Index3& triangle, const Frame& frame, const Vec3& point, double side,
                 FrictionStencil& stencil) {
  const Vec3 from_centre = point - frame.centre;
  const double height = dot(frame.normal, from_centre);
  double rest = side;
  stencil.own_count = stencil.point_count;
  for (int k = 2; k >= 0; --k) {
    const double share = side * (1.0 / 3.0 + dot(frame.gradient[k], from_centre));
    const double weight = k > 0 ? share : rest;  // sums of shares are one in every bit
    add(stencil, triangle[k], -weight, frame.gradient[k] * (side * height));
    rest -= weight;
  }
}

/// Both triangles carry the place. It may have been found when the sides of the contact were named the other
/// way round, as those of two edges may be from one refresh to the next.
FrictionStencil shared_stencil(const SurfaceMesh& mesh, const SharedPlace& shared, const Contact& contact,
                               std::span<const Vec3> x) {
  const Frame frame = frame_of(shared.carrier, x);
  if (frame.shape == 0.0) return closest_points(contact);
  FrictionStencil stencil{.facing = frame.normal, .arm = {.shared = shared}};
  const bool is_of_a = mesh.vertex_group[shared.face[0]] == contact.group_a;
  const double side = is_of_a ? 1.0 : -1.0;
  Vec3 point;
  double rest = 1.0;
  for (int k = 2; k >= 0; --k) {
    const int32_t site = shared.face[k];
    const double weight = k > 0 ? shared.shares[k] : rest;
    add(stencil, site, side * weight, {});
    point += x[site] * weight;
    rest -= weight;
  }
  stencil.shift = point;
  for (int p = 0; p < contact.point_count; ++p)
    if ((p < contact.side_a_count) == is_of_a)
      stencil.shift -= x[contact.sites[p]] * std::fabs(contact.weights[p]);
  add_carrier(shared.carrier, frame, point, side, stencil);
  return stencil;
}

/// The closest points of two rods that cross, whose gap turns with the common normal n of their chords. What
/// turns chords e moves their ends along n, so dn = -s_A (n . de_A) - s_B (n . de_B) with the basis s dual to
/// them [theory eq. 19e].
FrictionStencil crossing_rods(const Contact& contact, const Index2& a, const Index2& b,
                              std::span<const Vec3> x) {
  FrictionStencil stencil = closest_points(contact);
  const Vec3 e_a = x[a[1]] - x[a[0]], e_b = x[b[1]] - x[b[0]], area = cross(e_a, e_b);
  const double squared = squared_norm(area), sine = squared / (squared_norm(e_a) * squared_norm(e_b));
  if (!(sine > kParallel)) return stencil;
  stencil.facing = area / std::sqrt(squared);
  const double crossing = smooth_step((sine - kParallel) / (kCrossing - kParallel));
  const double height = dot(gap_vector(contact, x), stencil.facing) * crossing;
  const Vec3 s_a = cross(e_b, area) * (height / squared), s_b = cross(area, e_a) * (height / squared);
  add(stencil, a[0], 0.0, -s_a);
  add(stencil, a[1], 0.0, s_a);
  add(stencil, b[0], 0.0, -s_b);
  add(stencil, b[1], 0.0, s_b);
  return stencil;
}

}  // namespace

Vec3 FrictionStencil::motion(std::span<const Vec3> x, std::span<const Vec3> reference) const {
  Vec3 u;
  for (int p = 0; p < point_count; ++p) {
    const Vec3 d = x[sites[p]] - reference[sites[p]];
    u += d * weights[p] + slopes[p] * dot(facing, d);
  }
  return u;
}

Vec3 FrictionStencil::point(std::span<const Vec3> x) const {
  Vec3 point;
  double side = 0.0;
  for (int p = 0; p < own_count; ++p) {
    point += x[sites[p]] * weights[p];
    side += weights[p];
  }
  return point * (side < 0.0 ? -1.0 : 1.0);
}

FrictionStencil FrictionStencil::swapped() const {
  FrictionStencil other = *this;
  for (int p = 0; p < point_count; ++p) {
    other.weights[p] = -weights[p];
    other.slopes[p] = -slopes[p];
  }
  return other;
}

FrictionStencil closest_points(const Contact& contact) {
  FrictionStencil stencil;
  for (int p = 0; p < contact.point_count; ++p) add(stencil, contact.sites[p], contact.weights[p], {});
  return stencil;
}

FrictionCarriers::FrictionCarriers(const SurfaceMesh& mesh, std::vector<bool> rigid_sites,
                                   FrictionLevers levers)
    : rigid_sites_(std::move(rigid_sites)),
      triangles_of_edge_(mesh.edges.size(), {-1, -1}),
      triangle_of_vertex_(mesh.vertex_count, -1),
      chord_of_vertex_(mesh.vertex_count, {-1, -1}),
      levers_(std::move(levers)) {
  const EdgeLookup edges(mesh.edges);
  for (int32_t t = 0; t < static_cast<int32_t>(mesh.triangles.size()); ++t)
    for (int k = 0; k < 3; ++k) {
      const int32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      if (triangle_of_vertex_[a] < 0) triangle_of_vertex_[a] = t;
      const int32_t edge = edges.find(a, b);
      if (edge < 0) continue;
      Index2& both = triangles_of_edge_[edge];
      (both[0] < 0 ? both[0] : both[1]) = t;
    }
  for (size_t edge = 0; edge < mesh.edges.size(); ++edge) {
    if (triangles_of_edge_[edge][0] >= 0) continue;
    const auto [a, b] = mesh.edges[edge];
    chord_of_vertex_[a] = chord_of_vertex_[a][0] < 0 ? Index2{a, b} : Index2{chord_of_vertex_[a][0], b};
    chord_of_vertex_[b] = chord_of_vertex_[b][0] < 0 ? Index2{a, b} : Index2{a, chord_of_vertex_[b][1]};
  }
}

int32_t FrictionCarriers::triangle_at_edge(const SurfaceMesh& mesh, int32_t edge, const Vec3& gap,
                                           std::span<const Vec3> x) const {
  const auto [a, b] = triangles_of_edge_[edge];
  if (b < 0) return a;
  const auto suits = [&](int32_t triangle) {
    const Frame frame = frame_of(mesh.triangles[triangle], x);
    return frame.shape * std::fabs(dot(frame.normal, gap));
  };
  return suits(b) > suits(a) ? b : a;
}

// The name of a contact may be a triangle that the point has left, or none at all: what the stencil has says
// where it is. At edges and vertices the named triangle serves if it has them; any one of a rigid body does.
std::optional<Index3> FrictionCarriers::triangle_at_point(const SurfaceMesh& mesh,
                                                          const Contact& contact) const {
  const auto touched = std::span(contact.sites).subspan(1, static_cast<size_t>(contact.point_count - 1));
  if (touched.size() == 3) return Index3{touched[0], touched[1], touched[2]};
  if (contact.key.kind == PairKind::PointTriangle) {
    const Index3& named = mesh.triangles[contact.key.second];
    const auto has = [&](int32_t site) { return std::ranges::count(named, site) > 0; };
    if (std::ranges::all_of(touched, has)) return named;
  }
  const int32_t any = triangle_of_vertex_[touched[0]];
  return is_rigid(touched[0]) && any >= 0 ? std::optional(mesh.triangles[any]) : std::nullopt;
}

FrictionCarriers::Carrier FrictionCarriers::carrier_of(const SurfaceMesh& mesh, const Contact& contact,
                                                       std::span<const Vec3> x) const {
  const PairKey& key = contact.key;
  const Vec3 gap = gap_vector(contact, x);
  const auto of = [&](int32_t t) { return t < 0 ? std::nullopt : std::optional(mesh.triangles[t]); };
  if (key.kind == PairKind::PointTriangle || key.kind == PairKey::kOther)
    return {triangle_at_point(mesh, contact), {contact.sites[0], -1}};
  // Edges and points: a triangle beside them, which is of a rigid body. Those that deform would be bent by
  // it, and soft bodies pressed together took half as many Newton iterations again.
  const auto at_edge = [&](int32_t edge) {
    return is_rigid(mesh.edges[edge][0]) ? triangle_at_edge(mesh, edge, gap, x) : -1;
  };
  const auto at_vertex = [&](int32_t v) { return is_rigid(v) ? triangle_of_vertex_[v] : -1; };
  if (key.kind == PairKind::EdgeEdge) {
    if (const int32_t t = at_edge(key.second); t >= 0) return {of(t), mesh.edges[key.first]};
    return {of(at_edge(key.first)), mesh.edges[key.second]};
  }
  if (key.kind == PairKind::PointEdge) {
    if (const int32_t t = at_edge(key.second); t >= 0) return {of(t), {key.first, -1}};
    return {of(at_vertex(key.first)), mesh.edges[key.second]};
  }
  if (const int32_t t = at_vertex(key.second); t >= 0) return {of(t), {key.first, -1}};
  return {of(at_vertex(key.first)), {key.second, -1}};
}

LeverArm FrictionCarriers::arm_of(const SurfaceMesh& mesh, const Contact& contact, const Index3& triangle,
                                  const Vec3& normal, std::span<const Vec3> x) const {
  if (levers_.empty() || contact.key.kind != PairKind::PointTriangle || !is_rigid(triangle[0])) return {};
  return levers_.arm(mesh, contact, contact.key.second, normal, x);
}

Index2 FrictionCarriers::chord_of(std::span<const int32_t> touched) const {
  const Index2& chord = chord_of_vertex_[touched[0]];
  return chord[0] < 0 || touched.size() == 1 ? chord : Index2{touched[0], touched[1]};
}

FrictionStencil FrictionCarriers::stencil(const SurfaceMesh& mesh, const Contact& contact,
                                          std::span<const Vec3> x, const std::optional<LeverArm>& arm,
                                          PressedAreas& areas) const {
  std::optional<SharedPlace> shared = arm ? arm->shared : std::nullopt;
  if (!arm && !levers_.empty()) shared = levers_.shared_place(mesh, contact, x, areas);
  if (shared) return shared_stencil(mesh, *shared, contact, x);
  const Carrier carrier = carrier_of(mesh, contact, x);
  if (!carrier.triangle) {
    const std::span sites(contact.sites.data(), static_cast<size_t>(contact.point_count));
    const auto count_a = static_cast<size_t>(contact.side_a_count);
    const Index2 a = chord_of(sites.first(count_a)), b = chord_of(sites.subspan(count_a));
    const bool are_rods = a[0] >= 0 && b[0] >= 0;
    return are_rods ? crossing_rods(contact, a, b, x) : closest_points(contact);
  }
  const Index3& triangle = *carrier.triangle;
  const Frame frame = frame_of(triangle, x);
  if (frame.shape == 0.0) return closest_points(contact);
  FrictionStencil stencil{.facing = frame.normal};
  Vec3 point;         // of friction, on the other side
  double side = 0.0;  // 1 where that is A, -1 where it is B
  stencil.arm = arm ? *arm : arm_of(mesh, contact, triangle, frame.normal, x);
  for (int p = 0; p < contact.point_count; ++p) {
    const int32_t site = contact.sites[p];
    if (site != carrier.other[0] && site != carrier.other[1]) continue;
    const double weight = contact.weights[p], moved = weight * stencil.arm.part;
    if (stencil.arm.part < 1.0) add(stencil, site, weight - moved, {});
    point += x[site] * weight;
    side += weight;
    if (stencil.arm.part == 0.0) continue;
    add(stencil, stencil.arm.site, moved, {});
    stencil.shift = (x[stencil.arm.site] - x[site]) * stencil.arm.part;
    point += stencil.shift * weight;
  }
  side = side > 0.0 ? 1.0 : -1.0;
  add_carrier(triangle, frame, point * side, side, stencil);
  return stencil;
}

}  // namespace stark
