#include <stark/geometry/face_levers.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include <stark/geometry/flat_faces.h>

namespace stark {

namespace {

/// Part of the surface of a body from which a face is large.
constexpr double kLargeFace = 0.05;

/// Points along each edge of a triangle over which distances are averaged.
constexpr int kFineParts = 8;

struct Face {
  std::vector<int32_t> triangles;
  std::map<int32_t, double> border;  ///< length of the edges of the border at each of its vertices [m]
  Vec3 centre;
  double area = 0.0, length = 0.0;
  bool is_convex = true, has_vertices_inside = false;
};

double area_of(std::span<const Vec3> x, const Index3& t) {
  return 0.5 * norm(cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]));
}

void set_border(std::span<const Vec3> x, std::span<const Index3> triangles, Face& face) {
  std::map<Index2, int> count;
  for (const int32_t t : face.triangles)
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
      ++count[{low, high}];
    }
  for (const auto& [edge, n] : count) {
    if (n != 1) continue;
    const double length = norm(x[edge[1]] - x[edge[0]]);
    for (const int32_t v : edge) face.border[v] += length;
    face.length += length;
  }
}

std::map<int32_t, Face> collect_faces(std::span<const Vec3> x, std::span<const Index3> triangles) {
  const FlatFaces flat = find_flat_faces(x, triangles);
  std::vector<bool> is_inside(x.size(), false);
  for (const int32_t v : flat.inner_vertices) is_inside[v] = true;
  std::map<int32_t, Face> faces;
  for (size_t t = 0; t < triangles.size(); ++t) {
    Face& face = faces[flat.patch[t]];
    const auto& [a, b, c] = triangles[t];
    const double area = area_of(x, triangles[t]);
    face.triangles.push_back(static_cast<int32_t>(t));
    face.centre += (x[a] + x[b] + x[c]) * (area / 3.0);
    face.area += area;
    face.is_convex = face.is_convex && flat.face[t] == flat.patch[t];
    for (const int32_t v : triangles[t]) face.has_vertices_inside = face.has_vertices_inside || is_inside[v];
  }
  for (auto& [patch, face] : faces) face.centre = face.area > 0.0 ? face.centre / face.area : Vec3{};
  return faces;
}

/// Mean distance of the points of a face from its centre [m].
double mean_distance(std::span<const Vec3> x, std::span<const Index3> triangles, const Face& face) {
  double mean = 0.0;
  for (const int32_t t : face.triangles) {
    const auto& [i, j, k] = triangles[t];
    const Vec3 u = (x[j] - x[i]) / kFineParts, v = (x[k] - x[i]) / kFineParts;
    double sum = 0.0;
    for (int a = 0; a < kFineParts; ++a)
      for (int b = 0; b < kFineParts - a; ++b) {
        const Vec3 corner = x[i] + u * a + v * b - face.centre;
        sum += norm(corner + (u + v) / 3.0);
        if (a + b < kFineParts - 1) sum += norm(corner + (u + v) * (2.0 / 3.0));
      }
    mean += area_of(x, triangles[t]) / face.area * sum / (kFineParts * kFineParts);
  }
  return mean;
}

/// The same of the vertices of its border, which share the pressure by the length of their edges.
double mean_distance_of_border(std::span<const Vec3> x, const Face& face) {
  double mean = 0.0;
  for (const auto& [v, length] : face.border) mean += 0.5 * length / face.length * norm(x[v] - face.centre);
  return mean;
}

}  // namespace

std::vector<FaceLever> find_face_levers(std::span<const Vec3> vertices, std::span<const Index3> triangles) {
  std::map<int32_t, Face> faces = collect_faces(vertices, triangles);
  double surface = 0.0;
  for (const auto& [patch, face] : faces) surface += face.area;
  std::vector<FaceLever> levers;
  for (auto& [patch, face] : faces) {
    if (!face.is_convex || face.has_vertices_inside || !(face.area >= kLargeFace * surface)) continue;
    set_border(vertices, triangles, face);
    const double of_border = mean_distance_of_border(vertices, face);
    if (!(of_border > 0.0)) continue;
    const double part = std::min(1.0, mean_distance(vertices, triangles, face) / of_border);
    for (const auto& [v, length] : face.border)
      levers.push_back({v, face.triangles.front(), face.centre + (vertices[v] - face.centre) * part});
  }
  std::ranges::sort(levers, {}, [](const FaceLever& l) { return std::pair(l.vertex, l.triangle); });
  return levers;
}

}  // namespace stark
