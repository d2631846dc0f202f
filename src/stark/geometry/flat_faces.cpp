#include <stark/geometry/flat_faces.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <stark/geometry/topology.h>

namespace stark {

namespace {

constexpr double kFlat = 1e-10;     ///< distance from the plane over the diagonal of the mesh
constexpr double kSameSide = 0.9;   ///< cosine between normals of a face: folded triangles are another one
constexpr double kStraight = 1e-9;  ///< sine of a corner that counts as straight
constexpr double kFullTurnError = 1e-3;  ///< [rad] of the exterior angles of a convex polygon

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
    neighbours_.resize(triangles_.size());
    for (size_t e = 0; e < edges_.edges.size(); ++e) {
      if (edges_.offsets[e + 1] - edges_.offsets[e] != 2) continue;
      const int32_t a = edges_.triangles[edges_.offsets[e]], b = edges_.triangles[edges_.offsets[e] + 1];
      neighbours_[a].push_back(b);
      neighbours_[b].push_back(a);
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
      for (const int32_t n : neighbours_[t]) {
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
    std::map<int32_t, std::map<int32_t, int32_t>> borders;  // by face: where the border goes from each vertex
    std::map<int32_t, bool> is_simple;
    for (size_t t = 0; t < triangles_.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const int32_t a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
        const Index2 edge{std::min(a, b), std::max(a, b)};
        const size_t e = std::ranges::lower_bound(edges_.edges, edge) - edges_.edges.begin();
        if (is_inner(e)) continue;
        const bool is_new = borders[face_[t]].emplace(a, b).second;
        is_simple.try_emplace(face_[t], true).first->second &= is_new;
      }
    std::vector<int32_t> faces(triangles_.size());
    std::iota(faces.begin(), faces.end(), 0);
    std::map<int32_t, bool> convex;
    for (const auto& [face, border] : borders)
      convex[face] = is_simple[face] && is_convex(border, normals_[face]);
    for (size_t t = 0; t < triangles_.size(); ++t)
      if (convex[face_[t]]) faces[t] = face_[t];
    return faces;
  }

  /// One loop that turns left only, once round.
  bool is_convex(const std::map<int32_t, int32_t>& next, const Vec3& normal) const {
    double turn = 0.0;
    size_t corners = 0;
    const int32_t start = next.begin()->first;
    int32_t a = start;
    do {
      const auto b = next.find(a);
      if (b == next.end() || ++corners > next.size()) return false;
      const auto c = next.find(b->second);
      if (c == next.end()) return false;
      const Vec3 in = x_[b->second] - x_[a], out = x_[c->second] - x_[b->second];
      const double sine = dot(cross(in, out), normal) / norm(normal);
      if (sine < -kStraight * norm(in) * norm(out)) return false;
      turn += std::atan2(sine, dot(in, out));
      a = b->second;
    } while (a != start);
    return corners == next.size() && std::fabs(turn - 2.0 * std::numbers::pi) < kFullTurnError;
  }

  std::span<const Vec3> x_;
  std::span<const Index3> triangles_;
  EdgeTriangles edges_;
  double tolerance_;
  std::vector<int32_t> face_;  ///< seed of the face of each triangle
  std::vector<Vec3> normals_;
  std::vector<std::vector<int32_t>> neighbours_;
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
