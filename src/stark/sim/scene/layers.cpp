// See layers.h.
#include <stark/sim/scene/layers.h>

#include <cmath>

#include <stark/geometry/polyline.h>
#include <stark/sim/scene/material_fields.h>

namespace stark {

namespace {

/// Sine of the angle between a fibre and the way to a neighbour that has no bearing.
constexpr double kSmallestAngle = 1e-9;

/// Rotation and shape at time 0 of the body of a layer.
struct Placement {
  Mat3 rotation;
  std::span<const Vec3> initial_positions;  ///< in the frame of the body; empty: the rest shape
};

Placement placement_of(const Scene& scene, BodyId body) {
  return scene.visit(body, [](const auto& b) -> Placement {
    if constexpr (requires { b.initial_positions; }) return {b.rotation, b.initial_positions};
    return {b.rotation, {}};
  });
}

/// Vertices that share an element.
class Adjacency {
 public:
  Adjacency(const Scene& scene, BodyId body) {
    BodyElements elements = elements_of(scene, body);
    width_ = elements.width;
    elements_ = std::move(elements.vertices);
    at_.resize(scene.rest_vertices(body).size());
    for (size_t k = 0; k < elements_.size(); ++k) at_[elements_[k]].push_back(k / width_);
  }

  /// The one in the direction closest to a right angle with the unit vector `tangent`.
  int32_t farthest_off(int32_t v, const Vec3& tangent, std::span<const Vec3> X) const {
    int32_t best = -1;
    double largest = -1.0;
    for (const size_t element : at_[v])
      for (size_t k = 0; k < width_; ++k) {
        const int32_t w = elements_[width_ * element + k];
        if (w == v) continue;
        const double sine = norm(cross(normalized(X[w] - X[v]), tangent));
        if (sine > largest) best = w, largest = sine;
      }
    return best;
  }

 private:
  size_t width_ = 0;
  std::vector<int32_t> elements_;
  std::vector<std::vector<size_t>> at_;  ///< elements by vertex
};

/// Frame with d3 along `tangent` that sees `way` at the angle about d3 at which `rest` is, given in the axes
/// of the rest frame.
Mat3 with_bearing(const Vec3& tangent, const Vec3& way, const Vec3& rest) {
  const Vec3 across = way - tangent * dot(way, tangent);
  if (!(norm(across) > kSmallestAngle * norm(way)))  // flattened at time 0: any frame is as good
    return polyline_frames(std::vector<Vec3>{{}, tangent})[0];
  const Vec3 e = normalized(across);
  // Not std::hypot, whose last bit differs from one processor to another.
  const double size = std::sqrt(rest.x * rest.x + rest.y * rest.y);
  const Vec3 d1 = e * (rest.x / size) - cross(tangent, e) * (rest.y / size);
  return Mat3::from_columns(d1, cross(tangent, d1), tangent);
}

/// Of values at the points of a path, those at its nodes.
template <typename T>
std::vector<T> nodes_of(const std::vector<int32_t>& path, const std::vector<T>& at_points) {
  if (!is_ring(path)) return at_points;
  return {at_points.begin() + 1, at_points.end() - 1};
}

}  // namespace

ClothDescription sheet_of(const Scene& scene, const SkinDescription& skin) {
  ClothDescription sheet;
  sheet.name = skin.name;
  sheet.mesh = {scene.rest_vertices(skin.body), skin.triangles};
  sheet.material = skin.material;
  sheet.law = skin.law;
  sheet.fields = skin.fields;
  sheet.rest_angles = skin.rest_angles;
  return sheet;
}

std::vector<Vec3> path_points(const std::vector<int32_t>& path, std::span<const Vec3> vertices) {
  std::vector<Vec3> points;
  if (is_ring(path)) points.push_back(vertices[path[path.size() - 2]]);
  for (const int32_t v : path) points.push_back(vertices[v]);
  return points;
}

std::vector<PathFrames> path_frames(const Scene& scene, const FibresDescription& fibres) {
  const Placement place = placement_of(scene, fibres.body);
  const std::vector<Vec3>& X = scene.rest_vertices(fibres.body);
  const std::span<const Vec3> start =
      place.initial_positions.empty() ? std::span<const Vec3>(X) : place.initial_positions;
  const Adjacency adjacency(scene, fibres.body);
  std::vector<PathFrames> result;
  for (const auto& path : fibres.paths) {
    PathFrames& frames = result.emplace_back();
    frames.rest = nodes_of(path, polyline_frames(path_points(path, X), fibres.normal));
    const std::vector<Vec3> tangents = nodes_of(path, polyline_tangents(path_points(path, start)));
    for (size_t n = 0; n < node_count(path); ++n) {
      const Mat3& rest = frames.rest[n];
      const int32_t v = path[n], w = adjacency.farthest_off(v, rest.column(2), X);
      frames.neighbours.push_back(w);
      const Mat3 initial = place.initial_positions.empty() ? rest
                                                           : with_bearing(tangents[n], start[w] - start[v],
                                                                          transpose(rest) * (X[w] - X[v]));
      frames.initial.push_back(place.rotation * initial);
    }
  }
  return result;
}

std::vector<Mat3> initial_frames(const Scene& scene, const FibresDescription& fibres) {
  std::vector<Mat3> frames;
  if (!fibres.bending) return frames;
  for (const PathFrames& of_path : path_frames(scene, fibres))
    frames.insert(frames.end(), of_path.initial.begin(), of_path.initial.end());
  return frames;
}

std::vector<double> fibre_lengths(const Scene& scene, const FibresDescription& fibres) {
  const std::vector<Vec3>& X = scene.rest_vertices(fibres.body);
  std::vector<double> lengths;
  for (const auto& path : fibres.paths)
    for (size_t k = 0; k + 1 < path.size(); ++k) lengths.push_back(norm(X[path[k + 1]] - X[path[k]]));
  return lengths;
}

std::vector<double> fibre_masses(const Scene& scene, const FibresDescription& fibres) {
  std::vector<double> masses = fibre_lengths(scene, fibres);
  const double area = section_of(fibres.material).mass / fibres.material.density;
  for (size_t e = 0; e < masses.size(); ++e) masses[e] *= area * element_density(fibres, e);
  return masses;
}

}  // namespace stark
