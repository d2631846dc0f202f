#include <stark/geometry/flat_faces.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

#include <stark/base/bucket_sort.h>
#include <stark/geometry/topology.h>

namespace stark {

namespace {

constexpr double kFlat = 1e-10;     ///< distance from the plane over the diagonal of the mesh
constexpr double kSameSide = 0.9;   ///< cosine between normals of a face: folded triangles are another one
constexpr double kStraight = 1e-9;  ///< sine of a corner that counts as straight
constexpr double kFullTurnError = 1e-3;  ///< [rad] of the exterior angles of a convex polygon

/// Side of the border of a face, as its triangle runs through it.
struct Side {
  int32_t face, from, to;
};

/// Triangles across the edges of one.
struct Neighbours {
  std::array<int32_t, 3> triangle;
  int count = 0;
  void add(int32_t t) { triangle[count++] = t; }
  std::span<const int32_t> all() const { return std::span(triangle).first(count); }
};

int32_t next_in(const Index3& t, int32_t v) { return v == t[0] ? t[1] : v == t[1] ? t[2] : t[0]; }

class FaceFinder {
 public:
  FaceFinder(std::span<const Vec3> vertices, std::span<const Index3> triangles)
      : x_(vertices),
        triangles_(triangles),
        edges_(find_edge_triangles(triangles)),
        tolerance_(kFlat * norm(box_size(vertices))),
        face_(triangles.size(), -1) {
    for (const Index3& t : triangles) normals_.push_back(cross(x_[t[1]] - x_[t[0]], x_[t[2]] - x_[t[0]]));
    find_neighbours();
    for (size_t t = 0; t < triangles.size(); ++t)
      if (face_[t] < 0) grow(static_cast<int32_t>(t));
  }

  FlatFaces result() const {
    FlatFaces faces;
    std::vector<uint8_t> on_border(x_.size(), 0), used(x_.size(), 0);
    for (size_t e = 0; e < edges_.edges.size(); ++e) {
      const Index2& edge = edges_.edges[e];
      used[edge[0]] = used[edge[1]] = 1;
      if (is_inner(e)) continue;
      faces.edges.push_back(edge);
      on_border[edge[0]] = on_border[edge[1]] = 1;
    }
    for (size_t v = 0; v < x_.size(); ++v)
      if (used[v] && !on_border[v]) faces.inner_vertices.push_back(static_cast<int32_t>(v));
    faces.face = convex_faces();
    faces.patch = face_;
    return faces;
  }

 private:
  void find_neighbours() {
    neighbours_.assign(triangles_.size(), {});
    for (size_t e = 0; e < edges_.edges.size(); ++e) {
      if (edges_.offsets[e + 1] - edges_.offsets[e] != 2) continue;
      const int32_t a = edges_.triangles[edges_.offsets[e]], b = edges_.triangles[edges_.offsets[e] + 1];
      neighbours_[a].add(b);
      neighbours_[b].add(a);
    }
  }

  /// The face of a triangle: all that can be reached from it in its plane.
  void grow(int32_t seed) {
    face_[seed] = seed;
    const double length = norm(normals_[seed]);
    if (!(length > 0.0)) return;
    const Vec3 normal = normals_[seed] / length, origin = x_[triangles_[seed][0]];
    std::vector<int32_t> open{seed};
    while (!open.empty()) {
      const int32_t t = open.back();
      open.pop_back();
      for (const int32_t n : neighbours_[t].all()) {
        if (face_[n] >= 0 || !(dot(normals_[n], normal) > kSameSide * norm(normals_[n]))) continue;
        if (!std::ranges::all_of(triangles_[n], [&](int32_t v) {
              return std::fabs(dot(x_[v] - origin, normal)) <= tolerance_;
            }))
          continue;
        face_[n] = seed;
        open.push_back(n);
      }
    }
  }

  bool is_inner(size_t e) const {
    return edges_.offsets[e + 1] - edges_.offsets[e] == 2 &&
           face_[edges_.triangles[edges_.offsets[e]]] == face_[edges_.triangles[edges_.offsets[e] + 1]];
  }

  std::vector<int32_t> convex_faces() const {
    std::vector<bool> convex(triangles_.size(), false);  // by face, those of one triangle aside
    const std::vector<Side> sides = sides_of_borders();
    for (size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
      const int32_t face = sides[begin].face;
      while (end < sides.size() && sides[end].face == face) ++end;
      convex[face] = is_convex(std::span(sides).subspan(begin, end - begin), normals_[face]);
    }
    std::vector<int32_t> faces(triangles_.size());
    for (size_t t = 0; t < faces.size(); ++t)
      faces[t] = convex[face_[t]] ? face_[t] : static_cast<int32_t>(t);
    return faces;
  }

  /// Where the borders of faces of several triangles go on from each of their vertices: by face and vertex.
  std::vector<Side> sides_of_borders() const {
    std::vector<int32_t> size(triangles_.size(), 0);
    for (const int32_t face : face_) ++size[face];
    std::vector<Side> sides;
    for (size_t e = 0; e < edges_.edges.size(); ++e) {
      if (is_inner(e)) continue;
      for (int32_t i = edges_.offsets[e]; i < edges_.offsets[e + 1]; ++i) {
        const int32_t t = edges_.triangles[i];
        if (size[face_[t]] == 1) continue;
        const auto [a, b] = edges_.edges[e];
        const bool is_along = next_in(triangles_[t], a) == b;
        sides.push_back({face_[t], is_along ? a : b, is_along ? b : a});
      }
    }
    bucket_sort(
        sides, [](const Side& s) { return s.face; },
        [](const Side& s, const Side& t) { return std::tie(s.from, s.to) < std::tie(t.from, t.to); });
    return sides;
  }

  /// One loop that turns left only, once round.
  bool is_convex(std::span<const Side> border, const Vec3& normal) const {
    const auto side_from = [&](int32_t v) { return std::ranges::lower_bound(border, v, {}, &Side::from); };
    double turn = 0.0;
    size_t corners = 0;
    auto side = border.begin();
    do {
      if (++corners > border.size()) return false;
      const auto next = side_from(side->to);
      if (next == border.end() || next->from != side->to) return false;
      const Vec3 in = x_[side->to] - x_[side->from], out = x_[next->to] - x_[next->from];
      const double sine = dot(cross(in, out), normal) / norm(normal);
      if (sine < -kStraight * norm(in) * norm(out)) return false;
      turn += std::atan2(sine, dot(in, out));
      side = next;
    } while (side != border.begin());
    return corners == border.size() && std::fabs(turn - 2.0 * std::numbers::pi) < kFullTurnError;
  }

  std::span<const Vec3> x_;
  std::span<const Index3> triangles_;
  EdgeTriangles edges_;
  double tolerance_;
  std::vector<int32_t> face_;  ///< seed of the face of each triangle
  std::vector<Vec3> normals_;
  std::vector<Neighbours> neighbours_;
};

}  // namespace

FlatFaces separate_faces(std::span<const Index3> triangles) {
  FlatFaces faces{.edges = find_edges(triangles), .inner_vertices = {}, .face = {}, .patch = {}};
  faces.face.resize(triangles.size());
  std::iota(faces.face.begin(), faces.face.end(), 0);
  faces.patch = faces.face;
  return faces;
}

FlatFaces find_flat_faces(std::span<const Vec3> vertices, std::span<const Index3> triangles) {
  if (vertices.empty() || triangles.empty()) return {};
  return FaceFinder(vertices, triangles).result();
}

}  // namespace stark
