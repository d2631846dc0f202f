#include <stark/geometry/face_levers.h>

#include <algorithm>
#include <map>
#include <utility>

#include <stark/geometry/topology.h>

namespace stark {

namespace {

/// Part of the surface of a body from which a face is large.
constexpr double kLargeFace = 0.05;

/// Points along each edge of a triangle over which distances are averaged.
constexpr int kFineParts = 8;

/// Vertices inside a face up to which they are too few to sample the pressure on it: of a square of 3 by 3
/// cells, whose torque they make 6 % too large.
constexpr int kFewInside = 4;

struct Face {
  Vec3 centre;
  double area = 0.0;
  bool is_convex = true;
  int vertices_inside = 0;
};

struct Border {
  std::map<int32_t, double> at_vertex;  ///< length of the edges of the border at each of its vertices [m]
  double length = 0.0;
};

double area_of(std::span<const Vec3> x, const Index3& t) {
  return 0.5 * norm(cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]));
}

Border find_border(std::span<const Vec3> x, std::span<const Index3> face) {
  Border border;
  for (const Index2& edge : find_boundary_edges(face)) {
    const double length = norm(x[edge[1]] - x[edge[0]]);
    for (const int32_t v : edge) border.at_vertex[v] += length;
    border.length += length;
  }
  return border;
}

/// The patch around each of them.
std::vector<int32_t> patches_of_inner_vertices(std::span<const Index3> triangles, const FlatFaces& flat) {
  std::vector<int32_t> patches(flat.inner_vertices.size());
  for (size_t t = 0; t < triangles.size(); ++t)
    for (const int32_t v : triangles[t])
      if (const auto inner = std::ranges::lower_bound(flat.inner_vertices, v);
          inner != flat.inner_vertices.end() && *inner == v)
        patches[inner - flat.inner_vertices.begin()] = flat.patch[t];
  return patches;
}

/// Those of each patch at its lowest triangle; others have no area.
std::vector<Face> collect_faces(std::span<const Vec3> x, std::span<const Index3> triangles,
                                const FlatFaces& flat) {
  std::vector<Face> faces(triangles.size());
  for (size_t t = 0; t < triangles.size(); ++t) {
    Face& face = faces[flat.patch[t]];
    const auto& [a, b, c] = triangles[t];
    const double area = area_of(x, triangles[t]);
    face.centre += (x[a] + x[b] + x[c]) * (area / 3.0);
    face.area += area;
    face.is_convex = face.is_convex && flat.face[t] == flat.patch[t];
  }
  for (const int32_t patch : patches_of_inner_vertices(triangles, flat)) ++faces[patch].vertices_inside;
  for (Face& face : faces) face.centre = face.area > 0.0 ? face.centre / face.area : Vec3{};
  return faces;
}

std::vector<Index3> triangles_of(size_t patch, const FlatFaces& flat, std::span<const Index3> triangles) {
  std::vector<Index3> face;
  for (size_t t = patch; t < triangles.size(); ++t)
    if (flat.patch[t] == static_cast<int32_t>(patch)) face.push_back(triangles[t]);
  return face;
}

/// Mean distance of the points of a face from its centre [m].
double mean_distance(std::span<const Vec3> x, std::span<const Index3> triangles, const Face& face) {
  double mean = 0.0;
  for (const Index3& t : triangles) {
    const auto& [i, j, k] = t;
    const Vec3 u = (x[j] - x[i]) / kFineParts, v = (x[k] - x[i]) / kFineParts;
    double sum = 0.0;
    for (int a = 0; a < kFineParts; ++a)
      for (int b = 0; b < kFineParts - a; ++b) {
        const Vec3 corner = x[i] + u * a + v * b - face.centre;
        sum += norm(corner + (u + v) / 3.0);
        if (a + b < kFineParts - 1) sum += norm(corner + (u + v) * (2.0 / 3.0));
      }
    mean += area_of(x, t) / face.area * sum / (kFineParts * kFineParts);
  }
  return mean;
}

/// The same of the vertices of its border, which share the pressure by the length of their edges.
double mean_distance_of_border(std::span<const Vec3> x, const Border& border, const Vec3& centre) {
  double mean = 0.0;
  for (const auto& [v, length] : border.at_vertex) mean += 0.5 * length / border.length * norm(x[v] - centre);
  return mean;
}

double area_of_all(std::span<const Face> faces) {
  double area = 0.0;
  for (const Face& face : faces) area += face.area;
  return area;
}

bool has_levers(const Face& face, double surface) {
  return face.is_convex && face.vertices_inside <= kFewInside && face.area >= kLargeFace * surface &&
         face.area > 0.0;
}

}  // namespace

std::vector<int32_t> find_lone_vertices(std::span<const Vec3> vertices, std::span<const Index3> triangles,
                                        const FlatFaces& flat) {
  std::vector<int32_t> lone;
  if (flat.inner_vertices.empty()) return lone;
  const std::vector<Face> faces = collect_faces(vertices, triangles, flat);
  const double surface = area_of_all(faces);
  const std::vector<int32_t> patches = patches_of_inner_vertices(triangles, flat);
  for (size_t i = 0; i < patches.size(); ++i)
    if (has_levers(faces[patches[i]], surface)) lone.push_back(flat.inner_vertices[i]);
  return lone;
}

std::vector<FaceLever> find_face_levers(std::span<const Vec3> vertices, std::span<const Index3> triangles) {
  const FlatFaces flat = find_flat_faces(vertices, triangles);
  const std::vector<Face> faces = collect_faces(vertices, triangles, flat);
  const double surface = area_of_all(faces);
  std::vector<FaceLever> levers;
  for (size_t patch = 0; patch < faces.size(); ++patch) {
    const Face& face = faces[patch];
    if (!has_levers(face, surface)) continue;
    const std::vector<Index3> of_face = triangles_of(patch, flat, triangles);
    const Border border = find_border(vertices, of_face);
    const double of_border = mean_distance_of_border(vertices, border, face.centre);
    if (!(of_border > 0.0)) continue;
    const double part = std::min(1.0, mean_distance(vertices, of_face, face) / of_border);
    for (const auto& [v, length] : border.at_vertex)
      levers.push_back({v, static_cast<int32_t>(patch), face.centre + (vertices[v] - face.centre) * part});
  }
  std::ranges::sort(levers, {}, [](const FaceLever& l) { return std::pair(l.vertex, l.triangle); });
  return levers;
}

}  // namespace stark
